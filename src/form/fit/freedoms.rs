//! Directions in which a fit may move its parameters.
//!
//! Where points do not feel one combination of the shifts, or of the turns, of a freeform, that combination stays at its
//! start and the others of the group move. No single parameter is held in its place: an off-axis piece does not feel the
//! turn about its parent's axis. With `ry` held for it, a little tilt the part really has would come out as a large turn
//! about that axis, and the aperture would slide over the part.
//!
//! Within a group a length is a length and an angle an angle, so that "at its start" has a meaning: no step has a part along
//! the combination. What the combination is, is asked at the pose the whole fit starts from: so a fit in several stages, over
//! other points, ends at the same place. Between groups the order of `priority` decides: shifts follow, turns are held. So the piece above is
//! found where it lies, if it was not turned about the axis; a sphere is found by its centre and a cylinder by its axis.

use nalgebra::{DMatrix, DVector};

use crate::fit::motion::Motion;
use crate::fit::solve::System;
use crate::{Parameter, Pose};

/// The directions of some parameters that points determine.
#[derive(Clone, Debug, PartialEq)]
pub struct Freedoms {
    /// Indices of the parameters that some direction changes, ascending.
    moving: Vec<usize>,
    /// One row a moving parameter, one column a direction; `None` where each parameter is a direction of its own.
    directions: Option<DMatrix<f64>>,
}

/// Parameters that a fit may change, and those it holds.
pub(crate) struct Chosen {
    pub(crate) freedoms: Freedoms,
    pub(crate) held: Vec<Held>,
}

/// Something the points do not feel, which stays at its start.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    /// Index of the parameter that leads it.
    pub(crate) leading: usize,
    /// Index of the parameter whose column was left out, and those it was held against.
    pub(crate) left: usize,
    pub(crate) against: Vec<usize>,
    /// A change of all free parameters that moves the surface at the points least.
    pub(crate) change: Vec<f64>,
    /// Group it belongs to, and its number there.
    pub(crate) group: usize,
    pub(crate) number: usize,
    /// Whether others of the group have a part in it.
    pub(crate) is_combined: bool,
}

impl Freedoms {
    /// Each of so many parameters by itself.
    pub fn each(count: usize) -> Freedoms {
        Freedoms { moving: (0..count).collect(), directions: None }
    }

    /// Number of directions.
    pub fn count(&self) -> usize {
        self.directions.as_ref().map_or(self.moving.len(), DMatrix::ncols)
    }

    /// Whether some directions are combinations of parameters.
    pub fn is_combined(&self) -> bool {
        self.directions.is_some()
    }

    /// One row a moving parameter, one column a direction; `None` where each parameter is a direction of its own.
    pub fn directions(&self) -> Option<&DMatrix<f64>> {
        self.directions.as_ref()
    }

    /// Indices of the parameters that some direction changes, ascending.
    pub(crate) fn moving(&self) -> &[usize] {
        &self.moving
    }

    /// With one more parameter after the others, if that is asked for.
    pub(crate) fn with_offset(&self, offset: bool) -> Freedoms {
        if !offset {
            return self.clone();
        }
        let mut moving = self.moving.clone();
        moving.push(moving.len());
        let directions = self.directions.as_ref().map(|own| {
            let (rows, columns) = own.shape();
            let mut wide = own.clone().resize(rows + 1, columns + 1, 0.0);
            wide[(rows, columns)] = 1.0;
            wide
        });
        Freedoms { moving, directions }
    }

    /// Count of the moving parameters alone.
    pub(crate) fn of_moving(&self) -> Freedoms {
        Freedoms { moving: (0..self.moving.len()).collect(), directions: self.directions.clone() }
    }
}

impl Chosen {
    /// What the rows of a system at `pose` determine of the `free` parameters, admitted by the groups of `priority`. What
    /// they do not is held where `start` has it.
    pub(crate) fn new(
        system: &System,
        free: &[Parameter],
        priority: &[Vec<usize>],
        [pose, start]: [&Pose; 2],
        tolerance: f64,
    ) -> Chosen {
        let kept = system.determinate(priority, tolerance);
        let (mut held, mut earlier) = (Vec::new(), Vec::new());
        // For each group with combinations, its members and the directions left to them.
        let mut turned: Vec<(&[usize], DMatrix<f64>)> = Vec::new();
        for (number, group) in priority.iter().enumerate() {
            let (own, left): (Vec<usize>, Vec<usize>) =
                group.iter().partition(|index| kept.contains(index));
            let against: Vec<usize> = earlier.iter().chain(&own).copied().collect();
            let mut unfelt: Vec<Held> = left
                .iter()
                .enumerate()
                .map(|(at, &left)| {
                    let change = system.least_felt(&against, left, free.len());
                    let against = against.clone();
                    Held {
                        leading: left,
                        left,
                        against,
                        change,
                        group: number,
                        number: at,
                        is_combined: false,
                    }
                })
                .collect();
            let (held_along, metric) = along(group, &unfelt, free, [pose, start]);
            let covectors: Vec<DVector<f64>> = held_along.iter().map(|one| &metric * one).collect();
            let combines = unfelt.iter().zip(&covectors).any(|(held, covector)| {
                let at = group.iter().position(|&index| index == held.left);
                let size = at.map_or(0.0, |at| covector[at].abs());
                let others =
                    group.iter().zip(covector.iter()).filter(|(index, _)| own.contains(index));
                others.into_iter().any(|(_, share)| share.abs() > SHARE * size)
            });
            if combines {
                let mut taken = Vec::new();
                for held in &mut unfelt {
                    held.lead(group, &taken);
                    taken.push(held.leading);
                }
                turned.push((group, left_to(held_along, &metric)));
            }
            held.extend(unfelt);
            earlier.extend(own);
        }
        held.sort_by_key(|held| held.leading);
        Chosen { freedoms: joined(kept, &turned), held }
    }
}

impl Held {
    /// Names it by the member it changes most, of those that name no other.
    fn lead(&mut self, group: &[usize], taken: &[usize]) {
        let most = group
            .iter()
            .copied()
            .filter(|index| !taken.contains(index))
            .reduce(|a, b| if self.change[b].abs() > self.change[a].abs() { b } else { a });
        self.leading = most.unwrap_or(self.left);
        self.is_combined = true;
    }
}

/// What a group does not feel, as changes of its parameters, and the product of such changes: at `start`, where the group has
/// all that is needed to say it there, else at `pose`.
fn along(
    group: &[usize],
    unfelt: &[Held],
    free: &[Parameter],
    [pose, start]: [&Pose; 2],
) -> (Vec<DVector<f64>>, DMatrix<f64>) {
    let metric_at = |pose: &Pose| {
        DMatrix::from_fn(group.len(), group.len(), |i, j| {
            product(free[group[i]], free[group[j]], pose)
        })
    };
    let here =
        |held: &Held| DVector::from_iterator(group.len(), group.iter().map(|&i| held.change[i]));
    let now: Vec<DVector<f64>> = unfelt.iter().map(here).collect();
    let metric = metric_at(start);
    let moved =
        unfelt.iter().map(|held| Motion::of(held, free, pose)?.as_changes(group, free, start));
    let at_start: Option<Vec<DVector<f64>>> = moved.collect();
    // Of a part that was turned far, what is held there says nothing of what is not felt here.
    let tells = |one: &DVector<f64>, now: &DVector<f64>| {
        let covector = &metric * one;
        covector.dot(now).abs() > TELLS * covector.norm() * now.norm()
    };
    match at_start {
        Some(at_start) if at_start.iter().zip(&now).all(|(one, now)| tells(one, now)) => {
            (at_start, metric)
        }
        _ => (now, metric_at(pose)),
    }
}

/// Directions across all that is held, orthogonal in the metric (Gram and Schmidt, twice).
fn left_to(own: Vec<DVector<f64>>, metric: &DMatrix<f64>) -> DMatrix<f64> {
    let (size, held) = (metric.nrows(), own.len());
    let mut found: Vec<DVector<f64>> = Vec::new();
    let units = (0..size).map(|i| DVector::from_fn(size, |j, _| f64::from(i == j)));
    let mut units: Vec<DVector<f64>> = units.collect();
    let length = |vector: &DVector<f64>| vector.dot(&(metric * vector)).max(0.0).sqrt();
    let across = |vector: &mut DVector<f64>, found: &[DVector<f64>]| {
        for _ in 0..2 {
            for other in found {
                let along = vector.dot(&(metric * other));
                *vector -= other * along;
            }
        }
    };
    for mut vector in own {
        vector /= length(&vector);
        across(&mut vector, &found);
        let left = length(&vector);
        found.push(vector / left);
    }
    // Of the axes the one that is farthest from all so far comes next.
    while found.len() < size {
        for unit in &mut units {
            across(unit, &found);
        }
        let farthest = (0..units.len())
            .max_by(|&a, &b| length(&units[a]).total_cmp(&length(&units[b])))
            .unwrap_or(0);
        let next = units.swap_remove(farthest);
        let left = length(&next);
        found.push(next / left);
    }
    DMatrix::from_columns(&found[held..])
}

fn joined(kept: Vec<usize>, turned: &[(&[usize], DMatrix<f64>)]) -> Freedoms {
    if turned.is_empty() {
        return Freedoms { moving: kept, directions: None };
    }
    let is_turned = |index: &usize| turned.iter().any(|(group, _)| group.contains(index));
    let alone: Vec<usize> = kept.into_iter().filter(|index| !is_turned(index)).collect();
    let mut moving: Vec<usize> = alone.clone();
    moving.extend(turned.iter().flat_map(|(group, _)| group.iter().copied()));
    moving.sort_unstable();
    let columns = alone.len() + turned.iter().map(|(_, own)| own.ncols()).sum::<usize>();
    let mut directions = DMatrix::zeros(moving.len(), columns);
    let row = |index: usize| moving.iter().position(|&one| one == index).unwrap_or(0);
    for (column, &index) in alone.iter().enumerate() {
        directions[(row(index), column)] = 1.0;
    }
    let mut first = alone.len();
    for (group, own) in turned {
        for (i, &index) in group.iter().enumerate() {
            for k in 0..own.ncols() {
                directions[(row(index), first + k)] = own[(i, k)];
            }
        }
        first += own.ncols();
    }
    Freedoms { moving, directions: Some(directions) }
}

/// The product of a small change of one parameter with one of another of the same group: that of the axes of turns.
fn product(one: Parameter, other: Parameter, pose: &Pose) -> f64 {
    let axes = pose.turn_axes();
    let axis = |parameter: Parameter| match parameter {
        Parameter::Rx => Some(axes[0]),
        Parameter::Ry => Some(axes[1]),
        Parameter::Rz => Some(axes[2]),
        _ => None,
    };
    match (axis(one), axis(other)) {
        (Some(a), Some(b)) => a.iter().zip(b).map(|(a, b)| a * b).sum(),
        _ => f64::from(u8::from(one == other)),
    }
}

/// A share of the other members of a group that is rounding.
const SHARE: f64 = 1e-7;
/// What is held at the start goes along what is not felt by at least this share.
const TELLS: f64 = 0.1;
