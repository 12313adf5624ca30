//! Flags of PETSc: what the user gave, and what is chosen where nothing was given.

use crate::SpecError;
use crate::problem::{NearNullspace, Problem, Symmetry};

/// Relative residual to reach where none is asked for.
const TOLERANCE: f64 = 1e-12;
/// Positive definite systems up to this size are factorised.
const DIRECT_LIMIT: usize = 5_000;
/// Monolithic systems up to this size, in the plane and in space, are factorised.
const MONOLITHIC_LIMIT: [usize; 2] = [50_000, 15_000];
/// Methods that can judge convergence by the true residual.
const TRUE_RESIDUAL: [&str; 14] = [
    "cg",
    "pipecg",
    "groppcg",
    "fcg",
    "gmres",
    "fgmres",
    "lgmres",
    "dgmres",
    "gcr",
    "bcgs",
    "ibcgs",
    "fbcgs",
    "richardson",
    "chebyshev",
];

/// MUMPS, with room beside its estimate, which is short for small fronts shared by processes.
const MUMPS: [(&str, &str); 2] = [
    ("-pc_factor_mat_solver_type", "mumps"),
    ("-mat_mumps_icntl_14", "100"),
];

/// Flags as typed.
#[derive(Debug, Clone)]
pub(crate) struct Flags {
    pub(crate) text: String,
    /// Flag with its dash, and value if there is one.
    pairs: Vec<(String, Option<String>)>,
}

/// What the choice of flags depends on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nature {
    pub(crate) symmetry: Symmetry,
    pub(crate) unknowns: usize,
    /// The near-nullspace consists of rigid-body modes, and coordinates are there to build them.
    pub(crate) rigid_modes: bool,
    /// The unknowns of a point are a displacement and a pressure.
    pub(crate) blocks: bool,
    /// Points lie in space.
    pub(crate) spatial: bool,
    pub(crate) processes: usize,
    pub(crate) has_mumps: bool,
    pub(crate) has_hypre: bool,
}

impl Nature {
    pub(crate) fn of(problem: &Problem<'_>, processes: usize, packages: &[&str]) -> Self {
        let dimension = problem
            .coordinates
            .map_or(0, |coordinates| coordinates.dimension);
        let rigid = problem.near_nullspace == NearNullspace::RigidModes && dimension > 0;
        Self {
            symmetry: problem.symmetry,
            unknowns: problem.unknowns(),
            rigid_modes: rigid && problem.unknowns_per_point == dimension,
            blocks: rigid && problem.unknowns_per_point == dimension + 1,
            spatial: dimension == 3,
            processes,
            has_mumps: packages.contains(&"mumps"),
            has_hypre: packages.contains(&"hypre"),
        }
    }

    fn factorisation(&self) -> &'static str {
        match self.symmetry {
            Symmetry::General => "lu",
            _ => "cholesky",
        }
    }
}

impl Flags {
    /// Splits text at blanks. A word that begins with a dash and a letter is a flag.
    pub(crate) fn parse(text: &str) -> Self {
        let mut pairs: Vec<(String, Option<String>)> = Vec::new();
        for word in text.split_whitespace() {
            let mut letters = word.chars();
            let dash = letters.next() == Some('-');
            if dash && letters.next().is_some_and(char::is_alphabetic) {
                pairs.push((word.into(), None));
            } else if let Some((_, value)) = pairs.last_mut() {
                *value = Some(word.into());
            }
        }
        Self {
            text: text.into(),
            pairs,
        }
    }

    pub(crate) fn value(&self, flag: &str) -> Option<&str> {
        let mut pairs = self.pairs.iter().rev();
        let found = pairs.find(|(name, _)| name == flag)?;
        found.1.as_deref()
    }

    pub(crate) fn has(&self, flag: &str) -> bool {
        self.pairs.iter().any(|(name, _)| name == flag)
    }

    /// The relative residual to reach.
    pub(crate) fn tolerance(&self) -> Result<f64, SpecError> {
        let Some(text) = self.value("-ksp_rtol") else {
            return Ok(TOLERANCE);
        };
        let value = text.parse().ok();
        let valid = value.filter(|value: &f64| *value > 0.0 && *value < 1.0);
        valid.ok_or_else(|| SpecError::InvalidValue {
            solver: super::NAME,
            option: "-ksp_rtol",
            value: text.into(),
            suggestion: String::new(),
            valid: "a number between 0 and 1".into(),
        })
    }

    /// Flags among these that the user gave and that are no mere requests for output.
    pub(crate) fn missed(&self, unused: &[String]) -> Vec<String> {
        let output = |name: &str| {
            let words = ["view", "monitor", "reason", "options_left"];
            words.iter().any(|word| name.contains(word))
        };
        let given = unused.iter().map(|name| format!("-{name}"));
        given
            .filter(|flag| self.has(flag) && !output(flag))
            .collect()
    }

    /// Flags for what the user left open.
    pub(crate) fn defaults(&self, nature: &Nature) -> Vec<(&'static str, String)> {
        let (method, preconditioner) = self.methods(nature);
        let mut list = vec![("-ksp_type", method.to_string())];
        if let Some(preconditioner) = preconditioner {
            list.push(("-pc_type", preconditioner.into()));
        }
        let in_use = self.value("-pc_type").or(preconditioner).unwrap_or("");
        let others: &[(&str, &str)] = match in_use {
            "lu" | "cholesky" if nature.has_mumps => &MUMPS,
            "gamg" if nature.rigid_modes => &[("-pc_gamg_threshold", "0.05")],
            "gamg" => &[("-pc_gamg_threshold", "0.03")],
            "fieldsplit" if nature.blocks => &BLOCKS,
            _ => &[],
        };
        list.extend(
            others
                .iter()
                .map(|(flag, value)| (*flag, (*value).to_string())),
        );
        if in_use == "fieldsplit" && nature.blocks {
            // On the Schur complement GAMG takes four times the iterations of hypre.
            let fluid = if nature.has_hypre { "hypre" } else { "gamg" };
            list.push(("-fieldsplit_p_pc_type", fluid.into()));
        }
        list.push(("-ksp_gmres_restart", "60".into()));
        list
    }

    /// Method and preconditioner that go with what is given and with the system.
    fn methods(&self, nature: &Nature) -> (&'static str, Option<&'static str>) {
        let definite = nature.symmetry == Symmetry::PositiveDefinite;
        let iterative = if definite { "cg" } else { "fgmres" };
        match (self.value("-ksp_type"), self.value("-pc_type")) {
            (_, Some("lu" | "cholesky")) => ("preonly", None),
            (_, Some(_)) => (iterative, None),
            (Some("preonly"), None) => ("preonly", Some(nature.factorisation())),
            (Some(_), None) => (iterative, nature.preconditioner()),
            (None, None) if nature.direct() => ("preonly", Some(nature.factorisation())),
            (None, None) => (iterative, nature.preconditioner()),
        }
    }
}

impl Nature {
    /// Whether a factorisation is the better choice.
    fn direct(&self) -> bool {
        let possible = self.has_mumps || self.processes == 1;
        match self.symmetry {
            Symmetry::PositiveDefinite => possible && self.unknowns <= DIRECT_LIMIT,
            Symmetry::QuasiDefinite if self.blocks && self.has_hypre => {
                possible && self.unknowns <= MONOLITHIC_LIMIT[usize::from(self.spatial)]
            }
            _ => possible,
        }
    }

    /// Preconditioner of an iterative method; nothing leaves the choice to PETSc.
    fn preconditioner(&self) -> Option<&'static str> {
        match self.symmetry {
            Symmetry::PositiveDefinite => Some("gamg"),
            _ if self.blocks => Some("fieldsplit"),
            _ => None,
        }
    }
}

/// Blocks of displacement (`u`) and pressure (`p`): multigrid on the first, and on the Schur
/// complement with the inverse of the first replaced by that of its diagonal.
const BLOCKS: [(&str, &str); 7] = [
    ("-pc_fieldsplit_type", "schur"),
    ("-pc_fieldsplit_schur_fact_type", "upper"),
    ("-pc_fieldsplit_schur_precondition", "selfp"),
    ("-fieldsplit_u_ksp_type", "preonly"),
    ("-fieldsplit_u_pc_type", "gamg"),
    ("-fieldsplit_u_pc_gamg_threshold", "0.05"),
    ("-fieldsplit_p_ksp_type", "preonly"),
];

/// Whether a method can judge convergence by the true residual.
pub(crate) fn knows_true_residual(method: &str) -> bool {
    TRUE_RESIDUAL.contains(&method)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NATURE: Nature = Nature {
        symmetry: Symmetry::PositiveDefinite,
        unknowns: 1_000_000,
        rigid_modes: true,
        blocks: false,
        spatial: false,
        processes: 4,
        has_mumps: true,
        has_hypre: true,
    };

    /// Method and preconditioner that result from flags.
    fn chosen(text: &str, nature: Nature) -> (String, String) {
        let flags = Flags::parse(text);
        let defaults = flags.defaults(&nature);
        let default = |flag| defaults.iter().find(|(name, _)| *name == flag);
        let value = |flag| {
            let default = default(flag).map(|(_, value)| value.as_str());
            flags.value(flag).or(default).unwrap_or("").to_string()
        };
        (value("-ksp_type"), value("-pc_type"))
    }

    fn pair(method: &str, preconditioner: &str) -> (String, String) {
        (method.into(), preconditioner.into())
    }

    #[test]
    fn words_that_begin_with_a_dash_and_a_letter_are_flags() {
        let flags = Flags::parse("-pc_gamg_threshold -1  -ksp_view -ksp_type cg -ksp_type minres");
        assert_eq!(flags.value("-pc_gamg_threshold"), Some("-1"));
        assert_eq!(flags.value("-ksp_view"), None);
        assert_eq!(flags.value("-ksp_type"), Some("minres"));
        assert!(flags.has("-ksp_view") && !flags.has("-1"));
        let unused = ["ksp_view", "ksp_type", "pc_type"].map(String::from);
        assert_eq!(flags.missed(&unused), ["-ksp_type"]);
    }

    #[test]
    fn large_systems_are_iterated_and_small_ones_factorised() {
        assert_eq!(chosen("", NATURE), pair("cg", "gamg"));
        let small = Nature {
            unknowns: 3_000,
            ..NATURE
        };
        assert_eq!(chosen("", small), pair("preonly", "cholesky"));
        let no_package = Nature {
            has_mumps: false,
            ..small
        };
        assert_eq!(chosen("", no_package), pair("cg", "gamg"));
        let general = Nature {
            symmetry: Symmetry::General,
            ..NATURE
        };
        assert_eq!(chosen("", general), pair("preonly", "lu"));
        let monolithic = Nature {
            symmetry: Symmetry::QuasiDefinite,
            blocks: true,
            rigid_modes: false,
            unknowns: 20_000,
            ..NATURE
        };
        assert_eq!(chosen("", monolithic), pair("preonly", "cholesky"));
        let spatial = Nature {
            spatial: true,
            ..monolithic
        };
        assert_eq!(chosen("", spatial), pair("fgmres", "fieldsplit"));
    }

    #[test]
    fn what_is_given_is_completed_by_what_goes_with_it() {
        assert_eq!(chosen("-pc_type hypre", NATURE), pair("cg", "hypre"));
        assert_eq!(chosen("-pc_type lu", NATURE), pair("preonly", "lu"));
        let preonly = chosen("-ksp_type preonly", NATURE);
        assert_eq!(preonly, pair("preonly", "cholesky"));
        assert_eq!(chosen("-ksp_type minres", NATURE), pair("minres", "gamg"));
    }
}
