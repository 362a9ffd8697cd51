//! Files the commands read, and those they must not write.

use std::fs;
use std::path::Path;

use asphera_formats::Topography;

use super::output::Failure;
use crate::config::Part;
use crate::pipeline::{Along, Measurement, Pipeline};

/// What a nominal file says.
pub(super) fn part(path: &Path) -> Result<Part, Failure> {
    let name = path.display().to_string();
    let text = String::from_utf8(read(path)?)
        .map_err(|error| format!("{name}: expected UTF-8 text: {error}"))?;
    Ok(Part::parse(&name, &text)?)
}

/// The points of a file.
pub(super) fn topography(path: &Path) -> Result<Topography, Failure> {
    let name = path.display().to_string();
    asphera_formats::read(&name, &read(path)?)
        .map_err(|error| format!("{name}: {}", crate::error_chain(&error)).into())
}

/// Measures points against a part; `missing` places had none.
pub(super) fn measured(
    part: Part,
    along: Along,
    points: impl IntoIterator<Item = [f64; 3]>,
    missing: usize,
) -> Measurement {
    let mut pipeline = Pipeline::along(part, along);
    points.into_iter().for_each(|point| pipeline.take_position(point));
    pipeline.take_gaps(missing as u64);
    pipeline.finish()
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
