//! From a surface of a Zemax lens file to a nominal file.
//!
//! What the numbers of a kind mean is OpticStudio's help, Sequential Surfaces (2024 R2), as far as it could be read: the pages Odd Asphere, Extended Asphere,
//! Toroidal, Extended Polynomial, Grid Sag and Irregular. The extended odd asphere, the standard Zernike surface, the biconic and the Q-type asphere are laid out as
//! the open readers of such files have them (ray-optics reads XOSPHERE as powers of every order from 1 on), the
//! Fringe surface by analogy. An extra datum `XDAT i` is the parameter i + 12 there. The frame of both is the same: z along the light, a radius
//! positive where its centre lies at +z.

mod convert;
mod refused;
mod text;

use asphera_formats::zemax::Lens;
use thiserror::Error;

/// Why a surface makes no nominal.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum LensImportError {
    /// There is no surface of the number.
    #[error("there is no surface {number}; the file has\n{listed}")]
    NoSuchSurface {
        /// The number asked for.
        number: u32,
        /// The surfaces there are.
        listed: String,
    },
    /// The kind is not known here.
    #[error(
        "surface {number}, line {line}, is of the kind {kind}{hint}, expected one of {known}; the file has\n{listed}"
    )]
    Kind {
        /// Number of the surface.
        number: u32,
        /// Line of the file on which it begins.
        line: usize,
        /// Why it is not, and what can be done.
        hint: &'static str,
        /// Its kind.
        kind: String,
        /// The kinds that are.
        known: String,
        /// The surfaces of the file.
        listed: String,
    },
    /// A grid sag without its file of heights.
    #[error(
        "surface {number}, line {line}, is of the kind GRID_SAG, and its heights are in another file: add --grid FILE.DAT"
    )]
    NoHeights {
        /// Number of the surface.
        number: u32,
        /// Line of the file on which it begins.
        line: usize,
    },
    /// A file of heights for a surface that has none.
    #[error(
        "surface {number}, line {line}, is of the kind {kind}, expected GRID_SAG for a file of heights (--grid)"
    )]
    OtherHeights {
        /// Number of the surface.
        number: u32,
        /// Line of the file on which it begins.
        line: usize,
        /// Its kind.
        kind: String,
    },
    /// A value that is not taken over.
    #[error("surface {number}, line {line}, {kind}: {value} is {found}, expected {expected}")]
    Value {
        /// Number of the surface.
        number: u32,
        /// Line of the file on which it begins.
        line: usize,
        /// Its kind.
        kind: String,
        /// Which value.
        value: String,
        /// What it is.
        found: String,
        /// What can be taken over.
        expected: &'static str,
    },
}

/// The surfaces of a lens, a line each: number, kind, radius and semi-diameter in mm, comment.
pub fn list(lens: &Lens) -> String {
    let mut text =
        format!("{:>4}  {:<10} {:>16} {:>14}  comment\n", "no", "type", "R mm", "semi-dia mm");
    for surface in &lens.surfaces {
        let radius = match surface.curvature {
            0.0 => "infinite".to_owned(),
            curvature => format!("{:.6}", lens.unit_mm / curvature),
        };
        text += &format!(
            "{:>4}  {:<10} {:>16} {:>14.6}  {}\n",
            surface.number,
            surface.kind,
            radius,
            surface.semi_diameter * lens.unit_mm,
            surface.comment.as_deref().unwrap_or_default(),
        );
    }
    text
}

/// The nominal file of a surface: TOML, with where it comes from in comments. `heights` names the file of heights of a grid sag, as
/// the nominal is to name it.
///
/// # Errors
///
/// When there is no such surface, its kind is not known, it has a value that no nominal has, or a grid sag and its heights do not
/// go together.
pub fn nominal(
    lens: &Lens,
    number: u32,
    file: &str,
    heights: Option<&str>,
) -> Result<String, LensImportError> {
    let surface = lens
        .surface(number)
        .ok_or_else(|| LensImportError::NoSuchSurface { number, listed: list(lens) })?;
    let table = convert::table(lens, surface, heights)?;
    Ok(text::write(lens, surface, file, &table))
}

#[cfg(test)]
mod tests;
