//! The rigid motion that lays a part onto a sheet, by Gauss and Newton's steps on distances along normals (Y. Chen and G. Medioni,
//! Image and Vision Computing 10 (1992) 145-155), with the outlines as well.

use asphera_geometry::vector::{cross, dot, length, minus};

use super::sheet::{Frame, Sheet, Vector};
use crate::functions::eigen;

/// A rigid motion: a place y of an entry lies at R·y + t in the scene. Both in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    pub(super) rotation: [Vector; 3],
    pub(super) shift_mm: Vector,
}

impl Motion {
    /// The motion that brings one frame onto another, turned by `turn` about its third axis.
    pub(super) fn between(entry: &Frame, part: &Frame, turn: f64) -> Motion {
        let turned = part.turned(turn).axes;
        let rotation: [Vector; 3] = std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                (0..3).map(|at: usize| turned[at][row] * entry.axes[at][column]).sum()
            })
        });
        let motion = Motion { rotation, shift_mm: [0.0; 3] };
        Motion { shift_mm: minus(part.middle_mm, motion.place(entry.middle_mm)), ..motion }
    }

    /// A place of the entry in the scene.
    pub(super) fn place(&self, y: Vector) -> Vector {
        std::array::from_fn(|row| dot(self.rotation[row], y) + self.shift_mm[row])
    }

    /// A place of the scene in the frame of the entry.
    pub(super) fn back(&self, p: Vector) -> Vector {
        let from = minus(p, self.shift_mm);
        std::array::from_fn(|column| (0..3).map(|row| self.rotation[row][column] * from[row]).sum())
    }

    /// The motion after the part has been moved by a small turn and shift in the frame of the entry.
    fn moved(&self, turn: Vector, shift: Vector, about: Vector) -> Motion {
        // The part moves by y -> Q(y - c) + c + s: so R becomes R·Qᵀ.
        let small = small_rotation(turn);
        let rotation = std::array::from_fn(|row| {
            std::array::from_fn(|column| dot(self.rotation[row], small[column]))
        });
        let fixed = self.place(about);
        let moved = Motion { rotation, shift_mm: [0.0; 3] };
        let lands = moved.place(std::array::from_fn(|at| about[at] + shift[at]));
        Motion { shift_mm: minus(fixed, lands), ..moved }
    }
}

/// The rotation about a vector by its length (O. Rodrigues).
fn small_rotation(turn: Vector) -> [Vector; 3] {
    let angle = length(turn);
    let axis = if angle > 0.0 { turn.map(|value| value / angle) } else { [0.0, 0.0, 1.0] };
    let (sin, cos) = angle.sin_cos();
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let columns: [Vector; 3] = unit.map(|side| {
        let across = cross(axis, side);
        let along = dot(axis, side) * (1.0 - cos);
        std::array::from_fn(|at| cos * side[at] + sin * across[at] + along * axis[at])
    });
    std::array::from_fn(|row| std::array::from_fn(|column: usize| columns[column][row]))
}

/// A part to be laid onto sheets: all its places for the outline, some of them for the fit.
pub(super) struct Laid<'a> {
    pub(super) some: &'a [Vector],
    pub(super) part: &'a Sheet,
    pub(super) extent: Extent,
}

/// How much of a part a sheet is to explain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    Whole,
    /// Places beyond its outline belong to something else.
    Share,
}

impl Laid<'_> {
    /// How far part and sheet differ in mm: the root mean square of distances along normals, of places beyond the outline of the
    /// sheet, and of places of the sheet that the part lacks. The worst fiftieth of the places, such as dust, does not count.
    pub(super) fn difference_mm(&self, sheet: &Sheet, motion: &Motion, count: usize) -> f64 {
        let step = self.some.len().div_ceil(count);
        let mut squares: Vec<f64> = (self.some.iter().step_by(step))
            .filter_map(|&place| {
                let near = sheet.near(motion.back(place))?;
                let beyond = (near.aside_mm - sheet.over_mm()).max(0.0);
                if beyond > 0.0 && self.extent == Extent::Share {
                    return None;
                }
                Some(near.off_mm * near.off_mm + beyond * beyond)
            })
            .collect();
        squares.sort_unstable_by(f64::total_cmp);
        squares.truncate(squares.len() - squares.len() / TRIMMED);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let lacking: Vec<f64> = (sheet.places.iter())
            .step_by(sheet.places.len().div_ceil(count))
            .filter_map(|&place| {
                let (_, distance_mm) = self.part.tree.nearest(motion.place(place), |_| true)?;
                let beyond = (distance_mm - GAP * self.part.spacing_mm).max(0.0);
                Some(beyond * beyond)
            })
            .collect();
        (mean(&squares) + mean(&lacking)).sqrt()
    }

    /// The motion improved step by step, by some `count` places. Directions that the surfaces do not fix, as the turn of a disc, stay as they are.
    pub(super) fn refined(
        &self,
        sheet: &Sheet,
        mut motion: Motion,
        steps: usize,
        count: usize,
    ) -> Motion {
        let size_mm = sheet.frame.radius_mm;
        for _ in 0..steps {
            let step = self.step(sheet, &motion, count);
            let [a, b, c, shift @ ..] = step;
            let turn = [a, b, c].map(|value| value / size_mm);
            motion = motion.moved(turn, shift, sheet.frame.middle_mm);
            if step.iter().all(|value| value.abs() < STILL * size_mm) {
                break;
            }
        }
        motion
    }

    /// A step: a turn as lengths at the radius of the sheet, and a shift, in mm.
    fn step(&self, sheet: &Sheet, motion: &Motion, count: usize) -> [f64; 6] {
        let size_mm = sheet.frame.radius_mm;
        let (mut normal, mut right) = ([[0.0; 6]; 6], [0.0; 6]);
        let mut add = |place: Vector, direction: Vector, off_mm: f64| {
            let arm = cross(minus(place, sheet.frame.middle_mm), direction);
            let [x, y, z] = arm.map(|value| value / size_mm);
            let row = [x, y, z, direction[0], direction[1], direction[2]];
            for at in 0..6 {
                right[at] -= row[at] * off_mm;
                (0..6).for_each(|other| normal[at][other] += row[at] * row[other]);
            }
        };
        for &place in self.some.iter().step_by(self.some.len().div_ceil(count)) {
            let y = motion.back(place);
            let Some(near) = sheet.near(y) else { continue };
            let beyond = near.aside_mm - sheet.over_mm();
            if beyond > 0.0 && self.extent == Extent::Share {
                continue;
            }
            add(y, near.normal, near.off_mm);
            if beyond > 0.0 {
                add(y, near.aside, beyond);
            }
        }
        for &place in sheet.places.iter().step_by(sheet.places.len().div_ceil(count)) {
            let Some((id, distance_mm)) = self.part.tree.nearest(motion.place(place), |_| true)
            else {
                continue;
            };
            let beyond = distance_mm - GAP * self.part.spacing_mm;
            if beyond > 0.0 {
                let y = motion.back(self.part.places[id as usize]);
                add(y, minus(y, place).map(|value| value / distance_mm), beyond);
            }
        }
        solved(normal, right)
    }
}

/// The solution of the normal equations among the directions that are fixed.
fn solved(normal: [[f64; 6]; 6], right: [f64; 6]) -> [f64; 6] {
    let (values, vectors) = eigen(normal);
    let mut step = [0.0; 6];
    for (value, vector) in values.iter().zip(&vectors) {
        if *value > FIXED * values[0] && *value > 0.0 {
            let along: f64 = (0..6).map(|at| vector[at] * right[at]).sum::<f64>() / value;
            (0..6).for_each(|at| step[at] += along * vector[at]);
        }
    }
    step
}

/// How a place lies to a sheet.
pub(super) struct Near {
    normal: Vector,
    /// The distance along the normal in mm, with its sign.
    off_mm: f64,
    /// The direction and the distance beside it in mm.
    aside: Vector,
    pub(super) aside_mm: f64,
}

impl Sheet {
    /// How far beside a place of the sheet one still lies over it, in mm.
    pub(super) fn over_mm(&self) -> f64 {
        let spacings = if self.is_even { BESIDE } else { GAP };
        spacings * self.spacing_mm
    }

    pub(super) fn near(&self, y: Vector) -> Option<Near> {
        let (id, _) = self.tree.nearest(y, |_| true)?;
        let normal = self.normals[id as usize];
        let from = minus(y, self.places[id as usize]);
        let off_mm = dot(from, normal);
        let aside: Vector = std::array::from_fn(|at| from[at] - off_mm * normal[at]);
        let aside_mm = length(aside);
        let aside = aside.map(|value| if aside_mm > 0.0 { value / aside_mm } else { 0.0 });
        Some(Near { normal, off_mm, aside, aside_mm })
    }
}

/// Spacings beside a place of an even sheet that still lie over it.
const BESIDE: f64 = 1.5;

/// Spacings between the places of a sheet or a part at random: of places at random one in 500 gaps at the outline is larger.
const GAP: f64 = 4.0;

/// One place in so many does not count.
const TRIMMED: usize = 50;

/// A step of this share of the size is the last.
const STILL: f64 = 1e-6;

/// Eigenvalues below this share of the largest belong to directions that nothing fixes.
const FIXED: f64 = 1e-4;
