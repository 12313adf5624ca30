//! Families: the bonds of every point, and their transpose, the dual families.

use std::sync::OnceLock;

use super::cell_list::CellList;
use super::lattice::are_same;
use super::near::Near;
use super::transpose::Dual;
use super::{Cloud, Cutter, GeometryError, ImageTable, Lattice, Subdomain, Vector};
use crate::parallel;
use perifrac_solvers::Partition;

/// The cloud together with its mirror images within reach, ready for radius searches.
pub(super) struct World<const D: usize> {
    cells: CellList<D>,
    source: Vec<u32>,
    image: Vec<u8>,
}

impl<const D: usize> World<D> {
    /// Collects real points and all images within `reach` metres of the domain; only those that are
    /// `near`, if it is told what that means.
    pub(super) fn new(
        cloud: &Cloud<D>,
        images: &ImageTable<D>,
        reach: f64,
        edge: f64,
        near: Option<&Near<D>>,
    ) -> Self {
        let wanted = |x: &Vector<D>| near.is_none_or(|near| near.holds(x));
        let points = (0_u32..).zip(&cloud.position).filter(|(_, x)| wanted(x));
        let (mut source, mut positions): (Vec<u32>, Vec<Vector<D>>) = points.unzip();
        let mut image = vec![0_u8; source.len()];
        let (low, high) = (
            cloud.domain.lower.add_scalar(-reach),
            cloud.domain.upper.add_scalar(reach),
        );
        for (number, mirror) in images.iter().enumerate().skip(1) {
            for (point, x) in cloud.position.iter().enumerate() {
                let y = mirror.place(x);
                if y >= low && y <= high && wanted(&y) {
                    positions.push(y);
                    source.push(point as u32);
                    image.push(number as u8);
                }
            }
        }
        World {
            cells: CellList::new(&positions, edge),
            source,
            image,
        }
    }

    /// Real point and image number of an index in this world.
    pub(super) fn origin(&self, index: u32) -> (usize, u8) {
        (
            self.source[index as usize] as usize,
            self.image[index as usize],
        )
    }

    /// Calls `visit(index in this world, squared distance)` for all points within `radius` of `x`.
    pub(super) fn within(&self, x: &Vector<D>, radius: f64, visit: impl FnMut(u32, f64)) {
        self.cells.within(x, radius, visit);
    }
}

/// All bonds i → j in one flat list, grouped by owner i and sorted by neighbour j.
///
/// The dual families H′ (Eq. 2) are the transpose of H and are never searched for.
#[derive(Debug, Clone)]
pub struct Families<const D: usize> {
    /// Horizon of every point in metres, shape `(n,)`.
    pub horizon: Vec<f64>,
    /// The images that bonds refer to.
    pub images: ImageTable<D>,
    /// The part of the bonds that is held here.
    pub share: Subdomain,
    /// Bonds that cracks have cut, by owner; they are none any more. `None` without cracks.
    pub severed: Option<Vec<Severed>>,
    offset: Vec<u32>,
    neighbour: Vec<u32>,
    image: Vec<u8>,
    /// Made when it is first asked for: families that only tell who touches whom need none.
    dual: OnceLock<Dual>,
}

/// A bond that was there before a crack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Severed {
    /// Whose family it was in.
    pub owner: u32,
    /// Real neighbour at its end.
    pub neighbour: u32,
    /// Image number at its end.
    pub image: u8,
    /// The first crack across it.
    pub crack: u16,
}

const CHUNK: usize = 1024;

/// Family sizes of a range of points, and their bonds as pairs of neighbour and image number.
type Chunk = (Vec<u32>, Vec<(u32, u8)>);

impl<const D: usize> Families<D> {
    /// Finds every neighbour within each point's horizon, images included.
    ///
    /// # Errors
    /// [`GeometryError::TooManyImages`] for a domain too thin for the horizon;
    /// [`GeometryError::TooLarge`] beyond 32-bit indices.
    pub fn search(cloud: &Cloud<D>, horizon: Vec<f64>) -> Result<Self, GeometryError> {
        let radius = horizon.first().copied().unwrap_or(0.0);
        let lattice = are_same(&horizon).then(|| Lattice::of(cloud)).flatten();
        if let Some(lattice) = lattice {
            let reach = horizon.iter().copied().fold(0.0, f64::max);
            let images = ImageTable::new(&cloud.domain, reach)?;
            if let Some(known) = lattice.families(radius, &images) {
                return Self::of(horizon, images, Subdomain::WHOLE, |point, bonds| {
                    known.add(point, bonds);
                });
            }
        }
        Self::by_search(cloud, horizon)
    }

    /// As [`Families::search`], whatever the points are.
    pub(super) fn by_search(cloud: &Cloud<D>, horizon: Vec<f64>) -> Result<Self, GeometryError> {
        Self::search_share(cloud, horizon, None, &[])
    }

    /// As [`Families::search`], but if there is a partition only for the points that the rows of this
    /// process need, and for those in `watched`; all other families are empty.
    ///
    /// # Errors
    /// As [`Families::search`].
    pub fn search_share(
        cloud: &Cloud<D>,
        horizon: Vec<f64>,
        partition: Option<Partition>,
        watched: &[usize],
    ) -> Result<Self, GeometryError> {
        let reach = horizon.iter().copied().fold(0.0, f64::max);
        let images = ImageTable::new(&cloud.domain, reach)?;
        let typical = horizon.iter().sum::<f64>() / horizon.len().max(1) as f64;
        let (world, share) = match partition {
            None => (
                World::new(cloud, &images, reach, typical, None),
                Subdomain::WHOLE,
            ),
            Some(partition) => {
                let own = partition.own().iter().map(|point| *point as usize);
                let points = own.chain(watched.iter().copied());
                let positions: Vec<Vector<D>> = points.map(|point| cloud.position[point]).collect();
                // Families of points that see an own one reach as far again.
                let near = Near::new(&positions, 2.0 * reach);
                let world = World::new(cloud, &images, reach, typical, Some(&near));
                let held = held_families(cloud, &world, &near, &horizon, &partition, watched);
                (world, Subdomain::of(partition, held))
            }
        };
        let chunks: Vec<Chunk> = parallel::map(cloud.len().div_ceil(CHUNK), |chunk| {
            let points = chunk * CHUNK..((chunk + 1) * CHUNK).min(cloud.len());
            family_chunk(cloud, &world, &horizon, &share, points)
        });
        drop(world);
        Self::from_chunks(horizon, images, share, chunks)
    }

    /// Families whose bonds (neighbour, image number) are known without a search; `family` adds them
    /// sorted, and is asked for points that are held.
    ///
    /// # Errors
    /// [`GeometryError::TooLarge`] beyond 32-bit indices.
    pub fn of(
        horizon: Vec<f64>,
        images: ImageTable<D>,
        share: Subdomain,
        family: impl Fn(usize, &mut Vec<(u32, u8)>) + Sync,
    ) -> Result<Self, GeometryError> {
        let chunk = |chunk: usize| {
            let points = chunk * CHUNK..((chunk + 1) * CHUNK).min(horizon.len());
            let mut counts = Vec::with_capacity(points.len());
            let mut bonds = Vec::with_capacity(24 * points.len());
            for point in points {
                let before = bonds.len();
                if share.holds(point) {
                    family(point, &mut bonds);
                }
                counts.push((bonds.len() - before) as u32);
            }
            (counts, bonds)
        };
        let chunks: Vec<Chunk> = parallel::map(horizon.len().div_ceil(CHUNK), chunk);
        Self::from_chunks(horizon, images, share, chunks)
    }

    fn from_chunks(
        horizon: Vec<f64>,
        images: ImageTable<D>,
        share: Subdomain,
        chunks: Vec<Chunk>,
    ) -> Result<Self, GeometryError> {
        let bonds: usize = chunks.iter().map(|(_, bonds)| bonds.len()).sum();
        if bonds > u32::MAX as usize {
            return Err(GeometryError::TooLarge {
                what: "bonds",
                count: bonds,
            });
        }
        let mut offset = Vec::with_capacity(horizon.len() + 1);
        offset.push(0_u32);
        let mut neighbour = Vec::with_capacity(bonds);
        let mut image = Vec::with_capacity(bonds);
        for (counts, chunk) in chunks {
            let mut end = neighbour.len() as u32;
            for count in counts {
                end += count;
                offset.push(end);
            }
            neighbour.extend(chunk.iter().map(|&(j, _)| j));
            image.extend(chunk.iter().map(|&(_, number)| number));
        }
        Ok(Families {
            horizon,
            images,
            share,
            severed: None,
            offset,
            neighbour,
            image,
            dual: OnceLock::new(),
        })
    }

    /// The same families without the bonds to images for which `keep` is false.
    ///
    /// Fields with a natural (one-sided) boundary see no images there.
    ///
    /// # Errors
    /// As [`Families::search`].
    pub fn retain_images(&self, keep: impl Fn(u8) -> bool) -> Result<Self, GeometryError> {
        let kept = |severed: &Vec<Severed>| {
            let kept = severed.iter().filter(|bond| keep(bond.image));
            kept.copied().collect()
        };
        Ok(Families {
            severed: self.severed.as_ref().map(kept),
            ..self.retain(|_, bond| keep(self.image[bond]))?
        })
    }

    /// The same families without the bonds that meet a crack.
    ///
    /// # Errors
    /// As [`Families::search`].
    pub fn cut(&self, cloud: &Cloud<D>, cutter: &Cutter<D>) -> Result<Self, GeometryError> {
        let crack = |owner: usize, bond: usize| {
            let image = self.images.get(self.image[bond]);
            let end = image.place(&cloud.position[self.neighbour(bond)]);
            cutter.first(&cloud.position[owner], &end)
        };
        let severed: Vec<Severed> = parallel::gather(self.len(), |owner, all| {
            all.extend(self.family(owner).filter_map(|bond| {
                Some(Severed {
                    owner: owner as u32,
                    neighbour: self.neighbour[bond],
                    image: self.image[bond],
                    crack: crack(owner, bond)?,
                })
            }));
        });
        let mut next = severed.iter().peekable();
        let kept = self.retain(|owner, bond| {
            // Both lists run through the bonds in the same order.
            let end = (owner as u32, self.neighbour[bond], self.image[bond]);
            let same = |cut: &&Severed| (cut.owner, cut.neighbour, cut.image) == end;
            next.next_if(same).is_none()
        })?;
        Ok(Families {
            severed: Some(severed),
            ..kept
        })
    }

    /// The same families without the bonds (owner, bond) for which `keep` is false; it is asked in order.
    ///
    /// # Errors
    /// As [`Families::search`].
    pub fn retain(
        &self,
        mut keep: impl FnMut(usize, usize) -> bool,
    ) -> Result<Self, GeometryError> {
        let mut counts = Vec::with_capacity(self.len());
        let mut bonds = Vec::with_capacity(self.bonds());
        for point in 0..self.len() {
            let before = bonds.len();
            let kept = self.family(point).filter(|bond| keep(point, *bond));
            bonds.extend(kept.map(|bond| (self.neighbour[bond], self.image[bond])));
            counts.push((bonds.len() - before) as u32);
        }
        self.with_bonds(counts, bonds)
    }

    /// The same families with these bonds (neighbour, image number) alone, so many of each family.
    ///
    /// # Errors
    /// As [`Families::search`].
    pub fn with_bonds(
        &self,
        counts: Vec<u32>,
        bonds: Vec<(u32, u8)>,
    ) -> Result<Self, GeometryError> {
        Self::from_chunks(
            self.horizon.clone(),
            self.images.clone(),
            self.share.clone(),
            vec![(counts, bonds)],
        )
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.horizon.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.horizon.is_empty()
    }

    /// Number of bonds, those to images included.
    pub fn bonds(&self) -> usize {
        self.neighbour.len()
    }

    /// Bond numbers of the family of `point`.
    #[inline]
    pub fn family(&self, point: usize) -> std::ops::Range<usize> {
        self.offset[point] as usize..self.offset[point + 1] as usize
    }

    /// Start of every family in the list of bonds, shape `(n + 1,)`.
    pub fn offsets(&self) -> &[u32] {
        &self.offset
    }

    /// Start of every dual family, shape `(n + 1,)`.
    pub fn dual_offsets(&self) -> &[u32] {
        &self.transposed().offset
    }

    #[inline]
    fn transposed(&self) -> &Dual {
        let make = || Dual::of(&self.offset, &self.neighbour);
        self.dual.get_or_init(make)
    }

    /// Real neighbour at the end of a bond.
    #[inline]
    pub fn neighbour(&self, bond: usize) -> usize {
        self.neighbour[bond] as usize
    }

    /// Image number at the end of a bond; 0 is the neighbour itself.
    #[inline]
    pub fn image(&self, bond: usize) -> u8 {
        self.image[bond]
    }

    /// Dual family of `point`: pairs (owner, bond) of all bonds that end at it.
    #[inline]
    pub fn dual(&self, point: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let dual = self.transposed();
        let range = dual.offset[point] as usize..dual.offset[point + 1] as usize;
        let pairs = dual.owner[range.clone()].iter().zip(&dual.bond[range]);
        pairs.map(|(owner, bond)| (*owner as usize, *bond as usize))
    }

    /// Bond vector ξ = x_j − x_i in metres, to the image where the bond ends at one.
    #[inline]
    pub fn bond_vector(&self, cloud: &Cloud<D>, owner: usize, bond: usize) -> Vector<D> {
        let end = &cloud.position[self.neighbour(bond)];
        self.images.get(self.image[bond]).place(end) - cloud.position[owner]
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let words = self.offset.len() + 4 * self.neighbour.len();
        let severed = size_of::<Severed>() * self.severed.as_ref().map_or(0, Vec::len);
        severed + 4 * words + self.image.len() + 8 * self.horizon.len() + self.share.bytes()
    }
}

/// The points of this process, all points that see one of them, and those that are watched.
fn held_families<const D: usize>(
    cloud: &Cloud<D>,
    world: &World<D>,
    near: &Near<D>,
    horizon: &[f64],
    partition: &Partition,
    watched: &[usize],
) -> Vec<bool> {
    let own = partition.mask();
    let sees_own = |point: usize| {
        let mut seen = false;
        let x = &cloud.position[point];
        world.within(x, horizon[point], |index, _| {
            seen |= own[world.origin(index).0];
        });
        seen
    };
    let mut held: Vec<bool> = parallel::map(cloud.len(), |point| {
        own[point] || (near.holds(&cloud.position[point]) && sees_own(point))
    });
    watched.iter().for_each(|point| held[*point] = true);
    held
}

/// Family sizes and bonds of a range of points.
fn family_chunk<const D: usize>(
    cloud: &Cloud<D>,
    world: &World<D>,
    horizon: &[f64],
    share: &Subdomain,
    points: std::ops::Range<usize>,
) -> Chunk {
    let mut counts = Vec::with_capacity(points.len());
    let mut bonds: Vec<(u32, u8)> = Vec::with_capacity(24 * points.len());
    for point in points {
        if !share.holds(point) {
            counts.push(0);
            continue;
        }
        let before = bonds.len();
        world.within(&cloud.position[point], horizon[point], |index, _| {
            let bond = (world.source[index as usize], world.image[index as usize]);
            if bond != (point as u32, 0) {
                bonds.push(bond);
            }
        });
        bonds[before..].sort_unstable();
        counts.push((bonds.len() - before) as u32);
    }
    (counts, bonds)
}
