//! The steady state: one solve, no time loop.
//!
//! A sealed part of the domain has a steady state only if its sources balance, and then any constant
//! can be added. Such a part is grounded by doubling one diagonal entry: adding up its rows shows that
//! the grounded pressure is zero exactly, so nothing else changes. The constant follows from the
//! volume stored at the start, which a sealed part keeps.

use std::collections::BTreeMap;

use perifrac_solvers::Demand;

use super::{ImplicitSystem, SchemeCounters, State, StepError, StepReport};
use crate::boundary::BoundaryPlane;
use crate::model::FlowModel;

/// Imbalance of a sealed part, relative to its gross rates, that counts as rounding.
const BALANCED: f64 = 1e-9;

/// Solves L p = q.
///
/// # Errors
/// [`StepError::NoSteadyState`] for a sealed part with a net source; [`StepError::Solve`].
pub fn solve_steady<const D: usize>(
    flow: &FlowModel<D>,
    demand: &Demand,
    state: &mut State,
) -> Result<(StepReport, SchemeCounters, (String, String)), StepError> {
    let mut imbalance = vec![0.0; flow.points()];
    flow.rate(state.time, &mut imbalance);
    let parts = sealed_parts(flow);
    check_balance(&parts, &imbalance)?;
    let mut system = ImplicitSystem::new(demand, flow)?;
    let ground: Vec<usize> = parts.iter().map(|part| part[0] as usize).collect();
    system.prepare(flow, &vec![0.0; flow.points()], 1.0, &ground)?;
    let initial = state.pressure.clone();
    flow.imbalance(state.time, &state.pressure, &mut imbalance);
    let mut change = vec![0.0; flow.points()];
    for fixed in &flow.fixed {
        change[fixed.point] =
            flow.fixed_loads[fixed.load].at(state.time) - state.pressure[fixed.point];
    }
    let iterations = system.solve(flow, &imbalance, &mut change)?;
    state
        .pressure
        .iter_mut()
        .zip(&change)
        .for_each(|(p, c)| *p += c);
    for part in &parts {
        keep_volume(flow, part, &initial, &mut state.pressure);
    }
    let mut flows = flow.flows(&state.pressure, state.time);
    flow.imbalance(state.time, &state.pressure, &mut imbalance);
    flow.add_fixed_inflow(&imbalance, &mut flows);
    let report = StepReport {
        iterations,
        flows,
        stored: None,
        ..StepReport::default()
    };
    let counters = SchemeCounters {
        solver: system.counters().clone(),
        ..SchemeCounters::default()
    };
    Ok((report, counters, system.chosen().clone()))
}

/// Connected parts without any prescribed pressure, on a side, at points or in a well, each a list of points.
fn sealed_parts<const D: usize>(flow: &FlowModel<D>) -> Vec<Vec<u32>> {
    let mut anchored = vec![false; flow.points()];
    flow.fixed
        .iter()
        .for_each(|fixed| anchored[fixed.point] = true);
    flow.walls
        .iter()
        .flat_map(BoundaryPlane::points)
        .chain(flow.wells.held_points(&flow.controls))
        .for_each(|point| anchored[point] = true);
    let label = labels(flow);
    let mut parts: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (point, &label) in (0_u32..).zip(&label) {
        parts.entry(label).or_default().push(point);
    }
    let mut parts: Vec<Vec<u32>> = parts.into_values().collect();
    parts.retain(|part| !part.iter().any(|&point| anchored[point as usize]));
    parts
}

/// Lowest point of the connected part of every point, shape `(n,)`.
///
/// Labels fall to those of neighbours until none changes; over several processes each settles its own
/// rows between two exchanges.
fn labels<const D: usize>(flow: &FlowModel<D>) -> Vec<u32> {
    let (pattern, share) = (&flow.pattern, flow.subdomain());
    let mut label: Vec<u32> = (0..flow.points() as u32).collect();
    loop {
        let before = label.clone();
        // The lowest label first: it floods its part at once.
        let mut pending: Vec<u32> = (0..flow.points() as u32).rev().collect();
        while let Some(point) = pending.pop() {
            let columns = &pattern.columns[pattern.row(point as usize)];
            let neighbours = columns.iter().map(|&column| label[column as usize]);
            let own = neighbours.fold(label[point as usize], u32::min);
            label[point as usize] = own;
            for &column in columns {
                let other = &mut label[column as usize];
                if *other > own {
                    *other = own;
                    pending.push(column);
                }
            }
        }
        if share.partition().is_none() {
            return label;
        }
        let mut common: Vec<f64> = label.iter().map(|own| f64::from(*own)).collect();
        share.complete(&mut common, 1);
        let (mut changed, pairs) = ([0.0], label.iter_mut().zip(&common));
        for (own, common) in pairs {
            *own = (*own).min(*common as u32);
        }
        changed[0] += f64::from(u8::from(label != before));
        share.sum(&mut changed);
        if changed[0] < 0.5 {
            return label;
        }
    }
}

fn check_balance(parts: &[Vec<u32>], rate: &[f64]) -> Result<(), StepError> {
    for part in parts {
        let net: f64 = part.iter().map(|&i| rate[i as usize]).sum();
        let gross: f64 = part.iter().map(|&i| rate[i as usize].abs()).sum();
        if net.abs() > BALANCED * gross {
            return Err(StepError::NoSteadyState {
                point: part[0] as usize,
                net,
            });
        }
    }
    Ok(())
}

/// Shifts a sealed part so that it stores the same volume as before.
fn keep_volume<const D: usize>(
    flow: &FlowModel<D>,
    part: &[u32],
    initial: &[f64],
    pressure: &mut [f64],
) {
    let sum = |p: &dyn Fn(usize) -> f64| -> f64 {
        part.iter()
            .map(|&i| flow.capacity[i as usize] * p(i as usize))
            .sum()
    };
    let shift = (sum(&|i| initial[i]) - sum(&|i| pressure[i])) / sum(&|_| 1.0);
    part.iter().for_each(|&i| pressure[i as usize] += shift);
}
