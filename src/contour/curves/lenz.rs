//! Lenz's probe: chains that go ahead, across each other if need be.

use std::collections::BTreeSet;

use crate::samples::PlaceMm;
use crate::triangulation::distance_mm;
use crate::{Graph, SampleId, Triangulation};

/// Lenz's reconstruction: from a pair of samples that are each other's nearest a probe goes on ahead at both ends.
///
/// After an edge pq the next sample s is that of the least |qs| / cos, of those within u·|pq| of q whose way is within φ of the
/// way from p to q; cos is that of the angle between. It is the first that a disc through q meets that grows with its centre
/// ahead. Samples may be passed again, edges not: so curves may cross. T. Lenz, *How to sample and reconstruct curves with
/// unusual features*, EuroCG 2006, who claims ε < 0.48 without a proof; the text was not at hand, and the shape of the probe
/// and the defaults are ours. Decided in doubles. n·log n time on points that are about as dense everywhere.
///
/// # Panics
///
/// If u is not above 0 or not finite, or φ not above 0 and below 90 degrees.
pub fn lenz(triangulation: &Triangulation, u: f64, phi_deg: f64) -> Graph {
    assert!(u.is_finite() && u > 0.0, "expected a finite u above 0, found {u}");
    assert!(phi_deg > 0.0 && phi_deg < 90.0, "expected φ above 0 and below 90, found {phi_deg}");
    let probe = Probe { triangulation, u, cosine: phi_deg.to_radians().cos() };
    let mut edges: BTreeSet<[SampleId; 2]> = BTreeSet::new();
    let mut is_free = vec![true; triangulation.len()];
    for &seed in triangulation.by_length() {
        let [p, q] = triangulation.ends(seed);
        let leads = |from: SampleId, to: SampleId| {
            triangulation.nearest(from).is_some_and(|way| way.to == to)
        };
        if !(is_free[p as usize] && is_free[q as usize] && leads(p, q) && leads(q, p)) {
            continue;
        }
        edges.insert([p, q]);
        for end in [p, q] {
            is_free[end as usize] = false;
        }
        // An edge that one end made stops the other, so the end with the nearer step goes first.
        let step_mm = |&(from, to): &(SampleId, SampleId)| {
            probe.next(from, to).map_or(f64::INFINITY, |next| {
                distance_mm(triangulation.place(to), triangulation.place(next))
            })
        };
        let mut ways = [(p, q), (q, p)];
        ways.sort_by(|a, b| step_mm(a).total_cmp(&step_mm(b)));
        for (mut from, mut to) in ways {
            while let Some(next) = probe.next(from, to) {
                if !edges.insert([to.min(next), to.max(next)]) {
                    break;
                }
                is_free[next as usize] = false;
                (from, to) = (to, next);
            }
        }
    }
    Graph::new(edges)
}

/// What is looked for ahead.
struct Probe<'a> {
    triangulation: &'a Triangulation,
    u: f64,
    cosine: f64,
}

impl Probe<'_> {
    /// The sample that comes after the way from one to another; of equals the nearest.
    fn next(&self, from: SampleId, at: SampleId) -> Option<SampleId> {
        let [p, q] = [from, at].map(|sample| self.triangulation.place(sample));
        let step_mm = distance_mm(p, q);
        let reach_mm = self.u * step_mm;
        let mut best: Option<(f64, SampleId)> = None;
        for sample in self.triangulation.nearby(at) {
            let place = self.triangulation.place(sample);
            let distance_mm = distance_mm(q, place);
            // Those that follow are farther: none has less than its distance.
            if distance_mm > reach_mm || best.is_some_and(|(least_mm, _)| distance_mm > least_mm) {
                break;
            }
            let cosine = ahead(p, q, place) / (step_mm * distance_mm);
            let least_mm = distance_mm / cosine;
            if cosine >= self.cosine && best.is_none_or(|(found_mm, _)| least_mm < found_mm) {
                best = Some((least_mm, sample));
            }
        }
        best.map(|(_, sample)| sample)
    }
}

/// The scalar product of the ways from p to q and from q to s.
fn ahead(p: PlaceMm, q: PlaceMm, s: PlaceMm) -> f64 {
    (q[0] - p[0]) * (s[0] - q[0]) + (q[1] - p[1]) * (s[1] - q[1])
}
