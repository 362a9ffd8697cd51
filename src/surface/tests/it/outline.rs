//! Islands and holes against areas and counts known beforehand.

use std::f64::consts::TAU;

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::area;
use asphera_surface::{Criteria, Island, State, assess, islands};
use proptest::prelude::*;

use crate::random::Random;
use crate::shapes::{Sampled, meshed, over_square};

/// Two triangles for each cell of a picture, '#' kept: squares of 1 mm, the first line on top.
fn picture(lines: &[&str]) -> (Vec<PointMm>, Vec<[VertexId; 3]>, Vec<bool>) {
    let (rows, columns) = (lines.len(), lines[0].len());
    let points =
        (0..=rows).flat_map(|j| (0..=columns).map(move |i| [i as f64, j as f64, 0.0])).collect();
    let node = |i: usize, j: usize| (j * (columns + 1) + i) as VertexId;
    let (mut triangles, mut keep) = (Vec::new(), Vec::new());
    for (j, line) in lines.iter().rev().enumerate() {
        for (i, cell) in line.chars().enumerate() {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
            keep.extend([cell == '#'; 2]);
        }
    }
    (points, triangles, keep)
}

fn found(lines: &[&str]) -> Vec<Island> {
    let (points, triangles, keep) = picture(lines);
    islands(&points, &triangles, &keep)
}

fn holes(island: &Island) -> Vec<f64> {
    island.holes.iter().map(|hole| hole.area_mm2).collect()
}

#[test]
fn islands_and_a_hole() {
    let found = found(&["####..", "#..#.#", "#..#.#", "####.."]);
    let [ring, bar] = &found[..] else { panic!("{found:?}") };
    assert_eq!((ring.triangles, ring.vertices, ring.area_mm2), (24, 24, 12.0));
    assert_eq!((ring.outline.area_mm2, ring.outline.perimeter_mm), (16.0, 16.0));
    assert_eq!((ring.outline.min_mm, ring.outline.max_mm), ([0.0, 0.0], [4.0, 4.0]));
    let [hole] = &ring.holes[..] else { panic!("{ring:?}") };
    assert_eq!((hole.area_mm2, hole.perimeter_mm, hole.vertices.len()), (4.0, 8.0, 8));
    assert_eq!((hole.min_mm, hole.max_mm), ([1.0, 1.0], [3.0, 3.0]));
    assert_eq!((bar.triangles, bar.vertices, bar.area_mm2), (4, 6, 2.0));
    assert_eq!((bar.outline.min_mm, bar.outline.max_mm), ([5.0, 1.0], [6.0, 3.0]));
}

#[test]
fn the_island_lies_on_the_left() {
    let found = found(&["###", "#.#", "###"]);
    // From the first corner of a 3 × 3 raster of 4 × 4 nodes, counter-clockwise; the hole clockwise.
    assert_eq!(found[0].outline.vertices, [0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4]);
    assert_eq!(found[0].holes[0].vertices, [5, 9, 10, 6]);
}

#[test]
fn islands_that_touch_at_a_corner_are_two() {
    let found = found(&[".#", "#."]);
    assert_eq!(found.iter().map(|island| island.area_mm2).collect::<Vec<_>>(), [1.0, 1.0]);
    assert_eq!(found[0].outline.min_mm, [0.0, 0.0], "of equals the left one first");
    assert_eq!(found[0].vertices, 4);
}

#[test]
fn holes_that_touch_at_a_corner_are_two() {
    let found = found(&["####", "#.##", "##.#", "####"]);
    assert_eq!((found.len(), found[0].area_mm2, holes(&found[0])), (1, 14.0, vec![1.0, 1.0]));
    assert_eq!(found[0].vertices, 25);
}

#[test]
fn a_hole_that_touches_the_outline_at_a_corner_is_a_hole() {
    let found = found(&[".####", "#.###", "#.###", "#####"]);
    assert_eq!((found.len(), found[0].area_mm2), (1, 17.0));
    assert_eq!(holes(&found[0]), [2.0]);
    assert_eq!(found[0].outline.area_mm2, 19.0);
    assert_eq!(found[0].outline.vertices.len(), 18);
}

#[test]
fn four_that_meet_in_one_vertex() {
    let found = found(&["#####", "#.#.#", "##.##", "#.#.#", "#####"]);
    assert_eq!((found.len(), found[0].area_mm2), (1, 20.0));
    assert_eq!(holes(&found[0]), [1.0; 5]);
}

#[test]
fn an_island_in_a_hole() {
    let found = found(&["#####", "#...#", "#.#.#", "#...#", "#####"]);
    assert_eq!(found.iter().map(|island| island.area_mm2).collect::<Vec<_>>(), [16.0, 1.0]);
    assert_eq!(holes(&found[0]), [9.0], "with the island in it");
}

#[test]
fn nothing_kept_nothing_found() {
    assert!(found(&["..", ".."]).is_empty());
    assert!(islands(&[], &[], &[]).is_empty());
}

#[test]
fn a_disc_with_a_bore_far_from_the_origin() {
    // An annulus of radii 2 and 8 mm on a raster of 0.05 mm, a million mm away.
    let ring: Vec<PointMm> =
        over_square(Sampled::Raster { along: 400, across: 400 }, 20.0, |_, _| 0.0)
            .into_iter()
            .filter(|point| {
                let radius = (point[0] - 10.0).hypot(point[1] - 10.0);
                (2.0..8.0).contains(&radius)
            })
            .map(|[x, y, z]| [x + 1e6, y - 1e6, z])
            .collect();
    let (points, triangles) = meshed(&ring);
    let criteria = Criteria { gap_limit_mm: Some(0.1), ..Criteria::default() };
    let survey = assess(&points, triangles.iter().copied(), &criteria, |_, _| f64::INFINITY);
    let keep: Vec<bool> = survey.triangles().map(|(_, state)| state == State::Good).collect();
    let found = islands(&points, &triangles, &keep);
    let [ring] = &found[..] else { panic!("{} islands", found.len()) };
    let [bore] = &ring.holes[..] else { panic!("{} holes", ring.holes.len()) };
    let annulus = 0.5 * TAU * (64.0 - 4.0);
    assert!((ring.area_mm2 / annulus - 1.0).abs() < 0.02, "{}", ring.area_mm2);
    assert!((bore.area_mm2 / (0.5 * TAU * 4.0) - 1.0).abs() < 0.05, "{}", bore.area_mm2);
    assert_eq!(ring.vertices, points.len() as u64);
    let good = area(&points, survey.good()).projected_mm2;
    assert!((ring.area_mm2 - good).abs() < 1e-9 * good, "{} {good}", ring.area_mm2);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn areas_add_up_and_order_does_not_matter(
        seed in 0_u64..1_000,
        share in 0.3..0.9,
        count in 3_usize..400,
    ) {
        let (points, triangles) =
            meshed(&over_square(Sampled::Scattered { count, seed }, 7.0, |_, _| 0.0));
        let mut random = Random::new(seed);
        let keep: Vec<bool> = triangles.iter().map(|_| random.unit() < share).collect();
        let found = islands(&points, &triangles, &keep);
        let kept = || triangles.iter().zip(&keep).filter(|&(_, &keep)| keep).map(|(&t, _)| t);
        let expected = area(&points, kept()).projected_mm2;
        let total: f64 = found.iter().map(|island| island.area_mm2).sum();
        prop_assert!((total - expected).abs() < 1e-12 * (1.0 + 49.0));
        prop_assert_eq!(found.iter().map(|i| i.triangles).sum::<u64>(), kept().count() as u64);
        for island in &found {
            // Euler: V - E + F = 1 - holes, and each side is met twice, or once on a contour.
            let contours = island.holes.iter().chain([&island.outline]);
            let once: usize = contours.clone().map(|contour| contour.vertices.len()).sum();
            let edges = (3 * island.triangles as usize + once) / 2;
            let euler = island.vertices as i64 - edges as i64 + island.triangles as i64;
            prop_assert_eq!(euler, 1 - island.holes.len() as i64);
            for contour in contours {
                let mut vertices = contour.vertices.clone();
                vertices.sort_unstable();
                vertices.dedup();
                prop_assert_eq!(vertices.len(), contour.vertices.len(), "a vertex passed twice");
            }
        }
        let reversed: Vec<[VertexId; 3]> = triangles.iter().rev().map(|&[a, b, c]| [c, a, b]).collect();
        let keep: Vec<bool> = keep.into_iter().rev().collect();
        prop_assert_eq!(islands(&points, &reversed, &keep), found);
    }
}
