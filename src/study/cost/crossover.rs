//! Where implicit methods begin to cost less than the explicit one.

use serde_json::{Value, json};

use super::{Groups, Pair, STEADY, pairs};
use crate::study::findings::short;
use crate::study::reach;

/// Errors at which both are compared, between the loosest and the tightest that both reach.
const COMPARED: i32 = 50;

/// Seconds of the explicit method over those of the cheapest implicit one, by error.
type Ratio = (f64, f64);

/// Where the cheapest implicit method begins to cost less than the explicit one, by errors that both reach.
pub(super) fn crossover(groups: &Groups<'_>) -> (Option<String>, Value) {
    let ratios = ratios(groups);
    let (Some(first), Some(last)) = (ratios.first(), ratios.last()) else {
        return (None, json!(null));
    };
    let wins: Vec<bool> = ratios.iter().map(|(_, ratio)| *ratio > 1.0).collect();
    let start = wins.iter().position(|wins| *wins);
    // From there to the tightest error.
    let lasting = start.filter(|start| wins[*start..].iter().all(|wins| *wins));
    let facts = json!({
        "error": lasting.map(|index| ratios[index].0),
        "from": { "error": first.0, "explicit_over_implicit": first.1 },
        "to": { "error": last.0, "explicit_over_implicit": last.1 },
    });
    let (loose, tight) = (at(first), at(last));
    let text = match (start, lasting) {
        _ if ratios.len() == 1 => {
            format!("Explicit and implicit both reach one error only: {loose}.")
        }
        (_, Some(0)) => {
            format!("Implicit wins over the whole range that both reach: {loose}, {tight}.")
        }
        (_, Some(index)) => format!(
            "Implicit starts to win at an error of {}; {tight}.",
            short(ratios[index].0)
        ),
        (Some(_), None) => {
            format!("Neither wins over the whole range that both reach: {loose}, {tight}.")
        }
        (None, None) => format!("Explicit wins over the whole range that both reach; {tight}."),
    };
    (Some(text), facts)
}

/// A ratio in words.
fn at((error, ratio): &Ratio) -> String {
    let error = short(*error);
    match *ratio > 1.0 {
        true => format!("at an error of {error} implicit is {ratio:.1} times as fast"),
        false => format!(
            "at an error of {error} implicit takes {:.1} times as long",
            1.0 / ratio
        ),
    }
}

/// From the loosest to the tightest error that both reach.
fn ratios(groups: &Groups<'_>) -> Vec<Ratio> {
    let explicit: Vec<Pair> = groups.get("explicit").map_or(Vec::new(), |own| pairs(own));
    let implicit: Vec<Vec<Pair>> = groups
        .iter()
        .filter(|(name, _)| !name.starts_with("explicit") && !name.starts_with(STEADY))
        .map(|(_, runs)| pairs(runs))
        .collect();
    let errors = |pairs: &[Pair]| {
        let errors = pairs.iter().map(|pair| pair.1);
        let least = errors.clone().fold(f64::INFINITY, f64::min);
        (least, errors.fold(0.0, f64::max))
    };
    let ((low_a, high_a), (low_b, high_b)) = (errors(&explicit), errors(&implicit.concat()));
    let (low, high) = (low_a.max(low_b), high_a.min(high_b));
    if low > high {
        return Vec::new();
    }
    let count = if high < 1.1 * low { 0 } else { COMPARED };
    let share = |k: i32| f64::from(k) / f64::from(count.max(1));
    let ratio = |k: i32| {
        let error = high * (low / high).powf(share(k));
        let cheapest = implicit.iter().filter_map(|own| reach(own, error));
        Some((error, reach(&explicit, error)? / cheapest.reduce(f64::min)?))
    };
    (0..=count).filter_map(ratio).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Measured;
    use crate::study::cost::tests::run;

    fn told(runs: &[Measured]) -> Option<String> {
        crossover(&crate::study::cost::groups(runs)).0
    }

    #[test]
    fn a_method_wins_only_where_both_were_measured() {
        assert_eq!(told(&[]), None);
        assert_eq!(told(&[run("explicit", 1.0, 1e-2)]), None);
        let apart = [
            run("explicit", 1.0, 1e-1),
            run("explicit", 2.0, 3e-2),
            run("implicit", 1.0, 1e-2),
            run("implicit", 2.0, 1e-3),
        ];
        assert_eq!(told(&apart), None, "no error that both reach");
    }

    /// Costs of 1 and 100 s for 1e-1 and 1e-3 cross a constant 10 s at 1e-2.
    #[test]
    fn the_winner_is_told_over_the_range_that_both_reach() {
        let explicit = [run("explicit", 1.0, 1e-1), run("explicit", 100.0, 1e-3)];
        let against = |one: f64, other: f64| {
            let implicit = [run("implicit", one, 1e-1), run("implicit", other, 1e-3)];
            told(&[&explicit[..], &implicit].concat()).unwrap()
        };
        let crossing = against(9.9, 10.0);
        assert!(
            crossing.starts_with("Implicit starts to win at an error of 1.00e-2"),
            "{crossing}"
        );
        assert!(against(0.5, 50.0).starts_with("Implicit wins over the whole range"));
        assert!(against(2.0, 200.0).starts_with("Explicit wins over the whole range"));
        assert!(against(0.5, 200.0).starts_with("Neither wins"));
    }
}
