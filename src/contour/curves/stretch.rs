//! StretchDenoise: the vertices of a noisy curve are moved within their noise so that it bends least.

mod line;
mod run;

use self::line::Line;
use super::MovedCurve;
use super::fit_connect::connected;
use crate::triangulation::distance_mm;
use crate::{Chain, PlaceMm, SampleId, Triangulation};

/// The curve of [`super::fit_connect`] with its vertices moved along their normals, none farther than its noise.
///
/// The vertices are cut into runs, each as long as one line can pass through the discs of radius ν about its vertices, up to 48. A run ends
/// at a *sharp* vertex: no line passes through its disc and those of the two beside it. Over each run, in order along the curve,
///
/// Σ (dᵢ / lᵢ)² is least, while Σ eₛ = 0
///
/// dᵢ is the distance of a vertex that is not sharp from the line between the two beside it, lᵢ their distance, eₛ the signed distance of every sample to the edge
/// it belongs to: its nearest. A vertex that would move by more than ν moves by ν, and the others are found again. ν is the given noise, or
/// with 0 the largest distance of nine vertices in a row from the circle fitted to them.
///
/// S. Ohrhallinger, M. Wimmer, *StretchDenoise: parametric curve reconstruction with guarantees by separating connectivity from residual
/// uncertainty of samples*, Pacific Graphics 2018, after a description of its public program; the bound of 48, the order of the runs and ν
/// without given noise are ours. No condition is proven. In doubles. n·(k² + r²) time and n·log n, k the neighbours of `fit_connect`, r the
/// length of a run.
pub fn stretch_denoise(triangulation: &Triangulation, noise_mm: f64) -> MovedCurve {
    let (graph, is_between) = connected(triangulation);
    let mut places_mm = triangulation.samples().places().to_vec();
    let chains = graph.chains(triangulation.len());
    let owned = owned(triangulation, &chains, &is_between);
    let mut squares = Vec::new();
    for (chain, samples) in chains.iter().zip(owned) {
        if chain.samples.len() < LEAST {
            continue;
        }
        let mut line = Line::new(&chain.places_mm(triangulation.samples()), chain.closed, noise_mm);
        for (vertex, place) in samples {
            line.own(vertex, place);
        }
        line.smooth();
        for (&sample, place) in chain.samples.iter().zip(line.places()) {
            squares.push(distance_mm(places_mm[sample as usize], *place).powi(2));
            places_mm[sample as usize] = *place;
        }
    }
    squares.sort_by(f64::total_cmp);
    let sigma_mm = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    MovedCurve { graph, places_mm, sigma_mm }
}

/// For each chain the samples between its vertices that were left out, each with the place of the nearest vertex in the chain.
fn owned(
    triangulation: &Triangulation,
    chains: &[Chain],
    is_between: &[bool],
) -> Vec<Vec<(usize, PlaceMm)>> {
    let mut vertex_of: Vec<Option<(usize, usize)>> = vec![None; triangulation.len()];
    for (number, chain) in chains.iter().enumerate() {
        for (vertex, &sample) in chain.samples.iter().enumerate() {
            vertex_of[sample as usize] = Some((number, vertex));
        }
    }
    let mut owned = vec![Vec::new(); chains.len()];
    for sample in (0..is_between.len() as SampleId).filter(|&it| is_between[it as usize]) {
        let near = triangulation.nearby(sample).take(NEAR);
        let found = near.filter_map(|other| vertex_of[other as usize]).next();
        if let Some((chain, vertex)) = found {
            owned[chain].push((vertex, triangulation.place(sample)));
        }
    }
    owned
}

/// Shorter chains stay as they are.
const LEAST: usize = 5;
/// A vertex is looked for among so many nearest samples.
const NEAR: usize = 80;
