//! The border of an aperture as a polygon in general position, and where it runs.
//!
//! The polygons of what is not covered are made of sides of triangles and of sides of this border.
//! Where a part was measured to its very edge, or on a raster that fits it, both coincide, and which
//! is outside the other is then a matter of rounding. So the border is drawn a little inside the
//! aperture, by some 1e-9 of its size and not quite parallel to it, after which the exact predicates
//! tell all there is to tell. Areas are not taken from it.

use std::f64::consts::TAU;

use asphera_geometry::outline::{ring_area_mm2, side_right_of};
use asphera_geometry::predicates::Place;

use super::aperture::{Aperture, Shape};
use super::clip::{cross, minus};
use super::draw::Line;

/// How far, as a share of its radius, a circle's drawn border may lie inside it.
pub(super) const SAGITTA: f64 = 1e-5;

/// Where a triangle lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Whereabouts {
    /// Inside the aperture, clear of its border.
    Inside,
    /// Outside it, clear of its border.
    Outside,
    /// Perhaps across the border.
    Near,
}

/// The drawn border, the aperture on the left of each side.
pub(super) struct Border {
    /// Where sides begin.
    places: Vec<Place>,
    /// Which side follows which.
    next: Vec<u32>,
    low: Place,
    /// Centre and radius of a circle about the aperture.
    about: (Place, f64),
    /// Squares of the bounds per mm along x and y.
    scale: Place,
    squares: usize,
    /// For each square, row by row: whether no side runs near it, and if so, where it lies.
    whereabouts: Vec<Whereabouts>,
    /// For each square where it and those about it lie, if all alike.
    about_squares: Vec<Whereabouts>,
    /// Less than the square of a square's shorter side in mm².
    clear_mm2: f64,
    /// The sides near each square.
    near: Vec<Vec<u32>>,
    /// The sides whose range of y meets a row of squares.
    rows: Vec<Vec<u32>>,
    /// The same by ranges of x.
    columns: Vec<Vec<u32>>,
}

impl Border {
    /// The border of an aperture, for some `triangles` triangles. Another `attempt` places it a
    /// little differently.
    pub(super) fn new(aperture: &Aperture, triangles: usize, attempt: u32) -> Border {
        let rings = drawn(aperture, attempt);
        let mut places = Vec::new();
        let mut next = Vec::new();
        for ring in rings {
            let first = places.len() as u32;
            places.extend(ring);
            let end = places.len() as u32;
            next.extend((first + 1..end).chain([first]));
        }
        // The drawn border lies inside the bounds of the aperture.
        let [low, high] = aperture.bounds_mm();
        let squares = (triangles.isqrt() / 8).clamp(8, 256);
        let scale = [0, 1].map(|axis| squares as f64 / (high[axis] - low[axis]));
        let count = squares * squares;
        let centre = [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]));
        let reach = |place: &Place| (place[0] - centre[0]).hypot(place[1] - centre[1]);
        // Drawn borders lie inside the aperture by far less than the margin.
        let about = (centre, (1.0 + 4.0 * SAGITTA) * places.iter().map(reach).fold(0.0, f64::max));
        let mut border = Border {
            places,
            next,
            low,
            about,
            scale,
            squares,
            whereabouts: vec![Whereabouts::Outside; count],
            about_squares: vec![Whereabouts::Near; count],
            clear_mm2: 0.9 * scale[0].max(scale[1]).recip().powi(2),
            near: vec![Vec::new(); count],
            rows: vec![Vec::new(); squares],
            columns: vec![Vec::new(); squares],
        };
        border.enter_sides(2.0 * SAGITTA * (high[0] - low[0]).max(high[1] - low[1]));
        border.locate_squares();
        border.clear_squares();
        border
    }

    /// How many sides there are.
    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    pub(super) fn place(&self, index: u32) -> Place {
        self.places[index as usize]
    }

    /// The beginning and the end of a side.
    pub(super) fn side(&self, side: u32) -> (Place, Place) {
        (self.place(side), self.place(self.next[side as usize]))
    }

    /// The number of the place where a side ends, which is that of the next side.
    pub(super) fn next(&self, side: u32) -> u32 {
        self.next[side as usize]
    }

    /// All of it as closed lines.
    pub(super) fn lines(&self) -> Vec<Line> {
        let mut lines = Vec::new();
        let mut first = 0;
        for index in 0..self.len() {
            if self.next[index] as usize <= index {
                let places_mm = self.places[first..=index].to_vec();
                let signed_area_mm2 = ring_area_mm2(&places_mm);
                lines.push(Line { open: vec![true; places_mm.len()], places_mm, signed_area_mm2 });
                first = index + 1;
            }
        }
        lines
    }

    /// The side of the polygon `rings` that a side of this border stands for.
    pub(super) fn true_side(&self, rings: &[Vec<Place>], side: u32) -> (Place, Place) {
        let at = |index: u32| {
            let mut index = index as usize;
            let ring = rings.iter().find(|ring| {
                let here = index < ring.len();
                if !here {
                    index -= ring.len();
                }
                here
            });
            ring.expect("a side of the border is one of the rings")[index]
        };
        (at(side), at(self.next(side)))
    }

    /// Whether a place lies inside the drawn border, exactly.
    pub(super) fn contains(&self, at: Place) -> bool {
        // Rounding may put a side into the row beside that of a place at one height with its end;
        // both are then looked through, as sides are entered with a margin.
        let row = self.step(at[1], 1);
        let right = |&&side: &&u32| {
            let (p, q) = self.side(side);
            side_right_of(p, q, at)
        };
        self.rows[row].iter().filter(right).count() % 2 == 1
    }

    /// As [`Border::contains`], by a look at one square where that tells.
    #[inline]
    pub(super) fn holds(&self, at: Place) -> bool {
        // What is beyond the bounds is taken for the squares beside them, which are never inside.
        match self.whereabouts[self.step(at[1], 1) * self.squares + self.step(at[0], 0)] {
            Whereabouts::Inside => true,
            Whereabouts::Outside => false,
            Whereabouts::Near => self.contains(at),
        }
    }

    /// Where a triangle lies.
    pub(super) fn whereabouts(&self, triangle: [Place; 3]) -> Whereabouts {
        if !self.bounds_meet(triangle) {
            return Whereabouts::Outside;
        }
        let [(c0, c1), (r0, r1)] = self.squares_about(triangle);
        if (c1 - c0 + 1) * (r1 - r0 + 1) > FEW_SQUARES {
            return if self.is_beside(triangle) { Whereabouts::Outside } else { Whereabouts::Near };
        }
        let first = self.whereabouts[r0 * self.squares + c0];
        for row in r0..=r1 {
            for column in c0..=c1 {
                if self.whereabouts[row * self.squares + column] != first {
                    return Whereabouts::Near;
                }
            }
        }
        // What is beyond the bounds is taken for the squares beside them, which are never inside.
        first
    }

    /// Where a triangle lies of which only a corner is looked at and that no side is longer than the root of
    /// `long_mm2`: as [`Border::whereabouts`], or near where that would have to look closer.
    #[inline(always)]
    pub(super) fn whereabouts_of(&self, corner: Place, long_mm2: f64) -> Whereabouts {
        let square = self.step(corner[1], 1) * self.squares + self.step(corner[0], 0);
        if long_mm2 < self.clear_mm2 { self.about_squares[square] } else { Whereabouts::Near }
    }

    /// Whether the counter-clockwise triangle lies beside the circle about the border: a side of it has all of
    /// the circle on its right, or the triangle lies beyond the tangent that faces one of its corners.
    fn is_beside(&self, [p, q, r]: [Place; 3]) -> bool {
        let (centre, radius) = self.about;
        let beyond_a_side = [(p, q), (q, r), (r, p)].into_iter().any(|(from, to)| {
            let way = minus(to, from);
            cross(way, minus(centre, from)) < -radius * way[0].hypot(way[1])
        });
        let ways = [p, q, r].map(|corner| minus(corner, centre));
        beyond_a_side
            || ways.into_iter().any(|way| {
                let least = radius * way[0].hypot(way[1]);
                ways.into_iter().all(|other| way[0] * other[0] + way[1] * other[1] > least)
            })
    }

    /// Finds the sides that may meet the triangle, in order.
    pub(super) fn sides_near(&self, triangle: [Place; 3], found: &mut Vec<u32>) {
        found.clear();
        let [(c0, c1), (r0, r1)] = self.squares_about(triangle);
        if (c1 - c0 + 1) * (r1 - r0 + 1) > FEW_SQUARES {
            found.extend(0..self.len() as u32);
        } else {
            for row in r0..=r1 {
                for column in c0..=c1 {
                    found.extend_from_slice(&self.near[row * self.squares + column]);
                }
            }
            found.sort_unstable();
            found.dedup();
        }
        let range = |axis: usize| {
            let [p, q, r] = triangle.map(|corner| corner[axis]);
            [p.min(q).min(r), p.max(q).max(r)]
        };
        let ranges = [range(0), range(1)];
        found.retain(|&side| {
            let (p, q) = self.side(side);
            (0..2).all(|axis| {
                let [low, high] = ranges[axis];
                p[axis].min(q[axis]) <= high && low <= p[axis].max(q[axis])
            })
        });
    }

    /// Calls `take` for each side whose range of x may meet that of the triangle, in order.
    pub(super) fn for_sides_about(&self, triangle: [Place; 3], mut take: impl FnMut(u32)) {
        let [(c0, c1), _] = self.squares_about(triangle);
        if (c1 - c0) > FEW_COLUMNS {
            (0..self.len() as u32).for_each(take);
            return;
        }
        let mut sides = self.columns[c0..=c1].concat();
        sides.sort_unstable();
        sides.dedup();
        sides.into_iter().for_each(&mut take);
    }

    /// The square or row a coordinate falls in; those beyond the bounds count for the outermost.
    #[inline(always)]
    fn step(&self, mm: f64, axis: usize) -> usize {
        // A cast saturates: what lies before the bounds is in the first square.
        (((mm - self.low[axis]) * self.scale[axis]) as usize).min(self.squares - 1)
    }

    fn squares_about(&self, triangle: [Place; 3]) -> [(usize, usize); 2] {
        [0, 1].map(|axis| {
            let [p, q, r] = triangle.map(|corner| corner[axis]);
            (self.step(p.min(q).min(r), axis), self.step(p.max(q).max(r), axis))
        })
    }

    /// Whether the ranges of the triangle meet the bounds.
    fn bounds_meet(&self, triangle: [Place; 3]) -> bool {
        (0..2).all(|axis| {
            let [p, q, r] =
                triangle.map(|corner| (corner[axis] - self.low[axis]) * self.scale[axis]);
            p.max(q).max(r) >= 0.0 && p.min(q).min(r) <= self.squares as f64
        })
    }

    /// Notes for squares and rows which sides run within `margin` mm.
    fn enter_sides(&mut self, margin: f64) {
        let square_mm = [0, 1].map(|axis| self.scale[axis].recip());
        for side in 0..self.len() as u32 {
            let (p, q) = self.side(side);
            let way = minus(q, p);
            // A slanted side is near few of the squares of its range: it is entered bit by bit.
            let bits = (way[0] / square_mm[0]).abs().max((way[1] / square_mm[1]).abs()).ceil();
            let bits = bits.max(1.0) as usize;
            for bit in 0..bits {
                let at = |share: f64| [p[0] + share * way[0], p[1] + share * way[1]];
                let from = at(bit as f64 / bits as f64);
                let to = at((bit + 1) as f64 / bits as f64);
                let range = |axis: usize| {
                    let low = from[axis].min(to[axis]) - margin;
                    let high = from[axis].max(to[axis]) + margin;
                    self.step(low, axis)..=self.step(high, axis)
                };
                let (columns, rows) = (range(0), range(1));
                for column in columns.clone() {
                    if self.columns[column].last() != Some(&side) {
                        self.columns[column].push(side);
                    }
                }
                for row in rows {
                    if self.rows[row].last() != Some(&side) {
                        self.rows[row].push(side);
                    }
                    for column in columns.clone() {
                        let square = &mut self.near[row * self.squares + column];
                        if square.last() != Some(&side) {
                            square.push(side);
                        }
                    }
                }
            }
        }
    }

    fn locate_squares(&mut self) {
        for index in 0..self.near.len() {
            self.whereabouts[index] = if self.near[index].is_empty() {
                let middle = |step: usize, axis: usize| {
                    self.low[axis] + (step as f64 + 0.5) / self.scale[axis]
                };
                let at = [middle(index % self.squares, 0), middle(index / self.squares, 1)];
                if self.contains(at) { Whereabouts::Inside } else { Whereabouts::Outside }
            } else {
                Whereabouts::Near
            };
        }
    }

    fn clear_squares(&mut self) {
        let last = self.squares - 1;
        for index in 0..self.about_squares.len() {
            let about = |step: usize| step.saturating_sub(1)..=(step + 1).min(last);
            let (row, column) = (index / self.squares, index % self.squares);
            let here = self.whereabouts[index];
            let alike = about(row).all(|row| {
                about(column).all(|column| self.whereabouts[row * self.squares + column] == here)
            });
            self.about_squares[index] = if alike { here } else { Whereabouts::Near };
        }
    }
}

/// The closed lines of the border, moved inwards.
fn drawn(aperture: &Aperture, attempt: u32) -> Vec<Vec<Place>> {
    let [low, high] = aperture.bounds_mm();
    let size_mm = (high[0] - low[0]).max(high[1] - low[1]);
    let farthest_mm = low.iter().chain(&high).fold(0.0_f64, |far, mm| far.max(mm.abs()));
    // Far from the origin the coordinates themselves are rounded by more.
    let inset_mm = (1e-9 * size_mm).max(8.0 * f64::EPSILON * farthest_mm) * f64::from(1 + attempt);
    let mut wobble = Wobble(0x9E37_79B9 ^ attempt.wrapping_mul(0x85EB_CA6B));
    match &aperture.shape {
        Shape::Circle { centre_mm, radius_mm } => {
            vec![circle(*centre_mm, *radius_mm, -inset_mm, &mut wobble)]
        }
        Shape::Annulus { centre_mm, inner_mm, outer_mm } => {
            let mut hole = circle(*centre_mm, *inner_mm, inset_mm, &mut wobble);
            hole.reverse();
            vec![circle(*centre_mm, *outer_mm, -inset_mm, &mut wobble), hole]
        }
        Shape::Rectangle { min_mm: [x0, y0], max_mm: [x1, y1] } => {
            vec![moved_in(&[[*x0, *y0], [*x1, *y0], [*x1, *y1], [*x0, *y1]], inset_mm, &mut wobble)]
        }
        Shape::Outline(outline) => {
            outline.rings().iter().map(|ring| moved_in(ring, inset_mm, &mut wobble)).collect()
        }
    }
}

/// A regular polygon about `centre`, counter-clockwise: inside the circle if it is moved inwards
/// (by a negative `outwards`), else about it.
fn circle(centre: Place, radius_mm: f64, outwards: f64, wobble: &mut Wobble) -> Vec<Place> {
    // The sagitta of a side over the angle 2a is r·(1 - cos a).
    let half_angle = (1.0 - SAGITTA).acos();
    let count = (TAU / (2.0 * half_angle)).ceil();
    let scale = if outwards > 0.0 { (TAU / (2.0 * count)).cos().recip() } else { 1.0 };
    let turn = wobble.next();
    (0..count as usize)
        .map(|i| {
            let (sin, cos) = (TAU * (i as f64 + turn) / count).sin_cos();
            let r = radius_mm * scale + outwards * (1.0 + wobble.next());
            [centre[0] + r * cos, centre[1] + r * sin]
        })
        .collect()
}

/// The corners of a closed line, each moved to the left of its sides.
fn moved_in(ring: &[Place], inset_mm: f64, wobble: &mut Wobble) -> Vec<Place> {
    let left = |p: Place, q: Place| {
        let way = minus(q, p);
        let length = way[0].hypot(way[1]);
        [-way[1] / length, way[0] / length]
    };
    (0..ring.len())
        .map(|i| {
            let (before, at) = (ring[(i + ring.len() - 1) % ring.len()], ring[i]);
            let (first, second) = (left(before, at), left(at, ring[(i + 1) % ring.len()]));
            // Moving by d / (1 + n·m) along n + m moves either side by d. Along n and m it is not quite
            // the same, or a corner would move on the diagonal of a raster; but nearly, or a sharp
            // corner would leave the aperture.
            let along = (1.0 + first[0] * second[0] + first[1] * second[1]).max(0.1);
            let by = inset_mm * (1.0 + wobble.next()) / along;
            let other = by * (1.0 + 0.01 * wobble.next());
            [0, 1].map(|axis| at[axis] + by * first[axis] + other * second[axis])
        })
        .collect()
}

/// Numbers from 0 to below 1 without any regularity, always the same ones.
struct Wobble(u32);

impl Wobble {
    fn next(&mut self) -> f64 {
        // Xorshift: G. Marsaglia, Journal of Statistical Software 8 (2003) 14.
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        f64::from(self.0) / 4_294_967_296.0
    }
}

/// A triangle over more squares than these is not looked up: it may be as large as the aperture.
const FEW_SQUARES: usize = 64;
const FEW_COLUMNS: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawn_border_lies_inside_the_aperture_and_encloses_nearly_as_much() {
        let star = [[0.0, 0.0], [5.0, 2.0], [10.0, 0.0], [8.0, 5.0], [10.0, 10.0], [0.0, 10.0]];
        let hole = vec![[3.0, 4.0], [3.0, 6.0], [6.0, 5.0]];
        let apertures = [
            Aperture::circle([3.0, -1.0], 2.0),
            Aperture::annulus([1e6, 1e6], 1.0, 2.0),
            Aperture::rectangle([-5.0, 5.0], 4.0, 3.0),
            Aperture::polygon(&star, &[hole]),
        ];
        for aperture in apertures.map(Result::unwrap) {
            for attempt in 0..4 {
                let border = Border::new(&aperture, 100_000, attempt);
                let inside = |&side: &u32| {
                    let (p, q) = border.side(side);
                    let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
                    aperture.contains(p) && aperture.contains(middle)
                };
                assert!((0..border.len() as u32).all(|side| inside(&side)), "{aperture:?}");
                let drawn: f64 = border.lines().iter().map(|line| line.signed_area_mm2).sum();
                let missing = 1.0 - drawn / aperture.area_mm2();
                assert!(missing > 0.0 && missing < 3.0 * SAGITTA, "{aperture:?}: {missing}");
            }
        }
    }

    #[test]
    fn whereabouts_agree_with_places() {
        let hole = vec![[3.0, 4.0], [3.0, 6.0], [6.0, 5.0]];
        let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let aperture = Aperture::polygon(&square, &[hole]).unwrap();
        let border = Border::new(&aperture, 100_000, 0);
        let mut seen = [0; 3];
        for (i, j) in (-20..130).flat_map(|i| (-20..130).map(move |j| (i, j))) {
            let [x, y] = [0.1 * f64::from(i), 0.1 * f64::from(j)];
            let triangle = [[x, y], [x + 0.1, y], [x, y + 0.1]];
            let inside = triangle.iter().filter(|&&place| border.contains(place)).count();
            let whereabouts = border.whereabouts(triangle);
            match whereabouts {
                Whereabouts::Inside => assert_eq!(inside, 3, "{triangle:?}"),
                Whereabouts::Outside => assert_eq!(inside, 0, "{triangle:?}"),
                Whereabouts::Near => {}
            }
            seen[whereabouts as usize] += 1;
        }
        assert!(seen[0] > 8_000 && seen[1] > 10_000 && seen[2] < 2_000, "{seen:?}");
    }
}
