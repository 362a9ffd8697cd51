//! A volume file read, its threshold found, its part chosen.

use std::path::Path;

use asphera_formats::ReadError;
use asphera_formats::volume::{self, Frame, UnitKnown, Values, Volume};
use asphera_volume::{Levels, Parts, Samples, SlabBuilder};

use super::super::files::read;
use super::super::output::Failure;
use super::{Part, Threshold, VolumeArgs};

/// A volume, ready to be measured.
pub(super) struct Opened {
    pub(super) samples: Samples,
    /// Values, where they are more than two: they place the vertices.
    pub(super) grey: Option<Vec<f32>>,
    pub(super) frame: Frame,
    pub(super) threshold: f64,
    pub(super) threshold_source: &'static str,
    pub(super) levels: Levels,
    /// Foreground samples at the threshold moved down and up by 1 % of the contrast.
    pub(super) moved_foreground: Option<[u64; 2]>,
    /// Parts there are, before one was chosen.
    pub(super) parts: usize,
    /// Whether one of several parts was chosen.
    pub(super) is_chosen: bool,
}

pub(super) fn open(args: &VolumeArgs) -> Result<Opened, Failure> {
    let name = args.file.display().to_string();
    let volume = read_volume(&args.file, args.spacing)?;
    let frame = volume.frame;
    let floats = volume.values.to_floats();
    let Some(levels) = Levels::new(&floats) else {
        return Err(format!(
            "{name}: expected samples of at least two values, inside and outside; found one value all over"
        )
        .into());
    };
    let (threshold, threshold_source) = threshold(&name, args.threshold, &levels)?;
    let all = match &volume.values {
        // Whole numbers are at the threshold or above from the next whole number on.
        Values::Bytes(bytes) => {
            Samples::from_bytes(volume.size, bytes, threshold.ceil().clamp(0.0, 255.0) as u8)?
        }
        Values::Floats(_) => {
            let mut builder = SlabBuilder::new(volume.size)?;
            builder.push_values(&floats, threshold as f32)?;
            builder.finish()?
        }
    };
    let step = (levels.material - levels.background) / 100.0;
    let count =
        |threshold: f64| floats.iter().filter(|&&v| f64::from(v) >= threshold).count() as u64;
    let moved_foreground =
        (!levels.are_two).then(|| [count(threshold - step), count(threshold + step)]);
    let parts = Parts::label(&all);
    let (samples, is_chosen) = match args.part {
        Part::All => (all, false),
        Part::Number(number) => {
            let part = parts.volume_of(number - 1).ok_or_else(|| {
                format!("--part {number}: expected a part of the volume, found {}", parts.count())
            })?;
            (part, parts.count() > 1)
        }
    };
    Ok(Opened {
        samples,
        grey: (!levels.are_two).then_some(floats),
        frame,
        threshold,
        threshold_source,
        levels,
        moved_foreground: moved_foreground.filter(|_| !is_chosen),
        parts: parts.count(),
        is_chosen,
    })
}

/// The volume of a file or of a folder of slices; its spacing is known.
pub(in crate::cli) fn read_volume(
    path: &Path,
    spacing: Option<[f64; 3]>,
) -> Result<Volume, Failure> {
    let volume = if path.is_dir() { slices(path) } else { file(path) }?;
    let frame = spaced(&path.display().to_string(), volume.frame, spacing)?;
    Ok(Volume { frame, ..volume })
}

/// The volume of a file.
fn file(path: &Path) -> Result<Volume, Failure> {
    let bytes = read(path)?;
    let name = path.display().to_string();
    let folder = path.parent().unwrap_or_else(|| Path::new(""));
    volume::read(&name, &bytes, &mut |file| in_folder(folder, file))
        .map_err(|error| failed(&name, error))
}

/// The volume of a folder of slices, `.tif` and `.tiff`.
fn slices(folder: &Path) -> Result<Volume, Failure> {
    let name = folder.display().to_string();
    let cannot =
        |error: std::io::Error| -> Failure { format!("cannot read {name}: {error}").into() };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot)? {
        let Ok(file) = entry.map_err(cannot)?.file_name().into_string() else { continue };
        let lower = file.to_lowercase();
        // Files that begin with a dot are notes of the system about the others.
        if !file.starts_with('.') && (lower.ends_with(".tif") || lower.ends_with(".tiff")) {
            names.push(file);
        }
    }
    volume::read_slices(&names, &mut |file| in_folder(folder, file))
        .map_err(|error| failed(&name, error))
}

fn in_folder(folder: &Path, file: &str) -> Result<Vec<u8>, String> {
    std::fs::read(folder.join(file)).map_err(|error| format!("{file}: {error}"))
}

fn failed(name: &str, error: ReadError) -> Failure {
    if error.names_file() { error.into() } else { format!("{name}: {error}").into() }
}

/// The frame with the spacing that was asked for, if one was.
fn spaced(name: &str, frame: Frame, spacing: Option<[f64; 3]>) -> Result<Frame, Failure> {
    let Some(spacing) = spacing else {
        return match frame.unit {
            UnitKnown::Missing => Err(format!(
                "{name}: the file states no spacing: give --spacing MM, the distance of neighbouring samples"
            )
            .into()),
            UnitKnown::Stated | UnitKnown::Assumed => Ok(frame),
        };
    };
    let own = frame.spacing_mm();
    let mut spaced = Frame { unit: UnitKnown::Stated, ..frame };
    for (step, (from, to)) in spaced.steps_mm.iter_mut().zip(own.into_iter().zip(spacing)) {
        *step = step.map(|side| side / from * to);
    }
    Ok(spaced)
}

fn threshold(
    name: &str,
    asked: Option<Threshold>,
    levels: &Levels,
) -> Result<(f64, &'static str), Failure> {
    let (low, high) = (f64::from(levels.low), f64::from(levels.high));
    match asked {
        Some(Threshold::Value(value)) if value > low && value <= high => Ok((value, "given")),
        Some(Threshold::Value(value)) => Err(format!(
            "{name}: expected a threshold above the smallest value {low} and up to the largest {high}, found {value}"
        )
        .into()),
        None if levels.are_two => Ok((f64::midpoint(low, high), "two values")),
        Some(Threshold::Iso50) => Ok((levels.iso_50(), "iso50")),
        None | Some(Threshold::Otsu) => Ok((levels.otsu, "otsu")),
    }
}
