//! The region that is scanned.

use crate::PlanError;
use crate::error::positive;

/// A region about a centre. The border belongs to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// A disc.
    Circle {
        /// Radius in mm.
        radius_mm: f64,
    },
    /// A rectangle with its sides along x and y.
    Rectangle {
        /// Size along x in mm.
        width_mm: f64,
        /// Size along y in mm.
        height_mm: f64,
    },
    /// A ring.
    Annulus {
        /// Inner radius in mm.
        inner_mm: f64,
        /// Outer radius in mm.
        outer_mm: f64,
    },
}

impl Aperture {
    /// Fails unless every size is positive and finite and a ring is not empty.
    ///
    /// # Errors
    ///
    /// With the key of the size.
    pub fn validate(&self) -> Result<(), PlanError> {
        let cure = "give the size of the part";
        match *self {
            Aperture::Circle { radius_mm } => {
                positive("aperture.radius_mm", radius_mm, cure).map(|_| ())
            }
            Aperture::Rectangle { width_mm, height_mm } => {
                positive("aperture.width_mm", width_mm, cure)?;
                positive("aperture.height_mm", height_mm, cure).map(|_| ())
            }
            Aperture::Annulus { inner_mm, outer_mm } => {
                positive("aperture.outer_mm", outer_mm, cure)?;
                if inner_mm >= 0.0 && inner_mm < outer_mm {
                    return Ok(());
                }
                Err(PlanError::new(
                    "aperture.inner_mm",
                    format!("a number from 0 to below the outer radius, {outer_mm} mm"),
                    format!("{inner_mm} mm"),
                    "give a ring that is not empty",
                ))
            }
        }
    }

    /// Whether a place beside the centre, in mm, belongs to it, to rounding.
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let slack = ROUNDING * self.reach_mm();
        match *self {
            Aperture::Circle { radius_mm } => x.hypot(y) <= radius_mm + slack,
            Aperture::Rectangle { width_mm, height_mm } => {
                x.abs() <= 0.5 * width_mm + slack && y.abs() <= 0.5 * height_mm + slack
            }
            Aperture::Annulus { inner_mm, outer_mm } => {
                let r = x.hypot(y);
                r >= inner_mm - slack && r <= outer_mm + slack
            }
        }
    }

    /// The largest distance of a place of it from the centre, in mm.
    pub fn reach_mm(&self) -> f64 {
        match *self {
            Aperture::Circle { radius_mm } => radius_mm,
            Aperture::Rectangle { width_mm, height_mm } => 0.5 * width_mm.hypot(height_mm),
            Aperture::Annulus { outer_mm, .. } => outer_mm,
        }
    }

    /// The smallest distance of a place of it from the centre, in mm.
    pub fn inner_mm(&self) -> f64 {
        match *self {
            Aperture::Annulus { inner_mm, .. } => inner_mm,
            Aperture::Circle { .. } | Aperture::Rectangle { .. } => 0.0,
        }
    }

    /// Its area in mm².
    pub fn area_mm2(&self) -> f64 {
        use std::f64::consts::PI;
        match *self {
            Aperture::Circle { radius_mm } => PI * radius_mm * radius_mm,
            Aperture::Rectangle { width_mm, height_mm } => width_mm * height_mm,
            Aperture::Annulus { inner_mm, outer_mm } => {
                PI * (outer_mm - inner_mm) * (outer_mm + inner_mm)
            }
        }
    }

    /// The aperture with its edges further out by `margin_mm`; the hole of a ring ends at nothing.
    #[must_use]
    pub fn widened(&self, margin_mm: f64) -> Aperture {
        match *self {
            Aperture::Circle { radius_mm } => Aperture::Circle { radius_mm: radius_mm + margin_mm },
            Aperture::Rectangle { width_mm, height_mm } => Aperture::Rectangle {
                width_mm: width_mm + 2.0 * margin_mm,
                height_mm: height_mm + 2.0 * margin_mm,
            },
            Aperture::Annulus { inner_mm, outer_mm } => Aperture::Annulus {
                inner_mm: (inner_mm - margin_mm).max(0.0),
                outer_mm: outer_mm + margin_mm,
            },
        }
    }

    /// The place of it that is nearest to one beyond its border.
    pub(crate) fn nearest(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let on_circle = |radius_mm: f64| {
            let r = x.hypot(y);
            if r > 0.0 { [x, y].map(|mm| mm * radius_mm / r) } else { [radius_mm, 0.0] }
        };
        match *self {
            Aperture::Circle { radius_mm } => on_circle(radius_mm),
            Aperture::Rectangle { width_mm, height_mm } => {
                let half = [0.5 * width_mm, 0.5 * height_mm];
                [x.clamp(-half[0], half[0]), y.clamp(-half[1], half[1])]
            }
            Aperture::Annulus { inner_mm, outer_mm } => {
                on_circle(if x.hypot(y) < inner_mm { inner_mm } else { outer_mm })
            }
        }
    }

    /// Half its size along y in mm.
    pub(crate) fn half_height_mm(&self) -> f64 {
        match *self {
            Aperture::Rectangle { height_mm, .. } => 0.5 * height_mm,
            Aperture::Circle { .. } | Aperture::Annulus { .. } => self.reach_mm(),
        }
    }

    /// The stretches of the line at a height `y_mm` inside it, from and to in x, from left to right.
    pub(crate) fn chords(&self, y_mm: f64) -> Vec<[f64; 2]> {
        let half = |radius_mm: f64| (radius_mm - y_mm.abs()) * (radius_mm + y_mm.abs());
        match *self {
            Aperture::Rectangle { width_mm, .. } => vec![[-0.5 * width_mm, 0.5 * width_mm]],
            Aperture::Circle { radius_mm } => {
                let outer = half(radius_mm).max(0.0).sqrt();
                vec![[-outer, outer]]
            }
            Aperture::Annulus { inner_mm, outer_mm } => {
                let outer = half(outer_mm).max(0.0).sqrt();
                let hole = half(inner_mm);
                if hole <= 0.0 {
                    return vec![[-outer, outer]];
                }
                vec![[-outer, -hole.sqrt()], [hole.sqrt(), outer]]
            }
        }
    }

    /// How far a ray from the centre at an angle reaches, in mm.
    pub(crate) fn ray_mm(&self, angle_rad: f64) -> f64 {
        match *self {
            Aperture::Rectangle { width_mm, height_mm } => {
                let (sin, cos) = angle_rad.sin_cos();
                (0.5 * width_mm / cos.abs()).min(0.5 * height_mm / sin.abs())
            }
            Aperture::Circle { .. } | Aperture::Annulus { .. } => self.reach_mm(),
        }
    }

    /// The stretches of a circle about the centre that lie inside it, as angles from and to.
    pub(crate) fn arcs(&self, radius_mm: f64) -> Vec<[f64; 2]> {
        use std::f64::consts::{PI, TAU};
        let Aperture::Rectangle { width_mm, height_mm } = *self else {
            return vec![[0.0, TAU]];
        };
        let mut cuts = Vec::new();
        let [a, b] = [0.5 * width_mm / radius_mm, 0.5 * height_mm / radius_mm];
        if a < 1.0 {
            cuts.extend([a.acos(), PI - a.acos(), PI + a.acos(), TAU - a.acos()]);
        }
        if b < 1.0 {
            cuts.extend([b.asin(), PI - b.asin(), PI + b.asin(), TAU - b.asin()]);
        }
        if cuts.is_empty() {
            return vec![[0.0, TAU]];
        }
        cuts.sort_by(f64::total_cmp);
        let next = cuts.iter().skip(1).copied().chain([cuts[0] + TAU]);
        let stretches = cuts.iter().copied().zip(next);
        let inside = |from: f64, to: f64| {
            let (sin, cos) = (0.5 * (from + to)).sin_cos();
            to - from > 1e-9 && self.contains([radius_mm * cos, radius_mm * sin])
        };
        stretches.filter(|&(from, to)| inside(from, to)).map(|(from, to)| [from, to]).collect()
    }
}

/// A border belongs to its region though its places are rounded.
const ROUNDING: f64 = 1e-9;
