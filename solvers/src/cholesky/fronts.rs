//! Numeric factors front by front (Duff and Reid 1983, ACM Trans. Math. Softw. 9, 302), on the threads of the pool.
//!
//! The columns of a supernode with all of their rows form a dense front. It takes up its entries of the matrix and what its
//! children pass on, eliminates its columns, and passes on what is left of its rows. Subtrees that are worth it are
//! factorised at the same time. Which ones depends on the pattern alone, and a front adds what its children pass on in
//! their order, so that bits do not depend on the number of threads. The factor lies where faer's own factorisation puts
//! it, and faer solves with it.

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::{ldlt, llt};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::traits::RealField;
use faer::{Accum, MatMut, MatRef, Par};

use super::Kind;
use super::tree::Tree;
use crate::matrix::Rows;
use crate::parallel::Places;

/// A symmetric matrix in the order of its factor.
pub(super) struct Ordered<'a, T> {
    pub(super) rows: Rows<'a>,
    pub(super) entries: &'a [T],
    /// Row of the matrix per row of the factor, and the other way round; none where they are the same.
    pub(super) permutation: Option<(&'a [u32], &'a [u32])>,
}

impl<T: Copy> Ordered<'_, T> {
    /// Entries of a column of the factor's order: row and value.
    fn column(&self, column: usize) -> impl Iterator<Item = (usize, T)> {
        let forward = |column: usize| {
            self.permutation
                .map_or(column, |(of, _)| of[column] as usize)
        };
        let back = |row: u32| self.permutation.map_or(row, |(_, to)| to[row as usize]) as usize;
        let (starts, columns) = (self.rows.starts(), self.rows.columns());
        let row = forward(column);
        let range = starts[row] as usize..starts[row + 1] as usize;
        let entries = columns[range.clone()].iter().zip(&self.entries[range]);
        entries.map(move |(row, value)| (back(*row), *value))
    }
}

/// What a task works with.
struct Space<T> {
    /// Row of the front per row of the factor; meaningless for those that are not in it.
    local: Vec<u32>,
    memory: MemBuffer,
    /// L D of a front.
    scaled: Vec<T>,
}

/// A factorisation under way.
pub(super) struct Fronts<'a, T: RealField> {
    pub(super) tree: &'a Tree,
    pub(super) symbolic: &'a SymbolicSupernodalCholesky<u32>,
    pub(super) kind: Kind,
    pub(super) matrix: Ordered<'a, T>,
    pub(super) values: Places<T>,
}

/// Why there is no factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Failure {
    /// The pivot of this row of the factor is not positive, or zero.
    Pivot(usize),
    /// There is no memory for a front.
    Memory,
}

/// What a front passes on: lower triangle of a square by columns.
type Passed<T> = Result<Vec<T>, Failure>;

impl<T: RealField + Copy> Fronts<'_, T> {
    /// Factorises all of it.
    ///
    /// # Errors
    /// The first failure where there are several.
    pub(super) fn factorise(&self) -> Result<(), Failure> {
        let mut space = self.space();
        let heavy = self.tree.heavy(&self.tree.roots);
        let mut passed = self.side_by_side(&heavy, &mut space);
        let light = self.tree.roots.iter().filter(|root| !heavy.contains(root));
        passed.extend(light.map(|root| self.in_order(*root, &mut space)));
        first_failure(passed).map(|_| ())
    }

    fn space(&self) -> Space<T> {
        let symbolic = self.symbolic;
        let bounds = symbolic
            .supernode_begin()
            .iter()
            .zip(symbolic.supernode_end());
        let widest = bounds.map(|(begin, end)| end - begin).max().unwrap_or(0);
        Space {
            local: vec![0; symbolic.nrows()],
            memory: MemBuffer::new(scratch::<T>(self.kind, widest as usize)),
            scaled: Vec::new(),
        }
    }

    /// What several subtrees pass on, in their order.
    fn side_by_side(&self, nodes: &[u32], space: &mut Space<T>) -> Vec<Passed<T>> {
        match nodes {
            [] => Vec::new(),
            [node] => vec![self.subtree(*node, space)],
            _ if rayon::current_num_threads() == 1 => nodes
                .iter()
                .map(|node| self.subtree(*node, space))
                .collect(),
            _ => {
                let (one, other) = nodes.split_at(nodes.len() / 2);
                let (mut one, other) = rayon::join(
                    || self.side_by_side(one, &mut self.space()),
                    || self.side_by_side(other, space),
                );
                one.extend(other);
                one
            }
        }
    }

    /// What a subtree passes on; its heavy branches are worked on side by side.
    fn subtree(&self, top: u32, space: &mut Space<T>) -> Passed<T> {
        let mut chain = vec![top];
        let mut heavy = self.tree.heavy(self.tree.children(top));
        while let [only] = heavy[..] {
            chain.push(only);
            heavy = self.tree.heavy(self.tree.children(only));
        }
        let passed = first_failure(self.side_by_side(&heavy, space))?;
        let mut branches: Vec<(u32, Vec<T>)> = heavy.into_iter().zip(passed).collect();
        while let Some(node) = chain.pop() {
            let mut passed = Vec::with_capacity(self.tree.children(node).len());
            for child in self.tree.children(node) {
                let branch = branches.iter_mut().find(|(branch, _)| branch == child);
                passed.push(match branch {
                    Some((_, branch)) => std::mem::take(branch),
                    None => self.in_order(*child, space)?,
                });
            }
            branches = vec![(node, self.front(node, passed, space)?)];
        }
        Ok(branches.pop().map_or_else(Vec::new, |(_, passed)| passed))
    }

    /// What a subtree passes on, one front after another.
    fn in_order(&self, top: u32, space: &mut Space<T>) -> Passed<T> {
        let mut stack: Vec<Vec<T>> = Vec::new();
        for node in self.tree.subtree(top) {
            let below = stack.len() - self.tree.children(*node).len();
            let passed = stack.split_off(below);
            stack.push(self.front(*node, passed, space)?);
        }
        Ok(stack.pop().unwrap_or_default())
    }

    /// Columns of a supernode, its rows below them and where its values are.
    fn shape(&self, node: u32) -> (Range<usize>, &[u32], Range<usize>) {
        let (symbolic, node) = (self.symbolic, node as usize);
        let (begins, ends) = (symbolic.supernode_begin(), symbolic.supernode_end());
        let values = &symbolic.col_ptr_for_val()[node..];
        (
            begins[node] as usize..ends[node] as usize,
            symbolic.supernode(node).pattern(),
            values[0] as usize..values[1] as usize,
        )
    }

    /// Eliminates the columns of a supernode.
    fn front(&self, node: u32, passed: Vec<Vec<T>>, space: &mut Space<T>) -> Passed<T> {
        let (columns, below, values) = self.shape(node);
        let (width, rows) = (columns.len(), below.len());
        let height = width + rows;
        // SAFETY: the columns of a supernode are those of no other one, every front is worked on once, and the values
        // outlive the factorisation.
        let panel = unsafe { self.values.part(values) };
        let mut rest = Vec::new();
        (rest.try_reserve_exact(rows * rows)).map_err(|_| Failure::Memory)?;
        rest.resize(rows * rows, T::zero());
        self.assemble(node, passed, &mut space.local, (panel, &mut rest));
        let panel = MatMut::from_column_major_slice_mut(panel, height, width);
        let left = MatMut::from_column_major_slice_mut(&mut rest, rows, rows);
        let memory = MemStack::new(&mut space.memory);
        let par = threads(width * height * height);
        match self.kind {
            Kind::Llt => eliminate_llt(panel, left, par, memory),
            Kind::Ldlt => eliminate_ldlt(panel, left, par, (memory, &mut space.scaled)),
        }
        .map_err(|pivot| Failure::Pivot(columns.start + pivot))?;
        Ok(rest)
    }

    /// Puts the entries of the matrix and what children pass on into the columns of a front and the rest of it.
    fn assemble(
        &self,
        node: u32,
        passed: Vec<Vec<T>>,
        local: &mut [u32],
        (panel, rest): (&mut [T], &mut [T]),
    ) {
        let (columns, below, _) = self.shape(node);
        let height = columns.len() + below.len();
        let rows = columns.clone().chain(below.iter().map(|row| *row as usize));
        rows.zip(0..).for_each(|(row, at)| local[row] = at);
        panel.fill(T::zero());
        for (column, own) in columns.clone().zip(panel.chunks_mut(height)) {
            let lower = self.matrix.column(column).filter(|(row, _)| *row >= column);
            lower.for_each(|(row, value)| own[local[row] as usize] += value);
        }
        for (child, passed) in self.tree.children(node).iter().zip(passed) {
            let from = self.symbolic.supernode(*child as usize).pattern();
            add(&passed, from, local, (columns.len(), panel, rest));
        }
    }
}

fn scratch<T: RealField>(kind: Kind, width: usize) -> StackReq {
    let (par, standard) = (threads(SHARED), Default::default());
    match kind {
        Kind::Llt => llt::factor::cholesky_in_place_scratch::<T>(width, par, standard),
        Kind::Ldlt => ldlt::factor::cholesky_in_place_scratch::<T>(width, par, Default::default()),
    }
}

/// All of what was passed on, or the first failure.
fn first_failure<T>(passed: Vec<Passed<T>>) -> Result<Vec<Vec<T>>, Failure> {
    let failure = passed
        .iter()
        .filter_map(|passed| passed.as_ref().err())
        .min();
    match failure {
        Some(failure) => Err(*failure),
        None => Ok(passed.into_iter().flatten().collect()),
    }
}

/// Adds what a child passes on for the rows `from` to a front: its first `width` columns and the rest.
fn add<T: RealField + Copy>(
    passed: &[T],
    from: &[u32],
    local: &[u32],
    (width, panel, rest): (usize, &mut [T], &mut [T]),
) {
    let height = panel.len() / width;
    let rows = height - width;
    for (at, row) in from.iter().enumerate() {
        let column = local[*row as usize] as usize;
        let values = &passed[at * from.len()..][at..from.len()];
        let pairs = from[at..].iter().zip(values);
        if column < width {
            let own = &mut panel[column * height..][..height];
            pairs.for_each(|(row, value)| own[local[*row as usize] as usize] += *value);
        } else {
            let own = &mut rest[(column - width) * rows..][..rows];
            pairs.for_each(|(row, value)| own[local[*row as usize] as usize - width] += *value);
        }
    }
}

/// L Lᵀ of the columns of a front; takes what it is of the rest off it.
fn eliminate_llt<T: RealField + Copy>(
    panel: MatMut<'_, T>,
    rest: MatMut<'_, T>,
    par: Par,
    memory: &mut MemStack,
) -> Result<(), usize> {
    let width = panel.ncols();
    let (mut top, mut below) = panel.split_at_row_mut(width);
    let factor = llt::factor::cholesky_in_place(
        top.rb_mut(),
        Default::default(),
        par,
        memory,
        Default::default(),
    );
    factor.map_err(|llt::factor::LltError::NonPositivePivot { index }| index)?;
    solve_lower_triangular_in_place(top.rb(), below.rb_mut().transpose_mut(), par);
    subtract(rest, (below.rb(), below.rb()), par);
    Ok(())
}

/// L D Lᵀ of the columns of a front; takes what it is of the rest off it.
fn eliminate_ldlt<T: RealField + Copy>(
    panel: MatMut<'_, T>,
    rest: MatMut<'_, T>,
    par: Par,
    (memory, scaled): (&mut MemStack, &mut Vec<T>),
) -> Result<(), usize> {
    let (width, rows) = (panel.ncols(), rest.nrows());
    let (mut top, mut below) = panel.split_at_row_mut(width);
    let factor = ldlt::factor::cholesky_in_place(
        top.rb_mut(),
        Default::default(),
        par,
        memory,
        Default::default(),
    );
    factor.map_err(|ldlt::factor::LdltError::ZeroPivot { index }| index)?;
    solve_unit_lower_triangular_in_place(top.rb(), below.rb_mut().transpose_mut(), par);
    scaled.clear();
    for column in 0..width {
        // What is above the diagonal is read as a part of the factor.
        (0..column).for_each(|row| top[(row, column)] = T::zero());
        let pivot = top[(column, column)];
        for value in below.rb_mut().col_mut(column).iter_mut() {
            scaled.push(*value);
            *value /= pivot;
        }
    }
    let scaled = MatRef::from_column_major_slice(scaled, rows, width);
    subtract(rest, (scaled, below.rb()), par);
    Ok(())
}

/// Takes the lower triangle of one times the transpose of the other off `rest`.
fn subtract<T: RealField + Copy>(
    rest: MatMut<'_, T>,
    (one, other): (MatRef<'_, T>, MatRef<'_, T>),
    par: Par,
) {
    if rest.nrows() > 0 {
        triangular::matmul(
            rest,
            BlockStructure::TriangularLower,
            Accum::Add,
            one,
            BlockStructure::Rectangular,
            other.transpose(),
            BlockStructure::Rectangular,
            -T::one(),
            par,
        );
    }
}

/// Work from which a front is shared by all threads, its width times the square of its height. On two threads a factor of
/// 34² points with three unknowns takes 27.5, 29.0, 26.2, 28.2 and 29.1 ms with 1e6, 3e6, 1e7, 3e7 and never (one thread:
/// 47.5 ms), of 64² points 236, 232, 218, 231 and 259 ms (354 ms).
const SHARED: usize = 10_000_000;

/// Threads for a front of so much work.
fn threads(work: usize) -> Par {
    match rayon::current_num_threads() {
        1 => Par::Seq,
        _ if work < SHARED => Par::Seq,
        threads => Par::rayon(threads),
    }
}
