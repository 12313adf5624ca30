//! Machine-readable summaries.

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use super::{OutputError, write_atomically};

/// Writes `value` as indented JSON with a final newline, atomically.
///
/// JSON has no NaN or infinity: such numbers become `null`.
///
/// # Errors
/// [`OutputError::Json`] if the value cannot be serialised (for instance a map whose keys are not
/// text), else the errors of [`write_atomically`].
pub fn write_json<T: Serialize + ?Sized>(
    path: impl AsRef<Path>,
    value: &T,
) -> Result<(), OutputError> {
    let path = path.as_ref();
    let mut text = serde_json::to_string_pretty(value).map_err(|source| OutputError::Json {
        path: path.to_path_buf(),
        source,
    })?;
    text.push('\n');
    write_atomically(path, |writer: &mut dyn Write| {
        writer.write_all(text.as_bytes())
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;
    use serde_json::{Value, json};
    use std::collections::BTreeMap;

    #[test]
    fn numbers_survive_the_round_trip_to_the_last_bit() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("report.json");
        let number = 0.1 + 0.2;
        write_json(
            &path,
            &json!({ "steps": 3, "error": number, "gap": f64::NAN }),
        )
        .unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.ends_with("}\n"));
        let back: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(back["error"].as_f64(), Some(number));
        assert_eq!(back["gap"], Value::Null);
    }

    #[test]
    fn keys_that_are_not_text_leave_the_old_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("report.json");
        write_json(&path, "old").unwrap();
        let bad = BTreeMap::from([(vec![1], 2)]);
        assert!(matches!(
            write_json(&path, &bad),
            Err(OutputError::Json { .. })
        ));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "\"old\"\n");
    }
}
