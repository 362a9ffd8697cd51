//! The χ-shape.

use super::peeling::{Peeling, Verdict};
use crate::graphs::longest_spanning;
use crate::{Region, SampleId, Triangulation};

/// The χ-shape: from the convex hull the longest side of the border goes, again and again, as long as it is longer than l.
///
/// A side goes with its triangle, and only where what is left stays one simple polygon. So the region is one part without holes that
/// holds all samples. Lengths are ordered exactly, and compared with l in doubles. M. Duckham, L. Kulik, M. Worboys, A. Galton,
/// Pattern Recognition 41 (2008) 3224-3236. n·log n time.
///
/// # Panics
///
/// If l is negative or NaN.
pub fn chi_shape(triangulation: &Triangulation, length_mm: f64) -> Region {
    assert!(length_mm >= 0.0, "expected a length of at least 0, found {length_mm}");
    let mut peeling = Peeling::new(triangulation);
    peeling.peel(
        peeling.hull(),
        |side, _| triangulation.length_class(side),
        |_, ear| match triangulation.length_mm(ear.side) > length_mm {
            true => Verdict::Go,
            false => Verdict::Stay,
        },
    );
    peeling.region()
}

/// The length of share λ: the shortest edge of the triangulation for 0, the longest for 1; none without edges.
pub fn chi_length_mm(triangulation: &Triangulation, lambda: f64) -> Option<f64> {
    let by_length = triangulation.by_length();
    let [low, high] = [*by_length.first()?, *by_length.last()?];
    let [low_mm, high_mm] = [low, high].map(|edge| triangulation.length_mm(edge));
    Some(low_mm + lambda * (high_mm - low_mm))
}

/// A length from the points: half way between the longest edge of the spanning tree and the longest of the second shortest edges of
/// samples, in mm; none without edges.
///
/// The first is the least gap that must be bridged, the second the longest side that a border through all samples must have.
/// The rule is that of the authors of [`chi_shape`]; how the second length is meant is our choice.
pub fn chi_default_mm(triangulation: &Triangulation) -> Option<f64> {
    let longest = longest_spanning(triangulation)?;
    let second_mm = |sample: SampleId| {
        let spokes = triangulation.spokes(sample).iter();
        let mut edges: Vec<_> = spokes.map(|spoke| spoke.edge).collect();
        edges.sort_unstable_by_key(|&edge| triangulation.length_class(edge));
        edges.get(1).map_or(0.0, |&edge| triangulation.length_mm(edge))
    };
    let samples = 0..triangulation.len() as SampleId;
    Some(0.5 * (triangulation.length_mm(longest) + samples.map(second_mm).fold(0.0, f64::max)))
}
