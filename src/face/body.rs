//! A volume of grey values, smoothed, with its surface.

use asphera_geometry::PointMm;
use asphera_volume::{
    Ambiguity, Grey, Samples, SizeError, SlabBuilder, Surface, marching_cubes, smoothed,
};
use rayon::prelude::*;

use asphera_geometry::vector::{Vector, cross, dot, plus, unit};

/// Where the samples of a volume lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The place of sample (0, 0, 0), mm.
    pub origin_mm: PointMm,
    /// The steps from a sample to the next along x, y and z, mm; they span space.
    pub steps_mm: [[f64; 3]; 3],
}

/// Grey values on a lattice; material has the higher ones.
#[derive(Clone, Debug)]
pub struct Scan {
    /// One value a sample, x fastest; what was not measured is not finite.
    pub values: Vec<f32>,
    /// Columns, rows and slices.
    pub size: [usize; 3],
    /// Where they lie.
    pub lattice: Lattice,
}

/// A volume with its surface.
pub struct Body {
    pub(crate) scan: Scan,
    /// Standard deviation of the smoothing in mm; 0: none.
    pub(crate) smoothing_mm: f64,
}

/// The surface of a body at a threshold.
pub(crate) struct Skin {
    pub(crate) threshold: f64,
    /// In samples.
    pub(crate) surface: Surface,
    /// Places of the vertices, mm.
    pub(crate) places_mm: Vec<PointMm>,
    /// Unit normals out of the material, in mm; NaN where values lack.
    pub(crate) normals: Vec<Vector>,
}

impl Lattice {
    /// The place of a point given in samples, mm.
    pub(crate) fn place_mm(&self, at: Vector) -> PointMm {
        let [x, y, z] = self.steps_mm;
        plus(plus(plus(self.origin_mm, at[0], x), at[1], y), at[2], z)
    }

    /// The lengths of the steps, mm.
    pub(crate) fn spacing_mm(&self) -> [f64; 3] {
        self.steps_mm.map(|step| dot(step, step).sqrt())
    }

    /// The smallest of them.
    pub(crate) fn least_mm(&self) -> f64 {
        self.spacing_mm().into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The volume of a cell, mm³.
    pub(crate) fn cell_mm3(&self) -> f64 {
        let [x, y, z] = self.steps_mm;
        dot(x, cross(y, z)).abs()
    }

    /// Samples a mm: row i is the gradient of the i-th coordinate in samples.
    pub(crate) fn per_mm(&self) -> [Vector; 3] {
        let [x, y, z] = self.steps_mm;
        let volume = dot(x, cross(y, z));
        [cross(y, z), cross(z, x), cross(x, y)].map(|row| row.map(|side| side / volume))
    }
}

impl Body {
    /// A body of grey values, smoothed by a Gaussian of `smoothing` smallest spacings; 0 leaves them as they are.
    ///
    /// # Panics
    ///
    /// Where there are not as many values as the size says.
    pub fn new(scan: Scan, smoothing: f64) -> Body {
        let smoothing_mm = smoothing * scan.lattice.least_mm();
        let sigma = scan.lattice.spacing_mm().map(|spacing_mm| smoothing_mm / spacing_mm);
        let values = smoothed(&scan.values, scan.size, sigma);
        Body { scan: Scan { values, ..scan }, smoothing_mm }
    }

    /// The values, against a threshold.
    pub(crate) fn grey(&self, threshold: f64) -> Grey<'_> {
        Grey { values: &self.scan.values, size: self.scan.size, threshold: threshold as f32 }
    }

    /// The samples at a threshold or above.
    pub(crate) fn samples(&self, threshold: f64) -> Result<Samples, SizeError> {
        let mut builder = SlabBuilder::new(self.scan.size)?;
        builder.push_values(&self.scan.values, threshold as f32)?;
        builder.finish()
    }

    /// The surface at a threshold.
    pub(crate) fn skin(&self, threshold: f64) -> Result<Skin, SizeError> {
        let samples = self.samples(threshold)?;
        let grey = self.grey(threshold);
        let surface = marching_cubes(&samples, Ambiguity::Paired, &grey);
        let per_mm = self.scan.lattice.per_mm();
        let seen: Vec<(PointMm, Vector)> = surface
            .vertices
            .par_iter()
            .map(|&vertex| {
                let place_mm = self.scan.lattice.place_mm(vertex);
                (place_mm, outward(&grey, &per_mm, vertex).unwrap_or([f64::NAN; 3]))
            })
            .collect();
        let (places_mm, normals) = seen.into_iter().unzip();
        Ok(Skin { threshold, surface, places_mm, normals })
    }
}

/// The unit normal out of the material: against the gradient.
fn outward(grey: &Grey<'_>, per_mm: &[Vector; 3], vertex: Vector) -> Option<Vector> {
    let slope = grey.gradient(vertex)?;
    let sum = (0..3).fold([0.0; 3], |sum, axis| plus(sum, -slope[axis], per_mm[axis]));
    unit(sum)
}
