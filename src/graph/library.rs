//! A library of surfaces, and which of them a part of a scene is.
//!
//! Sizes and outlines propose entries, and how a part could lie. A rigid fit of the entry to the part decides: how far the two
//! surfaces differ, with the outline of either. An entry that is known from all sides is laid on each of its sides; one that is
//! known from one side is laid with that side up, and down. The scene is seen from above, along −z.

mod align;
mod any_size;
mod sheet;
mod touching;

use std::f64::consts::TAU;

use asphera_geometry::vector::dot;
use rayon::prelude::*;
use thiserror::Error;

use self::align::{Extent, Laid, Motion};
use self::sheet::{LEAST_PLACES, Sheet, Vector};
use crate::cloud::Cloud;
use crate::functions::principal_axes;

pub use any_size::recognise_any_size;
pub use touching::{Piece, recognise_touching};

/// A surface of a library, as it may lie on a table.
#[derive(Clone, Debug)]
pub struct LibraryEntry {
    name: String,
    sides: Vec<Side>,
}

/// A surface as seen from above when it lies on one of its sides.
#[derive(Clone, Debug)]
struct Side {
    sheet: Sheet,
    /// The surface is known from one side, and this is the other.
    is_behind: bool,
    /// It looks alike after any turn about the vertical.
    is_turned_alike: bool,
}

impl Side {
    fn new(sheet: Sheet, is_behind: bool) -> Side {
        let turned = sheet.frame.turned(SOME_TURN);
        let motion = Motion::between(&sheet.frame, &turned, 0.0);
        let some = sampled(&sheet.places, FEW_PLACES);
        let laid = Laid { some: &some, part: &sheet, extent: Extent::Whole };
        let difference_mm = laid.difference_mm(&sheet, &motion, FEW_PLACES);
        let is_turned_alike = difference_mm < limit_mm(&sheet, sheet.frame.radius_mm);
        Side { sheet, is_behind, is_turned_alike }
    }

    /// The side of a surface that is larger by a factor.
    fn scaled(&self, factor: f64) -> Side {
        Side { sheet: self.sheet.scaled(factor), ..*self }
    }
}

/// Reason why a surface cannot be recognised.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EntryError {
    /// Too few places, or all on a line.
    #[error(
        "{found} points: expected {LEAST_PLACES} different ones at least that do not lie on a line, in mm; check the file"
    )]
    TooFew {
        /// Points given.
        found: usize,
    },
}

impl LibraryEntry {
    /// A surface known from one side: points of it in mm, its z axis on the side it is seen from. It may also lie turned over.
    ///
    /// # Errors
    ///
    /// Fewer than twelve places, or places on a line.
    pub fn face(name: &str, points: &[[f64; 3]]) -> Result<LibraryEntry, EntryError> {
        let side = |up: f64| {
            let sheet = Sheet::new(points, None, [0.0, 0.0, up])?;
            Some(Side::new(sheet, up < 0.0))
        };
        let sides: Option<Vec<Side>> = [1.0, -1.0].into_iter().map(side).collect();
        let sides = sides.ok_or(EntryError::TooFew { found: points.len() })?;
        Ok(LibraryEntry { name: name.to_owned(), sides })
    }

    /// A body known from all sides: points of its surface in mm and their unit normals, which point outwards. It may lie on six
    /// sides: those across its principal axes.
    ///
    /// # Errors
    ///
    /// Fewer than twelve places, or places on a line.
    ///
    /// # Panics
    ///
    /// If there are not as many normals as points.
    pub fn body(
        name: &str,
        points: &[[f64; 3]],
        normals: &[[f64; 3]],
    ) -> Result<LibraryEntry, EntryError> {
        assert_eq!(points.len(), normals.len(), "a normal a point");
        let failed = || EntryError::TooFew { found: points.len() };
        let cloud = Cloud::new(points).map_err(|_| failed())?;
        let axes = principal_axes(&cloud).map_err(|_| failed())?.axes;
        let ups = axes.into_iter().flat_map(|axis| [axis, axis.map(|value| -value)]);
        let visible = |up: Vector| {
            let seen = |normal: &Vector| dot(*normal, up) > GRAZING;
            let rows = points.iter().zip(normals).filter(|(_, normal)| seen(normal));
            let (points, normals): (Vec<Vector>, Vec<Vector>) = rows.unzip();
            let sheet = Sheet::new(&points, Some(&normals), up)?;
            Some(Side::new(sheet, false))
        };
        let sides: Vec<Side> = ups.filter_map(visible).collect();
        if sides.is_empty() {
            return Err(failed());
        }
        Ok(LibraryEntry { name: name.to_owned(), sides })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// How an entry lies in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoarsePose {
    /// The rotation R of p = R·y + t, from a place y of the entry to its place p in the scene; rows.
    pub rotation: [[f64; 3]; 3],
    /// The shift t in mm: where the origin of the entry lies.
    pub shift_mm: [f64; 3],
}

impl CoarsePose {
    /// A place of the entry in the scene, both in mm.
    pub fn to_scene(&self, place_mm: [f64; 3]) -> [f64; 3] {
        Motion { rotation: self.rotation, shift_mm: self.shift_mm }.place(place_mm)
    }

    /// A place of the scene in the frame of the entry, both in mm.
    pub fn to_entry(&self, place_mm: [f64; 3]) -> [f64; 3] {
        Motion { rotation: self.rotation, shift_mm: self.shift_mm }.back(place_mm)
    }

    /// Where the z axis of the entry points: up, down, or to a side.
    pub fn facing(&self) -> Facing {
        match self.rotation[2][2] {
            slant if slant > SIDEWAYS => Facing::Up,
            slant if slant < -SIDEWAYS => Facing::Down,
            _ => Facing::Side,
        }
    }

    /// The turn about the z axis of the scene from its x axis to that of the entry as seen from above, in rad: −π to π.
    pub fn turn_rad(&self) -> f64 {
        self.rotation[1][0].atan2(self.rotation[0][0])
    }

    /// The angle between the z axes of entry and scene, whatever their sense, in rad: 0 to π/2.
    pub fn tilt_rad(&self) -> f64 {
        let [x, y, z] = self.rotation.map(|row| row[2]);
        x.hypot(y).atan2(z.abs())
    }
}

/// Where the z axis of an entry points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// Within 60° of the z axis of the scene.
    Up,
    /// Within 60° of its opposite.
    Down,
    /// Neither.
    Side,
}

/// An entry laid onto a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The number of the entry.
    pub entry: usize,
    /// How far entry and part differ in mm: the root mean square over both surfaces and outlines.
    pub difference_mm: f64,
    /// How the entry lies.
    pub pose: CoarsePose,
    /// No other side of the entry fits as well. Of a ring that is alike on both sides two fit.
    pub is_side_known: bool,
    /// It does not look alike after any turn about the vertical, as a disc does.
    pub is_turn_known: bool,
    /// Size of the part over that of the entry: 1 where sizes count. A place y of the entry lies at R·(scale·y) + t.
    pub scale: f64,
    /// A surface known from one side shows its other side.
    is_behind: bool,
}

/// Answer to which entry a part is.
#[derive(Clone, Debug, PartialEq)]
pub struct Recognition {
    /// The entries whose size fits, the nearest first.
    pub candidates: Vec<Candidate>,
    /// The largest difference that still fits in mm.
    pub limit_mm: f64,
    /// The verdict on the first candidate.
    pub outcome: Outcome,
}

/// Whether the nearest entry is the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It fits, and clearly better than any other.
    Match,
    /// No entry fits.
    NoneFits,
    /// Two entries fit equally.
    Ambiguous,
    /// The part has fewer than twelve places, or all lie on a line.
    TooSmall,
}

impl Recognition {
    /// How much nearer the first candidate is than the second, as a share of the second's difference: 0 of equal ones, 1 without
    /// a second.
    pub fn margin(&self) -> f64 {
        match &self.candidates[..] {
            [first, second, ..] if second.difference_mm > 0.0 => {
                1.0 - first.difference_mm / second.difference_mm
            }
            [_, _, ..] => 0.0,
            _ => 1.0,
        }
    }

    /// How well the first candidate fits: 1 without any difference, 0 at the limit and beyond.
    pub fn score(&self) -> f64 {
        let share = |first: &Candidate| 1.0 - first.difference_mm / self.limit_mm;
        self.candidates.first().map_or(0.0, |first| share(first).max(0.0))
    }
}

/// Which entry a part is. `points` are those of the part in mm, of the scene as seen from above along −z; `within_mm` is the
/// largest difference that still fits. Without it that is three times the noise of the points and 1/2000 of the part's diameter.
///
/// An entry that shows its back counts only where no other one fits that shows its face. Some n·log n of the points, and some ms
/// for every entry of about their size. Neither the order of the points nor that of the entries changes an answer, but that
/// candidates name entries by number.
pub fn recognise(
    points: &[[f64; 3]],
    library: &[LibraryEntry],
    within_mm: Option<f64>,
) -> Recognition {
    recognised(points, library, within_mm, &fitted)
}

/// An entry laid onto a part: how far they differ in mm, and how it lies, scaled first.
#[derive(Clone, Copy, Debug)]
struct Fit {
    difference_mm: f64,
    motion: Motion,
    scale: f64,
}

/// The answer by a fit of each side.
fn recognised(
    points: &[[f64; 3]],
    library: &[LibraryEntry],
    within_mm: Option<f64>,
    fit: &(dyn Fn(&Laid<'_>, &Side) -> Option<Fit> + Sync),
) -> Recognition {
    let Some(part) = Sheet::new(points, None, UP) else {
        let outcome = Outcome::TooSmall;
        return Recognition { candidates: Vec::new(), limit_mm: within_mm.unwrap_or(0.0), outcome };
    };
    let limit_mm = within_mm.unwrap_or(limit_mm(&part, part.frame.radius_mm));
    let some = sampled(&part.places, MOST_PLACES);
    let laid = Laid { some: &some, part: &part, extent: Extent::Whole };
    let nearest = |(entry, of): (usize, &LibraryEntry)| {
        let sides = of.sides.iter().filter_map(|side| {
            let Fit { difference_mm, motion, scale } = fit(&laid, side)?;
            let Motion { rotation, shift_mm } = motion;
            let pose = CoarsePose { rotation, shift_mm };
            Some(Candidate {
                entry,
                difference_mm,
                pose,
                is_side_known: true,
                is_turn_known: !side.is_turned_alike,
                scale,
                is_behind: side.is_behind,
            })
        });
        best_side(sides.collect())
    };
    let candidates = library.par_iter().enumerate().filter_map(nearest);
    let mut candidates: Vec<Candidate> = candidates.collect();
    candidates
        .sort_by(|a, b| a.difference_mm.total_cmp(&b.difference_mm).then(a.entry.cmp(&b.entry)));
    prefer_faces(&mut candidates, limit_mm);
    let mut found = Recognition { candidates, limit_mm, outcome: Outcome::Match };
    if found.candidates.first().is_none_or(|first| first.difference_mm > limit_mm) {
        found.outcome = Outcome::NoneFits;
    } else if found.margin() < CLEAR {
        found.outcome = Outcome::Ambiguous;
    }
    found
}

/// The largest difference in mm that fits a part, by its noise and the radius of its outline.
fn limit_mm(part: &Sheet, radius_mm: f64) -> f64 {
    NOISES * part.noise_mm + OF_DIAMETER * 2.0 * radius_mm
}

/// Some places spread over all of them.
fn sampled(places: &[Vector], count: usize) -> Vec<Vector> {
    places.iter().copied().step_by(places.len().div_ceil(count).max(1)).collect()
}

/// Drops backs where a face fits as well: of an opaque part the back of the other is not what is seen.
fn prefer_faces(candidates: &mut Vec<Candidate>, limit_mm: f64) {
    let Some(best) = candidates.first().map(|first| first.difference_mm) else { return };
    let equal_mm = (best / (1.0 - CLEAR)).min(limit_mm);
    if candidates.iter().any(|one| !one.is_behind && one.difference_mm <= equal_mm) {
        candidates.retain(|one| !one.is_behind || one.difference_mm > equal_mm);
    }
}

/// The side that fits best; of a surface known from one side its face, if that fits as well as its back.
fn best_side(mut sides: Vec<Candidate>) -> Option<Candidate> {
    sides.sort_by(|a, b| a.difference_mm.total_cmp(&b.difference_mm));
    let equal_mm = sides.first()?.difference_mm / (1.0 - CLEAR);
    let equal = || sides.iter().filter(|side| side.difference_mm <= equal_mm);
    let facings = || equal().filter(|side| !side.is_behind).map(|side| side.pose.facing());
    let is_side_known = facings().all(|facing| Some(facing) == facings().next());
    let best = equal().find(|side| !side.is_behind).or(equal().next())?;
    Some(Candidate { is_side_known, ..best.clone() })
}

/// The best motion of a side onto a part; `None` where their sizes differ.
fn fitted(laid: &Laid<'_>, side: &Side) -> Option<Fit> {
    let (part, entry) = (&laid.part.frame, &side.sheet.frame);
    let ratio = part.radius_mm / entry.radius_mm;
    if !(1.0 / LARGER..=LARGER).contains(&ratio) {
        return None;
    }
    let has_longest = !part.is_round && !entry.is_round;
    let turns = if side.is_turned_alike {
        1
    } else if has_longest {
        2
    } else {
        TURNS
    };
    let mut starts: Vec<(f64, Motion)> = (0..turns)
        .map(|turn| {
            let motion = Motion::between(entry, part, TAU * turn as f64 / turns as f64);
            (laid.difference_mm(&side.sheet, &motion, FEW_PLACES), motion)
        })
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refined = starts.iter().take(2).map(|(_, motion)| {
        let motion = laid.refined(&side.sheet, *motion, STEPS, MOST_PLACES);
        let difference_mm = laid.difference_mm(&side.sheet, &motion, MOST_PLACES);
        Fit { difference_mm, motion, scale: 1.0 }
    });
    refined.min_by(|a, b| a.difference_mm.total_cmp(&b.difference_mm))
}

/// The scene is seen from there.
const UP: Vector = [0.0, 0.0, 1.0];

/// Cosine of the angle between a normal and the direction to the eye above which a place is seen.
const GRAZING: f64 = 0.1;

/// Cosine of the slant from which on an entry lies on its side.
const SIDEWAYS: f64 = 0.5;

/// Margins below this are none.
const CLEAR: f64 = 0.1;

/// Parts and entries whose radii differ by more than this factor are not compared.
const LARGER: f64 = 1.15;

/// Turns about the vertical that are tried where the outline has no longest side.
const TURNS: usize = 12;

/// A turn by which a surface is compared with itself, in rad: no part of a full turn.
const SOME_TURN: f64 = 1.0;

/// Places by which a start is judged, and a fit.
const FEW_PLACES: usize = 150;
const MOST_PLACES: usize = 800;

/// Steps of a fit at most.
const STEPS: usize = 15;

/// Noises of the points, and the share of the diameter, that a coarse fit may differ by.
const NOISES: f64 = 3.0;
const OF_DIAMETER: f64 = 1.0 / 2000.0;
