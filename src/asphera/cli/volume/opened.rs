//! A volume file read, its threshold found, its part chosen.

use std::path::Path;

use asphera_formats::volume::{self, Frame, UnitKnown, Values, Volume};
use asphera_formats::{Format, ReadError};
use asphera_volume::{Gaps, Levels, Parts, Samples, SlabBuilder, components};

use super::super::files::read;
use super::super::output::Failure;
use super::sliced::{self, SlicedFile};
use super::{Part, Threshold, VolumeArgs};

/// A volume, ready to be measured.
pub(super) struct Opened {
    pub(super) samples: Samples,
    pub(super) values: Grey,
    pub(super) frame: Frame,
    pub(super) threshold: f64,
    pub(super) threshold_source: &'static str,
    pub(super) levels: Levels,
    /// Samples without a value, as foreground; `None` where there are none.
    pub(super) missing: Option<Samples>,
    /// Where material touches the border of the volume.
    pub(super) border: Border,
    /// Foreground samples at the threshold moved down and up by 1 % of the contrast.
    pub(super) moved_foreground: Option<[u64; 2]>,
    /// Parts there are, before one was chosen.
    pub(super) parts: u64,
    /// Whether one of several parts was chosen.
    pub(super) is_chosen: bool,
    /// All values of a volume in memory whose face is asked for, where there are two only; `values` has them otherwise.
    two: Option<Vec<f32>>,
    format: Format,
}

/// What becomes of the surface at the border of the volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Border {
    /// Nothing, for no material touches it.
    Free,
    /// It ends there.
    Open,
    /// Background beyond closes it, as was asked for.
    Padded,
}

impl Opened {
    /// Where the surface ends.
    pub(super) fn gaps(&self) -> Gaps<'_> {
        Gaps { missing: self.missing.as_ref(), at_border: self.border == Border::Open }
    }

    /// The volume as it was read; `None` of one that was read slice by slice.
    pub(super) fn into_volume(self) -> Option<Volume> {
        let Grey::Whole(values) = self.values else { return None };
        let values = Values::Floats(values.or(self.two)?);
        Some(Volume { size: self.samples.size(), values, frame: self.frame, format: self.format })
    }
}

/// The values that place the vertices; `None` where there are two only, and vertices lie halfway.
pub(super) enum Grey {
    /// All of them in memory.
    Whole(Option<Vec<f32>>),
    /// Those of a file that is read once more, slice by slice.
    Sliced(Option<SlicedFile>),
}

/// What is material, and how much of it there is.
pub(super) struct Thresholded {
    pub(super) all: Samples,
    pub(super) threshold: f64,
    pub(super) threshold_source: &'static str,
    pub(super) levels: Levels,
    pub(super) missing: Option<Samples>,
    pub(super) moved_foreground: Option<[u64; 2]>,
}

/// Opens the volume. One of more than `whole` samples is read slice by slice, where file and method can.
pub(super) fn open(args: &VolumeArgs, whole: u64) -> Result<Opened, Failure> {
    // A large file is not read for nothing.
    args.method()?;
    if let Some(opened) = sliced::open(args, whole)? {
        return Ok(opened);
    }
    let name = args.file.display().to_string();
    let volume = read_volume(&args.file, args.spacing)?;
    let floats = volume.values.to_floats();
    let levels = Levels::new(&floats).ok_or_else(|| no_levels(&name, has_finite(&floats)))?;
    let (threshold, threshold_source) = threshold(&name, args.threshold, &levels)?;
    let all = match &volume.values {
        Values::Bytes(bytes) => Samples::from_bytes(volume.size, bytes, whole_from(threshold))?,
        Values::Floats(_) => {
            let mut builder = SlabBuilder::new(volume.size)?;
            builder.push_values(&floats, threshold as f32)?;
            builder.finish()?
        }
    };
    let count = |threshold: f64| {
        floats.iter().filter(|&&value| is_material(value, threshold)).count() as u64
    };
    let moved_foreground = moved(threshold, &levels).map(|both| both.map(count));
    let mut missing = None;
    if levels.missing > 0 {
        let mut builder = SlabBuilder::new(volume.size)?;
        builder.push_missing(&floats)?;
        missing = Some(builder.finish()?);
    }
    let are_two = levels.are_two;
    let found = Thresholded { all, threshold, threshold_source, levels, missing, moved_foreground };
    let mut opened = found.opened(args, (volume.frame, volume.format), Grey::Whole(None))?;
    if !are_two {
        opened.values = Grey::Whole(Some(floats));
    } else if args.nominal.is_some() {
        opened.two = Some(floats);
    }
    Ok(opened)
}

impl Thresholded {
    /// The part that was asked for.
    pub(super) fn opened(
        self,
        args: &VolumeArgs,
        (frame, format): (Frame, Format),
        values: Grey,
    ) -> Result<Opened, Failure> {
        let Thresholded { all, threshold, threshold_source, levels, missing, moved_foreground } =
            self;
        let (samples, parts) = match args.part {
            Part::All => {
                let parts = components(&all);
                (all, parts)
            }
            Part::Number(number) => {
                let parts = Parts::label(&all);
                let part = parts.volume_of(number - 1).ok_or_else(|| {
                    let count = parts.count();
                    format!("--part {number}: expected a part of the volume, found {count}")
                })?;
                (part, parts.count() as u64)
            }
        };
        let border = match (samples.touches_border(), args.pad) {
            (false, _) => Border::Free,
            (true, true) => Border::Padded,
            (true, false) => Border::Open,
        };
        let is_chosen = parts > 1 && args.part != Part::All;
        Ok(Opened {
            samples,
            values,
            frame,
            threshold,
            threshold_source,
            levels,
            missing,
            border,
            moved_foreground: moved_foreground.filter(|_| !is_chosen),
            parts,
            is_chosen,
            two: None,
            format,
        })
    }
}

/// The threshold moved down and up by 1 % of the contrast; none where there are two values only.
pub(super) fn moved(threshold: f64, levels: &Levels) -> Option<[f64; 2]> {
    let step = (levels.material - levels.background) / 100.0;
    (!levels.are_two).then_some([threshold - step, threshold + step])
}

/// Whether a value is material; one that is not finite is missing.
pub(super) fn is_material(value: f32, threshold: f64) -> bool {
    value.is_finite() && f64::from(value) >= threshold
}

/// Whole numbers are at the threshold or above from the next whole number on.
pub(super) fn whole_from(threshold: f64) -> u8 {
    threshold.ceil().clamp(0.0, 255.0) as u8
}

/// Why values have no threshold between inside and outside.
pub(in crate::cli) fn no_levels(name: &str, has_finite: bool) -> Failure {
    let found = if has_finite { "one value all over" } else { "no value that is finite" };
    format!("{name}: expected samples of at least two values, inside and outside; found {found}")
        .into()
}

pub(in crate::cli) fn has_finite(values: &[f32]) -> bool {
    values.iter().any(|value| value.is_finite())
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

pub(super) fn failed(name: &str, error: ReadError) -> Failure {
    if error.names_file() { error.into() } else { format!("{name}: {error}").into() }
}

/// The frame with the spacing that was asked for, if one was.
pub(super) fn spaced(
    name: &str,
    frame: Frame,
    spacing: Option<[f64; 3]>,
) -> Result<Frame, Failure> {
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

pub(super) fn threshold(
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
