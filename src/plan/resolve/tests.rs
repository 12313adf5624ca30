//! Plans of mechanics, coupling and schemes, from scenes.
#![allow(clippy::float_cmp)]

use std::path::Path;

use super::*;
use crate::geometry::{Horizon, Shape};
use crate::load::Load;
use crate::plan::{
    Acceleration, ApertureRule, CrackKind, CrackPlace, CrackPlan, DamageMethod, DamageModel,
    DamagePlan, DescentSettings, EnergySplit, Exponent, FieldPlan, FractureFlowPlan,
    GradientChoice, HourglassRule, InjectionPlan, Integrator, Normalise, SchemeChoice, SolidMethod,
    StoragePlan, Support, TimeMode, TransmissivityRule,
};
use crate::scene::load_str;

/// A body that is held, and nothing else.
const SOLID: &str = r#"title = "Solid"
[geometry]
type = "lattice"
size = [1, 1]
points = [4, 4]
[materials.rock]
youngs_modulus = "10 GPa"
poissons_ratio = 0.25
[mechanics.boundary.bottom]
clamped = true
[time]
end = 1
"#;

const FLOW: &[&str] = &[
    "fluid.viscosity=1 cP",
    "flow.initial_pressure=1 bar",
    "materials.rock.permeability=1 mD",
    "materials.rock.storage=1e-10",
    "materials.rock.biot_coefficient=0.8",
];

fn resolved(text: &str, overrides: &[&str]) -> Result<Plan, SceneErrors> {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    resolve(&load_str("solid.toml", text, folder, &overrides)?, "solid")
}

fn plan(overrides: &[&str]) -> Plan {
    resolved(SOLID, overrides).unwrap_or_else(|errors| panic!("{errors}"))
}

#[test]
fn mechanics_alone_has_its_defaults_and_no_other_effect() {
    let plan = plan(&[]);
    let mechanics = plan.mechanics.unwrap();
    assert!(!mechanics.inertia && mechanics.loads.is_empty());
    assert_eq!(
        (mechanics.hourglass, mechanics.gradient),
        (1.0, GradientChoice::Auto)
    );
    assert!(mechanics.body_force.is_none());
    let clamped = Support::Prescribed(vec![Load::constant(0.0); 2]);
    let free = Support::Free;
    let sides = [&free, &free, &clamped, &free, &free, &free];
    assert!(mechanics.sides.iter().eq(sides), "{:?}", mechanics.sides);
    assert!(plan.flow.is_none() && plan.coupling.is_none() && plan.gravity.is_none());
    let rock = &plan.materials[0];
    assert!(rock.permeability.is_none() && rock.biot_coefficient.is_none());
    assert!(rock.density.is_none());
    // E = 10 GPa and ν = 1/4 give λ = μ = 4 GPa.
    let lame = rock.uniform_elasticity().unwrap().lame();
    assert!((lame.lambda - 4e9).abs() < 1.0 && (lame.mu - 4e9).abs() < 1.0);
}

#[test]
fn the_gradient_is_corrected_as_for_flow() {
    let mechanics = |set: &str| plan(&[set]).mechanics.unwrap();
    let auto = mechanics("mechanics.gradient=auto");
    assert!(auto.corrects_gradient(true, true));
    assert!(!auto.corrects_gradient(false, true) && !auto.corrects_gradient(true, false));
    assert!(!mechanics("mechanics.gradient=plain").corrects_gradient(true, true));
    let always = mechanics("mechanics.gradient=divergence-consistent");
    assert!(always.corrects_gradient(false, false));
}

#[test]
fn supports_and_loads_arrive_in_si_with_their_tables() {
    let mechanics = plan(&[
        "mechanics.mode=dynamic",
        "scheme.name=explicit",
        "materials.rock.density=2300",
        "mechanics.body_force=[\"1 kN/m^3\", 0]",
        "mechanics.boundary.left={roller = true}",
        "mechanics.boundary.right={normal_displacement = {time = [0, 2], value = [0, \"1 mm\"]}}",
        "mechanics.boundary.bottom={traction = [0, {time = [0, \"1 min\"], value = [0, \"1 kPa\"]}]}",
        "mechanics.loads.jack={side = \"bottom\", region = {type = \"disc\", centre = [0, 0], \
         radius = \"1 cm\"}, traction = [1, \"2 Pa\"]}",
    ])
    .mechanics
    .unwrap();
    assert!(mechanics.inertia);
    assert_eq!(mechanics.body_force.unwrap(), [1e3, 0.0]);
    let [left, right, bottom, top, ..] = &mechanics.sides[..] else {
        panic!("six sides")
    };
    assert_eq!(*left, Support::Roller(Load::constant(0.0)));
    assert_eq!(
        *right,
        Support::Roller(Load::table(vec![0.0, 2.0], vec![0.0, 1e-3]))
    );
    let ramp = Load::table(vec![0.0, 60.0], vec![0.0, 1e3]);
    assert_eq!(*bottom, Support::Traction(vec![Load::constant(0.0), ramp]));
    assert_eq!(*top, Support::Free);
    let jack = &mechanics.loads[0];
    assert_eq!((jack.name.as_str(), jack.side.name()), ("jack", "bottom"));
    assert!(matches!(
        jack.region,
        Some(Shape::Disc { radius: 0.01, .. })
    ));
    assert_eq!(jack.traction, [Load::constant(1.0), Load::constant(2.0)]);
}

#[test]
fn coupling_brings_the_biot_coefficient_beside_the_storage() {
    let coupled = plan(&[FLOW, &["coupling.undrained_start=false"]].concat());
    assert!(!coupled.coupling.unwrap().undrained_start);
    let rock = &coupled.materials[0];
    assert_eq!(rock.storage, StoragePlan::Given(FieldPlan::Uniform(1e-10)));
    assert_eq!(rock.biot_coefficient, Some(FieldPlan::Uniform(0.8)));
    assert!(rock.permeability.is_some());
    let started = plan(&[FLOW, &["coupling={}"]].concat());
    assert!(started.coupling.unwrap().undrained_start);
}

#[test]
fn each_scheme_has_its_name_and_integrator() {
    for name in ["implicit", "semi-implicit", "staggered", "monolithic"] {
        let set = format!("scheme.name={name}");
        let scheme = plan(&[&set, "time.integrator=backward-euler"]).scheme;
        assert_eq!(scheme.name(), name);
        assert_eq!(scheme.integrator(), Some(Integrator::BackwardEuler));
    }
    let explicit = plan(&["scheme.name=explicit"]).scheme;
    assert_eq!(
        (explicit, explicit.integrator()),
        (SchemeChoice::Explicit, None)
    );
    assert_eq!(plan(&[]).scheme, SchemeChoice::Implicit(Integrator::TrBdf2));
}

#[test]
fn scheme_options_have_defaults_and_can_be_set() {
    let default = plan(&[]).scheme_options;
    assert_eq!(
        (default.relaxation, default.acceleration),
        (1.0, Acceleration::Anderson)
    );
    assert_eq!(
        (default.coupling_tolerance, default.coupling_iterations),
        (1e-8, 100)
    );
    assert_eq!(
        (default.solid, default.adr_tolerance),
        (SolidMethod::Switched, 1e-6)
    );
    assert_eq!(
        (default.adr_iterations, default.adr_smoothing),
        (100_000, 0.5)
    );
    let set = plan(&[
        "scheme.relaxation=0",
        "scheme.acceleration=none",
        "scheme.coupling_iterations=7",
        "scheme.solid=verlet",
        "scheme.adr_smoothing=1",
    ])
    .scheme_options;
    assert_eq!(
        (set.relaxation, set.acceleration),
        (0.0, Acceleration::None)
    );
    assert_eq!(
        (set.coupling_iterations, set.solid),
        (7, SolidMethod::Verlet)
    );
    assert_eq!(set.adr_smoothing, 1.0);
}

#[test]
fn deformation_alone_may_be_steady() {
    let plan = plan(&["time.mode=steady"]);
    assert_eq!((plan.time.mode, plan.time.end), (TimeMode::Steady, 0.0));
}

#[test]
fn a_cloud_without_planes_has_no_sides_to_hold_or_load() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    std::fs::write(&file, "x,y,volume\n0,0,1\n1,0,1\n0,1,1\n1,1,1\n").unwrap();
    let text = SOLID.replace(
        "type = \"lattice\"\nsize = [1, 1]\npoints = [4, 4]",
        &format!("type = \"file\"\npath = {:?}", file.display().to_string()),
    );
    let load = "mechanics.loads.jack={side = \"top\", traction = [0, 1]}";
    let errors = resolved(&text, &[load]).unwrap_err();
    let messages: Vec<&str> = errors
        .diagnostics
        .iter()
        .map(|d| d.message.as_str())
        .collect();
    let expected = "a cloud from a file has sides only with geometry.bounds; give the bounds";
    assert_eq!(messages, [expected, expected]);
    let bounds = "geometry.bounds={min = [-0.5, -0.5], max = [1.5, 1.5]}";
    assert!(resolved(&text, &[load, bounds]).is_ok());
    let free = [
        "mechanics.mode=dynamic",
        "scheme.name=explicit",
        "mechanics.body_force=[0, 0, 0]",
    ];
    let text = text
        .replace("[mechanics.boundary.bottom]\nclamped = true\n", "")
        .replace("[materials.rock]", "[materials.rock]\ndensity = 2300");
    let errors = resolved(&text, &free).unwrap_err();
    assert_eq!(
        errors.diagnostics[0].message,
        "`body_force` needs 2 components, found 3"
    );
}

/// A body that breaks, and fluid that is pumped into a damaged crack in it.
const BROKEN: &[&str] = &[
    "materials.rock.fracture_energy=50 J/m^2",
    "coupling={}",
    "damage={model = \"paper\", length_scale = \"20 cm\", split = \"none\", normalise = true, method = \"alternate\"}",
    "fracture_flow={storage = 4e-10, viscosity = \"2 cP\", lower_threshold = 0.4}",
    "cracks.notch={kind = \"damaged\", points = [[0.3, 0.5], [0.6, 0.5]], injection = {rate = \
     \"1e-6 m^2/s\", at = [0.4, 0.5]}}",
    "horizon.length_scale_ratio=2",
    "time.end=10",
];

#[test]
fn what_breaks_arrives_in_si_with_its_defaults() {
    let plan = plan(&[FLOW, BROKEN].concat());
    assert_eq!(plan.horizon, Horizon::Radius(0.4));
    assert_eq!(
        plan.materials[0].fracture_energy,
        Some(FieldPlan::Uniform(50.0))
    );
    let damage = DamagePlan {
        model: DamageModel::Paper,
        exponent: Exponent::Two,
        friction: 0.6,
        length_scale: Some(0.2),
        split: EnergySplit::None,
        residual_stiffness: 1e-9,
        hourglass: HourglassRule::Variational,
        normalise: Normalise::Horizon,
        method: DamageMethod::Alternate,
        tolerance: 1e-5,
        iterations: 1000,
        largest_increment: 0.3,
        shortest_step: 0.1,
        descent: DescentSettings::default(),
    };
    assert_eq!(plan.damage, Some(damage));
    let fracture_flow = FractureFlowPlan {
        residual_aperture: 1e-5,
        aperture: ApertureRule::Normal,
        transmissivity: TransmissivityRule::Cubic,
        lower_threshold: 0.4,
        upper_threshold: 1.0,
        storage: Some(4e-10),
        biot_coefficient: 1.0,
        viscosity: Some(2e-3),
        permeability: None,
        cavitation_pressure: 0.0,
    };
    assert_eq!(plan.fracture_flow, Some(fracture_flow));
    let notch = CrackPlan {
        name: "notch".to_owned(),
        kind: CrackKind::Damaged,
        place: CrackPlace::Chain(vec![[0.3, 0.5], [0.6, 0.5]]),
        pressure: None,
        injection: Some(InjectionPlan {
            at: vec![0.4, 0.5],
            rate: Load::constant(1e-6),
        }),
    };
    assert_eq!(plan.cracks, [notch]);
    let gradient = plan.mechanics.unwrap().gradient;
    assert_eq!(gradient, GradientChoice::Plain);
    let integrator = plan.scheme.integrator();
    assert_eq!(integrator, Some(Integrator::BackwardEuler));
}

#[test]
fn a_disc_has_a_normal_of_length_one() {
    let text = SOLID
        .replace("size = [1, 1]", "size = [1, 1, 1]")
        .replace("points = [4, 4]", "points = [4, 4, 4]");
    let penny = "cracks.penny={kind = \"damaged\", pressure = \"1 MPa\", disc = {centre = [0.5, \
                 0.5, 0.5], normal = [0, 3, 4], radius = \"20 cm\"}}";
    let sets = [
        "materials.rock.fracture_energy=50",
        "damage.model=paper",
        "damage.length_scale=0.2",
        "damage.shortest_step=1 ms",
        penny,
    ];
    let plan = resolved(&text, &sets).unwrap();
    let disc = CrackPlace::Disc {
        centre: [0.5; 3],
        normal: [0.0, 0.6, 0.8],
        radius: 0.2,
    };
    assert_eq!(plan.cracks[0].place, disc);
    assert!(plan.cracks[0].points().is_empty());
    assert_eq!(plan.damage.unwrap().shortest_step, 1e-3);
    assert_eq!(plan.scheme, SchemeChoice::Implicit(Integrator::TrBdf2));
}

/// Scalars stay what they were, and storage by Eq. 38 is one number as long as nothing in it varies.
#[test]
fn storage_is_a_number_until_something_in_it_varies() {
    let porous = &[
        "fluid={viscosity = \"1 cP\", bulk_modulus = \"2 GPa\"}",
        "flow={}",
        "coupling={}",
        "materials.rock.permeability=1 mD",
        "materials.rock.porosity=0.2",
        "materials.rock.biot_coefficient=0.7",
        "materials.rock.bulk_modulus=10 GPa",
    ];
    let storage = |sets: &[&str]| {
        plan(&[&porous[..], sets].concat()).materials[0]
            .storage
            .clone()
    };
    let one = crate::material::storage_coefficient(0.2, 0.7, 1e10, 2e9);
    assert_eq!(storage(&[]), StoragePlan::Given(FieldPlan::Uniform(one)));
    let random = "materials.rock.porosity={distribution = \"log-normal\", median = 0.2, log10_std = 0.1, seed = 3, \
                  decades = 1}";
    let field = storage(&[random]);
    let StoragePlan::Porous(own) = &field else {
        panic!("{field:?}")
    };
    let drawn = FieldPlan::LogNormal {
        median: 0.2,
        log10_std: 0.1,
        decades: 1.0,
        correlation_length: None,
        seed: 3,
    };
    assert_eq!((&own.porosity, own.fluid), (&drawn, 2e9));
    assert_eq!(field.uniform(), None);
    // Four deviations below the median.
    let least = crate::material::storage_coefficient(0.2 * 10_f64.powf(-0.4), 0.7, 1e10, 2e9);
    assert!((field.least() / least - 1.0).abs() < 1e-12);
}
