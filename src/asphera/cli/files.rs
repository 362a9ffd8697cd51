//! Files the commands read, and those they must not write.

use std::fs;
use std::path::Path;

use asphera_formats::{KINDS, Topography};

use super::output::{Failure, say};
use super::summary;
use super::text::{TextArgs, reading};
use super::unit_doubt::UnitCheck;
use crate::config::{Part, TOML, Weights, text_of};
use crate::pipeline::{Along, Measurement, Pipeline};

/// What the help says of an argument that is a file of points.
pub(super) fn points_help() -> String {
    format!("The points: {KINDS}")
}

/// What a nominal file says.
pub(super) fn part(path: &Path) -> Result<Part, Failure> {
    let name = path.display().to_string();
    let text = text_of(&name, read(path)?)
        .map_err(|found| format!("{name}: expected {TOML}, found {found}"))?;
    Ok(Part::parse(&name, &text)?)
}

/// The points of a file.
pub(super) fn topography(path: &Path, text: &TextArgs) -> Result<Topography, Failure> {
    let name = path.display().to_string();
    let bytes = read(path)?;
    asphera_formats::read_with(&name, &bytes, &text.options()).map_err(|error| {
        match error.names_file() {
            true => error.to_string().into(),
            false => format!("{name}: {}", crate::error_chain(&error)).into(),
        }
    })
}

/// The standard uncertainty of the height of every point of a file, mm, with its place.
fn uncertainties(topography: &Topography, path: &Path) -> Result<Vec<([f64; 3], f64)>, Failure> {
    let (name, uncertainties_mm) = (path.display(), topography.uncertainties_mm());
    if uncertainties_mm.is_empty() {
        return Err(format!(
            "{name}: expected a column u_z[mm], the standard uncertainty of each z, for the weights the nominal asks \
             for; found none"
        )
        .into());
    }
    let bad = uncertainties_mm.iter().position(|u_mm| !(u_mm.is_normal() && *u_mm > 0.0));
    if let Some(index) = bad {
        return Err(format!(
            "{name}: the u_z of measured point {} is {} mm, expected a number above 0; leave out a point that is not \
             to count",
            index + 1,
            uncertainties_mm[index]
        )
        .into());
    }
    Ok(topography.points().zip(uncertainties_mm.iter().copied()).collect())
}

/// A pipeline for the points of a file, which knows how well they are known where the nominal asks for it.
pub(super) fn pipeline(
    part: Part,
    along: Along,
    topography: &Topography,
    path: &Path,
) -> Result<Pipeline, Failure> {
    let uncertain = match part.criterion.weights {
        Weights::None => Vec::new(),
        Weights::Uncertainty => uncertainties(topography, path)?,
    };
    let mut pipeline = Pipeline::along(part, along);
    pipeline.know_uncertainties(uncertain);
    let places = topography.points().map(|[x, ..]| x);
    pipeline.know_slopes(places.zip(topography.slopes().iter().copied()));
    Ok(pipeline)
}

/// Measures the points of a file against a part.
pub(super) fn measured(
    part: Part,
    along: Along,
    topography: &Topography,
    path: &Path,
) -> Result<Measurement, Failure> {
    let check = UnitCheck::of(topography, &part);
    let mut pipeline = pipeline(part, along, topography, path)?;
    pipeline.take_positions(topography.points());
    pipeline.take_gaps(topography.missing() as u64);
    let mut measurement = pipeline.finish();
    note_reading(&mut measurement, topography, check);
    Ok(measurement)
}

/// Adds to a measurement how its file was read, and whether another unit is more likely.
pub(super) fn note_reading(
    measurement: &mut Measurement,
    topography: &Topography,
    check: Option<UnitCheck>,
) {
    measurement.report.reading = reading(topography);
    if let Some(check) = check {
        let points_mm: Vec<_> = topography.points().collect();
        check.add(&points_mm, measurement);
    }
}

/// Says on stderr how a file was read that leaves columns or units open, where no report does.
pub(super) fn say_reading(topography: &Topography) {
    if let Some(reading) = reading(topography) {
        say(summary::reading(&reading).trim_end());
    }
}

/// The bytes of a file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()).into())
}

/// Fails where `out` must not be written: it is `source`, or it is there and not to be overwritten.
pub(super) fn refuse(out: &Path, source: &Path, overwrite: bool) -> Result<(), Failure> {
    if !out.exists() {
        return Ok(());
    }
    if let (Ok(out), Ok(source)) = (out.canonicalize(), source.canonicalize())
        && out == source
    {
        return Err(format!("{} is the file that is read; expected another", out.display()).into());
    }
    if !overwrite {
        return Err(format!("{} is there already; --force overwrites it", out.display()).into());
    }
    Ok(())
}
