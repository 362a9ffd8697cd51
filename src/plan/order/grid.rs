//! Places in square cells: the nearest of them, and a path that goes to the nearest each time.

use super::Ruler;

/// The path from node 0 that goes to the nearest place left each time.
pub(super) fn nearest_first(ruler: &Ruler) -> Vec<usize> {
    let mut grid = Grid::new(ruler);
    let mut order = Vec::with_capacity(ruler.places());
    let mut at = 0;
    while let Some(next) = grid.nearest(at, 1).first().copied() {
        grid.remove(next);
        order.push(next);
        at = next;
    }
    order
}

/// The nearest places of each node, the nearest first.
pub(super) fn neighbours(ruler: &Ruler) -> Vec<Vec<usize>> {
    let grid = Grid::new(ruler);
    (0..=ruler.places())
        .map(|node| {
            let found = grid.nearest(node, NEAR + 1).into_iter();
            found.filter(|&other| other != node).take(NEAR).collect()
        })
        .collect()
}

struct Grid<'a> {
    ruler: &'a Ruler,
    origin: [f64; 2],
    per_mm: f64,
    counts: [usize; 2],
    cells: Vec<Vec<usize>>,
}

impl Grid<'_> {
    fn new(ruler: &Ruler) -> Grid<'_> {
        let ends = |axis: usize| {
            let values = || ruler.nodes.iter().map(move |node| node[axis]);
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        };
        let [[left, right], [low, high]] = [ends(0), ends(1)];
        let side = (right - left).max(high - low).max(f64::MIN_POSITIVE);
        let cells = (0.5 * ruler.nodes.len() as f64).sqrt().ceil().clamp(1.0, 1024.0);
        let per_mm = cells / side;
        let count = |length: f64| ((length * per_mm) as usize + 1).min(1025);
        let counts = [count(right - left), count(high - low)];
        let mut grid = Grid {
            ruler,
            origin: [left, low],
            per_mm,
            counts,
            cells: vec![Vec::new(); counts[0] * counts[1]],
        };
        for node in 1..ruler.nodes.len() {
            let cell = grid.cell(node);
            grid.cells[cell].push(node);
        }
        grid
    }

    fn column_row(&self, node: usize) -> [usize; 2] {
        [0, 1].map(|axis| {
            let at = (self.ruler.nodes[node][axis] - self.origin[axis]) * self.per_mm;
            (at as usize).min(self.counts[axis] - 1)
        })
    }

    fn cell(&self, node: usize) -> usize {
        let [column, row] = self.column_row(node);
        row * self.counts[0] + column
    }

    fn remove(&mut self, node: usize) {
        let cell = self.cell(node);
        self.cells[cell].retain(|&other| other != node);
    }

    /// So many of the nearest places of a node by length and then by coordinates, itself included if it is there.
    fn nearest(&self, node: usize, wanted: usize) -> Vec<usize> {
        let centre = self.column_row(node);
        let mut found: Vec<(i64, usize)> = Vec::new();
        for ring in 0..self.counts[0].max(self.counts[1]) {
            // Beyond this ring all is at least so far.
            if found.len() >= wanted {
                found.sort_unstable();
                found.truncate(wanted);
                let within = (ring as f64 - 1.0) / self.per_mm * self.ruler.scale;
                if (found[wanted - 1].0 as f64) < within {
                    break;
                }
            }
            self.visit(centre, ring, |other| found.push((self.ruler.length(node, other), other)));
        }
        found.sort_unstable();
        found.truncate(wanted);
        found.into_iter().map(|(_, other)| other).collect()
    }

    /// Visits the places of the cells on a square ring about a cell.
    fn visit(&self, [column, row]: [usize; 2], ring: usize, mut take: impl FnMut(usize)) {
        let range = |at: usize, count: usize| at.saturating_sub(ring)..=(at + ring).min(count - 1);
        for y in range(row, self.counts[1]) {
            let whole = y.abs_diff(row) == ring;
            let mut visit = |x: usize| {
                self.cells[y * self.counts[0] + x].iter().for_each(|&node| take(node));
            };
            if whole {
                range(column, self.counts[0]).for_each(visit);
                continue;
            }
            if column >= ring {
                visit(column - ring);
            }
            if column + ring < self.counts[0] && ring > 0 {
                visit(column + ring);
            }
        }
    }
}

/// So many of the nearest places are tried.
const NEAR: usize = 8;
