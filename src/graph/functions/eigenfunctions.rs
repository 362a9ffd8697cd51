//! Eigenfunctions of the Laplacian of a cloud: its slowest vibrations.

use rayon::prelude::*;

use super::chebyshev::{Block, largest};
use super::cholesky::Cholesky;
use super::dissection::Dissection;
use super::krylov::slowest;
use super::laplacian::Laplacian;
use super::pieces::by_piece;
use super::{Field, FunctionError};
use crate::cloud::Cloud;
use crate::nearest::Nearest;

/// Eigenfunctions with their eigenvalues.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenfunctions {
    /// Eigenvalues of 1 − D⁻¹A, above 0 and below 2, the least first. That of the constant function is left out.
    pub eigenvalues: Vec<f64>,
    /// The functions. Their squares, weighted by the degrees, have the mean 1. [`Field::is_multiple`] is set where the next
    /// eigenvalue on either side is within a thousandth: any combination of both would do as well.
    pub fields: Vec<Field>,
    /// The norm of what each pair leaves of the symmetric problem.
    pub residuals: Vec<f64>,
    /// Rounds of the iteration.
    pub rounds: usize,
}

/// The first `count` eigenfunctions that are not constant.
///
/// The Laplacian is that of the random walk between neighbours, with densities taken out. A function has the sign by which its
/// third moment is above 0; where that is 0 but for rounding, the value that is farthest from 0 is above it. Residuals are
/// below 1e-8.
///
/// On a surface the factor of the Laplacian is small, and its inverse leads to the functions. Where it is not, as of a solid, a
/// polynomial of the Laplacian does.
///
/// # Errors
///
/// More than [`MOST_EIGENFUNCTIONS`], or than a quarter of the places; a cloud in pieces.
pub fn eigenfunctions<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
    count: usize,
) -> Result<Eigenfunctions, FunctionError> {
    if cloud.is_empty() {
        return Err(FunctionError::NoPoints);
    }
    let most = MOST_EIGENFUNCTIONS.min(cloud.len() / 4);
    if count == 0 || count > most {
        return Err(FunctionError::Eigenfunctions { found: count, most });
    }
    let laplacian = Laplacian::new(cloud, nearest)?;
    let degrees = laplacian.degrees().to_vec();
    let operator = laplacian.normalised();
    // The constant function, and one more by which the last one wanted is known to be alone or not.
    let wanted = count + 2;
    let width = (wanted + FURTHER.max(count / 2)).min(cloud.len());
    let start = start(cloud, &degrees, width);
    let start = by_inverse(cloud, &operator, &start, (wanted, &degrees)).unwrap_or(start);
    let found = largest(&operator, &start, wanted.min(width), TOLERANCE);
    let worst = found.residuals[..=count].iter().copied().fold(0.0, f64::max);
    if worst > TOLERANCE || worst.is_nan() {
        let (tolerance, rounds) = (TOLERANCE, found.rounds);
        return Err(FunctionError::Unsolved { tolerance, rounds, residual: worst });
    }
    let values = &found.eigenvalues;
    let is_near =
        |a: usize, b: usize| (values[a] - values[b]).abs() < GAP * values[a].max(values[b]);
    let total: f64 = degrees.iter().sum();
    let field = |at: usize| {
        let vector = found.vectors.values.iter().skip(at).step_by(width);
        let function = |(value, degree): (&f64, &f64)| value * (total / degree).sqrt();
        let mut values: Vec<f64> = vector.zip(&degrees).map(function).collect();
        if points_back(&values) {
            values.iter_mut().for_each(|value| *value = -*value);
        }
        let is_multiple = at > 1 && is_near(at, at - 1) || at + 1 < width && is_near(at, at + 1);
        Field { values, is_length: false, is_multiple }
    };
    Ok(Eigenfunctions {
        eigenvalues: values[1..=count].to_vec(),
        fields: (1..=count).into_par_iter().map(field).collect(),
        residuals: found.residuals[1..=count].to_vec(),
        rounds: found.rounds,
    })
}

/// Vectors from the inverse of the Laplacian, where its factor is small enough.
fn by_inverse<const D: usize>(
    cloud: &Cloud<D>,
    operator: &Laplacian,
    start: &Block,
    (wanted, degrees): (usize, &[f64]),
) -> Option<Block> {
    // A few places take no time by any way.
    if cloud.len() < FACTORED_PLACES || wanted > start.width {
        return None;
    }
    let dissection = Dissection::new(operator, &cloud.nodes);
    if dissection.entries > MOST_ENTRIES {
        return None;
    }
    let factor = Cholesky::new(operator, dissection)?;
    let roots: Vec<f64> = degrees.iter().map(|degree| degree.sqrt()).collect();
    slowest((operator, &factor), &roots, start, (wanted, TOLERANCE))
}

/// The eigenfunction of a number, from 1: see [`eigenfunctions`]. Each piece of a cloud has its own; one of fewer places than
/// four times the number has the value 0.
///
/// # Errors
///
/// A number that is none; a cloud without points, or all of whose pieces are too small.
pub fn eigenfunction<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
    number: usize,
) -> Result<Field, FunctionError> {
    by_piece(cloud, nearest, |cloud, nearest| {
        let mut found = eigenfunctions(cloud, nearest, number)?;
        found.fields.pop().ok_or(FunctionError::NoPoints)
    })
}

/// Vectors to begin with: the constant function, powers of the coordinates, and waves that nothing in the cloud shares.
fn start<const D: usize>(cloud: &Cloud<D>, degrees: &[f64], width: usize) -> Block {
    let centre_mm = cloud.centre_mm().unwrap_or([0.0; D]);
    let scale_mm = cloud.diagonal_mm().max(f64::MIN_POSITIVE);
    Block::new(cloud.len(), width, |place, column| {
        let at = cloud.places()[place];
        let at: [f64; D] = std::array::from_fn(|axis| (at[axis] - centre_mm[axis]) / scale_mm);
        let value = match column {
            0 => 1.0,
            _ if column <= D => at[column - 1],
            _ => {
                let wave: f64 = (0..D)
                    .map(|axis| at[axis] * 9.0 * ((column * (axis + 2)) as f64 * GOLDEN).sin())
                    .sum();
                (wave + column as f64).sin()
            }
        };
        value * degrees[place].sqrt()
    })
}

/// Whether a function is to be turned round.
fn points_back(values: &[f64]) -> bool {
    let (mut cubes, mut sizes, mut farthest) = (0.0, 0.0, 0.0_f64);
    for &value in values {
        let cube = value * value * value;
        cubes += cube;
        sizes += cube.abs();
        if value.abs() > farthest.abs() * (1.0 + SAME) {
            farthest = value;
        }
    }
    if cubes.abs() > SAME * sizes { cubes < 0.0 } else { farthest < 0.0 }
}

/// Eigenfunctions at most.
pub const MOST_EIGENFUNCTIONS: usize = 100;
/// Vectors beside those that are wanted, at least: they speed up the last ones.
const FURTHER: usize = 6;
/// Residuals are below this.
const TOLERANCE: f64 = 1e-8;
/// Eigenvalues within this share are one multiple eigenvalue.
const GAP: f64 = 1e-3;
/// Clouds of so many places are solved by the inverse.
const FACTORED_PLACES: usize = 2_000;
/// Numbers of the factor at most: 400 MB. Points of a solid come to that much sooner than those of a surface.
const MOST_ENTRIES: usize = 50_000_000;
/// Rounding leaves less than this share.
const SAME: f64 = 1e-6;
const GOLDEN: f64 = 0.618_033_988_749_894_9;
