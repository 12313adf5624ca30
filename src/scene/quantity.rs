//! Physical quantities as typed in a scene: checked for their dimension, kept in SI.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};

use super::reader::HELP;
use super::span::{Span, Spanned};
use super::units::{self, Exponents};

/// What a quantity measures.
pub trait Dimension {
    /// Name of the type, for the schema: `Pressure`.
    const ID: &'static str;
    /// In words: "a pressure".
    const NAME: &'static str;
    /// The SI unit: "Pa". Empty for plain numbers.
    const UNIT: &'static str;
    /// A quantity such as a user may type it.
    const EXAMPLE: &'static str;
    /// The dimensions that are accepted, the usual one first.
    const ACCEPTED: &'static [Exponents];
}

/// A quantity in SI with the place it was typed at.
///
/// A bare number is in SI already; a text has a unit, `"10 mD"`. Only finite numbers are read.
pub struct Quantity<D> {
    value: f64,
    span: Span,
    accepted: usize,
    dimension: PhantomData<fn() -> D>,
}

impl<D> Quantity<D> {
    /// A quantity nobody typed, in SI.
    pub const fn si(value: f64) -> Self {
        Self {
            value,
            span: Span::NOWHERE,
            accepted: 0,
            dimension: PhantomData,
        }
    }

    /// The same quantity, typed at `span`.
    pub(super) const fn at(self, span: Span) -> Self {
        Self { span, ..self }
    }

    /// The value in SI.
    pub const fn value(&self) -> f64 {
        self.value
    }

    /// Which of [`Dimension::ACCEPTED`] was typed; 0 for a bare number.
    pub const fn accepted(&self) -> usize {
        self.accepted
    }

    /// The value per metre of thickness of a slab of `thickness` metres: what was typed for all of it, or as a
    /// bare number, is divided by it; what was typed per metre is not.
    pub fn per_thickness(&self, thickness: f64) -> f64 {
        match self.accepted {
            0 => self.value / thickness,
            _ => self.value,
        }
    }

    /// Where it was typed; [`Span::NOWHERE`] for a default.
    pub const fn span(&self) -> Span {
        self.span
    }
}

impl<D: Dimension> Quantity<D> {
    /// A quantity from a number in SI.
    ///
    /// # Errors
    /// What is wrong with the number.
    pub(super) fn read_number<E: Error>(number: f64) -> Result<Self, E> {
        QuantityVisitor(PhantomData)
            .visit_f64(number)
            .map(Self::from)
    }

    /// A quantity from a text with a unit.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub(super) fn read_text<E: Error>(text: &str) -> Result<Self, E> {
        QuantityVisitor(PhantomData).visit_str(text).map(Self::from)
    }
}

impl<D> From<Bare<D>> for Quantity<D> {
    fn from(bare: Bare<D>) -> Self {
        Self {
            accepted: bare.accepted,
            ..Self::si(bare.value)
        }
    }
}

/// The SI values of a list of quantities.
pub fn values<D>(quantities: &[Quantity<D>]) -> Vec<f64> {
    quantities.iter().map(Quantity::value).collect()
}

impl<D> Clone for Quantity<D> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<D> Copy for Quantity<D> {}

impl<D> PartialEq for Quantity<D> {
    fn eq(&self, other: &Self) -> bool {
        self.value.total_cmp(&other.value).is_eq() && self.span == other.span
    }
}

impl<D: Dimension> fmt::Debug for Quantity<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.value, D::UNIT)
    }
}

impl<D: Dimension> fmt::Display for Quantity<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(format!("{} {}", self.value, D::UNIT).trim_end())
    }
}

macro_rules! dimensions {
    ($($(#[$doc:meta])* $id:ident, $name:literal, $unit:literal, $example:literal,
       $([$l:literal, $m:literal, $t:literal])+;)*) => {
        /// Markers for what a [`Quantity`] measures.
        pub mod dimension {
            $($(#[$doc])* #[derive(Debug, Clone, Copy, PartialEq, Eq)] pub enum $id {})*
            /// An angle, rad.
            #[derive(Debug, Clone, Copy, PartialEq, Eq)]
            pub enum Angle {}
        }
        $(
            impl Dimension for dimension::$id {
                const ID: &'static str = stringify!($id);
                const NAME: &'static str = $name;
                const UNIT: &'static str = $unit;
                const EXAMPLE: &'static str = $example;
                const ACCEPTED: &'static [Exponents] = &[$(Exponents::new($l, $m, $t)),+];
            }
            $(#[$doc])*
            pub type $id = Quantity<dimension::$id>;
        )*
    };
}

dimensions! {
    /// A number without unit; percent are accepted.
    Number, "a number without unit", "", "0.15", [0, 0, 0];
    /// A length, m.
    Length, "a length", "m", "10 mm", [1, 0, 0];
    /// A time, s.
    Time, "a time", "s", "2 h", [0, 0, 1];
    /// A pressure or an elastic modulus, Pa.
    Pressure, "a pressure", "Pa", "10 MPa", [-1, 1, -2];
    /// An inverse pressure (storage, compressibility), 1/Pa.
    InversePressure, "an inverse pressure", "1/Pa", "2e-10 1/Pa", [1, -1, 2];
    /// A dynamic viscosity, Pa s.
    Viscosity, "a viscosity", "Pa s", "1 cP", [-1, 1, -1];
    /// A mass density, kg/m³.
    Density, "a density", "kg/m^3", "1000 kg/m^3", [-3, 1, 0];
    /// An intrinsic permeability, m².
    Permeability, "a permeability", "m^2", "10 mD", [2, 0, 0];
    /// A volumetric flux (Darcy velocity), m/s.
    Flux, "a flux", "m/s", "1e-6 m/s", [1, 0, -1];
    /// A force per volume, N/m³.
    ForceDensity, "a force per volume", "N/m^3", "25 kN/m^3", [-2, 1, -2];
    /// A force, N, or N/m per metre of thickness in two dimensions.
    Force, "a force", "N", "10 kN", [1, 1, -2] [0, 1, -2];
    /// An energy per area (fracture energy), J/m².
    FractureEnergy, "an energy per area", "J/m^2", "100 J/m^2", [0, 1, -2];
    /// An acceleration, m/s².
    Acceleration, "an acceleration", "m/s^2", "9.81 m/s^2", [1, 0, -2];
    /// A volume rate, m³/s, or m²/s per metre of thickness in two dimensions.
    FlowRate, "a flow rate", "m^3/s", "1 L/s", [3, 0, -1] [2, 0, -1];
}

impl Dimension for dimension::Angle {
    const ID: &'static str = "Angle";
    const NAME: &'static str = "an angle";
    const UNIT: &'static str = "rad";
    const EXAMPLE: &'static str = "30 deg";
    const ACCEPTED: &'static [Exponents] = &[Exponents::ANGLE];
}
/// An angle, rad.
pub type Angle = Quantity<dimension::Angle>;

impl<'de, D: Dimension> Deserialize<'de> for Quantity<D> {
    fn deserialize<R: Deserializer<'de>>(reader: R) -> Result<Self, R::Error> {
        let Spanned { value, span } = Spanned::<Bare<D>>::deserialize(reader)?;
        Ok(Self {
            value: value.value,
            span,
            accepted: value.accepted,
            dimension: PhantomData,
        })
    }
}

/// A quantity before its place is known.
struct Bare<D> {
    value: f64,
    accepted: usize,
    dimension: PhantomData<D>,
}

impl<D> Bare<D> {
    fn new(value: f64, accepted: usize) -> Self {
        Self {
            value,
            accepted,
            dimension: PhantomData,
        }
    }
}

impl<'de, D: Dimension> Deserialize<'de> for Bare<D> {
    fn deserialize<R: Deserializer<'de>>(reader: R) -> Result<Self, R::Error> {
        reader.deserialize_any(QuantityVisitor(PhantomData))
    }
}

struct QuantityVisitor<D>(PhantomData<D>);

impl<D: Dimension> Visitor<'_> for QuantityVisitor<D> {
    type Value = Bare<D>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&words::<D>())
    }

    #[allow(clippy::cast_precision_loss)]
    fn visit_i64<E: Error>(self, number: i64) -> Result<Bare<D>, E> {
        Ok(Bare::new(number as f64, 0))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Bare<D>, E> {
        if number.is_finite() {
            return bounded::<D, E>(number, 0);
        }
        Err(E::custom(format!(
            "expected {}, found {number}, which is not finite",
            words::<D>()
        )))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Bare<D>, E> {
        let (value, dimension) = units::parse(text).map_err(|error| match error.help() {
            Some(help) => E::custom(format!("{error}{HELP}{help}")),
            None => E::custom(error),
        })?;
        let Some(found) = dimension else {
            return bounded::<D, E>(value, 0);
        };
        match D::ACCEPTED.iter().position(|accepted| *accepted == found) {
            Some(accepted) => bounded::<D, E>(value, accepted),
            None => Err(E::custom(format!(
                "expected {}, found {}: \"{text}\"{HELP}write it like {}",
                words::<D>(),
                found.describe(),
                example::<D>(),
            ))),
        }
    }
}

/// Decades above and below 1 in which products of several quantities neither overflow nor vanish.
const MOST_DECADES: i32 = 50;

/// A quantity that can be computed with.
fn bounded<D: Dimension, E: Error>(value: f64, accepted: usize) -> Result<Bare<D>, E> {
    let most = 10.0_f64.powi(MOST_DECADES);
    if value.abs() <= most && (value.abs() >= 1.0 / most || value.abs() <= 0.0) {
        return Ok(Bare::new(value, accepted));
    }
    let words = words::<D>();
    Err(E::custom(format!(
        "expected {words}, found {value:e}{HELP}nothing above 1e{MOST_DECADES} or below \
         1e-{MOST_DECADES} can be computed with"
    )))
}

/// "a pressure (Pa)".
fn words<D: Dimension>() -> String {
    if D::UNIT.is_empty() {
        D::NAME.to_owned()
    } else {
        format!("{} ({})", D::NAME, D::UNIT)
    }
}

fn example<D: Dimension>() -> String {
    if D::UNIT.is_empty() {
        D::EXAMPLE.to_owned()
    } else {
        format!("\"{}\"", D::EXAMPLE)
    }
}

impl<D> serde::Serialize for Quantity<D> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.value)
    }
}

impl<D: Dimension> JsonSchema for Quantity<D> {
    fn schema_name() -> Cow<'static, str> {
        D::ID.into()
    }
    fn schema_id() -> Cow<'static, str> {
        format!("{}::{}", module_path!(), D::ID).into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let unit = if D::UNIT.is_empty() { "1" } else { D::UNIT };
        let symbols = units::symbols_of(D::ACCEPTED).join(", ");
        let symbols = match symbols.is_empty() {
            true => symbols,
            false => format!("; symbols: {symbols}"),
        };
        json_schema!({
            "type": ["number", "string"],
            "description": format!(
                "{}: a number in {unit}, or a text with a unit such as \"{}\"{symbols}",
                D::NAME,
                D::EXAMPLE
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;
    use crate::scene::reader::read;
    use crate::scene::tree::parse;

    fn quantity<D: Dimension>(toml: &str) -> Result<f64, (String, Option<String>)> {
        #[derive(serde::Deserialize)]
        #[serde(bound = "D: Dimension")]
        struct Holder<D> {
            q: Quantity<D>,
        }
        let text = format!("q = {toml}");
        let root = parse(&text, 0).unwrap();
        let holder = read::<Holder<D>>(&root).map_err(|error| {
            let place = error.diagnostic.place.unwrap();
            assert_eq!(&text[place.start..place.end], toml);
            (
                error.diagnostic.message.clone(),
                error.diagnostic.help.clone(),
            )
        })?;
        let span = holder.q.span();
        assert_eq!(&text[span.start..span.end], toml);
        Ok(holder.q.value())
    }

    #[test]
    fn a_bare_number_is_si_and_a_text_has_a_unit() {
        assert_eq!(quantity::<dimension::Pressure>("5").unwrap(), 5.0);
        assert_eq!(quantity::<dimension::Pressure>("5.5").unwrap(), 5.5);
        assert_eq!(quantity::<dimension::Pressure>("\"5 MPa\"").unwrap(), 5e6);
        assert_eq!(quantity::<dimension::Pressure>("\"5\"").unwrap(), 5.0);
        assert_eq!(quantity::<dimension::Number>("\"15 %\"").unwrap(), 0.15);
        assert_eq!(quantity::<dimension::FlowRate>("\"2 m^2/s\"").unwrap(), 2.0);
        assert_eq!(quantity::<dimension::FlowRate>("\"2 m^3/s\"").unwrap(), 2.0);
    }

    #[test]
    fn a_wrong_dimension_is_named() {
        let (message, help) = quantity::<dimension::Pressure>("\"3 m\"").unwrap_err();
        assert_eq!(message, "expected a pressure (Pa), found a length: \"3 m\"");
        assert_eq!(help.unwrap(), "write it like \"10 MPa\"");
        let (message, _) = quantity::<dimension::Number>("\"3 m\"").unwrap_err();
        assert_eq!(
            message,
            "expected a number without unit, found a length: \"3 m\""
        );
        let (message, _) = quantity::<dimension::Length>("\"3 kg m^5\"").unwrap_err();
        assert!(message.contains("found a quantity in kg m^5"), "{message}");
    }

    #[test]
    fn a_misspelt_unit_gets_a_suggestion() {
        let (message, help) = quantity::<dimension::Viscosity>("\"1 cp\"").unwrap_err();
        assert_eq!(message, "unknown unit `cp` in \"1 cp\"");
        assert_eq!(help.unwrap(), "did you mean `cP`?");
    }

    #[test]
    fn what_is_no_finite_number_is_refused() {
        for (toml, message) in [
            ("inf", "expected a time (s), found inf, which is not finite"),
            ("nan", "expected a time (s), found NaN, which is not finite"),
            (
                "1e999",
                "expected a time (s), found inf, which is not finite",
            ),
            ("1e60", "expected a time (s), found 1e60"),
            ("-1e-60", "expected a time (s), found -1e-60"),
            ("\"1e60 h\"", "expected a time (s), found 3.6e63"),
            ("true", "expected a time (s), found true"),
            ("[1]", "expected a time (s), found a list"),
            ("{}", "expected a time (s), found a table"),
        ] {
            assert_eq!(
                quantity::<dimension::Time>(toml).unwrap_err().0,
                message,
                "{toml}"
            );
        }
    }
}
