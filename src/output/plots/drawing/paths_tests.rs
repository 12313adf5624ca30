use super::*;

fn svg(plot: &PathPlot<'_>) -> String {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("paths.svg");
    paths_svg(&path, plot).unwrap();
    std::fs::read_to_string(path).unwrap()
}

fn plot<'a>(initial: &'a [Vec<[f64; 2]>], points: &'a [[f64; 3]]) -> PathPlot<'a> {
    PathPlot {
        title: "crack <paths>",
        bounds: [[0.0, -0.02], [0.1, 0.02]],
        initial,
        points,
        note: None,
    }
}

fn refusal(plot: &PathPlot<'_>) -> String {
    let path = tempfile::tempdir().unwrap().path().join("a.svg");
    let error = paths_svg(&path, plot).unwrap_err();
    assert!(matches!(error, OutputError::Unsupported { .. }), "{error}");
    error.to_string()
}

fn texts(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let nodes = document
        .descendants()
        .filter(|node| node.has_tag_name("text"));
    nodes
        .filter_map(|node| node.text().map(|text| text.trim().to_owned()))
        .collect()
}

/// Centres and colours of the discs in drawing units.
fn discs(svg: &str) -> Vec<(f64, f64, String)> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let nodes = document
        .descendants()
        .filter(|node| node.has_tag_name("circle"));
    let number = |node: &roxmltree::Node<'_, '_>, name| {
        node.attribute(name).unwrap().parse::<f64>().unwrap()
    };
    nodes
        .map(|node| {
            let colour = node.attribute("fill").unwrap().to_owned();
            (number(&node, "cx"), number(&node, "cy"), colour)
        })
        .collect()
}

#[test]
fn labels_are_in_handy_units_and_markup_is_escaped() {
    let points = [[0.01, 0.0, 1e-6], [0.02, 0.0, 2e-5]];
    let texts = texts(&svg(&plot(&[], &points)));
    for expected in ["crack <paths>", "x [mm]", "y [mm]", "time [µs]", "100"] {
        assert!(
            texts.iter().any(|text| text == expected),
            "{expected} not in {texts:?}"
        );
    }
    let large = PathPlot {
        bounds: [[0.0, 0.0], [40.0, 20.0]],
        ..plot(&[], &points)
    };
    assert!(self::texts(&svg(&large)).contains(&"x [m]".to_owned()));
}

#[test]
fn places_are_to_scale_and_coloured_from_early_to_late() {
    let points = [[0.05, 0.01, 9.0], [0.03, 0.0, 1.0], [0.05, 0.0, 5.0]];
    let discs = discs(&svg(&plot(&[], &points)));
    assert_eq!(discs.len(), 6, "a mark and a rim each");
    let [first, middle, last] = &discs[3..] else {
        panic!("{discs:?}")
    };
    assert_eq!((first.2.as_str(), last.2.as_str()), ("#440154", "#FDE725"));
    assert!(first.0 < middle.0 && last.1 < middle.1);
    let (across, up) = (middle.0 - first.0, middle.1 - last.1);
    assert!((across / up - 2.0).abs() < 0.03, "{across} {up}");
}

#[test]
fn initial_cracks_are_lines_cut_at_the_sides() {
    let initial = [
        vec![[-1.0, 0.0], [0.02, 0.0], [0.03, 0.01]],
        vec![[0.5, 0.5], [0.6, 0.5]],
    ];
    let svg = svg(&plot(&initial, &[]));
    let document = roxmltree::Document::parse(&svg).unwrap();
    let lines: Vec<usize> = document
        .descendants()
        .filter(|node| node.has_tag_name("polyline"))
        .filter_map(|node| node.attribute("points"))
        .map(|points| points.split_whitespace().count())
        .collect();
    assert_eq!(lines, [3]);
}

#[test]
fn a_drawing_without_broken_places_says_so_and_has_no_bar() {
    let texts = texts(&svg(&plot(&[], &[])));
    assert!(texts.contains(&"nothing broke".to_owned()), "{texts:?}");
    assert!(!texts.iter().any(|text| text.starts_with("time")));
}

#[test]
fn places_outside_the_domain_are_counted() {
    let points = [[0.01, 0.0, 1.0], [0.2, 0.0, 2.0]];
    let svg = svg(&plot(&[], &points));
    assert_eq!(discs(&svg).len(), 2);
    assert!(texts(&svg).iter().any(|text| text.starts_with("1 of 2")));
}

#[test]
fn a_million_places_make_a_small_file() {
    let points: Vec<[f64; 3]> = (0..1_000_000)
        .map(|i| f64::from(i) * 1e-6)
        .map(|s| [0.1 * s, 0.01 * (9.0 * s).sin(), s])
        .collect();
    let size = svg(&plot(&[], &points)).len();
    assert!(size < 1_500_000, "{size}");
}

#[test]
fn numbers_that_are_not_finite_and_empty_domains_are_refused() {
    let nan = f64::NAN;
    let error = refusal(&plot(&[], &[[0.0, 0.0, 0.0], [0.0, nan, 0.0]]));
    assert!(error.contains("broken place 2"), "{error}");
    let error = refusal(&plot(&[vec![[0.0, 0.0], [f64::INFINITY, 0.0]]], &[]));
    assert!(error.contains("crack 1"), "{error}");
    for bounds in [
        [[0.0, 0.0], [0.0, 1.0]],
        [[0.0, 1.0], [1.0, 0.0]],
        [[nan, 0.0], [1.0, 1.0]],
    ] {
        let error = refusal(&PathPlot {
            bounds,
            ..plot(&[], &[])
        });
        assert!(error.contains("the domain"), "{error}");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let points = [[0.01, 0.0, 1.0], [0.02, 0.0, 1.0], [0.03, 0.01, 0.5]];
    assert_eq!(svg(&plot(&[], &points)), svg(&plot(&[], &points)));
}
