//! Dual families: the transpose of the list of bonds.

/// The bonds that end at every point.
#[derive(Debug, Clone)]
pub(super) struct Dual {
    pub offset: Vec<u32>,
    pub bond: Vec<u32>,
    pub owner: Vec<u32>,
}

impl Dual {
    /// That of bonds in families that start at `offset` and end at `neighbour`.
    pub(super) fn of(offset: &[u32], neighbour: &[u32]) -> Self {
        let points = offset.len() - 1;
        let mut start = vec![0_u32; points + 1];
        for &j in neighbour {
            start[j as usize + 1] += 1;
        }
        for point in 0..points {
            start[point + 1] += start[point];
        }
        let mut cursor = start.clone();
        let mut bonds = vec![0_u32; neighbour.len()];
        let mut owners = vec![0_u32; neighbour.len()];
        for owner in 0..points {
            for bond in offset[owner]..offset[owner + 1] {
                let slot = &mut cursor[neighbour[bond as usize] as usize];
                bonds[*slot as usize] = bond;
                owners[*slot as usize] = owner as u32;
                *slot += 1;
            }
        }
        Dual {
            offset: start,
            bond: bonds,
            owner: owners,
        }
    }
}
