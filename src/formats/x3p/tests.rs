//! Tests of the X3P reader and writer.

use std::io::{Cursor, Write};

use proptest::prelude::*;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::archive::md5_hex;
use super::*;
use crate::test_data::{shared, sq_about_polynomial_mm};
use crate::{Cloud, HeightMap, Source};

/// An archive of the given entries.
fn zipped(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in entries {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A `main.xml` with the given axes (XML of CX, CY, CZ, Rotation) and third record.
fn main_xml(feature: &str, axes: &str, record3: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- a comment -->\n\
         <p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\">\n<Record1>\
         <Revision>ISO5436 - 2000</Revision><FeatureType> {feature} </FeatureType>\
         <Axes>{axes}</Axes></Record1>\n<Record2><Date>2007-04-30T13:58:02.6+02:00</Date>\
         <Instrument><Manufacturer>A &amp; B</Manufacturer><Model>&#xB5;Surf</Model>\
         <Serial/></Instrument><Comment><![CDATA[1 < 2]]></Comment></Record2>\
         <Record3>{record3}</Record3></p:ISO5436_2>"
    )
}

const INCREMENTAL: &str = "<CX><AxisType>I</AxisType><Increment>2E-0006</Increment>\
    <Offset>1e-3</Offset></CX><CY><AxisType>I</AxisType><DataType>L</DataType>\
    <Increment>3E-0006</Increment><Offset>-1e-3</Offset></CY>";
const Z_DOUBLE: &str = "<CZ><AxisType>A</AxisType><DataType>D</DataType></CZ>";
const Z_INT16: &str = "<CZ><AxisType>A</AxisType><DataType>I</DataType>\
    <Increment>1e-6</Increment><Offset>5e-6</Offset></CZ>";
const MATRIX: &str = "<MatrixDimension><SizeX>3</SizeX><SizeY>2</SizeY><SizeZ>1</SizeZ>\
    </MatrixDimension>";

/// A file without binary parts and checksum.
fn text_file(feature: &str, axes: &str, record3: &str) -> Vec<u8> {
    zipped(&[("main.xml", main_xml(feature, axes, record3).as_bytes())])
}

fn data_list(data: &[&str]) -> String {
    let data: String = data.iter().map(|datum| format!("<Datum>{datum}</Datum>")).collect();
    format!("<DataList>{data}</DataList>")
}

fn small_text(z: &str) -> Vec<u8> {
    let list = data_list(&["1", "2", "3", "4", "", z]);
    text_file("SUR", &format!("{INCREMENTAL}{Z_INT16}"), &format!("{MATRIX}{list}"))
}

/// The map of [`small_text`] as binary file, with a validity file and all checksums.
fn small_binary() -> Vec<u8> {
    binary_with(&[1, 0, 2, 0, 3, 0, 4, 0, 99, 0, 6, 0], &[0b10_1111], |main| main)
}

fn binary_with(data: &[u8], valid: &[u8], change: impl Fn(String) -> String) -> Vec<u8> {
    let link = format!(
        "{MATRIX}<DataLink><PointDataLink>bindata\\data.bin</PointDataLink>\
         <MD5ChecksumPointData>{}</MD5ChecksumPointData>\
         <ValidPointsLink>./bindata/valid.bin</ValidPointsLink>\
         <MD5ChecksumValidPoints>{}</MD5ChecksumValidPoints></DataLink>",
        md5_hex(data).to_ascii_uppercase(),
        md5_hex(valid)
    );
    let main = change(main_xml("SUR", &format!("{INCREMENTAL}{Z_INT16}"), &link));
    zipped(&[
        ("main.xml", main.as_bytes()),
        ("md5checksum.hex", format!("{} *main.xml\n", md5_hex(main.as_bytes())).as_bytes()),
        ("bindata/data.bin", data),
        ("bindata/valid.bin", valid),
    ])
}

fn map(bytes: &[u8]) -> (HeightMap, Source) {
    match read(bytes) {
        Ok(Topography::Map(map, source)) => (map, source),
        other => panic!("no map but {other:?}"),
    }
}

fn cloud(bytes: &[u8]) -> Cloud {
    match read(bytes) {
        Ok(Topography::Cloud(cloud, _)) => cloud,
        other => panic!("no cloud but {other:?}"),
    }
}

fn message(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-15 * expected.abs().max(1e-3), "{found} {expected}");
}

#[test]
fn text_and_binary_give_the_same_map() {
    for bytes in [small_text("6"), small_binary()] {
        let (map, source) = map(&bytes);
        assert_eq!((map.nx, map.ny, map.missing()), (3, 2, 1));
        assert!(map.z_mm[4].is_nan());
        for (index, stored) in [(0, 1.0), (1, 2.0), (2, 3.0), (3, 4.0), (5, 6.0)] {
            assert_near(map.z_mm[index], (stored + 5.0) * 1e-3);
        }
        assert_near(map.dx_mm, 2e-3);
        assert_near(map.dy_mm, 3e-3);
        // The first column lies at the offset: u counts from 1.
        assert_near(map.x0_mm, 1.0);
        assert_near(map.y0_mm, -1.0);
        assert_eq!(source.instrument.as_deref(), Some("A & B µSurf"));
        assert_eq!(source.date.as_deref(), Some("2007-04-30T13:58:02.6+02:00"));
        assert_eq!(source.comment.as_deref(), Some("1 < 2"));
    }
}

#[test]
fn absolute_axes_give_a_cloud() {
    let x = "<CX><AxisType>A</AxisType><DataType>L</DataType><Increment>1e-3</Increment></CX>";
    let y = "<CY><AxisType>I</AxisType><Increment>2e-3</Increment><Offset>1</Offset></CY>";
    let list = data_list(&["5;1e-3", "6;2e-3", "7;NaN", "8;4e-3", "", "9;6e-3"]);
    let bytes = text_file("SUR", &format!("{x}{y}{Z_DOUBLE}"), &format!("{MATRIX}{list}"));
    let cloud = cloud(&bytes);
    assert_eq!(cloud.missing, 2);
    let expected = [[5.0, 1000.0, 1.0], [6.0, 1000.0, 2.0], [8.0, 1002.0, 4.0], [9.0, 1002.0, 6.0]];
    for (found, expected) in cloud.points_mm.iter().flatten().zip(expected.iter().flatten()) {
        assert_near(*found, *expected);
    }
    assert_eq!(cloud.points_mm.len(), 4);
}

/// Half a turn about x: y and z change sign before the offsets are added.
#[test]
fn a_rotation_gives_a_cloud_in_the_global_frame() {
    let rotation = |r11: &str, r22: &str, r33: &str| {
        format!(
            "<Rotation><r11>{r11}</r11><r12>0</r12><r13>0</r13><r21>0</r21><r22>{r22}</r22>\
             <r23>0</r23><r31>0</r31><r32>0</r32><r33>{r33}</r33></Rotation>"
        )
    };
    let file = |rotation: &str| {
        let list = data_list(&["1e-3", "2e-3", "3e-3", "4e-3", "", "6e-3"]);
        let axes = format!("{INCREMENTAL}{Z_DOUBLE}{rotation}");
        text_file("SUR", &axes, &format!("{MATRIX}{list}"))
    };
    let turned = cloud(&file(&rotation("1.0", "-1", "-1e0")));
    assert_eq!((turned.points_mm.len(), turned.missing), (5, 1));
    let last = turned.points_mm[4];
    for (found, expected) in last.iter().zip([1.0 + 2.0 * 2e-3, -1.0 - 3e-3, -6.0]) {
        assert_near(*found, expected);
    }
    assert_eq!(map(&file(&rotation("1", "1", "1"))).0.missing(), 1);

    let message = |r11, r22, r33| message(&file(&rotation(r11, r22, r33)));
    assert_eq!(
        message("1", "1", "-1"),
        "X3P file, element Record1/Axes/Rotation: expected a right-handed rotation within 1e-6, \
         found a matrix off by 2.00e0"
    );
    assert!(message("1", "1", "0.999").contains("a matrix off by 2.00e-3"));
    assert!(message("1", "1", "").contains("element Record1/Axes/Rotation/r33: expected a finite"));
}

#[test]
fn broken_documents_are_errors_at_their_element() {
    let axes = format!("{INCREMENTAL}{Z_INT16}");
    let good = format!("{MATRIX}{}", data_list(&["1", "2", "3", "4", "5", "6"]));
    let with =
        |feature: &str, axes: &str, record3: &str| message(&text_file(feature, axes, record3));
    let change = |from: &str, to: &str| with("SUR", &axes.replacen(from, to, 1), &good);
    let resize = |from: &str, to: &str| with("SUR", &axes, &good.replacen(from, to, 1));
    for (message, expected) in [
        (
            with("PRF", &axes, &good),
            "element Record1/FeatureType: a profile (PRF) is not supported",
        ),
        (with("XYZ", &axes, &good), "element Record1/FeatureType: expected SUR, PCL or PRF"),
        (with("PCL", &axes, &good), "element Record1/Axes/CX/AxisType: expected A: this axis"),
        (change("<AxisType>A", "<AxisType>I"), "element Record1/Axes/CZ/AxisType: expected A"),
        (change("<AxisType>A", "<AxisType>B"), "element Record1/Axes/CZ/AxisType: expected I or A"),
        (
            change("<DataType>I", "<DataType>X"),
            "element Record1/Axes/CZ/DataType: expected I, L, F",
        ),
        (change("2E-0006", "0"), "element Record1/Axes/CX/Increment: expected metres above zero"),
        (
            change("2E-0006", ""),
            "element Record1/Axes/CX/Increment: expected metres above zero, found none",
        ),
        (change("2E-0006", "2,5"), "CX/Increment: expected a finite number, found \"2,5\""),
        (change("<CX>", "<CX><AxisType>I</AxisType>"), "CX/AxisType: expected one element of this"),
        (resize("<SizeZ>1", "<SizeZ>3"), "SizeZ: a surface of 3 layers is not supported"),
        (resize("<SizeX>3", "<SizeX>0"), "expected at least one column and one row, found 0 × 2"),
        (resize("<SizeX>3", "<SizeX>4000000000"), "expected at most 100000000 points"),
        (resize("<SizeX>3", "<SizeX>4"), "Record3/DataList/Datum: expected 8 of them"),
        (resize("<SizeX>3", "<SizeX>2"), "Record3/DataList/Datum: expected 4 of them"),
        (resize("<SizeX>3", "<SizeX>three"), "SizeX: expected a whole number, found \"three\""),
        (resize("<Datum>2", "<Datum>2;3"), "Datum[2]: expected no more values than absolute axes"),
        (
            resize("<Datum>2", "<Datum>2.5"),
            "Datum[2]: expected whole numbers that fit the DataType",
        ),
        (
            resize("<Datum>2", "<Datum>32768"),
            "Datum[2]: expected whole numbers that fit the DataType",
        ),
        (
            with("SUR", &axes, MATRIX),
            "element Record3: expected DataLink/PointDataLink or DataList",
        ),
        (with("SUR", &axes, "<ListDimension>6</ListDimension>"), "element Record3/ListDimension"),
    ] {
        assert!(message.contains(expected), "{message}\n{expected}");
    }
}

#[test]
fn broken_xml_is_an_error_in_its_entry() {
    let deep = "<a>".repeat(40);
    let many: String = (0..5000).map(|number| format!("<a{number}/>")).collect();
    for (main, expected) in [
        ("", "zip entry main.xml: expected a complete ISO5436_2, found the end of the file"),
        ("<ISO5436_2>", "expected a complete ISO5436_2"),
        ("<html/>", "expected the root element ISO5436_2, found \"html\""),
        ("<ISO5436_2/><ISO5436_2/>", "expected the root element ISO5436_2"),
        ("<ISO5436_2></Record1>", "expected well-formed XML"),
        ("<!DOCTYPE a [<!ENTITY b \"c\">]><ISO5436_2/>", "expected no document type"),
        ("<ISO5436_2>&b;</ISO5436_2>", "expected a predefined entity, found \"b\""),
        (&format!("<ISO5436_2>{deep}"), "expected at most 16 levels of elements"),
        (&format!("<ISO5436_2>{many}</ISO5436_2>"), "expected at most 4096 elements"),
        ("<ISO5436_2/>", "element Record1/FeatureType: expected a text, found none"),
    ] {
        let message = message(&zipped(&[("main.xml", main.as_bytes())]));
        assert!(message.contains(expected), "{message}");
    }
    assert!(message(&zipped(&[("main.xml", b"<a>\xFF")])).contains("expected UTF-8"));
    assert!(message(&zipped(&[("other", b"")])).contains("zip entry main.xml: expected an entry"));
    assert!(message(b"PK\x03\x04").contains("byte 0: expected a complete zip archive"));
}

#[test]
fn every_checksum_is_verified() {
    let data = [1, 0, 2, 0, 3, 0, 4, 0, 99, 0, 6, 0];
    let error = read(&binary_with(&data, &[0b10_1111], |main| {
        main.replace(&md5_hex(&data).to_ascii_uppercase(), &"0".repeat(32))
    }));
    assert_eq!(
        error.unwrap_err().to_string(),
        format!(
            "X3P file, zip entry bindata\\data.bin: expected the MD5 checksum {}, found {}",
            "0".repeat(32),
            md5_hex(&data)
        )
    );
    let valid = read(&binary_with(&data, &[0b10_1111], |main| {
        main.replace(&md5_hex(&[0b10_1111]), &"a".repeat(32))
    }));
    assert!(matches!(valid, Err(ReadError::Checksum { .. })));
    let main = main_xml("SUR", INCREMENTAL, "");
    let changed = zipped(&[("main.xml", main.as_bytes()), ("md5checksum.hex", &[b'0'; 32])]);
    // Record1 lacks CZ: the document is judged first.
    assert!(message(&changed).contains("CZ/AxisType"));
    let main = main_xml(
        "SUR",
        &format!("{INCREMENTAL}{Z_INT16}"),
        &format!("{MATRIX}{}", data_list(&["1"])),
    );
    let changed = zipped(&[("main.xml", main.as_bytes()), ("md5checksum.hex", &[b'0'; 32])]);
    assert!(message(&changed).contains("zip entry main.xml: expected the MD5 checksum 000000"));
    let not_one =
        binary_with(&data, &[0b10_1111], |main| main.replace(&md5_hex(&[0b10_1111]), "abc"));
    assert!(message(&not_one).contains("MD5ChecksumValidPoints: expected 32 hexadecimal digits"));
}

/// The checksum of RFC 1321, A.5.
#[test]
fn checksums_are_those_of_the_rfc() {
    assert_eq!(md5_hex(b"message digest"), "f96b697d7cb7938d525a2f31aaf161d0");
}

#[test]
fn binary_files_have_exactly_the_declared_size() {
    let short = message(&binary_with(&[0; 10], &[0], |main| main));
    assert!(short.contains("expected 12 bytes for the points declared, found 10"), "{short}");
    let valid = message(&binary_with(&[0; 12], &[], |main| main));
    assert!(
        valid.contains("valid.bin: expected 1 bytes for the points declared, found 0"),
        "{valid}"
    );
    let bomb = message(&binary_with(&vec![0; 50_000_000], &[0], |main| main));
    assert!(bomb.contains("data.bin: expected at most 12 bytes, found 50000000"), "{bomb}");
    let main_bomb = message(&zipped(&[("main.xml", &vec![b' '; (64 << 20) + 1])]));
    assert!(main_bomb.contains("main.xml: expected at most 67108864 bytes"), "{main_bomb}");
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = small_binary();
    assert!((0..bytes.len()).all(|len| read(&bytes[..len]).is_err()));
}

/// Height in metres of the samples of x3pio, from their generator (`tests/samples/generate.py`).
fn sample_height_m(x_m: f64, y_m: f64) -> f64 {
    let wave = |length_m: f64, at_m: f64| std::f64::consts::TAU * at_m / length_m;
    1e-6 * (wave(24e-6, x_m).cos() * wave(16e-6, y_m).cos() + 0.3 * wave(9e-6, x_m).sin())
}

#[test]
fn samples_of_x3pio_have_the_heights_of_their_generator() {
    for (bytes, size, gap, step_m) in [
        (
            &include_bytes!("../tests/data/surface_binary.x3p")[..],
            (200, 150),
            (40..52, 70..85),
            3.849507590541495e-11,
        ),
        (
            &include_bytes!("../tests/data/surface_int32_xml.x3p")[..],
            (120, 90),
            (30..36, 40..50),
            5.873703177925675e-16,
        ),
    ] {
        let (map, source) = map(bytes);
        assert_eq!((map.nx, map.ny), size);
        assert_eq!(source.date.as_deref(), Some("2026-01-01T12:00:00.0+00:00"));
        for (index, z_mm) in map.z_mm.iter().enumerate() {
            let (column, row) = (index % map.nx, index / map.nx);
            if gap.0.contains(&row) && gap.1.contains(&column) {
                assert!(z_mm.is_nan());
            } else {
                let expected_m = sample_height_m(column as f64 * 1e-6, row as f64 * 1e-6);
                assert!((z_mm * 1e-3 - expected_m).abs() <= 0.51 * step_m, "{column} {row}");
            }
        }
    }
}

#[test]
fn point_cloud_of_x3pio_lies_on_its_surface() {
    let cloud = cloud(include_bytes!("../tests/data/point_cloud_binary.x3p"));
    assert_eq!((cloud.points_mm.len(), cloud.missing), (1000, 0));
    for [x_mm, y_mm, z_mm] in cloud.points_mm {
        // Rounding x and y to float32 moves them by up to 4e-12 m, times a slope below 1.
        let expected_m = sample_height_m(x_mm * 1e-3, y_mm * 1e-3);
        assert!((z_mm * 1e-3 - expected_m).abs() < 1e-11);
    }
}

/// Sq about the mean as the authors of SurfaceTopography assert it (`test_x3p.py`).
#[test]
fn measured_map_has_the_published_roughness() {
    let Some(bytes) = shared("topography/x3p-2.x3p") else { return };
    let (map, source) = map(&bytes);
    assert_eq!((map.nx, map.ny, map.missing()), (650, 650, 0));
    let sq_m = sq_about_polynomial_mm(&map, 0) * 1e-3;
    assert!((sq_m / 7.728033273597876e-8 - 1.0).abs() < 1e-9, "{sq_m:e}");
    assert!((map.dx_mm - 1.27656509837346e-4).abs() < 1e-18);
    assert!(source.instrument.unwrap().starts_with("DIGITAL SURF Mountains Map"));
}

const METADATA: Metadata<'_> = Metadata {
    date: "2026-01-31T12:00:00.0+01:00",
    calibration_date: "2026-01-01T00:00:00Z",
    creator: Some("A < B"),
    manufacturer: "asphera",
    model: "µ & m",
    serial: "7",
    version: "0.1.0",
    probing: Probing::NonContacting,
    probe: "lens 3",
    comment: Some("\"quoted\"\n"),
};

fn written(map: &HeightMap) -> Vec<u8> {
    let mut file = Vec::new();
    write_map(&mut file, map, &METADATA).unwrap();
    file
}

fn small_map() -> HeightMap {
    let z_mm = vec![1.0, f64::NAN, f64::INFINITY, -0.1];
    HeightMap { nx: 2, ny: 2, dx_mm: 0.5, dy_mm: 0.25, x0_mm: -3.0, y0_mm: 4.0, z_mm }
}

#[test]
fn what_is_written_is_the_same_every_time_and_says_where_it_comes_from() {
    let file = written(&small_map());
    assert_eq!(file, written(&small_map()));
    let (map, source) = map(&file);
    assert_eq!(format!("{:?}", map.z_mm), format!("{:?}", [1.0, f64::NAN, f64::NAN, -0.1]));
    assert_eq!((map.dx_mm, map.dy_mm, map.x0_mm, map.y0_mm), (0.5, 0.25, -3.0, 4.0));
    assert_eq!(source.instrument.as_deref(), Some("asphera µ & m 7"));
    assert_eq!(source.date.as_deref(), Some(METADATA.date));
    assert_eq!(source.comment.as_deref(), Some("\"quoted\""));
}

#[test]
fn what_cannot_be_written_is_refused() {
    let refused = |map: &HeightMap, metadata: &Metadata<'_>, expected: &str| {
        let mut file = Vec::new();
        let message = write_map(&mut file, map, metadata).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
        assert!(file.is_empty());
    };
    let map = small_map();
    refused(&HeightMap { nx: 3, ..map.clone() }, &METADATA, "height map: expected 3 × 2 heights");
    refused(&HeightMap { nx: usize::MAX, ..map.clone() }, &METADATA, "height map: expected");
    let none = HeightMap { nx: 0, z_mm: vec![], ..map.clone() };
    refused(&none, &METADATA, "at least one, found 0");
    refused(&HeightMap { dx_mm: 0.0, ..map.clone() }, &METADATA, "dx_mm: expected a length");
    refused(&HeightMap { y0_mm: f64::NAN, ..map.clone() }, &METADATA, "dy_mm: expected a length");
    for date in
        ["", "2026-01-31", "2026-01-31 12:00:00", "2026-01-31T12:00:00.", "2026-01-31T12:00:00+1"]
    {
        refused(&map, &Metadata { date, ..METADATA }, "Date: expected a date as");
    }
    refused(&map, &Metadata { model: "a\0b", ..METADATA }, "Model: expected text without control");

    let cloud =
        |points: &[[f64; 3]]| write_cloud(Vec::new(), points, &METADATA).unwrap_err().to_string();
    assert!(cloud(&[]).contains("point cloud: expected at least one point"));
    assert!(cloud(&[[0.0; 3], [0.0, f64::NAN, 0.0]]).contains("point 1: expected finite"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Dividing by 1000 and multiplying again rounds twice.
    #[test]
    fn maps_come_back_within_rounding(
        z_mm in prop::collection::vec(prop_oneof![-1e3..1e3_f64, Just(f64::NAN)], 6),
        dx_mm in 1e-9..1e3_f64,
        x0_mm in -1e3..1e3_f64,
    ) {
        let original = HeightMap { nx: 3, ny: 2, dx_mm, dy_mm: 1.0, x0_mm, y0_mm: 0.0, z_mm };
        let (read, _) = map(&written(&original));
        let near = |a: f64, b: f64| (a - b).abs() <= 2.0 * f64::EPSILON * b.abs();
        prop_assert!(near(read.dx_mm, dx_mm) && near(read.x0_mm, x0_mm));
        for (found, z_mm) in read.z_mm.iter().zip(&original.z_mm) {
            prop_assert!(near(*found, *z_mm) || found.is_nan() && z_mm.is_nan());
        }
    }

    #[test]
    fn clouds_come_back_within_rounding(
        points in prop::collection::vec(prop::array::uniform3(-1e3..1e3_f64), 1..20),
    ) {
        let mut file = Vec::new();
        write_cloud(&mut file, &points, &METADATA).unwrap();
        let read = cloud(&file);
        prop_assert_eq!(read.points_mm.len(), points.len());
        for (found, mm) in read.points_mm.iter().flatten().zip(points.iter().flatten()) {
            prop_assert!((found - mm).abs() <= 2.0 * f64::EPSILON * mm.abs());
        }
    }
}

proptest! {
    #[test]
    fn mutated_archives_never_panic(
        text in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut bytes = if text { small_text("6") } else { small_binary() };
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        let _ = read(&bytes);
    }

    /// The archive is whole, so that the mutation reaches the XML reader.
    #[test]
    fn mutated_documents_never_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0x20..0x7F_u8), 1..8),
    ) {
        let list = data_list(&["1", "2", "3", "4", "", "6"]);
        let axes = format!("{INCREMENTAL}{Z_INT16}");
        let mut main = main_xml("SUR", &axes, &format!("{MATRIX}{list}")).into_bytes();
        for (place, value) in changes {
            let place = place.index(main.len());
            main[place] = value;
        }
        let _ = read(&zipped(&[("main.xml", &main)]));
    }

    #[test]
    fn random_bytes_never_panic(tail in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = read(&[MAGIC, &tail].concat());
        let _ = read(&zipped(&[("main.xml", &tail)]));
    }
}
