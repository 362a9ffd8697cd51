//! Pieces of a curve and what they make.

use serde::{Deserialize, Serialize};

/// A piece of a curve, or what pieces make together. Lengths are mm, angles degrees; `u_` are standard
/// uncertainties (k = 1) by the noise of the points.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum FeatureFigures {
    /// `angle_deg` is that from x, 0 to below 180; `middle_mm` the mean of its points.
    Line {
        /// Curve, counted from 0.
        chain: usize,
        /// Its two ends.
        ends_mm: [[f64; 2]; 2],
        /// Its angle.
        angle_deg: f64,
        /// Uncertainty of `angle_deg`.
        u_angle_deg: f64,
        /// Mean of its points.
        middle_mm: [f64; 2],
        /// Uncertainty of its place across, at the middle.
        u_across_mm: f64,
        /// Straightness deviation, least squares.
        straightness_mm: f64,
        /// Number of its points.
        points: usize,
    },
    /// `sweep_deg` is above 0 counter-clockwise.
    Arc {
        /// Curve, counted from 0.
        chain: usize,
        /// Its two ends.
        ends_mm: [[f64; 2]; 2],
        /// Centre.
        centre_mm: [f64; 2],
        /// Uncertainty of `centre_mm`.
        u_centre_mm: [f64; 2],
        /// Radius.
        radius_mm: f64,
        /// Uncertainty of `radius_mm`.
        u_radius_mm: f64,
        /// Angle that it spans.
        sweep_deg: f64,
        /// Roundness deviation, least squares.
        roundness_mm: f64,
        /// Number of its points.
        points: usize,
    },
    /// A piece that is neither within the noise.
    Free {
        /// Curve, counted from 0.
        chain: usize,
        /// Its two ends.
        ends_mm: [[f64; 2]; 2],
        /// Number of its points.
        points: usize,
    },
    /// The place where two pieces meet when they go on; the angle is that on the inner side.
    Corner {
        /// Curve, counted from 0.
        chain: usize,
        /// Place.
        at_mm: [f64; 2],
        /// Uncertainty of `at_mm`.
        u_at_mm: [f64; 2],
        /// Its angle.
        angle_deg: f64,
        /// Uncertainty of `angle_deg`.
        u_angle_deg: f64,
    },
    /// `width_mm` is the length of its face; legs and angles are those to the line before and the one after.
    Chamfer {
        /// Curve, counted from 0.
        chain: usize,
        /// Place.
        at_mm: [f64; 2],
        /// Length of the face.
        width_mm: f64,
        /// Uncertainty of `width_mm`.
        u_width_mm: f64,
        /// Legs along the line before and the one after.
        legs_mm: [f64; 2],
        /// Uncertainty of `legs_mm`.
        u_legs_mm: [f64; 2],
        /// Angles to the line before and the one after.
        angles_deg: [f64; 2],
        /// Uncertainty of `angles_deg`.
        u_angles_deg: [f64; 2],
    },
    /// An arc between two lines, and the angle between these on the inner side.
    Edge {
        /// Curve, counted from 0.
        chain: usize,
        /// Place.
        at_mm: [f64; 2],
        /// Radius.
        radius_mm: f64,
        /// Uncertainty of `radius_mm`.
        u_radius_mm: f64,
        /// Its angle.
        angle_deg: f64,
        /// Uncertainty of `angle_deg`.
        u_angle_deg: f64,
    },
    /// The area that a closed curve encloses; the perimeter is there of lines and arcs only.
    Enclosed {
        /// Curve, counted from 0.
        chain: usize,
        /// Area.
        area_mm2: f64,
        /// Uncertainty of `area_mm2`.
        u_area_mm2: f64,
        /// Perimeter.
        perimeter_mm: Option<f64>,
        /// Uncertainty of `perimeter_mm`.
        u_perimeter_mm: Option<f64>,
    },
    /// A closed curve as the section of an airfoil, where that is asked for. `ends_mm` are leading and trailing edge.
    Airfoil {
        /// Curve, counted from 0.
        chain: usize,
        /// Chord.
        chord_mm: f64,
        /// Uncertainty of `chord_mm`.
        u_chord_mm: f64,
        /// Its two ends.
        ends_mm: [[f64; 2]; 2],
        /// Largest thickness.
        thickness_mm: f64,
        /// Uncertainty of `thickness_mm`.
        u_thickness_mm: f64,
        /// Place of the largest thickness.
        thickest_mm: [f64; 2],
        /// Radius of the leading edge.
        leading_radius_mm: Option<f64>,
        /// Uncertainty of `leading_radius_mm`.
        u_leading_radius_mm: Option<f64>,
        /// Radius of the trailing edge.
        trailing_radius_mm: Option<f64>,
        /// Uncertainty of `trailing_radius_mm`.
        u_trailing_radius_mm: Option<f64>,
    },
}
