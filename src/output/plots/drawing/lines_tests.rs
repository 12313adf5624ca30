use super::*;

fn svg(plot: &LinePlot<'_>) -> String {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("lines.svg");
    lines_svg(&path, plot).unwrap();
    std::fs::read_to_string(path).unwrap()
}

fn plot<'a>(series: &'a [Series<'a>]) -> LinePlot<'a> {
    LinePlot {
        title: "pressure <p> & \"time\"",
        x_label: "time [s]",
        y_label: "pressure [Pa]",
        x_log: false,
        y_log: false,
        series,
        note: None,
    }
}

fn series<'a>(label: &'a str, x: &'a [f64], y: &'a [f64], style: LineStyle) -> Series<'a> {
    Series { label, x, y, style }
}

/// Texts of the drawing; fails if it is not well-formed.
fn texts(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let nodes = document
        .descendants()
        .filter(|node| node.has_tag_name("text"));
    nodes
        .filter_map(|node| node.text().map(|text| text.trim().to_owned()))
        .collect()
}

/// Curves in the colour of the series of the given index: the places of each polyline, in pixels.
fn polylines(svg: &str, index: usize) -> Vec<Vec<Place>> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let [r, g, b] = crate::output::plots::drawing::colours::PALETTE[index];
    let colour = format!("#{r:02X}{g:02X}{b:02X}");
    let unit = f64::from(SVG_UNITS);
    let place = |pair: &str| {
        let (x, y) = pair.split_once(',').unwrap();
        (
            x.parse::<f64>().unwrap() / unit,
            y.parse::<f64>().unwrap() / unit,
        )
    };
    let nodes = document
        .descendants()
        .filter(|node| node.attribute("stroke") == Some(&colour));
    nodes
        .filter_map(|node| node.attribute("points"))
        .map(|points| points.split_whitespace().map(place).collect())
        .collect()
}

#[test]
fn axes_are_labelled_in_handy_units_and_markup_is_escaped() {
    let data = [series("a", &[0.0, 864_000.0], &[0.0, 5e6], LineStyle::Line)];
    let texts = texts(&svg(&plot(&data)));
    for expected in [
        "time [d]",
        "pressure [MPa]",
        "10",
        "pressure <p> & \"time\"",
        "a",
    ] {
        assert!(
            texts.iter().any(|text| text == expected),
            "{expected} not in {texts:?}"
        );
    }
}

#[test]
fn control_characters_do_not_break_the_drawing() {
    let data = [series("a\u{1}b", &[0.0, 1.0], &[0.0, 1.0], LineStyle::Line)];
    let svg = svg(&LinePlot {
        title: "c\u{0}d\ne",
        ..plot(&data)
    });
    assert!(texts(&svg).contains(&"a b".to_owned()));
}

#[test]
fn a_straight_line_runs_from_corner_to_corner_of_its_data() {
    let data = [series(
        "",
        &[0.0, 1.0, 2.0],
        &[0.0, 1.0, 2.0],
        LineStyle::Line,
    )];
    let curves = polylines(&svg(&plot(&data)), 0);
    let [(x0, y0), (x1, y1), (x2, y2)] = curves[0][..] else {
        panic!("{curves:?}")
    };
    assert!(
        x0 < x1 && x1 < x2 && y0 > y1 && y1 > y2,
        "up is up and right is right"
    );
    assert!((x1 - 0.5 * (x0 + x2)).abs() < 0.1 && (y1 - 0.5 * (y0 + y2)).abs() < 0.1);
}

#[test]
fn equal_ratios_are_equal_lengths_on_logarithmic_axes() {
    let values = [1e-9, 1e-6, 1e-3];
    let data = [series("", &values, &values, LineStyle::Line)];
    let svg = svg(&LinePlot {
        x_log: true,
        y_log: true,
        ..plot(&data)
    });
    let places = polylines(&svg, 0).remove(0);
    assert!((places[1].0 - 0.5 * (places[0].0 + places[2].0)).abs() < 0.1);
    assert!((places[1].1 - 0.5 * (places[0].1 + places[2].1)).abs() < 0.1);
    assert!(texts(&svg).contains(&"10⁻⁹".to_owned()));
}

#[test]
fn a_gap_splits_the_curve_and_a_lonely_point_becomes_a_mark() {
    let y = [1.0, 2.0, f64::NAN, 3.0, f64::INFINITY, 2.0, 1.0];
    let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let svg = svg(&plot(&[series("", &x, &y, LineStyle::Line)]));
    assert_eq!(polylines(&svg, 0).len(), 2);
    assert_eq!(svg.matches("<circle").count(), 1);
}

#[test]
fn values_without_a_place_on_a_logarithmic_axis_are_counted() {
    let data = [series(
        "",
        &[1.0, 2.0, 3.0],
        &[0.0, -1.0, 5.0],
        LineStyle::Line,
    )];
    let texts = texts(&svg(&LinePlot {
        y_log: true,
        ..plot(&data)
    }));
    assert!(
        texts.iter().any(|text| text.starts_with("2 values ≤ 0")),
        "{texts:?}"
    );
}

#[test]
fn empty_constant_and_single_point_series_give_a_drawing() {
    let nan = [f64::NAN; 3];
    let cases: [&[Series<'_>]; 6] = [
        &[],
        &[series("empty", &[], &[], LineStyle::Line)],
        &[series(
            "constant",
            &[0.0, 1.0],
            &[7.0, 7.0],
            LineStyle::Dashed,
        )],
        &[series("zero", &[0.0, 0.0], &[0.0, 0.0], LineStyle::Line)],
        &[series("single", &[3.0], &[4.0], LineStyle::Markers)],
        &[series("nothing finite", &nan, &nan, LineStyle::Line)],
    ];
    for data in cases {
        for (x_log, y_log) in [(false, false), (true, true)] {
            let svg = svg(&LinePlot {
                x_log,
                y_log,
                ..plot(data)
            });
            assert!(!texts(&svg).is_empty());
            assert!(!svg.contains("NaN") && !svg.contains(&i32::MAX.to_string()));
        }
    }
}

#[test]
fn a_million_values_make_a_small_file() {
    let x: Vec<f64> = (0..1_000_000).map(f64::from).collect();
    let y: Vec<f64> = x
        .iter()
        .map(|x| (x * 1e-5).sin() + 0.1 * (x * 1.7).sin())
        .collect();
    let data = [LineStyle::Line, LineStyle::Dashed, LineStyle::Markers]
        .map(|style| series("noise", &x, &y, style));
    let svg = svg(&plot(&data));
    let vertices: usize = polylines(&svg, 0).iter().map(Vec::len).sum();
    assert!(
        vertices < 4000 && svg.len() < 400_000,
        "{vertices} {}",
        svg.len()
    );
}

#[test]
fn nothing_leaves_the_drawing() {
    let x = [0.0, 1.0, 2.0];
    let names: Vec<String> = (0..9)
        .map(|i| format!("a long name of series {i}"))
        .collect();
    let y: Vec<Vec<f64>> = (0..9)
        .map(|i| x.map(|x| x * f64::from(i) * 1e9).to_vec())
        .collect();
    let data: Vec<Series<'_>> = names
        .iter()
        .zip(&y)
        .map(|(name, y)| series(name, &x, y, LineStyle::Line))
        .collect();
    let svg = svg(&plot(&data));
    let document = roxmltree::Document::parse(&svg).unwrap();
    let size: Vec<f64> = document
        .root_element()
        .attribute("viewBox")
        .unwrap()
        .split(' ')
        .map(|v| v.parse().unwrap())
        .collect();
    for node in document.descendants() {
        let number = |name| node.attribute(name).and_then(|v| v.parse::<f64>().ok());
        if let (Some(x), Some(y)) = (number("x"), number("y")) {
            assert!((0.0..=size[2]).contains(&x) && (0.0..=size[3]).contains(&y));
        }
    }
    for curve in 0..7 {
        for (x, y) in polylines(&svg, curve).concat() {
            assert!((0.0..900.0).contains(&x) && (0.0..size[3] / 20.0).contains(&y));
        }
    }
}

#[test]
fn series_of_unequal_lengths_are_refused() {
    let path = tempfile::tempdir().unwrap().path().join("a.svg");
    let data = [series("torn", &[1.0, 2.0], &[1.0], LineStyle::Line)];
    let error = lines_svg(path, &plot(&data)).unwrap_err();
    assert!(error.to_string().contains("torn"), "{error}");
}

#[test]
fn a_series_without_a_label_looks_as_the_one_before_it() {
    let values = [0.0, 1.0];
    let of = |label| series(label, &values, &values, LineStyle::Dashed);
    let data = [of("near"), of("exact"), of(""), of("")];
    let indices: Vec<usize> = looks(&plot(&data)).iter().map(|look| look.index).collect();
    assert_eq!(indices, [0, 1, 1, 1]);
    let data = [of(""), of("exact")];
    let indices: Vec<usize> = looks(&plot(&data)).iter().map(|look| look.index).collect();
    assert_eq!(indices, [0, 1]);
}

#[test]
fn marks_stand_at_values_alone_and_thin_curves_have_none() {
    let (x, y) = ([1.0, 2.0, 3.0], [3.0, 1.0, 2.0]);
    let long: Vec<f64> = (0..100).map(|k| 1.0 + 0.02 * f64::from(k)).collect();
    let data = [
        series("runs", &x, &y, LineStyle::Markers),
        series("", &x, &y, LineStyle::Thin),
        series("", &long, &long, LineStyle::Thin),
        series("", &x[..1], &y[..1], LineStyle::Thin),
    ];
    let svg = svg(&plot(&data));
    assert_eq!(
        svg.matches("<circle").count(),
        x.len() + 1,
        "one is in the legend"
    );
    assert!(!svg.contains("<polygon"));
    assert!(
        polylines(&svg, 0)
            .iter()
            .any(|curve| curve.len() == x.len())
    );
}
