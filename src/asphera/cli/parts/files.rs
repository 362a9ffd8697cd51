//! The files of `asphera parts --out`.

use std::io::Write as _;
use std::path::Path;

use asphera_formats::ply;
use asphera_geometry::PointMm;

use super::super::columns::whole;
use super::super::files::refuse;
use super::super::output::{Failure, cannot_write, write_json};
use super::Done;
use crate::parts::Scene;
use crate::results;
use crate::whole_file::write_whole;

/// Where files go.
pub(super) struct Out<'a> {
    pub(super) folder: &'a Path,
    /// What was read, which is not to be overwritten.
    pub(super) source: &'a Path,
    pub(super) overwrite: bool,
}

impl Out<'_> {
    /// Writes the figures, the points with their parts, the points of every part, and the results of those that were measured.
    pub(super) fn write(&self, done: &Done, points: &[PointMm]) -> Result<(), Failure> {
        let folder = self.folder;
        let (report_file, points_file) = (folder.join("parts.json"), folder.join("points.ply"));
        let of_part = |number: usize| folder.join(format!("part-{}", number + 1));
        let file = |number: usize| of_part(number).with_extension("ply");
        let refused = |path: &Path| refuse(path, [self.source], self.overwrite);
        refused(&report_file)?;
        refused(&points_file)?;
        let numbers = 0..done.scene.parts.len();
        numbers.clone().try_for_each(|number| refused(&file(number)))?;
        for number in numbers.filter(|&number| done.measurements[number].is_some()) {
            refused(&of_part(number).join("report.json"))?;
        }
        std::fs::create_dir_all(folder)
            .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
        write_json(&report_file, &done.report)?;
        write_points(&points_file, &done.scene, points)?;
        for (number, part) in done.scene.parts.iter().enumerate() {
            let path = file(number);
            write_whole(&path, |file| {
                ply::write_mesh(file, &part.places, &[], None, &["lengths in mm"])
                    .map_err(cannot_write(&path))
            })?;
            if let Some(measurement) = &done.measurements[number] {
                results::write(&of_part(number), measurement)?;
            }
        }
        Ok(())
    }
}

/// Writes every point in the order of the file with the number of its part, from 1; 0 of what is in none. Binary.
fn write_points(path: &Path, scene: &Scene, points: &[PointMm]) -> Result<(), Failure> {
    let mut part_of_row = vec![0_i32; points.len()];
    for (number, part) in (1..).zip(&scene.parts) {
        part.rows.iter().for_each(|&row| part_of_row[row] = number);
    }
    whole(path, |w| {
        writeln!(w, "ply\nformat binary_little_endian 1.0\ncomment lengths in mm")?;
        writeln!(w, "element vertex {}\nproperty double x\nproperty double y", points.len())?;
        writeln!(w, "property double z\nproperty int part\nend_header")?;
        for (point, part) in points.iter().zip(&part_of_row) {
            point.iter().try_for_each(|side| w.write_all(&side.to_le_bytes()))?;
            w.write_all(&part.to_le_bytes())?;
        }
        Ok(())
    })?;
    Ok(())
}
