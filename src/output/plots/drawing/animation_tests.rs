use super::*;
use crate::output::plots::Scale;

/// 4 × 2 square cells of 1 m, row by row from below.
fn positions() -> Vec<f64> {
    (0..8)
        .flat_map(|i| [f64::from(i % 4) + 0.5, f64::from(i / 4) + 0.5])
        .collect()
}

fn frames(count: u32) -> Vec<(f64, Vec<f64>)> {
    let frame = |k: u32| (0.1 * f64::from(k), vec![f64::from(k); 8]);
    (0..count).map(frame).collect()
}

fn plot<'a>(positions: &'a [f64], frames: &'a [(f64, Vec<f64>)]) -> Multiples<'a> {
    Multiples {
        title: "damage",
        unit: "",
        positions,
        sizes: &[1.0; 8],
        frames,
        scale: Scale::Linear,
        range: None,
        width_px: 400,
        axes: ["x", "y"],
        lines: &[],
        outlines: &[],
    }
}

fn bytes(plot: &Multiples<'_>) -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("animation.png");
    animation_png(&path, plot, 0.25).unwrap();
    std::fs::read(path).unwrap()
}

fn refusal(plot: &Multiples<'_>, seconds: f64) -> OutputError {
    let path = tempfile::tempdir().unwrap().path().join("a.png");
    animation_png(&path, plot, seconds).unwrap_err()
}

#[test]
fn every_frame_is_there_for_its_time_in_the_common_colours() {
    let (positions, frames) = (positions(), frames(15));
    let plot = plot(&positions, &frames);
    let bytes = bytes(&plot);
    let decoder = png::Decoder::new(std::io::Cursor::new(&bytes));
    let mut reader = decoder.read_info().unwrap();
    let control = reader.info().animation_control.unwrap();
    assert_eq!((control.num_frames, control.num_plays), (15, 0));
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    for (_, values) in &frames {
        reader.next_frame(&mut pixels).unwrap();
        let delay = reader.info().frame_control.unwrap();
        assert_eq!((delay.delay_num, delay.delay_den), (250, 1000));
        let colour = plot.colours().colour(values[0]);
        let count = pixels.chunks(3).filter(|pixel| *pixel == colour).count();
        assert!(count > 10_000, "{values:?}: {count}");
    }
}

#[test]
fn the_file_names_its_number_of_frames() {
    let (positions, frames) = (positions(), frames(3));
    let bytes = bytes(&plot(&positions, &frames));
    let at = bytes.windows(4).position(|four| four == b"acTL").unwrap();
    assert_eq!(bytes[at + 4..at + 8], [0, 0, 0, 3]);
    let images = bytes.windows(4).filter(|four| *four == b"fcTL").count();
    assert_eq!(images, 3);
}

#[test]
fn a_frame_with_remarks_of_its_own_keeps_the_size_of_the_others() {
    let (positions, mut frames) = (positions(), frames(3));
    frames[1].1[0] = f64::NAN;
    frames[2].0 = 1e9;
    assert!(!bytes(&plot(&positions, &frames)).is_empty());
}

#[test]
fn impossible_times_per_frame_and_missing_frames_are_refused() {
    let (positions, frames) = (positions(), frames(2));
    for seconds in [f64::NAN, 0.0, -1.0, 61.0] {
        let error = refusal(&plot(&positions, &frames), seconds);
        assert!(error.to_string().contains("time per frame"), "{error}");
    }
    let error = refusal(&plot(&positions, &[]), 0.1);
    assert!(matches!(error, OutputError::Unsupported { .. }), "{error}");
    let error = refusal(&plot(&positions[1..], &frames), 0.1);
    assert!(matches!(error, OutputError::Shape { .. }), "{error}");
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let (positions, frames) = (positions(), frames(2));
    let plot = plot(&positions, &frames);
    assert!(bytes(&plot) == bytes(&plot));
}
