//! Which diagonal four points nearly on one circle have: the one rule that all of them share.
//!
//! Four points that are nearly flat decide alone: in the plane along both diagonals, where the ends of a diagonal are equally high, a
//! circle decides. Four that are bent, as across a sharp edge, are compared in the mean of their tangent planes. There the cell structure
//! of space decides as a circle does, with heights as weights. Ties and what rounding leaves open fall by coordinates: the diagonal that
//! avoids the last of the four, as the mesh in the plane has it (O. Devillers, M. Teillaud, doi:10.1016/j.comgeo.2010.09.010).

use std::cmp::Ordering;

use asphera_geometry::{PointMm, greater};

use super::normals::TangentPlane;
use crate::geometry::{cross, dot, minus, unit};
use crate::neighbours::by_coordinates;

/// A convex quadrilateral of four points in the order of their coordinates: by places where it is flat.
enum Shape {
    Flat(bool),
    Open,
    Bent,
}

/// The rule's answers to one question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Vote {
    /// Whether the first two points have an edge, and whether the other two have; `None` where the four make no convex quadrilateral.
    has_edge: Option<[bool; 2]>,
    /// Whether their planes were asked for.
    is_bent: bool,
}

/// What the rule says of four points that make a quadrilateral with the first two and the other two as its diagonals.
///
/// The answer is a function of the four alone: whoever asks, the edge is the same.
fn vote(
    points_mm: &[PointMm],
    planes: &[Option<TangentPlane>],
    one: [u32; 2],
    other: [u32; 2],
) -> Vote {
    let in_order = |[one, other]: [u32; 2]| {
        let [one, other] = [one, other].map(|at| points_mm[at as usize]);
        if by_coordinates(one, other).is_gt() { [other, one] } else { [one, other] }
    };
    let (ask, across) = (in_order(one), in_order(other));
    let is_first = by_coordinates(ask[0], across[0]).is_lt();
    let shape = if is_first { flat(ask, across) } else { flat(across, ask) };
    let has_edge = match shape {
        Shape::Flat(has_first) => Some([has_first == is_first, has_first != is_first]),
        Shape::Open => None,
        Shape::Bent => bent(points_mm, planes, one, other),
    };
    Vote { has_edge, is_bent: matches!(shape, Shape::Bent) }
}

/// The edges of four points by the mean of their planes.
fn bent(
    points_mm: &[PointMm],
    planes: &[Option<TangentPlane>],
    one: [u32; 2],
    other: [u32; 2],
) -> Option<[bool; 2]> {
    let mut four = [one[0], one[1], other[0], other[1]];
    four.sort_unstable_by(|&a, &b| by_coordinates(points_mm[a as usize], points_mm[b as usize]));
    let places = four.map(|at| points_mm[at as usize]);
    let mut normals = [[0.0; 3]; 4];
    for (normal, &at) in normals.iter_mut().zip(&four) {
        *normal = planes[at as usize]?.normal;
    }
    let ends = ends(places, normals)?.map(|end| four[end]);
    Some([one, other].map(|[from, to]| ends.contains(&from) && ends.contains(&to)))
}

/// Answers of the rule, remembered: each corner of a quadrilateral asks, one soon after another.
pub(super) struct Votes {
    /// The four points of the last question that came to a place, and its answer.
    last: Vec<([u32; 4], Vote)>,
}

impl Default for Votes {
    fn default() -> Votes {
        let none = Vote { has_edge: None, is_bent: false };
        // No question has a point twice.
        Votes { last: vec![([0; 4], none); 1 << PLACES_LOG2] }
    }
}

impl Votes {
    /// Whether the diagonal from the first of four points runs to the second; `None` where the four make no convex quadrilateral.
    ///
    /// `asked` gets the numbers of the others where their planes were asked for.
    pub(super) fn diagonal(
        &mut self,
        points_mm: &[PointMm],
        planes: &[Option<TangentPlane>],
        [own, over]: [u32; 2],
        sides: [u32; 2],
        asked: &mut impl Extend<u32>,
    ) -> Option<bool> {
        let in_order = |[one, other]: [u32; 2]| [one.min(other), one.max(other)];
        let (ask, across) = (in_order([own, over]), in_order(sides));
        let is_second = across[0] < ask[0];
        let [one, other] = if is_second { [across, ask] } else { [ask, across] };
        let question = [one[0], one[1], other[0], other[1]];
        let last = &mut self.last[place(question)];
        if last.0 != question {
            *last = (question, vote(points_mm, planes, one, other));
        }
        let Vote { has_edge, is_bent } = last.1;
        if is_bent {
            asked.extend([over, sides[0], sides[1]]);
        }
        has_edge.map(|has_edge| has_edge[usize::from(is_second)])
    }
}

/// The place of a question among those that are remembered.
fn place([a, b, c, d]: [u32; 4]) -> usize {
    let pair = |one: u32, other: u32| u64::from(one) << 32 | u64::from(other);
    let mixed = pair(a, b).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ pair(c, d).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    (mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - PLACES_LOG2)) as usize
}

/// The shape of a quadrilateral by its diagonals. Each runs in the order of coordinates; the first has the smallest.
fn flat([a, c]: [PointMm; 2], [b, d]: [PointMm; 2]) -> Shape {
    let Some(up) = unit(cross(minus(c, a), minus(d, b))) else { return Shape::Bent };
    let height = dot(minus(b, a), up);
    // Ways from the ends of the second diagonal to those of the first, at one height.
    let flat = |from: PointMm, to: PointMm| {
        let way = minus(to, from);
        [0, 1, 2].map(|axis| way[axis] + height * up[axis])
    };
    let (b_a, b_c, d_a, d_c) = (flat(b, a), flat(b, c), flat(d, a), flat(d, c));
    let size = [b_a, b_c, d_a, d_c].map(|way| dot(way, way)).into_iter().fold(0.0, greater);
    if height * height > BENT * size {
        return Shape::Bent;
    }
    let turn = |one: PointMm, other: PointMm| dot(cross(one, other), up);
    let corners = [turn(d_a, b_a), turn(b_a, b_c), turn(b_c, d_c), turn(d_c, d_a)];
    if !corners.iter().all(|&at| at > 0.0) && !corners.iter().all(|&at| at < 0.0) {
        return Shape::Open;
    }
    // The angles at b and d are 180° together where all four lie on a circle, and less where the first diagonal divides them.
    let sine = corners[1].abs() * dot(d_a, d_c) + corners[3].abs() * dot(b_a, b_c);
    if sine.abs() <= rounding([a, b, c, d], size) {
        return Shape::Flat(by_coordinates(c, d) == Ordering::Less);
    }
    Shape::Flat(sine > 0.0)
}

/// What of the fourth power of a length counts as a tie.
fn rounding(places: [PointMm; 4], square: f64) -> f64 {
    let values = places.as_flattened();
    let coordinate = values.iter().fold(0.0_f64, |most, value| greater(value.abs(), most));
    TIE * square * square + 64.0 * f64::EPSILON * coordinate * square * square.sqrt()
}

/// Which two of four points, in the order of their coordinates, the dividing edge joins.
fn ends(places: [PointMm; 4], mut normals: [PointMm; 4]) -> Option<[usize; 2]> {
    let first = normals[0];
    for normal in &mut normals {
        if dot(*normal, first) < 0.0 {
            *normal = normal.map(|side| -side);
        }
    }
    let up = unit([0, 1, 2].map(|axis| normals.iter().map(|normal| normal[axis]).sum()))?;
    let along = basis(up);
    let across = cross(up, along);
    let flat = places.map(|place| {
        let way = minus(place, places[0]);
        [dot(way, along), dot(way, across), dot(way, up)]
    });
    let middle = [0, 1].map(|axis| flat.iter().map(|place| place[axis]).sum::<f64>() / 4.0);
    // Where the tangent planes pass the middle, on the average.
    let height = flat.iter().zip(normals).map(|(place, normal)| {
        let slope =
            |axis: PointMm, index: usize| dot(normal, axis) * (middle[index] - place[index]);
        place[2] - (slope(along, 0) + slope(across, 1)) / dot(normal, up).max(0.3)
    });
    let height = height.sum::<f64>() / 4.0;
    let turn = |i: usize, j: usize| flat[i][0] * flat[j][1] - flat[i][1] * flat[j][0];
    let opposite = (1..4).find(|&k| {
        let (i, j) = others(k);
        turn(k, i) * turn(k, j) < 0.0
    })?;
    let (i, j) = others(opposite);
    let k = opposite;
    // Convex: the first and its opposite lie on different sides of the line of the other two.
    let side = |p: [f64; 3]| {
        (flat[j][0] - flat[i][0]) * (p[1] - flat[i][1])
            - (flat[j][1] - flat[i][1]) * (p[0] - flat[i][0])
    };
    if side(flat[0]) * side(flat[k]) >= 0.0 {
        return None;
    }
    let lift = flat.map(|[x, y, z]| x * x + y * y + z * (z - 2.0 * height));
    let det = lift[i] * turn(k, j) + lift[k] * turn(j, i) + lift[j] * turn(i, k);
    let area = turn(i, k) + turn(k, j) + turn(j, i);
    let size = flat.iter().map(|[x, y, z]| x * x + y * y + z * z).fold(0.0, f64::max);
    let noise = rounding(places, size);
    let encloses = if area > 0.0 { det } else { -det };
    // `true`: the first lies in the circle of the other three, and the diagonal runs from it.
    let from_first = if encloses.abs() <= noise { k != 3 } else { encloses > 0.0 };
    Some(if from_first { [0, k] } else { [i, j] })
}

fn others(k: usize) -> (usize, usize) {
    match k {
        1 => (2, 3),
        2 => (1, 3),
        _ => (1, 2),
    }
}

/// A direction across another.
pub(crate) fn basis(up: PointMm) -> PointMm {
    let least =
        (0..3).fold(0, |least, axis| if up[axis].abs() < up[least].abs() { axis } else { least });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    // An axis at more than 54° to `up` is never along it.
    unit(cross(up, axis)).unwrap_or(axis)
}

/// The logarithm of the number of answers that are remembered: those of a thread's points and of the borders about them.
const PLACES_LOG2: u32 = 10;
/// Of the fourth power of the size: what counts as a tie.
const TIE: f64 = 1e-11;
/// Of the square of the longest side: the square of the distance of the diagonals of a bent quadrilateral.
const BENT: f64 = 0.0005;

#[cfg(test)]
mod tests {
    use asphera_geometry::predicates::in_circle;
    use proptest::prelude::*;

    use super::*;

    fn ask(points: &[PointMm; 4], [own, over]: [u32; 2], sides: [u32; 2]) -> Option<bool> {
        Votes::default().diagonal(points, &[None; 4], [own, over], sides, &mut Vec::new())
    }

    proptest! {
        #[test]
        fn flat_points_have_the_diagonal_of_their_circle(
            places in prop::array::uniform4(prop::array::uniform2(1_i32..6)),
            turn in 0_usize..3,
            shift in -1000_i32..1000,
        ) {
            // Four places on a lattice, one in each quadrant: many lie on one circle.
            let signs = [[1, 1], [-1, 1], [-1, -1], [1, -1]];
            let flat: [[f64; 2]; 4] = std::array::from_fn(|at| {
                [0, 1].map(|axis| f64::from(signs[at][axis] * places[at][axis]))
            });
            let points = flat.map(|[x, y]| {
                let mut point = [x, y, f64::from(shift)];
                point.rotate_right(turn);
                point
            });
            let [a, b, c, d] = flat;
            let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
                (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])
            };
            let corners = [side(a, b, c), side(b, c, d), side(c, d, a), side(d, a, b)];
            prop_assume!(corners.iter().all(|&corner| corner > 0.0));
            let found = ask(&points, [0, 2], [1, 3]);
            let expected = match in_circle(a, b, c, d) {
                Ordering::Less => true,
                Ordering::Greater => false,
                // The diagonal avoids the last.
                Ordering::Equal => {
                    let last = (0..4).max_by(|&i, &j| by_coordinates(points[i], points[j]));
                    [Some(1), Some(3)].contains(&last)
                }
            };
            prop_assert_eq!(found, Some(expected));
        }

        #[test]
        fn whoever_asks_hears_the_same(
            points in prop::array::uniform4(prop::array::uniform3(-1.0..1.0)),
            height in prop::sample::select(vec![0.0, 1e-12, 1e-3, 0.02]),
        ) {
            let points = points.map(|[x, y, z]| [x, y, height * z]);
            let one = ask(&points, [0, 2], [1, 3]);
            for (own, sides) in [([0, 2], [3, 1]), ([2, 0], [1, 3]), ([2, 0], [3, 1])] {
                prop_assert_eq!(ask(&points, own, sides), one);
            }
            for (own, sides) in [([1, 3], [0, 2]), ([3, 1], [2, 0])] {
                prop_assert_eq!(ask(&points, own, sides), one.map(|is_there| !is_there));
            }
        }
    }

    #[test]
    fn bent_points_ask_for_planes_and_flat_ones_do_not() {
        let square =
            |height| [[0.0, 0.0, 0.0], [1.0, 0.0, height], [1.0, 1.0, 0.0], [0.0, 1.0, height]];
        for (height, expected) in [(0.0, vec![]), (0.02, vec![]), (0.5, vec![2, 1, 3])] {
            let mut asked = Vec::new();
            let mut votes = Votes::default();
            votes.diagonal(&square(height), &[None; 4], [0, 2], [1, 3], &mut asked);
            assert_eq!(asked, expected, "{height}");
        }
    }
}
