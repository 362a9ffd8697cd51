//! Geodesic distances: along the surface that the places sample.
//!
//! Shortest paths along the edges of a neighbour graph are too long by a few percent, however dense the places are. So
//! fronts also cross the triangles of neighbouring places: the two corners that the front has passed are unfolded into the
//! plane of the third, with the source behind them (M. Novotni, R. Klein, Journal of WSCG 10 (2002), "Computing geodesic
//! distances on triangular meshes", section 4). No mesh is needed: any two neighbours of a place may be corners.

mod front;

use front::sweep;

use super::ring::Rings;
use super::{Field, FunctionError};
use crate::cloud::{Cloud, PlaceId};
use crate::nearest::Nearest;
use crate::tree::squared_distance;

/// The distance from the nearest of some sources along the surface in mm. n·log n time with a factor of k².
///
/// `nearest` are neighbours of the cloud, some 12 of each place. In a part of the cloud that holds no source the place nearest to the
/// first source, straight on, is one.
///
/// # Errors
///
/// No source, or a source that is no place.
pub fn geodesic<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
    sources: &[PlaceId],
) -> Result<Field, FunctionError> {
    check(cloud, sources)?;
    let rings = Rings::new(cloud, nearest);
    let sources = with_a_source_each(cloud, &rings, sources);
    Ok(Field::length(sweep(cloud, &rings, &sources)))
}

/// The distance from one end of the cloud along the surface in mm, the ends being a pair of places that are farthest apart. Some four
/// times the time of [`geodesic`].
///
/// The pair comes from sweeps from end to end until they get no longer. Of both ends that one is the source from which the distances
/// have the larger third moment about their mean; where these are equal, `is_multiple` is set.
///
/// # Errors
///
/// A cloud without points.
pub fn geodesic_from_ends<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
) -> Result<Field, FunctionError> {
    let start = farthest_from_centre(cloud)?;
    let rings = Rings::new(cloud, nearest);
    let of = |source: PlaceId| {
        let sources = with_a_source_each(cloud, &rings, &[source]);
        sweep(cloud, &rings, &sources)
    };
    let mut from = of(farthest(&of(start)));
    for _ in 0..SWEEPS {
        let other = farthest(&from);
        let back = of(other);
        let is_longer = back[farthest(&back) as usize] > from[other as usize] * (1.0 + SAME);
        let moments = [third_moment(&from), third_moment(&back)];
        if !is_longer {
            let is_multiple =
                (moments[0] - moments[1]).abs() < NEAR * (moments[0].abs() + moments[1].abs());
            let values = if moments[1] > moments[0] { back } else { from };
            return Ok(Field { values, is_length: true, is_multiple });
        }
        from = of(farthest(&back));
    }
    Ok(Field::length(from))
}

/// The places where a field of [`geodesic_from_ends`] is least and largest.
pub(super) fn ends(field: &Field) -> [PlaceId; 2] {
    let least: Vec<f64> = field.values.iter().map(|value| -value).collect();
    [farthest(&least), farthest(&field.values)]
}

/// The mean of the distances from `count` sources along the surface in mm, which bending does not change. The sources are spread: each is
/// the place farthest from those before it, the first one farthest from the centre. `count` times the time of [`geodesic`].
///
/// # Errors
///
/// No source or more than [`MOST_SOURCES`]; a cloud without points.
pub fn geodesic_mean<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
    count: usize,
) -> Result<Field, FunctionError> {
    if count == 0 || count > MOST_SOURCES {
        return Err(FunctionError::Sources { found: count, most: MOST_SOURCES });
    }
    let mut source = farthest_from_centre(cloud)?;
    let rings = Rings::new(cloud, nearest);
    let mut least = vec![f64::INFINITY; cloud.len()];
    let mut sum = vec![0.0; cloud.len()];
    for _ in 0..count {
        let sources = with_a_source_each(cloud, &rings, &[source]);
        let distances = sweep(cloud, &rings, &sources);
        for ((sum, least), distance) in sum.iter_mut().zip(&mut least).zip(&distances) {
            *sum += distance / count as f64;
            *least = least.min(*distance);
        }
        source = farthest(&least);
    }
    Ok(Field::length(sum))
}

fn check<const D: usize>(cloud: &Cloud<D>, sources: &[PlaceId]) -> Result<(), FunctionError> {
    if sources.is_empty() || sources.len() > cloud.len() {
        return Err(FunctionError::Sources { found: sources.len(), most: cloud.len() });
    }
    match sources.iter().find(|&&source| source as usize >= cloud.len()) {
        Some(&found) => Err(FunctionError::Source { found, places: cloud.len() }),
        None => Ok(()),
    }
}

/// The sources, and one more in each part of the cloud that holds none.
fn with_a_source_each<const D: usize>(
    cloud: &Cloud<D>,
    rings: &Rings,
    sources: &[PlaceId],
) -> Vec<PlaceId> {
    let mut all = sources.to_vec();
    let mut nearest = vec![None; rings.parts as usize];
    sources.iter().for_each(|&source| nearest[rings.part(source) as usize] = Some((0.0, source)));
    if nearest.iter().all(Option::is_some) {
        return all;
    }
    let has_source: Vec<bool> = nearest.iter().map(Option::is_some).collect();
    let first = &cloud.places()[sources[0] as usize];
    for (place, position) in (0..).zip(cloud.places()) {
        let part = rings.part(place) as usize;
        let distance = squared_distance(position, first);
        if nearest[part].is_none_or(|(least, _)| distance < least) {
            nearest[part] = Some((distance, place));
        }
    }
    let added = nearest.iter().zip(has_source).filter(|(_, has)| !has);
    all.extend(added.filter_map(|(found, _)| found.map(|(_, place)| place)));
    all
}

fn farthest_from_centre<const D: usize>(cloud: &Cloud<D>) -> Result<PlaceId, FunctionError> {
    let centre = cloud.centre_mm().ok_or(FunctionError::NoPoints)?;
    let squares: Vec<f64> =
        cloud.places().iter().map(|place| squared_distance(place, &centre)).collect();
    Ok(farthest(&squares))
}

/// The first place with the largest value.
fn farthest(values: &[f64]) -> PlaceId {
    let mut best = 0;
    for (at, value) in values.iter().enumerate() {
        if *value > values[best] {
            best = at;
        }
    }
    best as PlaceId
}

fn third_moment(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter().map(|value| (value - mean).powi(3)).sum::<f64>() / count
}

/// Sources of a mean at most.
pub const MOST_SOURCES: usize = 1000;

/// Sweeps from end to end at most.
const SWEEPS: usize = 4;

/// A sweep is longer if it is by this share.
const SAME: f64 = 1e-9;

/// Third moments are equal within this share.
const NEAR: f64 = 1e-3;
