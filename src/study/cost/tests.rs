use super::*;
use crate::study::{Row, Status};
use reaching::reaching;

/// A run of a scheme that took so many seconds for an error.
pub(crate) fn run(scheme: &str, wall_s: f64, error: f64) -> Measured {
    let variant = Variant {
        scheme: scheme.to_owned(),
        solver: "-".to_owned(),
        ..Variant::default()
    };
    let mut row = Row::unmeasured(String::new(), 0, Status::Done, String::new());
    (row.reason, row.wall_s) = (None, wall_s);
    let mut run = Measured::new(variant, vec![row]);
    run.compared = Some(Compared {
        errors: [("pressure".to_owned(), error)].into(),
        resolved: true,
    });
    run
}

fn told(runs: &[Measured]) -> Vec<String> {
    let done: Vec<&Measured> = runs.iter().collect();
    let (_, costs) = reaching(&groups(runs), &done);
    super::headlines(&costs)
}

/// 1 s for 1e-1 and 100 s for 1e-3 give 10 s for 1e-2; nothing is told of 1e-4.
#[test]
fn errors_cost_what_runs_or_two_of_them_tell_and_no_more() {
    assert!(told(&[]).is_empty());
    let runs = [
        run("monolithic", 1.0, 1e-1),
        run("monolithic", 100.0, 1e-3),
        run("explicit", 181.0, 1.5e-2),
    ];
    assert_eq!(
        told(&runs),
        [
            "For 1e-1: monolithic 1.00 s, explicit 181 s (181.0×).",
            "For 1e-2: monolithic 10 s, explicit not reached (best 1.5e-2 at 181 s).",
            "For 1e-3: monolithic 100 s, explicit not reached (best 1.5e-2 at 181 s).",
        ]
    );
}

#[test]
fn a_single_run_tells_its_own_error_only() {
    assert_eq!(
        told(&[run("explicit", 2.0, 1e-2)]),
        ["For 1e-2: explicit 2.00 s."]
    );
    assert!(told(&[run("explicit", 2.0, 2e-2)]).is_empty());
}

/// Two clouds lie on a power law whatever they are.
#[test]
fn two_clouds_tell_neither_an_order_nor_an_exponent() {
    let on = |spacing: f64| {
        let mut run = run("implicit", 1.0 / spacing, spacing.powi(2));
        run.variant = run.variant.with("spacing", spacing);
        run
    };
    let clouds = [on(0.4), on(0.2), on(0.1)];
    let orders_of = |count: usize| {
        let done: Vec<&Measured> = clouds[..count].iter().collect();
        orders(&done).0.rows.len()
    };
    assert_eq!(
        (orders_of(0), orders_of(1), orders_of(2), orders_of(3)),
        (0, 0, 0, 1)
    );
}

/// Settings are more runs on the same clouds, and no more clouds.
#[test]
fn settings_tell_no_orders() {
    let on = |spacing: f64, setting| {
        let mut run = run("implicit", 1.0 / spacing, spacing.powi(2));
        run.variant = run.variant.with("spacing", spacing);
        run.variant.setting = setting;
        run
    };
    let relaxed = Some("relaxed to 1e-5");
    let runs = [
        on(0.4, None),
        on(0.2, None),
        on(0.4, relaxed),
        on(0.2, relaxed),
    ];
    let done: Vec<&Measured> = runs.iter().collect();
    assert!(orders(&done).0.rows.is_empty() && growth(&done).0.rows.is_empty());
}

#[test]
fn methods_with_few_runs_are_named_and_every_run_has_one_mark() {
    let mut unfinished = run("staggered", f64::NAN, f64::NAN);
    unfinished.rows[0].status = Status::TimedOut;
    let runs: Vec<Measured> = (1..=5)
        .map(|k| run("implicit", f64::from(k), 0.1 / f64::from(k)))
        .chain([
            run("explicit", 3.0, 0.3),
            run("explicit", 4.0, 0.5),
            unfinished,
        ])
        .collect();
    let mut section = Section::new("");
    draw(&mut section, &groups(&runs));
    assert_eq!(
        section.text,
        ["Methods with fewer than 4 runs that tell an error: explicit (2); staggered (0)."]
    );
    let drawing = &section.figures[0].svg;
    assert_eq!(crate::study::tests::marks(drawing, 2), 7);
    assert!(told(&runs)[0].contains("staggered no error measured"));
}
