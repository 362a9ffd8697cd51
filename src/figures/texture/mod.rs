//! Areal surface texture: the Gaussian filters of ISO 16610 and the parameters of ISO 25178-2.
//!
//! A surface is a [`Grid`] of heights with gaps or a triangulated [`Mesh`]; [`Grid::levelled`] takes out the
//! mean or the mean plane, a [`Gaussian`] separates wavelengths, and a [`Scale`] of two of them makes the S-F
//! or the S-L surface. Of either come [`height_parameters`] (Sa, Sq, Ssk, Sku, Sp, Sv, Sz),
//! [`hybrid_parameters`] (Sdq, Sdr), [`core_parameters`] (Sk, Spk, Svk, Smrk1, Smrk2) and
//! [`spatial_parameters`] (Sal, Str).
//!
//! Heights are nm, places mm, slopes µrad. What is not measured is a gap: it has no weight in any sum, and
//! no filter fills it. A node weighs as much as the area it stands for: equal on a grid, a third of each
//! triangle around it on a mesh. Every result carries its [`Support`], every figure its [`Definition`](crate::Definition); what
//! the data cannot tell is an [`Unknown`] that says why. The same input gives the same bits whatever the
//! number of threads.
//!
//! ```
//! use asphera_figures::texture::{Datum, Gaussian, Grid, Order, Scale, height_parameters};
//!
//! // Waves of 10 nm at 0.1 mm on waves of 100 nm at 2 mm, every 0.01 mm.
//! let wave = |x: f64, period: f64| (std::f64::consts::TAU * x / period).sin();
//! let row: Vec<f64> = (0..600).map(|i| f64::from(i) * 0.01)
//!     .map(|x| 10.0 * wave(x, 0.1) + 100.0 * wave(x, 2.0)).collect();
//! let grid = Grid::new(&row.repeat(20), 20, 600, [0.01, 0.01])?;
//!
//! let cut_off = Gaussian::new(0.4, Order::Two)?;
//! let rough = Scale::new(None, Some(cut_off))?.of_grid(&grid, Datum::AsGiven);
//! let found = height_parameters((&rough.surface).into())?;
//! assert!((found.sq_nm - 10.0 / 2f64.sqrt()).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Deliberately absent: the removal of form (see [`asphera_form::fit`]; give its deviations as heights), feature
//! and volume parameters, splines and morphological filters; uncertainties (see
//! the crate `asphera-uncertainty`).

mod autocorrelation;
mod binned_filter;
mod cells;
mod core_heights;
mod datum;
mod gaussian;
mod grid;
mod grid_filter;
mod heights;
mod hybrid;
mod mesh;
mod mesh_filter;
mod parameter;
mod raster;
mod rays;
mod regression;
mod response;
mod robust;
mod scale;
mod surface;
mod unknown;

pub use autocorrelation::{Autocorrelation, autocorrelation};
pub use core_heights::{CoreParameters, core_parameters};
pub use datum::Datum;
pub use gaussian::{Filtered, Gaussian, Order};
pub use grid::Grid;
pub use heights::{HeightParameters, height_parameters};
pub use hybrid::{HybridParameters, hybrid_parameters};
pub use mesh::Mesh;
pub use parameter::Parameter;
pub use rays::{Decay, SpatialParameters, Threshold, spatial_parameters};
pub use response::{Functions, NoiseLeft};
pub use robust::{Robust, RobustReport};
pub use scale::{Scale, ScaleKind, ScaleLimited};
pub use surface::{Support, Surface};
pub use unknown::{TextureError, Unknown};
