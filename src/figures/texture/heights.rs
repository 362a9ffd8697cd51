//! Height parameters.

use super::{Parameter, Support, Surface, Unknown};
use crate::Figure;

/// The height parameters of ISO 25178-2:2021, 4.2, about the datum of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightParameters {
    /// Mean of |z| in nm.
    pub sa_nm: f64,
    /// Root of the mean of z² in nm.
    pub sq_nm: f64,
    /// Mean of z³ over Sq³; `None` where every height is 0.
    pub ssk: Option<f64>,
    /// Mean of z⁴ over Sq⁴, 3 for normal heights; `None` as above.
    pub sku: Option<f64>,
    /// Largest height in nm.
    pub sp_nm: f64,
    /// Minus the smallest height in nm.
    pub sv_nm: f64,
    /// Sp + Sv in nm.
    pub sz_nm: f64,
    /// Samples that they rest on.
    pub support: Support,
}

impl HeightParameters {
    /// Those that are known.
    pub fn figures(&self) -> Vec<Figure> {
        let known = [
            (Parameter::Sa, Some(self.sa_nm)),
            (Parameter::Sq, Some(self.sq_nm)),
            (Parameter::Ssk, self.ssk),
            (Parameter::Sku, self.sku),
            (Parameter::Sp, Some(self.sp_nm)),
            (Parameter::Sv, Some(self.sv_nm)),
            (Parameter::Sz, Some(self.sz_nm)),
        ];
        Parameter::known(&known)
    }
}

/// The height parameters of a surface. Means are weighted by area. `O(n)`. Unknown if no node counts.
pub fn height_parameters(surface: Surface<'_>) -> Result<HeightParameters, Unknown> {
    let nodes = surface.nodes()?;
    let [low, high] = nodes.range_nm();
    let largest = high.abs().max(low.abs());
    let heights = &nodes.heights_nm;
    // In units of the largest, so that powers of small heights do not vanish.
    let unit = if largest > 0.0 { largest } else { 1.0 };
    let scaled = |power: i32| nodes.mean(|i| (heights[i] / unit).powi(power));
    let square = scaled(2);
    let shape =
        |power: i32| (largest > 0.0).then(|| scaled(power) / square.powf(0.5 * f64::from(power)));
    Ok(HeightParameters {
        sa_nm: nodes.mean(|i| heights[i].abs()),
        sq_nm: square.sqrt() * unit,
        ssk: shape(3),
        sku: shape(4),
        sp_nm: high,
        sv_nm: -low,
        sz_nm: high - low,
        support: nodes.support,
    })
}
