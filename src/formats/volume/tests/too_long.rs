//! Files with more samples than their header states.

use std::io::{Cursor, Write as _};

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};

use super::{NIFTI_1, alone};
use crate::volume::unpack::{Packing, unpacked};
use crate::volume::{SliceReader, Stored, read};

/// What is said of a file with one beside it, read at once and slice by slice.
fn said(name: &str, own: &[u8], other: &[u8]) -> [Option<String>; 2] {
    let whole = read(name, own, &mut |_| Ok(other.to_vec()));
    let mut open = |wanted: Option<&str>| {
        let bytes = if wanted.is_none() { own } else { other };
        Ok(Stored { reader: Box::new(Cursor::new(bytes.to_vec())), length: bytes.len() as u64 })
    };
    let by_slices = SliceReader::open(name, &mut open).and_then(|slices| {
        let mut slices = slices.unwrap();
        while slices.next_slice()?.is_some() {}
        Ok(())
    });
    [whole.map(|_| ()), by_slices].map(|found| found.err().map(|error| error.to_string()))
}

fn right(name: &str, own: &[u8], other: &[u8]) {
    assert_eq!(said(name, own, other), [None, None], "{name}");
}

fn wrong(name: &str, own: &[u8], other: &[u8], expected: &str) {
    for said in said(name, own, other) {
        let said = said.unwrap_or_else(|| panic!("{name}: nothing is said, not {expected}"));
        assert!(said.contains(expected), "{expected}: {said}");
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

#[test]
fn more_samples_than_nrrd_states_are_refused() {
    let header = |more: &str| {
        format!("NRRD0004\ntype: ushort\ndimension: 3\nsizes: 2 1 2\nendian: little\n{more}\n")
            .into_bytes()
    };
    let with = |more: &str, samples: &[u8]| [&header(more), samples].concat();
    right("a.nrrd", &with("encoding: raw\n", b"12345678"), b"");
    wrong(
        "a.nrrd",
        &with("encoding: raw\n", b"1234567890"),
        b"",
        "NRRD file, line 4: expected 8 bytes of samples, 2 × 1 × 2 of 2 each, found 10: the sizes or the type in the header may be wrong",
    );
    let lines = "encoding: raw\nline skip: 1\nbyte skip: 3\ndata file: a.raw";
    right("a.nhdr", &header(lines), b"a line\n###12345678");
    wrong("a.nhdr", &header(lines), b"a line\n###12345678\n", "8 bytes of samples");
    let last = "encoding: raw\nbyte skip: -1\ndata file: a.raw";
    right("a.nhdr", &header(last), b"any length of bytes before them");
    right("a.nrrd", &with("encoding: gzip\n", &gzip(b"12345678")), b"");
    // Two members are one after the other; what follows them and is none has no samples.
    let members = [gzip(b"12345"), gzip(b"678")].concat();
    right("a.nrrd", &with("encoding: gzip\n", &[&members[..], b"\n"].concat()), b"");
    let members = [members, gzip(b"90")].concat();
    wrong("a.nrrd", &with("encoding: gzip\n", &members), b"", "of 2 each, found 10: the sizes");
    let packed = with("encoding: gzip\nbyte skip: 3\n", &gzip(b"###12345678"));
    right("a.nrrd", &packed, b"");
    let text = |samples: &str| {
        let file = with("encoding: ascii\n", samples.as_bytes());
        alone("a.nrrd", &file).map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(text("1 2\n3 4\n\n"), Ok(()));
    let found = text("1 2\n3 4\n\n5 6\n").unwrap_err();
    let expected =
        "NRRD file, line 11: expected 4 samples, found 6: the sizes in the header may be wrong";
    assert_eq!(found, expected);
}

#[test]
fn more_samples_than_metaimage_states_are_refused() {
    let header = |more: &str, file: &str| {
        format!(
            "NDims = 3\nDimSize = 2 1 2\nElementType = MET_SHORT\n{more}ElementDataFile = {file}\n"
        )
        .into_bytes()
    };
    let with = |more: &str, samples: &[u8]| [&header(more, "LOCAL"), samples].concat();
    let expected =
        "MetaImage file, line 2: expected 8 bytes of samples, 2 × 1 × 2 of 2 each, found 9";
    right("a.mha", &with("", b"12345678"), b"");
    wrong("a.mha", &with("", b"123456789"), b"", expected);
    right("a.mhd", &header("", "a.raw"), b"12345678");
    wrong("a.mhd", &header("HeaderSize = 2\n", "a.raw"), b"##123456789", expected);
    right("a.mhd", &header("HeaderSize = -1\n", "a.raw"), b"##123456789");
    let zlib = |bytes: &[u8]| {
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(bytes).unwrap();
        packed.finish().unwrap()
    };
    right("a.mha", &with("CompressedData = True\n", &zlib(b"12345678")), b"");
    wrong("a.mha", &with("CompressedData = True\n", &zlib(b"123456789")), b"", expected);
}

/// Fields by nifti1.h: dim at 40, bitpix at 72, vox_offset at 108, magic at 344.
#[test]
fn more_samples_than_nifti_states_are_refused() {
    let plain = unpacked(crate::Format::Nifti, 0, NIFTI_1, Packing::Gzip, 1 << 20).unwrap();
    right("a.nii", &plain, b"");
    let longer = [&plain[..], b"\0"].concat();
    let expected =
        "NIfTI file, byte 40: expected 24 bytes of samples, 3 × 2 × 2 of 2 each, found 25";
    wrong("a.nii", &longer, b"", expected);
    wrong("a.nii.gz", &gzip(&longer), b"", expected);
    // An extension lies between the header and the samples.
    let mut extended = plain.clone();
    extended[108..112].copy_from_slice(&368_f32.to_le_bytes());
    extended.splice(352..352, [1; 16]);
    right("a.nii", &extended, b"");
    // The offset of a pair is that in the file with the samples.
    let (mut pair, samples) = (plain[..348].to_vec(), &plain[352..]);
    pair[344..348].copy_from_slice(b"ni1\0");
    pair[108..112].copy_from_slice(&0_f32.to_le_bytes());
    right("a.hdr", &pair, samples);
    wrong("a.hdr", &pair, &[b"\0", samples].concat(), expected);
    pair[108..112].copy_from_slice(&1_f32.to_le_bytes());
    right("a.hdr", &pair, &[b"\0", samples].concat());
}

#[test]
fn bits_that_contradict_the_type_of_nifti_are_refused() {
    let mut file = unpacked(crate::Format::Nifti, 0, NIFTI_1, Packing::Gzip, 1 << 20).unwrap();
    file[72..74].copy_from_slice(&8_i16.to_le_bytes());
    let expected = "NIfTI file, byte 72: expected bitpix 16, as datatype 4 has, found 8";
    wrong("a.nii", &file, b"", expected);
    file[72..74].copy_from_slice(&0_i16.to_le_bytes());
    right("a.nii", &file, b"");
}
