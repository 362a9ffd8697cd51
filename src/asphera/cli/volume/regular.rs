//! r of the part: stated, or proved by a mesh of it.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use asphera_formats::read_triangles;
use asphera_surface::lfs::mesh_reach;
use serde::Serialize;

use super::super::files::read;
use super::super::output::Failure;
use super::{VolumeArgs, length};
use crate::cli::summary::short;

/// What `--regular` gives.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Regular {
    StatedMm(f64),
    Mesh(PathBuf),
}

impl FromStr for Regular {
    type Err = String;

    fn from_str(word: &str) -> Result<Regular, String> {
        let extension = Path::new(word).extension().map(|of| of.to_string_lossy().to_lowercase());
        if extension.is_some_and(|of| ["stl", "ply", "obj", "off"].contains(&of.as_str())) {
            return Ok(Regular::Mesh(word.into()));
        }
        length(word)
            .map(Regular::StatedMm)
            .map_err(|why| format!("{why}, and no name that ends with .stl, .ply, .obj or .off"))
    }
}

/// The r of a mesh.
#[derive(Debug, Serialize)]
pub(super) struct MeshReachFigures {
    file: String,
    /// The least local feature size on both sides as the mesh has it.
    reach_mm: Option<f64>,
    /// What is proved of it; absent where the mesh proves none.
    pub(super) proved_mm: Option<f64>,
    /// Where it is least.
    at_mm: Option<[f64; 3]>,
    /// What was found, in words.
    pub(super) why: String,
}

/// The r to compare the grid with, and what the mesh said if one was given.
pub(super) fn of(args: &VolumeArgs) -> Result<(Option<f64>, Option<MeshReachFigures>), Failure> {
    match &args.regular {
        None => Ok((None, None)),
        Some(Regular::StatedMm(r)) => Ok((Some(*r), None)),
        Some(Regular::Mesh(path)) => {
            let found = of_mesh(args, path)?;
            Ok((found.proved_mm, Some(found)))
        }
    }
}

fn of_mesh(args: &VolumeArgs, path: &Path) -> Result<MeshReachFigures, Failure> {
    let file = path.display().to_string();
    let mesh = read_triangles(&file, &read(path)?, &args.unit.options())
        .map_err(|error| format!("{file}: {error}"))?
        .ok_or_else(|| format!("{file}: expected triangles for --regular, found points alone"))?;
    Ok(match mesh_reach(&mesh.points_mm, &mesh.triangles) {
        Ok(found) => {
            let [x, y, z] = found.at_mm.map(short);
            let why = format!(
                "r {} mm is proved by the mesh, where its reach is {} mm at ({x}, {y}, {z}) mm",
                short(found.lower_mm),
                short(found.mm)
            );
            MeshReachFigures {
                file,
                reach_mm: Some(found.mm).filter(|mm| mm.is_finite()),
                proved_mm: Some(found.lower_mm),
                at_mm: Some(found.at_mm),
                why,
            }
        }
        Err(why) => MeshReachFigures {
            file,
            reach_mm: None,
            proved_mm: None,
            at_mm: None,
            why: format!("no r is proved: {why}"),
        },
    })
}
