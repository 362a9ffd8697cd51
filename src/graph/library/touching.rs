//! Parts that touch: entries of the library are laid at the ends of what lies there, and taken away one by one.

use std::f64::consts::TAU;

use asphera_geometry::vector::{dot, minus, plus};
use rayon::prelude::*;

use crate::auto::auto_tau_mm;
use crate::cloud::Cloud;
use crate::parts::{Part, parts};

use super::align::{Extent, Laid, Motion};
use super::sheet::{Frame, LEAST_PLACES, Sheet, Vector};
use super::{
    FEW_PLACES, LibraryEntry, MOST_PLACES, Outcome, Recognition, STEPS, Side, TURNS, UP, limit_mm,
    recognise, sampled,
};

/// A part of touching ones: its points in mm, and which entry it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// The points in mm.
    pub points: Vec<[f64; 3]>,
    /// Which entry it is.
    pub recognition: Recognition,
}

/// The parts that lie there as one: the whole if it is an entry or none is found in it, else the entries found in it and what
/// is left of it. Arguments as of [`recognise`].
///
/// An entry is found where it fits a share of the points with its whole surface, and the points go on beyond at most a quarter of
/// its outline. So a small flat is not found in the middle of a large one. What is left in pieces of less than a twentieth of the
/// points is dropped.
pub fn recognise_touching(
    points: &[[f64; 3]],
    library: &[LibraryEntry],
    within_mm: Option<f64>,
) -> Vec<Piece> {
    let mut waiting = vec![points.to_vec()];
    let mut pieces = Vec::new();
    while let Some(points) = waiting.pop() {
        let recognition = recognise(&points, library, within_mm);
        if recognition.outcome == Outcome::NoneFits
            && let Some((inside, outside)) = parted(&points, library, within_mm)
        {
            let recognition = recognise(&inside, library, within_mm);
            if recognition.outcome != Outcome::NoneFits {
                pieces.push(Piece { points: inside, recognition });
                waiting.extend(large_pieces(&outside, points.len() / SHARE));
                continue;
            }
        }
        pieces.push(Piece { points, recognition });
    }
    pieces
}

/// What is left where an entry was taken away: the pieces of it that are no crumbs of its outline.
fn large_pieces(points: &[Vector], least: usize) -> Vec<Vec<Vector>> {
    let Ok(cloud) = Cloud::new(points) else { return Vec::new() };
    let Some(tau_mm) = auto_tau_mm(&cloud) else { return Vec::new() };
    let Ok(found) = parts(&cloud, tau_mm, least.max(LEAST_PLACES) as u64) else {
        return Vec::new();
    };
    let places =
        |part: &Part<3>| part.places.iter().map(|&at| cloud.places()[at as usize]).collect();
    found.parts.iter().map(places).collect()
}

/// The points of the entry that fits best at an end, and the others; `None` where none fits.
fn parted(
    points: &[Vector],
    library: &[LibraryEntry],
    within_mm: Option<f64>,
) -> Option<(Vec<Vector>, Vec<Vector>)> {
    let part = Sheet::new(points, None, UP)?;
    let some = sampled(&part.places, 2 * MOST_PLACES);
    let laid = Laid { some: &some, part: &part, extent: Extent::Share };
    let sides: Vec<&Side> = library.iter().flat_map(|entry| &entry.sides).collect();
    let fits = sides.par_iter().filter_map(|side| {
        let (difference_mm, motion) = at_an_end(&laid, side)?;
        let limit_mm = within_mm.unwrap_or(limit_mm(&part, side.sheet.frame.radius_mm));
        let fits = difference_mm <= limit_mm && ends_there(&part, side, &motion);
        fits.then_some((difference_mm / limit_mm, *side, motion))
    });
    let fits: Vec<(f64, &Side, Motion)> = fits.collect();
    let (_, side, motion) = fits.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let is_inside = |point: &Vector| {
        let near = side.sheet.near(motion.back(*point));
        near.is_some_and(|near| near.aside_mm <= side.sheet.over_mm().max(part.spacing_mm))
    };
    Some(points.iter().partition(|point| is_inside(point)))
}

/// The best motion of a side to an end of the part, and the difference in mm.
fn at_an_end(laid: &Laid<'_>, side: &Side) -> Option<(f64, Motion)> {
    let (part, entry) = (&laid.part.frame, &side.sheet.frame);
    if entry.radius_mm > part.radius_mm {
        return None;
    }
    let turns = if side.is_turned_alike { 1 } else { TURNS };
    let mut starts = Vec::new();
    for end in 0..ENDS {
        let (sin, cos) = (TAU * f64::from(end) / f64::from(ENDS)).sin_cos();
        let outwards = plus([0.0; 3], cos, part.axes[0]);
        let outwards = plus(outwards, sin, part.axes[1]);
        let along = |place: &Vector| dot(minus(*place, part.middle_mm), outwards);
        let farthest = laid.some.iter().max_by(|a, b| along(a).total_cmp(&along(b))).copied()?;
        let middle_mm = plus(farthest, -entry.radius_mm, outwards);
        // The entry lies as high as the part in the middle.
        let rise =
            laid.part.height_mm(middle_mm, part)? - side.sheet.height_mm(entry.middle_mm, entry)?;
        let frame = Frame { middle_mm: plus(middle_mm, rise, part.axes[2]), ..*part };
        for turn in 0..turns {
            let turn = TAU * turn as f64 / turns as f64;
            let motion = Motion::between(entry, &frame, turn);
            let motion = laid.refined(&side.sheet, motion, FIRST_STEPS, 2 * FEW_PLACES);
            starts.push((laid.difference_mm(&side.sheet, &motion, FEW_PLACES), motion));
        }
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refined = starts.iter().take(2).map(|(_, motion)| {
        let motion = laid.refined(&side.sheet, *motion, STEPS, 2 * MOST_PLACES);
        (laid.difference_mm(&side.sheet, &motion, MOST_PLACES), motion)
    });
    refined.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Whether the points end at the outline of an entry: they go on beyond it in few directions.
fn ends_there(part: &Sheet, side: &Side, motion: &Motion) -> bool {
    let frame = &side.sheet.frame;
    let [from_mm, to_mm] = BEYOND.map(|spacings| side.sheet.over_mm() + spacings * part.spacing_mm);
    let mut occupied = [false; DIRECTIONS];
    for &place in &part.places {
        let y = motion.back(place);
        let from = minus(y, frame.middle_mm);
        if side.sheet.near(y).is_some_and(|near| near.aside_mm > from_mm && near.aside_mm < to_mm) {
            let angle = dot(from, frame.axes[1]).atan2(dot(from, frame.axes[0]));
            let at = ((angle / TAU + 0.5) * DIRECTIONS as f64) as usize;
            occupied[at.min(DIRECTIONS - 1)] = true;
        }
    }
    4 * occupied.iter().filter(|&&is| is).count() <= DIRECTIONS
}

/// Ends of a part at which entries are laid.
const ENDS: u8 = 8;

/// Steps of the first fit.
const FIRST_STEPS: usize = 6;

/// Directions from the middle of an entry in which points may go on.
const DIRECTIONS: usize = 48;

/// Spacings beyond the outline between which points go on; nearer ones may belong to the entry, whose outline is not known better.
const BEYOND: [f64; 2] = [2.0, 6.0];

/// Points over those of the smallest piece.
const SHARE: usize = 20;
