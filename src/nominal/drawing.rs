//! Drawings that a nominal names.

use std::path::Path;

use asphera_formats::drawing::{DrawnLine, read_dxf, read_svg};
use asphera_report::contour::ContourReport;

/// Names of files of drawings end so.
pub const DRAWINGS: &str = "a name that ends in .svg, .dxf, or .json of contour --json";

/// Whether a name is that of a drawing.
pub fn is_drawing(path: &Path) -> bool {
    matches!(ending(path).as_str(), "svg" | "dxf" | "json")
}

/// The lines of a drawing, by the ending of its name.
///
/// # Errors
///
/// With what was found, when it is no drawing or cannot be read.
pub fn drawn_lines(path: &Path, bytes: &[u8]) -> Result<Vec<DrawnLine>, String> {
    if !is_drawing(path) {
        return Err(format!("expected {DRAWINGS}"));
    }
    match ending(path).as_str() {
        "svg" => read_svg(bytes).map_err(|error| error.to_string()),
        "dxf" => read_dxf(bytes).map_err(|error| error.to_string()),
        _ => of_contour(bytes),
    }
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// The lines of what `contour --json` wrote.
fn of_contour(bytes: &[u8]) -> Result<Vec<DrawnLine>, String> {
    let report: ContourReport = serde_json::from_slice(bytes)
        .map_err(|error| format!("expected what contour --json writes: {error}"))?;
    let chains = report.chains.iter();
    Ok(chains.filter_map(|chain| DrawnLine::through(&chain.points_mm, chain.closed)).collect())
}
