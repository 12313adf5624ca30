//! `[geometry]`: the domain and its points.

use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{Length, Number, values};
use crate::scene::range::{Range, within};
use crate::scene::shape::Shape;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// The domain and its points.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(tag = "type")]
pub enum Geometry {
    /// Equal cells in a rectangle or cuboid.
    Lattice(Lattice),
    /// A tensor grid whose spacing changes along each axis.
    Graded(Graded),
    /// A quadtree or octree of blocks, 2:1 between neighbours.
    Blocks(Blocks),
    /// Points read from a file.
    File(PointFile),
    /// The cells of a mesh read from a file.
    Mesh(MeshFile),
}

/// Equal cells in a rectangle or cuboid; a point at the centre of each.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lattice {
    /// Edge lengths of the domain, m; two or three.
    pub size: Spanned<Vec<Length>>,
    /// Lowest corner, m; zero if absent.
    pub origin: Option<Spanned<Vec<Length>>>,
    /// Number of points along each axis. Excludes `spacing`.
    pub points: Option<Spanned<Vec<Spanned<u64>>>>,
    /// Cell edge, m; must divide `size`. Excludes `points`.
    pub spacing: Option<Length>,
    /// Random shift of the points as a part of the spacing.
    #[schemars(transform = within(&JITTER))]
    #[serde(default = "zero")]
    pub jitter: Number,
    /// Seed of the random shift.
    #[serde(default)]
    pub seed: u64,
    /// Extent across the plane, m; 1 m if absent. Forces, rates and energies are those of a slab this
    /// thick. Only in two dimensions.
    pub thickness: Option<Length>,
}

/// A tensor grid: each axis is a row of segments.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Graded {
    /// Lowest corner, m; zero if absent.
    pub origin: Option<Spanned<Vec<Length>>>,
    /// For each axis its segments from low to high.
    pub axes: Spanned<Vec<Spanned<Vec<Segment>>>>,
    /// Extent across the plane, m; 1 m if absent. Forces, rates and energies are those of a slab this
    /// thick. Only in two dimensions.
    pub thickness: Option<Length>,
}

/// A part of an axis.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// Length, m.
    pub length: Length,
    /// Cell edge, m: one value, or the first and the last of a geometric progression.
    pub spacing: SegmentSpacing,
}

/// Cell edges in a segment.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename = "SegmentSpacing by key", rename_all = "kebab-case")]
#[schemars(rename = "SegmentSpacing", untagged)]
pub enum SegmentSpacing {
    /// All the same, m.
    Value(Length),
    /// The first and the last of a geometric progression, m.
    List([Length; 2]),
}

/// A quadtree (octree) of blocks, 2:1 between neighbours.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Blocks {
    /// Edge lengths of the domain, m; two or three.
    pub size: Spanned<Vec<Length>>,
    /// Lowest corner, m; zero if absent.
    pub origin: Option<Spanned<Vec<Length>>>,
    /// Edge of the coarsest cells, m; must divide `size`.
    pub spacing: Length,
    /// Regions of finer cells.
    #[serde(default)]
    pub refine: Vec<Refinement>,
    /// Extent across the plane, m; 1 m if absent. Forces, rates and energies are those of a slab this
    /// thick. Only in two dimensions.
    pub thickness: Option<Length>,
}

/// A region of finer cells.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Refinement {
    /// How many times the cells are halved.
    #[schemars(transform = within(&LEVELS))]
    pub levels: Spanned<u64>,
    /// Where.
    pub region: Spanned<Shape>,
}

/// Points read from a file.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointFile {
    /// A `.csv` or `.vtu` file, relative to the scene file.
    pub path: Spanned<String>,
    /// Corners of the domain. Points are cell centres, half a cell inside; parts without points are
    /// voids with free surfaces, where nothing pushes and nothing flows through.
    pub bounds: Option<FileBounds>,
    /// Accepts volumes that do not fit the bounds or the distances between the points.
    #[serde(default)]
    pub any_volume: bool,
    /// Extent across the plane, m; 1 m if absent. Forces, rates and energies are those of a slab this
    /// thick. Only in two dimensions.
    pub thickness: Option<Length>,
}

/// The cells of a mesh: each becomes a point at its centroid. The domain is the box around them; what they leave of
/// it is void, with free surfaces.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// A `.msh` (Gmsh 4.1), `.inp` (Abaqus) or `.vtu` file, relative to the scene file. Cells have straight edges.
    /// Groups with the name of a material tell which cells it has.
    #[serde(alias = "file")]
    pub path: Spanned<String>,
    /// Length of one unit of the file, m; 1 m if absent.
    pub unit: Option<Length>,
    /// Extent across the plane, m; 1 m if absent. Forces, rates and energies are those of a slab this
    /// thick. Only in two dimensions.
    pub thickness: Option<Length>,
}

/// Corners of a domain whose points come from a file.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileBounds {
    /// Lowest corner, m.
    pub min: Spanned<Vec<Length>>,
    /// Highest corner, m.
    pub max: Spanned<Vec<Length>>,
}

const JITTER: Range = Range {
    key: "jitter",
    low: 0.0,
    high: 0.4,
    why: "beyond half a cell points leave their own cells and may meet",
};
const LEVELS: Range = Range {
    key: "levels",
    low: 1.0,
    high: 12.0,
    why: "twelve halvings are a factor of 4096 along each axis",
};

fn zero() -> Number {
    Number::si(0.0)
}

/// The corners of a domain, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// Lowest corner, m.
    pub min: Vec<f64>,
    /// Highest corner, m.
    pub max: Vec<f64>,
}

impl Bounds {
    /// Whether the position (m) lies inside or on the boundary, within rounding.
    pub fn contain(&self, position: &[f64]) -> bool {
        position
            .iter()
            .zip(&self.min)
            .zip(&self.max)
            .all(|((x, low), high)| {
                let slack = 1e-12 * (low.abs() + high.abs());
                low - slack <= *x && *x <= high + slack
            })
    }

    fn new(origin: Option<&Spanned<Vec<Length>>>, size: &[f64]) -> Self {
        let min = origin.map_or_else(|| vec![0.0; size.len()], |origin| values(origin));
        let max = min
            .iter()
            .zip(size)
            .map(|(low, length)| low + length)
            .collect();
        Self { min, max }
    }
}

impl fmt::Display for Bounds {
    /// The interval of each axis: `[0, 2] × [0, 1] m`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axes: Vec<String> = self
            .min
            .iter()
            .zip(&self.max)
            .map(|(low, high)| format!("[{low}, {high}]"))
            .collect();
        write!(f, "{} m", axes.join(" \u{d7} "))
    }
}

impl Geometry {
    /// Space dimension, 2 or 3; `None` if only the points' file knows.
    pub fn dimension(&self) -> Option<usize> {
        match self {
            Self::Lattice(lattice) => Some(lattice.size.len()),
            Self::Graded(graded) => Some(graded.axes.len()),
            Self::Blocks(blocks) => Some(blocks.size.len()),
            Self::File(file) => file.bounds.as_ref().map(|bounds| bounds.min.len()),
            Self::Mesh(_) => None,
        }
    }

    /// Extent across the plane, m, where it is given.
    pub fn thickness(&self) -> Option<Length> {
        match self {
            Self::Lattice(lattice) => lattice.thickness,
            Self::Graded(graded) => graded.thickness,
            Self::Blocks(blocks) => blocks.thickness,
            Self::File(file) => file.thickness,
            Self::Mesh(mesh) => mesh.thickness,
        }
    }

    /// The file that points come from.
    pub fn path(&self) -> Option<&Spanned<String>> {
        match self {
            Self::Lattice(_) | Self::Graded(_) | Self::Blocks(_) => None,
            Self::File(file) => Some(&file.path),
            Self::Mesh(mesh) => Some(&mesh.path),
        }
    }

    /// Corners of the domain; `None` if only the points' file knows.
    pub fn bounds(&self) -> Option<Bounds> {
        Some(match self {
            Self::Lattice(lattice) => Bounds::new(lattice.origin.as_ref(), &values(&lattice.size)),
            Self::Blocks(blocks) => Bounds::new(blocks.origin.as_ref(), &values(&blocks.size)),
            Self::Graded(graded) => Bounds::new(graded.origin.as_ref(), &graded.lengths()),
            Self::Mesh(_) => return None,
            Self::File(file) => {
                let bounds = file.bounds.as_ref()?;
                Bounds {
                    min: values(&bounds.min),
                    max: values(&bounds.max),
                }
            }
        })
    }
}

impl Lattice {
    /// Number of points along each axis.
    pub fn counts(&self) -> Vec<usize> {
        match (&self.points, self.spacing) {
            (Some(points), _) => points
                .iter()
                .map(|n| usize::try_from(n.value).unwrap_or(usize::MAX))
                .collect(),
            (None, Some(spacing)) => counts(&self.size, spacing),
            (None, None) => Vec::new(),
        }
    }
}

impl Graded {
    /// Length of each axis, m.
    pub fn lengths(&self) -> Vec<f64> {
        let length = |axis: &Spanned<Vec<Segment>>| axis.iter().map(|s| s.length.value()).sum();
        self.axes.iter().map(length).collect()
    }
}

impl Blocks {
    /// Number of the coarsest cells along each axis.
    pub fn counts(&self) -> Vec<usize> {
        counts(&self.size, self.spacing)
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn counts(size: &[Length], spacing: Length) -> Vec<usize> {
    size.iter()
        .map(|length| (length.value() / spacing.value()).round() as usize)
        .collect()
}

impl Section for Geometry {
    const NAME: &'static str = "geometry";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        match self {
            Self::Lattice(lattice) => check_lattice(lattice, place, report),
            Self::Graded(graded) => check_graded(graded, report),
            Self::Blocks(blocks) => check_blocks(blocks, scene, report),
            Self::File(file) => check_file(file, report),
            Self::Mesh(mesh) => check_mesh(mesh, report),
        }
        if let Some(thickness) = self.thickness() {
            report.positive("thickness", thickness);
            if self.dimension() == Some(3) {
                report.add(thickness_in_space(thickness.span()));
            }
        }
    }
}

/// The fault of a thickness in three dimensions.
pub(crate) fn thickness_in_space(place: Span) -> Diagnostic {
    let fault = Diagnostic::new("`thickness` has no meaning in three dimensions").at(place);
    fault.help("leave it out: the third axis of the domain is its thickness")
}

fn check_box(
    size: &Spanned<Vec<Length>>,
    origin: Option<&Spanned<Vec<Length>>>,
    report: &mut Report,
) {
    report.vector("size", size, None);
    report.all_positive("size", size);
    if let Some(origin) = origin {
        report.vector("origin", origin, Some(size.len()));
    }
}

fn check_lattice(lattice: &Lattice, place: Span, report: &mut Report) {
    check_box(&lattice.size, lattice.origin.as_ref(), report);
    let given = [
        ("points", lattice.points.as_ref().map(|points| points.span)),
        ("spacing", lattice.spacing.map(|spacing| spacing.span())),
    ];
    if given.iter().all(|(_, span)| span.is_none()) {
        report.add(Diagnostic::new("a lattice needs `points` or `spacing`").at(place));
    }
    report.at_most_one(&given);
    if let Some(points) = &lattice.points {
        report.vector("points", points, Some(lattice.size.len()));
        points
            .iter()
            .for_each(|count| report.at_least("points", *count, 1));
    }
    if let Some(spacing) = lattice.spacing {
        check_divides(&lattice.size, spacing, report);
    }
    JITTER.check(lattice.jitter, report);
}

fn check_divides(size: &[Length], spacing: Length, report: &mut Report) {
    report.positive("spacing", spacing);
    if spacing.value() <= 0.0 {
        return;
    }
    let uneven = size.iter().find_map(|length| {
        let cells = length.value() / spacing.value();
        (length.value() > 0.0 && (cells - cells.round()).abs() > 1e-9 * cells.max(1.0))
            .then_some((length, cells))
    });
    if let Some((length, cells)) = uneven {
        let message = format!("`spacing` must divide `size`, found {cells:.3} cells");
        report.add(
            Diagnostic::new(message)
                .at(spacing.span())
                .also(length.span(), "this edge"),
        );
    }
}

fn check_graded(graded: &Graded, report: &mut Report) {
    report.vector("axes", &graded.axes, None);
    if let Some(origin) = &graded.origin {
        report.vector("origin", origin, Some(graded.axes.len()));
    }
    for axis in graded.axes.iter() {
        if axis.is_empty() {
            report.add(Diagnostic::new("an axis needs at least one segment").at(axis.span));
        }
        axis.iter()
            .for_each(|segment| check_segment(segment, report));
    }
}

fn check_segment(segment: &Segment, report: &mut Report) {
    report.positive("length", segment.length);
    let spacings: &[Length] = match &segment.spacing {
        SegmentSpacing::Value(spacing) => std::slice::from_ref(spacing),
        SegmentSpacing::List(ends) => ends,
    };
    for spacing in spacings {
        report.positive("spacing", *spacing);
        if segment.length.value() > 0.0 && spacing.value() > segment.length.value() * (1.0 + 1e-9) {
            let fault = Diagnostic::new("`spacing` is longer than its segment").at(spacing.span());
            report.add(fault.also(segment.length.span(), "the segment"));
        }
    }
}

fn check_blocks(blocks: &Blocks, scene: &Context<'_>, report: &mut Report) {
    check_box(&blocks.size, blocks.origin.as_ref(), report);
    check_divides(&blocks.size, blocks.spacing, report);
    for refinement in &blocks.refine {
        report.shape(&refinement.region, scene);
        LEVELS.check_count(refinement.levels, report);
    }
}

fn check_file(file: &PointFile, report: &mut Report) {
    report.file("path", &file.path, &["csv", "vtu"]);
    if let Some(bounds) = &file.bounds {
        report.corners(&bounds.min, &bounds.max, None);
    }
}

fn check_mesh(mesh: &MeshFile, report: &mut Report) {
    report.file("path", &mesh.path, &["msh", "inp", "vtu"]);
    if let Some(unit) = mesh.unit {
        report.positive("unit", unit);
    }
}
