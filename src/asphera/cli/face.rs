//! The face of a volume that a nominal describes, for the commands that measure points.

use std::path::{Path, PathBuf};

use asphera_face::{
    Body, Face, Lattice, Lying, MeasuredFace, Scan, Settings, Threshold as Value, VolumeViewer,
    between,
};
use asphera_formats::volume::{Values, Volume};
use asphera_formats::{Format, volume};
use asphera_measure::{Along, Measurement, Part, undecide};
use asphera_report::{SecondFigures, Timing};
use asphera_volume::Levels;
use clap::Args;

use super::files::{part, read, timed};
use super::output::Failure;
use super::progress::Progress;
use super::source::{Source, is_recording};
use super::usage::misused;
use super::volume::opened::{has_finite, no_levels, read_volume};
use super::volume::{Threshold, spacing};
use crate::shown::ShownMeasurement;

/// What the command line says of a volume.
#[derive(Args)]
pub(super) struct FaceArgs {
    /// Of a volume: the value of its surface; otsu, or iso50, halfway between the levels of material and background on both sides of
    /// the face, which is the default.
    #[arg(long, value_name = "T|otsu|iso50", allow_hyphen_values = true)]
    threshold: Option<Threshold>,
    /// Of a volume: the standard uncertainty of the threshold, grey values. Without it from the levels over the face.
    #[arg(long, value_name = "U", value_parser = not_below_0)]
    u_threshold: Option<f64>,
    /// Of a volume: the spacing of its samples, one length or three, for what the file says, or does not.
    #[arg(long, value_name = "MM[,MM,MM]", value_parser = spacing)]
    spacing: Option<[f64; 3]>,
    /// Of a volume: standard deviation of the Gaussian that takes noise from its grey values, in spacings; 0 for none.
    #[arg(long, value_name = "SPACINGS", default_value_t = SMOOTHING, value_parser = not_below_0)]
    smooth: f64,
    /// Of a volume: the nominal of the other face of the part. It is measured too, with thickness, wedge and decentre.
    #[arg(long, value_name = "FILE")]
    second: Option<PathBuf>,
}

/// A Gaussian of one spacing: it takes 85 % of white noise, and 0.5 % of waves of 60 spacings.
const SMOOTHING: f64 = 1.0;

/// What was measured of a volume.
pub(super) struct Faces {
    pub(super) first: Measurement,
    pub(super) second: Option<Measurement>,
    /// The volume, to be looked at.
    body: Body,
}

impl Faces {
    /// The first face for the page, with the volume and both faces in it.
    pub(super) fn shown(self, path: &Path) -> Result<ShownMeasurement, Failure> {
        let Faces { first, second, body } = self;
        let threshold = first.report.volume.as_ref().map_or(0.0, |face| face.threshold);
        let faces: Vec<MeasuredFace<'_>> = std::iter::once(&first)
            .chain(&second)
            .map(|face| MeasuredFace {
                points_mm: &face.points_mm,
                deviations_nm: &face.deviations_nm,
            })
            .collect();
        let viewer = VolumeViewer::new(body, threshold, &faces)?;
        Ok(ShownMeasurement::new(&name_of(path), first, Some(viewer)))
    }
}

/// The name of a file without its folder.
pub(super) fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

impl FaceArgs {
    /// Fails where something is said of a volume, and there is none.
    pub(super) fn refuse(&self, path: &Path) -> Result<(), Failure> {
        let given = [
            (self.threshold.is_some(), "--threshold"),
            (self.u_threshold.is_some(), "--u-threshold"),
            (self.spacing.is_some(), "--spacing"),
            (self.smooth.to_bits() != SMOOTHING.to_bits(), "--smooth"),
            (self.second.is_some(), "--second"),
        ];
        match given.into_iter().find(|(is_given, _)| *is_given) {
            Some((_, option)) => Err(misused(format!(
                "{}: expected a volume for {option}, found points: leave it out",
                path.display()
            ))),
            None => Ok(()),
        }
    }

    /// Those of a part of which both faces are measured.
    pub(super) fn of_pair(second: PathBuf) -> FaceArgs {
        FaceArgs { second: Some(second), ..FaceArgs::of_face(None, None) }
    }

    /// Those of one face.
    pub(super) fn of_face(threshold: Option<Threshold>, spacing: Option<[f64; 3]>) -> FaceArgs {
        FaceArgs { threshold, u_threshold: None, spacing, smooth: SMOOTHING, second: None }
    }

    /// The nominal of the other face.
    pub(super) fn second(&self) -> Option<&Path> {
        self.second.as_deref()
    }
}

/// Whether a path leads to a volume: its content says so, or where samples have no header its name.
pub(super) fn is_volume(path: &Path) -> Result<bool, Failure> {
    if path.is_dir() {
        let holds = |ending: &[&str]| {
            std::fs::read_dir(path).is_ok_and(|entries| {
                entries.flatten().any(|entry| {
                    let name = entry.file_name().to_string_lossy().to_lowercase();
                    !name.starts_with('.') && ending.iter().any(|ending| name.ends_with(ending))
                })
            })
        };
        return Ok(!is_recording(path) && !holds(&["mesh.ply"]) && holds(&[".tif", ".tiff"]));
    }
    // What comes through a pipe can be read once only: it is taken for points.
    let is_pipe = std::fs::metadata(path).is_ok_and(|held| !held.is_file());
    if is_pipe || is_recording(path) {
        return Ok(false);
    }
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let is_bare = ending.is_some_and(|ending| ["raw", "vol", "bin"].contains(&ending.as_str()));
    Ok(is_bare || volume::format_of(&path.display().to_string(), &read(path)?).is_some())
}

/// Measures the face of a file that a nominal describes, and the other one where it is asked for.
pub(super) fn measured(
    path: &Path,
    args: &FaceArgs,
    given: Option<Part>,
    along: Option<Along>,
    seed: Option<u64>,
    progress: &Progress,
) -> Result<Faces, Failure> {
    let name = path.display();
    let first = given.ok_or_else(|| {
        misused(format!("{name} is a volume: --nominal FILE says which face of it is meant"))
    })?;
    let second = args.second.as_deref().map(part).transpose()?;
    let along = match along.map(|along| along.normal().ok_or(())) {
        None => None,
        Some(Ok(direction)) => Some(direction),
        Some(Err(())) => {
            return Err(misused(format!(
                "{name}: expected --along z or nx,ny,nz, the side a face of a volume is seen from; found fitted, none or auto, which are of points"
            )));
        }
    };
    progress.stage("reading");
    let opened = Opened::new(path, read_volume(path, args.spacing)?, args)?;
    let (mut first, lies) = opened.measured(&first, along, seed, progress)?;
    let mut other = None;
    if let Some(second) = second {
        // The other face is seen from the other side.
        let along = along.map(|direction| direction.map(|side| -side));
        let (measurement, other_lies) = opened.measured(&second, along, seed, progress)?;
        let lies = lies.as_ref().zip(other_lies.as_ref());
        let figures = SecondFigures {
            lies: lies.and_then(|(first, second)| between(first, second)),
            report: Box::new(measurement.report.clone()),
        };
        if let Some(face) = &mut first.report.volume {
            face.second = Some(figures);
        }
        other = Some(measurement);
    }
    Ok(Faces { first, second: other, body: opened.body })
}

/// A volume with its threshold.
struct Opened {
    path: PathBuf,
    format: Format,
    body: Body,
    settings: Settings,
    are_two: bool,
    missing: u64,
    is_assumed: bool,
}

/// Measures one face of a volume that was read already, from a path.
pub(super) fn measured_in(
    path: &Path,
    volume: Volume,
    args: &FaceArgs,
    part: &Part,
    progress: &Progress,
) -> Result<Measurement, Failure> {
    let (measurement, _) = Opened::new(path, volume, args)?.measured(part, None, None, progress)?;
    Ok(measurement)
}

impl Opened {
    fn new(path: &Path, volume: Volume, args: &FaceArgs) -> Result<Opened, Failure> {
        let name = path.display().to_string();
        let values = match volume.values {
            Values::Floats(values) => values,
            bytes @ Values::Bytes(_) => bytes.to_floats(),
        };
        let levels = Levels::new(&values).ok_or_else(|| no_levels(&name, has_finite(&values)))?;
        let threshold = match args.threshold {
            None | Some(Threshold::Iso50) => Value::Halfway(levels.iso_50()),
            Some(Threshold::Otsu) => Value::Stated(levels.otsu),
            Some(Threshold::Value(value)) => Value::Stated(value),
        };
        let frame = volume.frame;
        let lattice = Lattice { origin_mm: frame.origin_mm, steps_mm: frame.steps_mm };
        let scan = Scan { values, size: volume.size, lattice };
        Ok(Opened {
            path: path.to_owned(),
            format: volume.format,
            body: Body::new(scan, args.smooth),
            settings: Settings { threshold, u_threshold: args.u_threshold, along: None },
            are_two: levels.are_two,
            missing: levels.missing,
            is_assumed: frame.unit == volume::UnitKnown::Assumed,
        })
    }

    /// One face through the pipeline, with the place where it lies.
    fn measured(
        &self,
        part: &Part,
        along: Option<[f64; 3]>,
        seed: Option<u64>,
        progress: &Progress,
    ) -> Result<(Measurement, Option<Lying>), Failure> {
        progress.stage("looking for the face");
        let settings = Settings { along, ..self.settings };
        let mut face = self
            .body
            .face(part, &settings)
            .map_err(|error| format!("{}: {error}", self.path.display()))?;
        self.note(&mut face);
        let points_mm = std::mem::take(&mut face.points_mm);
        let source = Source::of_points(&self.path, points_mm, self.format);
        let known = face.part(part.clone());
        let (mut measurement, timing): (Measurement, Timing) =
            timed(known, (face.projection(), None), &source, seed, progress)?;
        measurement.report.timing = timing;
        let lies = Lying::in_report(&face, &part.nominal, &measurement.report);
        if self.are_two {
            undecide(
                &mut measurement.report.verdict,
                "the volume has two values: they place its surface to half a spacing, and no u counts that".to_owned(),
            );
        }
        measurement.report.volume = Some(face.figures);
        Ok((measurement, lies))
    }

    /// Adds what must be known of the file.
    fn note(&self, face: &mut Face) {
        let reasons = &mut face.figures.reasons;
        if self.is_assumed {
            reasons.push(
                "the file states no unit of length: mm is assumed; --spacing overrides it"
                    .to_owned(),
            );
        }
        if self.missing > 0 {
            reasons.push(format!("{} samples of the volume have no value", self.missing));
        }
    }
}

fn not_below_0(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err(format!("expected a number not below 0, found `{word}`")),
    }
}

#[cfg(test)]
mod tests;
