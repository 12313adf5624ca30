//! Conduction across a square array of cylinders.

use std::f64::consts::PI;

use nalgebra::{SMatrix, SVector};

/// Multipoles of a cylinder that are solved for.
const MULTIPOLES: usize = 10;
/// Largest radius, over the distance of the axes, at which they tell the conductivity: within 7e-7 of what 40 of them tell
/// at a contrast of 1e12, where 0.49 leaves 1.6e-4.
const LARGEST_RADIUS: f64 = 0.475;

/// Conductivity across a square array of cylinders, relative to that of the rock around them; `radius` over the
/// distance of their axes, and `contrast` of the cylinders to the rock. `None` where cylinders nearly touch, at radii above
/// 0.475.
///
/// By Rayleigh's method (Perrins, McKenzie and McPhedran 1979, Proc. R. Soc. A 369, 207): the potential around a
/// cylinder is Σ (A r^l + B r^−l) cos lθ over odd l, A follows from B by its face, and from the B of all others by sums
/// over the lattice.
#[must_use]
pub fn square_array_of_cylinders(radius: f64, contrast: f64) -> Option<f64> {
    // A = T B/a^2l at the face; B in units of a^l, so that no power overflows.
    let inverse = (1.0 - contrast) / (1.0 + contrast);
    if radius > LARGEST_RADIUS {
        return None;
    }
    let order = |k: usize| 2 * k as u32 + 1;
    let sums: Vec<f64> = (0..=order(MULTIPOLES)).map(lattice_sum).collect();
    let term = |row: usize, column: usize| {
        let (l, m) = (order(row), order(column));
        let reach = radius.powi((l + m) as i32);
        let other = binomial(l + m - 1, l) * sums[((l + m) / 2) as usize] * reach;
        let own = if row == column { 1.0 } else { 0.0 };
        own + inverse * other
    };
    let system = SMatrix::<f64, MULTIPOLES, MULTIPOLES>::from_fn(term);
    let mut field = SVector::<f64, MULTIPOLES>::zeros();
    field[0] = inverse * radius;
    let dipole = system.lu().solve(&field)?[0] * radius;
    Some(1.0 - 2.0 * PI * dipole)
}

/// Σ (j + ik)^(−2n) over the square lattice without its origin; that of n = 1 is summed for a field along x.
fn lattice_sum(n: u32) -> f64 {
    match n {
        0 => 0.0,
        1 => PI,
        // The lattice turned by 90° is itself.
        odd if odd % 2 == 1 => 0.0,
        // Eisenstein's series: 2ζ(2n) + 2(2π)^2n/(2n − 1)! Σ σ(k) e^(−2πk), by Lipschitz's formula row by row.
        even => {
            let power = 2 * even;
            let zeta: f64 = (1..60)
                .rev()
                .map(|k| f64::from(k).powi(-(power as i32)))
                .sum();
            let last = 60_f64.powi(-(power as i32));
            // Of terms from 60 on, by Euler and Maclaurin.
            let tail = last * (60.0 / f64::from(power - 1) + 0.5);
            let factor = (1..power).fold(2.0 * PI, |factor, k| factor * 2.0 * PI / f64::from(k));
            let row = |k: u32| {
                let divisors = (1..=k).filter(|d| k.is_multiple_of(*d));
                let sum: f64 = divisors.map(|d| f64::from(d).powi(power as i32 - 1)).sum();
                sum * (-2.0 * PI * f64::from(k)).exp()
            };
            2.0 * (zeta + tail) + 2.0 * factor * (1..40).map(row).sum::<f64>()
        }
    }
}

fn binomial(n: u32, k: u32) -> f64 {
    (0..k).fold(1.0, |product, i| {
        product * f64::from(n - i) / f64::from(i + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// S4, S8 and S12 of the square lattice (Perrins, McKenzie and McPhedran 1979, Table 1).
    #[test]
    fn sums_over_the_square_lattice_are_those_published() {
        for (n, sum) in [(2, 3.151_212_00), (4, 4.255_773_04), (6, 3.938_849_01)] {
            assert!(
                (lattice_sum(n) - sum).abs() < 1e-8,
                "{n}: {}",
                lattice_sum(n)
            );
        }
    }

    fn radius(share: f64) -> f64 {
        (share / PI).sqrt()
    }

    /// Perfect conductors that fill 0.1 to 0.7 of the plane (the same, Table 2).
    #[test]
    fn perfect_conductors_conduct_as_published() {
        for (share, conductivity) in [
            (0.1, 1.222),
            (0.2, 1.500),
            (0.3, 1.860),
            (0.4, 2.351),
            (0.5, 3.080),
            (0.6, 4.342),
            (0.7, 7.433),
        ] {
            let found = square_array_of_cylinders(radius(share), 1e12).unwrap();
            assert!((found - conductivity).abs() < 5e-4, "{share}: {found}");
        }
    }

    /// In the plane currents and lines of equal potential change places (Keller 1964).
    #[test]
    fn the_inverse_contrast_conducts_inversely() {
        for share in [1e-4, 0.1, 0.3, 0.6] {
            for contrast in [1.0, 2.0, 1e3, 1e12] {
                let [one, other] = [contrast, 1.0 / contrast]
                    .map(|own| square_array_of_cylinders(radius(share), own).unwrap());
                assert!(
                    (one * other - 1.0).abs() < 1e-9,
                    "{share}, {contrast}: {one} {other}"
                );
            }
        }
    }

    /// 1 − 2f/(T + f), T = (1 + κ)/(1 − κ), where cylinders are far apart (Maxwell).
    #[test]
    fn thin_cylinders_do_not_feel_each_other() {
        let (share, contrast) = (1e-3, 5.0);
        let face = (1.0 + contrast) / (1.0 - contrast);
        let maxwell = 1.0 - 2.0 * share / (face + share);
        let found = square_array_of_cylinders(radius(share), contrast).unwrap();
        assert!((found - maxwell).abs() < 1e-12, "{found} {maxwell}");
    }

    #[test]
    fn cylinders_that_nearly_touch_are_not_told() {
        assert!(square_array_of_cylinders(0.475, 2.0).is_some());
        assert!(square_array_of_cylinders(0.476, 2.0).is_none());
    }
}
