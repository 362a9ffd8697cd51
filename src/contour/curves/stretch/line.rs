//! A chain of vertices that are moved along their normals.

use super::run::Run;
use crate::curves::fit_connect::fit::Fit;
use crate::samples::PlaceMm;
use crate::triangulation::distance_mm;

/// The chain.
pub(super) struct Line {
    places: Vec<PlaceMm>,
    closed: bool,
    /// Unit normals on the left.
    normals: Vec<PlaceMm>,
    /// How far each vertex may move, mm.
    reach_mm: Vec<f64>,
    /// The samples of the edge after each vertex.
    samples: Vec<Vec<PlaceMm>>,
}

impl Line {
    pub(super) fn new(places: &[PlaceMm], closed: bool, noise_mm: f64) -> Line {
        let count = places.len();
        let mut line = Line {
            places: places.to_vec(),
            closed,
            normals: Vec::new(),
            reach_mm: Vec::new(),
            samples: vec![Vec::new(); count],
        };
        for vertex in 0..count {
            let before = line.beside(vertex, -1).unwrap_or(vertex);
            let after = line.beside(vertex, 1).unwrap_or(vertex);
            line.normals.push(normal(places[before], places[after]));
            let reach_mm = if noise_mm > 0.0 { noise_mm } else { line.extent_mm(vertex) };
            line.reach_mm.push(reach_mm);
            // A vertex is a sample, too. Its edges end in it, so either may have it.
            line.samples[if after == vertex { before } else { vertex }].push(places[vertex]);
        }
        line
    }

    pub(super) fn places(&self) -> &[PlaceMm] {
        &self.places
    }

    /// Gives a sample to the nearer of the two edges of a vertex.
    pub(super) fn own(&mut self, vertex: usize, sample: PlaceMm) {
        let edges = [self.beside(vertex, -1), self.beside(vertex, 1).map(|_| vertex)];
        let off_mm = |&first: &usize| {
            let second = self.beside(first, 1).unwrap_or(first);
            let [p, q] = [self.places[first], self.places[second]];
            let share = share(p, q, sample).clamp(0.0, 1.0);
            distance_mm(sample, between(p, q, share))
        };
        let nearer = edges.into_iter().flatten().min_by(|a, b| off_mm(a).total_cmp(&off_mm(b)));
        if let Some(edge) = nearer {
            self.samples[edge].push(sample);
        }
    }

    /// The vertex some steps on; none beyond an end.
    fn beside(&self, vertex: usize, steps: isize) -> Option<usize> {
        let count = self.places.len() as isize;
        let at = vertex as isize + steps;
        match self.closed {
            true => Some(at.rem_euclid(count) as usize),
            false => (0..count).contains(&at).then_some(at as usize),
        }
    }

    /// The largest distance of the vertices about one from the circle fitted to them, mm.
    fn extent_mm(&self, vertex: usize) -> f64 {
        let mut about: Vec<usize> =
            (-WINDOW..=WINDOW).filter_map(|steps| self.beside(vertex, steps)).collect();
        about.sort_unstable();
        about.dedup();
        let [x, y] = self.places[vertex];
        let places: Vec<PlaceMm> =
            about.iter().map(|&it| [self.places[it][0] - x, self.places[it][1] - y]).collect();
        let fit = Fit::new(&places);
        places.iter().map(|&place| distance_mm(place, fit.foot(place))).fold(0.0, f64::max)
    }

    /// Moves all vertices, run by run, from the one at which the line turns most.
    pub(super) fn smooth(&mut self) {
        let count = self.places.len();
        let start = if self.closed { self.sharpest() } else { 0 };
        let mut done = 0;
        while done < count {
            let first = (start + done) % count;
            let most = (count - done).min(LONGEST_RUN);
            let mut run = vec![first];
            while run.len() < most {
                let next = (first + run.len()) % count;
                run.push(next);
                let previous = [run[run.len() - 2]];
                let ends = run.len() > 2 && self.is_sharp(previous[0]);
                if ends || !self.is_stabbed(&run) {
                    run.pop();
                    break;
                }
            }
            self.move_run(&run);
            done += run.len();
        }
    }

    /// The vertex with the largest turn; equal ones by their order along the line.
    fn sharpest(&self) -> usize {
        let count = self.places.len();
        let turn = |vertex: usize| {
            let [a, b, c] = [count - 1, 0, 1].map(|step| self.places[(vertex + step) % count]);
            let [ux, uy, vx, vy] = [b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]];
            (ux * vy - uy * vx).abs().atan2(ux * vx + uy * vy)
        };
        (0..count).fold(0, |best, next| if turn(next) > turn(best) { next } else { best })
    }

    /// Whether no line passes through the discs of a vertex and of those beside it.
    fn is_sharp(&self, vertex: usize) -> bool {
        match (self.beside(vertex, -1), self.beside(vertex, 1)) {
            (Some(before), Some(after)) => !self.is_stabbed(&[before, vertex, after]),
            _ => false,
        }
    }

    /// Whether a line passes through the discs of vertices in order.
    ///
    /// Along the way from the first to the last, the line's slope lies between bounds that each two discs set. Where one slope keeps
    /// all of them, the heights it leaves at 0 overlap in pairs, and so all have one in common.
    fn is_stabbed(&self, run: &[usize]) -> bool {
        let (Some(&first), Some(&last)) = (run.first(), run.last()) else { return true };
        let [nx, ny] = normal(self.places[first], self.places[last]);
        let local = |vertex: usize| {
            let [x, y] = [0, 1].map(|axis| self.places[vertex][axis] - self.places[first][axis]);
            [x * ny - y * nx, x * nx + y * ny]
        };
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (index, &q) in run.iter().enumerate() {
            for &p in &run[..index] {
                let ([px, py], [qx, qy]) = (local(p), local(q));
                if qx <= px {
                    return false;
                }
                let reach = self.reach_mm[p] + self.reach_mm[q];
                low = low.max((qy - py - reach) / (qx - px));
                high = high.min((qy - py + reach) / (qx - px));
            }
        }
        low <= high
    }

    fn move_run(&mut self, run: &[usize]) {
        let mut equations = Run::new(run.len());
        let unknown = |vertex: Option<usize>| {
            vertex.and_then(|vertex| run.iter().position(|&other| other == vertex))
        };
        let about = (-1..=run.len() as isize).filter_map(|step| self.beside(run[0], step));
        // A sharp vertex is no noise: its turn stays.
        for vertex in about.filter(|&vertex| !self.is_sharp(vertex)) {
            let (Some(before), Some(after)) = (self.beside(vertex, -1), self.beside(vertex, 1))
            else {
                continue;
            };
            let [p, at, q] = [before, vertex, after].map(|it| self.places[it]);
            let length = distance_mm(p, q);
            let across = normal(p, q);
            let share = share(p, q, at);
            let off = dot([at[0] - p[0], at[1] - p[1]], across);
            let terms = [(vertex, 1.0), (before, share - 1.0), (after, -share)]
                .map(|(it, by)| (unknown(Some(it)), by * dot(self.normals[it], across) / length));
            equations.bend(&terms, off / length);
        }
        let edges = (-1..run.len() as isize).filter_map(|step| self.beside(run[0], step));
        for first in edges {
            let Some(second) = self.beside(first, 1) else { continue };
            let [p, q] = [self.places[first], self.places[second]];
            let across = normal(p, q);
            for &sample in &self.samples[first] {
                let share = share(p, q, sample).clamp(0.0, 1.0);
                let foot = between(p, q, share);
                let off = dot([sample[0] - foot[0], sample[1] - foot[1]], across);
                let terms = [(first, share - 1.0), (second, -share)];
                let terms =
                    terms.map(|(it, by)| (unknown(Some(it)), by * dot(self.normals[it], across)));
                equations.balance(&terms, off);
            }
        }
        let bounds: Vec<f64> = run.iter().map(|&vertex| self.reach_mm[vertex]).collect();
        for (&vertex, way) in run.iter().zip(equations.solved(&bounds)) {
            let [x, y] = self.normals[vertex];
            let place = &mut self.places[vertex];
            *place = [place[0] + way * x, place[1] + way * y];
        }
    }
}

/// Unit normal on the left of the way between two places; zero if they are one.
fn normal(p: PlaceMm, q: PlaceMm) -> PlaceMm {
    let length = distance_mm(p, q);
    if length > 0.0 { [(p[1] - q[1]) / length, (q[0] - p[0]) / length] } else { [0.0; 2] }
}

fn dot(a: PlaceMm, b: PlaceMm) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Share of the way from one place to another at which the foot of a third lies.
fn share(p: PlaceMm, q: PlaceMm, at: PlaceMm) -> f64 {
    let way = [q[0] - p[0], q[1] - p[1]];
    let share = dot([at[0] - p[0], at[1] - p[1]], way) / dot(way, way);
    if share.is_finite() { share } else { 0.0 }
}

fn between(p: PlaceMm, q: PlaceMm, share: f64) -> PlaceMm {
    [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])]
}

/// Vertices on each side that noise is found from.
const WINDOW: isize = 4;
/// Most vertices of a run.
const LONGEST_RUN: usize = 48;
