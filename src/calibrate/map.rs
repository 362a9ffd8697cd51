//! Errors of height as Zernike terms over a disc.

use asphera_form::basis::{Basis as _, Normalisation, Zernike};

/// Height as a series of Zernike terms of unit RMS over a disc about the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    radius_mm: f64,
    terms: Vec<(u32, i32, f64)>,
    series: Series,
}

impl HeightMap {
    /// The map of terms (n, m, coefficient in mm) over a disc. `None` where an order does not exist or stands twice,
    /// there is no term, or a number is not finite.
    pub fn new(radius_mm: f64, terms: Vec<(u32, i32, f64)>) -> Option<HeightMap> {
        let is_right = radius_mm.is_finite() && radius_mm > 0.0;
        let orders: Vec<(u32, i32)> = terms.iter().map(|&(n, m, _)| (n, m)).collect();
        let series = Series::new(&orders)?;
        (is_right && terms.iter().all(|(_, _, value)| value.is_finite())).then_some(HeightMap {
            radius_mm,
            terms,
            series,
        })
    }

    /// Radius of the disc, mm.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Orders and coefficients in mm.
    pub fn terms(&self) -> &[(u32, i32, f64)] {
        &self.terms
    }

    /// Height at a place in mm; `None` beyond the disc, where the terms tell nothing.
    pub fn height_mm(&self, [x_mm, y_mm]: [f64; 2]) -> Option<f64> {
        let [u, v] = [x_mm / self.radius_mm, y_mm / self.radius_mm];
        if u * u + v * v > RIM_SQUARE {
            return None;
        }
        let mut height_mm = 0.0;
        self.series.each(u, v, |term, value| height_mm += self.terms[term].2 * value);
        Some(height_mm)
    }
}

/// Rounding at the rim is no place beyond it.
const RIM_SQUARE: f64 = 1.0 + 1e-9;

/// Terms of unit RMS.
#[derive(Clone, Debug)]
pub(crate) struct Series(Zernike);

impl PartialEq for Series {
    fn eq(&self, other: &Series) -> bool {
        self.0.orders() == other.0.orders()
    }
}

impl Series {
    /// Terms by their orders; `None` where one does not exist or stands twice, and of no orders.
    pub(crate) fn new(orders: &[(u32, i32)]) -> Option<Series> {
        Zernike::of_orders(orders, Normalisation::UnitRms).ok().map(Series)
    }

    /// Shows the value of every term, each once.
    pub(crate) fn each(&self, u: f64, v: f64, mut visit: impl FnMut(usize, f64)) {
        self.0.each_value(u, v, &mut visit);
    }
}

/// Orders from 2 to a highest one: piston and tilts are those of the pose.
pub(crate) fn orders_to(highest: u32) -> Vec<(u32, i32)> {
    let of_order = |n: u32| {
        let n = n as i32;
        (-n..=n).step_by(2).map(move |m| (n as u32, m))
    };
    (2..=highest).flat_map(of_order).collect()
}
