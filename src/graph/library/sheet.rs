//! A surface as places with normals: those of a library entry as one sees it from a side, and those of a part.

use asphera_geometry::WeightedTree;
use asphera_geometry::vector::{cross, dot, length, minus, plus};

use crate::cloud::Cloud;
use crate::functions::{eigen, principal_axes};

/// A place or a direction in space.
pub(super) type Vector = [f64; 3];

/// A frame: its middle in mm, and three unit vectors at right angles, the third one up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) middle_mm: Vector,
    pub(super) axes: [Vector; 3],
    /// The first two axes could be turned about the third: the outline has no longest side.
    pub(super) is_round: bool,
    /// The farthest place from the third axis in mm.
    pub(super) radius_mm: f64,
}

/// Places of a surface with what a fit needs of them.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub(super) places: Vec<Vector>,
    pub(super) normals: Vec<Vector>,
    pub(super) tree: WeightedTree,
    pub(super) frame: Frame,
    /// The mean distance of a place to the nearest other one in mm.
    pub(super) spacing_mm: f64,
    /// Its places lie about as far apart everywhere, as those of a grid, and not at random, as those of a scan or of triangles.
    pub(super) is_even: bool,
    /// Scatter of the places about planes through their neighbours, a standard deviation in mm.
    pub(super) noise_mm: f64,
}

impl Sheet {
    /// The sheet of some points in mm, seen along `up` from above, with a normal a point if these are known. `None` of fewer than
    /// [`LEAST_PLACES`], of points on a line, and of coordinates that a cloud refuses.
    pub(super) fn new(points: &[Vector], normals: Option<&[Vector]>, up: Vector) -> Option<Sheet> {
        let cloud = Cloud::new(points).ok()?;
        if cloud.len() < LEAST_PLACES {
            return None;
        }
        // In the order of the places, which does not depend on that of the points.
        let places = cloud.places().to_vec();
        let tree = WeightedTree::of_points(&places);
        let frame = frame(&cloud, up)?;
        let spacing_mm = cloud.spacing_mm()?;
        let some = || places.iter().step_by(places.len().div_ceil(PLANES));
        let mut scatter: Vec<f64> =
            some().filter_map(|&place| Some(plane(&places, &tree, place)?.1)).collect();
        scatter.sort_unstable_by(f64::total_cmp);
        let noise_mm = *scatter.get(scatter.len() / 2)?;
        let normals = match normals {
            Some(known) => {
                let mut normals = vec![up; places.len()];
                for (&place, &normal) in cloud.places_of_rows().iter().zip(known) {
                    normals[place as usize] = normal;
                }
                normals
            }
            None => {
                let normal = |&at: &Vector| plane(&places, &tree, at).map_or(up, |found| found.0);
                places.iter().map(normal).collect()
            }
        };
        let is_even = is_even(some().map(|&place| nearest_mm(&places, &tree, place)));
        Some(Sheet { places, normals, tree, frame, spacing_mm, is_even, noise_mm })
    }

    /// The sheet of a surface that is larger by a factor.
    pub(super) fn scaled(&self, factor: f64) -> Sheet {
        let larger = |place: &Vector| place.map(|mm| factor * mm);
        let places: Vec<Vector> = self.places.iter().map(larger).collect();
        let frame = Frame {
            middle_mm: larger(&self.frame.middle_mm),
            radius_mm: factor * self.frame.radius_mm,
            ..self.frame
        };
        Sheet {
            tree: WeightedTree::of_points(&places),
            places,
            normals: self.normals.clone(),
            frame,
            spacing_mm: factor * self.spacing_mm,
            is_even: self.is_even,
            noise_mm: factor * self.noise_mm,
        }
    }

    /// How much higher than `from_mm` the place nearest to it lies along the third axis of a frame, in mm.
    pub(super) fn height_mm(&self, from_mm: Vector, frame: &Frame) -> Option<f64> {
        let (id, _) = self.tree.nearest(from_mm, |_| true)?;
        Some(dot(minus(self.places[id as usize], from_mm), frame.axes[2]))
    }
}

impl Frame {
    /// A frame turned about its third axis.
    pub(super) fn turned(&self, turn: f64) -> Frame {
        let (sin, cos) = turn.sin_cos();
        let [x, y, z] = self.axes;
        let across = std::array::from_fn(|at| cos * x[at] + sin * y[at]);
        let along = std::array::from_fn(|at| cos * y[at] - sin * x[at]);
        Frame { axes: [across, along, z], ..*self }
    }
}

/// The frame of a cloud: its principal axes, the one nearest to `up` as the third, about the middle of its box along them.
fn frame(cloud: &Cloud<3>, up: Vector) -> Option<Frame> {
    let found = principal_axes(cloud).ok()?;
    if found.spread_mm[1] <= LINE * found.spread_mm[0] {
        return None;
    }
    let slant = |at: usize| dot(found.axes[at], up).abs();
    let third = (0..2).fold(2, |best, at| if slant(at) > slant(best) { at } else { best });
    let [first, second] = match third {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    };
    let sign = if dot(found.axes[third], up) < 0.0 { -1.0 } else { 1.0 };
    let z = found.axes[third].map(|value| sign * value);
    let x = found.axes[first];
    let axes = [x, cross(z, x), z];
    let mut middle_mm = found.centre_mm;
    for axis in axes {
        let along = |&place: &Vector| dot(minus(place, found.centre_mm), axis);
        let (low, high) = (cloud.places().iter().map(along))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            });
        middle_mm = plus(middle_mm, f64::midpoint(low, high), axis);
    }
    let from_axis = |&place: &Vector| {
        let from = minus(place, middle_mm);
        dot(from, axes[0]).hypot(dot(from, axes[1]))
    };
    let radius_mm = cloud.places().iter().map(from_axis).fold(0.0, f64::max);
    let ratio = found.spread_mm[second] / found.spread_mm[first];
    Some(Frame { middle_mm, axes, is_round: ratio > ROUND, radius_mm })
}

/// The distance of a place to the nearest other one in mm.
fn nearest_mm(places: &[Vector], tree: &WeightedTree, place: Vector) -> f64 {
    let near = tree.least_few(place, 2);
    let distances = near.iter().map(|&id| length(minus(places[id as usize], place)));
    distances.fold(0.0, f64::max)
}

/// Whether distances differ little. Of places at random in a plane they deviate by 0.52 of their mean (J. Rayleigh's distribution).
fn is_even(distances_mm: impl Iterator<Item = f64>) -> bool {
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    distances_mm.for_each(|mm| (count, sum, squares) = (count + 1.0, sum + mm, squares + mm * mm));
    let mean: f64 = sum / count;
    (squares / count - mean * mean).max(0.0).sqrt() < EVEN * mean
}

/// The plane through the neighbours of a place: its normal, and their standard deviation from it in mm.
fn plane(places: &[Vector], tree: &WeightedTree, place: Vector) -> Option<(Vector, f64)> {
    let near = tree.least_few(place, NEIGHBOURS);
    let count = near.len() as f64;
    let offset = |&id: &u32| minus(places[id as usize], place);
    let sum = near
        .iter()
        .map(offset)
        .fold([0.0; 3], |sum, from| std::array::from_fn(|axis| sum[axis] + from[axis]));
    let mean = sum.map(|value| value / count);
    let mut moments = [[0.0; 3]; 3];
    for id in &near {
        let from = minus(offset(id), mean);
        for row in 0..3 {
            (0..3).for_each(|column| moments[row][column] += from[row] * from[column]);
        }
    }
    let (values, vectors) = eigen(moments);
    // Three degrees of freedom went into the plane.
    (values[0] > 0.0).then(|| (vectors[2], (values[2].max(0.0) / (count - 3.0)).sqrt()))
}

/// Places that a surface needs.
pub(super) const LEAST_PLACES: usize = 12;

/// Neighbours of a plane, the place itself among them.
const NEIGHBOURS: usize = 9;

/// Planes from which the noise is found.
const PLANES: usize = 300;

/// The standard deviation of distances over their mean below which places are those of a grid.
const EVEN: f64 = 0.25;

/// The second spread over the first of a cloud that is a line.
const LINE: f64 = 1e-3;

/// The second spread over the first of an outline without a longest side.
const ROUND: f64 = 0.9;
