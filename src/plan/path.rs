//! Paths over an aperture, laid as pieces.

use std::f64::consts::TAU;

use crate::error::positive;
use crate::{Aperture, Piece, PlanError};

/// A path over an aperture.
#[derive(Clone, Debug, PartialEq)]
pub enum Path {
    /// Lines along x, one line there and the next one back, or all in one direction.
    Raster {
        /// Largest distance of lines in mm.
        pitch_mm: f64,
        /// Whether all lines run towards +x.
        one_way: bool,
    },
    /// A spiral of Archimedes between a turn at the outer edge and, of a ring, one at the inner edge.
    Spiral {
        /// Largest distance of turns in mm.
        pitch_mm: f64,
        /// Which way it goes.
        way: Way,
    },
    /// Circles about the centre.
    Rings {
        /// Largest distance of circles in mm.
        pitch_mm: f64,
        /// Which way they follow each other.
        way: Way,
    },
    /// Lines between the centre, or the inner edge, and the outer edge: one out and the next one in.
    Meridians {
        /// Largest distance of lines in mm, at the farthest place of the aperture.
        pitch_mm: f64,
    },
    /// Listed places (x, y) in mm, in this order.
    Points(Vec<[f64; 2]>),
}

/// Direction of a path about a centre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Way {
    /// From the centre to the edge.
    #[default]
    Out,
    /// From the edge to the centre.
    In,
}

/// Lays a path over an aperture about a centre, (x, y) in mm.
///
/// Lines, turns and circles have even distances, as large as the pitch or a little less. A raster has lines on both edges of a
/// rectangle, and half a distance inside the edges of a disc; along round edges gaps are up to a quarter larger. A spiral over a rectangle runs over the disc about it.
///
/// # Errors
///
/// When a size is no positive number, a place is not finite, or there are more pieces than a plan may have.
pub fn lay(path: &Path, aperture: &Aperture, centre_mm: [f64; 2]) -> Result<Vec<Piece>, PlanError> {
    aperture.validate()?;
    if !centre_mm.iter().all(|mm| mm.is_finite()) {
        let found = format!("{centre_mm:?} mm");
        return Err(PlanError::new("centre", "two numbers", found, "give the centre in mm"));
    }
    let pitch = |mm: f64| {
        let mm = positive("spacing", mm, "give the distance of lines in mm")?;
        let count = aperture.reach_mm() / mm * TAU;
        if count <= MOST_PIECES {
            return Ok(mm);
        }
        Err(PlanError::new(
            "spacing",
            format!("at most {MOST_PIECES} lines"),
            format!("{count:.0} with {mm} mm"),
            "give a larger spacing",
        ))
    };
    Ok(match path {
        Path::Raster { pitch_mm, one_way } => {
            raster(aperture, centre_mm, pitch(*pitch_mm)?, *one_way)
        }
        Path::Spiral { pitch_mm, way } => spiral(aperture, centre_mm, pitch(*pitch_mm)?, *way),
        Path::Rings { pitch_mm, way } => rings(aperture, centre_mm, pitch(*pitch_mm)?, *way),
        Path::Meridians { pitch_mm } => meridians(aperture, centre_mm, pitch(*pitch_mm)?),
        Path::Points(places) => listed(places)?,
    })
}

fn raster(aperture: &Aperture, [x0, y0]: [f64; 2], pitch_mm: f64, one_way: bool) -> Vec<Piece> {
    let half_mm = aperture.half_height_mm();
    let count = steps(2.0 * half_mm, pitch_mm);
    let step_mm = 2.0 * half_mm / count as f64;
    let heights: Vec<f64> = match aperture {
        Aperture::Rectangle { .. } => (0..=count).map(|k| k as f64 * step_mm - half_mm).collect(),
        _ => (0..count).map(|k| (k as f64 + 0.5) * step_mm - half_mm).collect(),
    };
    let mut pieces = Vec::new();
    for (index, y) in heights.into_iter().enumerate() {
        let mut chords = aperture.chords(y);
        let back = index % 2 == 1 && !one_way;
        if back {
            chords.reverse();
        }
        for [left, right] in chords {
            let [from, to] = if back { [right, left] } else { [left, right] };
            pieces.push(Piece::Line { from_mm: [x0 + from, y0 + y], to_mm: [x0 + to, y0 + y] });
        }
    }
    pieces
}

fn spiral(aperture: &Aperture, centre_mm: [f64; 2], pitch_mm: f64, way: Way) -> Vec<Piece> {
    let [inner_mm, outer_mm] = [aperture.inner_mm(), aperture.reach_mm()];
    let turns = steps(outer_mm - inner_mm, pitch_mm) as f64;
    let turn = |radius_mm: f64| Piece::Arc { centre_mm, radius_mm, from_rad: 0.0, to_rad: TAU };
    let [from, to] = match way {
        Way::Out => [inner_mm, outer_mm],
        Way::In => [outer_mm, inner_mm],
    };
    let spiral = Piece::Spiral {
        centre_mm,
        from_radius_mm: from,
        to_radius_mm: to,
        from_rad: 0.0,
        to_rad: turns * TAU,
    };
    let ring = |radius_mm: f64| (radius_mm > 0.0).then(|| turn(radius_mm));
    ring(from).into_iter().chain([spiral]).chain(ring(to)).collect()
}

fn rings(aperture: &Aperture, centre_mm: [f64; 2], pitch_mm: f64, way: Way) -> Vec<Piece> {
    let [inner_mm, outer_mm] = [aperture.inner_mm(), aperture.reach_mm()];
    let count = steps(outer_mm - inner_mm, pitch_mm);
    let step_mm = (outer_mm - inner_mm) / count as f64;
    let mut radii: Vec<f64> = (0..=count).map(|k| inner_mm + k as f64 * step_mm).collect();
    if way == Way::In {
        radii.reverse();
    }
    let mut pieces = Vec::new();
    for radius_mm in radii {
        if radius_mm <= 0.0 {
            pieces.push(Piece::Stop { at_mm: centre_mm });
            continue;
        }
        pieces.extend(aperture.arcs(radius_mm).into_iter().map(|[from_rad, to_rad]| Piece::Arc {
            centre_mm,
            radius_mm,
            from_rad,
            to_rad,
        }));
    }
    pieces
}

fn meridians(aperture: &Aperture, [x0, y0]: [f64; 2], pitch_mm: f64) -> Vec<Piece> {
    let count = steps(TAU * aperture.reach_mm(), pitch_mm).max(2);
    let place = |radius_mm: f64, angle: f64| {
        let (sin, cos) = angle.sin_cos();
        [x0 + radius_mm * cos, y0 + radius_mm * sin]
    };
    let line = |k: usize| {
        let angle = TAU * k as f64 / count as f64;
        let [inner, outer] = [aperture.inner_mm(), aperture.ray_mm(angle)];
        let [from, to] = if k.is_multiple_of(2) { [inner, outer] } else { [outer, inner] };
        Piece::Line { from_mm: place(from, angle), to_mm: place(to, angle) }
    };
    (0..count).map(line).collect()
}

fn listed(places: &[[f64; 2]]) -> Result<Vec<Piece>, PlanError> {
    let bad = places.iter().position(|place| !place.iter().all(|mm| mm.is_finite()));
    match bad {
        Some(index) => Err(PlanError::new(
            "points",
            "two numbers in mm",
            format!("{:?} as place {}", places[index], index + 1),
            "leave the place out",
        )),
        None => Ok(places.iter().map(|&at_mm| Piece::Stop { at_mm }).collect()),
    }
}

/// How many steps of at most `pitch_mm` make a length; rounding makes no step more.
fn steps(length_mm: f64, pitch_mm: f64) -> usize {
    ((length_mm / pitch_mm - 1e-9).ceil() as usize).max(1)
}

/// Most lines or turns of a plan.
const MOST_PIECES: f64 = 1e6;
