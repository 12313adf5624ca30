//! Settings of a method that are not worth another run: on a coarser cloud another setting was cheaper.

use super::{Row, Status, Variant};

/// Share of the seconds that another setting must save to be called cheaper, and seconds besides, which starts of the
/// program differ by.
const SAVED: (f64, f64) = (0.1, 0.02);
/// How many times the error another setting may have and still be called as good.
const AS_GOOD: f64 = 1.1;

/// How a run ended, with what counts here.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outcome {
    status: Status,
    wall_s: f64,
    error: f64,
}

impl From<&Row> for Outcome {
    fn from(row: &Row) -> Self {
        Outcome {
            status: row.status,
            wall_s: row.wall_s,
            error: row.error(),
        }
    }
}

/// Whether every run of its setting on the next coarser cloud was beaten by one of another setting of the same method.
///
/// What the program takes by itself is run on every cloud; runs without an error beat none and are beaten by none.
pub(super) fn is_beaten(index: usize, variants: &[Variant], outcomes: &[Option<Outcome>]) -> bool {
    let own = &variants[index];
    if own.setting.is_none() {
        return false;
    }
    let spacing = |variant: &Variant| variant.value("spacing");
    let coarser: Vec<(&Variant, &Option<Outcome>)> = (variants.iter().zip(outcomes))
        .filter(|(other, _)| other.method() == own.method() && spacing(other) > spacing(own))
        .collect();
    let next = coarser.iter().map(|(other, _)| spacing(other));
    let next = next.fold(f64::INFINITY, f64::min);
    let on_next = || coarser.iter().filter(|(other, _)| spacing(other) <= next);
    let mut same = on_next()
        .filter(|(other, _)| other.setting == own.setting)
        .peekable();
    let others = || on_next().filter(|(other, _)| other.setting != own.setting);
    same.peek().is_some()
        && same.all(|(_, outcome)| match outcome {
            Some(outcome) if outcome.status == Status::Done => {
                let others = others().filter_map(|(_, other)| other.as_ref());
                others.into_iter().any(|other| beats(other, outcome))
            }
            Some(outcome) => outcome.status == Status::Beaten,
            // Its turn is still to come.
            None => false,
        })
}

/// Whether a run took less time for no more error.
fn beats(run: &Outcome, other: &Outcome) -> bool {
    let (share, seconds) = SAVED;
    run.status == Status::Done
        && run.wall_s < (1.0 - share) * other.wall_s - seconds
        && run.error <= AS_GOOD * other.error
}

#[cfg(test)]
mod tests {
    use super::*;

    type Run = (Option<&'static str>, f64, f64, f64);

    /// Rows of runs with setting, spacing, seconds and error; the last one is still to be run.
    fn beaten(runs: &[Run]) -> bool {
        let variants: Vec<Variant> = (runs.iter())
            .map(|(setting, spacing, ..)| Variant {
                setting: *setting,
                ..Variant::default().with("spacing", *spacing)
            })
            .collect();
        let outcomes: Vec<Option<Outcome>> = (runs.iter())
            .map(|&(_, _, wall_s, error)| {
                (!wall_s.is_nan()).then_some(Outcome {
                    status: Status::Done,
                    wall_s,
                    error,
                })
            })
            .collect();
        is_beaten(runs.len() - 1, &variants, &outcomes)
    }

    #[test]
    fn a_setting_is_dropped_where_another_was_cheaper_and_as_good_on_the_cloud_before() {
        let next = (Some("b"), 0.1, f64::NAN, f64::NAN);
        let by = |seconds: f64, error: f64| {
            beaten(&[
                (None, 0.2, seconds, error),
                (Some("b"), 0.2, 2.0, 1e-2),
                next,
            ])
        };
        assert!(by(1.0, 1e-2) && by(1.0, 1.05e-2));
        assert!(!by(1.0, 1.2e-2), "less accurate");
        assert!(!by(1.9, 1e-3), "hardly cheaper");
        assert!(!by(1.0, f64::NAN), "without an error");
    }

    #[test]
    fn the_cloud_before_decides_and_defaults_are_always_run() {
        let coarse = [(None, 0.4, 1.0, 1e-2), (Some("b"), 0.4, 2.0, 1e-2)];
        let fine = [(None, 0.2, 8.0, 1e-3), (Some("b"), 0.2, 4.0, 1e-3)];
        let next = |setting| (setting, 0.1, f64::NAN, f64::NAN);
        let all = |setting| beaten(&[&coarse[..], &fine, &[next(setting)]].concat());
        assert!(!all(Some("b")) && !all(None) && !all(Some("never run")));
        let tight = (Some("b"), 0.2, 40.0, 1e-5);
        assert!(!beaten(&[
            fine[0],
            (Some("b"), 0.2, 9.0, 1e-3),
            tight,
            next(Some("b"))
        ]));
    }
}
