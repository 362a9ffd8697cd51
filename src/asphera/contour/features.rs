//! Pieces of a curve and what they make.

use asphera_contour::features::{Airfoil, Course, Estimate, Feature, Profile};
use asphera_report::contour::FeatureFigures;

/// The features of curves.
#[derive(Default)]
pub(super) struct Found {
    /// In the order of the curves.
    pub(super) features: Vec<FeatureFigures>,
    /// What is not known of them.
    pub(super) unknown: Vec<String>,
    /// Whether a curve bridges a gap.
    pub(super) has_bridge: bool,
}

/// The features of courses, in their order, and what is not known of them.
pub(super) fn features_of(courses: &[Course], tolerance_mm: f64, is_airfoil: bool) -> Found {
    let Found { mut features, mut unknown, mut has_bridge } = Found::default();
    for (chain, course) in courses.iter().enumerate() {
        let profile = Profile::new(course, tolerance_mm);
        features.extend(profile.features.iter().map(|it| feature_of(chain, it)));
        features.extend(profile.area_mm2.map(|area_mm2| FeatureFigures::Enclosed {
            chain,
            area_mm2: area_mm2.value,
            u_area_mm2: area_mm2.u,
            perimeter_mm: profile.perimeter_mm.map(|it| it.value),
            u_perimeter_mm: profile.perimeter_mm.map(|it| it.u),
        }));
        has_bridge |= !profile.bridges.is_empty();
        let mut reasons = profile.unknown;
        if is_airfoil {
            match Airfoil::new(course) {
                Ok(airfoil) => {
                    features.push(airfoil_of(chain, &airfoil));
                    reasons.extend(airfoil.unknown);
                }
                Err(why) => reasons.push(why),
            }
        }
        let name = if courses.len() > 1 { format!("curve {chain}: ") } else { String::new() };
        unknown.extend(reasons.into_iter().map(|why| format!("{name}{why}")));
    }
    Found { features, unknown, has_bridge }
}

/// A feature of a curve.
fn feature_of(chain: usize, feature: &Feature) -> FeatureFigures {
    let values = |[p, q]: [Estimate; 2]| [p.value, q.value];
    let u = |[p, q]: [Estimate; 2]| [p.u, q.u];
    match *feature {
        Feature::Line { ends_mm, angle_deg, middle_mm, u_across_mm, straightness_mm, points } => {
            FeatureFigures::Line {
                chain,
                ends_mm,
                angle_deg: angle_deg.value,
                u_angle_deg: angle_deg.u,
                middle_mm,
                u_across_mm,
                straightness_mm,
                points,
            }
        }
        Feature::Arc { ends_mm, centre_mm, radius_mm, sweep_deg, roundness_mm, points } => {
            FeatureFigures::Arc {
                chain,
                ends_mm,
                centre_mm: values(centre_mm),
                u_centre_mm: u(centre_mm),
                radius_mm: radius_mm.value,
                u_radius_mm: radius_mm.u,
                sweep_deg,
                roundness_mm,
                points,
            }
        }
        Feature::Free { ends_mm, points } => FeatureFigures::Free { chain, ends_mm, points },
        Feature::Corner { at_mm, angle_deg } => FeatureFigures::Corner {
            chain,
            at_mm: values(at_mm),
            u_at_mm: u(at_mm),
            angle_deg: angle_deg.value,
            u_angle_deg: angle_deg.u,
        },
        Feature::Chamfer { at_mm, width_mm, legs_mm, angles_deg } => FeatureFigures::Chamfer {
            chain,
            at_mm,
            width_mm: width_mm.value,
            u_width_mm: width_mm.u,
            legs_mm: values(legs_mm),
            u_legs_mm: u(legs_mm),
            angles_deg: values(angles_deg),
            u_angles_deg: u(angles_deg),
        },
        Feature::Edge { at_mm, radius_mm, angle_deg } => FeatureFigures::Edge {
            chain,
            at_mm,
            radius_mm: radius_mm.value,
            u_radius_mm: radius_mm.u,
            angle_deg: angle_deg.value,
            u_angle_deg: angle_deg.u,
        },
    }
}

/// The section of an airfoil.
fn airfoil_of(chain: usize, airfoil: &Airfoil) -> FeatureFigures {
    let [leading, trailing] = [airfoil.leading_radius_mm, airfoil.trailing_radius_mm];
    FeatureFigures::Airfoil {
        chain,
        chord_mm: airfoil.chord_mm.value,
        u_chord_mm: airfoil.chord_mm.u,
        ends_mm: airfoil.ends_mm,
        thickness_mm: airfoil.thickness_mm.value,
        u_thickness_mm: airfoil.thickness_mm.u,
        thickest_mm: airfoil.thickest_mm,
        leading_radius_mm: leading.map(|it| it.value),
        u_leading_radius_mm: leading.map(|it| it.u),
        trailing_radius_mm: trailing.map(|it| it.value),
        u_trailing_radius_mm: trailing.map(|it| it.u),
    }
}
