//! Uncertainties of points that were joined by time, as the fit weighs them.

use asphera_form::Nominal;
use asphera_geometry::Point as Weighed;
use asphera_measure::{Part, Weights};

use crate::station::Point;

/// Gives points of a station the uncertainty of their height, where the part asks for weights and the noise is known.
///
/// An error of the place changes the height over the part by its slope. Those along x, y and z come of one error of time, so
/// they add up; the noise of the gauge is independent of them.
#[derive(Clone, Debug)]
pub(crate) struct Weighing(Option<(Nominal, f64)>);

impl Weighing {
    /// For points of a part, whose heights have this noise.
    pub(crate) fn new(part: &Part, noise_mm: Option<f64>) -> Weighing {
        let noise_mm = noise_mm.filter(|_| part.criterion.weights == Weights::Uncertainty);
        Weighing(noise_mm.map(|noise_mm| (part.nominal.clone(), noise_mm)))
    }

    /// Whether points get uncertainties.
    pub(crate) fn is_known(&self) -> bool {
        self.0.is_some()
    }

    /// A point with its uncertainty.
    pub(crate) fn weighed(&self, point: &Point) -> Weighed {
        let Some((nominal, noise_mm)) = &self.0 else { return point.position_mm.into() };
        let ([x_mm, y_mm, _], [u_x_mm, u_y_mm, u_z_mm]) = (point.position_mm, point.u_mm);
        // Beyond the surface nothing is known of its slope; a steep one makes the point count little.
        let slope = |slope: f64| if slope.is_finite() { slope.abs() } else { STEEP };
        let [along_x, along_y] = nominal.gradient(x_mm, y_mm).map(slope);
        let of_place_mm = along_x * u_x_mm + along_y * u_y_mm + u_z_mm;
        Weighed { at_mm: point.position_mm, u_z_mm: Some(of_place_mm.hypot(*noise_mm)) }
    }
}

/// Slope where the nominal has none.
const STEEP: f64 = 10.0;

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_form::Nominal;
    use asphera_link::{Flags, Nanos};

    #[test]
    fn an_error_along_a_slope_is_one_of_height() {
        let mut part = Part::new(Nominal::Sphere { radius_mm: 50.0 });
        let point = Point {
            count: None,
            host: Nanos::ZERO,
            position_mm: [30.0, 0.0, 10.0],
            flags: Flags::empty(),
            u_mm: [0.004, 0.5, 0.0],
        };
        assert_eq!(Weighing::new(&part, Some(0.001)).weighed(&point).u_z_mm, None);
        part.criterion.weights = Weights::Uncertainty;
        assert!(!Weighing::new(&part, None).is_known());
        // At 30 mm of a sphere of 50 mm the slope is 3/4 along x and none along y.
        let u_mm = Weighing::new(&part, Some(0.004)).weighed(&point).u_z_mm.unwrap();
        assert!((u_mm - 0.005).abs() < 1e-9, "{u_mm}");
    }
}
