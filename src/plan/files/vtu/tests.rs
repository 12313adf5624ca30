#![allow(clippy::float_cmp)]
use super::*;

/// Written by meshio 5.3: zlib, 32-bit headers, inline base64.
const MESHIO: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" compressor="vtkZLibDataCompressor">
<!--This file was created by meshio v5.3.5-->
<UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="4">
<Points>
<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="binary">
AQAAAACAAABgAAAAHAAAAA==eJxjYMAOZs0EgZ32OKSh8ift0dWjiwMAfA4SXQ==
</DataArray>
</Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="binary">
AQAAAACAAAAgAAAAEwAAAA==eJxjYIAARijNBKWZoTQAAHAABw==
</DataArray>
<DataArray type="Int64" Name="offsets" format="binary">
AQAAAACAAAAgAAAAEwAAAA==eJxjZIAAJijNDKVZoDQAAMAACw==
</DataArray>
<DataArray type="Int64" Name="types" format="binary">
AQAAAACAAAAgAAAADgAAAA==eJxjZIAARhw0AABwAAU=
</DataArray>
</Cells>
<PointData>
<DataArray type="Float64" Name="volume" format="binary">
AQAAAACAAAAgAAAAIAAAAA==eJyrFlnn/rCqxb4aTE+x3yHX+jpwxzwof4k9APeaD0M=
</DataArray>
<DataArray type="Float64" Name="permeability" format="binary">
AQAAAACAAAAgAAAAIAAAAA==eJwTC3s+bz3zJRsxMP3IRoExOq+d9TWU/8kGAOQpDeE=
</DataArray>
<DataArray type="Int64" Name="material_id" format="binary">
AQAAAACAAAAgAAAAEQAAAA==eJxjYIAARgZUAOMDAABAAAM=
</DataArray>
</PointData>
</Piece>
</UnstructuredGrid>
</VTKFile>
"#;

/// Written by VTK 9.7: text, with notes inside an array.
const TEXT: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" header_type="UInt32">
  <UnstructuredGrid>
    <Piece NumberOfPoints="4" NumberOfCells="4">
      <PointData>
        <DataArray type="Float64" Name="volume" format="ascii" RangeMin="0.01" RangeMax="0.04">
          0.01 0.02 0.03 0.04
        </DataArray>
        <DataArray type="Float64" Name="permeability" format="ascii" RangeMin="1e-15" RangeMax="4e-15">
          1e-15 2e-15 3e-15 4e-15
        </DataArray>
      </PointData>
      <CellData>
      </CellData>
      <Points>
        <DataArray type="Float64" Name="Points" NumberOfComponents="3" format="ascii" RangeMin="0" RangeMax="0.223606797749979">
          0 0 0 0.1 0 0
          0 0.2 0 0.1 0.2 0
          <InformationKey name="L2_NORM_RANGE" location="vtkDataArray" length="2">
            <Value index="0">
              0
            </Value>
            <Value index="1">
              0.22360679775
            </Value>
          </InformationKey>
        </DataArray>
      </Points>
      <Cells>
        <DataArray type="Int64" Name="connectivity" format="ascii" RangeMin="0" RangeMax="3">
          0 1 2 3
        </DataArray>
        <DataArray type="Int64" Name="offsets" format="ascii" RangeMin="1" RangeMax="4">
          1 2 3 4
        </DataArray>
        <DataArray type="UInt8" Name="types" format="ascii" RangeMin="1" RangeMax="1">
          1 1 1 1
        </DataArray>
      </Cells>
    </Piece>
  </UnstructuredGrid>
</VTKFile>
"#;

/// Written by VTK 9.7: zlib, 64-bit headers, appended base64.
const APPENDED: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor">
  <UnstructuredGrid>
    <Piece NumberOfPoints="4" NumberOfCells="4" >
      <PointData>
        <DataArray type="Float64" Name="volume" format="appended" RangeMin="0.01" RangeMax="0.04" offset="0" ></DataArray>
        <DataArray type="Float64" Name="permeability" format="appended" RangeMin="1e-15" RangeMax="4e-15" offset="88" ></DataArray>
      </PointData>
      <CellData>
      </CellData>
      <Points>
        <DataArray type="Float64" Name="Points" NumberOfComponents="3" format="appended" RangeMin="0" RangeMax="0.22360679775" offset="176" ></DataArray>
      </Points>
      <Cells>
        <DataArray type="Int64" Name="connectivity" format="appended" RangeMin="" RangeMax="" offset="260"                 />
        <DataArray type="Int64" Name="offsets" format="appended" RangeMin="" RangeMax="" offset="332"                 />
        <DataArray type="UInt8" Name="types" format="appended" RangeMin="" RangeMax="" offset="404" ></DataArray>
      </Cells>
    </Piece>
  </UnstructuredGrid>
  <AppendedData encoding="base64">
   _AQAAAAAAAAAAgAAAAAAAACAAAAAAAAAAIAAAAAAAAAA=eJyrFlnn/rCqxb4aTE+x3yHX+jpwxzwof4k9APeaD0M=AQAAAAAAAAAAgAAAAAAAACAAAAAAAAAAIAAAAAAAAAA=eJwTC3s+bz3zJRsxMP3IRoExOq+d9TWU/8kGAOQpDeE=AQAAAAAAAAAAgAAAAAAAAGAAAAAAAAAAHAAAAAAAAAA=eJxjYMAOZs0EgZ32OKSh8ift0dWjiwMAfA4SXQ==AQAAAAAAAAAAgAAAAAAAACAAAAAAAAAAEwAAAAAAAAA=eJxjYIAARijNBKWZoTQAAHAABw==AQAAAAAAAAAAgAAAAAAAACAAAAAAAAAAEwAAAAAAAAA=eJxjZIAAJijNDKVZoDQAAMAACw==AQAAAAAAAAAAgAAAAAAAAAQAAAAAAAAADAAAAAAAAAA=eJxjZGRkBAAADgAF
  </AppendedData>
</VTKFile>
"#;

/// A file with raw appended data. `numbers` gives the bytes of each block behind its header.
fn raw(attributes: &str, header: impl Fn(usize) -> Vec<u8>, number: fn(f64) -> [u8; 8]) -> Vec<u8> {
    let points = [0., 0., 0., 0.1, 0., 0., 0., 0.2, 0., 0.1, 0.2, 0.];
    let volume = [0.01, 0.02, 0.03, 0.04];
    let block = |values: &[f64]| {
        let data: Vec<u8> = values.iter().flat_map(|&value| number(value)).collect();
        [header(data.len()), data].concat()
    };
    let (points, volume) = (block(&points), block(&volume));
    let start = format!(
        "<VTKFile type=\"UnstructuredGrid\" {attributes}><UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"4\" NumberOfCells=\"0\"><PointData>\
         <DataArray type=\"Float64\" Name=\"volume\" format=\"appended\" offset=\"{}\"/>\
         </PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" \
         format=\"appended\" offset=\"0\"/></Points></Piece></UnstructuredGrid>\n\
         <AppendedData encoding=\"raw\">\n _",
        points.len()
    );
    [
        start.as_bytes(),
        &points,
        &volume,
        b"\n</AppendedData></VTKFile>\n",
    ]
    .concat()
}

/// One valid file of each kind, for tests that damage them.
pub(in super::super) fn files() -> Vec<Vec<u8>> {
    let little = "header_type=\"UInt64\" byte_order=\"LittleEndian\"";
    let mut files = [MESHIO, TEXT, APPENDED]
        .map(|text| text.as_bytes().to_vec())
        .to_vec();
    files.push(raw(
        little,
        |n| (n as u64).to_le_bytes().to_vec(),
        f64::to_le_bytes,
    ));
    let big = "header_type=\"UInt32\" byte_order=\"BigEndian\"";
    files.push(raw(
        big,
        |n| (n as u32).to_be_bytes().to_vec(),
        f64::to_be_bytes,
    ));
    files
}

fn read(bytes: &[u8]) -> Result<PointTable, FileError> {
    read_points(Path::new("points.vtu"), bytes)
}

/// The text sample with a part replaced, which must be there.
fn changed(from: &str, to: &str) -> Result<PointTable, FileError> {
    assert!(TEXT.contains(from));
    read(TEXT.replace(from, to).as_bytes())
}

#[track_caller]
fn fails(result: Result<PointTable, FileError>, parts: &[&str]) {
    let message = result.unwrap_err().to_string();
    for part in parts.iter().chain(&["points.vtu"]) {
        assert!(message.contains(part), "`{part}` not in: {message}");
    }
}

#[test]
fn text_base64_raw_and_zlib_give_the_same_points() {
    for (index, file) in files().iter().enumerate() {
        let table = read(file).unwrap();
        assert_eq!(table.dimension, 2, "file {index}");
        assert_eq!(
            table.position,
            [0., 0., 0.1, 0., 0., 0.2, 0.1, 0.2],
            "file {index}"
        );
        assert_eq!(table.volume, [0.01, 0.02, 0.03, 0.04], "file {index}");
        let permeability = (index < 3).then(|| vec![1e-15, 2e-15, 3e-15, 4e-15]);
        assert_eq!(
            (table.permeability, table.material),
            (permeability, None),
            "file {index}"
        );
    }
}

#[test]
fn points_are_flat_only_if_z_is_constant() {
    let shifted = changed("0.2 0 0.1 0.2 0\n", "0.2 0 0.1 0.2 1e-14\n").unwrap();
    assert_eq!((shifted.dimension, shifted.position.len()), (2, 8));
    let bent = changed("0.2 0 0.1 0.2 0\n", "0.2 0 0.1 0.2 1e-3\n").unwrap();
    assert_eq!(
        (bent.dimension, &bent.position[9..]),
        (3, &[0.1, 0.2, 1e-3][..])
    );
    let lifted = changed(
        "0 0 0 0.1 0 0\n          0 0.2 0 0.1 0.2 0",
        "0 0 5 1 0 5 0 1 5 1 1 5",
    );
    assert_eq!(lifted.unwrap().dimension, 2);
}

#[test]
fn a_unit_in_the_name_of_the_volume_is_checked() {
    assert!(changed("\"volume\"", "\"volume_m2\"").is_ok());
    fails(
        changed("\"volume\"", "\"volume_m3\""),
        &["`volume_m3`", "`volume_m2`"],
    );
    fails(
        changed("\"permeability\"", "\"permeability_mD\""),
        &["`permeability_m2`"],
    );
}

#[test]
fn pieces_are_joined() {
    let start = TEXT.find("<Piece").unwrap();
    let end = TEXT.find("</UnstructuredGrid>").unwrap();
    let twice = [&TEXT[..end], &TEXT[start..]].concat();
    let table = read(twice.as_bytes()).unwrap();
    assert_eq!((table.volume.len(), table.position.len()), (8, 16));
    assert_eq!(table.permeability.unwrap().len(), 8);
    let without = TEXT[start..].replace("\"permeability\"", "\"other\"");
    fails(
        read([&TEXT[..end], &without].concat().as_bytes()),
        &["only some pieces"],
    );
}

#[test]
fn missing_or_misspelt_volume_names_the_arrays_found() {
    let result = changed("\"volume\"", "\"Volumes\"");
    fails(
        result,
        &[
            "point data `volume`",
            "`Volumes`, `permeability`",
            "did you mean `Volumes`",
        ],
    );
}

#[test]
fn bad_values_name_the_point() {
    let result = changed("0.01 0.02 0.03 0.04\n", "0.01 0 -1 0.04\n");
    fails(result, &["index 1", "volume is 0.0", "2 of 4"]);
    fails(
        changed("1e-15 2e-15", "1e-15 nan"),
        &["index 1", "permeability is NaN"],
    );
    fails(
        changed("0 0 0 0.1 0 0", "0 0 0 0.1 inf 0"),
        &["index 1", "a coordinate is inf"],
    );
}

#[test]
fn arrays_that_do_not_fit_are_refused_with_their_line() {
    fails(
        changed("0.01 0.02 0.03 0.04\n", "0.01 0.02 0.03\n"),
        &["line 6", "3 values", "4 needed"],
    );
    fails(
        changed("0.01 0.02", "0.01 x"),
        &["`volume`", "`x` is no number"],
    );
    fails(
        changed("NumberOfPoints=\"4\"", "NumberOfPoints=\"5\""),
        &["15 needed"],
    );
    fails(
        changed("NumberOfPoints=\"4\"", "NumberOfPoints=\"-4\""),
        &["NumberOfPoints"],
    );
    let huge = "NumberOfPoints=\"9223372036854775807\"";
    fails(changed("NumberOfPoints=\"4\"", huge), &["impossible"]);
    assert!(matches!(
        changed("NumberOfPoints=\"4\"", "NumberOfPoints=\"0\""),
        Err(FileError::Empty { .. })
    ));
}

#[test]
fn a_block_size_from_a_broken_header_is_not_believed() {
    let attributes = "header_type=\"UInt64\"";
    for size in [0, 1, u64::MAX, 1 << 60] {
        let file = raw(
            attributes,
            |_| size.to_le_bytes().to_vec(),
            f64::to_le_bytes,
        );
        assert!(
            matches!(read(&file), Err(FileError::Damaged { .. })),
            "{size}"
        );
    }
    let zlib = "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"";
    for blocks in [0_u64, 1, u64::MAX, 1 << 61] {
        let header = |_| [blocks, 32, 0, u64::MAX].map(u64::to_le_bytes).concat();
        let file = raw(zlib, header, f64::to_le_bytes);
        assert!(
            matches!(read(&file), Err(FileError::Damaged { .. })),
            "{blocks}"
        );
    }
}

#[test]
fn every_truncation_is_noticed() {
    for file in files() {
        let complete = file.trim_ascii_end().len();
        for length in 0..complete {
            assert!(read(&file[..length]).is_err(), "{length} of {complete}");
        }
    }
}

#[test]
fn other_grids_and_compressors_are_named_with_the_remedy() {
    fails(
        changed("type=\"UnstructuredGrid\"", "type=\"PolyData\""),
        &["`PolyData`"],
    );
    let lz4 = "version=\"0.1\" compressor=\"vtkLZ4DataCompressor\"";
    fails(
        changed("version=\"0.1\"", lz4),
        &["vtkLZ4DataCompressor", "zlib"],
    );
    fails(read(b"<html/>"), &["`html`"]);
    fails(read(b"x,y\n"), &["line 1"]);
}
