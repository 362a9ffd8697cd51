//! The figures by which standards and optical shops judge a form deviation.
//!
//! A [`Sample`] holds the places and deviations that count. From it come [`peak_to_valley`], [`rms`],
//! [`robust_peak_to_valley`] and [`pvr`], after [`remove`] if terms are to be taken out first;
//! [`decompose`] into the parts of ISO 10110-5, held against an [`Indication`]; the classical
//! [`Aberrations`] of a [`fringe_fit`]; the [`q_spectrum`]; [`slopes`]; [`radial_profile`] and
//! [`azimuthal_profile`]; and the power spectral densities [`line_psd`] and [`map_psd`], of places on a [`Lattice`] as they
//! are.
//!
//! Places are mm in the part frame, deviations come in mm and leave in nm, slopes are µrad. Each figure
//! carries its [`Definition`]. What the data cannot tell is an [`Unknown`] that says why, never a number.
//! Every mean is weighted by the area a point stands for where areas are given. Sums run over fixed chunks
//! joined in order: the same input gives the same bits whatever the number of threads.
//!
//! ```
//! use asphera_form::Aperture;
//! use asphera_figures::{Approximation, Indication, Sample, decompose};
//!
//! // 100 nm of power and 10 nm of astigmatism at the rim of a disc of 5 mm.
//! let places: Vec<[f64; 2]> =
//!     (0..2000).map(|i| (0.05 * f64::from(i).sqrt(), 2.4 * f64::from(i)))
//!         .map(|(r, phi)| [2.2 * r * phi.cos(), 2.2 * r * phi.sin()])
//!         .collect();
//! let nm = |[x, y]: [f64; 2]| (100.0 * (x * x + y * y) + 10.0 * (x * x - y * y)) / 25.0;
//! let deviations_mm: Vec<f64> = places.iter().map(|&place| nm(place) * 1e-6).collect();
//!
//! let aperture = Aperture::Circle { radius_mm: 5.0 };
//! let sample = Sample::new(&places, &deviations_mm, None, &aperture)?;
//! let found = decompose(&sample, Approximation::Quadratic, None)?;
//! assert!((found.a_nm - 100.0).abs() < 0.1 && (found.b_nm - 20.0).abs() < 1.0);
//!
//! // Half a fringe of power and a tenth of irregularity are allowed at 546 nm.
//! let limits: Indication = "3/0.5(0.1); λ=546".parse()?;
//! assert!(limits.compare(&found).iter().all(|comparison| comparison.holds()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Deliberately absent: alignment and fits of the nominal (see [`asphera_form::fit`]), uncertainties, filters.

mod aberration;
mod amplitude;
mod catalogue;
mod definition;
mod expansion;
mod formation;
mod fourier;
mod indication;
mod interpolation;
mod invariant;
mod irregularity;
mod lattice;
mod least_squares;
mod profile;
mod psd_line;
mod psd_map;
mod q_spectrum;
mod removal;
mod sample;
mod slope;
mod statistic;
mod subject;
pub mod texture;
mod unknown;

pub use aberration::{Aberrations, Directed, SpectrumLine};
pub use amplitude::{Reference, Share, peak_to_valley, pvr, rms, robust_peak_to_valley};
pub use catalogue::Definition;
pub use definition::{Figure, Unit};
pub use expansion::fringe_orders;
pub use expansion::{FringeCount, FringeFit, fringe_fit};
pub use formation::Formation;
pub use indication::{Comparison, Indication, IndicationError, LengthUnit};
pub use interpolation::Interpolation;
pub use irregularity::{Approximation, Irregularity, decompose};
pub use irregularity::{irregular, sagitta_gains};
pub use lattice::Lattice;
pub use least_squares::joined;
pub use profile::{Heights, Ring, Sector, azimuthal_profile, radial_profile};
pub use psd_line::{Band, HeightLine, LinePsd, Window, line_psd};
pub use psd_map::{FrequencyRing, HeightGrid, MapPsd, map_psd};
pub use q_spectrum::{QSpectrum, SeriesSlope, q_spectrum};
pub use removal::{Removed, Term, Terms, remove};
pub use sample::{LeftOut, Sample, SampleError};
pub use slope::{SlopeFigure, SlopeSettings, Slopes, slopes};
pub use statistic::Statistic;
pub use subject::{Subject, Treatment, is_motion};
pub use unknown::{SettingError, Unknown};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
