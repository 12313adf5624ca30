//! What pictures show: the whole plane, or of space three sections through its first crack, else through its middle.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::fields::Snapshot;
use super::grid::Grid;
use crate::geometry::Vector;
use crate::model::{Disc, Model};
use crate::output::OutputError;
use crate::plan::{CrackPlace, GeometryPlan, Plan, PointFields, read_fields};
use crate::run::quantities::drawn;

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// The points of one picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Section {
    /// Axis to which it is normal.
    pub(super) normal: usize,
    /// Coordinate along that axis, m.
    pub(super) at: f64,
    /// Half the distance to what it leaves out, m.
    half: f64,
    /// Its points.
    pub(super) points: Vec<u32>,
    in_space: bool,
}

/// All sections of a run, and where their fields are.
#[derive(Debug, Default)]
pub(super) struct Sections {
    pub(super) all: Vec<Section>,
    /// Whether the files of fields have just their points.
    in_fields: bool,
    /// What is drawn of the last outputs, by their numbers and sections: files are read where it is not here.
    kept: VecDeque<(usize, Vec<Arc<PointFields>>)>,
}

/// Bytes that are kept of the last outputs at most, or those of one: to read a file of a million points takes 1.1
/// processor seconds. That is eight such outputs of flow.
const MOST_KEPT: usize = 1 << 26;

impl Sections {
    /// The plane, or the layers of points nearest to the centre of the first crack, else to the middle, along z, x
    /// and y.
    pub(super) fn of<const D: usize>(plan: &Plan, model: &Model<D>) -> Self {
        let axes: &[usize] = if D == 2 { &[2] } else { &[2, 0, 1] };
        Sections {
            all: axes
                .iter()
                .map(|axis| Section::of(plan, model, *axis))
                .collect(),
            in_fields: D == 2 && plan.output.vtu && model.subdomain().partition().is_none(),
            kept: VecDeque::new(),
        }
    }

    /// Keeps what is drawn of an output.
    pub(super) fn keep(&mut self, number: usize, snapshot: &Snapshot<'_>, dimension: usize) {
        let names = drawn(dimension).map(|quantity| quantity.field());
        let all = self.all.iter();
        let fields = all.map(|section| Arc::new(snapshot.select(&names, &section.points)));
        self.kept.push_back((number, fields.collect()));
        let bytes = |fields: &Arc<PointFields>| -> usize {
            fields.arrays.values().map(|(_, own)| 8 * own.len()).sum()
        };
        let total = |(_, all): &(usize, Vec<_>)| all.iter().map(bytes).sum::<usize>();
        while self.kept.len() > 1 && self.kept.iter().map(total).sum::<usize>() > MOST_KEPT {
            self.kept.pop_front();
        }
    }

    fn kept(&self, section: &Section, number: usize) -> Option<&Arc<PointFields>> {
        let (_, fields) = self.kept.iter().find(|kept| kept.0 == number)?;
        let place = self
            .all
            .iter()
            .position(|own| own.normal == section.normal)?;
        fields.get(place)
    }

    /// Name of the file with the fields of a section at an output.
    pub(super) fn file(&self, section: &Section, number: usize) -> String {
        match self.in_fields {
            true => super::piece_name(number, None),
            false => format!("section{}-{number:04}.vtu", section.suffix()),
        }
    }

    /// Writes the fields of all sections at an output, where no other file has them.
    ///
    /// # Errors
    /// [`OutputError`].
    pub(super) fn write(
        &self,
        (folder, number): (&Path, usize),
        snapshot: &Snapshot<'_>,
    ) -> Result<(), OutputError> {
        if self.in_fields {
            return Ok(());
        }
        for section in &self.all {
            let path = folder.join(self.file(section, number));
            snapshot
                .drawn()
                .write(&path, &Grid::of_points(&section.points))?;
        }
        Ok(())
    }

    /// What was kept of them, else all that stands in their file; `None` if that is gone.
    ///
    /// # Errors
    /// [`OutputError::Malformed`] if it is damaged.
    pub(super) fn read(
        &self,
        folder: &Path,
        section: &Section,
        number: usize,
    ) -> Result<Option<Arc<PointFields>>, OutputError> {
        if let Some(kept) = self.kept(section, number) {
            return Ok(Some(kept.clone()));
        }
        let path = folder.join(self.file(section, number));
        if !path.exists() {
            return Ok(None);
        }
        let fields = read_fields(&path);
        fields
            .map(|fields| Some(Arc::new(fields)))
            .map_err(|error| malformed(path, &error.to_string()))
    }
}

fn malformed(path: PathBuf, reason: &str) -> OutputError {
    OutputError::Malformed {
        path,
        line: 1,
        reason: reason.to_owned(),
    }
}

impl Section {
    fn of<const D: usize>(plan: &Plan, model: &Model<D>, normal: usize) -> Self {
        let cloud = &model.cloud;
        if normal >= D {
            return Section {
                normal,
                at: 0.0,
                half: f64::INFINITY,
                points: (0..cloud.len() as u32).collect(),
                in_space: false,
            };
        }
        let (lower, upper) = (cloud.domain.lower[normal], cloud.domain.upper[normal]);
        let centre = plan.cracks.iter().find_map(|crack| match &crack.place {
            CrackPlace::Disc { centre, .. } => Some(centre[normal].clamp(lower, upper)),
            CrackPlace::Chain(_) => None,
        });
        let middle = centre.unwrap_or(0.5 * (lower + upper));
        let (place, edge) = (
            |i: u32| cloud.position[i as usize][normal],
            |i: u32| cloud.cell[i as usize][normal],
        );
        let within = |i: &u32| (place(*i) - middle).abs() <= 0.5001 * edge(*i);
        let near: Vec<u32> = (0..cloud.len() as u32).filter(within).collect();
        // An even number of layers has two beside the middle; one is enough.
        let lowest = near.iter().map(|i| place(*i)).fold(f64::INFINITY, f64::min);
        let in_layer = |i: &u32| place(*i) < lowest + 0.25 * edge(*i);
        let points: Vec<u32> = near.into_iter().filter(in_layer).collect();
        let half = points.iter().map(|i| 0.5 * edge(*i)).fold(0.0, f64::max);
        Section {
            normal,
            at: lowest,
            half,
            points,
            in_space: true,
        }
    }

    /// The two axes of its picture.
    pub(super) fn across(&self) -> [usize; 2] {
        match self.normal {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        }
    }

    /// Names of these axes.
    pub(super) fn axes(&self) -> [&'static str; 2] {
        self.across().map(|axis| AXES[axis])
    }

    /// What sets the names of its files apart: nothing for the plane, in space the axis it is normal to.
    pub(super) fn suffix(&self) -> String {
        match self.in_space {
            true => format!("-{}", AXES[self.normal]),
            false => String::new(),
        }
    }

    /// The same for pictures, where the section normal to z is the first to be looked at.
    pub(super) fn picture_suffix(&self) -> String {
        match self.normal {
            2 => String::new(),
            _ => self.suffix(),
        }
    }

    /// Where it is, for titles; nothing for the whole plane.
    pub(super) fn name(&self) -> String {
        match self.in_space {
            true => format!(", points at {} = {} m", AXES[self.normal], rounded(self.at)),
            false => String::new(),
        }
    }

    /// Places of its points in the picture, m.
    pub(super) fn positions<const D: usize>(&self, model: &Model<D>) -> Vec<f64> {
        let across = self.across();
        let place = |i: &u32| across.map(|axis| model.cloud.position[*i as usize][axis]);
        self.points.iter().flat_map(place).collect()
    }

    /// Edges of the squares that are drawn, m: as large as the longer edge, so that narrow cells of tensor grids leave
    /// no gaps.
    pub(super) fn sizes<const D: usize>(&self, model: &Model<D>) -> Vec<f64> {
        let across = self.across();
        let size = |i: &u32| {
            let edges = across.map(|axis| model.cloud.cell[*i as usize][axis]);
            edges[0].max(edges[1])
        };
        self.points.iter().map(size).collect()
    }

    /// Corners of the cells of a plane mesh, m; empty where squares stand for cells.
    pub(super) fn outlines<'a>(&self, plan: &'a Plan) -> &'a [Vec<[f64; 2]>] {
        match &plan.geometry {
            GeometryPlan::Points {
                mesh: Some(mesh), ..
            } if !self.in_space => &mesh.outlines,
            _ => &[],
        }
    }

    /// Cracks of the scene in the picture, m: chains, the chord of a disc, or its rim where it lies in the section.
    pub(super) fn cracks(&self, plan: &Plan) -> Vec<Vec<[f64; 2]>> {
        let line = |place: &CrackPlace| match place {
            CrackPlace::Chain(points) => Some(points.clone()),
            CrackPlace::Disc { .. } => self.of_disc(&Disc::of(place)?),
        };
        plan.cracks
            .iter()
            .filter_map(|crack| line(&crack.place))
            .collect()
    }

    fn of_disc(&self, disc: &Disc<3>) -> Option<Vec<[f64; 2]>> {
        let (own, normal) = (self.normal, disc.normal);
        let flat = |x: &Vector<3>| self.across().map(|axis| x[axis]);
        let off = self.at - disc.centre[own];
        let slope = (1.0 - normal[own] * normal[own]).max(0.0).sqrt();
        if slope < 1e-6 {
            let near = off.abs() <= 1.001 * self.half;
            return near.then(|| disc.rim().iter().map(flat).collect());
        }
        // Down the slope of the disc to the section, then half a chord to both sides.
        let step = off / slope;
        let half = (disc.radius * disc.radius - step * step).max(0.0).sqrt();
        let down = (Vector::ith(own, 1.0) - normal * normal[own]) / slope;
        let (middle, arm) = (disc.centre + down * step, normal.cross(&down) * half);
        (half > 0.0).then(|| vec![flat(&(middle - arm)), flat(&(middle + arm))])
    }
}

/// Four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(normal: usize, at: f64) -> Section {
        Section {
            normal,
            at,
            half: 0.1,
            points: Vec::new(),
            in_space: true,
        }
    }

    fn disc(centre: [f64; 3], normal: [f64; 3], radius: f64) -> Disc<3> {
        let place = CrackPlace::Disc {
            centre,
            normal,
            radius,
        };
        Disc::of(&place).unwrap()
    }

    fn close(found: &[[f64; 2]], expected: &[[f64; 2]]) -> bool {
        let near = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12;
        found.len() == expected.len() && found.iter().zip(expected).all(near)
    }

    /// By hand: a disc of radius 5 around (1, 2, 3), normal to z, is cut by x = 4, 3 from its middle, along y from 2 − 4
    /// to 2 + 4 at z = 3.
    #[test]
    fn a_disc_is_cut_in_a_chord() {
        let chord = section(0, 4.0)
            .of_disc(&disc([1.0, 2.0, 3.0], [0.0, 0.0, 1.0], 5.0))
            .unwrap();
        let mut chord = chord;
        chord.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(close(&chord, &[[-2.0, 3.0], [6.0, 3.0]]), "{chord:?}");
        let beyond = section(0, 7.0).of_disc(&disc([1.0, 2.0, 3.0], [0.0, 0.0, 1.0], 5.0));
        assert!(beyond.is_none());
    }

    /// By hand: a disc inclined by 45° about y through the origin meets z = 1 at x = 1 if its normal is (−1, 0, 1)/√2.
    #[test]
    fn an_inclined_disc_is_cut_where_it_meets_the_section() {
        let half = 0.5_f64.sqrt();
        let chord = section(2, 1.0)
            .of_disc(&disc([0.0; 3], [-half, 0.0, half], 2.0))
            .unwrap();
        assert!(
            chord.iter().all(|end| (end[0] - 1.0).abs() < 1e-12),
            "{chord:?}"
        );
        let length = (chord[0][1] - chord[1][1]).abs();
        assert!((length - 2.0 * 2.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_disc_in_the_section_is_drawn_by_its_rim() {
        let normal = [0.0, 0.0, 1.0];
        let rim = section(2, 3.05)
            .of_disc(&disc([1.0, 2.0, 3.0], normal, 5.0))
            .unwrap();
        assert!(
            rim.iter()
                .all(|[x, y]| ((x - 1.0).hypot(y - 2.0) - 5.0).abs() < 1e-12)
        );
        assert!(
            section(2, 3.2)
                .of_disc(&disc([1.0, 2.0, 3.0], normal, 5.0))
                .is_none()
        );
    }
}
