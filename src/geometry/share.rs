//! The part of the bonds that one process holds when several work on a run.
//!
//! Points and fields are known everywhere. A process owns the rows of its points; for them it holds
//! the families of these points and of all points that see them. What it sums over bonds is right at
//! its own points, and [`Subdomain::complete`] brings the parts of all processes together.

use std::sync::Arc;

use perifrac_solvers::Partition;

/// Rows and families of this process. By default it has all of them.
#[derive(Debug, Clone, Default)]
pub struct Subdomain {
    several: Option<Arc<Several>>,
}

/// What there is to know if there are several processes.
#[derive(Debug)]
struct Several {
    partition: Partition,
    own: Vec<bool>,
    held: Vec<bool>,
}

impl Subdomain {
    /// Everything, in a single process.
    pub const WHOLE: Self = Subdomain { several: None };

    /// Subdomain of this process in `partition`, which holds the families marked in `held`.
    pub fn of(partition: Partition, held: Vec<bool>) -> Self {
        let own = partition.mask();
        let several = Several {
            partition,
            own,
            held,
        };
        Subdomain {
            several: Some(Arc::new(several)),
        }
    }

    /// How points are dealt out, if there are several processes.
    pub fn partition(&self) -> Option<&Partition> {
        self.several.as_ref().map(|several| &several.partition)
    }

    /// Whether the row of a point is this process's.
    pub fn owns(&self, point: usize) -> bool {
        self.several
            .as_ref()
            .is_none_or(|several| several.own[point])
    }

    /// Whether the family of a point is known here.
    pub fn holds(&self, point: usize) -> bool {
        self.several
            .as_ref()
            .is_none_or(|several| several.held[point])
    }

    /// Replaces values of points of other processes by theirs; `per_point` values for every point.
    /// All processes must call this together.
    pub fn complete(&self, values: &mut [f64], per_point: usize) {
        if let Some(several) = &self.several {
            several.partition.complete(values, per_point);
        }
    }

    /// Replaces values by their sums over all processes. All processes must call this together.
    pub fn sum(&self, values: &mut [f64]) {
        if let Some(several) = &self.several {
            several.partition.team().sum(values);
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let points = |several: &Arc<Several>| several.own.len() * (size_of::<u32>() + 2);
        self.several.as_ref().map_or(0, points)
    }
}
