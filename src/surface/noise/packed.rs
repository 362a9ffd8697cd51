//! The spacing from which on noise turns no facet too far, whatever its shape.

use super::{Noise, SpacingCriteria};

impl SpacingCriteria {
    /// The spacing in mm of an even cloud, half squares or equilateral triangles, at which noise of
    /// `sigma_mm` along the normal turns facets by the limit: 2σ/τ.
    pub fn even_bound_mm(&self, sigma_mm: f64) -> f64 {
        2.0 * sigma_mm / self.tilt_limit_rad()
    }

    /// The spacing s in mm that is wide enough for facets of every shape: chosen among points so
    /// dense that every place of the surface has one within `gap_mm`, such that no two are nearer
    /// than s and every other one has a chosen one within s. `cosine` is that of the steepest slope.
    ///
    /// *Circles.* The centre of an empty circle between chosen points has a point within the gap g,
    /// and that a chosen one within its spacing, so the circle's radius is at most g + s. Where the
    /// spacing itself changes, by L for each mm of way, all three distances do: with L = ε/(1 + ε), as
    /// of a spacing that follows ε·lfs/(1 + ε), the radius is at most
    ///
    /// ```text
    ///     R = (1 + ε)·s + (1 + 2ε)·g                                                             (1)
    /// ```
    ///
    /// *Facets.* Let a facet have sides of s or more and a circumradius up to ρ·s, ρ ≥ 1. Its worst
    /// tilt is that of two sides s with the angle between them so wide that the radius is reached:
    ///
    /// ```text
    ///     tilt² = (σ/s)²·4ρ²(6ρ² - 1) / (4ρ² - 1) ≤ (σ/s)²·(6ρ² + 2/3)                           (2)
    /// ```
    ///
    /// For, with σ²(a² + b² + c²)/4A² as in [`crate::noise::facet_tilt_rad`], let a be the shortest
    /// side and γ the largest angle, between a and b. Scaled down until a = s it tilts more, and the
    /// radius shrinks. Then tilt² = σ²(2/a² + 2/b² - 2·cos γ/(a·b))/sin² γ grows as b is made
    /// shorter, since b·cos γ ≤ a/2 while b is not the longest side, and again the radius shrinks: b =
    /// s. What is left, σ²(4 - 2·cos γ)/(s·sin γ)², grows with γ from where it is 4, as for 60°, and
    /// the radius s/(2·cos(γ/2)) sets its end: with cos²(γ/2) = 1/4ρ² that is (2). At ρ = 1 the angle
    /// is 120° and the tilt √(20/3)·σ/s, 1.29 times that of an even facet of the same side.
    ///
    /// *Slopes.* Circles are empty in the plane of projection, sides are s in space. A facet whose
    /// normal has the z component c has projected sides of s·c or more, so ρ = R/(s·c); noise σ along
    /// z changes its gradient as (2) says for these, and turns its normal by c times that at most:
    /// the two c cancel.
    ///
    /// *Result.* √(6ρ² + 2/3) ≤ √6·ρ + √(20/3) - √6, equal at ρ = 1, makes tilt ≤ τ with (1) a quadratic
    /// equation for s; the larger root is given. On level ground among points without gaps it is
    /// √(20/3)·σ/τ but for the ε in (1).
    ///
    /// A gap is that of the points chosen from, at least 0 and finite; a cosine above 0, up to 1.
    pub fn packed_bound_mm(&self, noise: Noise, gap_mm: f64, cosine: f64) -> f64 {
        let scale_mm = noise.along_z_mm(cosine) / self.tilt_limit_rad();
        let epsilon = self.epsilon_limit();
        let steepness = 6.0_f64.sqrt() / cosine;
        let linear_mm = scale_mm * (steepness * (1.0 + epsilon) + EXCESS);
        let constant_mm2 = scale_mm * steepness * (1.0 + 2.0 * epsilon) * gap_mm;
        0.5 * (linear_mm + (linear_mm * linear_mm + 4.0 * constant_mm2).sqrt())
    }
}

/// √(20/3) - √6.
const EXCESS: f64 = 0.132_499_154_688_433;
