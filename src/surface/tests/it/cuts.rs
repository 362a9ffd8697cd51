//! Cuts by planes of any direction, against brute force and figures known by formula.

use std::f64::consts::TAU;

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::Mesh;
use asphera_surface::sections::{CuttingPlane, Limit, Section, SectionPath, Source, cut, section};
use proptest::prelude::*;

use crate::patterns::jittered_raster;

fn meshed(points: &[PointMm]) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.insert(points);
    mesh
}

fn level(height_mm: f64) -> CuttingPlane {
    CuttingPlane::new([0.0, 0.0, 1.0], height_mm).expect("its normal has a direction")
}

/// Every chord, ordered, as the places of its ends.
fn chords(found: &Section) -> Vec<[[u64; 3]; 2]> {
    let pairs = found.pieces.iter().flat_map(|piece| piece.points.windows(2));
    let mut chords: Vec<[[u64; 3]; 2]> = pairs
        .map(|pair| {
            let mut ends = [pair[0], pair[1]].map(|point| point.at_mm.map(f64::to_bits));
            ends.sort_unstable();
            ends
        })
        .collect();
    chords.sort_unstable();
    chords
}

#[test]
fn a_contour_of_a_paraboloid_is_nearly_a_circle() {
    let points: Vec<PointMm> = jittered_raster(80, 0.3, 3)
        .into_iter()
        .map(|[x, y, _]| [x, y, (x - 0.2).powi(2) + (y - 0.2).powi(2)])
        .collect();
    let mesh = meshed(&points);
    let found = cut(&mesh, &level(0.01), None).unwrap();
    let [piece] = &found.pieces[..] else { panic!("{}", found.pieces.len()) };
    assert!(piece.is_closed());
    assert!((piece.length_mm() - TAU * 0.1).abs() < 1e-3 * TAU * 0.1, "{}", piece.length_mm());
    for point in &piece.points {
        assert!((point.at_mm[2] - 0.01).abs() < 1e-15);
        let away = (point.at_mm[0] - 0.2).hypot(point.at_mm[1] - 0.2);
        assert!((away - 0.1).abs() < 2e-4, "{away}");
    }
    // The corners of the square; the thin triangles along its sides are left out.
    let open = cut(&mesh, &level(0.05), Some(0.01)).unwrap();
    assert_eq!(open.pieces.len(), 4);
    for piece in &open.pieces {
        assert!(
            [piece.begins, piece.ends].iter().all(|end| [Limit::Hull, Limit::Gap].contains(end))
        );
    }
    assert!(cut(&mesh, &level(1.0), None).unwrap().pieces.is_empty());
    // Without the triangles of a hole it is broken.
    let holed: Vec<PointMm> =
        points.into_iter().filter(|[x, y, _]| (x - 0.3).hypot(y - 0.2) > 0.03).collect();
    let found = cut(&meshed(&holed), &level(0.01), Some(0.01)).unwrap();
    let [piece] = &found.pieces[..] else { panic!("{}", found.pieces.len()) };
    assert_eq!((piece.begins, piece.ends), (Limit::Gap, Limit::Gap));
}

#[test]
fn an_upright_plane_cuts_as_the_segment_does() {
    let mesh = meshed(&jittered_raster(50, 0.3, 9));
    let found = cut(&mesh, &CuttingPlane::new([3.0, -4.0, 0.0], 0.01).unwrap(), None).unwrap();
    // 3x - 4y = 0.01 from left to right.
    let path = SectionPath::Segment { from_mm: [-1.0, -0.7525], to_mm: [1.0, 0.7475] };
    let expected = section(&mesh, &path, None).unwrap();
    let ([found], [expected]) = (&found.pieces[..], &expected.pieces[..]) else {
        panic!("{} and {}", found.pieces.len(), expected.pieces.len())
    };
    assert_eq!(found.points.len(), expected.points.len());
    let same = |left: &Source, right: &Source| match (left, right) {
        (Source::Edge { edge: p, share: s }, Source::Edge { edge: q, share: t }) => {
            p == q && (s - t).abs() < 1e-9
        }
        _ => left == right,
    };
    let forth = found.points.iter().zip(&expected.points);
    let back = found.points.iter().rev().zip(&expected.points);
    assert!(
        forth.clone().all(|(p, q)| same(&p.source, &q.source))
            || back.clone().all(|(p, q)| same(&p.source, &q.source))
    );
}

/// Heights of -1, 0 and 1 on a lattice: everything happens, and nothing but by whole numbers.
fn steps(heights: &[i8], width: usize) -> Mesh {
    let points: Vec<PointMm> = heights
        .iter()
        .enumerate()
        .map(|(i, &z)| [(i % width) as f64, (i / width) as f64, f64::from(z)])
        .collect();
    meshed(&points)
}

#[test]
fn ridges_valleys_plateaus_and_crossings() {
    // A ridge in the plane, and a valley: the edges themselves, once.
    for side in [-1, 1] {
        let mesh = steps(&[side, side, side, side, 0, 0, 0, side, side, side, side, side], 4);
        let found = cut(&mesh, &level(0.0), None).unwrap();
        let [piece] = &found.pieces[..] else { panic!("{found:?}") };
        let passed: Vec<VertexId> = piece
            .points
            .iter()
            .filter_map(|point| point.source.weights().next())
            .map(|w| w.0)
            .collect();
        assert_eq!(passed, [4, 5, 6]);
        assert_eq!((piece.begins, piece.ends), (Limit::Hull, Limit::Junction));
        assert_eq!(piece.length_mm(), 2.0);
    }
    // A plateau: its border.
    let mut heights = [-1; 25];
    for i in [6, 7, 8, 11, 12, 13, 16, 17, 18] {
        heights[i] = 0;
    }
    let found = cut(&steps(&heights, 5), &level(0.0), None).unwrap();
    let [piece] = &found.pieces[..] else { panic!("{found:?}") };
    assert!(piece.is_closed());
    assert_eq!(piece.length_mm(), 8.0);
    // A saddle: the diagonals lie in the plane as well, so two loops meet at a vertex.
    let found = cut(&steps(&[1, 0, -1, 0, 0, 0, -1, 0, 1], 3), &level(0.0), None).unwrap();
    assert_eq!(found.pieces.len(), 2, "{found:?}");
    for piece in &found.pieces {
        assert_eq!((piece.begins, piece.ends), (Limit::Junction, Limit::Junction));
        assert_eq!(piece.points[0].source, Source::Vertex { vertex: 4 });
        assert!((piece.length_mm() - 2.0 - 2.0_f64.sqrt()).abs() < 1e-15);
    }
    // A peak that touches the plane, and a mesh that lies in it, have no cut.
    assert!(
        cut(&steps(&[-1, -1, -1, -1, 0, -1, -1, -1, -1], 3), &level(0.0), None)
            .unwrap()
            .pieces
            .is_empty()
    );
    assert!(cut(&steps(&[0; 9], 3), &level(0.0), None).unwrap().pieces.is_empty());
}

proptest! {
    #[test]
    fn every_chord_is_there_once_and_pieces_end_where_they_must(
        heights in prop::collection::vec(-1_i8..=1, 30),
    ) {
        let mesh = steps(&heights, 6);
        let found = cut(&mesh, &level(0.0), None).unwrap();
        // Brute force: the places where the sides of a triangle meet the plane, two different ones.
        let mut expected: Vec<[[u64; 3]; 2]> = Vec::new();
        for corners in mesh.triangles() {
            let at = corners.map(|corner| mesh.points()[corner as usize]);
            let mut places: Vec<PointMm> = Vec::new();
            for i in 0..3 {
                let (p, q) = (at[i], at[(i + 1) % 3]);
                if p[2] == 0.0 {
                    places.push(p);
                } else if p[2] * q[2] < 0.0 {
                    places.push([(p[0] + q[0]) / 2.0, (p[1] + q[1]) / 2.0, 0.0]);
                }
            }
            if let [p, q] = places[..] {
                let mut ends = [p, q].map(|place| place.map(f64::to_bits));
                ends.sort_unstable();
                expected.push(ends);
            }
        }
        expected.sort_unstable();
        expected.dedup();
        prop_assert_eq!(chords(&found), expected);
        for piece in &found.pieces {
            let ends = [&piece.points[0], &piece.points[piece.points.len() - 1]];
            prop_assert_eq!(piece.is_closed(), piece.ends == Limit::Closed);
            if piece.is_closed() {
                prop_assert_eq!(ends[0].at_mm, ends[1].at_mm);
            }
            prop_assert!(piece.begins != Limit::Gap && piece.begins != Limit::Path);
        }
    }
}
