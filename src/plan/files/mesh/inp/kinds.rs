//! Forms of Abaqus's elements by the names of their types.

use crate::plan::files::mesh::ElementKind;

/// Families of elements that fill a plane or space, or are edges, with their dimension; longer names first.
const FAMILIES: [(&str, usize); 16] = [
    ("SFM3D", 2),
    ("STRI", 2),
    ("AC2D", 2),
    ("AC3D", 3),
    ("DC2D", 2),
    ("DC3D", 3),
    ("CPEG", 2),
    ("C3D", 3),
    ("CPS", 2),
    ("CPE", 2),
    ("M3D", 2),
    ("R3D", 2),
    ("R2D", 1),
    ("T2D", 1),
    ("T3D", 1),
    ("S", 2),
];

/// Form of elements by the name of their type: letters that tell the family, then the number of nodes.
///
/// # Errors
/// What to do about a type that is no element with straight edges.
pub(super) fn kind_of(name: &str) -> Result<ElementKind, &'static str> {
    let upper = name.to_uppercase();
    let known = FAMILIES.iter().find_map(|(prefix, dimension)| {
        let rest = upper.strip_prefix(prefix)?;
        let digits = rest.find(|c: char| !c.is_ascii_digit());
        let digits = digits.unwrap_or(rest.len());
        Some((*dimension, rest[..digits].parse::<usize>().ok()?))
    });
    Ok(match known {
        Some((1, 2)) => ElementKind::Line,
        Some((2, 3)) => ElementKind::Triangle,
        Some((2, 4)) => ElementKind::Quadrilateral,
        Some((3, 4)) => ElementKind::Tetrahedron,
        Some((3, 5)) => ElementKind::Pyramid,
        Some((3, 6)) => ElementKind::Wedge,
        Some((3, 8)) => ElementKind::Hexahedron,
        Some(_) => {
            return Err("mesh with elements of first order, such as CPE3, CPE4, C3D4 or C3D8");
        }
        None => return Err("mesh with solid elements, such as CPE3, CPE4, C3D4 or C3D8"),
    })
}
