//! Hints: places within regions, with the labels of these.

use std::cmp::Ordering;

use asphera_geometry::RANGE_MM;
use asphera_geometry::predicates::orientation;
use thiserror::Error;

use crate::triangulation::TriangleId;
use crate::{PlaceMm, Triangulation};

/// A place within a region, and the label of that.
#[derive(Clone, Debug, PartialEq)]
pub struct Hint {
    /// The place, mm.
    pub at_mm: PlaceMm,
    /// The label.
    pub label: String,
}

/// Reason why hints cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum HintError {
    /// Words that are no hint.
    #[error(
        "hint {number}: expected x,y=label with x and y in mm, found `{found}`; write hints as 1.5,2=hole;8,2=plate"
    )]
    NotAHint {
        /// Its number, counted from 1.
        number: usize,
        /// The words.
        found: String,
    },
    /// There is none.
    #[error("expected hints, found none; name a place within each region, as 1.5,2=hole;8,2=plate")]
    None,
    /// A hint on a point or on the side between two triangles.
    #[error("hint {number} at {}, {} mm lies on a line between points: expected a place within a region; move it", .at_mm[0], .at_mm[1])]
    OnLine {
        /// Its number, counted from 1.
        number: usize,
        /// The place, mm.
        at_mm: PlaceMm,
    },
    /// Two labels for one triangle.
    #[error(
        "hint {number} names `{found}` where another names `{expected}`, and no point lies between: expected one label there; move one of them, or \
         give both one label"
    )]
    TwoLabels {
        /// Its number, counted from 1.
        number: usize,
        /// Its label.
        found: String,
        /// The other's.
        expected: String,
    },
}

/// Hints as `x,y=label;x,y=label`, lengths in mm.
///
/// # Errors
///
/// The first that is none.
pub fn hints_of(text: &str) -> Result<Vec<Hint>, HintError> {
    let words = text.split(';').map(str::trim).filter(|word| !word.is_empty());
    words
        .zip(1..)
        .map(|(word, number)| {
            hint_of(word).ok_or_else(|| HintError::NotAHint { number, found: word.to_owned() })
        })
        .collect()
}

fn hint_of(word: &str) -> Option<Hint> {
    let (place, label) = word.split_once('=')?;
    let (x, y) = place.split_once(',')?;
    let coordinate = |word: &str| {
        let value: f64 = word.trim().parse().ok()?;
        (value.abs() <= RANGE_MM).then_some(value)
    };
    let at_mm = [coordinate(x)?, coordinate(y)?];
    let label = label.trim();
    (!label.is_empty()).then(|| Hint { at_mm, label: label.to_owned() })
}

/// Where a place lies.
pub(super) enum Found {
    Within(TriangleId),
    /// Beyond the hull.
    Beyond,
    OnLine,
}

/// The triangle that a place lies in, decided exactly; time linear in the triangles.
pub(super) fn find(triangulation: &Triangulation, at_mm: PlaceMm) -> Found {
    for (corners, number) in triangulation.triangles().iter().zip(0..) {
        let [a, b, c] = corners.map(|corner| triangulation.place(corner));
        let turns = [(a, b), (b, c), (c, a)].map(|(p, q)| orientation(p, q, at_mm));
        if !turns.contains(&Ordering::Less) {
            return match turns.contains(&Ordering::Equal) {
                true => Found::OnLine,
                false => Found::Within(number),
            };
        }
    }
    Found::Beyond
}
