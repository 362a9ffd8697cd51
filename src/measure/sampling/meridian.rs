//! Local feature size of a nominal, as a function of the distance from its axis.
//!
//! Of a nominal of revolution the local feature size is one of revolution as well; for a freeform see
//! [`super::freeform`]. The medial balls of
//! the surface over a disc are found once, on a raster of [`RASTER`] steps across (see
//! `asphera_surface::lfs`); the local feature size is then taken at [`NODES`] distances from the axis, each
//! refined to [`TOLERANCE`], and interpolated linearly between them.
//!
//! **Error.** A local feature size changes by no more than the way gone, so a value between two nodes is off by
//! at most half their distance, 1/128 of the disc's radius, whatever the surface; where it is smooth by second
//! order of that. Features of the nominal narrower than two steps of the raster are not seen.

use asphera_form::{Curvatures, Nominal};
use asphera_surface::lfs::{Jet, LfsError, NominalLfs};
use thiserror::Error;

/// Why there is no local feature size along a meridian.
#[derive(Clone, Debug, Error, PartialEq)]
pub(super) enum MeridianError {
    /// The nominal has no meridian.
    #[error("a {kind} is not rotational")]
    NotRotational {
        /// Kind of the source.
        kind: &'static str,
    },
    /// The kernel found none.
    #[error(transparent)]
    Lfs(#[from] LfsError),
}

/// The local feature size along the meridian.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Meridian {
    /// Nodes per mm.
    scale_per_mm: f64,
    /// At each node in mm: infinite over a plane, NaN where it is not known.
    nodes_mm: Vec<f64>,
}

impl Meridian {
    /// That of the nominal over a disc of this radius in mm about its vertex; beyond its domain nothing is
    /// known.
    ///
    /// # Errors
    ///
    /// When the nominal is not rotational, the radius is no positive number, or the nominal cannot be
    /// evaluated.
    pub(super) fn of(nominal: &Nominal, radius_mm: f64) -> Result<Meridian, MeridianError> {
        if !nominal.is_rotational() {
            return Err(MeridianError::NotRotational { kind: nominal.kind() });
        }
        if *nominal == Nominal::Plane {
            return Ok(Meridian { scale_per_mm: 0.0, nodes_mm: vec![f64::INFINITY; 2] });
        }
        let radius_mm = if radius_mm.is_nan() {
            radius_mm
        } else {
            radius_mm.min(WITHIN * nominal.domain_mm())
        };
        let disc = Disc { nominal: nominal.clone(), radius_mm };
        let lfs = NominalLfs::new(disc, 2.0 * radius_mm / RASTER, TOLERANCE)?;
        let step_mm = radius_mm / (NODES - 1) as f64;
        let nodes_mm = (0..NODES)
            .map(|node| {
                // The last one is not to fall off the disc by rounding.
                let at_mm = (node as f64 * step_mm).min(radius_mm);
                lfs.at(at_mm, 0.0).mm().unwrap_or(f64::NAN)
            })
            .collect();
        Ok(Meridian { scale_per_mm: step_mm.recip(), nodes_mm })
    }

    /// At a distance from the axis in mm; beyond the disc that at its rim. None if it is not known.
    pub(super) fn at(&self, r_mm: f64) -> Option<f64> {
        if r_mm.is_nan() {
            return None;
        }
        let last = self.nodes_mm.len() - 1;
        let at = (r_mm * self.scale_per_mm).min(last as f64);
        let node = (at as usize).min(last - 1);
        let (low, high) = (self.nodes_mm[node], self.nodes_mm[node + 1]);
        if low == high {
            return Some(low);
        }
        let mm = low + (at - node as f64) * (high - low);
        (!mm.is_nan()).then_some(mm)
    }

    /// The smallest from this distance from the axis in mm to the rim of the disc; infinite over a plane, none if
    /// it is not known all the way.
    pub(super) fn least_mm(&self, from_mm: f64) -> Option<f64> {
        // Between nodes it runs straight.
        let beyond = |node: &usize| *node as f64 > from_mm * self.scale_per_mm;
        let nodes = (0..self.nodes_mm.len()).filter(beyond).map(|node| self.nodes_mm[node]);
        nodes
            .map(|mm| (!mm.is_nan()).then_some(mm))
            .fold(self.at(from_mm), |least, mm| Some(least?.min(mm?)))
    }
}

/// A nominal over a disc.
struct Disc {
    nominal: Nominal,
    radius_mm: f64,
}

impl asphera_surface::lfs::Nominal for Disc {
    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let r_mm = x_mm.hypot(y_mm);
        if r_mm > self.radius_mm {
            return None;
        }
        let Curvatures { meridional_per_mm, azimuthal_per_mm } = self.nominal.curvatures(r_mm);
        let slope = self.nominal.slope(r_mm);
        let stretch = slope.mul_add(slope, 1.0).sqrt();
        // Along the meridian the second derivative is z″, across it z′/r.
        let (along, across) = (meridional_per_mm * stretch.powi(3), azimuthal_per_mm * stretch);
        let [cos, sin] = if r_mm > 0.0 { [x_mm / r_mm, y_mm / r_mm] } else { [1.0, 0.0] };
        Some(Jet {
            height_mm: self.nominal.sag_mm(r_mm),
            slope: [slope * cos, slope * sin],
            bend_per_mm: [
                along * cos * cos + across * sin * sin,
                (along - across) * cos * sin,
                along * sin * sin + across * cos * cos,
            ],
        })
    }

    fn extent_mm(&self) -> [[f64; 2]; 2] {
        [[-self.radius_mm; 2], [self.radius_mm; 2]]
    }
}

/// Steps of the raster across the disc.
const RASTER: f64 = 48.0;
/// Places along the meridian.
const NODES: usize = 65;
/// How far values are refined, as a share.
const TOLERANCE: f64 = 1e-3;
/// At the end of its domain a nominal stands upright.
const WITHIN: f64 = 1.0 - 1e-6;

#[cfg(test)]
mod tests {
    use asphera_form::Asphere;

    use super::*;

    #[test]
    fn a_sphere_has_its_radius_everywhere() {
        let sphere = Nominal::Sphere { radius_mm: -20.0 };
        let meridian = Meridian::of(&sphere, 9.0).unwrap();
        for r_mm in [0.0, 0.01, 4.4, 9.0, 30.0] {
            let found = meridian.at(r_mm).unwrap();
            assert!((found / 20.0 - 1.0).abs() < 3e-3, "{found} at {r_mm}");
        }
        assert_eq!(meridian.at(f64::NAN), None);
        // A disc that reaches beyond the equator ends there.
        assert!(Meridian::of(&sphere, 50.0).unwrap().at(19.0).is_some());
    }

    #[test]
    fn a_plane_has_no_end_and_a_disc_needs_a_size() {
        assert_eq!(Meridian::of(&Nominal::Plane, 1.0).unwrap().at(0.7), Some(f64::INFINITY));
        let sphere = Nominal::Sphere { radius_mm: 20.0 };
        for radius_mm in [0.0, -1.0, f64::NAN] {
            assert!(Meridian::of(&sphere, radius_mm).is_err());
        }
    }

    /// The centre of curvature at the vertex of a paraboloid of radius of curvature R is the lowest point of
    /// its medial axis, which is its axis of revolution from there on up: at the distance r from the axis and
    /// the height r²/2R, the local feature size is the distance to that centre or, further out, r.
    #[test]
    fn a_paraboloid_after_its_formula() {
        let radius_mm = 10.0;
        let paraboloid = Nominal::Asphere(Asphere::new(radius_mm, -1.0, &[]).unwrap());
        let meridian = Meridian::of(&paraboloid, 12.0).unwrap();
        for r_mm in [0.0, 1.0, 3.3, 7.0, 11.0] {
            let height_mm = r_mm * r_mm / (2.0 * radius_mm);
            let expected = r_mm.hypot(radius_mm - height_mm);
            let found = meridian.at(r_mm).unwrap();
            assert!((found / expected - 1.0).abs() < 6e-3, "{found}, not {expected}, at {r_mm}");
        }
    }

    /// A paraboloid has its smallest at the vertex, so that a ring of it has it at its inner border. An oblate ellipsoid
    /// bends more and more strongly from its vertex on: a cap of it has its smallest at the rim, where it is the radius of
    /// curvature along the meridian, (R² - k·r²)^(3/2)/R².
    #[test]
    fn the_least_is_where_the_surface_has_it() {
        let conic =
            |radius_mm, conic| Nominal::Asphere(Asphere::new(radius_mm, conic, &[]).unwrap());
        let near = |found: Option<f64>, expected: f64| {
            assert!((found.unwrap() / expected - 1.0).abs() < 6e-3, "{found:?}, not {expected}");
        };
        let paraboloid = Meridian::of(&conic(4.0, -1.0), 6.0).unwrap();
        near(paraboloid.least_mm(0.0), 4.0);
        let height_mm = 3.3 * 3.3 / 8.0;
        near(paraboloid.least_mm(3.3), 3.3_f64.hypot(4.0 - height_mm));
        near(paraboloid.least_mm(6.0), 6.0);
        let ellipsoid = Meridian::of(&conic(10.0, 1.0), 6.0).unwrap();
        for inner_mm in [0.0, 3.3, 6.0] {
            near(ellipsoid.least_mm(inner_mm), 5.12);
        }
        // The centres of curvature of the rim are the nearest of the medial axis to the vertex, too.
        near(ellipsoid.at(0.0), 2.16_f64.hypot(5.741));
        let plane = Meridian::of(&Nominal::Plane, 1.0).unwrap();
        assert_eq!(plane.least_mm(0.3), Some(f64::INFINITY));
    }

    #[test]
    fn where_a_node_is_not_known_the_least_is_not() {
        let meridian = Meridian { scale_per_mm: 1.0, nodes_mm: vec![f64::NAN, 3.0, 2.0, 4.0] };
        assert_eq!([0.0, 0.5].map(|from_mm| meridian.least_mm(from_mm)), [None; 2]);
        assert_eq!(
            [1.0, 2.0, 2.5, 9.0].map(|from| meridian.least_mm(from)),
            [2.0, 2.0, 3.0, 4.0].map(Some)
        );
    }
}
