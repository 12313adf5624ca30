//! Pressures below zero, which a scene must mean.

use super::finish::extremes;
use super::time_loop::Run;

/// Pressure below zero over the largest one so far that is worth a warning: operators undershoot next to
/// steep fronts by less than a thousandth in the bundled cases.
const SUCTION: f64 = 1e-3;
/// The same over the largest pressure or stress that the data name: what is left of a pressure that has drained.
const DRAINED: f64 = 1e-7;

impl<const D: usize> Run<'_, D> {
    /// Warns of the first pressure below zero, with its place and time, unless the scene allows it.
    pub(super) fn watch_suction(&mut self) {
        let allowed = self.plan.flow.as_ref().is_none_or(|flow| flow.suction);
        let (Some(before), false) = (self.pressed, allowed) else {
            return;
        };
        let pressure = &self.state.pressure;
        let [lowest, highest] = extremes(pressure);
        let largest = before.max(lowest.abs()).max(highest.abs());
        self.pressed = Some(largest);
        if lowest >= -(SUCTION * largest).max(DRAINED * self.model.level) {
            return;
        }
        self.pressed = None;
        let point = (0..pressure.len()).min_by(|a, b| pressure[*a].total_cmp(&pressure[*b]));
        let at = self.model.cloud.position[point.unwrap_or(0)];
        let at: Vec<String> = at.iter().map(|x| format!("{x:.6}")).collect();
        let message = format!(
            "the pressure falls below zero: {lowest:.3e} Pa at [{}] m at t = {:.6} s; a fluid would boil or come out \
             of solution there: limit the rate, or set flow.suction = true where suction, or a pressure that counts \
             from another zero, is meant",
            at.join(", "),
            self.state.time
        );
        self.observer.warn(&message);
        self.warnings.push(message);
    }
}
