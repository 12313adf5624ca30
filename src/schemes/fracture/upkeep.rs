//! When a preconditioner that lags behind its matrix is worth renewing.

/// Iterations that renewing it costs, as measured with multigrid on 20 000 points.
const COST: usize = 16;

/// Iterations wasted since the preconditioner was renewed.
#[derive(Default)]
pub struct Upkeep {
    /// Iterations of the first solve after that; `None` if there was none yet.
    fresh: Option<usize>,
    wasted: usize,
}

impl Upkeep {
    /// Whether to renew it now. Direct solvers take no iterations and have nothing to lag behind.
    pub fn is_due(&self) -> bool {
        self.fresh.is_none_or(|fresh| fresh == 0) || self.wasted >= COST
    }

    /// Renewed just now.
    pub fn renew(&mut self) {
        *self = Upkeep::default();
    }

    /// A solve took `iterations`.
    pub fn took(&mut self, iterations: usize) {
        match self.fresh {
            None => self.fresh = Some(iterations),
            Some(fresh) => self.wasted += iterations.saturating_sub(fresh),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_renewed_once_the_waste_outweighs_it_and_always_for_direct_solvers() {
        let mut upkeep = Upkeep::default();
        assert!(upkeep.is_due());
        upkeep.took(20);
        assert!(!upkeep.is_due());
        upkeep.took(30);
        assert!(!upkeep.is_due());
        upkeep.took(30);
        assert!(upkeep.is_due());
        upkeep.renew();
        upkeep.took(0);
        assert!(upkeep.is_due());
    }
}
