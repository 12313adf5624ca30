//! Loops that dominate runs: families, model, refill, product, imbalance, explicit step, triad.

mod support;

use std::hint::black_box;
use std::time::Duration;

use anyhow::Result;
use criterion::{BenchmarkGroup, Criterion, SamplingMode, Throughput, measurement::WallTime};
use perifrac::model::{build_cloud, build_families};
use perifrac::plan::Plan;
use perifrac_solvers::multiply;

use support::{
    Marcher, OPERATORS, Triad, flow, model, product_bytes, quick, refill, rough_pressure,
    step_bytes,
};

fn main() -> Result<()> {
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    for operator in &OPERATORS {
        let plan = operator.plan(quick())?;
        let mut group = criterion.benchmark_group(operator.name);
        match operator.dimension {
            2 => operator_loops::<2>(&plan, &mut group)?,
            _ => operator_loops::<3>(&plan, &mut group)?,
        }
        group.finish();
    }
    memory(&mut criterion);
    criterion.final_summary();
    Ok(())
}

type Group<'a> = BenchmarkGroup<'a, WallTime>;

fn operator_loops<const D: usize>(plan: &Plan, group: &mut Group<'_>) -> Result<()> {
    set_up::<D>(plan, group)?;
    let mut model = model::<D>(plan)?;
    group.sampling_mode(SamplingMode::Auto).sample_size(20);
    group.throughput(Throughput::Elements(flow(&model)?.pattern.nonzeros() as u64));
    group.bench_function("refill", |bench| bench.iter(|| refill(&mut model)));
    let flow = flow(&model)?;
    let pressure = rough_pressure(flow.points());
    let mut result = vec![0.0; flow.points()];
    // The view checks the whole structure, so it is made once and not measured with the product.
    let matrix = flow.matrix();
    group.throughput(Throughput::Bytes(product_bytes(flow)));
    group.bench_function("product", |bench| {
        bench.iter(|| multiply(matrix, black_box(&pressure), &mut result));
    });
    group.bench_function("imbalance", |bench| {
        bench.iter(|| flow.imbalance(0.0, black_box(&pressure), &mut result));
    });
    group.bench_function("matrix view", |bench| {
        bench.iter(|| black_box(flow.matrix()))
    });
    let mut marcher = Marcher::new(&model)?;
    let mut outcome = Ok(());
    group.throughput(Throughput::Bytes(step_bytes(flow)));
    group.bench_function("forward Euler step", |bench| {
        bench.iter(|| outcome = marcher.step(&mut model));
    });
    outcome
}

/// What happens once per run.
fn set_up<const D: usize>(plan: &Plan, group: &mut Group<'_>) -> Result<()> {
    let (cloud, _) = build_cloud::<D>(plan)?;
    build_families(plan, &cloud, None, &[])?;
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    group.throughput(Throughput::Elements(cloud.len() as u64));
    group.bench_function("families", |bench| {
        bench.iter(|| black_box(build_families(plan, &cloud, None, &[]).is_ok()));
    });
    group.bench_function("model", |bench| {
        bench.iter(|| black_box(model::<D>(plan).is_ok()))
    });
    Ok(())
}

fn memory(criterion: &mut Criterion) {
    let mut triad = Triad::new();
    let mut group = criterion.benchmark_group("memory");
    group.throughput(Throughput::Bytes(Triad::bytes()));
    group.bench_function("triad", |bench| bench.iter(|| triad.run()));
    group.finish();
}
