//! What points do not feel, in words: which turn, which shift.

use nalgebra::{DVector, Matrix3, Vector3};

use crate::fit::freedoms::Held;
use crate::{Nominal, Parameter, Pose};

/// A small rigid motion in the part frame: a place p moves by `shift + turn × p`.
pub(super) struct Motion {
    shift: [f64; 3],
    turn: [f64; 3],
}

/// What is held in a few words, and in a sentence why, and how much of the aperture's place rests on it.
pub(crate) fn words(
    held: &Held,
    free: &[Parameter],
    nominal: &Nominal,
    pose: &Pose,
) -> (String, String) {
    let name = free[held.left].name(nominal);
    let Some(motion) = Motion::of(held, free, pose) else {
        let text = format!(
            "{name} cannot be found from these points beside the others: held at its start"
        );
        return (name, text);
    };
    let motion = motion.without_slide(nominal);
    let what = motion.words(nominal);
    if !held.is_combined {
        let text = format!(
            "{name} cannot be found from these points: {} changes nothing. It is held at its start",
            moving(&what)
        );
        return (name, text);
    }
    let rests = match motion.lever_mm() {
        Some(mm) => {
            format!(
                "; every mrad it is off moves the aperture by {:.3} mm over the part",
                1e-3 * mm
            )
        }
        None => "; by as much as it is off, the aperture is off".to_owned(),
    };
    let text = format!("the {what} cannot be found from these points: held at its start{rests}");
    (what, text)
}

/// A motion as what somebody does: "shift along … of the part" is "moving the part along …".
fn moving(what: &str) -> String {
    let done = what.replacen("shift along", "moving the part along", 1);
    let done = done.replacen("turn about", "turning the part about", 1);
    done.replacen(" of the part", "", 1)
}

impl Motion {
    /// `None` where parameters of the shape take part.
    pub(super) fn of(held: &Held, free: &[Parameter], pose: &Pose) -> Option<Motion> {
        let axes = pose.turn_axes();
        let (mut shift, mut turn) = ([0.0; 3], [0.0; 3]);
        for (&parameter, &change) in free.iter().zip(&held.change) {
            let axis = match parameter {
                Parameter::Tx => {
                    shift[0] += change;
                    continue;
                }
                Parameter::Ty => {
                    shift[1] += change;
                    continue;
                }
                Parameter::Tz => {
                    shift[2] += change;
                    continue;
                }
                Parameter::Rx => axes[0],
                Parameter::Ry => axes[1],
                Parameter::Rz => axes[2],
                _ if change == 0.0 => continue,
                _ => return None,
            };
            turn.iter_mut().zip(axis).for_each(|(sum, entry)| *sum += change * entry);
        }
        Some(Motion { shift: pose.motion().turn_to_part(shift), turn })
    }

    /// The changes of a group of shifts or turns that make it at `pose`; `None` where the group cannot. What others than the
    /// group do is theirs.
    pub(super) fn as_changes(
        &self,
        group: &[usize],
        free: &[Parameter],
        pose: &Pose,
    ) -> Option<DVector<f64>> {
        use Parameter::{Rx, Ry, Rz, Tx, Ty, Tz};
        let turns = group.iter().all(|&index| matches!(free[index], Rx | Ry | Rz));
        let all = if turns {
            let axes = pose.turn_axes();
            if group.len() < axes.len() {
                return None;
            }
            let matrix = Matrix3::from_columns(&axes.map(Vector3::from));
            matrix.lu().solve(&Vector3::from(self.turn))?
        } else {
            Vector3::from(pose.motion().turn_to_measured(self.shift))
        };
        let entries = group.iter().map(|&index| match free[index] {
            Tx | Rx => Some(all[0]),
            Ty | Ry => Some(all[1]),
            Tz | Rz => Some(all[2]),
            _ => None,
        });
        Some(DVector::from_vec(entries.collect::<Option<Vec<f64>>>()?))
    }

    /// Without the shift along the axis of the turn, where the surface slides along it: that is another motion, not felt
    /// either.
    fn without_slide(mut self, nominal: &Nominal) -> Motion {
        if !self.is_shift() {
            let along = direction(self.turn);
            let slides = nominal.slides();
            if (0..2).any(|axis| slides[axis] && along[axis].abs() > 1.0 - NEAR) {
                let pitch = dot(along, self.shift);
                self.shift.iter_mut().zip(along).for_each(|(shift, along)| *shift -= pitch * along);
            }
        }
        self
    }

    /// How far the vertex moves across the part's axis for a turn of 1 rad; `None` without a turn.
    fn lever_mm(&self) -> Option<f64> {
        let turn = length(self.turn);
        (!self.is_shift()).then(|| self.shift[0].hypot(self.shift[1]) / turn)
    }

    fn is_shift(&self) -> bool {
        length(self.turn) * FARTHEST_MM < length(self.shift)
    }

    fn words(&self, nominal: &Nominal) -> String {
        if self.is_shift() {
            let along = direction(self.shift);
            return format!("shift along {} of the part", named(along));
        }
        let (along, size) = (direction(self.turn), length(self.turn));
        // The place of the axis next to the vertex.
        let place = cross(self.turn, self.shift).map(|entry| entry / (size * size));
        let pitch = dot(along, self.shift) / size;
        if let Some([parent, of_parent]) =
            nominal.freeform().and_then(|shape| shape.parent_axis_mm())
        {
            let off = length(cross(along, direction(of_parent)));
            let apart: [f64; 3] = std::array::from_fn(|i| place[i] - parent[i]);
            let beside = length(cross(apart, direction(of_parent)));
            let near = NEAR * (1.0 + length(parent));
            if off < NEAR && beside < near && pitch.abs() < near {
                return "turn about the parent's axis".to_owned();
            }
        }
        let screw = if pitch.abs() > NEAR * (1.0 + length(place)) {
            format!(", with a shift of {pitch:.4} mm a rad along it,")
        } else {
            String::new()
        };
        format!(
            "turn about the axis through ({}) mm along {} of the part{screw}",
            numbers(place),
            named(along)
        )
    }
}

/// A direction by the name of its axis, otherwise as a vector.
fn named(along: [f64; 3]) -> String {
    let axis = along.iter().position(|entry| entry.abs() > 1.0 - NEAR * NEAR);
    axis.map_or_else(|| format!("({})", numbers(along)), |axis| ["x", "y", "z"][axis].to_owned())
}

/// Three numbers to four digits, without the rounding about zero.
fn numbers(of: [f64; 3]) -> String {
    let largest = of.iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
    let digits = |entry: f64| {
        let entry = if entry.abs() < NEAR * largest { 0.0 } else { entry };
        format!("{entry:.3e}").parse::<f64>().unwrap_or(entry).to_string()
    };
    of.map(digits).join(", ")
}

/// The unit vector whose largest entry is positive.
fn direction(of: [f64; 3]) -> [f64; 3] {
    let largest = of.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let size = length(of) * largest.signum();
    of.map(|entry| entry / size)
}

fn length(of: [f64; 3]) -> f64 {
    dot(of, of).sqrt()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A turn about an axis farther away than this is a shift, in mm.
const FARTHEST_MM: f64 = 1e7;
/// Axes that differ by less than this share are the same.
const NEAR: f64 = 1e-4;
