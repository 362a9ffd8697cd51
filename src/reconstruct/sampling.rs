//! The sampling condition: how far the points are apart, as a share of the local feature size.
//!
//! In a sample of ratio ε every place of the surface has a point within ε times its distance from the medial axis. A facet has its
//! farthest places at the centre of its circle, so its ratio is the radius of that over the least feature size of its corners.
//! The feature size is estimated: the distance from the nearest pole ([`crate::poles`]).

use asphera_geometry::PointMm;

use crate::geometry::{dot, double_area, minus};
use crate::poles::Poles;

/// The sampling condition of a method, and what the points have.
#[derive(Clone, Debug, PartialEq)]
pub struct SamplingCondition {
    /// The bound that the theorem asks for.
    pub bound: f64,
    /// The largest ratio of all facets.
    pub largest: f64,
    /// Facets above the bound.
    pub above: usize,
    /// The facets of the largest ratios above the bound, the largest first: the middle of the facet and the ratio.
    pub worst: Vec<(PointMm, f64)>,
}

/// So many facets above the bound are listed.
pub const LISTED_ABOVE: usize = 16;

impl SamplingCondition {
    /// The condition for facets by numbers of places.
    pub(crate) fn of(
        places_mm: &[PointMm],
        poles: &Poles,
        facets: &[[u32; 3]],
        bound: f64,
    ) -> SamplingCondition {
        let sizes_mm = poles.feature_sizes_mm(places_mm);
        let mut largest = 0.0_f64;
        let mut over = Vec::new();
        for facet in facets {
            let least = facet.iter().map(|&at| sizes_mm[at as usize]).fold(f64::INFINITY, f64::min);
            let places = facet.map(|corner| places_mm[corner as usize]);
            let ratio = radius_mm(places) / least;
            largest = largest.max(ratio);
            // Not a number counts as above.
            let is_within = ratio <= bound;
            if !is_within {
                let middle =
                    [0, 1, 2].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / 3.0);
                over.push((middle, ratio));
            }
        }
        over.sort_by(|one, other| {
            other
                .1
                .total_cmp(&one.1)
                .then(one.0.partial_cmp(&other.0).unwrap_or(std::cmp::Ordering::Equal))
        });
        let above = over.len();
        over.truncate(LISTED_ABOVE);
        SamplingCondition { bound, largest, above, worst: over }
    }

    /// Whether all facets are within the bound.
    pub fn is_met(&self) -> bool {
        self.above == 0
    }
}

/// The radius of the circle through three places.
pub(crate) fn radius_mm([a, b, c]: [PointMm; 3]) -> f64 {
    let length = |p, q| {
        let way = minus(p, q);
        dot(way, way).sqrt()
    };
    let normal = double_area([a, b, c]);
    length(a, b) * length(b, c) * length(c, a) / (2.0 * dot(normal, normal).sqrt())
}
