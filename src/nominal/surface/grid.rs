//! A surface given by a file of heights.

use std::path::Path;
use std::sync::Arc;

use asphera_form::Nominal;
use asphera_form::shape::{ConicSection, Nodes, SagGrid};
use asphera_formats::{ReadError, Topography};
use asphera_settings::Section;

use super::super::text::bytes_of;
use super::base::{base, even_powers, on_base};

/// `kind = "grid"`: the heights of a topography file, over a conic and powers where these are given.
pub(super) fn grid(surface: &Section<'_>, folder: &Path) -> Option<Nominal> {
    let has_base = ["radius_mm", "conic", "base"].iter().any(|key| surface.has(key));
    let conic = if has_base { base(surface) } else { Some(ConicSection::FLAT) };
    let powers = even_powers(surface);
    let heights = heights(surface, folder);
    on_base(surface, conic?, &powers, Arc::new(heights?))
}

fn heights(surface: &Section<'_>, folder: &Path) -> Option<SagGrid> {
    let path = folder.join(surface.required::<String>("file")?);
    let name = path.display();
    let expected = "a file of heights on a grid: X3P, SDF, MetroPro or Zemax grid sag";
    let bytes = bytes_of(&path)
        .map_err(|error| surface.problem("file", expected, format!("{name}: {error}")))
        .ok()?;
    let map = match asphera_formats::read(&name.to_string(), &bytes) {
        Ok(Topography::Map(map, _)) => map,
        Ok(Topography::Cloud(..)) => {
            surface.problem("file", expected, format!("{name}, which lists points"));
            return None;
        }
        Err(error) => {
            surface.problem("file", expected, said(&name, &error));
            return None;
        }
    };
    let nodes = Nodes {
        x_min_mm: map.x0_mm,
        y_min_mm: map.y0_mm,
        step_x_mm: map.dx_mm,
        step_y_mm: map.dy_mm,
        nx: map.nx,
        ny: map.ny,
    };
    SagGrid::new(nodes, &map.z_mm)
        .map_err(|error| surface.problem("file", expected, format!("{name}: {error}")))
        .ok()
}

/// An error of reading, with the file it is of.
fn said(name: &impl std::fmt::Display, error: &ReadError) -> String {
    match error.names_file() {
        true => error.to_string(),
        false => format!("{name}: {}", asphera_report::error_chain(error)),
    }
}
