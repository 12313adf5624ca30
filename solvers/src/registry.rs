//! The table of backends and the options they accept.

use crate::krylov::{bicgstab, conjugate_gradient, gmres, minres};
use crate::problem::Symmetry;
use crate::{
    Lattice, LinearSolver, SolveError, SpecError, auto, faer_ldlt, faer_llt, faer_lu, fourier,
    petsc, system,
};

/// Every backend that can be chosen by name.
pub const BACKENDS: &[Backend] = &[
    auto::BACKEND,
    faer_llt::BACKEND,
    faer_ldlt::BACKEND,
    conjugate_gradient::BACKEND,
    faer_lu::BACKEND,
    fourier::BACKEND,
    minres::BACKEND,
    gmres::BACKEND,
    gmres::FLEXIBLE_BACKEND,
    bicgstab::BACKEND,
    petsc::BACKEND,
];

/// A solver that can be chosen by name.
#[derive(Debug, Clone, Copy)]
pub struct Backend {
    /// Name in a [`crate::SolverSpec`].
    pub name: &'static str,
    /// One line on the method.
    pub summary: &'static str,
    /// Kinds of systems it solves.
    pub symmetries: &'static [Symmetry],
    /// Whether several processes may share a system.
    pub distributed: bool,
    /// Whether points must be a lattice that separates, see [`Lattice::separates`].
    pub lattices_only: bool,
    /// Options it accepts.
    pub options: &'static [OptionSpec],
    /// Builds the solver from its options.
    pub build: fn(&Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError>,
}

/// An option of a backend.
#[derive(Debug, Clone, Copy)]
pub struct OptionSpec {
    /// Name before the `=`.
    pub key: &'static str,
    /// Kind of its value.
    pub value: OptionValue,
    /// Value where it is not given.
    pub default: &'static str,
    /// One line on what it does.
    pub meaning: &'static str,
}

/// Kind of the value of an option.
#[derive(Debug, Clone, Copy)]
pub enum OptionValue {
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// A positive, finite number.
    Positive,
    /// A positive whole number.
    Count,
    /// Flags of another program: all that stands behind the name of the backend, as it is. A
    /// backend with such an option has no other.
    Flags,
}

impl OptionValue {
    /// What is accepted, in words.
    #[must_use]
    pub fn describe(&self) -> String {
        match self {
            Self::OneOf(words) => words.join(", "),
            Self::Positive => "a positive number".into(),
            Self::Count => "a positive whole number".into(),
            Self::Flags => "flags that begin with `-`".into(),
        }
    }

    fn accepts(&self, text: &str) -> bool {
        match self {
            Self::OneOf(words) => words.contains(&text),
            Self::Positive => text
                .parse()
                .is_ok_and(|value: f64| value > 0.0 && value.is_finite()),
            Self::Count => text.parse().is_ok_and(|value: usize| value > 0),
            Self::Flags => text.is_empty() || text.starts_with('-'),
        }
    }

    fn suggestion(&self, text: &str) -> String {
        match self {
            Self::OneOf(words) => suggest(text, words),
            Self::Positive | Self::Count | Self::Flags => String::new(),
        }
    }
}

impl Backend {
    /// The backend of this name.
    ///
    /// # Errors
    /// [`SpecError::UnknownSolver`].
    pub fn find(name: &str) -> Result<&'static Self, SpecError> {
        let names: Vec<&str> = BACKENDS.iter().map(|backend| backend.name).collect();
        BACKENDS
            .iter()
            .find(|backend| backend.name == name)
            .ok_or_else(|| SpecError::UnknownSolver {
                name: name.into(),
                suggestion: suggest(name, &names),
                valid: names.join(", "),
            })
    }

    /// Whether it takes systems of a kind that so many processes share.
    ///
    /// # Errors
    /// [`SolveError::Refused`] with what to choose instead.
    pub fn takes(&self, symmetry: Symmetry, processes: usize) -> Result<(), SolveError> {
        system::admit(
            self.name,
            symmetry,
            self.symmetries,
            processes == 1 || self.distributed,
        )
    }

    /// Whether it takes points that are this lattice, or are none for this reason.
    ///
    /// # Errors
    /// [`SolveError::Refused`] with the reason.
    pub fn takes_points(
        &self,
        symmetry: Symmetry,
        lattice: Result<&Lattice, &str>,
    ) -> Result<(), SolveError> {
        let separates = |lattice: &Lattice| lattice.separates();
        match lattice.map_err(str::to_owned).and_then(separates) {
            Err(reason) if self.lattices_only => Err(SolveError::Refused {
                solver: self.name,
                symmetry,
                advice: format!("it solves on lattices of equal cells, and {reason}; use `auto`"),
            }),
            _ => Ok(()),
        }
    }

    /// The option that takes the whole text behind the name, if there is one.
    #[must_use]
    pub fn flags(&self) -> Option<&'static OptionSpec> {
        let mut options = self.options.iter();
        options.find(|option| matches!(option.value, OptionValue::Flags))
    }

    /// Checks the name and value of an option.
    ///
    /// # Errors
    /// [`SpecError::UnknownOption`] or [`SpecError::InvalidValue`].
    pub fn check_option(&self, key: &str, value: &str) -> Result<(), SpecError> {
        let Some(option) = self.options.iter().find(|option| option.key == key) else {
            return Err(self.unknown_option(key));
        };
        if option.value.accepts(value) {
            return Ok(());
        }
        Err(SpecError::InvalidValue {
            solver: self.name,
            option: option.key,
            value: value.into(),
            suggestion: option.value.suggestion(value),
            valid: option.value.describe(),
        })
    }

    fn unknown_option(&self, key: &str) -> SpecError {
        let keys: Vec<&str> = self.options.iter().map(|option| option.key).collect();
        SpecError::UnknownOption {
            solver: self.name,
            option: key.into(),
            suggestion: suggest(key, &keys),
            valid: if keys.is_empty() {
                "none".into()
            } else {
                keys.join(", ")
            },
        }
    }
}

/// The options of one specification, with the defaults of the backend behind them.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    backend: &'static Backend,
    given: &'a [(String, String)],
}

impl<'a> Options<'a> {
    /// Options given for a backend.
    #[must_use]
    pub fn new(backend: &'static Backend, given: &'a [(String, String)]) -> Self {
        Self { backend, given }
    }

    /// The value of an option as text; empty for a key the backend does not have.
    #[must_use]
    pub fn choice(&self, key: &str) -> &'a str {
        let given = self.given.iter().find(|(name, _)| name == key);
        let default = || self.backend.options.iter().find(|option| option.key == key);
        match given {
            Some((_, value)) => value,
            None => default().map_or("", |option| option.default),
        }
    }

    /// The value of an option as a number.
    ///
    /// # Errors
    /// [`SpecError::InvalidValue`] if it is none.
    pub fn number(&self, key: &'static str) -> Result<f64, SpecError> {
        self.parse(key)
    }

    /// The value of an option as a whole number.
    ///
    /// # Errors
    /// [`SpecError::InvalidValue`] if it is none.
    pub fn count(&self, key: &'static str) -> Result<usize, SpecError> {
        self.parse(key)
    }

    fn parse<T: std::str::FromStr>(&self, option: &'static str) -> Result<T, SpecError> {
        let value = self.choice(option);
        value.parse().map_err(|_| self.invalid(option))
    }

    /// The error for a value that the check of the option should have refused.
    pub(crate) fn invalid(&self, option: &'static str) -> SpecError {
        let known = self
            .backend
            .options
            .iter()
            .find(|known| known.key == option);
        SpecError::InvalidValue {
            solver: self.backend.name,
            option,
            value: self.choice(option).into(),
            suggestion: String::new(),
            valid: known.map_or_else(String::new, |known| known.value.describe()),
        }
    }
}

/// ", did you mean `…`?" for the nearest word, or nothing if none is near.
fn suggest(text: &str, words: &[&str]) -> String {
    let nearness = |word: &str| strsim::jaro_winkler(&text.to_lowercase(), word);
    let nearest = words
        .iter()
        .map(|word| (nearness(word), word))
        .filter(|(nearness, _)| *nearness > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or_else(String::new, |(_, word)| format!(", did you mean `{word}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SolverSpec;

    #[test]
    fn names_and_keys_are_unique_and_defaults_are_valid() {
        for (index, backend) in BACKENDS.iter().enumerate() {
            assert!(
                BACKENDS[..index]
                    .iter()
                    .all(|other| other.name != backend.name)
            );
            for option in backend.options {
                backend.check_option(option.key, option.default).unwrap();
            }
        }
    }

    #[test]
    fn every_backend_builds_from_its_defaults() {
        for backend in BACKENDS {
            let spec: SolverSpec = backend.name.parse().unwrap();
            assert_eq!(spec.build().unwrap().name(), backend.name);
        }
    }
}
