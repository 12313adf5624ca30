use std::sync::atomic::AtomicBool;
use perifrac::{plan, scene, run};
use perifrac::plan::*;
struct Obs;
impl run::Observer for Obs {
    fn warn(&mut self, m: &str) { eprintln!("warn {m}"); }
    fn step(&mut self, p: &run::Progress) { eprintln!("t={:.4e} dt={:.2e} steps={} rej={} it={} E={:?}", p.time, p.dt, p.steps, p.rejected, p.iterations, p.potential); }
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).unwrap();
    let get = |k: &str, d: f64| args.iter().find_map(|a| a.strip_prefix(&format!("{k}=")).map(|v| v.parse().unwrap())).unwrap_or(d);
    let loaded = scene::load_str("x.toml", &text, std::path::Path::new("."), &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut plan = plan::resolve(&loaded, "scratch").unwrap_or_else(|e| panic!("{e}"));
    let l = get("l", 0.03e-3);
    for m in &mut plan.materials { m.fracture_energy = Some(get("gc", 2700.0)); }
    plan.damage = Some(DamagePlan { length_scale: l, split: EnergySplit::Spectral, residual_stiffness: 1e-9, normalise: get("norm", 0.0) > 0.0,
        method: match get("method", 0.0) as i32 { 1 => DamageMethod::Newton, 2 => DamageMethod::Alternate, _ => DamageMethod::Auto },
        tolerance: get("tol", 1e-5), iterations: get("its", 1000.0) as usize, largest_increment: get("inc", 0.3), shortest_step: plan.time.end / get("short", 200.0) });
    if get("kind", 0.0) > 0.0 { for c in &mut plan.cracks { c.kind = CrackKind::Damaged; } }
    let out = args.iter().find_map(|a| a.strip_prefix("out="));
    let mut writer = out.map(|o| run::Writer::create(std::path::Path::new(o), "").unwrap());
    let r = run::run::<2>(&plan, writer.as_mut(), &mut Obs, &AtomicBool::new(false));
    match r { Ok((s, _)) => println!("{}", serde_json::to_string(&s).unwrap()), Err(e) => println!("ERR {e}") }
}
