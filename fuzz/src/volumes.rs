//! Files of volumes as a fuzzer can write them, and what must hold for whatever a reader makes of them.
//!
//! The first byte of an input chooses the name of the file, the next two the length of the file that lies beside it, which comes last;
//! between them is the file. So headers find their samples, and samples their headers.

use std::io::Cursor;

use asphera_formats::volume::{
    Frame, SliceReader, Stored, Values, Volume, format_of, read, read_slices,
};

/// Reads an input, at once and slice by slice, and checks what came out of it.
///
/// # Panics
///
/// Where a law is broken.
pub fn hold(input: &[u8]) {
    let [name, high, low, files @ ..] = input else { return };
    let name = NAMES[usize::from(*name) % NAMES.len()];
    let beside = usize::from(u16::from_be_bytes([*high, *low])).min(files.len());
    let (file, beside) = files.split_at(files.len() - beside);
    let _ = format_of(name, file);
    let whole = read(name, file, &mut |_| Ok(beside.to_vec()));
    match &whole {
        Ok(volume) => is_sound(volume, file.len() + beside.len()),
        Err(error) => is_readable(&error.to_string()),
    }
    slices(name, file, beside, whole.as_ref().ok());
    // The same as one slice of a folder.
    if name.ends_with(".tif") {
        let names = ["slice-1.tif", "slice-2.tif"].map(str::to_owned);
        let mut open = |name: &str| Ok(if name == names[0] { file } else { beside }.to_vec());
        match read_slices(&names, &mut open) {
            Ok(volume) => is_sound(&volume, file.len() + beside.len()),
            Err(error) => is_readable(&error.to_string()),
        }
    }
}

/// Names of files: those that decide, and one that does not.
pub const NAMES: [&str; 10] = [
    "a.nrrd", "a.nhdr", "a.mha", "a.nii", "a.nii.gz", "a.tif", "a.vti", "a.vgi", "a.toml", "a.vol",
];

/// Samples read slice by slice are those of the whole; a file that has none in a row is refused, or is none for it.
fn slices(name: &str, file: &[u8], beside: &[u8], whole: Option<&Volume>) {
    let mut open = |name: Option<&str>| {
        let bytes = if name.is_none() { file } else { beside };
        let length = bytes.len() as u64;
        Ok(Stored { reader: Box::new(Cursor::new(bytes.to_vec())), length })
    };
    let mut reader = match SliceReader::open(name, &mut open) {
        Ok(Some(reader)) => reader,
        Ok(None) => return,
        Err(error) => return is_readable(&error.to_string()),
    };
    frame_is_sound(&reader.frame());
    let (size, are_bytes) = (reader.size(), reader.are_bytes());
    let mut values = Vec::new();
    for slice in 0..=size[2] {
        match reader.next_slice() {
            Ok(Some(found)) => {
                assert_eq!(matches!(found, Values::Bytes(_)), are_bytes, "a slice of another type");
                assert_eq!(found.len(), size[0] * size[1], "a slice of another size");
                values.extend(found.to_floats());
            }
            Ok(None) => {
                assert_eq!(slice, size[2], "a slice too few");
                break;
            }
            Err(error) => {
                assert!(whole.is_none(), "{error}, but the whole was read");
                return is_readable(&error.to_string());
            }
        }
    }
    if let Some(volume) = whole {
        assert_eq!(
            (volume.size, volume.frame, volume.format),
            (size, reader.frame(), reader.format())
        );
        let of_whole = volume.values.to_floats();
        let same = of_whole.iter().zip(&values).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(same && of_whole.len() == values.len(), "slices of other samples");
    }
}

/// There are as many samples as the size says, no more than the bytes can hold, and they lie somewhere.
fn is_sound(volume: &Volume, bytes: usize) {
    let [columns, rows, slices] = volume.size;
    let samples = columns.checked_mul(rows).and_then(|area| area.checked_mul(slices));
    assert_eq!(samples, Some(volume.values.len()), "{:?}", volume.size);
    assert!(!volume.values.is_empty(), "a volume of nothing");
    // The most a byte can stand for is what DEFLATE makes of one, 1032; LZW makes less.
    assert!(
        volume.values.len() <= bytes.saturating_mul(1032),
        "{:?} of {bytes} bytes",
        volume.size
    );
    frame_is_sound(&volume.frame);
}

fn frame_is_sound(frame: &Frame) {
    let numbers = frame.origin_mm.iter().chain(frame.steps_mm.as_flattened());
    assert!(numbers.copied().all(f64::is_finite), "{frame:?}");
    assert!(frame.spacing_mm().iter().all(|step| *step > 0.0), "{frame:?}");
}

/// A message of at most some lines, without signs that move a terminal.
fn is_readable(message: &str) {
    assert!(!message.trim().is_empty(), "an error without words");
    assert!(message.len() <= 4096, "an error of {} bytes", message.len());
    let moves = |sign: char| sign.is_control() && sign != '\n';
    assert!(!message.contains(moves), "{message:?}");
}
