//! Removal of terms before figures are formed.

use std::fmt;

use super::expansion::expand_fringe;
use super::{Sample, Unknown};

/// A term that can be removed, as Fringe terms over the aperture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Term {
    /// Fringe 1.
    Piston,
    /// Fringe 2 and 3.
    Tilt,
    /// Fringe 4.
    Power,
    /// Fringe 5 and 6, of third order.
    Astigmatism,
    /// Fringe 7 and 8, of third order.
    Coma,
    /// Fringe 9, of third order.
    Spherical,
}

impl Term {
    /// Numbers of its Fringe terms.
    pub fn fringe(self) -> &'static [u8] {
        match self {
            Term::Piston => &[1],
            Term::Tilt => &[2, 3],
            Term::Power => &[4],
            Term::Astigmatism => &[5, 6],
            Term::Coma => &[7, 8],
            Term::Spherical => &[9],
        }
    }
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Term::Piston => "piston",
            Term::Tilt => "tilt",
            Term::Power => "power",
            Term::Astigmatism => "astigmatism",
            Term::Coma => "coma",
            Term::Spherical => "spherical",
        })
    }
}

impl Term {
    /// All of them, in ascending order.
    pub const ALL: [Term; 6] =
        [Term::Piston, Term::Tilt, Term::Power, Term::Astigmatism, Term::Coma, Term::Spherical];
}

/// A set of terms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Terms {
    has: [bool; Term::ALL.len()],
}

impl Terms {
    /// None.
    pub const NONE: Terms = Terms { has: [false; Term::ALL.len()] };

    /// The terms of a list, each once.
    pub fn new(terms: &[Term]) -> Terms {
        Terms { has: Term::ALL.map(|term| terms.contains(&term)) }
    }

    /// The terms in ascending order.
    pub fn list(&self) -> Vec<Term> {
        Term::ALL.into_iter().zip(self.has).filter_map(|(term, has)| has.then_some(term)).collect()
    }
}

/// `piston, tilt`.
impl fmt::Display for Terms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = self.list().iter().map(ToString::to_string).collect();
        f.write_str(&names.join(", "))
    }
}

/// A sample with terms removed.
#[derive(Clone, Debug, PartialEq)]
pub struct Removed {
    /// What remains.
    pub sample: Sample,
    /// The terms removed, in ascending order, each once.
    pub terms: Vec<Term>,
    /// Fringe number and coefficient in nm of what was removed; `None` for a term that the places do not
    /// tell from lower ones, so that it went with these.
    pub coefficients_nm: Vec<(u8, Option<f64>)>,
}

/// Fits the `terms`, and only these, together by area-weighted least squares at the measured places, and
/// subtracts them. `O(n)`.
///
/// Over an evenly and fully measured disc each term is that of a longer expansion; over another aperture
/// or with gaps it is what removes most. Unknown unless there are more points than Fringe terms.
pub fn remove(sample: &Sample, terms: &[Term]) -> Result<Removed, Unknown> {
    let mut terms = terms.to_vec();
    terms.sort_unstable();
    terms.dedup();
    let numbers: Vec<u8> = terms.iter().flat_map(|term| term.fringe()).copied().collect();
    if numbers.is_empty() {
        return Ok(Removed { sample: sample.clone(), terms, coefficients_nm: Vec::new() });
    }
    let expansion = expand_fringe(sample, &numbers, numbers.len() + 1)?;
    Ok(Removed {
        sample: sample.with_values(expansion.residual_nm),
        terms,
        coefficients_nm: numbers.into_iter().zip(expansion.coefficients_nm).collect(),
    })
}
