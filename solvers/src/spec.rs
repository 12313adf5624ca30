//! The text that chooses a solver: `NAME[:key=value,key=value]`, or `NAME:-flag value …` for a
//! backend that passes flags on.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::registry::{Backend, Options};
use crate::{LinearSolver, SpecError};

/// A choice of backend and options, as in `faer-cg:preconditioner=stale,refactor_above=8`.
///
/// Names, options and values are checked when it is parsed. It is serialised as its text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct SolverSpec {
    name: String,
    options: Vec<(String, String)>,
}

/// What a run asks of a solver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Demand {
    /// The backend wished for.
    pub spec: SolverSpec,
    /// Right-hand sides expected per change of the values of the matrix.
    pub solves: usize,
}

impl SolverSpec {
    /// Name of the backend.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Options that were given, in the order of their keys.
    #[must_use]
    pub fn options(&self) -> &[(String, String)] {
        &self.options
    }

    /// Words of the flags given that do more than choose a method: they may read or write files. None of
    /// a backend without flags.
    #[must_use]
    pub fn unconfined_flags(&self) -> Vec<String> {
        let flags = Backend::find(&self.name).ok().and_then(Backend::flags);
        let text = flags.and_then(|flags| self.options.iter().find(|(key, _)| key == flags.key));
        text.map_or_else(Vec::new, |(_, text)| crate::petsc::others(text))
    }

    /// Builds the solver.
    ///
    /// # Errors
    /// [`SpecError`] if an option does not fit the backend.
    pub fn build(&self) -> Result<Box<dyn LinearSolver>, SpecError> {
        let backend = Backend::find(&self.name)?;
        (backend.build)(&Options::new(backend, &self.options))
    }

    /// Takes text that the backend passes on as it is.
    fn set_flags(&mut self, backend: &'static Backend, text: &str) -> Result<(), SpecError> {
        let Some(option) = backend.flags() else {
            return Ok(());
        };
        let text = text.trim();
        backend.check_option(option.key, text)?;
        if text.is_empty() {
            return Err(SpecError::Malformed {
                text: format!("{}:", backend.name),
                reason: "there are no flags",
            });
        }
        self.options.push((option.key.into(), text.into()));
        Ok(())
    }

    fn push_option(&mut self, backend: &Backend, text: &str) -> Result<(), SpecError> {
        let malformed = |reason| SpecError::Malformed {
            text: text.trim().into(),
            reason,
        };
        let (key, value) = text
            .split_once('=')
            .ok_or_else(|| malformed("there is no `=`"))?;
        let (key, value) = (key.trim(), value.trim());
        backend.check_option(key, value)?;
        if self.options.iter().any(|(other, _)| other == key) {
            return Err(malformed("the option is given twice"));
        }
        self.options.push((key.into(), value.into()));
        Ok(())
    }
}

impl Default for SolverSpec {
    fn default() -> Self {
        Self {
            name: crate::auto::BACKEND.name.into(),
            options: Vec::new(),
        }
    }
}

impl FromStr for SolverSpec {
    type Err = SpecError;

    fn from_str(text: &str) -> Result<Self, SpecError> {
        let (name, options) = match text.split_once(':') {
            Some((name, options)) => (name, Some(options)),
            None => (text, None),
        };
        let backend = Backend::find(name.trim())?;
        let mut spec = Self {
            name: backend.name.into(),
            options: Vec::new(),
        };
        if let (Some(_), Some(text)) = (backend.flags(), options) {
            spec.set_flags(backend, text)?;
            return Ok(spec);
        }
        for option in options.into_iter().flat_map(|options| options.split(',')) {
            spec.push_option(backend, option)?;
        }
        spec.options.sort_unstable();
        Ok(spec)
    }
}

impl TryFrom<String> for SolverSpec {
    type Error = SpecError;

    fn try_from(text: String) -> Result<Self, SpecError> {
        text.parse()
    }
}

impl From<SolverSpec> for String {
    fn from(spec: SolverSpec) -> Self {
        spec.to_string()
    }
}

impl fmt::Display for SolverSpec {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.name)?;
        let flags = Backend::find(&self.name).ok().and_then(Backend::flags);
        if let (Some(_), [(_, text)]) = (flags, &self.options[..]) {
            return write!(formatter, ":{text}");
        }
        for (index, (key, value)) in self.options.iter().enumerate() {
            let separator = if index == 0 { ':' } else { ',' };
            write!(formatter, "{separator}{key}={value}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> SpecError {
        text.parse::<SolverSpec>().unwrap_err()
    }

    #[test]
    fn text_survives_parsing_and_printing_with_sorted_options() {
        for text in [
            "auto",
            "faer-llt:ordering=amd",
            "faer-cg:max_iterations=7,tolerance=1e-9",
        ] {
            assert_eq!(text.parse::<SolverSpec>().unwrap().to_string(), text);
        }
        let spaced: SolverSpec = "faer-cg: tolerance = 1e-9 , max_iterations=7"
            .parse()
            .unwrap();
        assert_eq!(
            spaced.to_string(),
            "faer-cg:max_iterations=7,tolerance=1e-9"
        );
        assert_eq!(SolverSpec::default().to_string(), "auto");
    }

    #[test]
    fn flags_are_passed_on_as_they_are() {
        let text = "petsc:-ksp_type cg -pc_type hypre -a b,c=d:e";
        let spec: SolverSpec = text.replacen(':', ": ", 1).parse().unwrap();
        assert_eq!(spec.to_string(), text);
        assert_eq!(spec.options()[0].1, text["petsc:".len()..]);
        assert_eq!(spec, text.parse().unwrap());
        let missing = error("petsc:ksp_type=cg").to_string();
        assert!(missing.contains("flags that begin with `-`"), "{missing}");
        assert!(matches!(error("petsc: "), SpecError::Malformed { .. }));
    }

    #[test]
    fn serialises_as_its_text() {
        let spec: SolverSpec = "faer-cg:preconditioner=stale".parse().unwrap();
        let json = serde_json::to_string(&spec).unwrap();
        assert_eq!(json, "\"faer-cg:preconditioner=stale\"");
        assert_eq!(serde_json::from_str::<SolverSpec>(&json).unwrap(), spec);
        assert!(serde_json::from_str::<SolverSpec>("\"faer-gc\"").is_err());
    }

    #[test]
    fn mistakes_name_the_remedy() {
        let unknown = error("fear-llt").to_string();
        assert!(unknown.contains("did you mean `faer-llt`?"), "{unknown}");
        assert!(
            unknown.contains("auto, faer-llt, faer-ldlt, faer-cg"),
            "{unknown}"
        );
        let option = error("faer-cg:tolerence=1").to_string();
        assert!(option.contains("did you mean `tolerance`?"), "{option}");
        let value = error("faer-cg:preconditioner=stael").to_string();
        assert!(value.contains("did you mean `stale`?"), "{value}");
        assert!(value.contains("none, jacobi, block-jacobi, ic0"), "{value}");
    }

    #[test]
    fn wrong_values_and_forms_are_refused() {
        for text in [
            "faer-cg:tolerance=-1",
            "faer-cg:tolerance=NaN",
            "faer-cg:max_iterations=1.5",
        ] {
            assert!(
                matches!(error(text), SpecError::InvalidValue { .. }),
                "{text}"
            );
        }
        assert!(matches!(error("faer-cg:"), SpecError::Malformed { .. }));
        assert!(matches!(
            error("faer-llt:ordering=nd,ordering=nd"),
            SpecError::Malformed { .. }
        ));
        assert!(matches!(
            error("auto:tolerance=1"),
            SpecError::UnknownOption { .. }
        ));
        assert!(matches!(error(""), SpecError::UnknownSolver { .. }));
    }
}
