//! A value over time: what walls, wells and regions prescribe.

/// Piecewise linear in time, constant beyond the ends; a single entry is a constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    times: Vec<f64>,
    values: Vec<f64>,
}

impl Load {
    /// The same value for ever.
    pub fn constant(value: f64) -> Self {
        Load {
            times: Vec::new(),
            values: vec![value],
        }
    }

    /// Values at increasing times in seconds; both lists have the same length of at least one.
    pub fn table(times: Vec<f64>, values: Vec<f64>) -> Self {
        debug_assert!(times.len() == values.len() && !values.is_empty());
        Load { times, values }
    }

    /// Value at `time` seconds.
    pub fn at(&self, time: f64) -> f64 {
        let after = self.times.partition_point(|&t| t <= time);
        let last = self.values.len() - 1;
        if after == 0 || after > last {
            return self.values[after.min(last)];
        }
        let (t0, t1) = (self.times[after - 1], self.times[after]);
        let (v0, v1) = (self.values[after - 1], self.values[after]);
        v0 + (v1 - v0) * (time - t0) / (t1 - t0)
    }

    /// Times at which the slope may jump.
    pub fn breakpoints(&self) -> &[f64] {
        &self.times
    }

    /// Whether the value never changes.
    pub fn is_constant(&self) -> bool {
        self.values
            .windows(2)
            .all(|pair| pair[0].to_bits() == pair[1].to_bits())
    }

    /// Whether the value is zero at all times.
    pub fn is_zero(&self) -> bool {
        self.values.iter().all(|value| value.abs() <= 0.0)
    }

    /// All values of the table.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_its_times_and_constant_beyond() {
        let load = Load::table(vec![1.0, 3.0, 4.0], vec![10.0, 20.0, 0.0]);
        for (time, expected) in [
            (0.0, 10.0),
            (1.0, 10.0),
            (2.0, 15.0),
            (3.5, 10.0),
            (9.0, 0.0),
        ] {
            assert!((load.at(time) - expected).abs() < 1e-14, "at {time}");
        }
        assert!((Load::constant(7.0).at(-3.0) - 7.0).abs() < 1e-15);
    }
}
