//! How long cracks are, measured from the points that broke.
//!
//! A crack is a band whose width w the rock chooses. Of the disc (ball in 3-D) that the horizon δ of a
//! point in it sees, the band fills 2δw (πδ²w) where it is thin, less where it is wide, so that what is
//! broken near broken points tells the width, and the width with the area of all of them the length.

use std::f64::consts::PI;

use crate::model::{Disc, Faces, Model, SolidModel};
use crate::plan::{CrackPlace, CrackPlan, Plan};

/// Length of the cracks that are there from the start, m; area of discs in the domain, m².
pub(super) fn started<const D: usize>(plan: &Plan, model: &Model<D>) -> f64 {
    let of = |crack: &CrackPlan| match &crack.place {
        CrackPlace::Chain(points) => points
            .windows(2)
            .map(|ends| (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]))
            .sum(),
        CrackPlace::Disc { .. } => {
            Disc::of(&crack.place).map_or(0.0, |disc| disc.area(&model.cloud.domain))
        }
    };
    plan.cracks.iter().map(of).sum()
}

/// 2 where all cracks lie on planes of symmetry, so that half of every band is in the domain, else 1.
pub(super) fn faces_of_bands<const D: usize>(model: &Model<D>) -> f64 {
    let cracks = &model.places.cracks;
    let on_plane = |faces: &Vec<Faces<D>>| faces.iter().any(|faces| faces.mirrored != 0.0);
    match !cracks.is_empty() && cracks.iter().all(on_plane) {
        true => 2.0,
        false => 1.0,
    }
}

/// Length of a crack through the points that `broke`, m (area in 3-D, m²), which goes on in all that is
/// `broken`: to a tenth, and a horizon or two at a tip, where points see half of a band.
pub(super) fn grown<const D: usize>(
    solid: &SolidModel<D>,
    broke: impl Fn(usize) -> bool,
    broken: impl Fn(usize) -> bool,
) -> f64 {
    let around = &solid.elastic.around;
    let (families, volume) = (&around.families, &around.cloud.volume);
    let ends = |i: usize| families.family(i).map(|bond| families.neighbour(bond));
    // All that a point sees, itself included.
    let seen = |i: usize| volume[i] + ends(i).map(|end| volume[end]).sum::<f64>();
    let (mut thin, mut band) = (0.0, 0.0);
    for i in (0..families.len()).filter(|i| broke(*i)) {
        let near: f64 = ends(i)
            .filter(|end| broken(*end))
            .map(|end| volume[end])
            .sum();
        // Points whose centre is within the horizon fill more or less than its ball; points at a side
        // see less than those around them.
        let all = ends(i).map(seen).fold(seen(i), f64::max);
        let horizon = families.horizon[i];
        let (through, ball) = match D {
            2 => (2.0 * horizon, PI * horizon.powi(2)),
            _ => (PI * horizon.powi(2), 4.0 / 3.0 * PI * horizon.powi(3)),
        };
        thin += volume[i] * through * all / (ball * (volume[i] + near));
        band += volume[i] / horizon;
    }
    length(D, thin, band)
}

/// Widest band that is told from the points near points, in units of the horizon.
const WIDEST: f64 = 2.0;

/// Length from `thin`, which it would be if the band were thin, and `band`, its length times its
/// width over the horizon.
fn length(dimension: usize, thin: f64, band: f64) -> f64 {
    let mut length = thin;
    for _ in 0..60 {
        if length <= 0.0 {
            return 0.0;
        }
        length = thin / excess(dimension, (band / length).min(WIDEST));
    }
    length
}

/// What a thin band would fill of the ball of radius 1 over what a band of `width` fills, on average over
/// the points in it.
fn excess(dimension: usize, width: f64) -> f64 {
    let far = width.min(1.0);
    let root = (1.0 - far * far).sqrt();
    // ∫ (1 − t/w) times the section of the ball at a distance t, over both sides.
    match dimension {
        2 => {
            let even = 0.5 * (far * root + far.asin());
            let odd = (1.0 - root.powi(3)) / 3.0;
            2.0 * width / (4.0 * (even - odd / width))
        }
        _ => {
            let even = far - far.powi(3) / 3.0;
            let odd = far * far / 2.0 - far.powi(4) / 4.0;
            PI * width / (2.0 * PI * (even - odd / width))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::plan::resolve;
    use crate::report::Timers;
    use crate::scene::load_str;

    /// Half a metre of two and of four rows behind a decimetre that was there, with horizons that see 12,
    /// 20 and 28 points.
    #[test]
    fn rows_of_broken_points_are_as_long_as_they_are() {
        let text = include_str!("../../cases/natural-fractures/scene.toml");
        for ratio in [2.0, 2.3, 3.0] {
            let small = [
                "geometry.size=[\"0.8 m\", \"2 m\"]".to_owned(),
                "geometry.spacing=\"2 cm\"".to_owned(),
                format!("horizon.ratio={ratio}"),
            ];
            let loaded = load_str("rows", text, Path::new(""), &small).unwrap();
            let model =
                Model::<2>::build(&resolve(&loaded, "rows").unwrap(), &mut Timers::default());
            let model = model.unwrap();
            let solid = model.solid.as_ref().unwrap();
            for rows in [1.0, 2.0] {
                let within = |i: usize, from: f64| {
                    let place = model.cloud.position[i];
                    (from..0.6).contains(&place[0]) && (place[1] - 1.0).abs() < 0.02 * rows
                };
                let found = grown(solid, |i| within(i, 0.1), |i| within(i, 0.0));
                let tip = 1.75 * ratio * 0.02;
                assert!(
                    (0.45..0.55 + tip).contains(&found),
                    "{ratio} {rows}: {found}"
                );
            }
        }
    }

    /// A quarter of a ring around the disc in a plane of symmetry, half of whose band is in the domain.
    #[test]
    fn a_ring_around_a_disc_on_a_plane_of_symmetry_has_its_area() {
        let text = include_str!("../../cases/penny-3d/scene.toml");
        let points = ["geometry.points=[20, 20, 20]".to_owned()];
        let loaded = load_str("penny", text, Path::new(""), &points).unwrap();
        let plan = resolve(&loaded, "penny").unwrap();
        let model = Model::<3>::build(&plan, &mut Timers::default()).unwrap();
        let solid = model.solid.as_ref().unwrap();
        let within = |i: usize, from: f64| {
            let place = model.cloud.position[i];
            (from..0.6).contains(&place[0].hypot(place[1])) && place[2] < 0.1
        };
        let found = grown(solid, |i| within(i, 0.3), |i| within(i, 0.0));
        let area = |rim: f64| PI * (rim * rim - 0.09) / 4.0;
        let (found, tip) = (faces_of_bands(&model) * found, 1.75 * 0.09);
        assert!(
            (0.9 * area(0.6)..area(0.6 + tip)).contains(&found),
            "{found}"
        );
    }

    #[test]
    fn a_thin_band_fills_its_width_and_a_wide_one_less() {
        for dimension in [2, 3] {
            assert!((excess(dimension, 1e-3) - 1.0).abs() < 1e-5);
            assert!(excess(dimension, 1.0) > 1.05);
        }
        // Half of the disc less two thirds of a square: 4 / (π − 2/3).
        assert!((excess(2, 2.0) - 4.0 / (PI - 2.0 / 3.0)).abs() < 1e-12);
    }

    #[test]
    fn the_length_comes_back_from_bands_of_any_width() {
        for dimension in [2, 3] {
            for width in [0.05, 0.5, 1.0, 1.5, 2.0] {
                let thin = 3.0 * excess(dimension, width);
                let found = length(dimension, thin, 3.0 * width);
                assert!((found - 3.0).abs() < 1e-3, "{dimension} {width}: {found}");
            }
        }
        assert!(length(2, 0.0, 0.0) <= 0.0);
    }
}
