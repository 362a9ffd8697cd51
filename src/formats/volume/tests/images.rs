//! TIFF stacks and images of VTK, written by other programs (`tests/data/PROVENANCE.md`), and damage.

use super::super::{Frame, UnitKnown, Values, Volume, read_slices};
use super::{alone, near, numbers};
use crate::{Format, ReadError};

macro_rules! file {
    ($name:literal) => {
        include_bytes!(concat!("../../tests/data/volumes/", $name)).as_slice()
    };
}

const VTI: [(&str, &[u8]); 7] = [
    ("ascii.vti", file!("ascii.vti")),
    ("base64.vti", file!("base64.vti")),
    ("base64_zlib.vti", file!("base64_zlib.vti")),
    ("raw_big.vti", file!("raw_big.vti")),
    ("raw_zlib_blocks.vti", file!("raw_zlib_blocks.vti")),
    ("appended.vti", file!("appended.vti")),
    ("appended_zlib.vti", file!("appended_zlib.vti")),
];

const IMAGEJ: &[u8] = file!("imagej.tif");
const DEFLATE: &[u8] = file!("floats_deflate.tif");
const BIG: &[u8] = file!("bytes_big.tif");

#[test]
fn images_of_vtk_are_read_in_every_coding() {
    for (name, bytes) in VTI {
        let volume = alone(name, bytes).unwrap();
        assert_eq!((volume.size, volume.format), ([3, 2, 2], Format::Vti), "{name}");
        assert_eq!(volume.values.to_floats(), numbers(), "{name}");
        assert_eq!(volume.frame.unit, UnitKnown::Assumed);
        // Point 5 along x is the first, at 0.5 mm + 5 × 0.1 mm.
        let place = volume.frame.place_mm([2.0, 1.0, 1.0]);
        assert!(near(place[0], 1.2) && near(place[1], 2.2) && near(place[2], 3.3), "{place:?}");
    }
    let cells = alone("cells.vti", file!("cells.vti")).unwrap();
    assert_eq!((cells.size, cells.values.to_floats()), ([3, 2, 2], numbers()));
    let place = cells.frame.origin_mm;
    assert!(near(place[0], 0.55) && near(place[1], 2.1) && near(place[2], 3.15), "{place:?}");
}

#[test]
fn images_of_vtk_that_cannot_be_read_are_named() {
    let text = std::str::from_utf8(VTI[0].1).unwrap();
    let message = |from: &str, to: &str| {
        assert!(text.contains(from));
        alone("a.vti", text.replace(from, to).as_bytes()).unwrap_err().to_string()
    };
    assert_eq!(
        message("Extent=\"5 7 0 1 0 1\"", "Extent=\"5 7 0 1 0 9999\""),
        "VTK image file, element DataArray: expected 60000 samples, found 12"
    );
    assert!(message("5 7 0 1 0 1", "0 2147483646 0 2147483646 0 1").contains("at most 2147483648"));
    assert!(message("Int16", "String").contains("type: Int8 to UInt64"));
    assert!(message("800\n", "eight\n").contains("expected numbers, found \"eight\""));
    assert!(message("Spacing=\"0.1", "Spacing=\"0").contains("expected steps between samples"));
    let two = "<DataArray type=\"Int16\" Name=\"a\" format=\"ascii\"></DataArray><DataArray type=\"Int16\" Name=\"b\" \
               format=\"ascii\"></DataArray></PointData>";
    let several = text.replace(" Scalars=\"density\"", "").replace("</PointData>", two);
    let message = alone("a.vti", several.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("arrays density, a, b: name the one"), "{message}");
    let missing = text.replace("100 200", "nan 200").replace("Int16", "Float32");
    let Values::Floats(values) = alone("a.vti", missing.as_bytes()).unwrap().values else {
        panic!("bytes")
    };
    assert!(values.iter().filter(|value| value.is_nan()).count() == 1);
}

#[test]
fn stacks_of_pages_are_read() {
    let volume = alone("a.tif", IMAGEJ).unwrap();
    let above: Vec<f32> = numbers().iter().map(|value| value + 300.0).collect();
    assert_eq!((volume.size, volume.values.to_floats()), ([3, 2, 2], above));
    assert_eq!(volume.frame.unit, UnitKnown::Stated);
    let [x, y, z] = volume.frame.spacing_mm();
    assert!(near(x, 1e-4) && near(y, 2e-4) && near(z, 3e-4), "{x} {y} {z}");
    let volume = alone("a.tif", DEFLATE).unwrap();
    assert_eq!((volume.size, volume.values), ([3, 2, 2], Values::Floats(numbers())));
    assert_eq!(volume.frame, Frame::aligned([1.0; 3], UnitKnown::Missing));
    let volume = alone("a.tif", BIG).unwrap();
    assert_eq!((volume.size, volume.values), ([3, 2, 2], Values::Bytes((0..12).collect())));
    let message = alone("a.tif", file!("rgb.tif")).unwrap_err().to_string();
    assert!(message.starts_with("TIFF file, page 1: RGB(8) is not supported"), "{message}");
}

/// A page of TIFF 6.0 by hand: bytes of which all are `value`, with claims about its size.
fn page(columns: u32, rows: u32, stored: usize, value: u8) -> Vec<u8> {
    let entry = |tag: u16, kind: u16, value: u32| {
        [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &1_u32.to_le_bytes(), &value.to_le_bytes()]
            .concat()
    };
    let entries = [
        entry(256, 4, columns),
        entry(257, 4, rows),
        entry(258, 3, 8),
        entry(259, 3, 1),
        entry(262, 3, 1),
        entry(273, 4, 8 + 2 + 9 * 12 + 4),
        entry(277, 3, 1),
        entry(278, 4, rows),
        entry(279, 4, columns.saturating_mul(rows)),
    ];
    let mut file = b"II\x2A\0\x08\0\0\0\x09\0".to_vec();
    file.extend(entries.concat());
    file.extend([0; 4]);
    file.resize(file.len() + stored, value);
    file
}

fn folder(files: &[(&str, Vec<u8>)]) -> Result<Volume, ReadError> {
    let names: Vec<String> = files.iter().map(|(name, _)| (*name).to_owned()).collect();
    read_slices(&names, &mut |name| {
        let file = files.iter().find(|(own, _)| *own == name);
        file.map(|(_, bytes)| bytes.clone()).ok_or_else(|| "no such file".into())
    })
}

#[test]
fn folders_of_slices_are_read_in_the_order_of_their_numbers() {
    let slice = |value| page(2, 1, 2, value);
    let volume =
        folder(&[("cut_10.tif", slice(3)), ("cut_8.tif", slice(1)), ("cut_9.tif", slice(2))]);
    let volume = volume.unwrap();
    assert_eq!((volume.size, volume.values), ([2, 1, 3], Values::Bytes(vec![1, 1, 2, 2, 3, 3])));
    let padded = folder(&[("a2_0100.tif", slice(2)), ("a2_0090.tif", slice(1))]).unwrap();
    assert_eq!(padded.values, Values::Bytes(vec![1, 1, 2, 2]));
    let alone = folder(&[("only.tif", slice(7))]).unwrap();
    assert_eq!(alone.size, [2, 1, 1]);
    let message = |files: &[(&str, Vec<u8>)]| folder(files).unwrap_err().to_string();
    assert_eq!(
        message(&[("a1.tif", slice(1)), ("a2.tif", slice(1)), ("a4.tif", slice(1))]),
        "TIFF file, slice a4.tif: expected the slice with number 3 after a2.tif, found number 4"
    );
    assert!(
        message(&[("a1.tif", slice(1)), ("a01.tif", slice(1))]).contains("one and the same number")
    );
    assert!(message(&[("a1.tif", slice(1)), ("b2.tif", slice(1))]).contains("slice b2.tif"));
    assert_eq!(message(&[]), "TIFF file, its folder: expected slices, .tif or .tiff, found none");
    assert!(
        message(&[("a1.tif", IMAGEJ.to_vec()), ("a2.tif", IMAGEJ.to_vec())])
            .contains("one page a file")
    );
    let message = message(&[("a1.tif", slice(1)), ("a2.tif", page(1, 2, 2, 0))]);
    assert_eq!(
        message,
        "TIFF file, slice a2.tif: expected a page of 2 × 1 as the first, found 1 × 2"
    );
}

#[test]
fn claimed_sizes_of_pages_allocate_nothing() {
    let message = alone("a.tif", &page(1 << 15, 1 << 15, 100, 0)).unwrap_err().to_string();
    assert_eq!(message, "TIFF file, page 1: expected 1073741824 bytes of samples, found 222");
    let message = alone("a.tif", &page(1 << 20, 1 << 20, 100, 0)).unwrap_err().to_string();
    assert!(message.contains("at most 2147483648 samples"), "{message}");
    assert!(alone("a.tif", &page(0, 4, 0, 0)).is_err());
}

/// Every file cut anywhere is refused or gives the same; with any byte changed it is read or refused, without a panic.
#[test]
fn damaged_images_are_refused() {
    let tiffs = [("a.tif", IMAGEJ), ("a.tif", DEFLATE), ("a.tif", BIG)];
    for (name, whole) in VTI.into_iter().chain(tiffs) {
        let expected = alone(name, whole).unwrap();
        for len in 0..whole.len() {
            match alone(name, &whole[..len]) {
                // The end of the XML holds no samples.
                Ok(found) => assert_eq!(found, expected, "{name} cut to {len}"),
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
        let mut changed = whole.to_vec();
        for at in 0..whole.len() {
            for value in [whole[at] ^ 1, whole[at] ^ 0x80, 0, 0xFF, b'9', b' '] {
                changed[at] = value;
                let _ = alone(name, &changed);
            }
            changed[at] = whole[at];
        }
    }
}
