//! Volumes read slice by slice are those read at once.

use std::io::{Cursor, Write as _};

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::{META, NRRD};
use crate::ReadError;
use crate::test_data::shared;
use crate::volume::{SliceReader, Stored, Values, Volume, read};

type Files<'a> = &'a [(&'a str, &'a [u8])];

/// The first of some files that lie beside each other, opened.
fn opened(files: Files<'_>) -> Result<Option<SliceReader>, ReadError> {
    let (own, _) = files[0];
    SliceReader::open(own, &mut |name| {
        let wanted = name.unwrap_or(own);
        let (_, bytes) = files.iter().find(|(name, _)| *name == wanted).ok_or("no such file")?;
        Ok(Stored { reader: Box::new(Cursor::new(bytes.to_vec())), length: bytes.len() as u64 })
    })
}

fn at_once(files: Files<'_>) -> Result<Volume, ReadError> {
    read(files[0].0, files[0].1, &mut |wanted| {
        let found = files.iter().find(|(name, _)| *name == wanted);
        found.map(|(_, bytes)| bytes.to_vec()).ok_or_else(|| "no such file".into())
    })
}

fn assert_same(files: Files<'_>) {
    let whole = at_once(files).unwrap();
    let mut slices = opened(files).unwrap().unwrap();
    assert_eq!(slices.size(), whole.size);
    assert_eq!((slices.frame(), slices.format()), (whole.frame, whole.format));
    let are_bytes = matches!(whole.values, Values::Bytes(_));
    assert_eq!(slices.are_bytes(), are_bytes);
    let mut found = Vec::new();
    for _ in 0..whole.size[2] {
        let slice = slices.next_slice().unwrap().unwrap();
        assert_eq!(slice.len(), whole.size[0] * whole.size[1]);
        assert_eq!(matches!(slice, Values::Bytes(_)), are_bytes);
        found.extend(slice.to_floats());
    }
    assert_eq!(slices.next_slice().unwrap(), None);
    let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect::<Vec<u32>>();
    assert_eq!(bits(found), bits(whole.values.to_floats()), "{}", files[0].0);
}

fn vol(version: u8, samples: &[u8]) -> Vec<u8> {
    let mut file = format!("X: 2\nY: 3\nZ: 4\nVersion: {version}\n.\n").into_bytes();
    file.extend_from_slice(samples);
    file
}

fn samples() -> Vec<u8> {
    (0..24).map(|at| at * 9).collect()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

#[test]
fn slices_are_those_of_the_whole_volume() {
    let samples = samples();
    let packed = zlib(&samples);
    assert_same(&[("a.vol", &vol(2, &samples))]);
    assert_same(&[("a.vol", &vol(3, &packed))]);
    assert_same(&[("a.nrrd", NRRD)]);
    assert_same(&[("a.mha", META)]);
    let header =
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: raw\nspacings: 1 1 1\n";
    let lines = b"one\ntwo\n";
    let data = [&lines[..], b"###", &samples].concat();
    for skip in ["line skip: 2\nbyte skip: 3\n", "byte skip: -1\n", "line skip: 1\nbyte skip: -1\n"]
    {
        let header = format!("{header}{skip}data file: ./a.raw\n");
        assert_same(&[("a.nhdr", header.as_bytes()), ("a.raw", &data)]);
    }
    let header = "NDims = 3\nDimSize = 2 3 2\nElementType = MET_USHORT\nElementSpacing = 1 2 3\n\
                  BinaryDataByteOrderMSB = True\n";
    for skip in ["HeaderSize = 11\n", "HeaderSize = -1\n"] {
        let header = format!("{header}{skip}ElementDataFile = a.raw\n");
        assert_same(&[("a.mhd", header.as_bytes()), ("a.raw", &data)]);
    }
    let side = b"size = [3, 2, 2]\ntype = \"i16\"\nbyte_order = \"big\"\nspacing_mm = 0.5\nheader_bytes = 11\n";
    assert_same(&[("a.toml", side), ("a.raw", &data)]);
    assert_same(&[("a.raw", &data), ("a.toml", side)]);
}

/// NIfTI packed and not, with its samples in the same file and in one beside it, its values scaled and not.
#[test]
fn slices_of_nifti_are_those_of_the_whole_volume() {
    for packed in [super::NIFTI_1, super::NIFTI_2] {
        assert_same(&[("a.nii.gz", packed)]);
        let plain = crate::volume::unpack::unpacked(
            crate::Format::Nifti,
            0,
            packed,
            crate::volume::unpack::Packing::Gzip,
            1 << 20,
        )
        .unwrap();
        assert_same(&[("a.nii", &plain)]);
        let cut = &plain[..plain.len() - 1];
        let mut slices = opened(&[("a.nii", cut)]).unwrap().unwrap();
        let ends = std::iter::from_fn(|| Some(slices.next_slice())).find(Result::is_err);
        assert!(ends.unwrap().unwrap_err().to_string().contains("in slice"));
    }
    // A header of 348 bytes by nifti1.h: dim at 40, datatype at 70, bitpix at 72, pixdim at 76, scl_slope at 112, scl_inter at 116.
    let mut header = vec![0_u8; 348];
    header[..4].copy_from_slice(&348_i32.to_le_bytes());
    for (at, value) in [(40, 3_i16), (42, 2), (44, 3), (46, 4), (70, 2), (72, 8)] {
        header[at..at + 2].copy_from_slice(&value.to_le_bytes());
    }
    for (at, value) in [(80, 0.5_f32), (84, 0.5), (88, 0.5), (112, 2.0), (116, -3.0)] {
        header[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    header[344..348].copy_from_slice(b"ni1\0");
    assert_same(&[("a.hdr", &header), ("a.img", &samples())]);
}

#[test]
fn files_that_end_too_soon_are_named() {
    let samples = samples();
    let packed = zlib(&samples);
    for file in [vol(2, &samples[..23]), vol(2, &[]), vol(3, &packed[..packed.len() - 9])] {
        let mut slices = opened(&[("a.vol", &file)]).unwrap().unwrap();
        let mut read = || loop {
            match slices.next_slice() {
                Ok(Some(_)) => {}
                Ok(None) => panic!("a file that ends too soon was read to its end"),
                Err(error) => return error.to_string(),
            }
        };
        let message = read();
        assert!(
            message.contains("4 slices of 6 bytes") && message.contains("in slice"),
            "{message}"
        );
    }
    let side = b"size = [3, 2, 2]\ntype = \"u8\"\n";
    let message = opened(&[("a.toml", side), ("a.raw", &samples)]).err().unwrap().to_string();
    assert!(message.contains("a file of 12 bytes") && message.contains("24 bytes"), "{message}");
    let message = opened(&[("a.toml", side)]).err().unwrap().to_string();
    assert!(message.contains("no such file"), "{message}");
    // What is no volume, or has no slices in a row, is left to others.
    for (name, bytes) in
        [("a.xyz", &b"1 2 3\n"[..]), ("a.tif", b"II\x2A\0\x08\0\0\0"), ("a.vol", b"")]
    {
        assert!(opened(&[(name, bytes)]).unwrap().is_none(), "{name}");
    }
    let huge = b"X: 65536\nY: 65536\nZ: 17\nVersion: 2\n.\n";
    let message = opened(&[("a.vol", huge)]).err().unwrap().to_string();
    assert!(message.contains("68719476736"), "{message}");
}

#[test]
fn real_volumes_are_read_slice_by_slice() {
    let names = ["cat10.vol", "sphere-10.vol", "bunny-128.vol", "BallBinary30x30x30.nrrd"];
    let more = ["BallBinary30x30x30_gz.nrrd", "BallBinary30x30x30_gz_lineskip.nrrd"];
    for name in names.into_iter().chain(more) {
        let Some(bytes) = shared(&format!("volumes/{name}")) else { return };
        assert_same(&[(name, &bytes)]);
    }
    let Some(samples) = shared("volumes/BallBinary30x30x30.raw") else { return };
    for name in ["BallBinary30x30x30.nhdr", "BallBinary30x30x30_byteskip_minus_one.nhdr"] {
        let Some(header) = shared(&format!("volumes/{name}")) else { return };
        assert_same(&[(name, &header), ("BallBinary30x30x30.raw", &samples)]);
    }
}
