//! The explanation as text for a terminal.

use std::fmt;

use super::Explanation;

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.title == self.case {
            true => writeln!(f, "{}", self.case)?,
            false => writeln!(f, "{}: {}", self.case, self.title)?,
        }
        writeln!(
            f,
            "  cloud      {} points in {}-D, Δx {}, δ {}{}",
            grouped(self.points as u64),
            self.dimension,
            range(self.spacing, "m"),
            range(self.horizon, "m"),
            if self.estimated {
                " (estimated from a small cloud like it)"
            } else {
                ""
            }
        )?;
        let materials: Vec<String> = self
            .materials
            .iter()
            .map(|(name, count)| format!("{name} ({count})"))
            .collect();
        writeln!(f, "  materials  {}", materials.join(", "))?;
        for effect in &self.effects {
            writeln!(f, "  effect     {} because {}", effect.name, effect.why)?;
        }
        for operator in self.operator.iter().chain(&self.elasticity) {
            writeln!(f, "  operator   {}: {}", operator.name, operator.why)?;
        }
        writeln!(f, "  scheme     {}: {}", self.scheme.name, self.scheme.why)?;
        writeln!(f, "  solver     {}: {}", self.solver.name, self.solver.why)?;
        writeln!(
            f,
            "  size       {} unknowns, about {} bonds, {} nonzeros",
            grouped(self.unknowns as u64),
            grouped(self.bonds),
            grouped(self.nonzeros)
        )?;
        self.matrices(f)?;
        let memory = &self.memory;
        writeln!(
            f,
            "  memory     about {} (bonds {}, gradients {}, matrices {}, factor {}, fields {}), {} at its highest",
            bytes(memory.total),
            bytes(memory.bonds),
            bytes(memory.gradients),
            bytes(memory.matrices),
            bytes(memory.factor),
            bytes(memory.fields),
            bytes(memory.peak)
        )?;
        for limit in &self.limits {
            if limit.dt.is_finite() {
                let steps = limit
                    .steps
                    .map_or(String::new(), |n| format!(" ({} steps)", grouped(n)));
                let (scheme, dt) = (&limit.scheme, limit.dt);
                writeln!(
                    f,
                    "  limit      {scheme} Δt ≤ {dt:.4e} s{steps}: {}",
                    limit.limiter
                )?;
            } else {
                writeln!(f, "  limit      {}: {}", limit.scheme, limit.limiter)?;
            }
        }
        for number in &self.numbers {
            writeln!(
                f,
                "  number     {} = {:.3e}, {}",
                number.name, number.value, number.meaning
            )?;
        }
        for warning in &self.warnings {
            writeln!(f, "  warning    {warning}")?;
        }
        Ok(())
    }
}

impl Explanation {
    /// Sizes of the single matrices, unless flow alone has the only one.
    fn matrices(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.elasticity.is_none() {
            return Ok(());
        }
        for matrix in &self.matrices {
            let use_of = match (matrix.solved, matrix.factor) {
                (false, _) => "applied only".to_owned(),
                (true, 0) => "solved without a factor".to_owned(),
                (true, levels) if matrix.factor_flops <= 0.0 => {
                    format!("multigrid {}", bytes(levels))
                }
                (true, factor) => format!(
                    "factor {}, {:.1e} operations",
                    bytes(factor),
                    matrix.factor_flops
                ),
            };
            writeln!(
                f,
                "  matrix     {}: {} unknowns, about {} nonzeros, {use_of}",
                matrix.name,
                grouped(matrix.unknowns as u64),
                grouped(matrix.nonzeros)
            )?;
        }
        Ok(())
    }
}

fn range([low, high]: [f64; 2], unit: &str) -> String {
    let shown = |value: f64| match value < 1e-2 {
        true => format!("{value:.3e}"),
        false => format!("{value:.4}"),
    };
    match (high - low).abs() <= 1e-9 * high {
        true => format!("{} {unit}", shown(high)),
        false => format!("{}…{} {unit}", shown(low), shown(high)),
    }
}

/// Digits in groups of three.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> = digits
        .as_bytes()
        .rchunks(3)
        .rev()
        .map(|group| std::str::from_utf8(group).unwrap_or_default())
        .collect();
    groups.join(" ")
}

/// A size for people: `1.20 GB`, `3.4 MB`, `5 kB`.
pub fn bytes(count: u64) -> String {
    let count = count as f64;
    match count {
        c if c >= 1e9 => format!("{:.2} GB", c / 1e9),
        c if c >= 1e6 => format!("{:.1} MB", c / 1e6),
        c => format!("{:.0} kB", c / 1e3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_and_bytes_scaled() {
        assert_eq!(grouped(1_234_567), "1 234 567");
        assert_eq!(grouped(40), "40");
        assert_eq!(bytes(2_500_000), "2.5 MB");
        assert_eq!(range([0.1, 0.1], "m"), "0.1000 m");
        assert_eq!(range([1.8382e-6, 2.5], "m"), "1.838e-6…2.5000 m");
    }
}
