//! Lines in batches that end within them, and what may come between two such batches.

use asphera_geometry::{PointMm, VertexId};
use proptest::prelude::*;

use crate::regressions::beside_source;
use crate::{Mesh, check};

/// How the lines of a scan lie.
#[derive(Clone, Copy, Debug)]
struct Pattern {
    columns: i32,
    pitch_mm: f64,
    /// From line to line, in pitches.
    apart: f64,
    /// How far every other line is moved along, in pitches.
    stagger: f64,
    /// By how many pitches points are moved along and across their line, at most.
    jitter: [f64; 2],
    /// Every other line backwards.
    serpentine: bool,
    /// Quarter turns.
    turns: u8,
}

const PLAIN: Pattern = Pattern {
    columns: 11,
    pitch_mm: 0.003,
    apart: 1.0,
    stagger: 0.0,
    jitter: [0.0; 2],
    serpentine: true,
    turns: 0,
};

/// Rasters, exact or nearly so, and lines so near one another that angles behind them are obtuse.
const PATTERNS: [Pattern; 8] = [
    PLAIN,
    Pattern { pitch_mm: 0.25, ..PLAIN },
    Pattern { jitter: [0.02, 0.0], apart: 1.5, ..PLAIN },
    Pattern { jitter: [0.3, 0.0], apart: 0.4, ..PLAIN },
    Pattern { jitter: [0.0, 1e-13], ..PLAIN },
    Pattern { jitter: [0.05, 0.05], ..PLAIN },
    Pattern { apart: 0.3, stagger: 0.5, ..PLAIN },
    Pattern { apart: 0.5, stagger: 0.5, pitch_mm: 1.0, ..PLAIN },
];

impl Pattern {
    /// A place given along the lines and across them, in pitches and lines.
    fn at(self, along: f64, line: f64) -> PointMm {
        let along = along + if line.rem_euclid(2.0) < 1.0 { 0.0 } else { self.stagger };
        let [x, y] = [self.pitch_mm * along, self.pitch_mm * self.apart * line];
        let [x, y] = match self.turns % 4 {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        };
        [x, y, 0.0]
    }

    /// The points of a line as they arrive.
    fn line(self, line: i32) -> Vec<PointMm> {
        let is_back = self.serpentine && line % 2 == 1;
        let column = |step: i32| if is_back { self.columns - 1 - step } else { step };
        let off = |salt: i32, column: i32| f64::from(line * 7919 + column * 31 + salt).sin();
        let place = |column: i32| {
            let [along, across] =
                [self.jitter[0] * off(0, column), self.jitter[1] * off(5, column)];
            // Staggered as the line is, wherever its points are moved.
            let [x, y, z] = self.at(f64::from(column) + along, f64::from(line));
            let [dx, dy, _] = Pattern { stagger: 0.0, apart: 1.0, ..self }.at(0.0, across);
            [x + dx, y + dy, z]
        };
        (0..self.columns).map(|step| place(column(step))).collect()
    }

    /// The column at which a line goes on after `done` points, and the step there to the next.
    fn head(self, line: i32, done: usize) -> [f64; 2] {
        let done = done as f64;
        if self.serpentine && line % 2 == 1 {
            [f64::from(self.columns) - done, -1.0]
        } else {
            [done - 1.0, 1.0]
        }
    }
}

/// Event between two batches of a line.
#[derive(Clone, Copy, Debug)]
enum Between {
    Nothing,
    /// A point in the fan.
    Inside,
    /// A point in the fan, on the line before.
    OnBase,
    /// A point before the fan.
    Beyond,
    /// A point straight on, far off.
    FarAhead,
    ApexAgain,
    ApexWithdrawn,
    BaseWithdrawn,
    /// The rest of the line from its end.
    Back,
    /// The next line first.
    Jump,
    /// A line of its own between the two, against their sense.
    Amid,
    /// A line from before the fan to behind the line before.
    Across,
    /// A line that starts beside the last points and goes on beyond the fan.
    Again,
}

const ALL: [Between; 13] = [
    Between::Nothing,
    Between::Inside,
    Between::OnBase,
    Between::Beyond,
    Between::FarAhead,
    Between::ApexAgain,
    Between::ApexWithdrawn,
    Between::BaseWithdrawn,
    Between::Back,
    Between::Jump,
    Between::Amid,
    Between::Across,
    Between::Again,
];

impl Between {
    fn happen(self, mesh: &mut Mesh, pattern: Pattern, line: i32, done: usize) {
        let [head, step] = pattern.head(line, done);
        let y = f64::from(line);
        let path = |from: [f64; 2], by: [f64; 2], count: i32| -> Vec<PointMm> {
            let at = |i: f64| pattern.at(from[0] + i * by[0], from[1] + i * by[1]);
            (0..count).map(|i| at(f64::from(i))).collect()
        };
        match self {
            Between::Nothing => {}
            Between::Inside => mesh.insert(&path([head + 2.5 * step, y - 0.75], [0.0; 2], 1)),
            Between::OnBase => mesh.insert(&path([head + 2.5 * step, y - 1.0], [0.0; 2], 1)),
            Between::Beyond => mesh.insert(&path([head + 3.0 * step, y + 1.5], [0.0; 2], 1)),
            Between::FarAhead => mesh.insert(&path([head + 40.0 * step, y], [0.0; 2], 1)),
            Between::ApexAgain => {
                let apex = *mesh.points().last().expect("there are two lines at least");
                mesh.insert(&[apex]);
            }
            Between::ApexWithdrawn => withdraw(mesh, mesh.points().len() - 1),
            Between::BaseWithdrawn => {
                let columns = pattern.columns as usize;
                withdraw(mesh, (line - 1) as usize * columns + columns / 2);
            }
            Between::Back => {
                let mut rest = pattern.line(line).split_off(done);
                rest.reverse();
                mesh.insert(&rest);
            }
            Between::Jump => mesh.insert(&pattern.line(line + 1)),
            Between::Amid => {
                mesh.insert(&path([head + 4.0 * step, y - 0.5], [-0.5 * step, 0.0], 6));
            }
            Between::Across => {
                mesh.insert(&path([head + step, y + 0.5], [0.75 * step, -0.375], 8));
            }
            Between::Again => {
                mesh.insert(&path([head - 2.25 * step, y + 0.25], [step, 0.0625], 12));
            }
        }
        assert_right(mesh);
    }
}

fn withdraw(mesh: &mut Mesh, vertex: usize) {
    let vertex = vertex as VertexId;
    if mesh.is_vertex(vertex) {
        mesh.remove(vertex).expect("it is there");
    }
}

/// The triangulation of all points at once, which is right.
fn assert_right(mesh: &Mesh) {
    mesh.assert_sound();
    let there: Vec<VertexId> = mesh.vertices().collect();
    let points: Vec<PointMm> = there.iter().map(|&vertex| mesh.points()[vertex as usize]).collect();
    let mut at_once = Mesh::new();
    at_once.insert(&points);
    assert_eq!(check::delaunay(&points, at_once.triangles()), Ok(()));
    let named = at_once.triangles().into_iter().map(|corners| corners.map(|i| there[i as usize]));
    assert!(mesh.triangles() == named.collect::<Vec<_>>(), "the triangles differ");
    let [counts, expected] = [mesh.counts(), at_once.counts()];
    assert_eq!((counts.triangles, counts.hull), (expected.triangles, expected.hull));
}

#[test]
fn whatever_comes_while_a_line_is_unfinished() {
    for pattern in PATTERNS {
        for (turns, serpentine) in (0..8).map(|i| (i % 4, i < 4)) {
            let pattern = Pattern { turns, serpentine, ..pattern };
            let lines: Vec<Vec<PointMm>> = (0..4).map(|line| pattern.line(line)).collect();
            for (cut, between) in (1..10).flat_map(|cut| ALL.map(|between| (cut, between))) {
                let mut mesh = Mesh::new();
                mesh.insert(&lines[0]);
                mesh.insert(&lines[1]);
                mesh.insert(&lines[2][..cut]);
                assert_right(&mesh);
                between.happen(&mut mesh, pattern, 2, cut);
                let next = (cut + 4).min(lines[2].len());
                mesh.insert(&lines[2][cut..next]);
                assert_right(&mesh);
                mesh.insert(&[&lines[2][next..], &lines[3][..cut]].concat());
                assert_right(&mesh);
                mesh.insert(&lines[3][cut..]);
                assert_right(&mesh);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..beside_source() })]

    #[test]
    fn lines_in_any_batches_with_anything_between(
        kind in 0..PATTERNS.len(),
        turns in 0_u8..4,
        serpentine in prop::bool::ANY,
        columns in 3_i32..40,
        batches in prop::collection::vec((1_usize..60, 0..ALL.len(), prop::bool::ANY), 2..12),
    ) {
        let pattern = Pattern { columns, turns, serpentine, ..PATTERNS[kind] };
        let lines: Vec<PointMm> = (0..12).flat_map(|line| pattern.line(line)).collect();
        let mut mesh = Mesh::new();
        let mut done = 0;
        for (batch, between, disturbed) in batches {
            let end = (done + batch).min(lines.len());
            mesh.insert(&lines[done..end]);
            done = end;
            assert_right(&mesh);
            let (line, within) = (done / columns as usize, done % columns as usize);
            if disturbed && line > 1 && within > 0 {
                ALL[between].happen(&mut mesh, pattern, line as i32, within);
            }
        }
    }
}

/// A line that ends before the last points of the line before, and the next, which ends far ahead of both: its first
/// point lies beyond the apex of the fan, and a strip beside that fan would end in a corner that is not convex.
#[test]
fn a_run_from_beyond_the_apex() {
    for turns in 0..4 {
        let pattern = Pattern { turns, columns: 21, serpentine: false, ..PATTERNS[6] };
        let mut first = [pattern.line(2), pattern.line(3), pattern.line(4)].concat();
        first.insert(22, pattern.at(40.0, 3.0));
        let mut second = pattern.line(5)[..11].to_vec();
        second.push(pattern.at(50.0, 5.0));
        let mut mesh = Mesh::new();
        for batch in [first, second] {
            mesh.insert(&batch);
            assert_right(&mesh);
        }
    }
}
