//! The chord, the largest thickness and the edges of an airfoil's section.

use super::course::Course;
use super::profile::Estimate;
use super::section::{Frame, Section};
use super::tip::Tip;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// The figures of an airfoil's section.
#[derive(Clone, Debug, PartialEq)]
pub struct Airfoil {
    /// The largest distance between two places of the section.
    pub chord_mm: Estimate,
    /// These places: the leading edge, that of the larger radius, and the trailing edge.
    pub ends_mm: [PlaceMm; 2],
    /// The diameter of the largest circle within the section.
    pub thickness_mm: Estimate,
    /// Its middle.
    pub thickest_mm: PlaceMm,
    /// The radius of the circle of least squares of the leading edge, down to a twentieth of the thickness from the end of the chord. Every
    /// length of the edge counts by how much of that depth is left. None of a corner.
    pub leading_radius_mm: Option<Estimate>,
    /// The same of the trailing edge.
    pub trailing_radius_mm: Option<Estimate>,
    /// What is not known, and why.
    pub unknown: Vec<String>,
}

impl Airfoil {
    /// The figures of a closed course; what cannot be told is said in words.
    ///
    /// The ends of the chord are where it stands across the section: the vertex of a polynomial of degree 4 where the edge is round; where
    /// polynomials of degree 3 of both sides meet where it is a corner. Uncertainties are those of the polynomials by the noise of the points:
    /// chord and thickness are extremes, so where on the polynomials they are taken counts in second order only.
    ///
    /// # Errors
    ///
    /// A sentence that says what is missing.
    pub fn new(course: &Course) -> Result<Airfoil, String> {
        let places_mm = course.places_mm();
        let count = places_mm.len();
        if !course.is_closed() || count < LEAST_POINTS {
            let kind = if course.is_closed() { "a closed" } else { "an open" };
            return Err(format!(
                "airfoil: expected a closed curve of {LEAST_POINTS} points or more, found {kind} one of {count}"
            ));
        }
        let noise = course.noise().ok_or("airfoil: the noise of its points is not known")?;
        let ends = farthest(places_mm);
        let mut frame = Frame::new(places_mm[ends[0]], places_mm[ends[1]]);
        let section = Section::new(places_mm, ends, frame);
        let rough_mm = section.thickness(&noise)?.0.value;
        let tips = |section: &Section| -> Result<[Tip; 2], String> {
            Ok([Tip::new(section, 0, rough_mm, &noise)?, Tip::new(section, 1, rough_mm, &noise)?])
        };
        for _ in 0..ROUNDS {
            let section = Section::new(places_mm, ends, frame);
            let [from, to] = tips(&section)?.map(|tip| frame.back(tip.at));
            frame = Frame::new(from, to);
        }
        let section = Section::new(places_mm, ends, frame);
        let tips = tips(&section)?;
        let (thickness_mm, thickest) = section.thickness(&noise)?;
        let radii = [0, 1].map(|end| tips[end].radius(&section, end, thickness_mm.value, &noise));
        let size = |end: usize| radii[end].as_ref().map_or(0.0, |radius| radius.value);
        let leading = usize::from(size(1) > size(0));
        let mut unknown = Vec::new();
        let mut radius = |end: usize, name: &str| {
            let failed = radii[end].as_ref().err().map(|error| format!("{name} radius: {error}"));
            unknown.extend(failed);
            radii[end].as_ref().ok().copied()
        };
        Ok(Airfoil {
            chord_mm: Estimate {
                value: tips[1].at[0] - tips[0].at[0],
                u: tips[0].u_mm.hypot(tips[1].u_mm),
            },
            ends_mm: [leading, 1 - leading].map(|end| frame.back(tips[end].at)),
            thickness_mm,
            thickest_mm: frame.back(thickest),
            leading_radius_mm: radius(leading, "leading"),
            trailing_radius_mm: radius(1 - leading, "trailing"),
            unknown,
        })
    }
}

/// The two points farthest apart: of each end the farthest point from the other, from the first point on.
fn farthest(places_mm: &[PlaceMm]) -> [usize; 2] {
    let from = |other: usize| {
        let far = |index: usize| distance_mm(places_mm[index], places_mm[other]);
        (0..places_mm.len())
            .fold(0, |best, index| if far(index) > far(best) { index } else { best })
    };
    let (mut first, mut last) = (0, from(0));
    for _ in 0..MOST_SWAPS {
        let next = from(last);
        if next == first {
            break;
        }
        (first, last) = (last, next);
    }
    [first.min(last), first.max(last)]
}

/// Least points of a section.
const LEAST_POINTS: usize = 100;
/// Rounds in which the chord finds its direction.
const ROUNDS: usize = 3;
/// Most times that the farthest point is looked for.
const MOST_SWAPS: usize = 100;
