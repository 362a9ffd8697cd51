//! Heights on a regular grid, with gaps.

use super::datum::{Datum, MeanPlane};
use super::surface::{LARGEST, Nodes, Support};
use super::unknown::positive;
use super::{TextureError, Unknown};

/// Heights in nm on a regular grid of rows along x.
///
/// Invariants: sizes agree; heights are finite and below 1e60 nm, 0 at gaps.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    heights_nm: Vec<f64>,
    measured: Vec<bool>,
    rows: usize,
    columns: usize,
    spacing_mm: [f64; 2],
    datum: Datum,
}

impl Grid {
    /// Heights in nm, row after row, x fastest; what is not finite or beyond 1e60 nm is a gap.
    /// `spacing_mm` is the distance of columns and of rows. Fails unless there are rows times columns
    /// heights and the distances are positive. `O(n)`.
    pub fn new(
        heights_nm: &[f64],
        rows: usize,
        columns: usize,
        spacing_mm: [f64; 2],
    ) -> Result<Grid, TextureError> {
        if rows.checked_mul(columns) != Some(heights_nm.len()) {
            return Err(TextureError::Grid { rows, columns, heights: heights_nm.len() });
        }
        positive("distance of columns", spacing_mm[0])?;
        positive("distance of rows", spacing_mm[1])?;
        let heights = heights_nm.iter().map(|height| (height.abs() < LARGEST).then_some(*height));
        Ok(Grid::of_heights(heights, rows, columns, spacing_mm))
    }

    /// A profile: one row of heights in nm at a distance in mm. Filters then act along it alone, by the
    /// weights of ISO 16610-21.
    pub fn profile(heights_nm: &[f64], spacing_mm: f64) -> Result<Grid, TextureError> {
        Grid::new(heights_nm, 1, heights_nm.len(), [spacing_mm; 2])
    }

    fn of_heights(
        heights_nm: impl Iterator<Item = Option<f64>>,
        rows: usize,
        columns: usize,
        spacing_mm: [f64; 2],
    ) -> Grid {
        let (heights_nm, measured) =
            heights_nm.map(|height| (height.unwrap_or(0.0), height.is_some())).unzip();
        Grid { heights_nm, measured, rows, columns, spacing_mm, datum: Datum::AsGiven }
    }

    /// Places kept, with other heights, `None` for a gap.
    pub(super) fn with_heights(&self, heights_nm: impl Iterator<Item = Option<f64>>) -> Grid {
        Grid::of_heights(heights_nm, self.rows, self.columns, self.spacing_mm)
    }

    /// How many rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Distance of columns and of rows in mm.
    pub fn spacing_mm(&self) -> [f64; 2] {
        self.spacing_mm
    }

    /// Height that the heights are about.
    pub fn datum(&self) -> Datum {
        self.datum
    }

    /// Height in nm at a node; `None` for a gap or outside.
    pub fn height_nm(&self, row: usize, column: usize) -> Option<f64> {
        if row < self.rows && column < self.columns {
            self.at(row * self.columns + column)
        } else {
            None
        }
    }

    /// Heights in nm, row after row; `None` for a gap.
    pub fn heights_nm(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        (0..self.heights_nm.len()).map(|i| self.at(i))
    }

    /// The heights about another datum, the gaps as they are. `O(n)`.
    pub fn levelled(&self, datum: Datum) -> Grid {
        let Ok(nodes) = self.nodes() else { return Grid { datum, ..self.clone() } };
        let plane = MeanPlane::new(&nodes, datum);
        let left =
            (0..self.heights_nm.len()).map(|i| Some(self.at(i)? - plane.height_nm(self.place(i))));
        Grid { datum, ..self.with_heights(left) }
    }

    /// These heights less those of a grid of the same places; a gap in either is a gap.
    pub(super) fn less(&self, other: &Grid) -> Grid {
        let pairs = self.heights_nm().zip(other.heights_nm());
        self.with_heights(pairs.map(|(own, other)| Some(own? - other?)))
    }

    /// The measured nodes, all of the same area.
    pub(super) fn nodes(&self) -> Result<Nodes, Unknown> {
        let given = self.heights_nm.len();
        let used: Vec<usize> = (0..given).filter(|&i| self.measured[i]).collect();
        if used.is_empty() {
            return Err(Unknown::NoPoints { given });
        }
        let points = used.len();
        Ok(Nodes {
            places_mm: used.iter().map(|&i| self.place(i)).collect(),
            heights_nm: used.iter().map(|&i| self.heights_nm[i]).collect(),
            shares: vec![1.0 / points as f64; points],
            support: Support { points, measured: points as f64 / given as f64, datum: self.datum },
        })
    }

    pub(super) fn at(&self, index: usize) -> Option<f64> {
        self.measured[index].then_some(self.heights_nm[index])
    }

    /// 1 where measured, 0 at gaps.
    pub(super) fn weights(&self) -> Vec<f64> {
        self.measured.iter().map(|&measured| f64::from(u8::from(measured))).collect()
    }

    fn place(&self, index: usize) -> [f64; 2] {
        let [dx, dy] = self.spacing_mm;
        [(index % self.columns) as f64 * dx, (index / self.columns) as f64 * dy]
    }
}
