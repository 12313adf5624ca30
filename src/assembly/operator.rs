//! One trait object per operator: dispatch once per assembly, never per bond.

use super::{Pattern, PatternError, Refill, force, scalar};
use crate::geometry::Vector;
use crate::operators::{BondForm, MirrorContinuation, Neighbourhood, OpenFace};

/// A scalar operator chosen at run time; every [`BondForm`] is one.
pub trait ScalarOperator<const D: usize>: Send + Sync {
    /// Name in scenes and reports.
    fn name(&self) -> &'static str;

    /// The families it lives on.
    fn neighbourhood(&self) -> &Neighbourhood<D>;

    /// Number of points whose families reach a second hop.
    fn second_hops(&self) -> usize;

    /// Bytes held beyond the neighbourhood.
    fn bytes(&self) -> usize;

    /// Sparsity.
    ///
    /// # Errors
    /// [`PatternError`] beyond 2³² nonzeros.
    fn pattern(&self) -> Result<Pattern, PatternError>;

    /// What refills of this pattern share.
    fn refill_plan(&self, extension: &MirrorContinuation<D>, pattern: &Pattern) -> Refill;

    /// Values for the given mobility (shape `(n,)`), into `values` (shape `(nonzeros,)`).
    fn fill(
        &self,
        extension: &MirrorContinuation<D>,
        mobility: &[f64],
        pattern: &Pattern,
        plan: &Refill,
        values: &mut [f64],
    );

    /// The operator applied to bond differences without a matrix, shape `(n,)`.
    fn force(
        &self,
        extension: &MirrorContinuation<D>,
        mobility: &[f64],
        difference: &(dyn Fn(usize, usize) -> f64 + Sync),
    ) -> Vec<f64>;

    /// Flux −κ∇̃p at a point from the bond differences of its family, m/s.
    fn flux(
        &self,
        mobility: &[f64],
        point: usize,
        difference: &dyn Fn(usize, usize) -> f64,
    ) -> Vector<D>;

    /// Forces of the bonds of one family from their differences: what each carries, m^D/s.
    fn family_forces(
        &self,
        mobility: &[f64],
        point: usize,
        difference: &dyn Fn(usize) -> f64,
    ) -> Vec<f64>;

    /// As [`BondForm::flux_is_carried`].
    fn flux_is_carried(&self) -> bool;

    /// As [`BondForm::open_faces`].
    fn open_faces(&self) -> &[OpenFace<D>];

    /// Points with bonds that leave through a side of prescribed value.
    fn outlets(&self, extension: &MirrorContinuation<D>) -> Vec<u32>;

    /// Rate of outflow through every side, shape `(2D,)`; `owners` comes from `outlets`.
    fn outflow(
        &self,
        extension: &MirrorContinuation<D>,
        owners: &[u32],
        mobility: &[f64],
        difference: &dyn Fn(usize, usize) -> f64,
    ) -> Vec<f64>;
}

impl<const D: usize, F: BondForm<D>> ScalarOperator<D> for F {
    fn name(&self) -> &'static str {
        BondForm::name(self)
    }

    fn neighbourhood(&self) -> &Neighbourhood<D> {
        BondForm::neighbourhood(self)
    }

    fn second_hops(&self) -> usize {
        (0..BondForm::neighbourhood(self).len())
            .filter(|&owner| self.couples(owner))
            .count()
    }

    fn bytes(&self) -> usize {
        BondForm::bytes(self)
    }

    fn pattern(&self) -> Result<Pattern, PatternError> {
        Pattern::new(self)
    }

    fn refill_plan(&self, extension: &MirrorContinuation<D>, pattern: &Pattern) -> Refill {
        Refill::new(self, extension, pattern)
    }

    fn fill(
        &self,
        extension: &MirrorContinuation<D>,
        mobility: &[f64],
        pattern: &Pattern,
        plan: &Refill,
        values: &mut [f64],
    ) {
        scalar::fill(self, extension, mobility, pattern, plan, values);
    }

    fn force(
        &self,
        extension: &MirrorContinuation<D>,
        mobility: &[f64],
        difference: &(dyn Fn(usize, usize) -> f64 + Sync),
    ) -> Vec<f64> {
        force::force(self, extension, mobility, difference)
    }

    fn flux(
        &self,
        mobility: &[f64],
        point: usize,
        difference: &dyn Fn(usize, usize) -> f64,
    ) -> Vector<D> {
        BondForm::flux(self, point, mobility, &|bond| difference(point, bond))
    }

    fn family_forces(
        &self,
        mobility: &[f64],
        point: usize,
        difference: &dyn Fn(usize) -> f64,
    ) -> Vec<f64> {
        let family = BondForm::neighbourhood(self).families.family(point);
        let differences: Vec<f64> = family.map(difference).collect();
        let mut forces = Vec::with_capacity(differences.len());
        force::bond_force(self, point, mobility, &differences, &mut forces);
        forces
    }

    fn flux_is_carried(&self) -> bool {
        BondForm::flux_is_carried(self)
    }

    fn open_faces(&self) -> &[OpenFace<D>] {
        BondForm::open_faces(self)
    }

    fn outlets(&self, extension: &MirrorContinuation<D>) -> Vec<u32> {
        force::outlets(self, extension)
    }

    fn outflow(
        &self,
        extension: &MirrorContinuation<D>,
        owners: &[u32],
        mobility: &[f64],
        difference: &dyn Fn(usize, usize) -> f64,
    ) -> Vec<f64> {
        force::outflow(self, extension, owners, mobility, difference)
    }
}
