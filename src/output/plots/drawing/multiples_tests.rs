use super::*;

/// 6 × 4 square cells of 1 m, row by row from below.
fn positions() -> Vec<f64> {
    (0..24)
        .flat_map(|i| [f64::from(i % 6) + 0.5, f64::from(i / 6) + 0.5])
        .collect()
}

/// Frames whose values all equal their number.
fn frames(count: u32) -> Vec<(f64, Vec<f64>)> {
    let frame = |k: u32| (60.0 * f64::from(k), vec![1e6 * f64::from(k); 24]);
    (0..count).map(frame).collect()
}

fn plot<'a>(positions: &'a [f64], frames: &'a [(f64, Vec<f64>)]) -> Multiples<'a> {
    Multiples {
        title: "pressure",
        unit: "Pa",
        positions,
        sizes: &[1.0; 24],
        frames,
        scale: Scale::Linear,
        range: None,
        width_px: 800,
        axes: ["x", "y"],
        lines: &[],
        outlines: &[],
    }
}

fn bytes(plot: &Multiples<'_>) -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("multiples.png");
    multiples_png(&path, plot).unwrap();
    std::fs::read(path).unwrap()
}

/// Number of pixels of a colour.
fn count(bytes: &[u8], colour: [u8; 3]) -> usize {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.width, 800);
    pixels.chunks(3).filter(|pixel| *pixel == colour).count()
}

fn refusal(plot: &Multiples<'_>) -> OutputError {
    let path = tempfile::tempdir().unwrap().path().join("a.png");
    multiples_png(&path, plot).unwrap_err()
}

#[test]
fn all_panels_share_one_scale_of_colours() {
    let (positions, frames) = (positions(), frames(5));
    let bytes = bytes(&plot(&positions, &frames));
    for (_, values) in &frames {
        let colour = plot(&positions, &frames).colours().colour(values[0]);
        assert!(count(&bytes, colour) > 5000, "{colour:?}");
    }
}

#[test]
fn a_given_range_sets_the_colours_of_all_panels() {
    let (positions, frames) = (positions(), frames(2));
    let bytes = bytes(&Multiples {
        range: Some([5e6, 9e6]),
        ..plot(&positions, &frames)
    });
    assert!(count(&bytes, [68, 1, 84]) > 20_000);
}

#[test]
fn every_number_of_panels_from_1_to_12_gives_a_picture_and_more_are_refused() {
    let (positions, frames) = (positions(), frames(13));
    for number in 1..=12 {
        assert!(!bytes(&plot(&positions, &frames[..number])).is_empty());
    }
    for bad in [&frames[..], &[]] {
        let error = refusal(&plot(&positions, bad));
        assert!(matches!(error, OutputError::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains("number of frames"), "{error}");
    }
}

#[test]
fn values_that_are_not_finite_are_grey() {
    let (positions, mut frames) = (positions(), frames(3));
    frames[1].1 = vec![f64::NAN; 24];
    let bytes = bytes(&plot(&positions, &frames));
    assert!(count(&bytes, super::super::colours::MISSING) > 5000);
}

#[test]
fn arrays_and_times_that_do_not_fit_are_refused() {
    let (positions, mut frames) = (positions(), frames(3));
    let error = refusal(&plot(&positions[2..], &frames));
    assert!(matches!(error, OutputError::Shape { expected: 48, .. }));
    frames[1].1.pop();
    let error = refusal(&plot(&positions, &frames));
    assert!(matches!(error, OutputError::Shape { found: 23, .. }));
    frames[1].1.push(0.0);
    frames[2].0 = f64::NAN;
    let error = refusal(&plot(&positions, &frames));
    assert!(error.to_string().contains("time of frame 3"), "{error}");
}

#[test]
fn a_picture_without_points_is_refused() {
    let error = refusal(&Multiples {
        sizes: &[],
        ..plot(&[], &[(0.0, Vec::new())])
    });
    assert!(error.to_string().contains("number of points"), "{error}");
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let (positions, frames) = (positions(), frames(4));
    let plot = plot(&positions, &frames);
    assert!(bytes(&plot) == bytes(&plot));
}
