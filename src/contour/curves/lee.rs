//! Lee's moving least squares: noisy points brought onto a line before they are joined.

use rayon::prelude::*;

use super::hnn_crust;
use crate::graphs::{spanning, spanning_by_length};
use crate::triangulation::distance_mm;
use crate::{Graph, PlaceMm, SampleId, Samples, Triangulation};

/// A curve beside its samples: noise is taken away before they are joined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MovedCurve {
    /// The edges. Samples without one were left out.
    pub graph: Graph,
    /// Where the curve goes instead of through each sample, mm.
    pub places_mm: Vec<PlaceMm>,
    /// The standard deviation of the distances of the samples to it in mm: about the noise.
    pub sigma_mm: f64,
}

/// The curve of noisy samples: each is moved onto a parabola fitted to those about it, then few enough of them are joined by
/// [`hnn_crust`].
///
/// The samples about one are those that the minimum spanning tree reaches from it within a distance H. They count by
/// w = 2·(r/H)³ - 3·(r/H)² + 1, r their distance. A line is fitted, then a parabola over it; three times. Of the moved samples none stay nearer
/// to each other than H/6, those of most neighbours first. I.-K. Lee, Computer Aided Geometric Design 17 (2000) 161-177; the text was not
/// at hand: how H is chosen, the thinning and the joining are ours. No condition is proven. In doubles. n·m time, m the samples about one.
pub fn lee(triangulation: &Triangulation, reach_mm: f64) -> MovedCurve {
    let samples = triangulation.samples();
    let tree = Tree::new(triangulation);
    let mut places = samples.places().to_vec();
    let mut weights = vec![0.0; places.len()];
    for _ in 0..ROUNDS {
        let moved: Vec<(PlaceMm, f64)> = (0..places.len() as SampleId)
            .into_par_iter()
            .map(|sample| {
                let about = tree.about(sample, reach_mm, &places);
                Frame::fit(&places, sample, &about, reach_mm)
                    .map_or((places[sample as usize], 0.0), |frame| {
                        (frame.moved(places[sample as usize]), frame.weight)
                    })
            })
            .collect();
        (places, weights) = moved.into_iter().unzip();
    }
    let kept = thinned(&places, &weights, reach_mm / 6.0);
    let graph = joined(&places, &kept);
    let mut squares: Vec<f64> = samples
        .places()
        .iter()
        .zip(&places)
        .zip(&weights)
        .filter(|(_, weight)| **weight > 0.0)
        .map(|((&from, &to), _)| distance_mm(from, to).powi(2))
        .collect();
    squares.sort_by(f64::total_cmp);
    let sigma_mm = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    MovedCurve { graph, places_mm: places, sigma_mm }
}

/// The distance H that [`lee`] takes where none is given: the least at which the samples about most samples lie along a line, that is, at
/// which the median of their smaller over their larger spread is at most 0.15. None of fewer than eight samples.
pub fn lee_reach_mm(triangulation: &Triangulation) -> Option<f64> {
    let count = triangulation.len();
    let tree_edges = spanning_by_length(triangulation);
    let median_mm = triangulation.length_mm(*tree_edges.get(tree_edges.len() / 2)?);
    if count < LEAST || median_mm == 0.0 {
        return None;
    }
    let tree = Tree::new(triangulation);
    let places = triangulation.samples().places();
    let extent_mm = {
        let x: Vec<f64> = places.iter().map(|place| place[0]).collect();
        let y: Vec<f64> = places.iter().map(|place| place[1]).collect();
        let range = |values: &[f64]| {
            let (low, high) = values
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
            high - low
        };
        range(&x).hypot(range(&y))
    };
    let mut reach_mm = 4.0 * median_mm;
    loop {
        let mut spreads: Vec<f64> = (0..count as SampleId)
            .into_par_iter()
            .filter_map(|sample| {
                let about = tree.about(sample, reach_mm, places);
                Frame::fit(places, sample, &about, reach_mm).map(|frame| frame.spread)
            })
            .collect();
        spreads.sort_by(f64::total_cmp);
        let is_line = spreads.len() > count / 2 && spreads[spreads.len() / 2] <= 0.15;
        if is_line || reach_mm > extent_mm / 8.0 {
            return Some(reach_mm);
        }
        reach_mm *= 1.25;
    }
}

/// The neighbours of each sample in the minimum spanning tree.
struct Tree {
    others: Vec<Vec<SampleId>>,
}

impl Tree {
    fn new(triangulation: &Triangulation) -> Tree {
        let mut others = vec![Vec::new(); triangulation.len()];
        for (edge, _) in
            triangulation.edges().iter().zip(spanning(triangulation)).filter(|(_, is)| *is)
        {
            let [p, q] = edge.ends;
            others[p as usize].push(q);
            others[q as usize].push(p);
        }
        Tree { others }
    }

    /// The samples that the tree reaches from one without leaving the disc about it, and it.
    fn about(&self, sample: SampleId, reach_mm: f64, places: &[PlaceMm]) -> Vec<SampleId> {
        let centre = places[sample as usize];
        let mut found = vec![sample];
        let mut open = vec![(sample, sample)];
        while let Some((at, from)) = open.pop() {
            for &next in self.others[at as usize].iter().filter(|&&next| next != from) {
                if distance_mm(places[next as usize], centre) < reach_mm {
                    found.push(next);
                    open.push((next, at));
                }
            }
        }
        found
    }
}

/// A parabola over a line through places.
struct Frame {
    middle: PlaceMm,
    along: [f64; 2],
    terms: [f64; 3],
    /// Smaller over larger spread of the places.
    spread: f64,
    /// Sum of the weights.
    weight: f64,
}

impl Frame {
    fn fit(
        places: &[PlaceMm],
        sample: SampleId,
        about: &[SampleId],
        reach_mm: f64,
    ) -> Option<Frame> {
        if about.len() < LEAST {
            return None;
        }
        let centre = places[sample as usize];
        let weigh = |place: PlaceMm| {
            let r = distance_mm(place, centre) / reach_mm;
            (2.0 * r * r * r - 3.0 * r * r + 1.0).max(0.0)
        };
        let weighed: Vec<(PlaceMm, f64)> = about
            .iter()
            .map(|&other| places[other as usize])
            .map(|place| ([place[0] - centre[0], place[1] - centre[1]], weigh(place)))
            .collect();
        let sum = |term: &dyn Fn(PlaceMm) -> f64| -> f64 {
            weighed.iter().map(|&(place, weight)| weight * term(place)).sum()
        };
        let weight = sum(&|_| 1.0);
        let [mx, my] = [sum(&|place| place[0]) / weight, sum(&|place| place[1]) / weight];
        let xx = sum(&|[x, _]| (x - mx) * (x - mx));
        let yy = sum(&|[_, y]| (y - my) * (y - my));
        let xy = sum(&|[x, y]| (x - mx) * (y - my));
        let root = (0.5 * (xx - yy)).hypot(xy);
        let [large, small] = [0.5 * (xx + yy) + root, (0.5 * (xx + yy) - root).max(0.0)];
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let along = [angle.cos(), angle.sin()];
        let local = |[x, y]: PlaceMm| {
            let [x, y] = [(x - mx) / reach_mm, (y - my) / reach_mm];
            [along[0] * x + along[1] * y, along[0] * y - along[1] * x]
        };
        let mut normal = [[0.0; 4]; 3];
        for &(place, weight) in &weighed {
            let [s, t] = local(place);
            let row = [1.0, s, s * s];
            for i in 0..3 {
                for j in 0..3 {
                    normal[i][j] += weight * row[i] * row[j];
                }
                normal[i][3] += weight * row[i] * t;
            }
        }
        let terms = solved(normal)?;
        let middle = [centre[0] + mx, centre[1] + my];
        let terms = [terms[0] * reach_mm, terms[1], terms[2] / reach_mm];
        Some(Frame { middle, along, terms, spread: (small / large).sqrt(), weight })
    }

    /// The place on the parabola beside a place.
    fn moved(&self, place: PlaceMm) -> PlaceMm {
        let [x, y] = [place[0] - self.middle[0], place[1] - self.middle[1]];
        let s = self.along[0] * x + self.along[1] * y;
        let t = self.terms[0] + s * (self.terms[1] + s * self.terms[2]);
        [
            self.middle[0] + s * self.along[0] - t * self.along[1],
            self.middle[1] + s * self.along[1] + t * self.along[0],
        ]
    }
}

/// The solution of three linear equations by elimination with pivots; none if they are dependent.
fn solved(mut rows: [[f64; 4]; 3]) -> Option<[f64; 3]> {
    for column in 0..3 {
        let pivot = (column..3).fold(column, |best, row| {
            if rows[row][column].abs() > rows[best][column].abs() { row } else { best }
        });
        rows.swap(column, pivot);
        let lead = rows[column];
        if lead[column].abs() < 1e-12 {
            return None;
        }
        for row in rows.iter_mut().skip(column + 1) {
            let share = row[column] / lead[column];
            for (value, lead) in row.iter_mut().zip(lead) {
                *value -= share * lead;
            }
        }
    }
    let c = rows[2][3] / rows[2][2];
    let b = (rows[1][3] - rows[1][2] * c) / rows[1][1];
    let a = (rows[0][3] - rows[0][1] * b - rows[0][2] * c) / rows[0][0];
    Some([a, b, c])
}

/// Places no two of which are nearer than a distance, those of large weights first; none of weight 0.
fn thinned(places: &[PlaceMm], weights: &[f64], apart_mm: f64) -> Vec<SampleId> {
    let mut order: Vec<SampleId> = (0..places.len() as SampleId).collect();
    order.sort_by(|&a, &b| weights[b as usize].total_cmp(&weights[a as usize]).then(a.cmp(&b)));
    let cell = |[x, y]: PlaceMm| [(x / apart_mm).floor() as i64, (y / apart_mm).floor() as i64];
    let mut taken: std::collections::BTreeMap<[i64; 2], Vec<SampleId>> = Default::default();
    let mut kept = Vec::new();
    for sample in order.into_iter().filter(|&sample| weights[sample as usize] > 0.0) {
        let place = places[sample as usize];
        let [x, y] = cell(place);
        let is_near =
            (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy])).any(|cell| {
                let others = taken.get(&cell).into_iter().flatten();
                others
                    .into_iter()
                    .any(|&other| distance_mm(places[other as usize], place) < apart_mm)
            });
        if !is_near {
            taken.entry([x, y]).or_default().push(sample);
            kept.push(sample);
        }
    }
    kept.sort_unstable();
    kept
}

/// The edges between kept places that HNN-Crust finds.
fn joined(places: &[PlaceMm], kept: &[SampleId]) -> Graph {
    let chosen: Vec<PlaceMm> = kept.iter().map(|&sample| places[sample as usize]).collect();
    // Fitted places of admitted ones lie beside them.
    let Ok(samples) = Samples::new(&chosen) else { return Graph::default() };
    let edges = hnn_crust(&samples).edges_by_row(&samples);
    Graph::new(edges.into_iter().map(|edge| edge.map(|row| kept[row as usize])))
}

/// Fewest samples a parabola is fitted to.
const LEAST: usize = 8;
/// How often samples are moved.
const ROUNDS: usize = 3;
