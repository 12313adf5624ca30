//! Explanations of coupled and of purely mechanical plans.

use std::path::Path;

use super::*;
use crate::model::Model;
use crate::plan::resolve;
use crate::report::Timers;
use crate::scene;

const TERZAGHI: &str = include_str!("../../cases/terzaghi/scene.toml");

/// A loaded block that nothing flows through, small enough for every point to be sampled.
const SOLID: &str = r#"title = "Solid"
[geometry]
type = "lattice"
size = [6, 4]
points = [6, 4]
[materials.rock]
youngs_modulus = "10 GPa"
poissons_ratio = 0.25
density = "2500 kg/m^3"
[gravity]
acceleration = [0, -10]
[mechanics]
body_force = [0, 1]
[mechanics.boundary]
bottom = { clamped = true }
left = { traction = [1, 0] }
[mechanics.loads.footing]
side = "top"
traction = [0, -3]
[time]
end = 1
"#;

fn plan_of(text: &str, overrides: &[&str]) -> Plan {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    let loaded = scene::load_str("test", text, Path::new(""), &overrides)
        .unwrap_or_else(|errors| panic!("{errors}"));
    resolve(&loaded, "test").unwrap_or_else(|errors| panic!("{errors}"))
}

fn solid(overrides: &[&str]) -> Explanation {
    explain(&plan_of(SOLID, overrides)).unwrap()
}

/// The bundled case without its outputs and its exact solution, which fix its extent and its times.
fn column(overrides: &[&str]) -> Plan {
    let end = TERZAGHI.find("[output]").unwrap();
    plan_of(&TERZAGHI[..end], overrides)
}

fn terzaghi(overrides: &[&str]) -> Explanation {
    explain(&column(overrides)).unwrap()
}

fn names(reasons: &[Reason]) -> Vec<&str> {
    reasons.iter().map(|reason| reason.name.as_str()).collect()
}

fn value(told: &Explanation, name: &str) -> Option<f64> {
    let found = told.numbers.iter().find(|number| number.name == name);
    found.map(|number| number.value)
}

fn limit<'a>(told: &'a Explanation, scheme: &str) -> Option<&'a Limit> {
    told.limits.iter().find(|limit| limit.scheme == scheme)
}

/// Name, unknowns, and whether it is solved and factored.
fn matrices(told: &Explanation) -> Vec<(&str, usize, bool, bool)> {
    let own = |m: &MatrixSize| (m.name, m.unknowns, m.solved, m.factor > 0);
    told.matrices.iter().map(own).collect()
}

fn close(found: Option<f64>, expected: f64) {
    let found = found.unwrap();
    assert!(
        (found / expected - 1.0).abs() < 1e-6,
        "{found} instead of {expected}"
    );
}

#[test]
fn mechanics_alone_is_explained_without_flow() {
    let told = solid(&["initial={stress={xx=-1}, stress_gradient={yy=-24999}}"]);
    assert_eq!((told.points, told.unknowns), (24, 48));
    assert_eq!(
        names(&told.effects),
        [
            "mechanics",
            "traction",
            "loads",
            "body-force",
            "weight",
            "initial-stress"
        ]
    );
    assert!(told.effects[1].why.contains("left"), "{:?}", told.effects);
    assert!(
        told.effects[2].why.contains("footing"),
        "{:?}",
        told.effects
    );
    assert!(told.operator.is_none());
    assert_eq!(told.elasticity.as_ref().unwrap().why, "two hops");
    assert_eq!(told.scheme.name, "quasi-static (newton)");
    assert_eq!(told.solver.name, "faer-llt");
    assert_eq!(matrices(&told), [("mechanics", 48, true, true)]);
    let relaxed = solid(&["scheme.name=explicit"]);
    assert_eq!(relaxed.scheme.name, "quasi-static (adr, switched)");
    assert_eq!(relaxed.solver.name, "none");
    assert!(matrices(&relaxed).is_empty());
    assert!(value(&told, "contrast").is_none() && value(&told, "Fourier").is_none());
    let text = told.to_string();
    for line in [
        "operator   elastic: two hops",
        "matrix     mechanics: 48 unknowns",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
}

/// All 24 points are sampled, so the sizes are those of the model.
#[test]
fn sizes_of_a_small_cloud_are_exact() {
    let told = solid(&[]);
    let model = Model::<2>::build(&plan_of(SOLID, &[]), &mut Timers::default()).unwrap();
    let solid = model.solid.unwrap();
    let found = (solid.elastic.around.families.bonds(), solid.stiffness.nnz());
    assert_eq!((told.bonds as usize, told.nonzeros as usize), found);
    let coupled: &[&str] = &["geometry.size=[0.4, 0.2]"];
    let model = Model::<2>::build(&column(coupled), &mut Timers::default()).unwrap();
    let (flow, solid) = (model.flow.unwrap(), model.solid.unwrap());
    let told = terzaghi(coupled);
    let nonzeros: Vec<usize> = told.matrices.iter().map(|m| m.nonzeros as usize).collect();
    let union = solid.points.union(&flow.pattern).unwrap().nonzeros();
    let found = [flow.pattern.nonzeros(), solid.stiffness.nnz(), 9 * union];
    assert_eq!(nonzeros, found);
    let families = &flow.operator.neighbourhood().families;
    assert_eq!(told.bonds as usize, families.bonds());
}

/// ρ = 2500 kg/m³ and λ + 2μ = 12 GPa (E = 10 GPa, ν = 1/4) at Δx = 1 m: 0.7 √(2500/12e9) s.
#[test]
fn waves_limit_where_the_density_is_known() {
    let expected = 0.7 * (2500.0 / 12e9_f64).sqrt();
    close(limit(&solid(&[]), "dynamic").map(|own| own.dt), expected);
    let dynamic = solid(&["mechanics.mode=dynamic", "scheme.name=explicit"]);
    close(limit(&dynamic, "dynamic").map(|own| own.dt), expected);
    assert!(limit(&dynamic, "implicit").is_none());
    assert_eq!(dynamic.scheme.name, "explicit (verlet)");
    assert!(limit(&terzaghi(&[]), "dynamic").is_none());
    // α²/s = 0.25/1.65e-10 Pa is added to λ + 2μ = 100 MPa; Δx = 0.05 m.
    let modulus = 1e8 + 0.25 / 1.65e-10;
    let wet = terzaghi(&["materials.rock.density=2000"]);
    let expected = 0.7 * 0.05 * (2000.0_f64 / modulus).sqrt();
    close(limit(&wet, "dynamic").map(|own| own.dt), expected);
}

/// Loading efficiency and c_v of Table 1; τ = 0.25/(1.65e-10 · 1e8).
#[test]
fn numbers_of_the_coupling_are_those_of_the_column() {
    let told = terzaghi(&[]);
    close(value(&told, "coupling strength"), 0.25 / 0.0165);
    close(value(&told, "loading efficiency"), 1.8761726079);
    close(value(&told, "c_v"), 0.3752345216);
    close(
        value(&told, "oscillation step"),
        0.0025 / (6.0 * 0.3752345216),
    );
    close(value(&told, "Fourier"), 60.0 * 0.3752345216 / 225.0);
    assert!(value(&told, "Poisson's ratio").is_none());
    let soft = terzaghi(&["materials.rock.poissons_ratio=0.49"]);
    close(value(&soft, "Poisson's ratio"), 0.49);
    let eq_71 = limit(&told, "lagged strain").unwrap();
    close(Some(eq_71.dt), 0.5 * 0.0025 / 0.3752345216);
    assert!(eq_71.limiter.contains("Eq. 71"), "{}", eq_71.limiter);
    let steady = terzaghi(&["time.mode=steady"]);
    assert!(steady.limits.is_empty() && value(&steady, "c_v").is_none());
}

/// The split adds β α²/(λ + 2μ/D) to s; with ν = 0 in the plane λ + μ = 50 MPa.
#[test]
fn the_explicit_limit_counts_what_the_split_stores() {
    let dt = |set: &str| {
        limit(&terzaghi(&[set]), "explicit")
            .map(|own| own.dt)
            .unwrap()
    };
    let (split, bare) = (dt("scheme.relaxation=1"), dt("scheme.relaxation=0"));
    let expected = (1.65e-10 + 0.25 / 5e7) / 1.65e-10;
    close(Some(split / bare), expected);
}

#[test]
fn effects_and_matrices_depend_on_the_scheme() {
    let told = terzaghi(&[]);
    assert_eq!(
        names(&told.effects),
        ["flow", "mechanics", "traction", "coupling"]
    );
    let scheme = |name: &str| terzaghi(&[&format!("scheme.name={name}")]);
    for name in ["implicit", "monolithic"] {
        let told = scheme(name);
        assert_eq!((told.points, told.unknowns), (6000, 18000));
        assert_eq!(told.scheme.name, "monolithic tr-bdf2");
        assert_eq!(told.solver.name, "fourier");
        assert!(
            told.solver.why.contains("18000 unknowns"),
            "{:?}",
            told.solver
        );
        let expected = [
            ("flow", 6000, false, false),
            ("mechanics", 12000, false, false),
            ("monolithic", 18000, true, true),
        ];
        assert_eq!(matrices(&told), expected);
    }
    for (name, flow, solid, solver) in [
        ("staggered", true, true, "fourier"),
        ("semi-implicit", true, false, "fourier"),
        ("explicit", false, false, "none"),
    ] {
        let told = scheme(name);
        let all = [("flow", 6000, flow, flow), ("mechanics", 12000, true, true)];
        // Where nothing solves for it no stiffness is held.
        let expected = &all[..1 + usize::from(solid)];
        assert_eq!(matrices(&told), expected, "{name}");
        assert_eq!(told.solver.name, solver, "{name}");
        assert!(told.scheme.name.starts_with(name), "{}", told.scheme.name);
    }
    let why = scheme("staggered").solver.why;
    assert!(
        why.contains("flow: 6000 unknowns") && why.contains("mechanics: 12000 unknowns"),
        "{why}"
    );
    let steady = terzaghi(&["time.mode=steady"]);
    assert_eq!(
        steady.matrices.iter().map(|m| m.solved).collect::<Vec<_>>(),
        [true, true]
    );
}

#[test]
fn a_split_that_diverges_is_warned_of() {
    let warned = |sets: &[&str]| terzaghi(sets).warnings;
    for scheme in ["explicit", "semi-implicit", "staggered"] {
        let name = format!("scheme.name={scheme}");
        assert_eq!(
            warned(&[&name, "scheme.relaxation=0"]),
            [
                "scheme.relaxation = 0 with coupling strength 15.2: the split alone diverges above \
                 1; set scheme.relaxation = 1"
            ]
        );
        assert!(warned(&[&name]).is_empty());
        let stiff = "materials.rock.youngs_modulus=10 GPa";
        assert!(warned(&[&name, "scheme.relaxation=0", stiff]).is_empty());
    }
    assert!(warned(&["scheme.relaxation=0"]).is_empty());
}

/// E = 10 GPa, G_c = 50 J/m², ℓ = 2 m, and a horizon of 3.1 m.
const BREAKING: &[&str] = &[
    "damage.model=paper",
    "damage.length_scale=2",
    "materials.rock.fracture_energy=50",
    "horizon.radius=3.1",
];

/// σ_c = (3√3/16) √(2 E G_c/ℓ) and ε_c = √(2 G_c/(3 E ℓ)).
#[test]
fn numbers_of_damage_are_those_of_a_bar() {
    let told = solid(BREAKING);
    // Horizons have room for rounding.
    let width: f64 = 3.1 * (1.0 + 1e-6);
    close(value(&told, "2δ/ℓ"), width);
    let energy = value(&told, "effective fracture energy of rock");
    close(energy, 50.0 * width);
    let stress = 3.0 * 3.0_f64.sqrt() / 16.0 * (2.0 * 1e10 * 50.0_f64 / 2.0).sqrt();
    close(value(&told, "critical stress σ_c of rock"), stress);
    let strain = (2.0_f64 * 50.0 / (3.0 * 1e10 * 2.0)).sqrt();
    close(value(&told, "critical strain ε_c of rock"), strain);
    assert_eq!(
        told.warnings,
        [
            "a crack takes 2δ/ℓ = 3.1 times the fracture energy; set damage.normalise = \"mean\", \
             or tie the horizon to ℓ with horizon.length_scale_ratio = 0.5"
        ]
    );
    let own = solid(&[BREAKING, &["damage.normalise=true"]].concat());
    assert!(own.warnings.is_empty());
    close(value(&own, "effective fracture energy of rock"), 50.0);
    let weaker = 1.0 / width.sqrt();
    close(value(&own, "critical stress σ_c of rock"), stress * weaker);
    close(value(&own, "critical strain ε_c of rock"), strain * weaker);
    assert!(value(&solid(&[]), "2δ/ℓ").is_none());
}

/// On a lattice of δ = 2.3 Δx with ν = 0.3 effective widths over 2δ are 0.825, 0.878 and 0.893 at least, on
/// average and at most (a separate program).
#[test]
fn the_toughness_over_directions_is_that_of_the_widths_of_families() {
    let ratio = &["horizon={ratio = 2.3}", "materials.rock.poissons_ratio=0.3"];
    let told = |normalise: &str| solid(&[BREAKING, ratio, &[normalise]].concat());
    let extremes =
        |told: &Explanation| ["G/G_c, least", "G/G_c, most"].map(|name| value(told, name).unwrap());
    let near = |found: [f64; 2], expected: [f64; 2]| {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
        }
    };
    let nominal = told("damage.normalise=true");
    near(extremes(&nominal), [0.825, 0.893]);
    let off = told("damage.normalise=false");
    let width = value(&off, "2δ/ℓ").unwrap();
    near(extremes(&off), [0.825, 0.893].map(|share| share * width));
    let mean = told("damage.normalise=\"mean\"");
    near(extremes(&mean), [0.825 / 0.878, 0.893 / 0.878]);
    close(value(&mean, "effective fracture energy of rock"), 50.0);
    let stress = |told: &Explanation| value(told, "critical stress σ_c of rock").unwrap();
    near(
        [stress(&mean) / stress(&nominal); 2],
        [0.878_f64.powf(-0.5); 2],
    );
    assert!(mean.warnings.is_empty(), "{:?}", mean.warnings);
    let coarse = solid(
        &[
            BREAKING,
            &["horizon={ratio = 2.9}", "damage.normalise=true"],
        ]
        .concat(),
    );
    assert!(coarse.warnings[0].starts_with("at δ/Δx = 2.90 paths and toughness"));
    assert_eq!(coarse.warnings.len(), 1);
}

#[test]
fn damage_is_among_the_effects_and_in_the_scheme() {
    let told = solid(BREAKING);
    let effect = |told: &Explanation, name: &str| {
        let found = told.effects.iter().find(|effect| effect.name == name);
        found.map(|effect| effect.why.clone())
    };
    let why = effect(&told, "damage").unwrap();
    let model = "[damage] is there, model of the paper, split spectral (known against it: ";
    assert!(why.starts_with(model), "{why}");
    let split = solid(&[BREAKING, &["damage.model=split"]].concat());
    assert_eq!(
        effect(&split, "damage").unwrap(),
        "[damage] is there, model split, normalised by mean widths of families"
    );
    assert_eq!(told.scheme.name, "quasi-static (newton or alternate)");
    assert_eq!(
        told.scheme.why,
        "equilibrium with damage after each step, steps free to grow, cut where damage grows by \
         more than 0.3 in one"
    );
    let steady = solid(
        &[
            BREAKING,
            &["time={mode = \"steady\"}", "damage.method=newton"],
        ]
        .concat(),
    );
    let why = "time.mode = \"steady\": one equilibrium with damage (newton), no time loop";
    assert_eq!(steady.scheme.why, why);
    let text = told.to_string();
    let line = "number     2δ/ℓ = 3.100e0, width of a crack";
    assert!(text.contains(line), "{text}");
}

#[test]
fn cracks_are_told_by_kind_and_with_their_fluid() {
    let sets: &[&str] = &[
        "fluid.viscosity=1 cP",
        "flow={}",
        "coupling={}",
        "fracture_flow={}",
        "materials.rock.permeability=1 mD",
        "materials.rock.storage=1e-10",
        "materials.rock.biot_coefficient=0.8",
        "cracks.a={kind = \"damaged\", points = [[2, 2], [4, 2]], pressure = 0}",
        "cracks.b={kind = \"damaged\", points = [[2, 1], [4, 1]], injection = {rate = 1, at = \
         [3, 1]}}",
    ];
    let light = SOLID.replace("[gravity]\nacceleration = [0, -10]\n", "");
    let plan = plan_of(&light, &[BREAKING, sets].concat());
    let told = effects::effects(&plan);
    let why = |name: &str| {
        let found = told.iter().find(|effect| effect.name == name);
        found.map(|effect| effect.why.as_str())
    };
    assert!(why("cracks").is_none());
    assert_eq!(
        why("damaged-cracks"),
        Some("[cracks] names, as damaged, a, b")
    );
    assert_eq!(
        why("crack-pressure"),
        Some("the pressure of the fluid is prescribed in a")
    );
    assert_eq!(
        why("fracture-flow"),
        Some("[fracture_flow] is there, aperture normal, transmissivity cubic")
    );
    assert_eq!(why("injection"), Some("there is an injection into b"));
    let boils = |set: &[&str]| {
        let plan = plan_of(&light, &[BREAKING, sets, &["damage={}"], set].concat());
        let told = effects::effects(&plan);
        let found = told.iter().find(|effect| effect.name == "fracture-flow");
        found.map(|effect| effect.why.clone()).unwrap()
    };
    let at =
        |boils: &str| format!("[fracture_flow] is there, residual aperture 1e-5 m, fluid {boils}");
    assert_eq!(boils(&[]), at("boils at 0 Pa"));
    assert_eq!(boils(&["flow.suction=true"]), at("never boils"));
    let limit = ["flow.suction=true", "fluid.cavitation_pressure=-90 kPa"];
    assert_eq!(boils(&limit), at("boils at -90000 Pa"));
    let scheme = scheme::scheme(&plan);
    assert_eq!(scheme.name, "monolithic backward-euler");
}

/// Where rock varies the least and the most of all points are told, and never one value for all.
#[test]
fn strengths_of_a_field_are_ranges() {
    let named = |own: &Explanation, name: &str| {
        let found = own.numbers.iter().find(|number| number.name == name);
        found.map(|number| number.value)
    };
    let value = explain(&plan_of(SOLID, BREAKING)).unwrap();
    let energy = "materials.rock.fracture_energy={distribution = \"log-normal\", median = 50, log10_std = 0.2, \
                  decades = 0.4, seed = 2}";
    let field = explain(&plan_of(SOLID, &[BREAKING, &[energy]].concat())).unwrap();
    for what in [
        "effective fracture energy",
        "critical stress σ_c",
        "critical strain ε_c",
    ] {
        let single = named(&value, &format!("{what} of rock")).unwrap();
        let [least, most] =
            ["least", "most"].map(|end| named(&field, &format!("{what} of rock, {end}")).unwrap());
        assert!(
            least < single && single < most,
            "{what}: {least} {single} {most}"
        );
        assert!(named(&field, &format!("{what} of rock")).is_none());
        // Stress and strain go with the root of the energy; 0.4 decades in all.
        assert!(most / least <= 10_f64.powf(0.4) * (1.0 + 1e-12));
    }
}
