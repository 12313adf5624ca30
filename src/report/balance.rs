//! Mass balance: what came in, what went out, what is stored.

use serde::Serialize;

/// Cumulative volumes over a run in m^D; rates in m^D/s for a steady state.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Balance {
    /// Brought in by wells, sources and fluxes, net.
    pub injected: f64,
    /// Gone out through sides of prescribed pressure, net.
    pub outflow: f64,
    /// Brought in at points of prescribed pressure, net.
    pub fixed: f64,
    /// Gain of storage.
    pub stored: f64,
    /// Everything that moved, in absolute amounts: the scale of `mass`.
    pub turnover: f64,
    /// |injected + fixed − outflow − stored| / turnover.
    pub mass: f64,
    /// Forces out of balance over all forces, Σ|f| + Σ|Qᵀp|; with mechanics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub momentum: Option<f64>,
    /// Energy of Eq. 73, ½ uᵀKu + ½ pᵀSp, J (per metre of thickness in 2-D); with mechanics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<f64>,
    /// The energy less the work of the loads that act now, J: never grows while they are constant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub potential: Option<f64>,
}

/// Amounts of one step, or rates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Flows {
    /// From wells, sources and fluxes, net.
    pub injected: f64,
    /// From wells, sources and fluxes, each in absolute amount.
    pub gross: f64,
    /// Out through each side.
    pub outflow: Vec<f64>,
    /// In at points of prescribed pressure.
    pub fixed: f64,
    /// The same per prescribed pressure, in the order of the flow model's loads.
    pub held: Vec<f64>,
}

impl Flows {
    /// Adds what came in at a point of the prescribed pressure `load`.
    pub fn hold(&mut self, load: usize, amount: f64) {
        self.fixed += amount;
        self.held.resize(self.held.len().max(load + 1), 0.0);
        self.held[load] += amount;
    }

    /// Adds `weight` times other flows.
    pub fn add(&mut self, weight: f64, other: &Flows) {
        self.injected += weight * other.injected;
        self.gross += weight * other.gross;
        self.fixed += weight * other.fixed;
        let held = self.held.len().max(other.held.len());
        self.held.resize(held, 0.0);
        let pairs = self.held.iter_mut().zip(&other.held);
        pairs.for_each(|(own, o)| *own += weight * o);
        self.outflow.resize(other.outflow.len(), 0.0);
        self.outflow
            .iter_mut()
            .zip(&other.outflow)
            .for_each(|(own, o)| *own += weight * o);
    }
}

impl Balance {
    /// Adds the flows of one step.
    pub fn add(&mut self, flows: &Flows) {
        self.injected += flows.injected;
        self.outflow += flows.outflow.iter().sum::<f64>();
        self.fixed += flows.fixed;
        let through: f64 = flows.outflow.iter().map(|f| f.abs()).sum();
        self.turnover += flows.gross + through + flows.fixed.abs();
    }

    /// Closes the balance with the gain of storage since the start.
    pub fn close(&mut self, stored: f64) {
        self.stored = stored;
        let gap = (self.injected + self.fixed - self.outflow - stored).abs();
        let scale = self.turnover.max(stored.abs());
        self.mass = if scale > 0.0 { gap / scale } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_balance_is_zero_and_a_leak_shows() {
        let flows = Flows {
            injected: 3.0,
            gross: 3.0,
            outflow: vec![1.0, -0.5],
            fixed: 0.5,
            held: vec![0.5],
        };
        let mut balance = Balance::default();
        balance.add(&flows);
        balance.close(3.0);
        assert!(balance.mass < 1e-15);
        balance.close(2.0);
        assert!((balance.mass - 1.0 / 5.0).abs() < 1e-15);
    }
}
