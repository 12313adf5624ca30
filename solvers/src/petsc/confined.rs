//! Flags of PETSc that choose a method and nothing else.
//!
//! Others read files (`-options_file`), write any file (`-ksp_view ascii:NAME`), load code or print. Whoever
//! types a command may use them; a scene that somebody else wrote may not.

/// Beginnings that name a part of a method.
const PARTS: [&str; 7] = [
    "fieldsplit_u_",
    "fieldsplit_p_",
    "fieldsplit_0_",
    "fieldsplit_1_",
    "mg_levels_",
    "mg_coarse_",
    "sub_",
];

/// Settings of Krylov methods, behind `ksp_`.
const KRYLOV: [&str; 18] = [
    "type",
    "rtol",
    "atol",
    "divtol",
    "max_it",
    "norm_type",
    "pc_side",
    "gmres_restart",
    "gmres_modifiedgramschmidt",
    "gmres_classicalgramschmidt",
    "gmres_cgs_refinement_type",
    "lgmres_augment",
    "bcgsl_ell",
    "richardson_scale",
    "chebyshev_eigenvalues",
    "chebyshev_esteig",
    "chebyshev_esteig_steps",
    "reuse_preconditioner",
];

/// Settings of preconditioners, behind `pc_`.
const PRECONDITIONER: [&str; 40] = [
    "type",
    "asm_blocks",
    "asm_overlap",
    "asm_type",
    "bjacobi_blocks",
    "factor_fill",
    "factor_levels",
    "factor_mat_ordering_type",
    "factor_mat_solver_type",
    "factor_shift_amount",
    "factor_shift_type",
    "factor_zeropivot",
    "fieldsplit_block_size",
    "fieldsplit_detect_saddle_point",
    "fieldsplit_schur_fact_type",
    "fieldsplit_schur_precondition",
    "fieldsplit_schur_scale",
    "fieldsplit_type",
    "gamg_agg_nsmooths",
    "gamg_aggressive_coarsening",
    "gamg_coarse_eq_limit",
    "gamg_process_eq_limit",
    "gamg_repartition",
    "gamg_reuse_interpolation",
    "gamg_square_graph",
    "gamg_sym_graph",
    "gamg_threshold",
    "gamg_threshold_scale",
    "gamg_type",
    "hypre_type",
    "jacobi_type",
    "mg_cycle_type",
    "mg_levels",
    "mg_multiplicative_cycles",
    "mg_type",
    "sor_its",
    "sor_lits",
    "sor_omega",
    "sor_symmetric",
    "use_amat",
];

/// Settings of hypre's multigrid, behind `pc_hypre_boomeramg_`.
const BOOMERAMG: [&str; 20] = [
    "P_max",
    "agg_nl",
    "agg_num_paths",
    "coarsen_type",
    "cycle_type",
    "grid_sweeps_all",
    "interp_type",
    "max_iter",
    "max_levels",
    "max_row_sum",
    "nodal_coarsen",
    "no_CF",
    "relax_type_all",
    "relax_type_coarse",
    "relax_type_down",
    "relax_type_up",
    "relax_weight_all",
    "strong_threshold",
    "tol",
    "truncfactor",
];

/// Settings of MUMPS, behind `mat_mumps_`: of order, pivots, memory and precision. Others open units of
/// output or keep factors in files.
const MUMPS: [&str; 16] = [
    "cntl_1", "cntl_2", "cntl_3", "cntl_4", "cntl_5", "cntl_7", "icntl_6", "icntl_7", "icntl_8",
    "icntl_10", "icntl_13", "icntl_14", "icntl_23", "icntl_24", "icntl_28", "icntl_35",
];

/// Words of the flags that are not among the settings above.
pub(crate) fn others(text: &str) -> Vec<String> {
    let words = text.split_whitespace().filter(|word| !is_confined(word));
    words.map(str::to_owned).collect()
}

fn is_confined(word: &str) -> bool {
    let is_number = word.parse::<f64>().is_ok();
    match word.strip_prefix('-').filter(|_| !is_number) {
        Some(flag) => is_setting(flag),
        // A value names a method or is a number: no file, and no viewer, which has a colon.
        None => word
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "_.,+-".contains(c)),
    }
}

fn is_setting(flag: &str) -> bool {
    let own = without_part(flag);
    let behind = |start: &str, list: &[&str]| {
        let rest = own.strip_prefix(start);
        rest.is_some_and(|rest| list.contains(&rest))
    };
    behind("ksp_", &KRYLOV)
        || behind("pc_", &PRECONDITIONER)
        || behind("pc_hypre_boomeramg_", &BOOMERAMG)
        || behind("mat_mumps_", &MUMPS)
}

/// The flag as the part itself reads it.
fn without_part(flag: &str) -> &str {
    let rest = PARTS.iter().find_map(|part| flag.strip_prefix(part));
    let Some(rest) = rest else {
        return flag;
    };
    // Levels may be numbered, as in `-mg_levels_1_pc_type`.
    let numbered = rest.trim_start_matches(|c: char| c.is_ascii_digit());
    without_part(match numbered.strip_prefix('_') {
        Some(own) if numbered.len() < rest.len() => own,
        _ => rest,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_and_their_settings_are_confined() {
        for text in [
            "-ksp_type cg -pc_type hypre -ksp_rtol 1e-9",
            "-pc_type lu -pc_factor_mat_solver_type mumps -mat_mumps_icntl_14 100",
            "-mg_levels_ksp_type chebyshev -mg_levels_1_pc_type sor -mg_coarse_sub_pc_type lu",
            "-fieldsplit_u_pc_gamg_threshold -1 -ksp_chebyshev_eigenvalues 0.1,1.1",
            "-pc_hypre_boomeramg_strong_threshold 0.5",
            "",
        ] {
            assert!(others(text).is_empty(), "{text}: {:?}", others(text));
        }
    }

    #[test]
    fn what_reads_or_writes_files_prints_or_is_unknown_is_not() {
        for (text, named) in [
            ("-ksp_view ascii:/tmp/a", "-ksp_view"),
            ("-ksp_type cg --options_file x", "--options_file"),
            ("-options_file /etc/passwd", "-options_file"),
            ("-mg_levels_options_file x", "-mg_levels_options_file"),
            ("-ksp_monitor", "-ksp_monitor"),
            ("-mat_mumps_icntl_22 1", "-mat_mumps_icntl_22"),
            ("-mat_mumps_ooc_tmpdir x", "-mat_mumps_ooc_tmpdir"),
            ("-pc_python_type a.b", "-pc_python_type"),
            ("-pc_type ../lib", "../lib"),
            ("-ksp_type ascii:x", "ascii:x"),
            ("-KSP_VIEW x", "-KSP_VIEW"),
        ] {
            assert_eq!(others(text)[0], named, "{text}");
        }
    }
}
