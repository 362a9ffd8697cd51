//! What a topography file holds: a height map or a cloud, and where it comes from.

use crate::Format;
use crate::xyz::Taken;

/// Heights on a regular grid in the plane z = 0.
///
/// The sample at column `i`, row `j` lies at x = `x0_mm + i * dx_mm`, y = `y0_mm + j * dy_mm` and
/// has the height `z_mm[j * nx + i]`. Readers give `nx * ny == z_mm.len()`, both sizes at least 1,
/// finite origins, finite increments above zero, and heights that are finite or NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Columns, along x.
    pub nx: usize,
    /// Rows, along y.
    pub ny: usize,
    /// Distance of two columns in mm.
    pub dx_mm: f64,
    /// Distance of two rows in mm.
    pub dy_mm: f64,
    /// x of the first column in mm.
    pub x0_mm: f64,
    /// y of the first row in mm.
    pub y0_mm: f64,
    /// Heights in mm, row after row, x fastest; NaN where there is no measured height.
    pub z_mm: Vec<f64>,
}

/// Measured points in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cloud {
    /// x, y, z in mm; all finite.
    pub points_mm: Vec<[f64; 3]>,
    /// The standard uncertainty of each z in mm, as the file has it: 0 and negative numbers too, NaN where it is no
    /// number. Empty where the file has none.
    pub uncertainties_mm: Vec<f64>,
    /// The slope dz/dx at each point, where the file has slopes: then z is their integral by the trapezoidal rule. Empty
    /// where it has heights.
    pub slopes: Vec<f64>,
    /// How many points the file lists without a measured height. They are not in `points_mm`.
    pub missing: usize,
}

/// Where a topography comes from, as far as its file says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Format of the file.
    pub format: Format,
    /// Maker, model and serial number of the instrument, separated by spaces.
    pub instrument: Option<String>,
    /// Date and time of the measurement. ISO 8601 where the format defines a date; otherwise the
    /// text of the file.
    pub date: Option<String>,
    /// Free text.
    pub comment: Option<String>,
    /// Which columns and units were read, of a file whose format leaves them open.
    pub taken: Option<Taken>,
}

/// Content of one file.
#[derive(Clone, Debug, PartialEq)]
pub enum Topography {
    /// Heights on a regular grid.
    Map(HeightMap, Source),
    /// Points without a grid.
    Cloud(Cloud, Source),
}

impl HeightMap {
    /// The measured points, x, y, z in mm, row after row; gaps are skipped.
    pub fn points(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.z_mm.chunks(self.nx.max(1)).enumerate().flat_map(move |(row, heights)| {
            let y_mm = self.y0_mm + row as f64 * self.dy_mm;
            heights
                .iter()
                .enumerate()
                .filter(|(_, z_mm)| z_mm.is_finite())
                .map(move |(column, &z_mm)| [self.x0_mm + column as f64 * self.dx_mm, y_mm, z_mm])
        })
    }

    /// How many samples have no measured height.
    pub fn missing(&self) -> usize {
        self.z_mm.iter().filter(|z_mm| !z_mm.is_finite()).count()
    }
}

impl Topography {
    /// The measured points, x, y, z in mm, in the order of the file; gaps are skipped.
    pub fn points(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        // One of the two is empty: the type of an iterator cannot depend on the variant.
        let (map, cloud) = match self {
            Topography::Map(map, _) => (Some(map), None),
            Topography::Cloud(cloud, _) => (None, Some(cloud)),
        };
        let listed = cloud.into_iter().flat_map(|cloud| cloud.points_mm.iter().copied());
        map.into_iter().flat_map(HeightMap::points).chain(listed)
    }

    /// How many samples of the file have no measured height.
    pub fn missing(&self) -> usize {
        match self {
            Topography::Map(map, _) => map.missing(),
            Topography::Cloud(cloud, _) => cloud.missing,
        }
    }

    /// The standard uncertainties of the heights of [`Topography::points`], in the same order; empty where the file has
    /// none, as every height map.
    pub fn uncertainties_mm(&self) -> &[f64] {
        match self {
            Topography::Map(..) => &[],
            Topography::Cloud(cloud, _) => &cloud.uncertainties_mm,
        }
    }

    /// The slopes dz/dx of [`Topography::points`] of a profile; empty where the file has heights.
    pub fn slopes(&self) -> &[f64] {
        match self {
            Topography::Map(..) => &[],
            Topography::Cloud(cloud, _) => &cloud.slopes,
        }
    }

    /// Where it comes from.
    pub fn source(&self) -> &Source {
        match self {
            Topography::Map(_, source) | Topography::Cloud(_, source) => source,
        }
    }
}

impl Source {
    /// A source of which nothing but the format is known.
    pub(crate) fn new(format: Format) -> Source {
        Source { format, instrument: None, date: None, comment: None, taken: None }
    }
}

/// The texts that say something, joined by single spaces; `None` if none does.
pub(crate) fn joined(texts: &[&str]) -> Option<String> {
    let said: Vec<&str> = texts.iter().map(|text| text.trim()).filter(|t| !t.is_empty()).collect();
    (!said.is_empty()).then(|| said.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_skip_gaps_and_keep_their_places() {
        let map = HeightMap {
            nx: 2,
            ny: 2,
            dx_mm: 0.5,
            dy_mm: 2.0,
            x0_mm: 10.0,
            y0_mm: -1.0,
            z_mm: vec![1.0, f64::NAN, 3.0, 4.0],
        };
        let map = Topography::Map(map, Source::new(Format::Sdf));
        let expected = [[10.0, -1.0, 1.0], [10.0, 1.0, 3.0], [10.5, 1.0, 4.0]];
        assert_eq!(map.points().collect::<Vec<_>>(), expected);
        assert_eq!(map.missing(), 1);

        let cloud = Cloud { points_mm: expected.to_vec(), missing: 7, ..Cloud::default() };
        let cloud = Topography::Cloud(cloud, Source::new(Format::Xyz));
        assert_eq!(cloud.points().collect::<Vec<_>>(), expected);
        assert_eq!((cloud.missing(), cloud.source().format), (7, Format::Xyz));
    }
}
