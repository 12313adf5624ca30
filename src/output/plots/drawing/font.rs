//! The embedded typeface and its way onto the backends.

use std::convert::Infallible;
use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};
use plotters_backend::text_anchor::{HPos, Pos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendTextStyle, FontFamily, FontStyle, FontTransform,
};

use super::Drawn;

/// Height of the capitals of the embedded typeface as a part of the font size.
const CAPITAL_HEIGHT: f64 = 0.729;

/// The SVG backend divides the font size by this factor.
const SVG_SIZE_FACTOR: f64 = 1.24;

fn face(bold: bool) -> Drawn<&'static FontRef<'static>> {
    static REGULAR: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    static BOLD: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    let loaded = if bold {
        BOLD.get_or_init(|| FontRef::try_from_slice(dejavu::sans::bold()).ok())
    } else {
        REGULAR.get_or_init(|| FontRef::try_from_slice(dejavu::sans::regular()).ok())
    };
    loaded
        .as_ref()
        .ok_or_else(|| "the embedded typeface cannot be read".to_owned())
}

/// The scale at which one em is `size` pixels; the library counts in line heights instead.
fn scale(font: &FontRef<'_>, size: f64) -> PxScale {
    let em = font.units_per_em().unwrap_or(font.height_unscaled());
    PxScale::from(size as f32 * font.height_unscaled() / em)
}

/// Width of one line of text in pixels.
pub(super) fn text_width(text: &str, size: f64, bold: bool) -> Drawn<f64> {
    let font = face(bold)?;
    let scaled = font.as_scaled(scale(font, size));
    let mut width = 0.0;
    let mut previous = None;
    for character in text.chars() {
        let glyph = scaled.glyph_id(character);
        width += previous.map_or(0.0, |before| scaled.kern(before, glyph));
        width += scaled.h_advance(glyph);
        previous = Some(glyph);
    }
    Ok(f64::from(width))
}

/// Breaks a text into lines no wider than `width`; a single longer word stays whole.
pub(super) fn wrap(text: &str, size: f64, bold: bool, width: f64) -> Drawn<Vec<String>> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let joined = lines.last().map(|line| format!("{line} {word}"));
        match (joined, lines.last_mut()) {
            (Some(joined), Some(last)) if text_width(&joined, size, bold)? <= width => {
                *last = joined;
            }
            _ => lines.push(word.to_owned()),
        }
    }
    Ok(lines)
}

/// How a text is set, in units of the backend; it is always centred on the capitals.
#[derive(Clone)]
pub(super) struct BackendText {
    pub size: f64,
    pub bold: bool,
    pub upwards: bool,
    pub anchor: HPos,
    pub colour: BackendColor,
}

impl BackendTextStyle for BackendText {
    type FontError = Infallible;

    fn color(&self) -> BackendColor {
        self.colour
    }

    fn size(&self) -> f64 {
        self.size * SVG_SIZE_FACTOR
    }

    fn transform(&self) -> FontTransform {
        if self.upwards {
            FontTransform::Rotate270
        } else {
            FontTransform::None
        }
    }

    fn style(&self) -> FontStyle {
        if self.bold {
            FontStyle::Bold
        } else {
            FontStyle::Normal
        }
    }

    fn anchor(&self) -> Pos {
        Pos::new(self.anchor, VPos::Center)
    }

    fn family(&self) -> FontFamily<'_> {
        FontFamily::Name("DejaVu Sans, Verdana, Arial, sans-serif")
    }

    fn layout_box(&self, text: &str) -> Result<((i32, i32), (i32, i32)), Infallible> {
        let width = text_width(text, self.size, self.bold)
            .unwrap_or(0.0)
            .round() as i32;
        Ok(((0, 0), (width, (self.size * CAPITAL_HEIGHT).round() as i32)))
    }

    fn draw<E, DrawFunc: FnMut(i32, i32, BackendColor) -> Result<(), E>>(
        &self,
        text: &str,
        (left, top): BackendCoord,
        mut draw: DrawFunc,
    ) -> Result<Result<(), E>, Infallible> {
        let Ok(font) = face(self.bold) else {
            return Ok(Ok(()));
        };
        let scale = scale(font, self.size);
        let scaled = font.as_scaled(scale);
        let baseline = (self.size * CAPITAL_HEIGHT).round() as f32;
        let (mut pen, mut previous) = (0.0, None);
        for character in text.chars() {
            let id = scaled.glyph_id(character);
            pen += previous.map_or(0.0, |before| scaled.kern(before, id));
            previous = Some(id);
            let glyph = id.with_scale_and_position(scale, point(pen, baseline));
            pen += scaled.h_advance(id);
            let Some(outline) = font.outline_glyph(glyph) else {
                continue;
            };
            let corner = outline.px_bounds().min;
            let mut outcome = Ok(());
            outline.draw(|x, y, coverage| {
                let place = (
                    corner.x as i32 + x as i32 + left,
                    corner.y as i32 + y as i32 + top,
                );
                let alpha = f64::from(coverage.clamp(0.0, 1.0)) * self.colour.alpha;
                if outcome.is_ok() && alpha > 0.0 {
                    let colour = BackendColor {
                        alpha,
                        rgb: self.colour.rgb,
                    };
                    outcome = draw(place.0, place.1, colour);
                }
            });
            if outcome.is_err() {
                return Ok(outcome);
            }
        }
        Ok(Ok(()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_typeface_has_every_sign_the_plots_use() {
        for bold in [false, true] {
            let font = face(bold).unwrap();
            for sign in "0123456789−×·⁻⁰¹²³⁴⁵⁶⁷⁸⁹µ≤[]()/°Δσεφκαβ…–".chars()
            {
                assert_ne!(font.glyph_id(sign).0, 0, "{sign} is missing");
            }
        }
    }

    #[test]
    fn widths_grow_with_text_and_size() {
        let short = text_width("MPa", 16.0, false).unwrap();
        let long = text_width("MPa MPa", 16.0, false).unwrap();
        assert!(long > 2.0 * short);
        let twice = text_width("MPa", 32.0, false).unwrap();
        assert!((twice - 2.0 * short).abs() < 0.1, "{short} {twice}");
    }

    #[test]
    fn wrapped_lines_fit_and_lose_no_word() {
        let text = "a title that is much too long for the narrow picture it was given";
        let lines = wrap(text, 20.0, true, 200.0).unwrap();
        assert!(lines.len() > 2);
        assert!(
            lines
                .iter()
                .all(|l| text_width(l, 20.0, true).unwrap() <= 200.0)
        );
        assert_eq!(lines.join(" "), text);
    }
}
