//! Scans of every kind in batches of every size: always the same triangles, and those of others.

use std::collections::BTreeSet;

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{Mesh, check};
use proptest::prelude::*;
use spade::{DelaunayTriangulation, Point2, Triangulation};

use crate::scans::{self, Scan};

type Triangle = [[u64; 2]; 3];

/// The triangles by the places of their corners.
fn by_places(corners: impl Iterator<Item = [[f64; 2]; 3]>) -> BTreeSet<Triangle> {
    corners
        .map(|places| {
            // Zero is zero, negative or not.
            let mut bits = places.map(|place| place.map(|mm| (mm + 0.0).to_bits()));
            let first = (0..3).min_by_key(|&i| bits[i]).expect("there are three corners");
            bits.rotate_left(first);
            bits
        })
        .collect()
}

fn triangles(mesh: &Mesh) -> BTreeSet<Triangle> {
    let place = |corner: VertexId| {
        let [x, y, _] = mesh.points()[corner as usize];
        [x, y]
    };
    by_places(mesh.triangles().into_iter().map(|corners| corners.map(place)))
}

fn hull_area_mm2(spade: &DelaunayTriangulation<Point2<f64>>) -> f64 {
    let centre = spade.vertices().next().map_or(Point2::new(0.0, 0.0), |vertex| vertex.position());
    let twice = spade.convex_hull().map(|edge| {
        let [from, to] = edge.positions().map(|place| [place.x - centre.x, place.y - centre.y]);
        from[0] * to[1] - from[1] * to[0]
    });
    twice.sum::<f64>().abs() / 2.0
}

/// Delaunay, as many of everything as another triangulation has, and the same hull.
fn assert_right(scan: &Scan, mesh: &Mesh) {
    let name = &scan.name;
    assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()), "{name}");
    let places = mesh.points().iter().map(|point| Point2::new(point[0], point[1])).collect();
    let spade = DelaunayTriangulation::<Point2<f64>>::bulk_load(places).expect("they are finite");
    let counts = mesh.counts();
    assert_eq!(counts.vertices as usize, spade.num_vertices(), "{name}");
    assert_eq!(counts.vertices + counts.duplicates, scan.points.len() as u64, "{name}");
    assert_eq!(counts.triangles as usize, spade.num_inner_faces(), "{name}");
    assert_eq!(counts.triangles as usize, mesh.triangles().len(), "{name}");
    if counts.triangles > 0 {
        assert_eq!(counts.hull as usize, spade.convex_hull_size(), "{name}");
        assert_eq!(counts.edges as usize, spade.num_undirected_edges(), "{name}");
    }
    let (area, expected) = (mesh.area().projected_mm2, hull_area_mm2(&spade));
    // Rounding of coordinates relative to one of the points, and of as many products.
    let rounding = 1e-12 * (counts.vertices as f64) * expected.max(f64::MIN_POSITIVE);
    assert!((area - expected).abs() <= rounding, "{name}: {area} mm², not {expected} mm²");
    if scan.general {
        let faces =
            spade.inner_faces().map(|face| face.positions().map(|place| [place.x, place.y]));
        assert!(by_places(faces) == triangles(mesh), "{name}: the triangles differ from spade's");
    }
}

/// Batches of all sizes give what the scan at once gives, which is right.
fn assert_same_in_batches(scans: &[Scan], sizes: &[usize]) {
    for scan in scans {
        let mut at_once = Mesh::new();
        at_once.insert(&scan.points);
        assert_right(scan, &at_once);
        let expected = at_once.triangles();
        for &size in sizes {
            let mut mesh = Mesh::new();
            let batches = scan.points.len().div_ceil(size);
            for (index, batch) in scan.points.chunks(size).enumerate() {
                mesh.insert(batch);
                if index % (1 + batches / 6) == 0 {
                    let checked = check::delaunay(mesh.points(), mesh.triangles());
                    assert_eq!(checked, Ok(()), "{}: batch {index} of {size}", scan.name);
                }
            }
            assert!(mesh.points() == at_once.points(), "{} by {size}", scan.name);
            assert!(mesh.triangles() == expected, "{} by {size}", scan.name);
            assert_eq!(mesh.counts(), at_once.counts(), "{} by {size}", scan.name);
        }
        let mut backwards = Mesh::new();
        let mut turned = scan.points.clone();
        turned.reverse();
        backwards.insert(&turned);
        assert!(triangles(&backwards) == triangles(&at_once), "{} backwards", scan.name);
    }
}

#[test]
fn scans_of_every_kind() {
    assert_same_in_batches(&scans::all(), &[1, 2, 3, 7, 64, 1000]);
}

#[test]
fn far_away_minute_and_huge() {
    assert_same_in_batches(&scans::moved_and_scaled(), &[1, 2, 3, 7, 64, 1000]);
}

#[test]
fn thousands_of_points() {
    assert_same_in_batches(&scans::large(), &[7, 64, 1000]);
}

/// Points first, and then a line.
fn assert_delaunay_after_a_line(before: &[[f64; 2]], line: &[[f64; 2]]) {
    let at = |places: &[[f64; 2]]| places.iter().map(|&[x, y]| [x, y, 0.0]).collect::<Vec<_>>();
    for turns in 0..before.len() {
        let mut before = at(before);
        before.rotate_left(turns);
        let mut mesh = Mesh::new();
        for batch in [before, at(line)] {
            mesh.insert(&batch);
            assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));
        }
        let expected = triangles(&mesh);
        let mut one_by_one = Mesh::new();
        for point in mesh.points().iter().rev() {
            one_by_one.insert(&[*point]);
        }
        assert!(triangles(&one_by_one) == expected);
        // What does not show at once shows when the next points walk across it.
        for ring in [0.9, 1.5, 8.0] {
            let around = (0..40).map(|i| {
                let angle = f64::from(i) * 0.157;
                [5.0 + 6.0 * ring * angle.cos(), -1.0 + 3.0 * ring * angle.sin(), 0.0]
            });
            mesh.insert(&around.collect::<Vec<PointMm>>());
            assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));
        }
    }
}

fn level(from: f64, to: f64, y: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..9).map(move |i| [from + (to - from) * f64::from(i) / 8.0, y])
}

/// The line's first point lies beyond the triangle's far side, which the line is sewn to from inside
/// once the triangle has made way.
#[test]
fn a_line_takes_the_only_triangle_and_starts_behind_it() {
    let line: Vec<[f64; 2]> =
        [[-5.0, -0.5], [5.0, -3.0]].into_iter().chain(level(6.0, 8.0, -3.0)).collect();
    assert_delaunay_after_a_line(&[[0.0, 0.0], [10.0, 0.0], [5.0, 1.0]], &line);
}

/// All sides of the hull go: some are passed, the others are seen from the line's first point.
#[test]
fn a_line_below_all_that_starts_above_all() {
    let before = [[0.0, 0.0], [1.0, -1.0], [10.0, 0.0], [5.0, 0.1]];
    let line: Vec<[f64; 2]> =
        [[-4.0, 2.9], [0.5, -1.5]].into_iter().chain(level(1.5, 9.0, -2.0)).collect();
    assert_delaunay_after_a_line(&before, &line);
}

/// And from its last point: the sides between line's ends meet over the top.
#[test]
fn a_line_below_all_that_starts_and_ends_above_all() {
    let before = [[0.0, 0.0], [1.0, -1.0], [9.0, -1.0], [10.0, 0.0], [5.0, 0.1]];
    let line: Vec<[f64; 2]> = [[-4.0, 2.9], [0.5, -1.5]]
        .into_iter()
        .chain(level(1.5, 9.5, -2.0))
        .chain([[14.0, 2.9]])
        .collect();
    assert_delaunay_after_a_line(&before, &line);
}

/// A walk over a small lattice or a finer one beside it: straight on, turns, jumps and repeats.
fn walk() -> impl Strategy<Value = Vec<PointMm>> {
    let leg = (0_i8..12, 0_i8..12, -2_i8..=2, -2_i8..=2, 1_i8..14, 0_u8..4);
    prop::collection::vec(leg, 1..14).prop_map(|legs| {
        legs.into_iter()
            .flat_map(|(x, y, dx, dy, count, bend)| {
                (0..count).map(move |i| {
                    let off = f64::from(bend) * 0.125 * f64::from(i) * f64::from(i - count);
                    let [x, y] = [x + i * dx, y + i * dy].map(f64::from);
                    [x - off * f64::from(dy), y + off * f64::from(dx), 0.0]
                })
            })
            .collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn walks_cut_anywhere_and_turned(points in walk(), cuts in prop::collection::vec(1_usize..40, 1..8)) {
        let mut mesh = Mesh::new();
        let mut rest = &points[..];
        for &cut in cuts.iter().cycle() {
            let (batch, others) = rest.split_at(cut.min(rest.len()));
            mesh.insert(batch);
            prop_assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));
            rest = others;
            if rest.is_empty() {
                break;
            }
        }
        let mut at_once = Mesh::new();
        at_once.insert(&points);
        prop_assert_eq!(mesh.points(), at_once.points());
        prop_assert_eq!(mesh.triangles(), at_once.triangles());
        prop_assert_eq!(mesh.counts(), at_once.counts());
        let turned: Vec<PointMm> = points.iter().rev().copied().collect();
        let mut backwards = Mesh::new();
        backwards.insert(&turned);
        prop_assert!(triangles(&backwards) == triangles(&mesh));
    }
}
