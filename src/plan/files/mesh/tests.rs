use std::path::{Path, PathBuf};

use super::*;

/// Two squares of 1 m side by side, the right one as two triangles, an edge on the right, and a node that
/// nothing has. Numbers are sparse.
const TEXT: &str = r#"$MeshFormat
4.1 0 8
$EndMeshFormat
$Comments
anything at all
$EndComments
$PhysicalNames
3
1 4 "outlet"
2 1 "sand"
2 2 "clay and silt"
$EndPhysicalNames
$Entities
1 1 2 0
1 0 0 0 0
3 2 0 0 2 1 0 1 4 0
5 0 0 0 1 1 0 1 1 0
6 1 0 0 2 1 0 1 -2 1 3
$EndEntities
$Nodes
1 7 1 18446744073709551615
2 5 0 7
1
2
30
4
500
6
18446744073709551615
0 0 0
1 0 0
2 0 0
0 1 0
1 1 0
2 1 0
99 99 99
$EndNodes
$Elements
3 4 1 4
2 5 3 1
1 1 2 500 4
2 6 2 2
2 2 30 500
3 500 30 6
1 3 1 1
4 30 6
$EndElements
"#;

fn written(name: &str, bytes: impl AsRef<[u8]>) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Result<MeshTable, FileError> {
    let (_folder, path) = written(name, bytes);
    read_mesh(&path, 1.0)
}

fn refused(name: &str, bytes: impl AsRef<[u8]>, parts: &[&str]) {
    let message = read(name, bytes).unwrap_err().to_string();
    for part in parts {
        assert!(message.contains(part), "{part} in {message}");
    }
}

fn set<'a>(mesh: &'a MeshTable, name: &str) -> &'a [u32] {
    let found = mesh
        .sets
        .iter()
        .find(|set| set.name.eq_ignore_ascii_case(name));
    &found
        .unwrap_or_else(|| panic!("{name} in {:?}", mesh.sets))
        .points
}

fn near(found: &[f64], exact: &[f64]) {
    assert_eq!(found.len(), exact.len());
    let off = found.iter().zip(exact).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-12, "{found:?} {exact:?}");
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/meshes")
        .join(name)
}

#[test]
fn cells_become_points_at_their_centroids_and_groups_become_sets() {
    let mesh = read("a.msh", TEXT).unwrap();
    let third = 1.0 / 3.0;
    near(
        &mesh.table.position,
        &[0.5, 0.5, 1.0 + third, third, 2.0 - third, 2.0 * third],
    );
    near(&mesh.table.volume, &[1.0, 0.5, 0.5]);
    assert_eq!(
        mesh.bounds,
        (vec![0.0, 0.0], vec![2.0, 1.0]),
        "nodes that nothing has do not count"
    );
    assert_eq!(set(&mesh, "sand"), [0]);
    assert_eq!(set(&mesh, "clay and silt"), [1, 2]);
    assert_eq!(set(&mesh, "outlet"), [2], "the cell that has the edge");
    near(&mesh.side_area, &[1.0, 1.0, 2.0, 2.0]);
    assert!(mesh.surface.is_empty(), "the cells fill their box");
}

/// A square without its upper right quarter has two faces there; balls beyond them are in the quarter.
#[test]
fn faces_off_the_bounds_are_free_surfaces() {
    let corner = "*NODE\n1,0,0\n2,1,0\n3,2,0\n4,0,1\n5,1,1\n6,2,1\n7,0,2\n8,1,2\n*ELEMENT, TYPE=CPE4\n\
                  1,1,2,5,4\n2,2,3,6,5\n3,4,7,8,5\n";
    let mesh = read("a.inp", corner).unwrap();
    near(&mesh.side_area, &[2.0, 1.0, 2.0, 1.0]);
    let [(one, radius), (other, _)] = &mesh.surface[..] else {
        panic!("{:?}", mesh.surface);
    };
    near(one, &[1.5, 1.5]);
    near(other, &[1.5, 1.5]);
    near(&[*radius], &[0.5]);
}

#[test]
fn a_unit_scales_places_and_volumes() {
    let (_folder, path) = written("a.msh", TEXT);
    let mesh = read_mesh(&path, 1e-3).unwrap();
    near(&mesh.table.volume, &[1e-6, 5e-7, 5e-7]);
    near(&mesh.bounds.1, &[2e-3, 1e-3]);
    near(&mesh.side_area, &[1e-3, 1e-3, 2e-3, 2e-3]);
}

#[test]
fn a_plane_at_another_height_is_flat_and_one_that_rises_is_refused() {
    let nodes = "0 0 0\n1 0 0\n2 0 0\n0 1 0\n1 1 0\n2 1 0\n99";
    let lifted = TEXT.replace(nodes, "0 0 5\n1 0 5\n2 0 5\n0 1 5\n1 1 5\n2 1 5\n99");
    assert_ne!(lifted, TEXT);
    assert_eq!(read("a.msh", lifted).unwrap().table.dimension, 2);
    refused(
        "a.msh",
        TEXT.replace("2 1 0\n99", "2 1 0.5\n99"),
        &["rises", "from z = 0 to 0.5", "constant z"],
    );
}

/// As Gmsh 4.15 writes one mesh: text, binary, and for Abaqus.
#[test]
fn text_binary_and_abaqus_files_of_gmsh_hold_the_same_points() {
    let text = read_mesh(&fixture("hole-coarse.msh"), 1.0).unwrap();
    assert_eq!(text.table.volume.len(), 268);
    let exact = 1.0 - std::f64::consts::PI * 0.01 / 4.0;
    let area: f64 = text.table.volume.iter().sum();
    // Chords of the circle leave out less than a thousandth.
    assert!((area - exact).abs() < 1e-3, "{area}");
    assert_eq!(set(&text, "rock").len(), 268);
    let at = |point: &u32| &text.table.position[2 * *point as usize..][..2];
    let far = set(&text, "hole")
        .iter()
        .map(|point| at(point)[0].hypot(at(point)[1]));
    assert!(
        far.fold(0.0, f64::max) < 0.12,
        "cells at the hole are at its edge"
    );
    let binary = read_mesh(&fixture("hole-coarse-binary.msh"), 1.0).unwrap();
    // Texts have sixteen digits.
    near(&binary.table.position, &text.table.position);
    assert_eq!((&binary.sets, &binary.dual), (&text.sets, &text.dual));
    let abaqus = read_mesh(&fixture("hole-coarse.inp"), 1.0).unwrap();
    near(&abaqus.table.volume, &text.table.volume);
    assert_eq!(set(&abaqus, "rock"), set(&text, "rock"));
    assert_eq!(set(&abaqus, "hole"), set(&text, "hole"));
}

#[test]
fn cells_between_the_points_close_around_inner_nodes_alone() {
    let mesh = read_mesh(&fixture("hole-coarse.msh"), 1.0).unwrap();
    let at = |k: u32| [0, 1].map(|axis| mesh.table.position[2 * k as usize + axis]);
    let area = |ring: &[u32]| {
        let corner = |k: usize| at(ring[k % ring.len()]);
        let cross = |k: usize| corner(k)[0] * corner(k + 1)[1] - corner(k)[1] * corner(k + 1)[0];
        (0..ring.len()).map(cross).sum::<f64>() / 2.0
    };
    let areas: Vec<f64> = mesh.dual.iter().map(|(_, ring)| area(ring)).collect();
    assert!(areas.len() > 90 && areas.iter().all(|area| *area > 0.0));
    let whole: f64 = areas.iter().sum();
    assert!(
        (0.6..0.992).contains(&whole),
        "the border is left out: {whole}"
    );
}

/// A unit cube as one hexahedron, as wedges, and as a pyramid under a flat roof, by hand.
#[test]
fn cells_in_space_have_the_volumes_of_their_form_either_way_round() {
    let cube = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n";
    let hexahedron = format!("{cube}*ELEMENT, TYPE=C3D8R\n1,1,2,3,4,\n5,6,7,8\n");
    let mesh = read("a.inp", hexahedron).unwrap();
    near(&mesh.table.position, &[0.5; 3]);
    near(&mesh.table.volume, &[1.0]);
    near(&mesh.side_area, &[1.0; 6]);
    let turned = format!("{cube}*ELEMENT, TYPE=C3D8\n1,5,6,7,8,1,2,3,4\n");
    near(&read("a.inp", turned).unwrap().table.volume, &[1.0]);
    let wedges = format!("{cube}*ELEMENT, TYPE=C3D6\n1,1,2,3,5,6,7\n2,1,3,4,5,7,8\n");
    near(&read("a.inp", wedges).unwrap().table.volume, &[0.5, 0.5]);
    let pyramid =
        format!("{cube}*ELEMENT, TYPE=C3D5\n1,1,2,3,4,5\n*ELEMENT, TYPE=C3D4\n2,2,3,6,5\n");
    let mesh = read("a.inp", pyramid).unwrap();
    near(&mesh.table.volume, &[1.0 / 3.0, 1.0 / 6.0]);
    // A fifth of the way from the middle of the base, (0.5, 0.5, 0), at three quarters, to the apex.
    near(&mesh.table.position[..3], &[0.375, 0.375, 0.25]);
    let folded = format!("{cube}*ELEMENT, TYPE=C3D8\n7,1,2,4,3,5,6,7,8\n");
    refused("a.inp", folded, &["element 7", "hexahedron", "folded"]);
}

#[test]
fn sets_of_abaqus_hold_ranges_other_sets_and_sides_of_nodes() {
    let text = "** a comment\n*Heading\n nothing\n*Node, nset=ALL\n10, 0., 0.\n20, 1., 0.\n30, 2.D0, 0.\n40, 0., 1.\n\
                50, 1., 1.\n60, 2., 1.\n*Element, type=CPE4, elset=left\n1, 10, 20, 50, 40\n\
                *Element, type=CPE4P, elset=right\n2, 20, 30, 60, 50\n*Elset, elset=both\nLEFT, right\n\
                *Elset, elset=range, generate\n1, 2, 1\n*Nset, nset=top\n40, 50,\n60\n*Nset, nset=far, generate\n30,60,30\n\
                *Solid Section, elset=right, material=clay\n1.,\n*Material, name=clay\n*Elastic\n1e9, 0.3\n";
    let mesh = read("a.inp", text).unwrap();
    near(&mesh.table.position, &[0.5, 0.5, 1.5, 0.5]);
    for (name, points) in [
        ("left", &[0][..]),
        ("both", &[0, 1]),
        ("range", &[0, 1]),
        ("top", &[0, 1]),
        ("far", &[1]),
        ("clay", &[1]),
    ] {
        assert_eq!(set(&mesh, name), points, "{name}");
    }
}

#[test]
fn what_is_not_read_is_refused_by_name_with_a_remedy() {
    let curved = TEXT.replace("2 6 2 2\n", "2 6 9 2\n");
    refused(
        "a.msh",
        curved,
        &["6-node triangle", "Mesh.ElementOrder = 1"],
    );
    refused(
        "a.msh",
        TEXT.replace("4.1 0 8", "2.2 0 8"),
        &["version `2.2`", "msh41"],
    );
    refused(
        "a.inp",
        "*NODE\n1,0,0\n*ELEMENT, TYPE=CPS8\n",
        &["CPS8", "line 3", "first order"],
    );
    refused("a.inp", "*ELEMENT, TYPE=CAX4\n", &["CAX4"]);
    refused("a.inp", "*NODE\n1,0,0\n*NGEN\n1,2\n", &["*NGEN", "line 3"]);
    refused(
        "a.inp",
        "*PART, NAME=a\n*PART, NAME=b\n",
        &["a second *PART"],
    );
    refused(
        "a.inp",
        "*INSTANCE, NAME=a\n1., 0., 0.\n",
        &["instance", "own coordinates"],
    );
    refused("a.stl", "", &["`.stl`", "`.msh`, `.inp` and `.vtu`"]);
}

#[test]
fn elements_that_do_not_fit_are_told_by_number() {
    refused(
        "a.msh",
        TEXT.replace("2 2 30 500", "2 2 30 501"),
        &["element 2 has node 501", "line"],
    );
    refused(
        "a.msh",
        TEXT.replace("30\n4\n", "2\n4\n"),
        &["node 2 is there twice"],
    );
    refused(
        "a.msh",
        TEXT.replace("3 500 30 6", "3 2 500 30"),
        &["element 3", "element 2 has the same nodes"],
    );
    refused(
        "a.msh",
        TEXT.replace("1 1 2 500 4", "1 1 2 4 500"),
        &["element 1", "quadrilateral", "folded"],
    );
    refused(
        "a.msh",
        TEXT.replace("3 500 30 6", "3 1 2 30"),
        &["element 3", "triangle", "enclose nothing"],
    );
    refused(
        "a.msh",
        TEXT.replace("2 1 0\n99", "2 nan 0\n99"),
        &["element 3", "NaN"],
    );
    refused(
        "a.msh",
        TEXT.replace("3 500 30 6", "3 1 30 4"),
        &["overlap"],
    );
}

#[test]
fn files_without_cells_are_empty() {
    let lines = TEXT
        .replace(
            "2 5 3 1\n1 1 2 500 4\n2 6 2 2\n2 2 30 500\n3 500 30 6\n",
            "",
        )
        .replace("3 4 1 4", "1 1 1 1");
    refused("a.msh", lines, &["no triangles"]);
    refused("a.msh", "", &["$MeshFormat"]);
    refused("a.inp", "", &["no triangles"]);
}

/// Counts are not believed before what they count is there.
#[test]
fn every_truncation_and_absurd_count_ends_in_an_error() {
    for end in 0..TEXT.len() - 1 {
        let cut = read("a.msh", &TEXT[..end]);
        assert!(cut.is_err(), "{end}");
    }
    let binary = std::fs::read(fixture("hole-coarse-binary.msh")).unwrap();
    for end in (0..binary.len() - 20).step_by(211) {
        assert!(read("a.msh", &binary[..end]).is_err(), "{end}");
    }
    let endless = TEXT.replace("2 5 0 7\n", "2 5 0 18446744073709551615\n");
    refused("a.msh", endless, &["stands where a node should"]);
}

/// Every polyhedron closes: over its faces, each edge is there twice. Together they fill what inner nodes have around them.
#[test]
fn cells_between_the_points_of_a_mesh_in_space_are_closed_polyhedra() {
    let mesh = read_mesh(&fixture("block.msh"), 1.0).unwrap();
    assert!(mesh.dual.kinds.is_empty() && mesh.dual.solids.len() > 20);
    for solid in &mesh.dual.solids {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for face in solid {
            let next = face.iter().cycle().skip(1);
            edges.extend(face.iter().zip(next).map(|(a, b)| [*a.min(b), *a.max(b)]));
        }
        edges.sort_unstable();
        assert!(
            edges.chunk_by(|a, b| a == b).all(|same| same.len() == 2),
            "{solid:?}"
        );
        let mut corners: Vec<u32> = solid.iter().flatten().copied().collect();
        corners.sort_unstable();
        corners.dedup();
        // Euler's formula for a ball.
        assert_eq!(corners.len() + solid.len(), edges.len() / 2 + 2);
    }
}
