//! GathanG: curves with corners, each corner between two smooth pieces.

use super::gathan::{Curve, dual_mm, normal};
use crate::samples::PlaceMm;
use crate::triangulation::{EdgeId, distance_mm};
use crate::{Graph, SampleId, Triangulation};

/// GathanG: as [`super::gathan`], but with two normals a sample, and with corners only between smooth pieces.
///
/// The normals of a sample lead to the farthest vertex of its Voronoi cell, and to the farthest on the other side. On the hull the
/// first is the mean of the outward normals. A Delaunay edge is a candidate if its Voronoi edge is at least ρ times as long. It
/// agrees with an end if it is within α of the tangent there. Edges that agree with both ends by the first normals make the smooth
/// pieces, shortest first. Then candidates that touch a piece are offered: first those that agree with
/// one end by the first normal, then those that do by the second, then all, each time shortest first. So pieces meet directly, or through
/// one sample that belongs to none. An edge meets the edge there at 90° or more, at an end that it does not
/// agree with at 20° or more. It is at most four times as long as that edge: a gap stays open.
///
/// T. K. Dey, R. Wenger, *Fast reconstruction of curves with sharp corners*, International Journal of Computational Geometry and
/// Applications 12 (2002) 353-400, prove theirs right for smooth pieces with corners where samples lie evenly about each corner. The
/// text was not at hand: order, angles and defaults are ours, and nothing is proven of this form. Lengths are ordered exactly,
/// angles and Voronoi vertices are rounded. n·log n time.
///
/// # Panics
///
/// If α is not above 0 and below 90 degrees, or ρ is negative or not finite.
pub fn gathan_g(triangulation: &Triangulation, alpha_deg: f64, rho: f64) -> Graph {
    assert!(
        alpha_deg > 0.0 && alpha_deg < 90.0,
        "expected α above 0 and below 90, found {alpha_deg}"
    );
    assert!(rho.is_finite() && rho >= 0.0, "expected a finite ρ of at least 0, found {rho}");
    let normals: Vec<[PlaceMm; 2]> =
        (0..triangulation.len() as SampleId).map(|sample| normals(triangulation, sample)).collect();
    let most = alpha_deg.to_radians().sin();
    let agrees_by = |count: usize, edge: EdgeId, end: SampleId| {
        let [p, q] = triangulation.ends_mm(edge);
        normals[end as usize][..count].iter().any(|[x, y]| {
            let along = (q[0] - p[0]) * x + (q[1] - p[1]) * y;
            along.abs() <= most * distance_mm(p, q) * (x * x + y * y).sqrt()
        })
    };
    let is_candidate =
        |edge: EdgeId| dual_mm(triangulation, edge) >= rho * triangulation.length_mm(edge);
    // In the order of the edges, which lie near one another, what is asked for by length below: by one normal and by both, at each
    // end; none of an edge that is no candidate.
    let agreements: Vec<Option<[[bool; 2]; 2]>> = (0..triangulation.edges().len() as EdgeId)
        .map(|edge| {
            let by = |count| triangulation.ends(edge).map(|end| agrees_by(count, edge, end));
            is_candidate(edge).then(|| [by(1), by(2)])
        })
        .collect();
    // Candidates between samples with room by length: what finds a full sample now does so in its turn.
    let candidates = |curve: &Curve, is_wanted: &dyn Fn([[bool; 2]; 2]) -> bool| {
        let all = (0..).zip(&agreements);
        let wanted = all.filter(|(_, by)| by.is_some_and(is_wanted)).map(|(edge, _)| edge);
        let ends_have_room =
            |edge: &EdgeId| triangulation.ends(*edge).iter().all(|&end| curve.has_room(end));
        let edges: Vec<EdgeId> = wanted.filter(ends_have_room).collect();
        let sorted = triangulation.sorted_by_length(&edges).into_iter();
        sorted.filter_map(|edge| Some((edge, agreements[edge as usize]?)))
    };
    let is_even = |curve: &Curve, edge: EdgeId| {
        let ends = triangulation.ends(edge).into_iter();
        let there = ends.flat_map(|end| curve.others(end).map(|other| Some([end, other?])));
        let most_mm = there.flatten().map(|ends| MOST_RATIO * length_mm(triangulation, ends));
        most_mm.fold(f64::INFINITY, f64::min) >= triangulation.length_mm(edge)
    };
    let mut curve = Curve::new(triangulation);
    for (edge, _) in candidates(&curve, &|[by_one, _]| by_one == [true; 2]) {
        if is_even(&curve, edge) {
            curve.offer(triangulation.ends(edge), [true; 2]);
        }
    }
    let is_smooth: Vec<bool> = (0..triangulation.len() as SampleId)
        .map(|sample| curve.others(sample) != [None; 2])
        .collect();
    for wanted in [1, 2, 0] {
        let is_wanted = |by: [[bool; 2]; 2]| wanted == 0 || by[wanted - 1] != [false; 2];
        for (edge, by) in candidates(&curve, &is_wanted) {
            let ends = triangulation.ends(edge);
            // One sample at most lies between two pieces.
            let touches = ends.into_iter().any(|end| is_smooth[end as usize]);
            if touches && is_even(&curve, edge) {
                curve.offer(ends, by[0]);
            }
        }
    }
    curve.graph()
}

/// The directions of the two normals of a sample, of any length: that of [`normal`], and that to the farthest Voronoi vertex on the
/// other side; zero where there is none.
fn normals(triangulation: &Triangulation, sample: SampleId) -> [PlaceMm; 2] {
    let first = normal(triangulation, sample);
    let at = triangulation.place(sample);
    let centres = triangulation.centres_mm();
    let mut second = (0.0, first);
    for triangle in triangulation.fan(sample).sectors.into_iter().flatten() {
        let centre = centres[triangle as usize];
        let way = [centre[0] - at[0], centre[1] - at[1]];
        let far_mm = distance_mm(at, centre);
        if way[0] * first[0] + way[1] * first[1] < 0.0 && far_mm > second.0 {
            second = (far_mm, way);
        }
    }
    [first, second.1]
}

fn length_mm(triangulation: &Triangulation, ends: [SampleId; 2]) -> f64 {
    let [p, q] = ends.map(|end| triangulation.place(end));
    distance_mm(p, q)
}

/// An edge is at most so many times as long as one that it meets.
const MOST_RATIO: f64 = 4.0;
