//! The α-shape: as region, and as the edges of its border.

use asphera_geometry::Sets;
use asphera_geometry::predicates::{compare_circumradius, compare_distances};
use rayon::prelude::*;

use super::radius_mm;
use crate::graphs::{is_gabriel, longest_spanning};
use crate::inside::Inside;
use crate::triangulation::TriangleId;
use crate::{Graph, Region, Triangulation};

/// The α-shape: all triangles whose circumcircle has a radius of at most α.
///
/// A disc of radius α that holds no sample cannot come into the region. Decided exactly. H. Edelsbrunner, D. G. Kirkpatrick,
/// R. Seidel, IEEE Transactions on Information Theory 29 (1983) 551-559; their α is -1/α here. Lines and single samples that
/// belong to the shape but enclose nothing are those of [`alpha_curve`]. n·log n time.
///
/// # Panics
///
/// If α is not above 0 or not finite.
pub fn alpha_shape(triangulation: &Triangulation, alpha_mm: f64) -> Region {
    Region::of(triangulation, &Inside::of(within(triangulation, alpha_mm)))
}

/// The border of the α-shape as a curve: edges with a disc of radius α through both ends that holds no sample.
///
/// Some of them part the region of [`alpha_shape`] from what lies outside, others have the outside on both sides. Decided
/// exactly; where a disc of radius α passes through three samples, an edge that only a disc with another sample on its rim shows is
/// left out. The source is that of [`alpha_shape`]. n·log n time.
///
/// # Panics
///
/// If α is not above 0 or not finite.
pub fn alpha_curve(triangulation: &Triangulation, alpha_mm: f64) -> Graph {
    let within = within(triangulation, alpha_mm);
    let kept = |triangle: Option<TriangleId>| triangle.is_some_and(|id| within[id as usize]);
    Graph::of_edges(triangulation, |edge| {
        let (ends, triangles) = {
            let it = triangulation.edges()[edge as usize];
            (it.ends, it.triangles())
        };
        match triangles.map(kept) {
            [true, true] => false,
            [false, false] => {
                // Half the edge is at most α where a step of α, and one more, reach as far as the edge.
                let [p, q] = ends.map(|end| triangulation.place(end));
                let reach = [2.0 * alpha_mm, 0.0];
                is_gabriel(triangulation, edge) && compare_distances(p, q, reach, [0.0; 2]).is_le()
            }
            _ => true,
        }
    })
}

/// The smallest α for which the region of [`alpha_shape`] is one part that all samples belong to, in mm; none without triangles.
///
/// Triangles of radii that differ by less than 10⁻¹² of their size count as equal. n·log n time.
pub fn connecting_alpha_mm(triangulation: &Triangulation) -> Option<f64> {
    connecting(triangulation, |triangle| radius_mm(triangulation, triangle))
}

/// The smallest size for which the triangles of at most that size are one part with all samples; none without triangles.
pub(super) fn connecting(
    triangulation: &Triangulation,
    size: impl Fn(TriangleId) -> f64,
) -> Option<f64> {
    let count = triangulation.triangles().len();
    let sizes: Vec<f64> = (0..count as TriangleId).map(size).collect();
    // The first size at which no sample is bare: triangles up to it are joined in any order, that of the edges, which lie near one
    // another. As a rule few are larger.
    let first = covering(triangulation, &sizes)?;
    let order = |a: f64, b: f64| a.total_cmp(&b);
    let mut sets = Sets::new(count);
    let mut is_in: Vec<bool> = sizes.iter().map(|&size| order(size, first).is_le()).collect();
    let mut parts = is_in.iter().filter(|&&is_in| is_in).count();
    for edge in triangulation.edges() {
        if let [Some(left), Some(right)] = edge.triangles().map(|it| it.map(|it| it as usize))
            && is_in[left]
            && is_in[right]
        {
            parts -= usize::from(sets.join(left, right));
        }
    }
    let larger = (0..).zip(&sizes).filter(|&(_, &size)| order(size, first).is_gt());
    let mut larger: Vec<(f64, TriangleId)> = larger.map(|(id, &size)| (size, id)).collect();
    larger.par_sort_unstable_by(|a, b| order(a.0, b.0).then(a.1.cmp(&b.1)));
    let (mut size, mut next) = (first, larger.iter().peekable());
    loop {
        let most = size * SLACK;
        if next.peek().is_none_or(|next| next.0 > most) && parts == 1 {
            return most.is_finite().then_some(most);
        }
        let &(larger, triangle) = next.next()?;
        size = larger;
        is_in[triangle as usize] = true;
        parts += 1;
        for beyond in triangulation.across(triangle).into_iter().flatten() {
            if is_in[beyond as usize] {
                parts -= usize::from(sets.join(triangle as usize, beyond as usize));
            }
        }
    }
}

/// The least size up to which every sample is a corner of a triangle; none without triangles.
fn covering(triangulation: &Triangulation, sizes: &[f64]) -> Option<f64> {
    let mut least = vec![None; triangulation.len()];
    for (corners, &size) in triangulation.triangles().iter().zip(sizes) {
        for &corner in corners {
            let least: &mut Option<f64> = &mut least[corner as usize];
            if least.is_none_or(|least| size.total_cmp(&least).is_lt()) {
                *least = Some(size);
            }
        }
    }
    least.into_iter().try_fold(f64::NEG_INFINITY, |most, least| {
        let least = least?;
        Some(if least.total_cmp(&most).is_gt() { least } else { most })
    })
}

/// Half the longest edge of the spanning tree in mm: the smallest α for which the edges of the α-shape, those within it among
/// them, join all samples; none of fewer than two samples.
pub fn joining_alpha_mm(triangulation: &Triangulation) -> Option<f64> {
    Some(0.5 * triangulation.length_mm(longest_spanning(triangulation)?) * SLACK)
}

/// Whether each triangle has a radius of at most α.
pub(super) fn within(triangulation: &Triangulation, alpha_mm: f64) -> Vec<bool> {
    assert!(
        alpha_mm.is_finite() && alpha_mm > 0.0,
        "expected a finite α above 0, found {alpha_mm}"
    );
    let triangles = triangulation.triangles().par_iter();
    triangles
        .map(|corners| {
            let places = corners.map(|corner| triangulation.place(corner));
            compare_circumradius(places, alpha_mm).is_le()
        })
        .collect()
}

/// A radius is rounded: so much more than it holds all triangles of the same.
const SLACK: f64 = 1.0 + 1e-12;
