//! The scene of a run on its page: materials and conditions as the scene has them.

use toml::Value;

use super::findings::Table;
use super::html::{escape, table};

/// Parts of a scene that other tables or sections of the page show.
const ELSEWHERE: [&str; 4] = ["title", "materials", "output", "base"];

/// Title of the scene; `None` without one.
pub(super) fn title(scene: &str) -> Option<String> {
    let scene: toml::Table = scene.parse().ok()?;
    scene.get("title")?.as_str().map(str::to_owned)
}

/// Tables of materials and of everything else that the scene says; nothing of a text that is no scene.
pub(super) fn tables(scene: &str) -> String {
    let Ok(scene) = scene.parse::<toml::Table>() else {
        return String::new();
    };
    let mut materials = Table::new(
        "Materials, as the scene has them",
        &["material", "property", "value"],
    );
    for (name, material) in scene
        .get("materials")
        .and_then(Value::as_table)
        .into_iter()
        .flatten()
    {
        let mut rows = Vec::new();
        flatten("", material, &mut rows);
        let own = rows
            .into_iter()
            .map(|[key, value]| vec![name.clone(), key, value]);
        materials.rows.extend(own);
    }
    let mut rest = Table::new(
        "Geometry, conditions and settings, as the scene has them",
        &["key", "value"],
    );
    for (name, part) in scene
        .iter()
        .filter(|(name, _)| !ELSEWHERE.contains(&name.as_str()))
    {
        let mut rows = Vec::new();
        flatten(name, part, &mut rows);
        rest.rows.extend(rows.into_iter().map(Vec::from));
    }
    table(&materials) + &table(&rest)
}

/// The whole text, folded.
pub(super) fn text(scene: &str) -> String {
    if scene.is_empty() {
        return String::new();
    }
    format!(
        "<details><summary>resolved.toml: running it again gives the same bits</summary>\
         <pre class=\"wide\">{}</pre></details>\n",
        escape(scene)
    )
}

fn flatten(name: &str, value: &Value, rows: &mut Vec<[String; 2]>) {
    let text = match value {
        Value::Table(table) if table.is_empty() => "given".to_owned(),
        Value::Table(table) => {
            for (key, value) in table {
                let name = match name {
                    "" => key.clone(),
                    _ => format!("{name}.{key}"),
                };
                flatten(&name, value, rows);
            }
            return;
        }
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    rows.push([name.to_owned(), text]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_and_conditions_are_told_in_the_words_of_the_scene() {
        let scene = "title = \"A <b>\"\n[materials.\"<rock>\"]\nporosity = 0.1\n[fracture_flow]\n\
                     [flow.boundary.left]\npressure = \"2 MPa\"\n";
        let tables = tables(scene);
        assert_eq!(title(scene).as_deref(), Some("A <b>"));
        for expected in [
            "&lt;rock&gt;",
            "porosity",
            "flow.boundary.left.pressure",
            "2 MPa",
            "given",
        ] {
            assert!(tables.contains(expected), "{expected}: {tables}");
        }
        assert!(!tables.contains("A &lt;b&gt;") && !tables.contains("<rock>"));
    }

    #[test]
    fn a_text_that_is_no_scene_has_no_tables() {
        assert_eq!(tables("= ["), "");
        assert_eq!(tables(""), "");
    }
}
