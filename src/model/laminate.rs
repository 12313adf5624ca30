//! Layers in families whose moduli vary: what lies along their bonds, and how the layers are turned.

use super::interfaces::{Interfaces, Run};
use super::sample::contrast;
use crate::geometry::{Matrix, Vector};
use crate::material::{Backus, eigen};
use crate::operators::{Gradient, Lame, Laminate, Layered, Neighbourhood, cells_along};
use crate::parallel;

/// Contrast of moduli within a family from which it has layers.
pub const LAYERED: f64 = 1.01;

/// Contrast beyond which the stiffness along an interface that is curved is that of the point: with means a circle of
/// ratio 10, 100, 0.1, 0.01 has an error of the stress of 0.056, 0.33, 0.034, 0.10 (norm over norm, 40 points
/// across), so 0.027, 0.050, 0.054, 0.12, but of the displacement 0.26 with means at 0.01 and 0.09 so *(prototype)*.
const CONTRAST: f64 = 10.0;

/// Square of the turn of an interface within a family that makes it curved.
const FLAT: f64 = 1e-10;

/// The layers of a cloud under the weights of its strain, and those weights where layers change them; `None` where
/// moduli vary nowhere.
pub(super) fn build<const D: usize>(
    interfaces: &Interfaces<'_, D>,
    around: &Neighbourhood<D>,
    gradient: Option<&Gradient<D>>,
    lame: &[Lame],
) -> Option<(Laminate<D>, Option<Gradient<D>>)> {
    if !vary(lame.iter().copied()) {
        return None;
    }
    let Some(gradient) = gradient else {
        let mut changed = Gradient::plain(around);
        let layered = families(interfaces, around, &changed.weight, lame);
        let any = change(around, &layered, &mut changed.weight);
        let laminate = Laminate::new(around, &changed.weight, layered);
        return Some((laminate, any.then_some(changed)));
    };
    // Weights whose sums over columns have been corrected are kept.
    let layered = families(interfaces, around, &gradient.weight, lame);
    Some((Laminate::new(around, &gradient.weight, layered), None))
}

/// Gives families whose stiffness along the layers is that of their points the weights for it; whether there are any.
fn change<const D: usize>(
    around: &Neighbourhood<D>,
    layered: &[Layered<D>],
    weight: &mut [Vector<D>],
) -> bool {
    let mut any = false;
    for own in layered {
        let weight = &mut weight[around.families.family(own.owner)];
        if let Some(weights) = own.weights(around, weight) {
            weight.copy_from_slice(&weights);
            any = true;
        }
    }
    any
}

/// All families in which moduli vary.
fn families<const D: usize>(
    interfaces: &Interfaces<'_, D>,
    around: &Neighbourhood<D>,
    weight: &[Vector<D>],
    lame: &[Lame],
) -> Vec<Layered<D>> {
    let materials = &interfaces.plan.materials;
    // Within a field it is the cells of the points that tell where moduli change.
    let fields = interfaces.plan.has_elastic_fields();
    let regions = !fields && materials.iter().any(|own| own.region.is_some());
    let family = |owner: usize| -> Option<Layered<D>> {
        let ends = || {
            let family = around.families.family(owner);
            let ends = family.map(|bond| lame[around.families.neighbour(bond)]);
            ends.chain([lame[owner]])
        };
        if !vary(ends()) {
            return None;
        }
        let mut layered = match regions {
            true => of_regions(interfaces, around, owner, lame),
            false => of_cells(around, weight, owner, lame),
        };
        if contrast(ends().map(|own| own.mu)) <= CONTRAST * LAYERED {
            layered.own = None;
        }
        Some(layered)
    };
    parallel::gather(around.len(), |owner, found| found.extend(family(owner)))
}

fn vary(lame: impl Iterator<Item = Lame> + Clone) -> bool {
    let shear = contrast(lame.clone().map(|own| own.mu));
    shear.max(contrast(lame.map(|own| own.lambda + 2.0 * own.mu))) > LAYERED
}

/// The family of a point between regions: bonds are cut where they leave one for another.
fn of_regions<const D: usize>(
    interfaces: &Interfaces<'_, D>,
    around: &Neighbourhood<D>,
    owner: usize,
    lame: &[Lame],
) -> Layered<D> {
    let moduli = |material: u16| interfaces.moduli(material).unwrap_or(lame[owner]);
    let mut tensor = Matrix::zeros();
    let along = around.families.family(owner).map(|bond| {
        let runs: Vec<Run<D>> = interfaces.runs(owner, bond);
        for pair in runs.windows(2) {
            let jump = (moduli(pair[1].material).mu / moduli(pair[0].material).mu).ln();
            let facing = interfaces.facing(owner, bond, &pair[1]);
            tensor += facing * (around.measure[bond] * jump * jump);
        }
        Backus::sum(
            runs.iter()
                .map(|run| (run.share, Backus::of(moduli(run.material)))),
        )
    });
    let along = along.collect();
    layered(owner, along, &tensor, lame[owner])
}

/// The family of a point where moduli are told per point: bonds run through cells.
fn of_cells<const D: usize>(
    around: &Neighbourhood<D>,
    weight: &[Vector<D>],
    owner: usize,
    lame: &[Lame],
) -> Layered<D> {
    let families = &around.families;
    let family = families.family(owner);
    let mut along = vec![Backus::default(); family.len()];
    cells_along(around, owner, |bond, (point, _), share| {
        let own = &mut along[bond - family.start];
        *own = Backus::sum([(1.0, *own), (share, Backus::of(lame[point]))]);
    });
    let slope = |point: usize| -> Vector<D> {
        let jump = |bond: usize| (lame[families.neighbour(bond)].mu / lame[point].mu).ln();
        (families.family(point))
            .map(|bond| weight[bond] * jump(bond))
            .sum()
    };
    // Squares: the slopes on the two sides of a thin layer point against each other.
    let mut tensor = slope(owner) * slope(owner).transpose() * around.moment[owner];
    for bond in family {
        let image = families.images.get(families.image(bond));
        let slope = image.reflect(&slope(families.neighbour(bond)));
        tensor += slope * slope.transpose() * around.measure[bond];
    }
    layered(owner, along, &tensor, lame[owner])
}

/// The layers across the axis of the largest eigenvalue of `tensor`, Σ n⊗n over interfaces.
fn layered<const D: usize>(
    owner: usize,
    along: Vec<Backus>,
    tensor: &Matrix<D>,
    own: Lame,
) -> Layered<D> {
    let (values, vectors) = eigen(tensor);
    let curved = values.sum() - values.max() > FLAT * values.max();
    Layered {
        owner,
        along,
        normal: vectors.column(values.imax()).into_owned(),
        own: curved.then_some(own),
    }
}
