//! Gap, ε and coverage place by place, against distances to all samples over a fine grid of places.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::coverage::{Aperture, Coverage, Target, cover};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// What a grid of places over the mesh finds.
struct Truth {
    /// The distance of each place to its nearest sample in mm, the local feature size there, and the area in space
    /// that it stands for.
    places: Vec<[f64; 3]>,
}

impl Truth {
    /// Over the part of the mesh in a circle about the origin; the height of a place is that of the mesh.
    fn new(mesh: &Mesh, radius_mm: f64, lfs_mm: impl Fn(f64, f64) -> f64) -> Truth {
        let points = mesh.points();
        let squares = Squares::new(points, radius_mm);
        let (mut places, mut number) = (Vec::new(), 0_u32);
        for corners in mesh.triangles() {
            let [p, q, r] = corners.map(|corner| points[corner as usize]);
            let centre: [f64; 2] = std::array::from_fn(|axis| (p[axis] + q[axis] + r[axis]) / 3.0);
            if centre[0].hypot(centre[1]) > 1.3 * radius_mm {
                continue;
            }
            let (to_q, to_r) = (minus(q, p), minus(r, p));
            let normal = [
                to_q[1] * to_r[2] - to_q[2] * to_r[1],
                to_q[2] * to_r[0] - to_q[0] * to_r[2],
                to_q[0] * to_r[1] - to_q[1] * to_r[0],
            ];
            let area_mm2 = 0.5 * normal.iter().map(|it| it * it).sum::<f64>().sqrt();
            for _ in 0..PLACES {
                // Even over the square, and elsewhere in each triangle: M. Roberts's sequence of two coordinates.
                number += 1;
                let [u, v] = [0.754_877_666_246_693, 0.569_840_290_998_053]
                    .map(|step| (f64::from(number) * step).fract());
                // The upper half of the square is turned into the lower one.
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let at: PointMm =
                    std::array::from_fn(|axis| p[axis] + u * to_q[axis] + v * to_r[axis]);
                if at[0].hypot(at[1]) <= radius_mm {
                    let weight = area_mm2 / f64::from(PLACES);
                    places.push([squares.nearest_mm(at), lfs_mm(at[0], at[1]), weight]);
                }
            }
        }
        Truth { places }
    }

    fn percentile(&self, share: f64, of: impl Fn(&[f64; 3]) -> f64) -> f64 {
        let mut sorted: Vec<(f64, f64)> = self.places.iter().map(|it| (of(it), it[2])).collect();
        sorted.sort_by(|left, right| left.0.total_cmp(&right.0));
        let wanted = share * sorted.iter().map(|it| it.1).sum::<f64>();
        let mut held = 0.0;
        let found = sorted.iter().find(|it| {
            held += it.1;
            held >= wanted
        });
        found.expect("places make up all of the area").0
    }

    fn share_within(&self, epsilon: f64) -> f64 {
        let area = |all: bool| -> f64 {
            let counts = |it: &&[f64; 3]| all || it[0] <= epsilon * it[1];
            self.places.iter().filter(counts).map(|it| it[2]).sum()
        };
        area(false) / area(true)
    }
}

/// Places of a triangle.
const PLACES: u32 = 100;

fn minus(p: PointMm, q: PointMm) -> PointMm {
    std::array::from_fn(|axis| p[axis] - q[axis])
}

/// Samples in squares of the plane.
pub(crate) struct Squares<'a> {
    points: &'a [PointMm],
    size_mm: f64,
    reach: i64,
    of_square: std::collections::HashMap<[i64; 2], Vec<usize>>,
}

impl<'a> Squares<'a> {
    pub(crate) fn new(points: &'a [PointMm], radius_mm: f64) -> Squares<'a> {
        let size_mm = 2.0 * radius_mm / (points.len() as f64).sqrt();
        let mut found =
            Squares { points, size_mm, reach: 1, of_square: std::collections::HashMap::new() };
        for (index, point) in points.iter().enumerate() {
            found.of_square.entry(found.square(point)).or_default().push(index);
        }
        found
    }

    fn square(&self, point: &PointMm) -> [i64; 2] {
        [0, 1].map(|axis| (point[axis] / self.size_mm).floor() as i64)
    }

    pub(crate) fn nearest_mm(&self, at: PointMm) -> f64 {
        let [column, row] = self.square(&at);
        let mut reach = self.reach;
        loop {
            let mut nearest = f64::INFINITY;
            for i in -reach..=reach {
                for j in -reach..=reach {
                    for &index in self.of_square.get(&[column + i, row + j]).into_iter().flatten() {
                        let way = minus(self.points[index], at);
                        nearest = nearest.min(way.iter().map(|it| it * it).sum::<f64>().sqrt());
                    }
                }
            }
            // Whatever is in no square looked at is farther.
            if nearest <= reach as f64 * self.size_mm {
                return nearest;
            }
            reach += 1;
        }
    }
}

fn meshed(places: impl IntoIterator<Item = [f64; 2]>, height: impl Fn(f64, f64) -> f64) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.extend(places.into_iter().map(|[x, y]| [x, y, height(x, y)]));
    mesh.flush();
    mesh
}

fn found(
    mesh: &Mesh,
    radius_mm: f64,
    epsilon: f64,
    lfs_mm: impl Fn(f64, f64) -> f64 + Sync,
) -> Coverage {
    let aperture = Aperture::circle([0.0; 2], radius_mm).expect("a circle is an aperture");
    let target = Target::epsilon(epsilon);
    cover(mesh.points(), &mesh.triangles(), &[], Some(&aperture), &target, |x, y| {
        Some(lfs_mm(x, y))
    })
    .expect("the target is in range")
}

/// `tolerance` is what percentiles may be too large by, as a share, beside what the grid of places leaves open.
fn assert_as_place_by_place(
    name: &str,
    mesh: &Mesh,
    tolerance: f64,
    lfs_mm: impl Fn(f64, f64) -> f64 + Sync + Copy,
) {
    let truth = Truth::new(mesh, RADIUS_MM, lfs_mm);
    let largest = truth.places.iter().map(|it| it[0] / it[1]).fold(0.0, f64::max);
    // Limits that nearly all places meet, and that many do not.
    for epsilon in [0.55 * largest, 0.8 * largest, 1.01 * largest] {
        let coverage = found(mesh, RADIUS_MM, epsilon, lfs_mm);
        let (gap, of_epsilon) = (
            coverage.gap_mm.expect("there are triangles"),
            coverage.epsilon.expect("there are triangles"),
        );
        let check = |what: &str, found: f64, expected: f64| {
            let share = found / expected;
            assert!(
                share > 0.997 && share < 1.003 + tolerance,
                "{name}, {what}: {found}, place by place {expected}"
            );
        };
        check("median gap", gap.median, truth.percentile(0.5, |it| it[0]));
        check("p99 gap", gap.p99, truth.percentile(0.99, |it| it[0]));
        check("median ε", of_epsilon.median, truth.percentile(0.5, |it| it[0] / it[1]));
        check("p99 ε", of_epsilon.p99, truth.percentile(0.99, |it| it[0] / it[1]));
        let (share, expected) =
            (coverage.coverage().expect("there is an aperture"), truth.share_within(epsilon));
        assert!(
            share <= expected + 0.002 && share >= expected - 0.003 - 0.6 * tolerance,
            "{name}, ε {epsilon}: {share} covered, place by place {expected}"
        );
        // No place is farther, and one nearly as far.
        let most = truth.percentile(1.0, |it| it[0]);
        assert!(gap.max >= most * (1.0 - 1e-9) && gap.max < 1.1 * most, "{name}: {gap:?}, {most}");
    }
}

const RADIUS_MM: f64 = 20.0;

fn scattered(count: usize) -> Vec<[f64; 2]> {
    let mut rng = Pcg64::seed_from_u64(14);
    let mut unit = || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    (0..count).map(|_| [unit(), unit()].map(|share| 3.0 * RADIUS_MM * (share - 0.5))).collect()
}

fn raster(pitch: [f64; 2], shift: f64) -> Vec<[f64; 2]> {
    let nodes = (-30..=30).flat_map(|j| (-30..=30).map(move |i| (f64::from(i), f64::from(j))));
    nodes
        .map(|(i, j)| {
            let odd = if j.rem_euclid(2.0) > 0.5 { shift } else { 0.0 };
            [pitch[0] * (i + odd), pitch[1] * j]
        })
        .collect()
}

#[test]
fn over_a_plane_gap_and_coverage_are_those_of_places() {
    let flat = |_: f64, _: f64| 0.0;
    let lfs_mm = |_: f64, _: f64| 30.0;
    assert_as_place_by_place("raster", &meshed(raster([1.0, 1.0], 0.0), flat), 0.0, lfs_mm);
    assert_as_place_by_place("oblong", &meshed(raster([0.8, 1.6], 0.0), flat), 0.0, lfs_mm);
    let hexagonal = meshed(raster([1.0, 0.75_f64.sqrt()], 0.5), flat);
    assert_as_place_by_place("hexagonal", &hexagonal, 0.0, lfs_mm);
    let spiral = (0..4000).map(|i| {
        let turn = (2.0 * TAU * f64::from(i)).sqrt();
        [turn / TAU * turn.cos(), turn / TAU * turn.sin()]
    });
    assert_as_place_by_place("spiral", &meshed(spiral, flat), 0.012, lfs_mm);
    assert_as_place_by_place("random", &meshed(scattered(4000), flat), 0.012, lfs_mm);
}

#[test]
fn over_an_ellipsoid_epsilon_is_that_of_places() {
    // Half axes 30, 30 and 25 mm: up to 37° steep over the aperture.
    let sag = |x: f64, y: f64| 25.0 - 25.0 * (1.0 - (x * x + y * y) / 900.0).max(0.1).sqrt();
    // It grows towards the rim, as that of a real one does on its flat side.
    let lfs_mm = |x: f64, y: f64| 40.0 + 0.5 * x.hypot(y);
    let regular = meshed(raster([1.0, 1.0], 0.0), sag);
    assert_as_place_by_place("raster", &regular, 0.03, lfs_mm);
    assert_as_place_by_place("random", &meshed(scattered(4000), sag), 0.03, lfs_mm);
}
