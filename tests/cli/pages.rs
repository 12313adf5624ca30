//! Pictures of runs and the page about one: `perifrac report`.

use serde_json::Value;

use crate::support::Place;

const DRAWN: (&str, &str) = (
    "plots = false",
    "plots = true\ntimes = [\"20 s\", \"50 s\"]",
);
const RUN: [&str; 4] = ["run", "scene.toml", "--out", "out"];

/// What a picture tells of itself, which stands in it as plain text.
fn facts(place: &Place, name: &str) -> Value {
    let bytes = place.read(name);
    let text = String::from_utf8_lossy(&bytes);
    let start = text.find("{\"title\"").unwrap_or_else(|| panic!("{name}"));
    let mut parsed = serde_json::Deserializer::from_str(&text[start..]).into_iter();
    parsed.next().unwrap().unwrap()
}

fn page(place: &Place) -> String {
    String::from_utf8(place.read("out/report.html")).unwrap()
}

#[test]
fn pictures_of_a_field_have_the_same_colours_at_all_outputs() {
    let place = Place::with_scene(&[DRAWN]);
    place.succeed(&RUN);
    let all: Vec<Value> = (0..4)
        .map(|k| facts(&place, &format!("out/pressure-000{k}.png")))
        .collect();
    assert!(all.iter().all(|own| own["range"] == all[0]["range"]));
    assert_eq!(all[1]["time"], 20.0);
    assert_eq!(all[1]["source"], "fields-0001.vtu");
    assert_eq!(all[1]["title"], "Base: pressure");
}

#[test]
fn fields_of_pictures_have_a_file_of_their_own_where_no_other_has_them() {
    let place = Place::with_scene(&[(DRAWN.0, "plots = true\nvtu = false")]);
    place.succeed(&RUN);
    let list = place.list("out");
    let sections: Vec<&String> = list.iter().filter(|name| name.ends_with(".vtu")).collect();
    assert_eq!(sections, ["section-0000.vtu", "section-0001.vtu"]);
    assert_eq!(
        facts(&place, "out/pressure-0001.png")["source"],
        "section-0001.vtu"
    );
    place.succeed(&["report", "out"]);
    assert!(page(&place).contains("data-values=\""));
}

#[test]
fn any_field_is_drawn_and_one_that_there_is_not_is_refused_with_those_there_are() {
    let place = Place::with_scene(&[DRAWN]);
    place.succeed(&RUN);
    let outcome = place.run(&["report", "out", "--frames", "temperature"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    let told = "has no field `temperature` at its outputs; choose one of pressure, velocity, velocity_x, velocity_y\n";
    assert!(outcome.stderr.ends_with(told), "{}", outcome.stderr);
    // Rock that does not deform has no displacement.
    let outcome = place.run(&["report", "out", "--frames", "displacement"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    place.succeed(&["report", "out", "--frames", "velocity_x"]);
    let list = place.list("out");
    for name in [
        "velocity_x-0000.png",
        "velocity_x-0003.png",
        "velocity_x-animation.png",
    ] {
        assert!(list.contains(&name.to_owned()), "{name}: {list:?}");
    }
    assert!(page(&place).contains("data-name=\"velocity_x\""));
    // The next run removes them.
    place.succeed(&RUN);
    assert!(
        !place
            .list("out")
            .contains(&"velocity_x-0000.png".to_owned())
    );
}

#[test]
fn a_page_about_a_run_without_pictures_has_no_scripts() {
    let place = Place::with_scene(&[]);
    place.succeed(&RUN);
    place.succeed(&["report", "out"]);
    let page = page(&place);
    assert!(
        page.contains("<h2>Scene</h2>") && !page.contains("<script"),
        "{page}"
    );
    assert!(!page.contains("<h2>Fields</h2>") && !page.contains("<h2>Force"));
}

#[test]
fn a_page_shows_names_and_titles_as_they_are_written() {
    let title = ("\"Base\"", "\"Sand & <script>alert(1)</script>\"");
    let place = Place::with_scene(&[DRAWN, title]);
    place.succeed(&RUN);
    place.succeed(&["report", "out"]);
    let page = page(&place);
    assert!(page.contains("Sand &amp; &lt;script&gt;alert(1)"));
    assert!(!page.contains("<script>alert"));
}
