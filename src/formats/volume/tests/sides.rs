//! Raw samples with a header beside them: TOML and `.vgi`, by hand.

use super::super::{UnitKnown, Values, Volume, read};
use crate::{Format, ReadError};

const TOML: &str = "# A CT scan.\nsize = [3, 2, 1]\ntype = \"u16\"\nbyte_order = \"big\"\nspacing_mm = [0.1, 0.1, 0.25]\n\
                    origin_mm = [1, 2.5, -3]\nheader_bytes = 2\n";

const VGI: &str = "{volume1}\r\n[representation]\r\nsize = 3 2 1\r\ndatatype = float\r\nbitsperelement = 32\r\n\
                   [file1]\r\nRegionOfInterestEnd = 2 1 0\r\nFileFormat = raw\r\nSize = 3 2 1\r\nName = part.vol\r\n\
                   Datatype = unsigned integer\r\nBitsPerElement = 16\r\nSkipHeader = 0\r\nMirror = 0 0 0\r\n\
                   {volumeprimitive12}\r\n[geometry]\r\nresolution = 0.05 0.05 0.1\r\nunit = mm\r\n";

/// Reads the first file, with the others beside it.
fn folder(files: &[(&str, &[u8])]) -> Result<Volume, ReadError> {
    read(files[0].0, files[0].1, &mut |name| {
        let file = files.iter().find(|(own, _)| *own == name);
        file.map(|(_, bytes)| bytes.to_vec()).ok_or_else(|| format!("{name}: none"))
    })
}

#[test]
fn raw_samples_are_what_the_toml_beside_them_says() {
    let raw: &[u8] = &[9, 9, 0, 1, 0, 2, 0, 3, 1, 0, 1, 1, 255, 255];
    let toml = ("part.toml", TOML.as_bytes());
    for files in [[("part.raw", raw), toml], [toml, ("part.raw", raw)]] {
        let volume = folder(&files).unwrap();
        assert_eq!((volume.size, volume.format), ([3, 2, 1], Format::Raw));
        assert_eq!(volume.values, Values::Floats(vec![1.0, 2.0, 3.0, 256.0, 257.0, 65_535.0]));
        assert_eq!(volume.frame.spacing_mm(), [0.1, 0.1, 0.25]);
        assert_eq!(volume.frame.origin_mm, [1.0, 2.5, -3.0]);
        assert_eq!(volume.frame.unit, UnitKnown::Stated);
    }
    let bytes = "size = [1, 2, 1]\ntype = \"u8\"\nfile = \"b.bin\"\n";
    let volume = folder(&[("a.toml", bytes.as_bytes()), ("b.bin", &[4, 5])]).unwrap();
    assert_eq!((volume.values, volume.frame.unit), (Values::Bytes(vec![4, 5]), UnitKnown::Missing));
    let doubles = "size = [1, 1, 2]\ntype = \"f64\"\nbyte_order = \"little\"\nspacing_mm = 1\n";
    let samples = [2.5_f64.to_le_bytes(), f64::NAN.to_le_bytes()].concat();
    let volume = folder(&[("a.raw", &samples), ("a.toml", doubles.as_bytes())]).unwrap();
    let Values::Floats(values) = volume.values else { panic!("bytes") };
    assert!(values[0] == 2.5 && values[1].is_nan());
}

#[test]
fn wrong_tomls_are_named_with_the_key() {
    let message = |from: &str, to: &str| {
        assert!(TOML.contains(from));
        let toml = TOML.replace(from, to);
        folder(&[("part.raw", &[0; 14]), ("part.toml", toml.as_bytes())]).unwrap_err().to_string()
    };
    assert_eq!(
        message("[3, 2, 1]", "[3, 2, 2]"),
        "raw volume file, element size: expected a file of 26 bytes with the samples: header_bytes, then size × type, \
         found 14 bytes"
    );
    assert!(message("[3, 2, 1]", "[65536, 65536, 65536]").contains("at most 2147483648 samples"));
    assert!(
        message("[3, 2, 1]", "[3, 2]").contains("expected [columns, rows, slices], found [3, 2]")
    );
    assert!(message("[3, 2, 1]", "[3, -2, 1]").contains("element size"));
    assert!(message("\"u16\"", "\"u12\"").contains("\"u8\", \"i8\""));
    assert!(message("byte_order = \"big\"\n", "").contains("\"little\" or \"big\", found none"));
    assert!(message("0.25", "0").contains("one length or three, mm, above 0"));
    assert!(
        message("origin_mm", "orign_mm").contains("element orign_mm: expected one of the keys")
    );
    assert!(message("header_bytes = 2", "header_bytes = 9223372036854775807").contains("14 bytes"));
    assert!(message("size = ", "size == ").contains("line 2"));
    let alone = folder(&[("part.raw", &[0; 14])]).unwrap_err().to_string();
    assert_eq!(
        alone,
        "raw volume file, byte 0: expected part.toml with size, type and byte_order, or a .vgi, beside it, found neither"
    );
    for path in ["../x.raw", "/x.raw", "C:x.raw", "a\\\\b", ".."] {
        let toml = format!("{TOML}file = \"{path}\"\n");
        let message = folder(&[("part.toml", toml.as_bytes())]).unwrap_err().to_string();
        assert!(message.contains("a file in this folder, without a path"), "{message}");
    }
}

#[test]
fn headers_of_volume_graphics_are_read() {
    let samples: &[u8] = &[1, 0, 2, 0, 3, 0, 0, 1, 1, 1, 255, 255];
    let vgi = ("part.vgi", VGI.as_bytes());
    for files in [[vgi, ("part.vol", samples)], [("part.vol", samples), vgi]] {
        let volume = folder(&files).unwrap();
        assert_eq!((volume.size, volume.format), ([3, 2, 1], Format::Vgi));
        assert_eq!(volume.values, Values::Floats(vec![1.0, 2.0, 3.0, 256.0, 257.0, 65_535.0]));
        assert_eq!(volume.frame.spacing_mm(), [0.05, 0.05, 0.1]);
        assert_eq!(volume.frame.unit, UnitKnown::Stated);
    }
    let changed = |from: &str, to: &str| {
        assert!(VGI.contains(from));
        let vgi = VGI.replace(from, to);
        folder(&[("part.vgi", vgi.as_bytes()), ("part.vol", samples)])
    };
    let message = |from: &str, to: &str| changed(from, to).unwrap_err().to_string();
    for path in ["..\\part.vol", "../part.vol", "D:\\scans\\part.vol", "/scans/part.vol"] {
        let message = message("Name = part.vol", &format!("Name = {path}"));
        assert!(
            message.starts_with("VGI file, line 10: expected the name of a file in this folder")
        );
    }
    assert!(
        message("Size = 3 2 1", "Size = 3 2 2")
            .contains("line 9: expected a size that fits the 12 bytes")
    );
    assert!(message("Size = 3 2 1", "Size = 99999 99999 9").contains("at most"));
    assert!(message("Element = 16", "Element = 12").contains("line 12: \"12\" is not supported"));
    assert!(message("Mirror = 0 0 0", "Mirror = 1 0 0").contains("expected Mirror = 0 0 0"));
    assert!(message("unit = mm", "unit = furlong").contains("expected mm, um"));
    assert_eq!(changed("unit = mm\r\n", "").unwrap().frame.unit, UnitKnown::Assumed);
    assert_eq!(changed("resolution", "other").unwrap().frame.unit, UnitKnown::Missing);
    let lacking = folder(&[vgi]).unwrap_err().to_string();
    assert!(lacking.contains("the file with the samples beside the header, found part.vol: none"));
}

/// Headers cut or changed anywhere are read or refused, without a panic.
#[test]
fn damaged_headers_are_refused() {
    for (name, header) in [("part.toml", TOML), ("part.vgi", VGI)] {
        for len in 0..header.len() {
            let _ = folder(&[
                (name, &header.as_bytes()[..len]),
                ("part.raw", &[0; 14]),
                ("part.vol", &[0; 12]),
            ]);
        }
        let mut changed = header.as_bytes().to_vec();
        for at in 0..changed.len() {
            let before = changed[at];
            for value in [0, 0x80, 0xFF, b'9', b' ', b'\n', b'[', before ^ 1] {
                changed[at] = value;
                let _ = folder(&[(name, &changed), ("part.raw", &[0; 14]), ("part.vol", &[0; 12])]);
            }
            changed[at] = before;
        }
    }
}
