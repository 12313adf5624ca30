//! The small least-squares problem of GMRES: a Hessenberg matrix kept triangular by Givens
//! rotations (Saad & Schultz 1986, SIAM J. Sci. Stat. Comput. 7, 856).

/// Part of a column that counts as zero after the rotations.
const SINGULAR: f64 = 1e-13;

/// Triangular factor, rotated right-hand side and solution.
#[derive(Default)]
pub(super) struct Hessenberg {
    /// Columns one after the other, `restart + 1` entries each.
    columns: Vec<f64>,
    length: usize,
    rotations: Vec<(f64, f64)>,
    rhs: Vec<f64>,
    solution: Vec<f64>,
}

impl Hessenberg {
    pub(super) fn allocate(&mut self, restart: usize) {
        self.length = restart + 1;
        self.columns = vec![0.0; self.length * restart];
        self.rotations = vec![(1.0, 0.0); restart];
        self.rhs = vec![0.0; self.length];
        self.solution = vec![0.0; restart];
    }

    /// Begins with a residual of this norm.
    pub(super) fn begin(&mut self, norm: f64) {
        self.rhs.fill(0.0);
        self.rhs[0] = norm;
    }

    /// The entries of a column, to be filled before [`Self::push`].
    pub(super) fn column(&mut self, index: usize) -> &mut [f64] {
        &mut self.columns[index * self.length..][..index + 2]
    }

    /// Rotates the filled column. Returns whether it is independent of the earlier ones.
    pub(super) fn push(&mut self, index: usize) -> bool {
        let column = &mut self.columns[index * self.length..][..index + 2];
        let size = column
            .iter()
            .fold(0.0_f64, |norm, entry| norm.hypot(*entry));
        for (row, (cosine, sine)) in self.rotations[..index].iter().enumerate() {
            let (upper, lower) = (column[row], column[row + 1]);
            column[row] = cosine * upper + sine * lower;
            column[row + 1] = cosine * lower - sine * upper;
        }
        let (upper, lower) = (column[index], column[index + 1]);
        let pivot = upper.hypot(lower);
        // Written so that NaN counts as dependent.
        let independent = pivot > SINGULAR * size;
        if !independent {
            return false;
        }
        let (cosine, sine) = (upper / pivot, lower / pivot);
        (column[index], column[index + 1]) = (pivot, 0.0);
        self.rotations[index] = (cosine, sine);
        let head = self.rhs[index];
        self.rhs[index] = cosine * head;
        self.rhs[index + 1] = -sine * head;
        true
    }

    /// Norm of the residual after so many columns.
    pub(super) fn residual(&self, used: usize) -> f64 {
        self.rhs[used].abs()
    }

    /// Coefficients of the first `used` basis vectors.
    pub(super) fn solve(&mut self, used: usize) -> &[f64] {
        for row in (0..used).rev() {
            let known: f64 = (row + 1..used)
                .map(|column| self.columns[column * self.length + row] * self.solution[column])
                .sum();
            let pivot = self.columns[row * self.length + row];
            self.solution[row] = (self.rhs[row] - known) / pivot;
        }
        &self.solution[..used]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_residual_and_the_solution_are_those_of_the_normal_equations() {
        // Columns (1, 2), (3, 4, 5); right-hand side (7, 0, 0).
        let mut small = Hessenberg::default();
        small.allocate(2);
        small.begin(7.0);
        small.column(0).copy_from_slice(&[1.0, 2.0]);
        assert!(small.push(0));
        small.column(1).copy_from_slice(&[3.0, 4.0, 5.0]);
        assert!(small.push(1));
        // HᵀH = (5, 11; 11, 50), Hᵀb = (7, 21), determinant 129.
        let exact = [
            (50.0 * 7.0 - 11.0 * 21.0) / 129.0,
            (5.0 * 21.0 - 77.0) / 129.0,
        ];
        let left = [
            7.0 - exact[0] - 3.0 * exact[1],
            -2.0 * exact[0] - 4.0 * exact[1],
            -5.0 * exact[1],
        ];
        let found = small.solve(2).to_vec();
        assert!((found[0] - exact[0]).abs() + (found[1] - exact[1]).abs() < 1e-14);
        assert!((small.residual(2) - crate::norm2(&left)).abs() < 1e-14);
    }

    #[test]
    fn dependent_and_undefined_columns_are_refused() {
        let mut small = Hessenberg::default();
        small.allocate(2);
        small.begin(1.0);
        small.column(0).copy_from_slice(&[0.0, 0.0]);
        assert!(!small.push(0));
        small.column(0).copy_from_slice(&[f64::NAN, 1.0]);
        assert!(!small.push(0));
        small.column(0).copy_from_slice(&[1.0, 1.0]);
        assert!(small.push(0));
        small.column(1).copy_from_slice(&[2.0, 2.0, 0.0]);
        assert!(!small.push(1));
    }
}
