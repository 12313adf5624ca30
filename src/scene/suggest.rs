//! "Did you mean": the closest of the words that would have been right.

/// The option that `typed` most probably stands for, or `None` if nothing is close.
///
/// Letter case counts less than letters do, so `Mpa` finds `MPa` rather than `mPa`. On a tie
/// the earlier option wins.
pub fn closest<'a>(typed: &str, options: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = typed.to_lowercase();
    let allowed = match typed.chars().count() {
        0..=1 => 0,
        2..=4 => 1,
        5..=8 => 2,
        _ => 3,
    };
    options
        .into_iter()
        .map(|option| {
            let letters = strsim::damerau_levenshtein(&lower, &option.to_lowercase());
            (letters, strsim::damerau_levenshtein(typed, option), option)
        })
        .filter(|&(letters, _, _)| letters <= allowed)
        .min_by_key(|&(letters, exact, _)| (letters, exact))
        .map(|(_, _, option)| option)
}

/// The options as a sentence part: `` `a`, `b` or `c` ``.
pub fn one_of(options: &[&str]) -> String {
    match options {
        [] => "nothing".to_owned(),
        [only] => format!("`{only}`"),
        [first @ .., last] => {
            let first: Vec<String> = first.iter().map(|option| format!("`{option}`")).collect();
            format!("{} or `{last}`", first.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swapped_or_missing_letter_is_found() {
        let options = ["viscosity", "density", "bulk_modulus"];
        assert_eq!(closest("viscocity", options), Some("viscosity"));
        assert_eq!(closest("desnity", options), Some("density"));
        assert_eq!(closest("bulkmodulus", options), Some("bulk_modulus"));
    }

    #[test]
    fn a_word_that_is_far_from_all_options_gets_no_suggestion() {
        assert_eq!(closest("colour", ["viscosity", "density"]), None);
        assert_eq!(closest("x", ["y", "z"]), None);
    }

    #[test]
    fn the_letter_case_decides_between_equal_spellings() {
        assert_eq!(closest("Mpa", ["mPa", "MPa"]), Some("MPa"));
        assert_eq!(closest("mpa", ["MPa", "mPa"]), Some("mPa"));
    }

    #[test]
    fn lists_read_as_sentences() {
        assert_eq!(one_of(&["a"]), "`a`");
        assert_eq!(one_of(&["a", "b", "c"]), "`a`, `b` or `c`");
    }
}
