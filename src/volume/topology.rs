//! Components, tunnels and cavities of the solid.

use crate::euler::{euler_6, euler_26};
use crate::parts::{cavities, components};
use crate::{Histogram, Samples};

/// The topology of the digitized solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topology {
    /// Euler number where foreground is connected across faces of voxels only.
    pub euler_6: i64,
    /// Euler number where foreground is connected across edges and corners of voxels, too.
    pub euler_26: i64,
    /// Connected parts of the foreground, connected across faces (Betti number 0).
    pub components: u64,
    /// Parts of the background that the foreground encloses, connected across corners (Betti number 2).
    pub cavities: u64,
    /// Tunnels and handles (Betti number 1): components + cavities − Euler number (6).
    pub tunnels: i64,
}

impl Topology {
    /// The topology of a volume; `histogram` is that of the same volume. Memory is that of some slices.
    pub fn new(samples: &Samples, histogram: &Histogram) -> Topology {
        let (components, cavities) = (components(samples), cavities(samples));
        let euler_6 = euler_6(histogram);
        Topology {
            euler_6,
            euler_26: euler_26(histogram),
            components,
            cavities,
            tunnels: components as i64 + cavities as i64 - euler_6,
        }
    }

    /// Whether the grid alone determines the topology: both Euler numbers agree, as they do for r-regular solids.
    pub fn is_determined(&self) -> bool {
        self.euler_6 == self.euler_26
    }
}
