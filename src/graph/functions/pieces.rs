//! Functions of a cloud in several pieces: each piece has its own.

use asphera_geometry::Sets;

use super::ring::Rings;
use super::{Field, FunctionError};
use crate::cloud::{Cloud, PlaceId};
use crate::nearest::Nearest;

/// The function of every piece of a cloud, by what flows between neighbours. A piece too small for it has the value 0.
///
/// # Errors
///
/// Errors of the function; pieces of which none is large enough.
pub(super) fn by_piece<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
    function: impl Fn(&Cloud<D>, &Nearest) -> Result<Field, FunctionError>,
) -> Result<Field, FunctionError> {
    let pieces = match function(cloud, nearest) {
        Err(FunctionError::Pieces { .. }) => pieces(cloud, nearest),
        found => return found,
    };
    let mut whole = Field { values: vec![0.0; cloud.len()], is_length: false, is_multiple: false };
    let (count, mut is_known) = (pieces.len(), false);
    for piece in pieces {
        let places: Vec<[f64; D]> = piece.iter().map(|&at| cloud.places()[at as usize]).collect();
        let own = Cloud::new(&places)?;
        let found = match function(&own, &own.nearest(nearest.k())?) {
            Ok(found) => found,
            // Too few places, or a piece that the finer scale of its own neighbours parts again.
            Err(FunctionError::Eigenfunctions { found, most }) if found > most => continue,
            Err(FunctionError::Pieces { .. }) => continue,
            Err(error) => return Err(error),
        };
        for (&place, &row) in piece.iter().zip(own.places_of_rows()) {
            whole.values[place as usize] = found.values[row as usize];
        }
        whole.is_multiple |= found.is_multiple;
        is_known = true;
    }
    if is_known { Ok(whole) } else { Err(FunctionError::Pieces { pieces: count }) }
}

/// The places of each piece, in the order of their first ones.
fn pieces<const D: usize>(cloud: &Cloud<D>, nearest: &Nearest) -> Vec<Vec<PlaceId>> {
    let rings = Rings::new(cloud, nearest);
    let count = cloud.len();
    let (mut edges, mut sum_mm) = (0_usize, 0.0);
    for place in 0..count as PlaceId {
        for (_, length_mm) in rings.neighbours(place) {
            (edges, sum_mm) = (edges + 1, sum_mm + length_mm);
        }
    }
    let reach_mm = REACH * sum_mm / edges.max(1) as f64;
    let mut sets = Sets::new(count);
    for place in 0..count as PlaceId {
        for (other, _) in rings.neighbours(place).filter(|&(_, length_mm)| length_mm < reach_mm) {
            sets.join(place as usize, other as usize);
        }
    }
    let (piece_of, number) = sets.numbered();
    let mut pieces = vec![Vec::new(); number as usize];
    for (place, piece) in (0..).zip(piece_of) {
        pieces[piece as usize].push(place);
    }
    pieces
}

/// Mean distances of neighbours over which nothing flows any more: exp(−6²) is 2·10⁻¹⁶.
const REACH: f64 = 6.0;
