//! Blocks on either side of any seam: joined or not, the triangulation is the one of all points.

use std::collections::HashSet;
use std::f64::consts::TAU;
use std::ops::Range;

use asphera_geometry::{PointMm, VertexId};
use proptest::prelude::*;

use super::super::Delaunay;
use super::super::cells::{Cells, FlatCells};
use super::Blocks;
use crate::check;
use crate::mesh::Mesh;
use crate::regressions::beside_source;

/// Points from `before` on as two blocks that share `seam`, those before it as a batch of their own.
/// Checks the whole, and says whether the blocks were joined.
fn is_joined(points: &[PointMm], before: usize, seam: Range<usize>, closed: bool) -> bool {
    let mut delaunay: Delaunay<FlatCells> = Delaunay::default();
    delaunay.insert(&points[..before], 0..before as VertexId);
    let mut points = points.to_vec();
    let [from, start, end, to] = [before, seam.start, seam.end, points.len()];
    let id = |index: usize| index as VertexId;
    let blocks = Blocks { batch: id(from)..id(to), seam: id(start)..id(end), closed };
    let missing = (2 * end).saturating_sub(delaunay.cells.len());
    let mut new = delaunay.cells.grow(missing + blocks.second_cells());
    let sheet = &mut delaunay.sheet;
    sheet.work.spare.extend(new.by_ref().take(missing));
    let joined = sheet.insert_blocks(&points, &delaunay.cells, &blocks, new);
    if !joined {
        sheet.insert(&points[..], &delaunay.cells, blocks.rest());
    }
    let mut once = Mesh::new();
    once.insert(&points);
    delaunay.close_gaps(&mut points, id(from));
    delaunay.assert_sound();
    let mut triangles: Vec<_> = delaunay.triangles().map(asphera_geometry::from_smallest).collect();
    triangles.sort_unstable();
    assert_eq!(check::delaunay(&points, triangles.iter().copied()), Ok(()));
    assert_eq!(triangles, once.triangles());
    assert_eq!(delaunay.triangle_count(), triangles.len());
    // What is inserted next finds its way, whatever cells were thrown away.
    let first = id(points.len());
    let next: Vec<PointMm> = points.iter().map(|&[x, y, z]| [x + 1e-3, y - 2e-3, z]).collect();
    points.extend(next);
    delaunay.insert(&points[..], first..id(points.len()));
    delaunay.close_gaps(&mut points, first);
    delaunay.assert_sound();
    assert_eq!(check::delaunay(&points, delaunay.triangles()), Ok(()));
    joined
}

/// Rows of points, every other one backwards, moved by up to so many pitches.
fn rows(rows: usize, columns: usize, jitter: f64) -> Vec<PointMm> {
    (0..rows * columns)
        .map(|index| {
            let (row, step) = (index / columns, index % columns);
            let column = if row % 2 == 0 { step } else { columns - 1 - step };
            let off = |salt: usize| jitter * ((index * 7 + salt) as f64 * 0.618).sin();
            [0.003 * (column as f64 + off(0)), 0.003 * (row as f64 + off(3)), 0.0]
        })
        .collect()
}

fn rotated(points: &[PointMm], angle: f64, offset: f64) -> Vec<PointMm> {
    let (sin, cos) = angle.sin_cos();
    let turned = |&[x, y, z]: &PointMm| [x * cos - y * sin + offset, x * sin + y * cos - offset, z];
    points.iter().map(turned).collect()
}

fn ring(radius: f64, count: usize) -> impl Iterator<Item = PointMm> {
    (0..count).map(move |step| {
        let angle = TAU * step as f64 / count as f64;
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    })
}

#[test]
fn rows_are_joined_at_any_of_them_but_the_outermost() {
    for jitter in [0.0, 0.05, 0.2] {
        let upright = rows(9, 11, jitter);
        for (angle, offset) in [(0.0, 0.0), (0.3, 0.0), (1.1, 1e6), (0.0, 1e9), (TAU / 4.0, 0.1)] {
            let points = rotated(&upright, angle, offset);
            let distinct: HashSet<_> = points.iter().map(|point| point.map(f64::to_bits)).collect();
            for before in [0, 11, 17, 22] {
                for row in 3..8 {
                    let joined = is_joined(&points, before, row * 11..(row + 1) * 11, false);
                    let case = format!("{jitter} {angle} {offset} {before} {row}");
                    // Far away points of different rows fall on one place.
                    assert!(joined || distinct.len() < points.len() || jitter > 0.1, "{case}");
                }
            }
        }
    }
}

#[test]
fn rings_are_joined_from_either_side() {
    let outwards: Vec<PointMm> = (1..9).flat_map(|radius| ring(f64::from(radius), 24)).collect();
    let inwards: Vec<PointMm> = outwards.iter().rev().copied().collect();
    for points in [outwards, inwards] {
        for before in [0, 24, 30] {
            for index in 2..7 {
                assert!(is_joined(&points, before, 24 * index..24 * (index + 1), true), "{index}");
            }
        }
    }
}

#[test]
fn a_spiral_is_joined_at_a_turn_and_not_elsewhere() {
    let outwards: Vec<PointMm> = (0..900)
        .map(|index| {
            let angle = (2.0 * TAU * f64::from(index)).sqrt();
            [angle / TAU * angle.cos(), angle / TAU * angle.sin(), 0.0]
        })
        .collect();
    let inwards: Vec<PointMm> = outwards.iter().rev().copied().collect();
    let mut joined = [0; 2];
    for (points, joined) in [outwards, inwards].iter().zip(&mut joined) {
        for start in (200..500).step_by(74) {
            for count in (40..110).step_by(2) {
                *joined += usize::from(is_joined(points, 100, start..start + count, true));
            }
            assert!(!is_joined(points, 100, start..start + 20, false));
        }
    }
    assert!(joined.iter().all(|&joined| joined >= 5), "{joined:?}");
}

#[test]
fn what_does_not_part_the_points_is_not_taken_for_a_seam() {
    let points = rows(9, 11, 0.0);
    // Half a row does, its last point being on the hulls of both. A row and a half does not, nor does a row
    // before those that come in the place of others.
    assert!(is_joined(&points, 0, 44..50, false));
    assert!(!is_joined(&points, 0, 44..61, false));
    let crossing: Vec<PointMm> =
        points.iter().map(|&[x, y, z]| [x, if y > 0.02 { y - 0.013 } else { y }, z]).collect();
    assert!(!is_joined(&crossing, 0, 33..44, false));
    let line: Vec<PointMm> = (0..90).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    assert!(!is_joined(&line, 0, 40..50, false));
    assert!(!is_joined(&line, 20, 40..50, true));
    // The first block has triangles, the second has none.
    let mut last = points[..33].to_vec();
    last.extend((0..20).map(|i| [0.003 * f64::from(i), 0.009, 0.0]));
    assert!(!is_joined(&last, 0, 33..44, false));
}

/// The outline would run along the line twice.
#[test]
fn a_straight_seam_may_be_led_on_by_one_block_only() {
    let mut points = rows(9, 11, 0.0);
    // Points on the line of row 5, beyond its end, at the one end or the other.
    let [near, far] = [15.0, 19.0].map(|column| [0.003 * column, points[60][1], 0.0]);
    points.insert(80, far);
    assert!(is_joined(&points, 0, 55..66, false));
    points.insert(30, near);
    assert!(!is_joined(&points, 0, 56..67, false));
    points[30] = [-0.003, points[60][1], 0.0];
    assert!(is_joined(&points, 0, 56..67, false));
}

#[test]
fn points_in_the_place_of_one_of_the_other_block_are_duplicates() {
    let mut points = rows(9, 11, 0.0);
    for (repeat, of) in [(70, 12), (45, 3), (90, 46), (20, 8), (80, 79)] {
        let mut repeated = points.clone();
        repeated[repeat] = points[of];
        is_joined(&repeated, 0, 44..55, false);
        is_joined(&repeated, 16, 44..55, false);
    }
    // In one block there may be any.
    points[80] = points[79];
    points[81] = points[79];
    points[20] = points[8];
    points[90] = points[46];
    assert!(is_joined(&points, 0, 44..55, false));
}

proptest! {
    #![proptest_config(beside_source())]

    #[test]
    fn any_points_of_a_lattice_may_be_the_seam(
        runs in prop::collection::vec(
            (0_i8..7, 0_i8..7, -1_i8..=1, -1_i8..=1, 1_usize..8),
            2..16,
        ),
        [before, start, end] in [0.0..0.5, 0.0..1.0, 0.0..1.0],
        closed: bool,
    ) {
        let points: Vec<PointMm> = runs
            .iter()
            .flat_map(|&(x, y, dx, dy, count)| {
                (0..count as i8).map(move |i| [x + i * dx, y + i * dy])
            })
            .map(|[x, y]| [f64::from(x) * 0.003, f64::from(y) * 0.003, 0.0])
            .collect();
        // Those before the batch are vertices: each place once.
        let share = |part: f64, of: usize| (part * of as f64) as usize;
        let mut seen = HashSet::new();
        let whole = share(before, points.len());
        let mut kept: Vec<PointMm> = points[..whole].to_vec();
        kept.retain(|point| seen.insert(point.map(f64::to_bits)));
        let before = kept.len();
        kept.extend(&points[whole..]);
        let start = before + share(start, kept.len() - before - 1);
        let end = start + 1 + share(end, kept.len() - start - 1);
        is_joined(&kept, before, start..end, closed);
    }

    #[test]
    fn any_points_of_rows_may_be_the_seam(
        columns in 3_usize..9,
        jitter in 0.0..0.4,
        angle in 0.0..TAU,
        before in 0_usize..20,
        seam in (0_usize..30, 1_usize..20),
        closed: bool,
        reversed: bool,
    ) {
        let mut points = rotated(&rows(9, columns, jitter), angle, 0.0);
        if reversed {
            points.reverse();
        }
        let start = (before + 1 + seam.0).min(points.len() - 1);
        let end = (start + seam.1).min(points.len());
        is_joined(&points, before, start..end, closed);
    }
}
