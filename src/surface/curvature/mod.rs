//! Normals and principal curvatures at the vertices of a mesh, with what noise makes uncertain.
//!
//! Normals and curvatures are to be taken from the true neighbourhood of a point, the one on the
//! surface, not from what is near in space (W. El-Hayek et al., J. Phys.: Conf. Ser. 483 (2014)
//! 012003, doi:10.1088/1742-6596/483/1/012003, section 6). So a vertex' neighbourhood is that of
//! [`Adjacency`]: the rings about it along edges that bridge no gap. Over it [`local_shape`] fits a
//! polynomial (see `jet.rs`) and takes its normal and curvatures.
//!
//! Without noise curvatures err with the square of the sample distance h, normals with its cube.
//! White noise σ makes them uncertain by about σ/(h²·√k) and σ/(h·√k), with k samples in the
//! neighbourhood: where samples are dense for their noise, two rings tell little, and more are
//! needed.

mod adjacency;
mod jet;
mod rings;
mod shape;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) mod truth;

use std::ops::Range;

use asphera_geometry::{PointMm, VertexId};
use rayon::prelude::*;
use thiserror::Error;

pub use self::adjacency::{Adjacency, AdjacencyError};
pub use self::jet::Model;
pub(crate) use self::jet::{CUBIC, Local, QUADRIC, System, derivatives, dot, terms_at};
pub(crate) use self::rings::Rings;
pub use self::rings::Surroundings;
pub use self::shape::{LocalShape, ShapeUncertainty};
use crate::noise::Noise;

/// How wide the neighbourhoods are, and how large the noise is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeSettings {
    rings: usize,
    noise: Option<Noise>,
}

/// A number of rings that is not usable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{rings} rings are not from 1 to {max}", max = ShapeSettings::RINGS_MAX)]
pub struct RingsError {
    /// The number.
    pub rings: usize,
}

impl ShapeSettings {
    /// Default number of rings: 18 neighbours on a regular mesh, for a cubic of 10 terms.
    pub const RINGS: usize = 2;
    /// Largest number of rings: some 800 samples on a regular mesh.
    pub const RINGS_MAX: usize = 16;

    /// Neighbourhoods of that many rings, 1 to [`ShapeSettings::RINGS_MAX`]. Where they hold fewer
    /// than 16 vertices, as along the border or with one ring, up to two rings more are taken.
    pub fn new(rings: usize) -> Result<ShapeSettings, RingsError> {
        if (1..=ShapeSettings::RINGS_MAX).contains(&rings) {
            Ok(ShapeSettings { rings, noise: None })
        } else {
            Err(RingsError { rings })
        }
    }

    /// Settings with this noise, whose effect is then stated as [`LocalShape::uncertainty`].
    pub fn with_noise(self, noise: Noise) -> ShapeSettings {
        ShapeSettings { noise: Some(noise), ..self }
    }
}

impl Default for ShapeSettings {
    fn default() -> ShapeSettings {
        ShapeSettings { rings: ShapeSettings::RINGS, noise: None }
    }
}

/// Why the samples about a vertex do not tell the shape of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum Undetermined {
    /// There is no such vertex.
    #[error("there is no such vertex")]
    NoVertex,
    /// No edge of the surface leads to it: it was withdrawn, or the reach cuts it off.
    #[error("no edge leads to the vertex")]
    Isolated,
    /// The neighbourhood has too few vertices, as on a small island.
    #[error("the neighbourhood has {vertices} vertices, six are needed")]
    TooFew {
        /// How many there are, the vertex included.
        vertices: usize,
    },
    /// The projections of the neighbourhood lie on one line.
    #[error("the {vertices} vertices of the neighbourhood lie on one line")]
    Collinear {
        /// How many there are, the vertex included.
        vertices: usize,
    },
    /// The projections of the neighbourhood lie on one conic, a pair of lines for instance: more
    /// than one quadric passes through them.
    #[error("the {vertices} vertices of the neighbourhood lie on one conic")]
    OnConic {
        /// How many there are, the vertex included.
        vertices: usize,
    },
    /// A coordinate of the neighbourhood is not finite, or larger than [`asphera_geometry::RANGE_MM`].
    #[error("a coordinate of the neighbourhood is not finite or out of range")]
    NotFinite,
}

/// The shape of the surface at a vertex.
///
/// Takes about 2 µs with two rings. `adjacency` is that of these points.
///
/// # Panics
///
/// When the adjacency is that of more points than these.
pub fn local_shape(
    points: &[PointMm],
    adjacency: &Adjacency,
    vertex: VertexId,
    settings: &ShapeSettings,
) -> Result<LocalShape, Undetermined> {
    Work::default().shape(points, adjacency, vertex, settings)
}

/// The shapes at a range of vertices, in their order; ask for parts where memory is scarce.
///
/// The vertices are shared out to rayon's threads; every one is computed by itself, so the bits do
/// not depend on how many there are.
///
/// ```
/// use asphera_surface::curvature::{Adjacency, ShapeSettings, local_shapes};
/// use asphera_surface::noise::{Along, Noise, NoiseSettings, estimate_noise};
/// use asphera_mesh::Mesh;
///
/// // z = x²/40, a trough with a radius of 20 mm at its bottom.
/// let places = (0..400).map(|i| [f64::from(i % 20), f64::from(i / 20)].map(|x| 0.1 * (x - 9.5)));
/// let mut mesh = Mesh::new();
/// mesh.extend(places.map(|[x, y]| [x, y, x * x / 40.0]));
/// mesh.flush();
/// let adjacency = Adjacency::new(mesh.points(), &mesh.triangles(), Some(0.5))?;
/// let noise = estimate_noise(mesh.points(), &adjacency, &NoiseSettings::default())?.noise;
/// assert!(noise.sigma_mm() < 1e-12);
///
/// let settings = ShapeSettings::default().with_noise(Noise::new(1e-5, Along::Z)?);
/// let shape = local_shapes(mesh.points(), &adjacency, 189..190, &settings)[0]?;
/// assert!((shape.curvatures_per_mm[0] - 0.05).abs() < 1e-5);
/// let uncertainty = shape.uncertainty.expect("noise was given");
/// assert!(uncertainty.curvatures_per_mm[0] < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
///
/// When the adjacency is that of more points than these.
pub fn local_shapes(
    points: &[PointMm],
    adjacency: &Adjacency,
    vertices: Range<VertexId>,
    settings: &ShapeSettings,
) -> Vec<Result<LocalShape, Undetermined>> {
    vertices
        .into_par_iter()
        .with_min_len(256)
        .map_init(Work::default, |work, vertex| work.shape(points, adjacency, vertex, settings))
        .collect()
}

/// Memory that one fit leaves to the next.
#[derive(Default)]
struct Work {
    rings: Rings,
    places: Vec<[f64; 3]>,
}

impl Work {
    fn shape(
        &mut self,
        points: &[PointMm],
        adjacency: &Adjacency,
        vertex: VertexId,
        settings: &ShapeSettings,
    ) -> Result<LocalShape, Undetermined> {
        if vertex as usize >= adjacency.len() {
            return Err(Undetermined::NoVertex);
        }
        if adjacency.neighbours(vertex).is_empty() {
            return Err(Undetermined::Isolated);
        }
        let surroundings = self.rings.gather(adjacency, vertex, settings.rings);
        let jet = jet::Jet::of(points, self.rings.samples(), &mut self.places)?;
        let z_mm = points[vertex as usize][2];
        Ok(LocalShape::of(&jet, z_mm, surroundings, settings.noise))
    }
}
