//! What a scene may say of its solver: methods, but nothing that reads or writes files.

use crate::support::{Outcome, Place};

const VIEW: &str = "petsc:-ksp_type cg -ksp_view ascii:/tmp/elsewhere";

/// The base scene with a solver of its own.
fn with_solver(name: &str) -> Place {
    let solver = format!("[solver]\nname = \"{name}\"\n[output]");
    Place::with_scene(&[("[output]", &solver)])
}

/// Whether the scene is not at fault; PETSc itself may be missing.
fn is_taken(outcome: &Outcome) -> bool {
    outcome.code != Some(3) && !outcome.stderr.contains("a scene must not")
}

#[test]
fn flags_that_reach_files_are_refused_in_a_scene_and_taken_from_the_command_line() {
    for (flags, named) in [
        (VIEW, "-ksp_view`, `ascii:/tmp/elsewhere"),
        ("petsc:-options_file here.txt", "-options_file"),
        ("petsc:-ksp_monitor", "-ksp_monitor"),
    ] {
        let place = with_solver(flags);
        for verb in ["check", "plan", "run"] {
            let outcome = place.run(&[verb, "scene.toml"]);
            assert_eq!(outcome.code, Some(3), "{outcome:?}");
            let expected = format!("error: a scene must not give a solver `{named}`");
            assert!(outcome.stderr.starts_with(&expected), "{outcome:?}");
            assert!(
                outcome.stderr.contains("--> scene.toml:18:8"),
                "{outcome:?}"
            );
            assert!(outcome.stderr.contains("--solver"), "{outcome:?}");
        }
        assert_eq!(place.list(""), ["scene.toml"]);
        let set = format!("solver.name={flags}");
        for typed in [["--solver", flags], ["--set", &set]] {
            assert!(is_taken(
                &place.run(&[&["check", "scene.toml"], &typed[..]].concat())
            ));
        }
    }
}

#[test]
fn a_base_and_a_variant_are_scenes_too() {
    let place = with_solver(VIEW);
    place.write("variant.toml", "base = \"scene.toml\"\n[time]\nend = 50\n");
    let sound = with_solver("faer-llt");
    let solver = format!("base = \"scene.toml\"\n[solver]\nname = \"{VIEW}\"\n");
    sound.write("variant.toml", solver);
    for place in [place, sound] {
        let outcome = place.run(&["check", "variant.toml"]);
        assert_eq!(outcome.code, Some(3), "{outcome:?}");
        assert!(outcome.stderr.contains("`-ksp_view`"), "{outcome:?}");
        // What the command line says takes the place of what the scene says.
        place.succeed(&["check", "variant.toml", "--solver", "faer-llt"]);
    }
}

#[test]
fn methods_and_their_numbers_are_free_in_a_scene() {
    let flags = "petsc:-ksp_type cg -ksp_rtol 1e-10 -pc_type gamg -mg_levels_ksp_max_it 3";
    assert!(is_taken(&with_solver(flags).run(&["check", "scene.toml"])));
}

/// Another library in the place of PETSc.
#[test]
fn petsc_that_cannot_be_used_is_no_fault_of_the_scene() {
    let place = with_solver("petsc");
    for library in ["/nowhere/libpetsc.so", "/proc/self/exe"] {
        let mut program = place.program(&["run", "scene.toml"]);
        let output = program.env("PERIFRAC_PETSC", library).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(
            stderr.contains("solver `petsc` cannot be used here"),
            "{stderr}"
        );
    }
}
