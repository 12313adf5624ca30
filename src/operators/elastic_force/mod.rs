//! K u without a matrix, in two passes over the bonds: the response of every family, then the force on every point.
//!
//! Points gather what families do to them and own their sums, so that bits do not depend on the number of threads.
//! On a lattice families are those of one [stencil](stencil), and nothing is stored per bond; families that deviate
//! (cut by cracks, of layers, with corrected gradients, off a lattice) keep the forces of their bonds.

mod deviating;
mod diagonal;
mod kernels;
mod lattice;
mod padding;
mod stencil;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::Elastic;
use crate::geometry::Vector;
use deviating::Deviating;
pub(crate) use diagonal::diagonal;
use lattice::LatticeForce;

/// The force of an elastic operator whose stiffness stays.
#[derive(Debug)]
pub struct ElasticForce<const D: usize> {
    lattice: Option<LatticeForce<D>>,
    deviating: Deviating,
    work: Mutex<Work<D>>,
    evaluations: AtomicU64,
}

/// Fields of the two passes.
#[derive(Debug, Default)]
struct Work<const D: usize> {
    /// u by sites of the lattice.
    displacement: Vec<f64>,
    /// h u by sites.
    stiff: Vec<f64>,
    /// T by lines of sites and columns.
    stress: Vec<f64>,
    /// What the own family of a point does to it, by sites.
    rest: Vec<f64>,
    /// Forces of bonds that deviate.
    forces: Vec<Vector<D>>,
    /// K u of the points that see these.
    near: Vec<Vector<D>>,
    /// K u.
    result: Vec<f64>,
}

impl<const D: usize> ElasticForce<D> {
    /// Finds out which families are those of a stencil.
    pub fn new(elastic: &Elastic<D>) -> Self {
        let lattice = LatticeForce::new(elastic);
        let deviating = Deviating::new(elastic, lattice.as_ref());
        let mut work = Work::default();
        if let Some(lattice) = &lattice {
            lattice.prepare(&mut work);
        }
        deviating.prepare(&mut work);
        ElasticForce {
            lattice,
            deviating,
            work: Mutex::new(work),
            evaluations: AtomicU64::new(0),
        }
    }

    /// K u of the operator it was made of into `result`, shape `(n·D,)`, N; sums over all processes.
    pub fn evaluate(&self, elastic: &Elastic<D>, displacement: &[f64], result: &mut [f64]) {
        self.compute(elastic, displacement, &mut self.lock(), result);
    }

    fn compute(
        &self,
        elastic: &Elastic<D>,
        displacement: &[f64],
        work: &mut Work<D>,
        result: &mut [f64],
    ) {
        let lattice = self.lattice.as_ref();
        match lattice {
            Some(own) => own.first_pass(elastic, displacement, work),
            // Points without families here get their sums from other processes.
            None => result.fill(0.0),
        }
        self.deviating.first_pass(elastic, displacement, work);
        if let Some(own) = lattice {
            own.second_pass(work, result);
        }
        if !self.deviating.is_empty() {
            let deviating = &self.deviating;
            deviating.second_pass(elastic, lattice, displacement, work, result);
        }
        elastic.around.families.share.complete(result, D);
        self.evaluations.fetch_add(1, Ordering::Relaxed);
    }

    /// Takes K u off `force`, shape `(n·D,)`, N.
    pub fn subtract(&self, elastic: &Elastic<D>, displacement: &[f64], force: &mut [f64]) {
        let mut work = self.lock();
        let mut result = std::mem::take(&mut work.result);
        result.resize(force.len(), 0.0);
        self.compute(elastic, displacement, &mut work, &mut result);
        force.iter_mut().zip(&result).for_each(|(f, own)| *f -= own);
        work.result = result;
    }

    fn lock(&self) -> MutexGuard<'_, Work<D>> {
        // A panic elsewhere leaves numbers that the next evaluation overwrites.
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Evaluations so far.
    pub fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// Families that are those of one stencil.
    pub fn repeated(&self) -> usize {
        let regular = self.lattice.iter().flat_map(|own| &own.regular);
        regular.filter(|regular| **regular).count()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let work = self.lock();
        let fields = [&work.displacement, &work.stiff, &work.stress, &work.rest];
        let values: usize = fields.iter().map(|field| field.len()).sum();
        let vectors = D * (work.forces.len() + work.near.len());
        let lattice = self.lattice.as_ref().map_or(0, LatticeForce::bytes);
        8 * (values + vectors) + lattice + self.deviating.bytes()
    }
}
