//! The petal ratio: points of an area are told from points of its border, and outliers from both.

use crate::curves::hnn_crust;
use crate::inside::Inside;
use crate::triangulation::EdgeId;
use crate::{Region, SampleId, Triangulation};

/// What points are samples of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// An area: points lie all over it.
    Area,
    /// Its border alone.
    Border,
}

/// What the petals of the samples say of them.
///
/// A sample off the hull with more than two edges is *round* if the longest is less than twice as long as the shortest. Points are of the
/// area if any sample is round. Random or noisy borders have round samples, too. S. B. Thayyil, J. Peethambaran, R. Muthuganapathy,
/// Computer Aided Geometric Design (2021); as their public program works. Linear time.
pub fn petals(triangulation: &Triangulation) -> Sampling {
    let mut is_on_hull = vec![false; triangulation.len()];
    for edge in triangulation.edges().iter().filter(|edge| edge.triangles().contains(&None)) {
        for end in edge.ends {
            is_on_hull[end as usize] = true;
        }
    }
    let is_round = |sample: SampleId| {
        let spokes = triangulation.spokes(sample);
        let lengths_mm = spokes.iter().map(|spoke| triangulation.length_mm(spoke.edge));
        let (low, high) = lengths_mm.fold((f64::INFINITY, 0.0_f64), |(low, high), length| {
            (low.min(length), high.max(length))
        });
        !is_on_hull[sample as usize] && spokes.len() > 2 && high < 2.0 * low
    };
    match (0..triangulation.len() as SampleId).any(is_round) {
        true => Sampling::Area,
        false => Sampling::Border,
    }
}

/// The region of points of an area or of a border, as [`petals`] says.
///
/// Of a border it is what [`hnn_crust`] encloses. Of an area an edge is too long at an end if it is longer than twice the shortest one there,
/// and an edge that is too long at both ends goes. All edges of a sample go, if each is too long at an end at least; or if more are too long
/// at the other end only than at none, and all those are longer than Q₃ + 1.5·(Q₃ - Q₁), Q₁ and Q₃ the quartiles of all lengths: it is an
/// outlier. An edge that went alone at both its ends comes back, unless both lie on the hull. Triangles that keep all sides are the
/// region. Proven for minimal reach samples; the source is that of [`petals`]. In doubles. Linear time but for the order of lengths.
pub fn discern(triangulation: &Triangulation) -> Region {
    if petals(triangulation) == Sampling::Border {
        return Region::enclosed(triangulation, hnn_crust(triangulation.samples()));
    }
    let shortest_mm = |sample: SampleId| {
        let nearest = triangulation.nearest(sample);
        nearest.map_or(0.0, |spoke| triangulation.length_mm(spoke.edge))
    };
    let is_long =
        |edge: EdgeId, end: SampleId| triangulation.length_mm(edge) > 2.0 * shortest_mm(end);
    let mut is_gone: Vec<bool> = (0..triangulation.edges().len() as EdgeId)
        .map(|edge| triangulation.ends(edge).into_iter().all(|end| is_long(edge, end)))
        .collect();
    let fence_mm = fence_mm(triangulation);
    for sample in 0..triangulation.len() as SampleId {
        let spokes = triangulation.spokes(sample);
        let long = |edge: EdgeId, to: SampleId| [is_long(edge, sample), is_long(edge, to)];
        let count = |wanted: [bool; 2]| {
            spokes.iter().filter(|spoke| long(spoke.edge, spoke.to) == wanted).count()
        };
        let at_none = count([false, false]);
        let mut beyond = spokes.iter().filter(|spoke| long(spoke.edge, spoke.to) == [false, true]);
        let is_outlier = at_none == 0
            || (count([false, true]) > at_none
                && beyond.all(|spoke| triangulation.length_mm(spoke.edge) > fence_mm));
        if is_outlier {
            for spoke in spokes {
                is_gone[spoke.edge as usize] = true;
            }
        }
    }
    come_back(triangulation, &mut is_gone);
    let keeps = |sides: [EdgeId; 3]| !sides.iter().any(|&side| is_gone[side as usize]);
    let triangles = 0..triangulation.triangles().len() as u32;
    let kept = triangles.map(|triangle| keeps(triangulation.sides(triangle))).collect();
    Region::of(triangulation, &Inside::of(kept))
}

/// Brings back edges that went alone at both ends.
fn come_back(triangulation: &Triangulation, is_gone: &mut [bool]) {
    let mut gone = vec![0_u32; triangulation.len()];
    let mut is_on_hull = vec![false; triangulation.len()];
    for (edge, is_gone) in triangulation.edges().iter().zip(is_gone.iter()) {
        for end in edge.ends {
            gone[end as usize] += u32::from(*is_gone);
            is_on_hull[end as usize] |= edge.triangles().contains(&None);
        }
    }
    for (edge, is_gone) in triangulation.edges().iter().zip(is_gone) {
        let is_alone = edge.ends.iter().all(|&end| gone[end as usize] == 1);
        *is_gone &= !is_alone || edge.ends.iter().all(|&end| is_on_hull[end as usize]);
    }
}

/// The length above which an edge is unusually long, mm: the upper quartile and one and a half times the distance of both (J. W.
/// Tukey, Exploratory Data Analysis, 1977).
fn fence_mm(triangulation: &Triangulation) -> f64 {
    let by_length = triangulation.by_length();
    let at = |quarters: usize| {
        let edge = by_length.get(quarters * by_length.len() / 4);
        edge.map_or(0.0, |&edge| triangulation.length_mm(edge))
    };
    at(3) + 1.5 * (at(3) - at(1))
}
