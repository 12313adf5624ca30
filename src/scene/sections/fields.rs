//! Properties of the rock as fields: one value, values from a file, or drawn at random.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{Dimension, Length, Number, Quantity};
use crate::scene::range::{Range, within};
use crate::scene::span::Spanned;
use crate::scene::validate::Report;

/// One value, from a file, or drawn at random.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename = "Field by key", rename_all = "kebab-case")]
#[schemars(rename = "{Q}Field", untagged)]
pub enum Field<Q> {
    /// The same everywhere.
    Value(Q),
    /// From a file: one value for each point, or for each cell of an array laid over the domain.
    File(FieldFile),
    /// A random field.
    Distribution(FieldDistribution<Q>),
}

/// One value, or from a file.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename = "ReadField by key", rename_all = "kebab-case")]
#[schemars(rename = "{Q}ReadField", untagged)]
pub enum ReadField<Q> {
    /// The same everywhere.
    Value(Q),
    /// From a file: one value for each point, or for each cell of an array laid over the domain.
    File(FieldFile),
}

/// A property from a file, in SI units.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldFile {
    /// A `.npy`, `.csv` or `.vtu` file, relative to the scene file, or `bundled:NAME` for one that comes with the
    /// program. On a lattice or graded grid an array may
    /// have the shape of the grid, with the indices `[ix, iy]` (`[ix, iy, iz]`) from the lowest
    /// corner; a column or a flat array is in the order of the points (x fastest).
    pub file: Spanned<String>,
    /// Column of a `.csv` file, or point data of a `.vtu` file; there the name of the key if absent.
    pub column: Option<Spanned<String>>,
    /// Cells along each axis of an array that is laid over the domain: a point takes the value of the cell
    /// in which it lies, whatever the cloud. Without it there is one value for each point.
    pub cells: Option<Spanned<Vec<u32>>>,
    /// Largest over smallest value: logarithms are stretched about the middle of their range. Below 1 high and low
    /// change places. The values as they are if absent.
    pub contrast: Option<Number>,
}

/// A random field.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "{Q}Distribution")]
pub struct FieldDistribution<Q> {
    /// Kind of distribution.
    pub distribution: Distribution,
    /// Median, in the unit of the property.
    pub median: Q,
    /// Standard deviation of the decimal logarithm.
    #[schemars(transform = within(&LOG10_STD))]
    pub log10_std: Number,
    /// Whole range in decades, clipped around the median; not clipped if absent.
    #[schemars(transform = within(&DECADES))]
    pub decades: Option<Number>,
    /// Correlation length, m; neighbours are independent if absent.
    pub correlation_length: Option<Length>,
    /// Seed of the random numbers. Properties of the same seed and correlation length draw the same normal numbers, so that
    /// they are high and low at the same places, in all materials; those of other seeds are independent.
    #[serde(default)]
    pub seed: u64,
}

/// Kinds of random fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Distribution {
    /// The logarithm is normally distributed.
    LogNormal,
}

const LOG10_STD: Range = Range {
    key: "log10_std",
    low: 0.0,
    high: 3.0,
    why: "at 3 a few thousand points span 22 decades, and doubles carry 16 digits",
};
const DECADES: Range = Range {
    key: "decades",
    low: 1e-3,
    high: 22.0,
    why: "doubles carry 16 digits, so that wider contrasts are lost to rounding",
};

/// A field of whichever quantity, as it was typed.
#[derive(Clone, Copy)]
pub enum Typed<'a, D> {
    /// The same everywhere.
    Value(Quantity<D>),
    /// From a file.
    File(&'a FieldFile),
    /// Drawn at random.
    Distribution(&'a FieldDistribution<Quantity<D>>),
}

impl<D> Field<Quantity<D>> {
    /// What was typed.
    pub fn typed(&self) -> Typed<'_, D> {
        match self {
            Self::Value(value) => Typed::Value(*value),
            Self::File(file) => Typed::File(file),
            Self::Distribution(random) => Typed::Distribution(random),
        }
    }
}

impl<D> ReadField<Quantity<D>> {
    /// What was typed.
    pub fn typed(&self) -> Typed<'_, D> {
        match self {
            Self::Value(value) => Typed::Value(*value),
            Self::File(file) => Typed::File(file),
        }
    }
}

impl<'a, D: Dimension> Typed<'a, D> {
    /// The value, if it is the same everywhere.
    pub fn value(self) -> Option<Quantity<D>> {
        match self {
            Self::Value(value) => Some(value),
            Self::File(_) | Self::Distribution(_) => None,
        }
    }

    /// The file, if there is one.
    pub fn file(self) -> Option<&'a FieldFile> {
        match self {
            Self::File(file) => Some(file),
            Self::Value(_) | Self::Distribution(_) => None,
        }
    }

    /// Reports what is wrong with what was typed; `value` judges one value.
    pub(super) fn check(self, report: &mut Report, value: impl FnOnce(Quantity<D>, &mut Report)) {
        match self {
            Self::Value(own) => value(own, report),
            Self::File(file) => check_file(file, report),
            Self::Distribution(random) => check_distribution(random, report),
        }
    }
}

pub(super) fn check_file(source: &FieldFile, report: &mut Report) {
    report.file("file", &source.file, &["npy", "csv", "vtu"]);
    if let Some(column) = &source.column
        && source.file.to_lowercase().ends_with(".npy")
    {
        let fault = Diagnostic::new("a `.npy` file has no columns").at(column.span);
        report.add(
            fault
                .also(source.file.span, "the file")
                .help("remove `column`"),
        );
    }
    if let Some(contrast) = source.contrast {
        report.positive("contrast", contrast);
    }
}

pub(super) fn check_distribution<D: Dimension>(
    random: &FieldDistribution<Quantity<D>>,
    report: &mut Report,
) {
    report.positive("median", random.median);
    LOG10_STD.check(random.log10_std, report);
    random
        .decades
        .into_iter()
        .for_each(|decades| DECADES.check(decades, report));
    let length = random.correlation_length;
    length
        .into_iter()
        .for_each(|length| report.positive("correlation_length", length));
}
