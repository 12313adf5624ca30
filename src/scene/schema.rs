//! The JSON schema of the scene language, for editors.

use schemars::generate::SchemaSettings;

use super::draft::Draft;
use super::overrides::BASE;
use super::stages::STAGES;

/// The JSON schema (draft 7, which editors know best) of a scene file.
///
/// It describes keys, kinds of values, choices, and the limits of bare numbers. Units and the rules
/// between keys are checked only when a scene is loaded.
pub fn json_schema() -> serde_json::Value {
    let mut generator = SchemaSettings::draft07().into_generator();
    let mut schema = generator.root_schema_for::<Draft>().to_value();
    // Both are taken out of a file before its sections are read.
    schema["properties"][BASE] = serde_json::json!({
        "type": "string",
        "description": "Path of the scene file that this one changes, relative to it; that file may have a base itself. \
                        Sections of this file add to those of the base, and its values replace theirs.",
    });
    schema["properties"][STAGES] = serde_json::json!({
        "type": "array",
        "items": { "type": "object" },
        "description": "At the end of the file: runs that follow one another, `[[stages]]` each, with a `name` and the \
                        sections that change, as in `[stages.time]`. Each starts with the state in which the one before \
                        ended.",
    });
    schema
}

/// Where in a scene a key belongs: its paths of the fewest tables, such as `geometry.spacing`, with `NAME` for what the
/// user names; none for an unknown key.
pub(super) fn places_of(key: &str) -> Vec<String> {
    let schema = json_schema();
    let mut tables = vec![(String::new(), &schema)];
    for _ in 0..DEEPEST {
        let mut keys = Vec::new();
        for (path, table) in tables {
            add_keys(&schema, &path, table, &mut keys);
        }
        let own = |(path, _): &&(String, _)| path.rsplit('.').next() == Some(key);
        let mut places: Vec<String> = keys.iter().filter(own).map(|(p, _)| p.clone()).collect();
        if !places.is_empty() {
            places.sort_unstable();
            places.dedup();
            return places;
        }
        let inner = |(path, table): (String, _)| (format!("{path}."), table);
        tables = keys.into_iter().map(inner).collect();
    }
    Vec::new()
}

/// Tables within tables that a key is looked for in.
const DEEPEST: usize = 3;

/// Adds the keys of a table, with `path` before them, and what they hold, through references and alternatives. What the
/// user names is no table of its own.
fn add_keys<'a>(
    schema: &'a serde_json::Value,
    path: &str,
    table: &'a serde_json::Value,
    keys: &mut Vec<(String, &'a serde_json::Value)>,
) {
    if let Some(name) = table["$ref"].as_str() {
        let name = name.trim_start_matches("#/definitions/");
        add_keys(schema, path, &schema["definitions"][name], keys);
    }
    for list in ["oneOf", "anyOf", "allOf"] {
        let choices = table[list].as_array().into_iter().flatten();
        choices.for_each(|choice| add_keys(schema, path, choice, keys));
    }
    let own = table["properties"].as_object().into_iter().flatten();
    keys.extend(own.map(|(name, inner)| (format!("{path}{name}"), inner)));
    if table["additionalProperties"].is_object() {
        let named = format!("{path}NAME.");
        add_keys(schema, &named, &table["additionalProperties"], keys);
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// Every object schema that lists its properties.
    fn objects<'a>(value: &'a Value, found: &mut Vec<&'a Value>) {
        if value.get("properties").is_some_and(Value::is_object) {
            found.push(value);
        }
        match value {
            Value::Object(map) => map.values().for_each(|inner| objects(inner, found)),
            Value::Array(list) => list.iter().for_each(|inner| objects(inner, found)),
            _ => {}
        }
    }

    #[test]
    fn all_sections_are_described_and_the_needed_ones_required() {
        let schema = json_schema();
        let sections: Vec<&String> = schema["properties"].as_object().unwrap().keys().collect();
        for name in [
            "geometry",
            "flow",
            "mechanics",
            "coupling",
            "damage",
            "fracture_flow",
            "cracks",
            "wells",
            "time",
            "scheme",
            "audit",
            "output",
            "reference",
        ] {
            assert!(
                sections.iter().any(|section| *section == name),
                "{sections:?}"
            );
            assert!(
                schema["properties"][name]["description"].is_string(),
                "{name}"
            );
        }
        let required = schema["required"].as_array().unwrap();
        for name in ["geometry", "materials", "time"] {
            assert!(required.contains(&json!(name)), "{required:?}");
        }
    }

    #[test]
    fn keys_are_found_where_they_belong() {
        assert_eq!(places_of("spacing"), ["geometry.spacing"]);
        let both = ["fracture_flow.permeability", "materials.NAME.permeability"];
        assert_eq!(places_of("permeability"), both);
        assert_eq!(places_of("rate"), ["wells.NAME.rate"]);
        assert_eq!(places_of("clamped").len(), 0, "four tables deep");
        assert!(places_of("spacign").is_empty());
    }

    #[test]
    fn every_support_of_a_side_is_described() {
        let schema = json_schema();
        let mut found = Vec::new();
        objects(&schema["definitions"]["Support"], &mut found);
        let keys: Vec<&String> = found
            .iter()
            .flat_map(|object| object["properties"].as_object().unwrap().keys())
            .collect();
        let expected = [
            "free",
            "clamped",
            "roller",
            "traction",
            "displacement",
            "normal_displacement",
            "plate",
        ];
        assert_eq!(keys, expected);
    }

    /// Limits in the schema of a key, with its description.
    fn limits(schema: &Value, table: &str, key: &str) -> (Option<f64>, Option<f64>, String) {
        // Sections that every scene has are described where they stand.
        let table = match schema["properties"].get(table) {
            Some(section) => section,
            None => &schema["definitions"][table],
        };
        let found = &table["properties"][key];
        let number = |name: &str| found[name].as_f64();
        let told = found["description"].as_str().unwrap_or_default().to_owned();
        (number("minimum"), number("maximum"), told)
    }

    #[test]
    fn keys_that_tune_have_limits_and_their_reason_in_the_schema() {
        let schema = json_schema();
        for (table, key, low, high) in [
            ("Flow", "hourglass", 0.1, 10.0),
            ("Mechanics", "hourglass", 0.1, 10.0),
            ("Coupling", "stabilisation", 0.0, 10.0),
            ("Scheme", "relaxation", 0.0, 10.0),
            ("Scheme", "coupling_tolerance", 1e-14, 1e-3),
            ("Scheme", "coupling_iterations", 1.0, 1e6),
            ("Scheme", "adr_tolerance", 1e-14, 1e-5),
            ("Scheme", "adr_iterations", 1.0, 1e9),
            ("Scheme", "adr_smoothing", 1e-3, 1.0),
            ("time", "tolerance", 1e-12, 0.1),
            ("time", "safety", 1e-3, 1.0),
            ("time", "max_steps", 1.0, 1e12),
            ("Damage", "residual_stiffness", 1e-14, 1e-3),
            ("Damage", "tolerance", 1e-12, 1e-3),
            ("Damage", "iterations", 1.0, 1e6),
            ("Damage", "largest_increment", 1e-3, 1.0),
            ("FractureFlow", "lower_threshold", 0.01, 0.99),
            ("FractureFlow", "upper_threshold", 0.02, 1.0),
            ("Horizon", "neighbours", 3.0, 500.0),
            ("Horizon", "ratio", 1.0, 10.0),
            ("Refinement", "levels", 1.0, 12.0),
            ("Profile", "points", 2.0, 1e5),
            ("Material", "porosity", 0.0, 1.0),
        ] {
            let (least, most, told) = limits(&schema, table, key);
            assert_eq!((least, most), (Some(low), Some(high)), "{table}.{key}");
            assert!(told.contains(" From "), "{table}.{key}: {told}");
        }
    }

    #[test]
    fn no_table_lets_unknown_keys_pass() {
        let schema = json_schema();
        let mut found = Vec::new();
        objects(&schema, &mut found);
        assert!(found.len() > 25, "{}", found.len());
        for object in found {
            assert_eq!(object["additionalProperties"], json!(false), "{object}");
        }
    }

    #[test]
    fn what_is_taken_out_of_a_file_first_is_described_too() {
        let schema = json_schema();
        for key in ["base", "stages"] {
            assert!(
                schema["properties"][key]["description"].is_string(),
                "{key}"
            );
        }
    }

    #[test]
    fn quantities_tell_their_symbols_of_units() {
        let schema = json_schema();
        for (quantity, symbols) in [
            ("Pressure", "; symbols: Pa, bar, psi, atm"),
            ("Permeability", "; symbols: D, darcy"),
            ("Angle", "; symbols: rad, deg"),
        ] {
            let told = schema["definitions"][quantity]["description"]
                .as_str()
                .unwrap();
            assert!(told.ends_with(symbols), "{told}");
        }
        // Only products of symbols make a density.
        let told = schema["definitions"]["Density"]["description"]
            .as_str()
            .unwrap();
        assert!(!told.contains("symbols"), "{told}");
    }

    #[test]
    fn tagged_tables_name_their_type() {
        let text = json_schema().to_string();
        for name in [
            "lattice",
            "graded",
            "blocks",
            "file",
            "box",
            "disc",
            "polygon",
            "half-plane",
        ] {
            assert!(text.contains(&format!("\"const\":\"{name}\"")), "{name}");
        }
    }
}
