//! What fractures yield to their fluid: the storage that stands in for the strain of a pass to come.
//!
//! The fixed-stress term of intact rock, β = α²/K_dr, knows nothing of an open crack, whose faces give
//! way a thousand times as much. Its compliance is that of the body around it, so it is measured: the
//! pressure in all fractures is raised a little, and what they gain is their storage, which is Q K⁻¹ Qᵀ
//! for a pressure that moves in all of them alike. The longer a crack, the wider it opens, so that the
//! storage per volume grows with the broken volume (a little too fast in space, which costs time, not
//! stability).

use perifrac_solvers::norm2;

use crate::model::Model;
use crate::operators::Divergence;
use crate::schemes::memory::Measured;
use crate::schemes::{State, StepError, coupling_of, flow_of, solid_of};

/// Push that measures it, relative to that of the loads: above what equilibrium leaves out of balance.
const RAISED: f64 = 0.05;
/// Pressure that does so where no load acts, relative to the shear modulus: far from what breaks rock.
const AT_REST: f64 = 1e-9;

/// β V per point, m^D/Pa.
#[derive(Debug, Default)]
pub(crate) struct Compliance {
    /// The storage, shape `(n,)`.
    pub storage: Vec<f64>,
    /// Largest ratio of it to what the pores store themselves.
    pub strength: f64,
    /// What was measured, if there was a fracture yet.
    pub measured: Option<Measured>,
}

impl Compliance {
    /// Brings the storage to the fractures of `state`, with the coefficients that the model has.
    /// `equilibrate` moves a state into equilibrium and gives its iterations; `relaxation` is the factor of
    /// the whole term.
    ///
    /// # Errors
    /// Those of `equilibrate`.
    pub(crate) fn follow<const D: usize>(
        &mut self,
        model: &Model<D>,
        state: &State,
        relaxation: f64,
        equilibrate: impl FnOnce(&mut State) -> Result<usize, StepError>,
    ) -> Result<usize, StepError> {
        let shares = shares(model, state);
        let volume = &model.cloud.volume;
        let broken: f64 = shares.iter().zip(volume).map(|(s, v)| s * v).sum();
        let mut iterations = 0;
        if self.measured.is_none() && broken > 0.0 {
            let (density, effort) = measure(model, state, &shares, broken, equilibrate)?;
            self.measured = Some(Measured { density, broken });
            iterations = effort;
        }
        let measured = self.measured.as_ref();
        let density = measured.map_or(0.0, |then| then.density * broken / then.broken);
        check(model, state.time, &shares, density, relaxation)?;
        let rock = &coupling_of(model)?.fixed_stress;
        let at = |i: usize| relaxation * rock[i].max(shares[i] * volume[i] * density);
        self.storage = (0..shares.len()).map(at).collect();
        let ratios = self.storage.iter().zip(&flow_of(model)?.capacity);
        self.strength = ratios.map(|(own, pores)| own / pores).fold(0.0, f64::max);
        Ok(iterations)
    }
}

/// Refuses a split that lets lagging strain feed on itself: a pass answers to the wrong strain of the last
/// with (c − βc)/(s + βc) of it.
fn check<const D: usize>(
    model: &Model<D>,
    time: f64,
    shares: &[f64],
    density: f64,
    relaxation: f64,
) -> Result<(), StepError> {
    let capacity = &flow_of(model)?.capacity;
    let broken = (0..shares.len()).filter(|i| shares[*i] >= 1.0);
    let stored = broken.map(|i| capacity[i] / model.cloud.volume[i]);
    let strength = density / stored.fold(f64::INFINITY, f64::min);
    match strength * (1.0 - relaxation) > 1.0 + strength * relaxation {
        true => Err(StepError::FractureUnstable {
            time,
            relaxation,
            strength,
        }),
        false => Ok(()),
    }
}

/// Storage per broken volume, 1/Pa, and the iterations that it took.
fn measure<const D: usize>(
    model: &Model<D>,
    state: &State,
    shares: &[f64],
    broken: f64,
    equilibrate: impl FnOnce(&mut State) -> Result<usize, StepError>,
) -> Result<(f64, usize), StepError> {
    let (solid, coupling) = (solid_of(model)?, coupling_of(model)?);
    let mut push = vec![0.0; solid.unknowns()];
    match model.has_crack_content() {
        // The fluid pushes the faces apart by all of its pressure, whatever the rock makes of it.
        true => {
            let weight = model.cloud.volume.clone();
            Divergence { weight }.add_adjoint(&solid.elastic, shares, &mut push);
        }
        false => coupling.add_pressure_force(solid, shares, &mut push),
    }
    let loads = norm2(&model.external_force(state.time, &state.pressure));
    let stiffest = solid.elastic.lame.iter().map(|lame| lame.mu);
    let raise = (RAISED * loads / norm2(&push)).max(AT_REST * stiffest.fold(0.0, f64::max));
    let mut raised = state.clone();
    let pairs = raised.pressure.iter_mut().zip(shares);
    pairs.for_each(|(p, share)| *p += share * raise);
    let iterations = equilibrate(&mut raised)?;
    let step = raised.since(state);
    let mut gained = model.content(&step.displacement, &step.walls);
    if model.has_crack_content() {
        let cracks = |at: &State| model.crack_content(model.response(&at.view()).as_ref());
        let pairs = cracks(&raised).into_iter().zip(cracks(state));
        let own = gained.iter_mut().zip(pairs);
        own.for_each(|(gained, (now, then))| *gained += now - then);
    }
    let gained: f64 = gained.iter().zip(shares).map(|(g, s)| g * s).sum();
    Ok(((gained / (raise * broken)).max(0.0), iterations))
}

/// How much of a fracture each point is at the damage of a state, shape `(n,)`.
fn shares<const D: usize>(model: &Model<D>, state: &State) -> Vec<f64> {
    let damage = model.solid.as_ref().and_then(|solid| solid.damage.as_ref());
    let (Some(damage), Some(fracture)) = (damage, &model.fracture_flow) else {
        return vec![0.0; state.pressure.len()];
    };
    let damage = damage.of(&state.history);
    damage.iter().map(|s| fracture.share(*s)).collect()
}
