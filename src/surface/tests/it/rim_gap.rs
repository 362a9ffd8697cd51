//! The largest gap and the largest ε at the rim of an aperture, against a search that knows nothing of triangles' own
//! samples: pieces of the surface are halved where they may still hold a place farther than the farthest one found.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::coverage::{Aperture, Coverage, Target, cover};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use crate::places::Squares;

/// Samples lie in a square of this half width, well beyond every aperture.
const HALF_MM: f64 = 15.0;

/// An aperture about the origin, told twice.
struct Rim {
    name: &'static str,
    aperture: Aperture,
    /// How far a place lies inside it, negative outside: no place within that distance is on the other side.
    inside_by_mm: fn([f64; 2]) -> f64,
}

fn rims() -> [Rim; 3] {
    [
        Rim {
            name: "circle",
            aperture: Aperture::circle([0.0; 2], 9.0).expect("it is sound"),
            inside_by_mm: |[x, y]| 9.0 - x.hypot(y),
        },
        Rim {
            name: "rectangle",
            aperture: Aperture::rectangle([0.0; 2], 17.0, 13.0).expect("it is sound"),
            inside_by_mm: |[x, y]| (8.5 - x.abs()).min(6.5 - y.abs()),
        },
        Rim {
            name: "annulus",
            aperture: Aperture::annulus([0.0; 2], 4.0, 10.0).expect("it is sound"),
            inside_by_mm: |[x, y]| (10.0 - x.hypot(y)).min(x.hypot(y) - 4.0),
        },
    ]
}

fn distance_mm(p: PointMm, q: PointMm) -> f64 {
    (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum::<f64>().sqrt()
}

fn middle(p: PointMm, q: PointMm) -> PointMm {
    std::array::from_fn(|axis| 0.5 * (p[axis] + q[axis]))
}

/// The largest distance of a place of the mesh in the aperture from its nearest sample, over `unit_mm` there, to
/// within a share of `STEP`.
fn farthest(mesh: &Mesh, rim: &Rim, unit_mm: fn(f64, f64) -> f64) -> f64 {
    let points = mesh.points();
    let samples: Vec<PointMm> = mesh.vertices().map(|it| points[it as usize]).collect();
    let squares = Squares::new(&samples, HALF_MM);
    let mut most = 0.0_f64;
    // Pieces by what no place of theirs is above, the largest last.
    let mut open: BTreeMap<(u64, u64), [PointMm; 3]> = BTreeMap::new();
    let mut pieces: Vec<[PointMm; 3]> =
        mesh.triangles().into_iter().map(|it| it.map(|corner| points[corner as usize])).collect();
    let mut number = 0;
    loop {
        for [p, q, r] in pieces {
            let centre: PointMm = std::array::from_fn(|axis| (p[axis] + q[axis] + r[axis]) / 3.0);
            let reaches_mm = [p, q, r].map(|corner| distance_mm(centre, corner));
            let reach_mm = reaches_mm.into_iter().fold(0.0, f64::max);
            let inside_by_mm = (rim.inside_by_mm)([centre[0], centre[1]]);
            if inside_by_mm < -reach_mm {
                continue;
            }
            let unit_mm = unit_mm(centre[0], centre[1]);
            let ratio = squares.nearest_mm(centre) / unit_mm;
            if inside_by_mm >= 0.0 {
                most = most.max(ratio);
            }
            // The unit changes by less than a hundredth of the way gone.
            let bound: f64 = ratio + 1.1 * reach_mm / unit_mm;
            number += 1;
            open.insert((bound.to_bits(), number), [p, q, r]);
        }
        let Some(((bound, _), [p, q, r])) = open.pop_last() else { return most };
        if f64::from_bits(bound) <= most * (1.0 + STEP) {
            return most;
        }
        let [pq, qr, rp] = [middle(p, q), middle(q, r), middle(r, p)];
        pieces = vec![[p, pq, rp], [pq, q, qr], [rp, qr, r], [pq, qr, rp]];
    }
}

const STEP: f64 = 1e-3;

fn scattered(count: usize, seed: u64, height: fn(f64, f64) -> f64) -> Mesh {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut unit = || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut mesh = Mesh::new();
    mesh.extend((0..count).map(|_| {
        let [x, y] = [unit(), unit()].map(|share| 2.0 * HALF_MM * (share - 0.5));
        [x, y, height(x, y)]
    }));
    mesh.flush();
    mesh
}

/// Rows whose places run from one to the next by a third of a step: obtuse triangles all along.
fn sheared(height: fn(f64, f64) -> f64) -> Mesh {
    let mut mesh = Mesh::new();
    let nodes = (-20..=20).flat_map(|j| (-20..=20).map(move |i| (f64::from(i), f64::from(j))));
    mesh.extend(nodes.map(|(i, j)| {
        let [x, y] = [1.37 * i + 0.41 * j, 0.62 * j + 0.01 * i];
        [x, y, height(x, y)]
    }));
    mesh.flush();
    mesh
}

fn covered(mesh: &Mesh, rim: &Rim, target: &Target, lfs_mm: fn(f64, f64) -> f64) -> Coverage {
    cover(mesh.points(), &mesh.triangles(), &[], Some(&rim.aperture), target, |x, y| {
        Some(lfs_mm(x, y))
    })
    .expect("the target is in range")
}

fn flat(_: f64, _: f64) -> f64 {
    0.0
}

/// 17° steep at the rim.
fn bowl(x: f64, y: f64) -> f64 {
    0.015 * (x * x + y * y)
}

fn lfs_mm(x: f64, y: f64) -> f64 {
    40.0 + 0.005 * (x - y)
}

#[test]
fn the_largest_gap_at_a_rim_is_that_of_places() {
    let mut most = 0.0_f64;
    for rim in rims() {
        let by_chance = [60, 150, 400, 1200].into_iter().flat_map(|count| {
            (0..12).flat_map(move |seed| {
                [flat as fn(f64, f64) -> f64, bowl].map(|height| {
                    (format!("{count} points, seed {seed}"), scattered(count, seed, height))
                })
            })
        });
        let sheared = [flat as fn(f64, f64) -> f64, bowl]
            .map(|height| ("sheared".to_owned(), sheared(height)));
        let thinned = (0..12).map(|seed| {
            let mut mesh = scattered(700, seed, bowl);
            (0..700).step_by(3).for_each(|vertex| {
                mesh.remove(vertex).unwrap();
            });
            (format!("with points taken out, seed {seed}"), mesh)
        });
        for (name, mesh) in by_chance.chain(sheared).chain(thinned) {
            let expected_mm = farthest(&mesh, &rim, |_, _| 1.0);
            let expected = farthest(&mesh, &rim, lfs_mm);
            // Limits that all places meet, most, and few.
            for share in [1.02, 0.8, 0.3] {
                let target = Target::spacing_mm(2.0_f64.sqrt() * share * expected_mm);
                let found = covered(&mesh, &rim, &target, lfs_mm);
                let (gap, epsilon) = (found.gap_mm.unwrap().max, found.epsilon.unwrap().max);
                for (what, found, expected) in [("gap", gap, expected_mm), ("ε", epsilon, expected)]
                {
                    most = most.max(found / expected);
                    assert!(
                        found >= expected * (1.0 - 1e-9) && found <= 1.01 * expected,
                        "{}, {name}, {what} at {share}: {found}, place by place {expected}",
                        rim.name
                    );
                }
            }
        }
    }
    eprintln!("too large by {:.2} % at most", 100.0 * (most - 1.0));
}

#[test]
fn threads_change_no_bit() {
    let mesh = scattered(40_000, 5, bowl);
    for rim in rims() {
        let target = Target::spacing_mm(0.2);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| covered(&mesh, &rim, &target, lfs_mm))
        };
        let one = with(1);
        assert!(one.patches.len() > 10);
        assert_eq!(with(4), one);
    }
}

/// Rows that end within the aperture: the hull is closed there by triangles that reach over many samples.
#[test]
fn the_largest_gap_where_a_scan_has_got_so_far_is_that_of_places() {
    const RADIUS_MM: f64 = 2.5;
    // A circle is drawn as a polygon that leaves it by at most so much.
    const DRAWN_MM: f64 = 1e-5 * RADIUS_MM;
    let mut most = 0.0_f64;
    for count in (400..2400).step_by(90) {
        let scan = |shift_mm: [f64; 2]| {
            let mut mesh = Mesh::new();
            mesh.extend((0..count).map(|index: usize| {
                let [i, j] = [index % 50, index / 50].map(|at| at as f64);
                let jitter = |k: f64| 0.06 * (k * (index as f64 + 1.0)).sin();
                let x = -4.0 + 8.0 * i / 49.0 + jitter(12.9);
                let y = -3.0 + 6.0 * j / 49.0 + jitter(78.2);
                [x + shift_mm[0], y + shift_mm[1], 1e-3 * x - 2e-3 * y]
            }));
            mesh.flush();
            mesh
        };
        let rim = Rim {
            name: "begun",
            aperture: Aperture::circle([0.0; 2], RADIUS_MM).expect("it is sound"),
            inside_by_mm: |[x, y]| RADIUS_MM - x.hypot(y),
        };
        let mesh = scan([0.0; 2]);
        let expected_mm = farthest(&mesh, &rim, |_, _| 1.0);
        for share in [1.02, 0.8, 0.3] {
            let target = Target::spacing_mm(2.0_f64.sqrt() * share * expected_mm);
            let gap_mm = |mesh: &Mesh, rim: &Rim| {
                let found = covered(mesh, rim, &target, |_, _| 40.0);
                found.gap_mm.unwrap().max
            };
            let found = gap_mm(&mesh, &rim);
            most = most.max(found / expected_mm);
            assert!(
                found >= expected_mm - DRAWN_MM && found <= 1.01 * expected_mm,
                "{count} points at {share}: {found}, place by place {expected_mm}"
            );
            let shift_mm = [37.3, -112.9];
            let aperture = Aperture::circle(shift_mm, RADIUS_MM).expect("it is sound");
            let moved = gap_mm(&scan(shift_mm), &Rim { aperture, ..rim });
            assert!((moved / found - 1.0).abs() < 1e-9, "{found} here, {moved} there");
        }
    }
    eprintln!("too large by {:.2} % at most", 100.0 * (most - 1.0));
}
