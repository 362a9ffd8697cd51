//! Errors that all points have together: of a calibration, of the radius of a ball tip, of temperatures.
//!
//! A [`Systematic`] says where one standard uncertainty of its source moves each point. The points are moved so, to either side, and
//! fitted anew. The larger change of a figure is its contribution to u of that figure:
//!
//! ```text
//! u² = u₀² + Σ cᵢ²        cᵢ = max(|f(x + δᵢ) − f(x)|, |f(x − δᵢ) − f(x)|)
//!
//! u₀   standard uncertainty by all else
//! f    a figure of the points x after the fit
//! δᵢ   displacements by one standard uncertainty of source i
//! ```
//!
//! (JCGM 100:2008, 5.1.3, note 2.) What the fit takes up is not in it. The larger side stands for figures that are sizes: of a part
//! without form error either side changes its RMS, and the central difference is 0.

mod contributions;
mod counted;
mod refit;

pub(crate) use contributions::Contributions;
pub(crate) use refit::Moving;

use std::fmt;
use std::sync::Arc;

use asphera_geometry::PointMm;
use asphera_geometry::vector::{Vector, plus};

use crate::tip::Tip;

/// An error that all points have together, known by its standard uncertainty. Sources are independent of each other.
#[derive(Clone)]
pub struct Systematic {
    source: String,
    effect: Effect,
}

/// What one standard uncertainty does to points.
#[derive(Clone)]
enum Effect {
    /// Displacements by place, both mm of the measured frame, each of an error of its own.
    Fields(Vec<Arc<Field>>),
    /// A larger radius of the ball, mm: contacts lie deeper by it along the normal, and where `is_lowest` higher along the probe.
    Ball { u_mm: f64, is_lowest: bool },
    /// Nothing that is known, and why.
    Unknown(String),
}

type Field = dyn Fn(PointMm) -> Vector + Send + Sync;

impl Systematic {
    /// An error that moves a point of the measured frame, mm, by a displacement, mm, for one standard uncertainty of it. `source` is
    /// its name in reports.
    pub fn new(
        source: impl Into<String>,
        displacement_mm: impl Fn(PointMm) -> Vector + Send + Sync + 'static,
    ) -> Systematic {
        Systematic::several(source, vec![displacement_mm])
    }

    /// A source of several errors that are independent of each other, such as those of the rows of a table.
    pub fn several<F>(source: impl Into<String>, displacements_mm: Vec<F>) -> Systematic
    where
        F: Fn(PointMm) -> Vector + Send + Sync + 'static,
    {
        let fields = displacements_mm.into_iter().map(|field| Arc::new(field) as Arc<Field>);
        Systematic { source: source.into(), effect: Effect::Fields(fields.collect()) }
    }

    /// A source that the figures cannot count, and why: reports say so.
    pub fn not_counted(source: impl Into<String>, why: impl Into<String>) -> Systematic {
        Systematic { source: source.into(), effect: Effect::Unknown(why.into()) }
    }

    /// The radius of a ball tip.
    pub(crate) fn of_tip(tip: &Tip) -> Systematic {
        let u_mm = tip.u_radius_mm();
        if u_mm > 0.0 {
            let effect = Effect::Ball { u_mm, is_lowest: tip.is_lowest() };
            return Systematic { source: BALL.to_owned(), effect };
        }
        Systematic::not_counted(BALL, "its standard uncertainty is not stated")
    }
}

impl fmt::Debug for Systematic {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Systematic({})", self.source)
    }
}

/// A point moved by a share of a displacement, mm.
fn moved(at_mm: PointMm, share: f64, by_mm: Vector) -> PointMm {
    plus(at_mm, share, by_mm)
}

/// Source of the radius of a ball tip in reports.
pub(crate) const BALL: &str = "radius of the ball tip";

#[cfg(test)]
mod tests;
