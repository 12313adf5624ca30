#![allow(clippy::float_cmp)]

use super::super::vtk::BLOCK_BYTES;
use super::*;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Decodes one data array by the rules of the VTK file format, independently of the writer.
fn decode(text: &str) -> Vec<u8> {
    let text = text.trim();
    let number = |bytes: &[u8], i: usize| {
        u64::from_le_bytes(bytes[8 * i..8 * i + 8].try_into().unwrap()) as usize
    };
    // 3 words are 24 bytes, which are exactly 32 base64 characters.
    let blocks = number(&BASE64.decode(&text[..32]).unwrap(), 0);
    let header_characters = (8 * (3 + blocks)).div_ceil(3) * 4;
    let header = BASE64.decode(&text[..header_characters]).unwrap();
    let body = BASE64.decode(&text[header_characters..]).unwrap();
    let (mut out, mut start) = (Vec::new(), 0);
    for block in 0..blocks {
        let size = number(&header, 3 + block);
        let before = out.len();
        ZlibDecoder::new(&body[start..start + size])
            .read_to_end(&mut out)
            .unwrap();
        let last = block + 1 == blocks && number(&header, 2) != 0;
        assert_eq!(
            out.len() - before,
            number(&header, if last { 2 } else { 1 })
        );
        start += size;
    }
    assert_eq!(start, body.len());
    out
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
        .collect()
}

fn written(data: &VtuData<'_>) -> String {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.vtu");
    write_vtu(&path, data).unwrap();
    std::fs::read_to_string(path).unwrap()
}

fn array<'a>(document: &'a roxmltree::Document<'_>, name: &str) -> roxmltree::Node<'a, 'a> {
    document
        .descendants()
        .find(|n| n.attribute("Name") == Some(name))
        .unwrap()
}

fn content(document: &roxmltree::Document<'_>, name: &str) -> Vec<u8> {
    decode(array(document, name).text().unwrap())
}

#[test]
fn plane_vectors_are_padded_and_tensors_keep_their_order() {
    let tensor: Vec<f64> = (0..12).map(f64::from).collect();
    let fields = [
        Field {
            name: "pressure",
            unit: "Pa",
            components: 1,
            values: &[1e6, f64::NAN],
        },
        Field {
            name: "velocity",
            unit: "m/s",
            components: 2,
            values: &[1.0, 2.0, 3.0, 4.0],
        },
        Field {
            name: "stress",
            unit: "Pa",
            components: 6,
            values: &tensor,
        },
    ];
    let positions = [0.25, 0.5, 0.75, 0.1];
    let text = written(&VtuData {
        positions: &positions,
        time: 12.5,
        fields: &fields,
        ..EMPTY
    });
    let document = roxmltree::Document::parse(&text).unwrap();
    assert_eq!(floats(&content(&document, "TimeValue")), [12.5]);
    assert_eq!(
        floats(&content(&document, "Points")),
        [0.25, 0.5, 0.0, 0.75, 0.1, 0.0]
    );
    assert_eq!(
        floats(&content(&document, "velocity")),
        [1.0, 2.0, 0.0, 3.0, 4.0, 0.0]
    );
    assert_eq!(floats(&content(&document, "stress")), tensor);
    let attribute = |name, attribute| array(&document, name).attribute(attribute);
    assert_eq!(attribute("stress", "ComponentName3"), Some("XY"));
    assert_eq!(attribute("pressure", "NumberOfComponents"), None);
    let pressure = array(&document, "pressure");
    let key = pressure
        .children()
        .find(|node| node.has_tag_name("InformationKey"));
    assert_eq!(key.unwrap().attribute("name"), Some("UNITS_LABEL"));
    assert_eq!(key.unwrap().text(), Some("Pa"));
    let pressure = floats(&content(&document, "pressure"));
    assert!(pressure[0] == 1e6 && pressure[1].is_nan());
}

#[test]
fn cells_have_corners_ends_and_kinds_and_points_of_other_pieces_are_told() {
    let text = written(&VtuData {
        positions: &[0.0; 15],
        dimension: 3,
        cells: Cells {
            corners: &[0, 1, 2, 3, 4],
            ends: &[4, 5],
            ..Cells::default()
        },
        kinds: &[9, 1],
        ghosts: Some(2),
        ..EMPTY
    });
    let document = roxmltree::Document::parse(&text).unwrap();
    let integers = |name| -> Vec<u64> {
        let bytes = content(&document, name);
        bytes
            .chunks_exact(8)
            .map(|b| u64::from_le_bytes(b.try_into().unwrap()))
            .collect()
    };
    assert_eq!(integers("connectivity"), [0, 1, 2, 3, 4]);
    assert_eq!(integers("offsets"), [4, 5]);
    assert_eq!(content(&document, "types"), [9, 1]);
    assert_eq!(content(&document, "vtkGhostType"), [0, 0, 0, 1, 1]);
}

#[test]
fn cells_that_do_not_fit_the_points_are_refused() {
    let cells = |corners, ends| Cells {
        corners,
        ends,
        ..Cells::default()
    };
    for cells in [
        cells(&[0, 1, 2], &[3]),
        cells(&[0, 1], &[1]),
        cells(&[0, 1, 0], &[2, 1, 3]),
    ] {
        let kinds = vec![3; cells.ends.len()];
        let data = VtuData {
            cells,
            kinds: &kinds,
            ..PAIR
        };
        assert!(
            matches!(refused(&data), OutputError::Shape { .. }),
            "{cells:?}"
        );
    }
    let data = VtuData {
        cells: cells(&[0, 1], &[2]),
        ..PAIR
    };
    assert!(matches!(refused(&data), OutputError::Shape { .. }));
}

#[test]
fn fields_larger_than_a_block_and_exact_multiples_survive() {
    let per_block = BLOCK_BYTES / 8;
    for points in [per_block - 1, per_block, 2 * per_block, 2 * per_block + 7] {
        let values: Vec<f64> = (0..points).map(|i| (i as f64).sin()).collect();
        let positions = vec![0.0; 2 * points];
        let fields = [Field {
            name: "wave",
            unit: "",
            components: 1,
            values: &values,
        }];
        let data = VtuData {
            positions: &positions,
            fields: &fields,
            ..EMPTY
        };
        let text = written(&data);
        let document = roxmltree::Document::parse(&text).unwrap();
        assert!(
            floats(&content(&document, "wave")) == values,
            "{points} points"
        );
    }
}

#[test]
fn no_points_still_gives_a_readable_file() {
    let text = written(&EMPTY);
    let document = roxmltree::Document::parse(&text).unwrap();
    assert!(content(&document, "Points").is_empty());
}

#[test]
fn names_with_markup_are_escaped() {
    let fields = [Field {
        name: "a<b & \"c\"",
        unit: "",
        components: 1,
        values: &[1.0],
    }];
    let text = written(&VtuData {
        positions: &[0.0; 3],
        dimension: 3,
        fields: &fields,
        ..EMPTY
    });
    let document = roxmltree::Document::parse(&text).unwrap();
    assert_eq!(floats(&content(&document, "a<b & \"c\"")), [1.0]);
}

const EMPTY: VtuData<'static> = VtuData {
    positions: &[],
    dimension: 2,
    time: 0.0,
    cells: Cells {
        corners: &[],
        ends: &[],
        faces: &[],
        face_ends: &[],
    },
    kinds: &[],
    fields: &[],
    ghosts: None,
};

const PAIR: VtuData<'static> = VtuData {
    positions: &[0.0; 4],
    ..EMPTY
};

fn refused(data: &VtuData<'_>) -> OutputError {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.vtu");
    let error = write_vtu(&path, data).unwrap_err();
    assert!(!path.exists());
    error
}

#[test]
fn arrays_that_do_not_fit_are_refused_before_anything_is_written() {
    let short = [Field {
        name: "p",
        unit: "",
        components: 3,
        values: &[1.0; 5],
    }];
    let error = refused(&VtuData {
        fields: &short,
        ..PAIR
    });
    assert!(matches!(
        error,
        OutputError::Shape {
            expected: 6,
            found: 5,
            ..
        }
    ));
    let error = refused(&VtuData {
        positions: &[0.0; 3],
        ..PAIR
    });
    assert!(matches!(error, OutputError::Shape { .. }));
}

#[test]
fn shapes_the_format_lacks_are_refused() {
    let odd = [Field {
        name: "p",
        unit: "",
        components: 4,
        values: &[1.0; 8],
    }];
    for data in [
        VtuData {
            fields: &odd,
            ..PAIR
        },
        VtuData {
            dimension: 1,
            ..PAIR
        },
    ] {
        assert!(matches!(refused(&data), OutputError::Unsupported { .. }));
    }
}
