//! The frame of the checks: each section states its own rules once, in its own file, with the
//! words given here. All faults are gathered; none hides another.

use std::collections::BTreeSet;

use super::diagnostics::Diagnostic;
use super::draft::Draft;
use super::load::Load;
use super::quantity::{Dimension, Length, Quantity, values};
use super::sections::{Bounds, Geometry};
use super::shape::Shape;
use super::span::{Named, Span, Spanned};
use super::suggest::one_of;

/// A section of the scene and its rules.
pub(super) trait Section {
    /// Key of the section in the file.
    const NAME: &'static str;

    /// Reports every rule that the section breaks; `place` is its heading.
    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report);
}

/// What a section may ask about the others.
pub(super) struct Context<'a> {
    pub draft: &'a Draft,
    /// Sections in which there is a fault already; nothing more is concluded from them.
    pub faulty: &'a BTreeSet<String>,
}

impl<'a> Context<'a> {
    /// The section, if it was typed and could be read as a whole.
    pub(super) fn sound<T: Section>(&self, section: &'a Option<Spanned<T>>) -> Option<&'a T> {
        section
            .as_ref()
            .filter(|_| !self.faulty.contains(T::NAME))
            .map(|section| &section.value)
    }

    /// Whether the section was typed, with faults or without.
    pub(super) fn has<T: Section>(&self, section: &Option<Spanned<T>>) -> bool {
        section.is_some() || self.faulty.contains(T::NAME)
    }

    /// Space dimension, where the geometry tells it.
    pub(super) fn dimension(&self) -> Option<usize> {
        self.sound(&self.draft.geometry)?
            .dimension()
            .filter(|dimension| (2..=3).contains(dimension))
    }

    /// Corners of the domain, where the geometry tells them.
    pub(super) fn bounds(&self) -> Option<Bounds> {
        let bounds = self.sound(&self.draft.geometry)?.bounds()?;
        bounds
            .min
            .iter()
            .zip(&bounds.max)
            .all(|(low, high)| low < high)
            .then_some(bounds)
    }
}

/// The faults found so far, and the words for the common rules.
#[derive(Default)]
pub(super) struct Report {
    pub faults: Vec<Diagnostic>,
}

impl Report {
    pub(super) fn add(&mut self, fault: Diagnostic) {
        self.faults.push(fault);
    }

    pub(super) fn positive<D: Dimension>(&mut self, name: &str, quantity: Quantity<D>) {
        if quantity.value() <= 0.0 {
            self.add(Diagnostic::new(format!("`{name}` must be positive")).at(quantity.span()));
        }
    }

    pub(super) fn all_positive<D: Dimension>(&mut self, name: &str, list: &[Quantity<D>]) {
        list.iter()
            .for_each(|quantity| self.positive(name, *quantity));
    }

    pub(super) fn not_negative<D: Dimension>(&mut self, name: &str, quantity: Quantity<D>) {
        if quantity.value() < 0.0 {
            self.add(Diagnostic::new(format!("`{name}` must not be negative")).at(quantity.span()));
        }
    }

    /// Other sections without which `section` has no meaning, and whether they were typed.
    pub(super) fn needs(&mut self, section: &str, place: Span, others: &[(&str, bool)]) {
        for (other, _) in others.iter().filter(|(_, typed)| !typed) {
            let fault = Diagnostic::new(format!("{section} needs {other}")).at(place);
            self.add(fault.help(format!("add {other}, or leave {section} out")));
        }
    }

    pub(super) fn at_least(&mut self, name: &str, number: Spanned<u64>, low: u64) {
        if number.value < low {
            let message = format!("`{name}` must be at least {low}, found {}", number.value);
            self.add(Diagnostic::new(message).at(number.span));
        }
    }

    /// As many components as the domain has dimensions; true if so or if that is not known.
    pub(super) fn vector<T>(
        &mut self,
        name: &str,
        vector: &Spanned<Vec<T>>,
        dimension: Option<usize>,
    ) -> bool {
        let found = vector.len();
        let message = match dimension {
            Some(dimension) if found != dimension => {
                format!("`{name}` needs {dimension} components, found {found}")
            }
            None if !(2..=3).contains(&found) => {
                format!("`{name}` needs 2 or 3 components, found {found}")
            }
            _ => return true,
        };
        self.add(Diagnostic::new(message).at(vector.span));
        false
    }

    /// The right number of components, and in the domain where that is known.
    pub(super) fn position(&mut self, name: &str, at: &Spanned<Vec<Length>>, scene: &Context<'_>) {
        if !self.vector(name, at, scene.dimension()) {
            return;
        }
        if let Some(bounds) = scene.bounds()
            && !bounds.contain(&values(at))
        {
            let message = format!("`{name}` lies outside the domain");
            self.add(
                Diagnostic::new(message)
                    .at(at.span)
                    .help(format!("the domain is {bounds}")),
            );
        }
    }

    /// `min` below `max` along every axis.
    pub(super) fn corners(
        &mut self,
        min: &Spanned<Vec<Length>>,
        max: &Spanned<Vec<Length>>,
        dimension: Option<usize>,
    ) {
        let both = [
            self.vector("min", min, dimension),
            self.vector("max", max, dimension),
        ];
        if both == [true, true] && min.len() != max.len() {
            self.vector("max", max, Some(min.len()));
        } else if min
            .iter()
            .zip(max.iter())
            .any(|(low, high)| low.value() >= high.value())
        {
            let fault = Diagnostic::new("`max` must be greater than `min` along every axis");
            self.add(fault.at(max.span).also(min.span, "`min`"));
        }
    }

    pub(super) fn shape(&mut self, shape: &Shape, scene: &Context<'_>) {
        let dimension = scene.dimension();
        match shape {
            Shape::Box(shape) => self.corners(&shape.min, &shape.max, dimension),
            Shape::Disc(shape) => {
                self.vector("centre", &shape.centre, dimension);
                self.positive("radius", shape.radius);
            }
            Shape::Set(shape) => {
                let geometry = scene.sound(&scene.draft.geometry);
                if geometry.is_some_and(|own| !matches!(own, Geometry::Mesh(_))) {
                    let fault = Diagnostic::new("only a mesh has sets").at(shape.name.span);
                    self.add(fault.help("use another shape, or geometry.type = \"mesh\""));
                }
            }
            Shape::Polygon(shape) => {
                if shape.vertices.len() < 3 {
                    let fault = Diagnostic::new("a polygon needs at least three `vertices`");
                    self.add(fault.at(shape.vertices.span));
                }
            }
            Shape::HalfPlane(shape) => {
                self.vector("point", &shape.point, dimension);
                self.vector("normal", &shape.normal, dimension);
                if shape
                    .normal
                    .iter()
                    .all(|component| component.value() == 0.0)
                {
                    let fault = Diagnostic::new("`normal` must not be zero");
                    self.add(fault.at(shape.normal.span));
                }
            }
        }
    }

    /// Times that increase, a value for each; in a steady run no change in time.
    pub(super) fn load<D: Dimension>(&mut self, load: &Load<D>, scene: &Context<'_>) {
        let steady = scene
            .sound(&scene.draft.time)
            .is_some_and(|time| time.is_steady());
        if steady && !load.resolved().is_constant() {
            let fault = Diagnostic::new("a steady run needs loads that are constant in time");
            self.add(fault.at(load.span()));
        }
        let Load::Time(series) = load else { return };
        let (times, count) = (values(&series.time), series.value.len());
        if times.is_empty() {
            self.add(Diagnostic::new("`time` needs at least one entry").at(series.time.span));
        } else if times.len() != count {
            let message = format!(
                "`value` needs one entry for each of the {} times, found {count}",
                times.len()
            );
            let fault = Diagnostic::new(message).at(series.value.span);
            self.add(fault.also(series.time.span, "the times"));
        }
        if let Some(index) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
            let fault = Diagnostic::new("`time` must increase from entry to entry");
            self.add(fault.at(series.time[index + 1].span()));
        }
    }

    /// A file name with one of the endings.
    pub(super) fn file(&mut self, name: &str, path: &Spanned<String>, endings: &[&str]) {
        let ending = path.rsplit_once('.').map_or("", |(_, ending)| ending);
        if !endings
            .iter()
            .any(|known| known.eq_ignore_ascii_case(ending))
        {
            let message = format!("`{name}` must be a file ending in {}", one_of(endings));
            self.add(Diagnostic::new(message).at(path.span));
        }
    }

    /// Names that can stand in file names and column headings.
    pub(super) fn names<T>(&mut self, named: &Named<T>) {
        for entry in named {
            let sound = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
            if entry.name.is_empty() || !entry.name.chars().all(sound) {
                let message = format!("the name `{}` cannot be used in a file name", entry.name);
                let fault = Diagnostic::new(message).at(entry.span);
                self.add(fault.help("use letters, digits, `-` and `_`"));
            }
        }
    }

    /// At most one of several keys; `true` if there is exactly one.
    pub(super) fn at_most_one(&mut self, given: &[(&str, Option<Span>)]) -> bool {
        let mut typed = given
            .iter()
            .filter_map(|(name, span)| span.map(|span| (*name, span)));
        let Some((first, place)) = typed.next() else {
            return false;
        };
        let mut only = true;
        for (second, span) in typed {
            only = false;
            let fault = Diagnostic::new(format!("`{first}` excludes `{second}`")).at(span);
            self.add(fault.also(place, "given here").help("keep one of them"));
        }
        only
    }
}

/// A number as one would write it: `0`, `0.4`, `1e-12`, `1e6`.
pub(super) fn short(number: f64) -> String {
    let plain = format!("{number:?}");
    let plain = plain.strip_suffix(".0").unwrap_or(&plain);
    let power = format!("{number:e}");
    match power.len() + 1 < plain.len() {
        true => power,
        false => plain.to_owned(),
    }
}
