#![allow(clippy::float_cmp)]

use super::*;
use crate::output::plots::drawing::colours::MISSING;

type Rgb = [u8; 3];

struct Decoded {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Decoded {
    fn at(&self, x: usize, y: usize) -> Rgb {
        let start = 3 * (y * self.width + x);
        self.pixels[start..start + 3].try_into().unwrap()
    }

    fn count(&self, colour: Rgb) -> usize {
        self.pixels
            .chunks(3)
            .filter(|pixel| *pixel == colour)
            .count()
    }
}

fn picture(plot: &FieldPlot<'_>) -> Decoded {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("field.png");
    field_png(&path, plot).unwrap();
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    Decoded {
        width: info.width as usize,
        height: info.height as usize,
        pixels,
    }
}

/// A lattice of `across × up` square cells of 1 m, row by row from below.
fn lattice(across: usize, up: usize) -> Vec<f64> {
    let coordinate = |i: usize| i as f64 + 0.5;
    (0..across * up)
        .flat_map(|i| [coordinate(i % across), coordinate(i / across)])
        .collect()
}

fn plot<'a>(positions: &'a [f64], sizes: &'a [f64], values: &'a [f64]) -> FieldPlot<'a> {
    FieldPlot {
        title: "pressure",
        unit: "Pa",
        positions,
        dimension: 2,
        sizes,
        values,
        time: Some(10.0),
        scale: Scale::Linear,
        range: None,
        width_px: 600,
        axes: ["x", "y"],
        lines: &[],
        outlines: &[],
        source: None,
    }
}

/// The frame of the plot, found by the layout itself.
fn frame_of(plot: &FieldPlot<'_>) -> crate::output::plots::drawing::axes::Frame {
    let colours = ColourScale::new(plot.values, plot.range, plot.scale == Scale::Log10);
    let (_, window) = cells(plot, &colours);
    let (bar, metres) = units(plot.unit, &colours, &window);
    let (x, y) = window.axes();
    let content = Content {
        width: f64::from(plot.width_px),
        title: plot.title,
        time: "t",
        unit: &bar.unit,
        notes: &colours.remarks(plot.values.iter().copied()),
        x: x.divided(metres.divisor),
        y: y.divided(metres.divisor),
        bar: colours.axis.divided(bar.divisor),
    };
    Layout::fit(&content).unwrap().frame
}

#[test]
fn cells_that_are_no_squares_fill_the_domain_and_nothing_else() {
    // A square of two triangles; the frame ends at their corners, not half an edge around their middles.
    let outlines = [
        vec![[0.0, 0.0], [3.0, 0.0], [3.0, 3.0]],
        vec![[0.0, 0.0], [3.0, 3.0], [0.0, 3.0]],
    ];
    let plot = FieldPlot {
        outlines: &outlines,
        ..plot(&[2.0, 1.0, 1.0, 2.0], &[2.0; 2], &[0.0, 1.0])
    };
    let colours = ColourScale::new(plot.values, None, false);
    let (_, window) = cells(&plot, &colours);
    assert_eq!(
        [window.left, window.right, window.bottom, window.top],
        [0.0, 3.0, 0.0, 3.0]
    );
    let picture = draw(&plot).unwrap();
    let count = |value: f64| {
        let colour = colours.colour(value);
        let pixels = picture.pixels.chunks(3);
        pixels.filter(|own| *own == colour).count() as f64
    };
    let frame = frame_of(&plot);
    let half = 0.5 * frame.width * frame.height;
    // The outline of the frame and the line between both cover some.
    assert!(
        (count(0.0) / half - 1.0).abs() < 0.05,
        "{} {half}",
        count(0.0)
    );
    assert!(
        (count(1.0) / half - 1.0).abs() < 0.05,
        "{} {half}",
        count(1.0)
    );
}

#[test]
fn low_values_are_dark_blue_and_high_values_yellow_where_they_belong() {
    let positions = lattice(10, 10);
    let values: Vec<f64> = positions
        .chunks(2)
        .map(|p| if p[0] < 5.0 { 0.0 } else { 2e6 })
        .collect();
    let plot = plot(&positions, &[1.0; 100], &values);
    let (image, frame) = (picture(&plot), frame_of(&plot));
    let at = |across: f64, up: f64| {
        let (x, y) = frame.place((across, up));
        image.at(x as usize, y as usize)
    };
    for up in [0.05, 0.5, 0.95] {
        for across in [0.05, 0.3, 0.48] {
            assert_eq!(at(across, up), [68, 1, 84], "{across} {up}");
            assert_eq!(at(across + 0.5, up), [253, 231, 37], "{across} {up}");
        }
    }
}

#[test]
fn the_upper_row_of_points_is_at_the_top() {
    let positions = lattice(4, 4);
    let values: Vec<f64> = positions.chunks(2).map(|p| p[1]).collect();
    let plot = plot(&positions, &[1.0; 16], &values);
    let (image, frame) = (picture(&plot), frame_of(&plot));
    let at = |up: f64| {
        let (x, y) = frame.place((0.5, up));
        image.at(x as usize, y as usize)
    };
    assert_eq!((at(0.1), at(0.9)), ([68, 1, 84], [253, 231, 37]));
}

#[test]
fn no_stripe_of_background_runs_between_the_cells() {
    let positions = lattice(37, 23);
    let values: Vec<f64> = (0..37 * 23).map(|i| f64::from(i % 7)).collect();
    let plot = plot(&positions, &[1.0; 37 * 23], &values);
    let (image, frame) = (picture(&plot), frame_of(&plot));
    for y in frame.top as usize + 2..frame.bottom() as usize - 2 {
        for x in frame.left as usize + 2..frame.right() as usize - 2 {
            assert_ne!(image.at(x, y), [255; 3], "white pixel at {x}, {y}");
        }
    }
}

#[test]
fn values_that_are_not_finite_are_grey_and_the_others_keep_their_colour() {
    let positions = lattice(2, 1);
    let plot = plot(&positions, &[1.0; 2], &[f64::NAN, 3.0]);
    let image = picture(&plot);
    assert!(image.count(MISSING) > 1000);
    let colours = ColourScale::new(plot.values, None, false);
    assert!(colours.remarks(plot.values.iter().copied())[0].contains("1 of 2"));
    let nothing = picture(&self::plot(
        &positions,
        &[1.0; 2],
        &[f64::NAN, f64::INFINITY],
    ));
    assert!(nothing.count(MISSING) > 1000);
}

#[test]
fn logarithmic_colours_are_grey_for_values_that_are_not_positive() {
    let positions = lattice(3, 1);
    let base = plot(&positions, &[1.0; 3], &[1e-18, 1e-12, 0.0]);
    let image = picture(&FieldPlot {
        scale: Scale::Log10,
        unit: "m^2",
        ..base
    });
    assert!(image.count(MISSING) > 1000);
    assert!(image.count([68, 1, 84]) > 1000 && image.count([253, 231, 37]) > 1000);
}

#[test]
fn difficult_inputs_give_a_picture_all_the_same() {
    let point = [1e5, -2e-3];
    let cases: [(&[f64], &[f64], &[f64]); 6] = [
        (&[], &[], &[]),
        (&point, &[0.0], &[5.0]),
        (&point, &[f64::NAN], &[0.0]),
        (&[f64::NAN, 0.0], &[1.0], &[1.0]),
        (&[0.0, 0.0, 1e-9, 1e9], &[1.0, 1.0], &[f64::MAX, -f64::MAX]),
        (&[0.0, 0.0, 1.0, 0.0], &[1.0, 1.0], &[7.0, 7.0]),
    ];
    for (positions, sizes, values) in cases {
        for scale in [Scale::Linear, Scale::Log10] {
            for range in [
                None,
                Some((f64::NAN, 1.0)),
                Some((1.0, 1.0)),
                Some((-1.0, 2.0)),
            ] {
                let image = picture(&FieldPlot {
                    scale,
                    range,
                    ..plot(positions, sizes, values)
                });
                assert_eq!(image.width, 600);
                assert!((200..1400).contains(&image.height), "{} high", image.height);
            }
        }
    }
}

#[test]
fn points_in_space_are_drawn_by_their_first_two_coordinates() {
    let flat = lattice(3, 2);
    let space: Vec<f64> = flat.chunks(2).flat_map(|p| [p[0], p[1], 9.0]).collect();
    let values: Vec<f64> = (0..6).map(f64::from).collect();
    let base = plot(&flat, &[1.0; 6], &values);
    let in_space = FieldPlot {
        positions: &space,
        dimension: 3,
        ..base
    };
    assert!(picture(&base).pixels == picture(&in_space).pixels);
}

#[test]
fn arrays_that_do_not_fit_are_refused() {
    let path = tempfile::tempdir().unwrap().path().join("a.png");
    let bad = plot(&[0.0; 4], &[1.0; 2], &[1.0; 3]);
    assert!(matches!(
        field_png(&path, &bad),
        Err(OutputError::Shape { expected: 6, .. })
    ));
    let bad = plot(&[0.0; 4], &[1.0; 1], &[1.0; 2]);
    assert!(matches!(
        field_png(&path, &bad),
        Err(OutputError::Shape { expected: 2, .. })
    ));
    let bad = FieldPlot {
        dimension: 1,
        ..plot(&[0.0; 2], &[1.0; 2], &[1.0; 2])
    };
    assert!(matches!(
        field_png(&path, &bad),
        Err(OutputError::Unsupported { .. })
    ));
}
