//! What the table of combinations says is what happens: `check`, `plan` and `run` refuse the same scenes with
//! its words, and what it admits takes its steps.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use perifrac::plan::capability::{Feature, Features, broken, completed, features, refusals};
use perifrac::plan::{Plan, resolve_any, resolve_for};
use perifrac::run::{Interrupt, examine, run};
use perifrac::scene::{LoadedScene, SchemeName, load_str};
use perifrac::schemes;
use perifrac_solvers::BACKENDS;

/// A rock that lacks nothing, in 64 points, for two steps. Audits judge numbers, and are left out: loads that
/// meet a body without an undrained start do not balance.
const BASE: &str = r#"title = "Combined"
[geometry]
type = "lattice"
size = [1, 1]
points = [8, 8]
[horizon]
ratio = 2.3
[fluid]
viscosity = "1 cP"
[materials.rock]
permeability = "1 mD"
storage = "1e-10 1/Pa"
youngs_modulus = "10 GPa"
poissons_ratio = 0.2
biot_coefficient = 0.6
density = 2300
fracture_energy = 1e4
[audit]
mass = 1
momentum = 1
energy = 1
lag = 1
[output]
vtu = false
plots = false
"#;

const SCHEMES: [SchemeName; 5] = [
    SchemeName::Explicit,
    SchemeName::SemiImplicit,
    SchemeName::Implicit,
    SchemeName::Staggered,
    SchemeName::Monolithic,
];

/// Random triples that are tried, and the seed of the first.
const TRIPLES: u64 = 400;
const SEED: u64 = 7;

/// What a scene says to ask for a feature, where that depends on no other.
const WORDS: [(Feature, &str); 20] = [
    (Feature::HydrostaticStart, "flow.hydrostatic_start=true"),
    (
        Feature::Wells,
        "wells.w={at = [0.4, 0.4], rate = \"1e-9 m^2/s\"}",
    ),
    // Far from the sides, for oblique rock too.
    (
        Feature::KnownWells,
        "wells.w={at = [0.5, 0.5], rate = \"1e-9 m^2/s\", radius = 0.14, wellbore_radius = 1e-3}",
    ),
    (Feature::PathOperator, "flow.operator=path"),
    (
        Feature::PermeabilityTensor,
        "materials.rock.permeability={k1 = \"1 mD\", k2 = \"0.2 mD\", angle = \"30 deg\"}",
    ),
    (Feature::Gravity, "gravity.acceleration=[0, -9.81]"),
    (
        Feature::Mechanics,
        "mechanics.boundary.left={clamped = true}",
    ),
    (Feature::Dynamic, "mechanics.mode=dynamic"),
    (
        Feature::Plate,
        "mechanics.boundary.right={plate = \"-1 kN/m\"}",
    ),
    (
        Feature::MovingSide,
        "mechanics.boundary.top={normal_displacement = 1e-8}",
    ),
    (
        Feature::Loads,
        "mechanics.loads.l={side = \"bottom\", traction = [0, \"1 kPa\"]}",
    ),
    (Feature::BodyForce, "mechanics.body_force=[0, \"1 kN/m^3\"]"),
    (
        Feature::ConsistentGradient,
        "mechanics.gradient=divergence-consistent",
    ),
    (Feature::Layers, "mechanics.interfaces=laminate"),
    (Feature::Stabilisation, "coupling.stabilisation=0.5"),
    (Feature::Damage, "damage.length_scale=0.5"),
    (Feature::MixedRock, "damage.model=paper"),
    (Feature::FractureFlow, "fracture_flow.aperture=normal"),
    (Feature::Steady, "time.mode=steady"),
    (Feature::TrBdf2, "time.integrator=tr-bdf2"),
];

/// What a scene says to ask for features.
fn settings(all: &Features, scheme: SchemeName) -> Vec<String> {
    let has = |feature| all.contains(&feature);
    let own = WORDS.iter().filter(|(feature, _)| has(*feature));
    let mut set: Vec<String> = own.map(|(_, text)| (*text).to_owned()).collect();
    set.push(format!("scheme.name={}", scheme.name()));
    if has(Feature::Flow) {
        let deep = has(Feature::HydrostaticSide);
        let left = format!("{{pressure = \"1 kPa\", hydrostatic = {deep}}}");
        set.push(format!("flow.boundary.left={left}"));
    }
    if has(Feature::Coupling) {
        let start = has(Feature::UndrainedStart);
        set.push(format!("coupling.undrained_start={start}"));
    }
    if has(Feature::InitialStress) {
        set.push(in_situ(all));
    }
    if !has(Feature::Steady) {
        set.extend(["time.end=2e-5", "time.step=1e-5"].map(str::to_owned));
    }
    if !has(Feature::TrBdf2) {
        set.push("time.integrator=backward-euler".to_owned());
    }
    set.extend(cracks(all));
    set
}

/// A stress in balance with the weight, the body force and the force on the plate.
fn in_situ(all: &Features) -> String {
    let share = |feature, value: f64| if all.contains(&feature) { value } else { 0.0 };
    let xx = -1e4 + share(Feature::Plate, 9e3);
    let yy = share(Feature::BodyForce, 1e3) - share(Feature::Gravity, 2300.0 * 9.81);
    match all.contains(&Feature::InitialField) {
        true => format!(
            "initial={{kind = \"total\", stress.xx = {xx}, stress_gradient = {{yy = {yy}, zz = -10}}}}"
        ),
        false => format!("initial={{stress.xx = {xx}}}"),
    }
}

/// A pressure belongs to a crack that nothing is pumped into.
fn cracks(all: &Features) -> Vec<String> {
    let has = |feature| all.contains(&feature);
    let low = "points = [[0.3, 0.25], [0.7, 0.25]]";
    let [west, east] = [
        "points = [[0.25, 0.5], [0.45, 0.5]]",
        "points = [[0.55, 0.5], [0.75, 0.5]]",
    ];
    let pressed = ", pressure = \"1 kPa\"";
    let pumped = ", injection = {at = [0.35, 0.5], rate = \"1e-9 m^2/s\"}";
    let mut set = Vec::new();
    let mut pressure = has(Feature::CrackPressure);
    if has(Feature::CutCrack) {
        set.push(format!(
            "cracks.cut={{{low}{}}}",
            if pressure { pressed } else { "" }
        ));
        pressure = false;
    }
    if has(Feature::DamagedCrack) {
        let own = match (has(Feature::Injection), pressure) {
            (true, _) => pumped,
            (false, true) => pressed,
            _ => "",
        };
        set.push(format!("cracks.band={{kind = \"damaged\", {west}{own}}}"));
        if has(Feature::Injection) && pressure {
            set.push(format!(
                "cracks.other={{kind = \"damaged\", {east}{pressed}}}"
            ));
        }
    }
    set
}

/// Features with those that they are options of.
fn with_parents(mut all: Features) -> Features {
    while let Some(own) = (all.iter().copied())
        .find(|own| !own.part_of().is_empty() && !own.part_of().iter().any(|p| all.contains(p)))
    {
        let fluid = all.contains(&Feature::Flow) || all.contains(&Feature::FractureFlow);
        let parent = match own {
            Feature::CrackPressure if fluid => Feature::DamagedCrack,
            _ => own.part_of()[0],
        };
        all.insert(parent);
    }
    all
}

/// What differs between the table and what happens; nothing if all agree.
fn compare(all: &Features, scheme: SchemeName) -> Result<bool, String> {
    // Explicit steps have no stages.
    let mut expected = all.clone();
    if scheme == SchemeName::Explicit {
        expected.remove(&Feature::TrBdf2);
    }
    let processes = if all.contains(&Feature::Processes) {
        2
    } else {
        1
    };
    let loaded = load_str("scene", BASE, Path::new(""), &settings(all, scheme))
        .map_err(|errors| format!("not read: {errors}"))?;
    let plan = resolve_any(&loaded, "scene").map_err(|errors| format!("no plan: {errors}"))?;
    let found = features(&plan, processes);
    if found != expected {
        return Err(format!("asked for {expected:?}, found {found:?}"));
    }
    let told: BTreeSet<String> = broken(scheme, &expected)
        .map(|rule| rule.reason_for(scheme.name()))
        .collect();
    let of_scene = of_scene(&loaded, processes);
    if of_scene != told {
        return Err(format!("the scene: {of_scene:?}; the table: {told:?}"));
    }
    judge(&plan, processes)
}

/// What resolving the scene refuses.
fn of_scene(loaded: &LoadedScene, processes: usize) -> BTreeSet<String> {
    match resolve_for(loaded, "scene", processes) {
        Ok(_) => BTreeSet::new(),
        Err(errors) => {
            let faults = errors.diagnostics.into_iter();
            faults.map(|fault| fault.message).collect()
        }
    }
}

/// Whether a run was given up because strain lags behind the pressure in a crack whose faces come apart (ADR 32): no rule
/// on features can tell when they do. The way out that is named must be the scheme that needs no lag.
fn is_lagging(plan: &Plan, told: &str) -> bool {
    let lags = plan.scheme.name() != SchemeName::Monolithic.name() && plan.fracture_flow.is_some();
    lags && told.contains("--scheme monolithic")
}

/// Examines a plan and runs it: both end as the table says. Gives whether it ran.
fn judge(plan: &Plan, processes: usize) -> Result<bool, String> {
    let refusal = refusals(plan, processes).first().map(ToString::to_string);
    let end = |result: Result<(), String>| match (&refusal, result) {
        (None, Ok(())) => Ok(()),
        (Some(refusal), Err(told)) if told.ends_with(refusal.as_str()) => Ok(()),
        (refusal, result) => Err(format!("{result:?}, but the table: {refusal:?}")),
    };
    let examined = examine(plan, processes);
    end(examined.map(drop).map_err(|error| error.to_string()))
        .map_err(|why| format!("check: {why}"))?;
    // Several processes are only thought of: what one can run is run by one.
    let ran = match processes {
        1 => run(plan, None, &mut (), &Interrupt::default()).map_err(|e| e.to_string()),
        _ => {
            return end(schemes::check(plan, processes).map_err(|error| error.to_string()))
                .map(|()| refusal.is_none());
        }
    };
    match ran {
        Err(told) if is_lagging(plan, &told) => {}
        ran => end(ran.map(drop)).map_err(|why| format!("run: {why}"))?,
    }
    Ok(refusal.is_none())
}

/// Compares sets of features, each as it is and completed by what it cannot be without; gives how many were
/// compared and how many of them ran.
fn compare_all(sets: &[(Features, SchemeName)]) -> (usize, usize) {
    let (next, ran) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        let mut wrong = Vec::new();
        while let Some((all, scheme)) = sets.get(next.fetch_add(1, Ordering::Relaxed)) {
            match compare(all, *scheme) {
                Ok(started) => drop(ran.fetch_add(usize::from(started), Ordering::Relaxed)),
                Err(why) => wrong.push(format!("{} {all:?}: {why}", scheme.name())),
            }
        }
        wrong
    };
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let threads = [scope.spawn(work), scope.spawn(work)];
        let joined = threads.into_iter().map(|thread| thread.join().unwrap());
        joined.flatten().collect()
    });
    assert!(
        wrong.is_empty(),
        "{} of {} differ:\n{}",
        wrong.len(),
        sets.len(),
        wrong.join("\n")
    );
    (sets.len(), ran.into_inner())
}

/// A set of features as it is, and completed, for each of the schemes.
fn spread(sets: impl Iterator<Item = (Features, Vec<SchemeName>)>) -> Vec<(Features, SchemeName)> {
    let mut spread = BTreeSet::new();
    for (all, schemes) in sets {
        let bare = with_parents(all);
        let whole = completed(bare.clone());
        for scheme in schemes {
            let place = SCHEMES.iter().position(|own| *own == scheme).unwrap();
            spread.insert((bare.clone(), place));
            spread.insert((whole.clone(), place));
        }
    }
    let named = spread.into_iter().map(|(all, place)| (all, SCHEMES[place]));
    named.collect()
}

#[test]
fn all_pairs_of_effects_with_all_schemes_end_as_the_table_says() {
    let pairs = (0..Feature::ALL.len()).flat_map(|i| (0..=i).map(move |j| (i, j)));
    let sets = pairs.map(|(i, j)| {
        let pair = Features::from([Feature::ALL[i], Feature::ALL[j]]);
        (pair, SCHEMES.to_vec())
    });
    let (compared, ran) = compare_all(&spread(sets));
    println!("{compared} pairs with schemes, of which {ran} ran");
    assert!(ran > compared / 5, "{ran} of {compared} ran");
}

#[test]
fn random_triples_of_effects_end_as_the_table_says() {
    let mut state = SEED;
    let mut draw = |below: usize| {
        // Knuth's multiplier; the upper bits are the random ones.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let sets = (0..TRIPLES).map(|_| {
        let triple: Features = (0..3)
            .map(|_| Feature::ALL[draw(Feature::ALL.len())])
            .collect();
        (triple, vec![SCHEMES[draw(SCHEMES.len())]])
    });
    let (compared, ran) = compare_all(&spread(sets));
    println!("{compared} triples with schemes, of which {ran} ran");
    assert!(ran > compared / 10, "{ran} of {compared} ran");
}

#[test]
fn all_solvers_with_all_schemes_end_as_the_table_says() {
    let bodies = [
        &[Feature::Flow][..],
        &[Feature::Mechanics],
        &[Feature::Coupling],
        &[Feature::Damage],
        &[Feature::FractureFlow],
        &[Feature::Dynamic, Feature::Flow],
        &[Feature::Steady, Feature::Coupling],
    ];
    let mut wrong = Vec::new();
    let mut ran = 0;
    let sets = bodies.map(|body| completed(body.iter().copied().collect()));
    let own = BACKENDS.iter().filter(|backend| backend.name != "petsc");
    for (backend, all, scheme) in own.flat_map(|backend| {
        let schemes = move |all| SCHEMES.map(|scheme| (backend, all, scheme));
        sets.iter().flat_map(schemes)
    }) {
        let loaded = load_str("scene", BASE, Path::new(""), &settings(all, scheme)).unwrap();
        let mut plan = resolve_any(&loaded, "scene").unwrap();
        plan.solver = backend.name.parse().unwrap();
        match judge(&plan, 1).and_then(|started| Ok((started, judge(&plan, 2)?))) {
            Ok((started, _)) => ran += usize::from(started),
            Err(why) => wrong.push(format!("{} {} {all:?}: {why}", backend.name, scheme.name())),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    println!("{ran} solvers with schemes ran");
    assert!(ran > 100, "{ran} ran");
}
