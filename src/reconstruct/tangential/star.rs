//! The star of a point: its cell in the power diagram, cut by its tangent plane.

use super::weights::WIDEST;
use crate::geometry::{cross, dot, minus};
use crate::local::normals::TangentPlane;
use crate::local::{GAP, Places as _, basis};
use crate::neighbours::{Near, Neighbours};

/// Ingredients of stars.
pub(super) struct Maker<'a> {
    pub(super) tree: &'a Neighbours,
    pub(super) planes: &'a [Option<TangentPlane>],
    /// Weights in mm².
    pub(super) weights: Vec<f64>,
}

/// Memory of a thread between stars.
#[derive(Default)]
pub(super) struct Room {
    near: Vec<Near>,
    cell: Vec<Corner>,
    next: Vec<Corner>,
}

/// A half-plane of the cell: x·a + y·b ≤ offset.
#[derive(Clone, Copy)]
struct Half {
    x: f64,
    y: f64,
    offset: f64,
    of: u32,
}

/// A corner of the cell, and the neighbour beyond the side that starts there.
#[derive(Clone, Copy)]
struct Corner {
    x: f64,
    y: f64,
    beyond: u32,
}

impl Corner {
    fn square(&self) -> f64 {
        self.x * self.x + self.y * self.y
    }
}

impl Maker<'_> {
    /// The neighbours about a point, with [`GAP`] where no facet is.
    pub(super) fn star(&self, at: u32, room: &mut Room) -> Vec<u32> {
        let Some(plane) = self.planes[at as usize] else { return Vec::new() };
        let along = basis(plane.normal);
        let across = cross(plane.normal, along);
        let place = self.tree.points_mm[at as usize];
        let reach = plane.reach_mm;
        let limit = reach * reach / 4.0;
        room.cell.clear();
        for (x, y) in [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            room.cell.push(Corner { x: x * reach, y: y * reach, beyond: GAP });
        }
        let mut radius = limit.sqrt();
        let mut near = std::mem::take(&mut room.near);
        let mut asked = 0;
        // Most cells close within a third of the reach.
        for share in [0.34, 1.0] {
            let seen = share * reach;
            self.tree.within(at, seen, &mut near);
            for &(square, other) in near.iter().skip(asked) {
                // A neighbour at this distance cuts nothing within the radius, whatever its weight.
                if square.sqrt() * (1.0 - WIDEST * WIDEST) > 2.0 * radius * (1.0 + ROUNDING) {
                    break;
                }
                let way = minus(self.tree.points_mm[other as usize], place);
                let lift = self.weights[at as usize] - self.weights[other as usize];
                let offset = (square + lift) / 2.0;
                let half = Half { x: dot(way, along), y: dot(way, across), offset, of: other };
                if cut(room, half) {
                    let widest = room.cell.iter().map(Corner::square).fold(0.0, f64::max);
                    radius = widest.min(limit).sqrt();
                }
            }
            asked = near.len();
            if 2.0 * radius * (1.0 + ROUNDING) < seen * (1.0 - WIDEST * WIDEST) {
                break;
            }
        }
        room.near = near;
        ring(&room.cell, limit)
    }
}

/// The neighbours beyond the sides of a cell, with a gap at corners that are too far.
fn ring(cell: &[Corner], limit: f64) -> Vec<u32> {
    let mut ring = Vec::with_capacity(cell.len() + 2);
    for (index, corner) in cell.iter().enumerate() {
        let before = cell[(index + cell.len() - 1) % cell.len()].beyond;
        if corner.square() > limit && before != GAP && corner.beyond != GAP {
            ring.push(GAP);
        }
        ring.push(corner.beyond);
    }
    ring
}

/// Cuts the cell by a half-plane; gives whether it lost anything.
fn cut(room: &mut Room, half: Half) -> bool {
    let over = |corner: &Corner| corner.x * half.x + corner.y * half.y - half.offset;
    if room.cell.iter().all(|corner| over(corner) <= 0.0) {
        return false;
    }
    room.next.clear();
    let len = room.cell.len();
    for index in 0..len {
        let (from, to) = (room.cell[index], room.cell[(index + 1) % len]);
        let (a, b) = (over(&from), over(&to));
        let crossing = |beyond: u32| {
            let share = a / (a - b);
            Corner {
                x: from.x + share * (to.x - from.x),
                y: from.y + share * (to.y - from.y),
                beyond,
            }
        };
        if a <= 0.0 {
            room.next.push(from);
            if b > 0.0 {
                room.next.push(crossing(half.of));
            }
        } else if b <= 0.0 {
            room.next.push(crossing(from.beyond));
        }
    }
    std::mem::swap(&mut room.cell, &mut room.next);
    true
}

const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::super::weights::share;
    use super::*;

    /// In a plane the stars are those of the regular triangulation: a facet is where no point has less power at its orthocentre.
    #[test]
    fn stars_in_a_plane_are_the_regular_triangulation() {
        let mut state = 3_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 * 2_f64.powi(-53)
        };
        let tree = Neighbours::of((0..90).map(|id| ([random(), random(), 0.5], id)).collect());
        let nearest = tree.map_nearest(1, |_, near, _: &mut ()| near[0].0);
        let plane = Some(TangentPlane { normal: [0.0, 0.0, 1.0], reach_mm: 0.8 });
        let weights: Vec<f64> = nearest
            .iter()
            .zip(&tree.points_mm)
            .map(|(near, place)| near * share(*place, 1))
            .collect();
        assert!(weights.iter().any(|&weight| weight > 0.0));
        let planes = vec![plane; tree.len()];
        let maker = Maker { tree: &tree, planes: &planes, weights };
        let power = |at: u32, place: [f64; 3]| {
            let way = minus(place, tree.points_mm[at as usize]);
            dot(way, way) - maker.weights[at as usize]
        };
        // Where three powers are equal: two lines.
        let centre = |[p, q, r]: [u32; 3]| {
            let origin = tree.points_mm[p as usize];
            let [u, v] = [q, r].map(|at| minus(tree.points_mm[at as usize], origin));
            let [a, b] = [q, r].map(|at| (power(at, origin) - power(p, origin)) / 2.0);
            let turn = u[0] * v[1] - u[1] * v[0];
            let way = [(a * v[1] - b * u[1]) / turn, (b * u[0] - a * v[0]) / turn, 0.0];
            [0, 1, 2].map(|axis| origin[axis] + way[axis])
        };
        let count = tree.len() as u32;
        let mut room = Room::default();
        let mut inner = 0;
        for p in 0..count {
            let star = maker.star(p, &mut room);
            if star.contains(&GAP) {
                continue;
            }
            inner += 1;
            let mut found: Vec<[u32; 2]> = (0..star.len())
                .map(|at| (star[at], star[(at + 1) % star.len()]))
                .map(|(q, r)| [q.min(r), q.max(r)])
                .collect();
            found.sort_unstable();
            let others = (0..count).filter(|&at| at != p);
            let pairs =
                others.flat_map(|q| (q + 1..count).filter(move |&r| r != p).map(move |r| [q, r]));
            let expected: Vec<[u32; 2]> = pairs
                .filter(|&[q, r]| {
                    let place = centre([p, q, r]);
                    let least = power(p, place);
                    (0..count).all(|at| [p, q, r].contains(&at) || power(at, place) > least)
                })
                .collect();
            assert_eq!(found, expected);
        }
        assert!(inner > 50, "{inner}");
    }
}
