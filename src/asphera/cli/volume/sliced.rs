//! A volume read slice by slice: its bits are kept, its values are read again where they place the surface.

use std::fs::File;
use std::path::{Path, PathBuf};

use asphera_formats::volume::{SliceReader, Stored, Values};
use asphera_volume::{LevelCounts, LevelRange, Levels, SlabBuilder};

use super::super::output::Failure;
use super::opened::{
    Grey, Opened, Thresholded, failed, is_material, moved, no_levels, spaced, threshold, whole_from,
};
use super::{MethodName, VolumeArgs};

/// A file whose slices lie one after another.
pub(in crate::cli) struct SlicedFile {
    path: PathBuf,
    size: [usize; 3],
}

impl SlicedFile {
    /// The slices from the first on; `None` of a file that has none in a row.
    pub(super) fn open(path: &Path) -> Result<Option<SliceReader>, Failure> {
        if path.is_dir() {
            return Ok(None);
        }
        let name = path.display().to_string();
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        let mut open = |beside: Option<&str>| {
            let path = beside.map_or_else(|| path.to_owned(), |file| folder.join(file));
            let fail = |error: std::io::Error| format!("{}: {error}", path.display());
            let file = File::open(&path).map_err(fail)?;
            let meta = file.metadata().map_err(fail)?;
            if !meta.is_file() {
                return Err(format!("{}: no file", path.display()));
            }
            Ok(Stored { reader: Box::new(file), length: meta.len() })
        };
        SliceReader::open(&name, &mut open).map_err(|error| failed(&name, error))
    }

    /// The slices once more; fails if there are others now.
    pub(super) fn again(&self) -> Result<SliceReader, Failure> {
        let name = self.path.display();
        let reader = SlicedFile::open(&self.path)?.filter(|reader| reader.size() == self.size);
        reader.ok_or_else(|| format!("{name}: changed while it was read").into())
    }
}

/// Opens a volume of more than `whole` samples; `None` of a smaller one, and where file or method ask for all of it at once.
pub(super) fn open(args: &VolumeArgs, whole: u64) -> Result<Option<Opened>, Failure> {
    if args.method != MethodName::Mmc {
        return Ok(None);
    }
    let Some(reader) = SlicedFile::open(&args.file)? else { return Ok(None) };
    let size = reader.size();
    if size.iter().map(|&side| side as u64).product::<u64>() <= whole {
        return Ok(None);
    }
    let name = args.file.display().to_string();
    let frame = (spaced(&name, reader.frame(), args.spacing)?, reader.format());
    let file = SlicedFile { path: args.file.clone(), size };
    let counted = Counted::of(&name, reader, &file)?;
    let (at, threshold_source) = threshold(&name, args.threshold, &counted.levels)?;
    let mut builder = SlabBuilder::new(size)?;
    // None of bytes, which are all numbers.
    let mut missing = (counted.levels.missing > 0).then(|| SlabBuilder::new(size)).transpose()?;
    let moved_to = moved(at, &counted.levels);
    let mut moved_foreground = [0_u64; 2];
    let mut again = file.again()?;
    while let Some(slice) = next(&name, &mut again)? {
        match &slice {
            Values::Bytes(bytes) => builder.push_bytes(bytes, whole_from(at))?,
            Values::Floats(floats) => {
                builder.push_values(floats, at as f32)?;
                if let Some(missing) = &mut missing {
                    missing.push_missing(floats)?;
                }
                for (count, at) in moved_foreground.iter_mut().zip(moved_to.unwrap_or_default()) {
                    *count += floats.iter().filter(|&&v| is_material(v, at)).count() as u64;
                }
            }
        }
    }
    if let (Some(bytes), Some(moved_to)) = (&counted.bytes, moved_to) {
        let above = |at: f64| {
            (0..=255_u8)
                .zip(bytes)
                .filter(|(value, _)| f64::from(*value) >= at)
                .map(|of| of.1)
                .sum()
        };
        moved_foreground = moved_to.map(above);
    }
    let found = Thresholded {
        all: builder.finish()?,
        threshold: at,
        threshold_source,
        levels: counted.levels,
        missing: missing.map(SlabBuilder::finish).transpose()?,
        moved_foreground: moved_to.map(|_| moved_foreground),
    };
    let values = Grey::Sliced((!counted.levels.are_two).then_some(file));
    found.opened(args, frame, values).map(Some)
}

/// The next slice of a file.
pub(super) fn next(name: &str, reader: &mut SliceReader) -> Result<Option<Values>, Failure> {
    reader.next_slice().map_err(|error| failed(name, error))
}

/// The values of a file counted.
struct Counted {
    levels: Levels,
    /// How often each byte occurs, of samples that are bytes.
    bytes: Option<[u64; 256]>,
}

impl Counted {
    fn of(name: &str, mut reader: SliceReader, file: &SlicedFile) -> Result<Counted, Failure> {
        let mut range = LevelRange::default();
        let mut bytes = [0_u64; 256];
        let are_bytes = reader.are_bytes();
        while let Some(slice) = next(name, &mut reader)? {
            match slice {
                Values::Bytes(slice) => count_bytes(&slice, &mut bytes),
                Values::Floats(slice) => range.add(&slice),
            }
        }
        let present = (0..=255_u8).zip(&bytes).filter(|(_, count)| **count > 0);
        let present: Vec<f32> = present.map(|(value, _)| f32::from(value)).collect();
        range.add(&present);
        let mut counts =
            LevelCounts::new(range).ok_or_else(|| no_levels(name, range.has_finite()))?;
        if are_bytes {
            (0..=255_u8).zip(bytes).for_each(|(value, times)| counts.add(f32::from(value), times));
        } else {
            let mut again = file.again()?;
            while let Some(Values::Floats(slice)) = next(name, &mut again)? {
                slice.iter().for_each(|&value| counts.add(value, 1));
            }
        }
        Ok(Counted { levels: counts.finish(), bytes: are_bytes.then_some(bytes) })
    }
}

/// Counts bytes in four tables at a time, so that equal neighbours do not wait for one another.
fn count_bytes(values: &[u8], counts: &mut [u64; 256]) {
    let mut tables = [[0_u64; 256]; 4];
    let (fours, rest) = values.as_chunks::<4>();
    for four in fours {
        for (table, &value) in tables.iter_mut().zip(four) {
            table[usize::from(value)] += 1;
        }
    }
    rest.iter().for_each(|&value| tables[0][usize::from(value)] += 1);
    for table in tables {
        counts.iter_mut().zip(table).for_each(|(all, more)| *all += more);
    }
}
