//! The cut of every cell: loops of edge points found by walking the faces, and their triangles.
//!
//! Every face has edge points between its foreground and background corners. Each is joined to one other by a segment that
//! lies in the face; the segments of the six faces make closed loops, and each loop becomes a disc inside the cell. Only a face
//! with diagonal foreground corners (C1) leaves a choice: they stand apart, or they are joined. Two cells whose choices differ
//! on their common face leave a hole of four edge points there, which a quadrilateral closes. So every volume gives a closed
//! oriented 2-manifold: each edge point lies on one loop of each of its four cells.
//!
//! The table is made for one code of each class, and carried to the others by the symmetries of the cube, so that a turned
//! volume has the turned surface.

use std::sync::OnceLock;

use crate::cell::{EDGES, FACES, edge_between, share_face, symmetries};
use crate::codes::{Case, facts};

/// Treatment of a face whose two foreground corners are diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ambiguity {
    /// Foreground stands apart, background is joined.
    Apart,
    /// Foreground is joined, background stands apart.
    Joined,
    /// Modified marching cubes of the source: background stands apart in case-8 cells with six foreground samples, foreground
    /// everywhere else. Between the cells of a pair lies a quadrilateral.
    Paired,
}

/// The triangles of one code, as edges of the cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cut {
    /// Counter-clockwise seen from the background.
    pub(crate) triangles: Vec<[u8; 3]>,
    /// The loop that passes each edge; 255 where none does.
    pub(crate) loop_of_edge: [u8; 12],
    /// The number of loops.
    pub(crate) loops: u8,
}

/// The cuts of all codes by one rule.
pub(crate) struct Table {
    cuts: Vec<Cut>,
    rule: Ambiguity,
}

impl Table {
    /// The table of a rule, made once.
    pub(crate) fn of(rule: Ambiguity) -> &'static Table {
        static TABLES: OnceLock<[Table; 3]> = OnceLock::new();
        let tables = TABLES.get_or_init(|| {
            let apart = apart_cuts();
            let joined: Vec<Cut> = (0..256).map(|code| reversed(&apart[255 - code])).collect();
            let paired = |code: usize| {
                if joins(Ambiguity::Paired, code as u8) {
                    joined[code].clone()
                } else {
                    apart[code].clone()
                }
            };
            let paired = (0..256).map(paired).collect();
            let table = |cuts, rule| Table { cuts, rule };
            [
                table(apart, Ambiguity::Apart),
                table(joined, Ambiguity::Joined),
                table(paired, Ambiguity::Paired),
            ]
        });
        match rule {
            Ambiguity::Apart => &tables[0],
            Ambiguity::Joined => &tables[1],
            Ambiguity::Paired => &tables[2],
        }
    }

    pub(crate) fn cut(&self, code: u8) -> &Cut {
        &self.cuts[usize::from(code)]
    }

    /// Whether a cell joins the foreground on its C1 faces.
    pub(crate) fn joins(&self, code: u8) -> bool {
        joins(self.rule, code)
    }
}

fn joins(rule: Ambiguity, code: u8) -> bool {
    match rule {
        Ambiguity::Apart => false,
        Ambiguity::Joined => true,
        Ambiguity::Paired => {
            let facts = facts()[usize::from(code)];
            match facts.case {
                Case::Paired => code.count_ones() == 6,
                // Without a C1 face there is nothing to choose; the cut of the complement is taken turned round.
                _ => facts.c1_faces == 0 && code.count_ones() > 4,
            }
        }
    }
}

/// The four edges of a face in the order of the hole between a cell where foreground stands apart and one where it is joined:
/// clockwise seen from outside the former, so that it runs against the segments of both cells.
pub(crate) fn hole(code: u8, face: usize) -> [usize; 4] {
    let corners = FACES[face];
    let start = (0..4).find(|&at| code >> corners[at] & 1 == 1).unwrap_or(0);
    std::array::from_fn(|step| {
        let step = 4 - step;
        edge_between(corners[(start + step + 3) % 4], corners[(start + step) % 4])
    })
}

/// Segments of a code's faces: the edge that follows each edge on its loop. Foreground stands apart, but on the C1 faces that join it.
fn followers(code: u8, joined_faces: u8) -> [Option<usize>; 12] {
    let mut next = [None; 12];
    for (face, corners) in FACES.into_iter().enumerate() {
        let is_inside = |at: usize| code >> corners[at % 4] & 1 == 1;
        let edge = |at: usize| edge_between(corners[at % 4], corners[(at + 1) % 4]);
        if joined_faces >> face & 1 == 1 {
            // Each background corner is cut off: foreground begins behind it, and ended before it.
            let background = (0..4).filter(|&at| !is_inside(at));
            background.for_each(|at| next[edge(at)] = Some(edge(at + 3)));
            continue;
        }
        for at in 0..4 {
            if is_inside(at) && !is_inside(at + 1) {
                // Foreground ends behind `at`; it began where the walk back meets background.
                let begin = (1..4).find(|&back| !is_inside(at + 4 - back)).unwrap_or(1);
                next[edge(at + 4 - begin)] = Some(edge(at));
            }
        }
    }
    next
}

/// The loops of edges of a code; `joined_faces` are the C1 faces on which foreground is joined.
pub(crate) fn loops_of(code: u8, joined_faces: u8) -> Vec<Vec<usize>> {
    let next = followers(code, joined_faces);
    let mut is_used = [false; 12];
    let mut loops = Vec::new();
    for start in 0..12 {
        let mut around = Vec::new();
        let mut edge = start;
        while let Some(following) = next[edge].filter(|_| !is_used[edge]) {
            is_used[edge] = true;
            around.push(edge);
            edge = following;
        }
        if !around.is_empty() {
            loops.push(around);
        }
    }
    loops
}

/// The cuts of all codes, foreground apart.
fn apart_cuts() -> Vec<Cut> {
    let symmetries = symmetries();
    let facts = facts();
    let mut cuts: Vec<Option<Cut>> = vec![None; 256];
    for code in 0..=255_u8 {
        let class = facts[usize::from(code)].class;
        if cuts[usize::from(class)].is_none() {
            cuts[usize::from(class)] = Some(cut_of_class(class));
        }
        let symmetry = symmetries.iter().find(|symmetry| symmetry.code(class) == code);
        let (Some(of_class), Some(symmetry)) = (cuts[usize::from(class)].clone(), symmetry) else {
            continue;
        };
        let mut cut = Cut { loop_of_edge: [255; 12], loops: of_class.loops, triangles: Vec::new() };
        for (edge, &number) in of_class.loop_of_edge.iter().enumerate() {
            cut.loop_of_edge[symmetry.edge(edge)] = number;
        }
        cut.triangles = of_class
            .triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|edge| symmetry.edge(usize::from(edge)) as u8);
                if symmetry.is_mirror { [a, c, b] } else { [a, b, c] }
            })
            .collect();
        cuts[usize::from(code)] = Some(cut);
    }
    cuts.into_iter().map(Option::unwrap_or_default).collect()
}

fn cut_of_class(code: u8) -> Cut {
    let mut cut = Cut { loop_of_edge: [255; 12], ..Cut::default() };
    for around in loops_of(code, 0) {
        around.iter().for_each(|&edge| cut.loop_of_edge[edge] = cut.loops);
        cut.loops += 1;
        cut.triangles.extend(triangulated(&around).unwrap_or_default());
    }
    cut
}

fn reversed(cut: &Cut) -> Cut {
    let triangles = cut.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    Cut { triangles, ..cut.clone() }
}

/// The middle of an edge, twice over, in whole numbers.
fn middle(edge: usize) -> [i32; 3] {
    let [a, b] = EDGES[edge];
    std::array::from_fn(|axis| ((a >> axis & 1) + (b >> axis & 1)) as i32)
}

/// The triangulation of least area of a loop whose diagonals do not lie in a face of the cell. There the neighbour might have the
/// same one, and four triangles would meet at it. Some loops have none; foreground apart on all faces makes no such loop.
pub(crate) fn triangulated(around: &[usize]) -> Option<Vec<[u8; 3]>> {
    let count = around.len();
    // best[i][j]: least area between the vertices i and j, and the vertex that makes it.
    let mut best = vec![vec![(f64::INFINITY, 0); count]; count];
    for i in 0..count - 1 {
        best[i][i + 1].0 = 0.0;
    }
    for span in 2..count {
        for i in 0..count - span {
            let j = i + span;
            let is_side = i == 0 && j == count - 1;
            if !is_side && share_face(around[i], around[j]) {
                continue;
            }
            for k in i + 1..j {
                let area = best[i][k].0 + best[k][j].0 + area([around[i], around[k], around[j]]);
                if area < best[i][j].0 - 1e-9 {
                    best[i][j] = (area, k);
                }
            }
        }
    }
    if best[0][count - 1].0.is_infinite() {
        return None;
    }
    let mut triangles = Vec::with_capacity(count - 2);
    let mut spans = vec![(0, count - 1)];
    while let Some((i, j)) = spans.pop() {
        if j - i >= 2 {
            let k = best[i][j].1;
            triangles.push([around[i], around[k], around[j]].map(|edge| edge as u8));
            spans.extend([(i, k), (k, j)]);
        }
    }
    Some(triangles)
}

fn area(edges: [usize; 3]) -> f64 {
    let [a, b, c] = edges.map(middle);
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|axis| f64::from(p[axis] - a[axis])));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    cross.iter().map(|side| side * side).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Every loop becomes a disc: as many triangles as corners less two, inner edges used twice in both directions, and none of
    /// them in a face.
    #[test]
    fn every_loop_becomes_a_disc_inside_the_cell() {
        for rule in [Ambiguity::Apart, Ambiguity::Joined, Ambiguity::Paired] {
            for code in 0..=255_u8 {
                let cut = Table::of(rule).cut(code);
                let mut directed = BTreeMap::new();
                for &[a, b, c] in &cut.triangles {
                    for side in [[a, b], [b, c], [c, a]] {
                        assert!(directed.insert(side, ()).is_none(), "{code:08b} {side:?}");
                    }
                }
                let corners = cut.loop_of_edge.iter().filter(|&&number| number != 255).count();
                assert_eq!(cut.triangles.len(), corners - 2 * usize::from(cut.loops), "{code:08b}");
                for &[a, b] in directed.keys() {
                    let is_inner = directed.contains_key(&[b, a]);
                    assert_eq!(is_inner, !share_face(a.into(), b.into()), "{code:08b} {a} {b}");
                }
                // Exactly the mixed edges are cut.
                for (edge, [a, b]) in EDGES.into_iter().enumerate() {
                    let is_mixed = (code >> a ^ code >> b) & 1 == 1;
                    assert_eq!(cut.loop_of_edge[edge] != 255, is_mixed);
                }
            }
        }
    }

    #[test]
    fn the_normal_of_one_corner_points_away_from_it() {
        let cut = Table::of(Ambiguity::Apart).cut(1);
        let [a, b, c] = cut.triangles[0].map(|edge| middle(edge.into()));
        let [u, v] = [b, c].map(|p| [0, 1, 2].map(|axis| p[axis] - a[axis]));
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        assert!(normal.iter().all(|&n| n > 0), "{normal:?}");
    }
}
