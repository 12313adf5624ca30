//! The diffusion operators, and how far they are to be trusted on a cloud.

use std::sync::Arc;

use crate::assembly::{
    Consistency, Planes, ScalarOperator, consistent_gradient, uniform_flow_error,
};
use crate::geometry::{Cloud, Families, GeometryError, Side};
use crate::operators::{
    BondConductance, Cells, Correspondence, MirrorContinuation, Neighbourhood, Parity, Path,
    Tessellation,
};
use crate::plan::{FlowPlan, Plan, SideCondition};

use super::ModelError;
use super::interfaces::Interfaces;
use super::operator_choice::Form;
use super::properties::Properties;

/// Share of a family's weights beyond which its correction is not trusted.
const TRUSTED: f64 = 0.5;

/// Warnings where the corrected gradient is not what was asked for.
pub(super) fn doubts<const D: usize>(quality: &Consistency, cloud: &Cloud<D>) -> Vec<String> {
    let doubtful = (quality.ratio > TRUSTED).then(|| {
        format!(
            "the divergence-consistent correction is {:.0} % of the gradient's own weights \
             somewhere; enlarge the horizon or smooth the grading",
            100.0 * quality.ratio
        )
    });
    let plain = quality.first_plain.map(|first| {
        format!(
            "the divergence-consistent correction would exceed the gradient's own weights at {} of \
             {} points, the first at {:?}, whose neighbours are all on one side: they keep the plain \
             gradient as at a free surface, and column sums are off by up to {:.1e} of a cell's face",
            quality.plain_families,
            cloud.len(),
            cloud.position[first].as_slice(),
            quality.after
        )
    });
    doubtful.into_iter().chain(plain).collect()
}

/// Error of a uniform flow beyond which an operator is warned of, and refused.
const WARNED: f64 = 1e-3;
const REFUSED: f64 = 1e-1;

/// Holds a plain gradient of `owner`, `flow` or `mechanics`, against uniform fields where the spacing is uneven:
/// its area vectors do not vanish there.
///
/// # Errors
/// [`ModelError::InconsistentGradient`] where a uniform field would be far off.
pub(super) fn judge_plain<const D: usize>(
    owner: &'static str,
    around: &Arc<Neighbourhood<D>>,
    one_sided: &[bool],
    warnings: &mut Vec<String>,
) -> Result<(), ModelError> {
    let cloud = &around.cloud;
    if !cloud.irregular || !cloud.domain.planes {
        return Ok(());
    }
    let form = Correspondence::new(around.clone(), 1.0, None);
    let error = uniform_flow_error(&form, one_sided);
    if error > REFUSED {
        return Err(ModelError::InconsistentGradient { owner, error });
    }
    if error > WARNED {
        warnings.push(format!(
            "the plain gradient is not consistent on this cloud: a uniform field is off by {:.1} % on the \
             whole, and by more at single points; use {owner}.gradient = \"divergence-consistent\"",
            100.0 * error
        ));
    }
    Ok(())
}

/// An operator, and what goes with it.
pub(super) struct Built<const D: usize> {
    /// The operator.
    pub(super) operator: Arc<dyn ScalarOperator<D>>,
    /// Continuation of the pressure across the sides.
    pub(super) extension: MirrorContinuation<D>,
    /// What the divergence-consistent gradient achieved, if there is one.
    pub(super) consistency: Option<Consistency>,
    /// Along which fluid moves in cracks that hold fluid of their own.
    pub(super) crack_bonds: Option<CrackBonds<D>>,
}

/// Bonds along which fluid moves in cracks: those of whole families, whatever the operator of the rock.
#[derive(Debug, Clone)]
pub struct CrackBonds<const D: usize> {
    /// The families with their weights.
    pub around: Arc<Neighbourhood<D>>,
    /// How the pressure goes on across the sides.
    pub extension: Arc<MirrorContinuation<D>>,
}

impl<const D: usize> CrackBonds<D> {
    fn new(
        plan: &Plan,
        flow: &FlowPlan,
        cloud: &Arc<Cloud<D>>,
        families: Families<D>,
    ) -> Result<Self, GeometryError> {
        let extension = continuation(flow, cloud, &families);
        let one_sided = Side::all(D).any(|side| extension.parity(side) == Parity::OneSided);
        let families = match one_sided {
            true => families.retain_images(|image| extension.keeps(image))?,
            false => families,
        };
        let around = Neighbourhood::new(cloud.clone(), Arc::new(families), plan.influence)?;
        Ok(CrackBonds {
            around: Arc::new(around),
            extension: Arc::new(extension),
        })
    }
}

/// Builds the chosen operator.
///
/// # Errors
/// [`ModelError`] where it does not go with the cloud.
pub(super) fn operator<const D: usize>(
    plan: &Plan,
    flow: &FlowPlan,
    form: Form,
    (cloud, points, families): (&Arc<Cloud<D>>, &Properties, Families<D>),
    warnings: &mut Vec<String>,
) -> Result<Built<D>, ModelError> {
    if let Form::Path(cells) = form {
        return path(plan, flow, cells, (cloud, points, families), warnings);
    }
    let bonds = CrackBonds::new(plan, flow, cloud, families)?;
    let (around, extension) = (bonds.around.clone(), &bonds.extension);
    let one_sided: Vec<bool> = Side::all(D)
        .map(|side| extension.parity(side) == Parity::OneSided)
        .collect();
    let mut consistency = None;
    let operator = match form {
        Form::Bond => bond_operator(&around, &one_sided, warnings)?,
        _ => correspondence(flow, &around, &one_sided, &mut consistency, warnings)?,
    };
    Ok(Built {
        operator: operator.into(),
        extension: MirrorContinuation::clone(extension),
        consistency,
        crack_bonds: plan.has_crack_fluid().then_some(bonds),
    })
}

/// How the pressure goes on across the sides.
fn continuation<const D: usize>(
    flow: &FlowPlan,
    cloud: &Cloud<D>,
    families: &Families<D>,
) -> MirrorContinuation<D> {
    let parity: Vec<Parity> = flow.sides.iter().map(parity).collect();
    let planes: Vec<f64> = Side::all(D).map(|side| cloud.domain.plane(side)).collect();
    MirrorContinuation::new(&families.images, &parity, &planes)
}

fn parity(side: &SideCondition) -> Parity {
    match side {
        SideCondition::Sealed => Parity::Even,
        SideCondition::Pressure { .. } => Parity::Odd,
        SideCondition::Flux(_) => Parity::OneSided,
    }
}

/// Builds the path operator between the cells of a cloud.
fn path<const D: usize>(
    plan: &Plan,
    flow: &FlowPlan,
    cells: Cells,
    (cloud, points, families): (&Arc<Cloud<D>>, &Properties, Families<D>),
    warnings: &mut Vec<String>,
) -> Result<Built<D>, ModelError> {
    if !plan.geometry.tells_cells() {
        return Err(ModelError::PathWithoutCells);
    }
    // Values between points, wells and the stabilising storage see as far as the horizon that was asked for.
    let near = |point: usize, bond: usize| {
        families.bond_vector(cloud, point, bond).norm() <= families.horizon[point]
    };
    let lonely = |point: &usize| {
        let mut family = families.family(*point);
        families.share.holds(*point) && !family.any(|bond| near(*point, bond))
    };
    if let Some(point) = (0..cloud.len()).find(lonely) {
        return Err(ModelError::Geometry(GeometryError::SingularShape {
            point,
            position: cloud.position[point].iter().copied().collect(),
            found: 0,
            horizon: families.horizon[point],
        }));
    }
    let crack_bonds = match plan.has_crack_fluid() {
        true => Some(CrackBonds::new(plan, flow, cloud, families.clone())?),
        false => None,
    };
    let found = Tessellation::new(cloud, families, cells)?;
    let extension = continuation(flow, cloud, &found.families);
    let interfaces = Interfaces {
        plan,
        cloud,
        families: &found.families,
        material: &points.material,
    };
    // What strain squeezes out of a cell has the volume of mechanics.
    let own_volume = plan.coupling.is_none();
    let mut operator = Path::new(
        cloud,
        &found,
        own_volume,
        plan.influence,
        |image| extension.keeps(image),
        |owner, bond| interfaces.share(owner, bond),
    )?;
    if !points.tensor.is_empty() {
        operator = operator.with_tensors(&points.tensor);
        // Signs do not depend on the viscosity, by which mobilities are divided.
        warnings.extend(doubt_of_signs(operator.signed(&points.permeability), cloud));
    }
    Ok(Built {
        operator: Arc::new(operator),
        extension,
        consistency: None,
        crack_bonds,
    })
}

/// What tensors lose that are too oblique for the eight bonds of a point.
fn doubt_of_signs<const D: usize>(signed: usize, cloud: &Cloud<D>) -> Option<String> {
    (signed > 0).then(|| {
        format!(
            "at {signed} of {} points the permeability tensor is too oblique for positive conductances \
             (its xy component is above its xx or yy, or nearly, on cells of this shape): pressures may leave the \
             range of those that drive them; turn the lattice towards the principal axes to be rid of it",
            cloud.len()
        )
    })
}

/// Builds the bond operator over the families of `around`.
///
/// # Errors
/// [`ModelError::InconsistentBonds`] where a uniform flow would be far off.
fn bond_operator<const D: usize>(
    around: &Arc<Neighbourhood<D>>,
    one_sided: &[bool],
    warnings: &mut Vec<String>,
) -> Result<Box<dyn ScalarOperator<D>>, ModelError> {
    let form = BondConductance::new(around.clone());
    let (uneven, points) = (form.uncorrected(), around.len());
    let error = uniform_flow_error(&form, one_sided);
    if error > REFUSED {
        return Err(ModelError::InconsistentBonds {
            error,
            uneven,
            points,
        });
    }
    if error > WARNED {
        warnings.push(format!(
            "the bond operator is not consistent on this cloud: a uniform flow is off by {:.1} %, on \
             jittered clouds at every spacing; use a lattice, or flow.operator = \"correspondence\" \
             where the permeability is uniform",
            100.0 * error
        ));
    }
    if uneven > 0 {
        warnings.push(format!(
            "the bond operator is not consistent at {uneven} of {points} points (their families are \
             too uneven for positive weights); compare with flow.operator = \"correspondence\""
        ));
    }
    Ok(Box::new(form))
}

/// Builds the correspondence operator of `flow` over the families of `around`.
///
/// # Errors
/// [`ModelError::Consistency`] if the gradient cannot be corrected.
fn correspondence<const D: usize>(
    flow: &FlowPlan,
    around: &Arc<Neighbourhood<D>>,
    one_sided: &[bool],
    consistency: &mut Option<Consistency>,
    warnings: &mut Vec<String>,
) -> Result<Box<dyn ScalarOperator<D>>, ModelError> {
    let correct = flow.corrects_gradient(around.cloud.irregular, around.cloud.domain.planes);
    let mut corrected = None;
    if correct {
        let (gradient, quality) = consistent_gradient(around, &Planes::natural(one_sided))?;
        warnings.extend(doubts(&quality, &around.cloud));
        *consistency = Some(quality);
        corrected = Some(gradient);
    } else {
        judge_plain("flow", around, one_sided, warnings)?;
    }
    Ok(Box::new(Correspondence::new(
        around.clone(),
        flow.hourglass,
        corrected,
    )))
}
