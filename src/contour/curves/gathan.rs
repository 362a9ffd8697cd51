//! Gathan: curves with corners.

use super::regular::angle_rad;
use crate::samples::PlaceMm;
use crate::triangulation::{EdgeId, Fan, distance_mm};
use crate::{Graph, SampleId, Triangulation};

/// Gathan: edges along the tangents of the samples, and edges that meet in corners.
///
/// The normal of a sample leads to the farthest vertex of its Voronoi cell; on the hull it is the mean of the outward
/// normals. A Delaunay edge is a candidate if its Voronoi edge is at least ρ times as long. It agrees with an end if it is
/// within α of the tangent there. Edges that agree with both ends come first, shortest first, then those that agree with one.
/// An edge is taken if both ends have fewer than two, and if it meets the edge there at 90° or more, at an end that it does not
/// agree with at 20° or more. T. K. Dey, R. Wenger, *Reconstructing curves with sharp corners*, Computational Geometry 19 (2001)
/// 89-99; the text was not at hand: order, angles and defaults are ours. No condition is proven of it. Lengths are ordered
/// exactly, angles and Voronoi vertices are rounded. n·log n time.
///
/// # Panics
///
/// If α is not above 0 and below 90 degrees, or ρ is negative or not finite.
pub fn gathan(triangulation: &Triangulation, alpha_deg: f64, rho: f64) -> Graph {
    assert!(
        alpha_deg > 0.0 && alpha_deg < 90.0,
        "expected α above 0 and below 90, found {alpha_deg}"
    );
    assert!(rho.is_finite() && rho >= 0.0, "expected a finite ρ of at least 0, found {rho}");
    let normals: Vec<PlaceMm> =
        (0..triangulation.len() as SampleId).map(|sample| normal(triangulation, sample)).collect();
    let most = alpha_deg.to_radians().sin();
    let agrees = |edge: EdgeId, end: SampleId| {
        let [p, q] = triangulation.ends_mm(edge);
        let [x, y] = normals[end as usize];
        let along = (q[0] - p[0]) * x + (q[1] - p[1]) * y;
        along.abs() <= most * distance_mm(p, q) * (x * x + y * y).sqrt()
    };
    let is_candidate =
        |edge: EdgeId| dual_mm(triangulation, edge) >= rho * triangulation.length_mm(edge);
    // In the order of the edges, which lie near one another, what is asked for by length below: a bit for each end.
    let agreements: Vec<u8> = (0..triangulation.edges().len() as EdgeId)
        .map(|edge| {
            let at_ends = triangulation.ends(edge).map(|end| agrees(edge, end));
            if is_candidate(edge) { u8::from(at_ends[0]) | u8::from(at_ends[1]) << 1 } else { 0 }
        })
        .collect();
    let mut curve = Curve::new(triangulation);
    for wanted in [2, 1] {
        let all = (0..).zip(&agreements);
        let edges = all.filter(|(_, agreement)| agreement.count_ones() == wanted);
        let mut edges: Vec<EdgeId> = edges.map(|(edge, _)| edge).collect();
        // What finds a full sample now does so in its turn.
        edges.retain(|&edge| triangulation.ends(edge).iter().all(|&end| curve.has_room(end)));
        for edge in triangulation.sorted_by_length(&edges) {
            let agreement = agreements[edge as usize];
            curve.offer(triangulation.ends(edge), [1, 2].map(|bit| agreement & bit > 0));
        }
    }
    curve.graph()
}

/// Edges taken so far, at most two at a sample.
pub(super) struct Curve<'a> {
    triangulation: &'a Triangulation,
    others: Vec<[Option<SampleId>; 2]>,
}

impl<'a> Curve<'a> {
    /// No edges.
    pub(super) fn new(triangulation: &'a Triangulation) -> Curve<'a> {
        Curve { triangulation, others: vec![[None; 2]; triangulation.len()] }
    }

    /// The ends of the edges at a sample.
    pub(super) fn others(&self, sample: SampleId) -> [Option<SampleId>; 2] {
        self.others[sample as usize]
    }

    /// Whether a sample has fewer than two edges.
    pub(super) fn has_room(&self, sample: SampleId) -> bool {
        self.others[sample as usize][1].is_none()
    }

    /// Takes an edge if both its ends allow it.
    pub(super) fn offer(&mut self, [p, q]: [SampleId; 2], [agrees_at_p, agrees_at_q]: [bool; 2]) {
        if self.allows(p, q, agrees_at_p) && self.allows(q, p, agrees_at_q) {
            for (at, to) in [(p, q), (q, p)] {
                let others = &mut self.others[at as usize];
                *(if others[0].is_none() { &mut others[0] } else { &mut others[1] }) = Some(to);
            }
        }
    }

    /// Whether a sample has room for an edge to another, at a wide enough angle to the one it has.
    fn allows(&self, at: SampleId, to: SampleId, agrees: bool) -> bool {
        let least_deg: f64 = if agrees { 90.0 } else { 20.0 };
        match self.others[at as usize] {
            [_, Some(_)] => false,
            [None, None] => true,
            [Some(other), None] => {
                let [at, to, other] =
                    [at, to, other].map(|sample| self.triangulation.place(sample));
                other != to && angle_rad(at, to, other) >= least_deg.to_radians()
            }
        }
    }

    pub(super) fn graph(&self) -> Graph {
        let edges = (0..).zip(&self.others);
        Graph::new(
            edges.flat_map(|(at, others)| others.iter().flatten().map(move |&other| [at, other])),
        )
    }
}

/// The direction of the normal of a sample, of any length; zero where there are no triangles.
pub(super) fn normal(triangulation: &Triangulation, sample: SampleId) -> PlaceMm {
    let fan = triangulation.fan(sample);
    let at = triangulation.place(sample);
    let is_on_hull = fan.sectors.contains(&None);
    if is_on_hull {
        return normal_of_hull(triangulation, at, &fan);
    }
    let centres = triangulation.centres_mm();
    let corners = fan.sectors.iter().flatten().map(|&triangle| centres[triangle as usize]);
    let farthest = corners.fold((0.0, at), |best, corner| {
        let distance_mm = distance_mm(at, corner);
        if distance_mm > best.0 { (distance_mm, corner) } else { best }
    });
    [farthest.1[0] - at[0], farthest.1[1] - at[1]]
}

/// The mean of the outward normals of the hull at a place on it.
pub(super) fn normal_of_hull(triangulation: &Triangulation, at: PlaceMm, fan: &Fan) -> PlaceMm {
    let [Some(&first), Some(&last)] = [fan.edges.first(), fan.edges.last()] else {
        return [0.0; 2];
    };
    let sides = [first, last].map(|edge| {
        let [p, q] = triangulation.ends_mm(edge);
        let other = if p == at { q } else { p };
        let length_mm = distance_mm(at, other);
        [(other[0] - at[0]) / length_mm, (other[1] - at[1]) / length_mm]
    });
    // Outwards is right of the first hull side, which has the triangles on its left, and left of the last.
    [sides[0][1] - sides[1][1], sides[1][0] - sides[0][0]]
}

/// Length of the Voronoi edge of an edge in mm; infinite on the hull.
pub(super) fn dual_mm(triangulation: &Triangulation, edge: EdgeId) -> f64 {
    let centres = triangulation.centres_mm();
    match triangulation.edges()[edge as usize].triangles() {
        [Some(left), Some(right)] => distance_mm(centres[left as usize], centres[right as usize]),
        _ => f64::INFINITY,
    }
}
