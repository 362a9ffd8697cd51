//! Meshes as files.

use std::io::{self, Write};
use std::path::Path;

use asphera_formats::{ply, stl};
use asphera_geometry::PointMm;

use crate::cli::output::{Failure, cannot_write};
use crate::cli::usage::misused;
use crate::whole_file::write_whole;

/// The formats that surfaces are written in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MeshKind {
    Ply,
    Stl,
    Obj,
    Off,
}

pub(super) fn kind_of(path: &Path) -> Result<MeshKind, Failure> {
    match path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).as_deref() {
        Some("ply") => Ok(MeshKind::Ply),
        Some("stl") => Ok(MeshKind::Stl),
        Some("obj") => Ok(MeshKind::Obj),
        Some("off") => Ok(MeshKind::Off),
        _ => Err(misused(format!(
            "{}: expected a name that ends with .ply, .stl, .obj or .off",
            path.display()
        ))),
    }
}

pub(super) fn write(
    path: &Path,
    points_mm: &[PointMm],
    facets: &[[u32; 3]],
) -> Result<(), Failure> {
    let kind = kind_of(path)?;
    write_whole(path, |file| match kind {
        MeshKind::Ply => ply::write_mesh(file, points_mm, facets, None, &["lengths in mm"])
            .map_err(cannot_write(path)),
        MeshKind::Stl => stl::write_mesh(file, points_mm, facets).map_err(cannot_write(path)),
        MeshKind::Obj | MeshKind::Off => {
            text(file, kind, points_mm, facets).map_err(cannot_write(path))
        }
    })
}

/// Wavefront OBJ counts corners from 1, the Object File Format from 0.
fn text(
    file: &mut impl Write,
    kind: MeshKind,
    points_mm: &[PointMm],
    facets: &[[u32; 3]],
) -> io::Result<()> {
    let (vertex, face, first) = match kind {
        MeshKind::Obj => ("v ", "f", 1),
        _ => ("", "3", 0),
    };
    match kind {
        MeshKind::Obj => writeln!(file, "# lengths in mm")?,
        _ => writeln!(file, "OFF\n{} {} 0", points_mm.len(), facets.len())?,
    }
    for [x, y, z] in points_mm {
        writeln!(file, "{vertex}{x} {y} {z}")?;
    }
    for [a, b, c] in facets.iter().map(|facet| facet.map(|corner| corner + first)) {
        writeln!(file, "{face} {a} {b} {c}")?;
    }
    file.flush()
}
