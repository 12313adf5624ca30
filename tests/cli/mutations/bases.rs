//! The bundled scenes, coarse enough for a model in a few milliseconds.

use std::path::Path;

use perifrac::{cases, scene};
use toml::Table;

/// Case, variant, and what makes it small.
const SMALL: [(&str, Option<&str>, &[&str]); 24] = [
    ("channel", None, &["geometry.points=[9, 9]"]),
    ("column-3d", None, &["geometry.spacing=0.2"]),
    ("five-spot", None, &["geometry.points=[10, 10]"]),
    (
        "five-spot",
        None,
        &["geometry.points=[6, 6]", "time.mode=steady"],
    ),
    ("footing", None, &["geometry.spacing=1"]),
    ("heterogeneous", None, &["geometry.points=[10, 10]"]),
    ("injection-rate", None, &["geometry.spacing=0.1"]),
    ("mandel", None, &["geometry.spacing=0.05"]),
    ("manufactured", None, &["geometry.points=[8, 8]"]),
    ("natural-fractures", None, &["geometry.spacing=0.1"]),
    (
        "natural-fractures",
        Some("smoke"),
        &["geometry.spacing=0.06"],
    ),
    ("notched-shear", None, &["geometry.points=[12, 12]"]),
    (
        "notched-tension",
        Some("paper"),
        &["geometry.points=[12, 12]", "damage.length_scale=0.4 mm"],
    ),
    ("penny-3d", None, &["geometry.points=[4, 4, 4]"]),
    ("pressurised-notch", None, &["geometry.spacing=0.05"]),
    ("reservoir-3d", None, &["geometry.points=[8, 8, 6]"]),
    ("sneddon", None, &["geometry.spacing=0.05"]),
    ("terzaghi", None, &["geometry.spacing=0.5"]),
    (
        "terzaghi",
        None,
        &["geometry.spacing=0.5", "scheme.name=staggered"],
    ),
    (
        "terzaghi",
        None,
        &["geometry.spacing=0.5", "scheme.name=explicit"],
    ),
    ("terzaghi-graded", None, &["geometry.spacing=1"]),
    (
        "terzaghi-tensor",
        None,
        &["geometry.axes=[[{length=15, spacing=[0.25, 1]}], [{length=1, spacing=0.5}]]"],
    ),
    ("theis", None, &["geometry.points=[10, 10]"]),
    ("two-layer", None, &["geometry.points=[8, 2]"]),
];

/// Tables of sound scenes.
pub fn bases() -> Vec<Table> {
    let table = |(case, variant, sets): &(&str, Option<&str>, &[&str])| {
        let layers = cases::find(case).unwrap().layers(*variant).unwrap();
        let layers: Vec<(&str, &str)> =
            layers.iter().map(|(name, text)| (&**name, *text)).collect();
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = scene::load_layers(&layers, Path::new(""), &sets)
            .unwrap_or_else(|errors| panic!("{case}: {errors}"));
        loaded.resolved_toml().parse().unwrap()
    };
    SMALL.iter().map(table).collect()
}
