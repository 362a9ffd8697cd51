//! Faces: the short cycles of the map, an edge in at most two of them.

use std::collections::VecDeque;

/// Finds cycles of 3, 4, ... edges (section 3.1, face enumeration), with no edge in more than two.
///
/// Of cycles of a length the one with the smallest vertices comes first. `edges` and `meetings` are pairs of vertices below
/// `vertices`, in ascending order. A face starts with its smallest vertex; the second is smaller than the last.
///
/// With `meetings`, a cycle of 4 edges or more is a face only where pairs that meet, but share no edge, cut it into triangles. Around a
/// true face the cells meet within it. Across the rim of a hole they do not. Without `meetings` it is a face in any case.
pub(super) fn faces(
    vertices: usize,
    edges: &[[u32; 2]],
    meetings: Option<&[[u32; 2]]>,
    longest: usize,
) -> Vec<Vec<u32>> {
    let mut search = Search::new(vertices, edges, meetings);
    for length in 3..=longest {
        for start in 0..vertices as u32 {
            search.from(start, length);
        }
    }
    search.faces
}

/// The search for cycles.
struct Search<'a> {
    edges: &'a [[u32; 2]],
    meetings: Option<&'a [[u32; 2]]>,
    /// Neighbours of each vertex in ascending order, and the number of the edge.
    beside: Vec<Vec<(u32, u32)>>,
    /// In how many faces each edge is.
    uses: Vec<u8>,
    /// Steps back to the start, of vertices after it; `u8::MAX` of those out of reach.
    steps: Vec<u8>,
    faces: Vec<Vec<u32>>,
}

impl<'a> Search<'a> {
    fn new(vertices: usize, edges: &'a [[u32; 2]], meetings: Option<&'a [[u32; 2]]>) -> Search<'a> {
        let mut beside = vec![Vec::new(); vertices];
        for (edge, &[one, other]) in (0..).zip(edges) {
            beside[one as usize].push((other, edge));
            beside[other as usize].push((one, edge));
        }
        beside.iter_mut().for_each(|list| list.sort_unstable());
        let (uses, steps) = (vec![0; edges.len()], vec![u8::MAX; vertices]);
        Search { edges, meetings, beside, uses, steps, faces: Vec::new() }
    }

    /// Takes the cycles of a length whose smallest vertex is `start`.
    fn from(&mut self, start: u32, length: usize) {
        if !self.free(start).any(|(next, _)| next > start) {
            return;
        }
        let reached = self.reach(start, length / 2);
        let mut path = Path { vertices: vec![start], edges: Vec::new() };
        self.extend(&mut path, length);
        for vertex in reached {
            self.steps[vertex as usize] = u8::MAX;
        }
    }

    /// Edges of a vertex that are in fewer than two faces.
    fn free(&self, vertex: u32) -> impl Iterator<Item = (u32, u32)> + '_ {
        let all = self.beside[vertex as usize].iter().copied();
        all.filter(|&(_, edge)| self.uses[edge as usize] < 2)
    }

    /// Counts steps from the start along free edges and later vertices; gives the vertices met.
    fn reach(&mut self, start: u32, most: usize) -> Vec<u32> {
        let mut met = vec![start];
        self.steps[start as usize] = 0;
        let mut waiting = VecDeque::from([start]);
        while let Some(vertex) = waiting.pop_front() {
            let next = self.steps[vertex as usize] + 1;
            if usize::from(next) > most {
                break;
            }
            for index in 0..self.beside[vertex as usize].len() {
                let (other, edge) = self.beside[vertex as usize][index];
                let is_new = other > start && self.steps[other as usize] == u8::MAX;
                if is_new && self.uses[edge as usize] < 2 {
                    self.steps[other as usize] = next;
                    met.push(other);
                    waiting.push_back(other);
                }
            }
        }
        met
    }

    /// Goes on along a path, and takes it where it closes with the length.
    fn extend(&mut self, path: &mut Path, length: usize) {
        let (start, at) = (path.vertices[0], path.vertices[path.vertices.len() - 1]);
        let to_go = length - path.edges.len();
        for index in 0..self.beside[at as usize].len() {
            let (next, edge) = self.beside[at as usize][index];
            if self.uses[edge as usize] >= 2 {
                continue;
            }
            if to_go == 1 {
                // Each cycle is met in both directions.
                if next == start && path.vertices[1] < at && self.is_filled(&path.vertices) {
                    path.edges.push(edge);
                    self.take(path);
                    path.edges.pop();
                }
                continue;
            }
            let is_near = usize::from(self.steps[next as usize]) < to_go;
            if next <= start || !is_near || path.vertices.contains(&next) {
                continue;
            }
            path.vertices.push(next);
            path.edges.push(edge);
            self.extend(path, length);
            path.vertices.pop();
            path.edges.pop();
            // A face found further on may have used up what led here.
            if path.edges.iter().any(|&edge| self.uses[edge as usize] >= 2) {
                return;
            }
        }
    }

    /// Whether meetings cut a cycle into triangles. n³ time.
    fn is_filled(&self, cycle: &[u32]) -> bool {
        let Some(meetings) = self.meetings else { return true };
        let len = cycle.len();
        let meet = |from: usize, to: usize| {
            let pair = [cycle[from].min(cycle[to]), cycle[from].max(cycle[to])];
            meetings.binary_search(&pair).is_ok() && self.edges.binary_search(&pair).is_err()
        };
        // Whether the corners from one to another, with their chord, can be cut.
        let mut cuts = vec![vec![true; len]; len];
        for span in 2..len {
            for from in 0..len - span {
                let to = from + span;
                cuts[from][to] = (span + 1 == len || meet(from, to))
                    && (from + 1..to).any(|middle| cuts[from][middle] && cuts[middle][to]);
            }
        }
        cuts[0][len - 1]
    }

    fn take(&mut self, path: &Path) {
        for &edge in &path.edges {
            self.uses[edge as usize] += 1;
        }
        self.faces.push(path.vertices.clone());
    }
}

/// A path of the search: one more vertex than edges.
struct Path {
    vertices: Vec<u32>,
    edges: Vec<u32>,
}
