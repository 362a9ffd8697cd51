//! The files a measurement leaves: report, mesh, deviations.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use asphera_formats::{HeightMap, WriteError, ply, x3p};
use asphera_report::ResultFile;
use thiserror::Error;

use asphera_measure::{DeviationMap, Measurement, Pipeline};
use asphera_paper::{Provenance, html, qif};

use crate::whole_file::{CannotWrite, write_whole};

/// Why a result could not be written.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// The file system refused.
    #[error("cannot write {}", path.display())]
    File {
        /// Which file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The content cannot be put into that format.
    #[error("cannot write {}", path.display())]
    Format {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: WriteError,
    },
    /// The report is no JSON.
    #[error("cannot write {}", path.display())]
    Json {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
}

/// Writes `report.json`, `mesh.ply`, `deviation.ply` and `deviation.x3p` into `folder`, which is made if it
/// is not there. `deviation.x3p` needs a fit; without one it is left out, and so is a stale one.
///
/// Each file is written beside its place and then moved there, so that no half file is ever seen.
///
/// # Errors
///
/// Why the first file could not be written that could not. The others are written all the same.
pub fn write(folder: &Path, measurement: &Measurement) -> Result<(), ResultsError> {
    write_files(folder, &ResultFile::OUT, measurement, &Provenance::default())
}

/// Writes files of a measurement; `provenance` stands in those that are papers. As [`write()`] otherwise.
///
/// # Errors
///
/// As [`write()`].
pub fn write_files(
    folder: &Path,
    files: &[ResultFile],
    measurement: &Measurement,
    provenance: &Provenance,
) -> Result<(), ResultsError> {
    fs::create_dir_all(folder)
        .map_err(|source| ResultsError::File { path: folder.to_owned(), source })?;
    let results = files.iter().map(|of| write_one(folder, *of, measurement, provenance));
    // All are tried: a disk that is full may have room for a smaller one.
    results.fold(Ok(()), Result::and)
}

/// The command line of this process, for papers.
pub fn command_line() -> String {
    let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
    words.collect::<Vec<String>>().join(" ")
}

fn write_one(
    folder: &Path,
    of: ResultFile,
    measurement: &Measurement,
    provenance: &Provenance,
) -> Result<(), ResultsError> {
    let (points, triangles) = (&measurement.points_mm, &measurement.triangles);
    let name = of.name();
    match of {
        ResultFile::Report => file(folder, name, |w, path| {
            serde_json::to_writer_pretty(&mut *w, &measurement.report)
                .map_err(|source| ResultsError::Json { path: path.to_owned(), source })?;
            w.write_all(b"\n")
                .map_err(|source| ResultsError::File { path: path.to_owned(), source })
        }),
        ResultFile::Html => text(folder, name, &html(measurement, provenance)),
        ResultFile::Qif => text(folder, name, &qif(&measurement.report, provenance)),
        ResultFile::Mesh => file(folder, name, |w, path| {
            ply::write_mesh(w, points, triangles, None, &[UNITS]).map_err(format(path))
        }),
        ResultFile::DeviationMesh => file(folder, name, |w, path| {
            let scalar = Some(("scalar_deviation_nm", measurement.deviations_nm.as_slice()));
            let comments = [UNITS, "deviation in nm, nan where there is none"];
            ply::write_mesh(w, points, triangles, scalar, &comments).map_err(format(path))
        }),
        ResultFile::DeviationMap => match &measurement.map {
            Some(map) => deviation_map(folder, name, measurement, map),
            None => match fs::remove_file(folder.join(name)) {
                Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
                    Err(ResultsError::File { path: folder.join(name), source })
                }
                _ => Ok(()),
            },
        },
    }
}

fn deviation_map(
    folder: &Path,
    name: &str,
    measurement: &Measurement,
    map: &DeviationMap,
) -> Result<(), ResultsError> {
    file(folder, name, |w, path| {
        let heights = HeightMap {
            nx: map.grid.nx,
            ny: map.grid.ny,
            dx_mm: map.grid.dx_mm,
            dy_mm: map.grid.dy_mm,
            x0_mm: map.grid.x0_mm,
            y0_mm: map.grid.y0_mm,
            z_mm: map.values_nm.iter().map(|value| value * 1e-6).collect(),
        };
        let session = measurement.report.session.as_ref();
        let plane =
            measurement.report.mesh.projection.as_ref().map(|projection| {
                format!("x and y lie in the plane of projection: {projection}; ")
            });
        let comment = format!("{}{}", plane.unwrap_or_default(), map.source);
        let started = session.map_or(NO_DATE, |session| session.started.as_str());
        let metadata = x3p::Metadata {
            date: started,
            calibration_date: NO_DATE,
            creator: None,
            manufacturer: "asphera",
            model: session.map_or("file", |session| session.station.as_str()),
            serial: session.map_or("none", |session| session.id.as_str()),
            version: env!("CARGO_PKG_VERSION"),
            probing: x3p::Probing::Software,
            probe: "form deviation along the normal of the nominal, after alignment",
            comment: Some(&comment),
        };
        x3p::write_turned_map(w, &heights, map.turn_rad, &metadata).map_err(format(path))
    })
}

/// The mesh so far as a PLY file; `None` without a vertex.
pub fn mesh_ply(pipeline: &Pipeline) -> Option<Vec<u8>> {
    let (points, triangles) = pipeline.mesh();
    ply_bytes(&points, &triangles)
}

/// The mesh of a finished session as a PLY file; `None` without a vertex.
pub fn finished_mesh_ply(measurement: &Measurement) -> Option<Vec<u8>> {
    ply_bytes(&measurement.points_mm, &measurement.triangles)
}

fn ply_bytes(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Option<Vec<u8>> {
    if points.is_empty() {
        return None;
    }
    let mut bytes = Vec::new();
    // A mesh's own points and triangles are always finite and in range.
    ply::write_mesh(&mut bytes, points, triangles, None, &[UNITS]).ok()?;
    Some(bytes)
}

/// Where no date is known; the standard wants one.
const NO_DATE: &str = "1970-01-01T00:00:00Z";
const UNITS: &str = "coordinates in mm, measured frame";

fn format(path: &Path) -> impl FnOnce(WriteError) -> ResultsError + use<> {
    let path = path.to_owned();
    |source| ResultsError::Format { path, source }
}

fn text(folder: &Path, name: &str, text: &str) -> Result<(), ResultsError> {
    file(folder, name, |w, path| {
        w.write_all(text.as_bytes())
            .map_err(|source| ResultsError::File { path: path.to_owned(), source })
    })
}

/// Writes one file.
fn file(
    folder: &Path,
    name: &str,
    content: impl FnOnce(&mut BufWriter<File>, &Path) -> Result<(), ResultsError>,
) -> Result<(), ResultsError> {
    let path = folder.join(name);
    write_whole(&path, |writer| content(writer, &path))
}

impl From<CannotWrite> for ResultsError {
    fn from(CannotWrite { path, source }: CannotWrite) -> ResultsError {
        ResultsError::File { path, source }
    }
}

#[cfg(test)]
mod raster_tests;
#[cfg(test)]
mod tests;
