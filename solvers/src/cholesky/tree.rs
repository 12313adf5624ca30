//! The elimination tree of supernodes: which fronts need which, and which can be worked on at the same time.

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

/// Into how many parts of equal work a tree is divided at most. On two threads a factor of 64² points with three unknowns
/// takes 231, 205, 219, 175 and 173 ms with 4, 16, 64, 256 and 1024 parts (minimum degree; one thread: 340 ms).
const PARTS: f64 = 256.0;

/// The supernodes of a factor as a tree.
#[derive(Default)]
pub(super) struct Tree {
    /// First child of every supernode in `child`, shape `(supernodes + 1,)`.
    starts: Vec<u32>,
    /// Children in ascending order.
    child: Vec<u32>,
    /// Supernodes without a parent.
    pub(super) roots: Vec<u32>,
    /// All supernodes, children before their parent and subtrees in one piece.
    order: Vec<u32>,
    /// First place in `order` of the subtree of a supernode, and the one after its last.
    places: Vec<[u32; 2]>,
    /// Multiplications and additions of a subtree.
    work: Vec<f64>,
    /// Work from which a subtree counts as heavy.
    grain: f64,
}

impl Tree {
    pub(super) fn new(symbolic: &SymbolicSupernodalCholesky<u32>) -> Self {
        let count = symbolic.n_supernodes();
        let (begins, ends) = (symbolic.supernode_begin(), symbolic.supernode_end());
        let mut node_of = vec![0_u32; symbolic.nrows()];
        for node in 0..count {
            node_of[begins[node] as usize..ends[node] as usize].fill(node as u32);
        }
        let below = |node: usize| symbolic.supernode(node).pattern();
        let parent = |node: usize| {
            below(node)
                .first()
                .map(|row| node_of[*row as usize] as usize)
        };
        let (mut starts, mut size) = (vec![0_u32; count + 1], vec![1_u32; count]);
        let mut work = vec![0.0; count];
        for node in 0..count {
            let rows = below(node).len() as u64;
            let columns = u64::from(ends[node] - begins[node]);
            work[node] += (1..=columns)
                .map(|k| ((rows + k) as f64).powi(2))
                .sum::<f64>();
            if let Some(above) = parent(node) {
                starts[above + 1] += 1;
                size[above] += size[node];
                work[above] += work[node];
            }
        }
        (0..count).for_each(|node| starts[node + 1] += starts[node]);
        let (mut next, mut child) = (starts.clone(), vec![0; starts[count] as usize]);
        let mut roots = Vec::new();
        for node in 0..count {
            match parent(node) {
                Some(above) => {
                    child[next[above] as usize] = node as u32;
                    next[above] += 1;
                }
                None => roots.push(node as u32),
            }
        }
        let all: f64 = roots.iter().map(|root| work[*root as usize]).sum();
        let mut tree = Tree {
            starts,
            child,
            roots,
            order: vec![0; count],
            places: vec![[0; 2]; count],
            work,
            grain: all / PARTS,
        };
        tree.put_in_order(&size);
        tree
    }

    fn put_in_order(&mut self, size: &[u32]) {
        let mut from = 0;
        for root in self.roots.clone() {
            self.places[root as usize] = [from, from + size[root as usize]];
            from += size[root as usize];
        }
        for node in (0..size.len()).rev() {
            let [mut from, end] = self.places[node];
            self.order[end as usize - 1] = node as u32;
            for place in self.starts[node]..self.starts[node + 1] {
                let child = self.child[place as usize] as usize;
                self.places[child] = [from, from + size[child]];
                from += size[child];
            }
        }
    }

    pub(super) fn children(&self, node: u32) -> &[u32] {
        let node = node as usize;
        &self.child[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// The supernodes of a subtree, children before their parent.
    pub(super) fn subtree(&self, node: u32) -> &[u32] {
        let [from, end] = self.places[node as usize];
        &self.order[from as usize..end as usize]
    }

    /// Those of some supernodes whose subtrees are worth a thread of their own.
    pub(super) fn heavy(&self, nodes: &[u32]) -> Vec<u32> {
        let nodes = nodes.iter().copied();
        nodes
            .filter(|node| self.work[*node as usize] >= self.grain)
            .collect()
    }
}
