//! The processes that MPI started, as a [`Communicator`].

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use perifrac_petsc_sys::{Gather, Parked, PetscError, abort, run};

use super::petsc_status;
use crate::{Communicator, SolveError};

/// Layouts of which the exchange is kept.
const KEPT: usize = 64;

/// Processes that exchange through PETSc. Values are exchanged as they are and sums are taken in
/// the order of the processes, so every process has the same bits.
#[derive(Debug)]
struct MpiTeam {
    rank: usize,
    size: usize,
    /// Exchanges by layout.
    gathers: Mutex<HashMap<Vec<usize>, Parked<Gather>>>,
}

/// The processes started by `mpirun`; one without it.
///
/// # Errors
/// [`SolveError::Unavailable`] without PETSc.
pub fn petsc_team() -> Result<Arc<dyn Communicator>, SolveError> {
    let status = petsc_status()?;
    Ok(Arc::new(MpiTeam {
        rank: status.process,
        size: status.processes,
        gathers: Mutex::new(HashMap::new()),
    }))
}

impl MpiTeam {
    fn exchange(&self, starts: &[usize], values: &mut [f64]) -> Result<(), PetscError> {
        let own = values[starts[self.rank]..starts[self.rank + 1]].to_vec();
        let mut gathers = self.gathers.lock().unwrap_or_else(PoisonError::into_inner);
        if gathers.len() >= KEPT && !gathers.contains_key(starts) {
            gathers.clear();
        }
        let gathers = &mut *gathers;
        run(|session| {
            if !gathers.contains_key(starts) {
                let gather = Parked::new(session, Gather::new(session, own.len())?);
                gathers.insert(starts.to_vec(), gather);
            }
            match gathers.get_mut(starts) {
                Some(gather) => gather.get(session).gather(&own, values),
                None => Ok(()),
            }
        })?
    }
}

impl Communicator for MpiTeam {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn sum(&self, values: &mut [f64]) {
        if self.size == 1 {
            return;
        }
        let length = values.len();
        let starts: Vec<usize> = (0..=self.size).map(|rank| rank * length).collect();
        let mut all = vec![0.0; self.size * length];
        all[starts[self.rank]..][..length].copy_from_slice(values);
        self.gather(&starts, &mut all);
        for (index, value) in values.iter_mut().enumerate() {
            *value = (0..self.size).map(|rank| all[rank * length + index]).sum();
        }
    }

    fn gather(&self, starts: &[usize], values: &mut [f64]) {
        if self.size == 1 {
            return;
        }
        if let Err(error) = self.exchange(starts, values) {
            // The others wait for this process, which cannot go on: no error could reach them.
            eprintln!("process {}: {error}", self.rank);
            abort(1);
        }
    }
}
