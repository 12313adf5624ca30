//! What a well is held at, and when that changes.

use serde::{Deserialize, Serialize};

use super::Well;
use crate::plan::{Load, WellDrive};

/// What a well is held at.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Control {
    /// The rate or the pressure that the scene gives.
    #[default]
    Given,
    /// The lowest pressure of a producer.
    PressureMin,
    /// The highest pressure of an injector.
    PressureMax,
    /// The largest rate, in.
    RateIn,
    /// The largest rate, out.
    RateOut,
    /// No rate: at its limit it would flow the other way.
    Shut,
}

impl Control {
    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Control::Given => "given",
            Control::PressureMin => "pressure-min",
            Control::PressureMax => "pressure-max",
            Control::RateIn | Control::RateOut => "rate-max",
            Control::Shut => "shut",
        }
    }
}

/// What is prescribed: full-plane rate, m^D/s, or bottom-hole pressure, Pa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Imposed {
    Rate(f64),
    Pressure(f64),
}

/// Pressures that differ by rounding, relative to their size: as of the errors of steps.
const NOISE: f64 = 1e-10;

impl Well {
    /// What a control prescribes at `time`.
    pub(super) fn imposed(&self, control: Control, time: f64) -> Imposed {
        match (&self.drive, control) {
            (_, Control::Shut) => Imposed::Rate(0.0),
            (
                WellDrive::Rate {
                    pressure_min: Some(low),
                    ..
                },
                Control::PressureMin,
            ) => Imposed::Pressure(*low),
            (
                WellDrive::Rate {
                    pressure_max: Some(high),
                    ..
                },
                Control::PressureMax,
            ) => Imposed::Pressure(*high),
            (
                WellDrive::Pressure {
                    rate_max: Some(most),
                    ..
                },
                Control::RateIn | Control::RateOut,
            ) => Imposed::Rate(if control == Control::RateIn {
                *most
            } else {
                -most
            }),
            (WellDrive::Rate { rate, .. }, _) => Imposed::Rate(rate.at(time)),
            (WellDrive::Pressure { pressure, .. }, _) => Imposed::Pressure(pressure.at(time)),
        }
    }

    /// The control that suits the mean pressure `mean` (Pa) of the well's points, which `control` led to at `time`:
    /// itself unless a limit is passed by more than rounding.
    pub(super) fn suited(&self, control: Control, mean: f64, time: f64) -> Control {
        match &self.drive {
            WellDrive::Rate {
                rate,
                pressure_min,
                pressure_max,
            } => self.of_rate(control, mean, rate.at(time), [*pressure_min, *pressure_max]),
            WellDrive::Pressure { pressure, rate_max } => match rate_max {
                Some(most) => self.of_pressure(control, mean, pressure.at(time), *most),
                None => Control::Given,
            },
        }
    }

    /// Rates that differ by rounding where pressures are as large as these.
    fn noise(&self, one: f64, other: f64) -> f64 {
        NOISE * self.index * (one.abs() + other.abs())
    }

    /// A well of the rate `asked`. What its limit lets through in the wanted direction decides: enough, less, or nothing.
    fn of_rate(
        &self,
        control: Control,
        mean: f64,
        asked: f64,
        limits: [Option<f64>; 2],
    ) -> Control {
        let (limit, bound) = match asked < 0.0 {
            true => (limits[0], Control::PressureMin),
            false => (limits[1], Control::PressureMax),
        };
        let Some(limit) = limit.filter(|_| asked.abs() > 0.0) else {
            return Control::Given;
        };
        let through = asked.signum() * self.index * (limit - mean);
        let noise = self.noise(limit, mean);
        let (enough, nothing) = (through - asked.abs(), through);
        match control {
            Control::Given if enough >= -noise => Control::Given,
            Control::Shut if nothing <= noise => Control::Shut,
            _ if enough > noise => Control::Given,
            _ if nothing < -noise => Control::Shut,
            _ => bound,
        }
    }

    /// A well held at `given`, Pa, that moves `most` at most.
    fn of_pressure(&self, control: Control, mean: f64, given: f64, most: f64) -> Control {
        let (rate, noise) = (self.index * (given - mean), self.noise(given, mean));
        let bound = match rate > 0.0 {
            true => Control::RateIn,
            false => Control::RateOut,
        };
        let beyond = rate.abs() - most;
        match control {
            Control::Given if beyond <= noise => Control::Given,
            Control::Given => bound,
            _ if beyond < -noise => Control::Given,
            _ => bound,
        }
    }
}

/// The load of a well that holds.
pub(super) fn load(drive: &WellDrive) -> &Load {
    match drive {
        WellDrive::Rate { rate, .. } => rate,
        WellDrive::Pressure { pressure, .. } => pressure,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn well(drive: WellDrive) -> Well {
        Well {
            name: "w".to_owned(),
            index: 2.0,
            equivalent_radius: 1.0,
            drive,
            share: vec![(0, 1.0)],
            inside: 1.0,
            block: vec![(0, 0.0)],
        }
    }

    fn at_rate(rate: f64, pressure_min: Option<f64>, pressure_max: Option<f64>) -> Well {
        well(WellDrive::Rate {
            rate: Load::constant(rate),
            pressure_min,
            pressure_max,
        })
    }

    /// A producer of 6 with an index of 2 needs 3 below the mean; its limit is 10.
    #[test]
    fn a_producer_is_at_its_limit_where_the_rock_gives_less_and_shut_where_it_gives_nothing() {
        let producer = at_rate(-6.0, Some(10.0), None);
        let anyone = [Control::Given, Control::PressureMin, Control::Shut];
        let table = [
            (20.0, Control::Given),
            (13.1, Control::Given),
            (12.9, Control::PressureMin),
            (10.1, Control::PressureMin),
            (9.9, Control::Shut),
        ];
        for (mean, expected) in table {
            for control in anyone {
                let found = producer.suited(control, mean, 0.0);
                assert_eq!(found, expected, "{control:?} at {mean}");
            }
        }
    }

    #[test]
    fn an_injector_mirrors_a_producer() {
        let injector = at_rate(6.0, None, Some(10.0));
        for (mean, expected) in [
            (6.9, Control::Given),
            (7.1, Control::PressureMax),
            (10.1, Control::Shut),
        ] {
            assert_eq!(
                injector.suited(Control::Given, mean, 0.0),
                expected,
                "{mean}"
            );
        }
    }

    #[test]
    fn at_its_limit_to_rounding_a_well_stays_as_it_is() {
        let producer = at_rate(-6.0, Some(10.0), None);
        for off in [-1e-10, 0.0, 1e-10] {
            for control in [Control::Given, Control::PressureMin] {
                assert_eq!(producer.suited(control, 13.0 + off, 0.0), control);
            }
            for control in [Control::PressureMin, Control::Shut] {
                assert_eq!(producer.suited(control, 10.0 + off, 0.0), control);
            }
        }
    }

    #[test]
    fn a_limit_of_the_other_direction_and_a_well_shut_in_are_never_met() {
        for rate in [0.0, 6.0] {
            let well = at_rate(rate, Some(10.0), None);
            for control in [Control::Given, Control::PressureMin, Control::Shut] {
                assert_eq!(well.suited(control, -50.0, 0.0), Control::Given);
            }
        }
    }

    #[test]
    fn a_well_at_a_pressure_moves_no_more_than_its_largest_rate_either_way() {
        let well = well(WellDrive::Pressure {
            pressure: Load::constant(10.0),
            rate_max: Some(4.0),
        });
        for (mean, expected) in [
            (5.0, Control::RateIn),
            (9.0, Control::Given),
            (11.9, Control::Given),
            (12.1, Control::RateOut),
        ] {
            for control in [Control::Given, Control::RateIn, Control::RateOut] {
                assert_eq!(well.suited(control, mean, 0.0), expected, "{control:?}");
            }
        }
        assert_eq!(well.imposed(Control::RateOut, 0.0), Imposed::Rate(-4.0));
    }
}
