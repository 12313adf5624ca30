//! What pages say of studies of which little was run.

use std::path::Path;

use super::*;

/// Every kind of study with a case that suits it.
const STUDIES: [(&str, &str); 6] = [
    ("cost", "terzaghi"),
    ("cost", "heterogeneous"),
    ("contrast", "two-layer"),
    ("stability", "terzaghi"),
    ("stability", "two-layer"),
    ("convergence", "terzaghi"),
];

/// Words of claims that take several runs.
const CLAIMS: [&str; 7] = [
    "is of order",
    "found at",
    "very grid cell",
    "at every step run",
    " wins ",
    "extrapolated",
    "over the whole range",
];

fn subject(case: &str) -> StudyCase {
    let scene = crate::cases::find(case).unwrap().scene;
    let loaded = crate::scene::load_str(case, scene, Path::new(""), &[]).unwrap();
    let plan = crate::plan::resolve(&loaded, case).unwrap();
    StudyCase::new(case, &loaded, plan, Vec::new())
}

/// Where rows repeat along all axes but one, and only there; solvers that the user names are all there are.
#[test]
fn the_study_of_cost_compares_transforms_where_they_can_be_used() {
    let first = |case: &str, scheme: &str, options: &Options| {
        subject(case).fastest_solvers(scheme, options).remove(0)
    };
    let options = Options::default();
    for (case, scheme, solver) in [
        ("terzaghi", "monolithic", "fourier"),
        ("terzaghi", "staggered", "fourier"),
        ("terzaghi", "explicit", "-"),
        ("terzaghi-graded", "monolithic", "faer-ldlt"),
        ("two-layer", "implicit", "fourier"),
        ("heterogeneous", "implicit", "faer-llt"),
    ] {
        assert_eq!(first(case, scheme, &options), solver, "{case} {scheme}");
    }
    let named = Options {
        solvers: vec!["faer-ldlt".to_owned()],
        ..Options::default()
    };
    assert_eq!(first("terzaghi", "monolithic", &named), "faer-ldlt");
}

/// Planned runs of a study, all of one status; those done took a second and left nothing else.
fn planned(kind: &dyn Study, subject: &StudyCase, status: Status) -> Vec<Measured> {
    let options = Options {
        quick: true,
        ..Options::default()
    };
    let run = |variant| {
        let mut row = Row::unmeasured(String::new(), 0, status, "the reason".to_owned());
        if status == Status::Done {
            (row.reason, row.wall_s) = (None, 1.0);
        }
        Measured::new(variant, vec![row])
    };
    let variants = kind.variants(subject, &options).unwrap();
    variants.into_iter().map(run).collect()
}

fn page(kind: &dyn Study, subject: &StudyCase, runs: &[Measured]) -> String {
    let request = Request {
        command: "perifrac study --budget 1s".to_owned(),
        longer: "perifrac study".to_owned(),
        complete: false,
    };
    let findings = kind.findings(subject, runs);
    let page = html::study_page(
        (kind.name(), &request),
        subject,
        &Machine::here(),
        &findings,
        runs,
    );
    // The style has words of its own.
    page.split_once("</style>").unwrap().1.to_owned()
}

#[track_caller]
fn assert_no_claim(page: &str) {
    // What readers see ends where scripts begin.
    let page = page.split("<script>").next().unwrap_or_default();
    for words in CLAIMS.iter().chain(&["NaN", "inf "]) {
        assert!(!page.contains(words), "{words:?} in {page}");
    }
}

/// Marks of a drawing, those of its legend left out.
pub(super) fn marks(svg: &str, in_legend: usize) -> usize {
    svg.matches("<circle").count() + svg.matches("<polygon").count() - in_legend
}

#[test]
fn a_study_of_which_nothing_was_run_shows_nothing_and_says_what_is_missing() {
    for (name, case) in STUDIES {
        let (kind, subject) = (study(name).unwrap(), subject(case));
        for status in [
            Status::NotRun,
            Status::TimedOut,
            Status::Skipped,
            Status::Refused,
        ] {
            let runs = planned(&*kind, &subject, status);
            let page = page(&*kind, &subject, &runs);
            assert_no_claim(&page);
            assert!(
                !page.contains("<svg"),
                "{name} {case}: a picture of nothing"
            );
            let state = format!("0 of {0} runs done, {0} {1}", runs.len(), status.name());
            assert!(
                page.contains(&state),
                "{name} {case}: {state} not in {page}"
            );
            for line in kind.findings(&subject, &runs).headlines {
                let denies = line.to_lowercase().contains("no ");
                assert!(denies, "{name} {case}: {line}");
            }
        }
    }
}

#[test]
fn a_single_run_makes_no_claim() {
    for (name, case) in STUDIES {
        let (kind, subject) = (study(name).unwrap(), subject(case));
        let waiting = planned(&*kind, &subject, Status::NotRun);
        let done = planned(&*kind, &subject, Status::Done);
        for index in [0, done.len() / 2, done.len() - 1] {
            let mut runs = waiting.clone();
            runs[index] = done[index].clone();
            assert_no_claim(&page(&*kind, &subject, &runs));
        }
    }
}

/// A run of a map whose pressure fades or grows.
fn of_map(mut run: Measured, grows: bool) -> Measured {
    let factor: f64 = if grows { 1.1 } else { 0.9 };
    let high = (0..40).map(|k| factor.powi(k)).collect();
    run.rows[0].fields = vec![
        (profile::LOWEST.to_owned(), vec![0.0; 40]),
        (profile::HIGHEST.to_owned(), high),
    ];
    run
}

#[test]
fn a_map_has_a_mark_for_every_run_that_ended_and_borders_between_such_alone() {
    let (kind, subject) = (study("stability").unwrap(), subject("two-layer"));
    let explicit = |run: &Measured| run.variant.scheme == "explicit";
    let waiting = planned(&*kind, &subject, Status::NotRun);
    let done = planned(&*kind, &subject, Status::Done);
    let ratio = |run: &Measured| run.variant.value("step_ratio");
    // All steps up to the limit are run, then those beyond it too.
    for (most, ended, borders) in [(1.0, 6, false), (10.0, 15, true)] {
        let runs: Vec<Measured> = std::iter::zip(&waiting, &done)
            .map(
                |(waiting, done)| match explicit(done) && ratio(done) < most {
                    true => of_map(done.clone(), ratio(done) > 1.0),
                    false => waiting.clone(),
                },
            )
            .collect();
        let content = kind.findings(&subject, &runs);
        let line = content
            .headlines
            .iter()
            .find(|line| line.starts_with("explicit:"));
        let line = line.unwrap();
        assert_eq!(
            line.contains("border of stability found at 3 of 3"),
            borders,
            "{line}"
        );
        assert_eq!(
            line.contains("6 of 15 runs ended, 6 stable"),
            !borders,
            "{line}"
        );
        let figures = &content.sections[0].figures;
        assert_eq!(figures.len(), 1, "of the only scheme that was run");
        assert_eq!(marks(&figures[0].svg, 4), ended);
    }
}

/// Errors of 1/steps² beside an over-resolved run, of which the one that verifies it is missing or not.
#[test]
fn orders_in_time_take_a_verified_run_and_three_others() {
    let (kind, subject) = (study("convergence").unwrap(), subject("terzaghi"));
    let runs = |steps: f64, verified: bool| -> Vec<Measured> {
        let mut runs = planned(&*kind, &subject, Status::Done);
        for run in &mut runs {
            let own = run.variant.value("steps");
            let role = run.variant.value("role");
            run.rows[0].fields = vec![("pressure".to_owned(), vec![1.0, own.powi(-2)])];
            let kept = match role {
                role if role < 0.5 => own <= steps && run.variant.scheme == "monolithic TR-BDF2",
                role if role < 1.5 => verified,
                role => role < 2.5,
            };
            if !kept {
                run.rows[0].status = Status::NotRun;
            }
        }
        runs
    };
    let order = |runs: &[Measured]| {
        let lines = kind.findings(&subject, runs).headlines;
        lines.iter().any(|line| line.contains("is of order"))
    };
    assert!(!order(&runs(64.0, false)), "nothing verifies the run");
    assert!(!order(&runs(16.0, true)), "two runs");
    let lines = kind.findings(&subject, &runs(16.0, true)).headlines;
    assert!(
        lines[0].contains("no order of pressure in time; 2 runs"),
        "{lines:?}"
    );
}
