//! The model of a run as a picture: points by material, what holds on sides, wells, probes and cracks.

use super::pictures::Pictures;
use super::sections::Section;
use crate::geometry::Side;
use crate::output::{About, OutputError, SetupMark, SetupPlot, SideSign, Sign, setup_png};
use crate::plan::{Load, Plan, SideCondition, Support, TractionPlan};

const WIDTH: u32 = 900;

/// A condition of a side with its words.
type Told = (Side, SideSign, &'static str);

/// Draws the model in all sections.
///
/// # Errors
/// Those of [`setup_png`].
pub(super) fn draw<const D: usize>(pictures: &Pictures<'_, D>) -> Result<(), OutputError> {
    pictures
        .sections
        .all
        .iter()
        .try_for_each(|section| of_section(pictures, section))
}

fn of_section<const D: usize>(
    pictures: &Pictures<'_, D>,
    section: &Section,
) -> Result<(), OutputError> {
    let Pictures {
        folder,
        plan,
        model,
        ..
    } = *pictures;
    let mut groups: Vec<String> = plan.materials.iter().map(|own| own.name.clone()).collect();
    let held = held(pictures, section);
    let group = |(point, held): (&u32, &bool)| match held {
        true => groups.len(),
        false => usize::from(model.material[*point as usize]),
    };
    let group: Vec<usize> = section.points.iter().zip(&held).map(group).collect();
    if held.contains(&true) {
        groups.push("pressure held".to_owned());
    }
    let told = sides(pictures, section);
    let lines = section.cracks(plan);
    let mut notes = notes(&told);
    notes.extend((!lines.is_empty()).then(|| "dark lines: cracks from the start".to_owned()));
    let plot = SetupPlot {
        title: &format!("{}: points and conditions{}", plan.title, section.name()),
        axes: section.axes(),
        positions: &section.positions(model),
        sizes: &section.sizes(model),
        group: &group,
        groups: &groups,
        sides: &told.iter().map(|own| own.1).collect::<Vec<_>>(),
        marks: &marks(plan, section),
        lines: &lines,
        outlines: section.outlines(plan),
        notes: &notes,
        width_px: WIDTH,
    };
    setup_png(
        folder.join(format!("setup{}.png", section.picture_suffix())),
        &plot,
    )
}

/// Which points lie in regions where the pressure is held.
fn held<const D: usize>(pictures: &Pictures<'_, D>, section: &Section) -> Vec<bool> {
    let regions = || pictures.plan.flow.iter().flat_map(|flow| &flow.regions);
    let place = |point: &u32| &pictures.model.cloud.position[*point as usize];
    let within = |point: &u32| regions().any(|own| own.region.contains(place(point).as_slice()));
    section.points.iter().map(within).collect()
}

/// Conditions of the sides that the section meets, and loads on parts of them.
fn sides<const D: usize>(pictures: &Pictures<'_, D>, section: &Section) -> Vec<Told> {
    let plan = pictures.plan;
    let across = section.across();
    let mut told = Vec::new();
    for side in Side::all(D).filter(|side| across.contains(&side.axis)) {
        let axis = usize::from(side.axis == across[1]);
        let domain = &pictures.model.cloud.domain;
        let along = across[1 - axis];
        let span = [domain.lower[along], domain.upper[along]];
        let sign = |(sign, about)| SideSign {
            axis,
            upper: side.outward() > 0.0,
            span,
            sign,
            about,
        };
        if let Some(mechanics) = &plan.mechanics {
            let solid = solid(&mechanics.sides[side.index()], side, across);
            told.extend(solid.map(|(own, words)| (side, sign(own), words)));
            for load in mechanics.loads.iter().filter(|load| load.side == side) {
                let part = SideSign {
                    span: part(pictures, section, load, along).unwrap_or(span),
                    ..sign((Sign::Arrows(directed(&load.traction, across)), About::Load))
                };
                told.push((side, part, "traction on a part"));
            }
        }
        if let Some(flow) = &plan.flow {
            let fluid = fluid(&flow.sides[side.index()], side, across);
            told.extend(fluid.map(|(own, words)| (side, sign(own), words)));
        }
    }
    told
}

/// Sign and words of a mechanical condition; nothing on a free side.
fn solid(
    support: &Support,
    side: Side,
    across: [usize; 2],
) -> Option<((Sign, About), &'static str)> {
    let normal = |load: &Load| {
        let mut direction = [0.0; 2];
        direction[usize::from(side.axis == across[1])] = strongest(load);
        Sign::Arrows(direction)
    };
    Some(match support {
        Support::Free => return None,
        Support::Traction(loads) => {
            if loads.iter().all(Load::is_zero) {
                return None;
            }
            (
                (Sign::Arrows(directed(loads, across)), About::Load),
                "traction",
            )
        }
        Support::Roller(load) if load.is_zero() => ((Sign::Circles, About::Support), "roller"),
        Support::Roller(load) => ((normal(load), About::Motion), "moved along its normal"),
        Support::Prescribed(loads) if loads.iter().all(Load::is_zero) => {
            ((Sign::Bar, About::Support), "clamped")
        }
        Support::Prescribed(loads) => (
            (Sign::Arrows(directed(loads, across)), About::Motion),
            "moved",
        ),
        Support::Plate(load) => ((normal(load), About::Load), "force on a rigid plate"),
    })
}

/// Sign and words of a condition of flow; nothing on a sealed side.
fn fluid(
    condition: &SideCondition,
    side: Side,
    across: [usize; 2],
) -> Option<((Sign, About), &'static str)> {
    Some(match condition {
        SideCondition::Sealed => return None,
        SideCondition::Pressure { hydrostatic, .. } => {
            let words = match hydrostatic {
                true => "hydrostatic pressure",
                false => "pressure",
            };
            ((Sign::Bar, About::Fluid), words)
        }
        SideCondition::Flux(load) if load.is_zero() => return None,
        SideCondition::Flux(load) => {
            let mut direction = [0.0; 2];
            let inwards = -side.outward();
            direction[usize::from(side.axis == across[1])] = inwards * strongest(load);
            ((Sign::Arrows(direction), About::Fluid), "flux")
        }
    })
}

/// The value of a load that is farthest from zero.
fn strongest(load: &Load) -> f64 {
    let larger = |a: f64, b: &f64| if b.abs() > a.abs() { *b } else { a };
    load.values().iter().fold(0.0, larger)
}

/// Direction of a vector of loads in the picture.
fn directed(loads: &[Load], across: [usize; 2]) -> [f64; 2] {
    across.map(|axis| loads.get(axis).map_or(0.0, strongest))
}

/// From where to where along the side a load acts, m.
fn part<const D: usize>(
    pictures: &Pictures<'_, D>,
    section: &Section,
    load: &TractionPlan,
    along: usize,
) -> Option<[f64; 2]> {
    let region = load.region.as_ref()?;
    let cloud = &pictures.model.cloud;
    let end = match load.side.outward() > 0.0 {
        true => cloud.domain.upper[load.side.axis],
        false => cloud.domain.lower[load.side.axis],
    };
    let mut span = [f64::INFINITY, f64::NEG_INFINITY];
    for point in &section.points {
        let half = 0.5 * cloud.cell[*point as usize];
        let mut place = cloud.position[*point as usize];
        if (place[load.side.axis] - end).abs() > 1.01 * half[load.side.axis] {
            continue;
        }
        place[load.side.axis] = end;
        if region.contains(place.as_slice()) {
            span[0] = span[0].min(place[along] - half[along]);
            span[1] = span[1].max(place[along] + half[along]);
        }
    }
    (span[0] < span[1]).then_some(span)
}

/// One remark for each kind of sign: what it looks like, what it means and on which sides it is.
fn notes(told: &[Told]) -> Vec<String> {
    let mut notes: Vec<(String, Vec<String>)> = Vec::new();
    for (side, sign, words) in told {
        let look = match (sign.sign, sign.about) {
            (Sign::Bar, About::Fluid) => "blue bar",
            (Sign::Bar, _) => "dark bar",
            (Sign::Circles, _) => "circles",
            (Sign::Arrows(_), About::Fluid) => "blue arrows",
            (Sign::Arrows(_), About::Load) => "green arrows",
            (Sign::Arrows(_), _) => "orange arrows",
        };
        let kind = format!("{look}: {words}");
        match notes.iter_mut().find(|own| own.0 == kind) {
            Some((_, sides)) => sides.push(side.to_string()),
            None => notes.push((kind, vec![side.to_string()])),
        }
    }
    let line = |(kind, sides): (String, Vec<String>)| format!("{kind} ({})", sides.join(", "));
    notes.into_iter().map(line).collect()
}

/// Wells, places of injection and probes; in space all of them, seen along the normal of the section.
fn marks(plan: &Plan, section: &Section) -> Vec<SetupMark> {
    let across = section.across();
    let mark = |at: &[f64], label: String, about| {
        let at = across.map(|axis| at.get(axis).copied());
        let [Some(x), Some(y)] = at else { return None };
        Some(SetupMark {
            at: [x, y],
            label,
            about,
        })
    };
    let wells = plan.wells.iter();
    let wells = wells.map(|well| mark(&well.at, format!("well {}", well.name), About::Fluid));
    let pumped = plan.cracks.iter().filter_map(|crack| {
        let injection = crack.injection.as_ref()?;
        Some(mark(
            &injection.at,
            format!("injection into {}", crack.name),
            About::Fluid,
        ))
    });
    let probes = plan.output.probes.iter();
    let probes = probes.map(|own| mark(&own.at, format!("probe {}", own.name), About::Support));
    wells.chain(pumped).chain(probes).flatten().collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    const TOP: Side = Side {
        axis: 1,
        upper: true,
    };

    #[test]
    fn conditions_have_their_signs_and_free_or_sealed_sides_none() {
        let fixed = Support::Prescribed(vec![Load::constant(0.0); 2]);
        let own = |support: &Support| solid(support, TOP, [0, 1]);
        assert_eq!(own(&fixed), Some(((Sign::Bar, About::Support), "clamped")));
        assert_eq!(own(&Support::Free), None);
        let still = Support::Traction(vec![Load::constant(0.0); 2]);
        assert_eq!(own(&still), None);
        let down = Load::table(vec![0.0, 1.0], vec![0.0, -2.0]);
        let (plate, words) = own(&Support::Plate(down.clone())).unwrap();
        assert_eq!(plate, (Sign::Arrows([0.0, -2.0]), About::Load));
        assert_eq!(words, "force on a rigid plate");
        assert_eq!(fluid(&SideCondition::Sealed, TOP, [0, 1]), None);
        // Two into the domain through the top is down.
        let flux = SideCondition::Flux(Load::constant(2.0));
        let (sign, _) = fluid(&flux, TOP, [0, 1]).unwrap();
        assert_eq!(sign, (Sign::Arrows([0.0, -2.0]), About::Fluid));
    }

    #[test]
    fn sides_with_the_same_condition_share_a_remark() {
        let sign = SideSign {
            axis: 1,
            upper: true,
            span: [0.0, 1.0],
            sign: Sign::Circles,
            about: About::Support,
        };
        let bottom = Side {
            axis: 1,
            upper: false,
        };
        let told = [(TOP, sign, "roller"), (bottom, sign, "roller")];
        assert_eq!(notes(&told), ["circles: roller (top, bottom)"]);
    }
}
