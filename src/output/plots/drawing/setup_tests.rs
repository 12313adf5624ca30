#![allow(clippy::float_cmp)]
use super::*;

fn signed(sides: &[SideSign], marks: &[SetupMark]) -> Picture {
    let positions: Vec<f64> = (0..16)
        .flat_map(|k| [f64::from(k % 4) + 0.5, f64::from(k / 4) + 0.5])
        .collect();
    let group: Vec<usize> = (0..16).map(|k| k / 8).collect();
    draw(&SetupPlot {
        title: "a model",
        axes: ["x", "y"],
        positions: &positions,
        sizes: &[1.0; 16],
        group: &group,
        groups: &["sand".to_owned(), "<shale>".to_owned()],
        sides,
        marks,
        lines: &[],
        outlines: &[],
        notes: &[],
        width_px: 600,
    })
    .unwrap()
}

fn count(picture: &Picture, colour: Colour) -> usize {
    picture
        .pixels
        .chunks(3)
        .filter(|own| *own == colour)
        .count()
}

fn left(sign: Sign, about: About) -> SideSign {
    SideSign {
        axis: 0,
        upper: false,
        span: [0.0, 4.0],
        sign,
        about,
    }
}

#[test]
fn half_of_the_points_have_the_colour_of_each_material() {
    let picture = signed(&[], &[]);
    let [lower, upper] = [0, 1].map(|group| count(&picture, PALE[group]));
    assert!(
        lower > 10_000 && lower.abs_diff(upper) < lower / 10,
        "{lower} {upper}"
    );
}

#[test]
fn every_sign_has_the_colour_of_what_it_is_about() {
    let bare = signed(&[], &[]);
    for (sign, about) in [
        (Sign::Bar, About::Fluid),
        (Sign::Arrows([1.0, 0.0]), About::Load),
        (Sign::Arrows([-1.0, 0.5]), About::Motion),
    ] {
        let picture = signed(&[left(sign, about)], &[]);
        let colour = about.colour();
        let more = count(&picture, colour) - count(&bare, colour);
        assert!(more > 200, "{sign:?}: {more}");
    }
    let still = signed(&[left(Sign::Arrows([0.0, 0.0]), About::Load)], &[]);
    assert_eq!(count(&still, About::Load.colour()), 0);
}

#[test]
fn arrows_stay_on_the_picture_whichever_way_they_point() {
    for direction in [[1.0, 0.0], [-1.0, 0.0]] {
        let picture = signed(&[left(Sign::Arrows(direction), About::Load)], &[]);
        let green = count(&picture, About::Load.colour());
        // By the area of a shaft and a head, 15 px in size: some 120 px each, of at least two arrows.
        assert!(green > 240, "{direction:?}: {green}");
    }
}

#[test]
fn a_mark_stands_at_its_place() {
    let mark = SetupMark {
        at: [2.0, 2.0],
        label: "well".to_owned(),
        about: About::Fluid,
    };
    let more = count(&signed(&[], &[mark]), About::Fluid.colour());
    assert!(more > 50, "{more}");
}
