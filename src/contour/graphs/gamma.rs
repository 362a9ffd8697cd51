//! The γ-neighbourhood graph, of which the circle-based β-skeleton is a case.

use std::cmp::Ordering;

use asphera_geometry::predicates::{orientation, scalar_product};

use crate::samples::{PlaceMm, SampleId};
use crate::{Graph, Triangulation};

/// Number of samples above which graphs outside the Delaunay triangulation are not made: they ask about every pair.
pub const MOST_FOR_PAIRS: usize = 2_000;

/// The γ-neighbourhood graph for -1 ≤ γ0, γ1 ≤ 1.
///
/// γ names the disc through p and q of radius |pq| / (2·(1 - |γ|)), and on one side of pq its larger part if γ > 0, its
/// smaller one if γ < 0; ±1 is the half-plane and nothing. N is the part of γ0 on one side together with that of γ1 on the
/// other. An edge pq is one if N or its mirror image holds no sample.
///
/// | γ0, γ1 | graph |
/// |---|---|
/// | 0, 0 | [`super::gabriel`], decided exactly |
/// | γ, γ | [`beta_skeleton`] |
/// | γ, -γ | edges with an empty disc of that radius: those of an α-shape |
/// | 1, -1 | the convex hull, decided exactly |
///
/// Other values are decided in doubles. R. C. Veltkamp, Computational Geometry 1 (1992) 227-246; the text was not at hand,
/// the ranges are those of a tutorial. For γ0 + γ1 ≥ 0 it lies in the Delaunay triangulation and takes linear time. Else all
/// pairs are asked about: none for more than [`MOST_FOR_PAIRS`] samples.
pub fn gamma_neighbourhood(triangulation: &Triangulation, gamma: [f64; 2]) -> Option<Graph> {
    let [left, right] = gamma;
    if left + right >= 0.0 {
        return Some(Graph::of_edges(triangulation, |edge| {
            let [p, q] = triangulation.ends_mm(edge);
            let apexes =
                triangulation.opposite(edge).map(|apex| apex.map(|apex| triangulation.place(apex)));
            let holds = |gammas: [f64; 2]| {
                apexes
                    .iter()
                    .zip(gammas)
                    .any(|(apex, gamma)| apex.is_some_and(|apex| lies_within(apex, p, q, gamma)))
            };
            !holds([left, right]) || !holds([right, left])
        }));
    }
    if triangulation.len() > MOST_FOR_PAIRS {
        return None;
    }
    let count = triangulation.len() as SampleId;
    let is_edge = |p: SampleId, q: SampleId| {
        let [at_p, at_q] = [p, q].map(|sample| triangulation.place(sample));
        let holds = |gammas: [f64; 2]| {
            (0..count).filter(|&other| other != p && other != q).any(|other| {
                let apex = triangulation.place(other);
                match orientation(at_p, at_q, apex) {
                    Ordering::Greater => lies_within(apex, at_p, at_q, gammas[0]),
                    Ordering::Less => lies_within(apex, at_p, at_q, gammas[1]),
                    // Between the ends it lies in every disc through them.
                    Ordering::Equal => scalar_product(apex, at_p, at_q).is_lt(),
                }
            })
        };
        !holds([left, right]) || !holds([right, left])
    };
    let pairs = (0..count).flat_map(|p| (p + 1..count).map(move |q| [p, q]));
    Some(Graph::new(pairs.filter(|&[p, q]| is_edge(p, q))))
}

/// The circle-based β-skeleton for β > 0: edges pq that no sample sees under more than θ.
///
/// θ = asin(1/β) for β ≥ 1 and π - asin(β) below; β = 1 is [`super::gabriel`]. D. G. Kirkpatrick, J. D. Radke,
/// Computational Morphology (1985) 217-248. Below β = 1 it is not part of the Delaunay triangulation and all pairs are
/// asked about: none for more than [`MOST_FOR_PAIRS`] samples.
///
/// # Panics
///
/// If β is not above 0 or not finite.
pub fn beta_skeleton(triangulation: &Triangulation, beta: f64) -> Option<Graph> {
    assert!(beta.is_finite() && beta > 0.0, "expected a finite β above 0, found {beta}");
    let gamma = if beta >= 1.0 { 1.0 - 1.0 / beta } else { beta - 1.0 };
    gamma_neighbourhood(triangulation, [gamma; 2])
}

/// Whether a sample beside an edge lies in the part of the disc that γ names on its side: it sees the edge under more than
/// asin(1 - γ) for γ ≥ 0, and π - asin(1 + γ) for γ < 0.
fn lies_within(apex: PlaceMm, p: PlaceMm, q: PlaceMm, gamma: f64) -> bool {
    if gamma == 0.0 {
        return scalar_product(apex, p, q).is_lt();
    }
    let sine = 1.0 - gamma.abs();
    let cosine = (1.0 - sine * sine).sqrt().copysign(gamma);
    let [px, py, qx, qy] = [p[0] - apex[0], p[1] - apex[1], q[0] - apex[0], q[1] - apex[1]];
    let [dot, cross] = [px * qx + py * qy, (px * qy - py * qx).abs()];
    // The sine of the angle less θ, times the ways' lengths.
    match sine {
        0.0 => gamma > 0.0,
        _ => cross * cosine - dot * sine > 0.0,
    }
}
