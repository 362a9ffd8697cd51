//! The nominal outline of a contour.

use std::path::Path;

use asphera_contour::PlaceMm;
use asphera_contour::features::NominalOutline;
use asphera_contour::sampler::BezierLine;
use asphera_formats::drawing::DrawnLine;
use asphera_nominal::{drawn_lines, is_drawing};
use thiserror::Error;

/// A nominal outline as it lies: lines of Bézier curves, and the file they are from.
#[derive(Clone, Debug, PartialEq)]
pub struct Nominal {
    name: String,
    lines: Vec<BezierLine>,
}

/// Why a file is no nominal outline.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct NominalError(String);

impl Nominal {
    /// The outline of a drawing, by the ending of its name; `None` where that is of no drawing.
    ///
    /// # Errors
    ///
    /// When the drawing cannot be read, or holds no line.
    pub(crate) fn of_drawing(
        path: &Path,
        read: impl FnOnce(&Path) -> std::io::Result<Vec<u8>>,
    ) -> Option<Result<Nominal, NominalError>> {
        let name = path.display().to_string();
        if !is_drawing(path) {
            return None;
        }
        let bytes = match read(path) {
            Ok(bytes) => bytes,
            Err(error) => return Some(Err(NominalError(format!("cannot read {name}: {error}")))),
        };
        Some(match drawn_lines(path, &bytes) {
            Ok(lines) => Nominal::new(name, drawn(lines)),
            Err(found) => Err(NominalError(format!("{name}: {found}"))),
        })
    }

    /// The closed polygon through corners in order.
    ///
    /// # Errors
    ///
    /// When there is no side.
    pub(crate) fn of_polygon(name: String, corners: &[PlaceMm]) -> Result<Nominal, NominalError> {
        Nominal::new(name, vec![BezierLine::through(corners, true)])
    }

    fn new(name: String, lines: Vec<BezierLine>) -> Result<Nominal, NominalError> {
        match NominalOutline::new(&lines) {
            Some(_) => Ok(Nominal { name, lines }),
            None => Err(NominalError(format!("{name}: expected an outline, found no line"))),
        }
    }

    /// The file.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The outline; never none, for it was one when it was read.
    pub(super) fn outline(&self) -> Option<NominalOutline> {
        NominalOutline::new(&self.lines)
    }
}

fn drawn(lines: Vec<DrawnLine>) -> Vec<BezierLine> {
    let line = |DrawnLine { pieces, closed }| BezierLine { pieces, closed };
    lines.into_iter().map(line).collect()
}
