//! Pieces of a curve and what they make, as the command writes them.

use std::fmt::Write as _;

use asphera_contour::PlaceMm;
use asphera_contour::features::{Airfoil, Course, Estimate, Feature, Profile};
use serde::{Deserialize, Serialize};

use crate::cli::summary::short;

/// A piece of a curve, or what pieces make together. Lengths are mm, angles degrees; `u_` are standard uncertainties by the noise of the points,
/// `chain` is the curve, counted from 0.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(in crate::cli) enum FeatureFigures {
    /// `angle_deg` is that from x, 0 to below 180; `middle_mm` the mean of its points.
    Line {
        chain: usize,
        ends_mm: [PlaceMm; 2],
        angle_deg: f64,
        u_angle_deg: f64,
        middle_mm: PlaceMm,
        u_across_mm: f64,
        straightness_mm: f64,
        points: usize,
    },
    /// `sweep_deg` is above 0 counter-clockwise.
    Arc {
        chain: usize,
        ends_mm: [PlaceMm; 2],
        centre_mm: PlaceMm,
        u_centre_mm: [f64; 2],
        radius_mm: f64,
        u_radius_mm: f64,
        sweep_deg: f64,
        roundness_mm: f64,
        points: usize,
    },
    /// A piece that is neither within the noise.
    Free { chain: usize, ends_mm: [PlaceMm; 2], points: usize },
    /// Where two pieces meet when they go on; the angle is that on the inner side.
    Corner { chain: usize, at_mm: PlaceMm, u_at_mm: [f64; 2], angle_deg: f64, u_angle_deg: f64 },
    /// `width_mm` is the length of its face; legs and angles are those to the line before and the one after.
    Chamfer {
        chain: usize,
        at_mm: PlaceMm,
        width_mm: f64,
        u_width_mm: f64,
        legs_mm: [f64; 2],
        u_legs_mm: [f64; 2],
        angles_deg: [f64; 2],
        u_angles_deg: [f64; 2],
    },
    /// An arc between two lines, and the angle between these on the inner side.
    Edge {
        chain: usize,
        at_mm: PlaceMm,
        radius_mm: f64,
        u_radius_mm: f64,
        angle_deg: f64,
        u_angle_deg: f64,
    },
    /// What a closed curve encloses; the perimeter is there of lines and arcs only.
    Enclosed {
        chain: usize,
        area_mm2: f64,
        u_area_mm2: f64,
        perimeter_mm: Option<f64>,
        u_perimeter_mm: Option<f64>,
    },
    /// A closed curve as the section of an airfoil, where --airfoil asks for it. `ends_mm` are leading and trailing edge.
    Airfoil {
        chain: usize,
        chord_mm: f64,
        u_chord_mm: f64,
        ends_mm: [PlaceMm; 2],
        thickness_mm: f64,
        u_thickness_mm: f64,
        thickest_mm: PlaceMm,
        leading_radius_mm: Option<f64>,
        u_leading_radius_mm: Option<f64>,
        trailing_radius_mm: Option<f64>,
        u_trailing_radius_mm: Option<f64>,
    },
}

/// The features of courses, in their order, and what is not known of them.
pub(super) fn features_of(
    courses: &[Course],
    tolerance_mm: f64,
    is_airfoil: bool,
) -> (Vec<FeatureFigures>, Vec<String>) {
    let (mut features, mut unknown) = (Vec::new(), Vec::new());
    for (chain, course) in courses.iter().enumerate() {
        let profile = Profile::new(course, tolerance_mm);
        features.extend(profile.features.iter().map(|it| FeatureFigures::new(chain, it)));
        features.extend(profile.area_mm2.map(|area_mm2| FeatureFigures::Enclosed {
            chain,
            area_mm2: area_mm2.value,
            u_area_mm2: area_mm2.u,
            perimeter_mm: profile.perimeter_mm.map(|it| it.value),
            u_perimeter_mm: profile.perimeter_mm.map(|it| it.u),
        }));
        let mut told = profile.unknown;
        if is_airfoil {
            match Airfoil::new(course) {
                Ok(airfoil) => {
                    features.push(FeatureFigures::of_airfoil(chain, &airfoil));
                    told.extend(airfoil.unknown);
                }
                Err(why) => told.push(why),
            }
        }
        let name = if courses.len() > 1 { format!("curve {chain}: ") } else { String::new() };
        unknown.extend(told.into_iter().map(|why| format!("{name}{why}")));
    }
    (features, unknown)
}

impl FeatureFigures {
    fn new(chain: usize, feature: &Feature) -> FeatureFigures {
        let values = |[p, q]: [Estimate; 2]| [p.value, q.value];
        let u = |[p, q]: [Estimate; 2]| [p.u, q.u];
        match *feature {
            Feature::Line {
                ends_mm,
                angle_deg,
                middle_mm,
                u_across_mm,
                straightness_mm,
                points,
            } => FeatureFigures::Line {
                chain,
                ends_mm,
                angle_deg: angle_deg.value,
                u_angle_deg: angle_deg.u,
                middle_mm,
                u_across_mm,
                straightness_mm,
                points,
            },
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

    fn of_airfoil(chain: usize, airfoil: &Airfoil) -> FeatureFigures {
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

    /// The line of the summary.
    pub(super) fn write_summary(&self, text: &mut String) -> std::fmt::Result {
        let with =
            |value: f64, u: f64, unit: &str| format!("{value:.6} {unit}, u {} {unit}", short(u));
        let at = |[x, y]: PlaceMm| format!("{}, {} mm", short(x), short(y));
        match *self {
            FeatureFigures::Line { ends_mm, angle_deg, u_angle_deg, points, .. } => writeln!(
                text,
                "line       {} to {}: {}, {points} points",
                at(ends_mm[0]),
                at(ends_mm[1]),
                with(angle_deg, u_angle_deg, "deg")
            ),
            FeatureFigures::Arc {
                centre_mm, radius_mm, u_radius_mm, sweep_deg, points, ..
            } => {
                writeln!(
                    text,
                    "arc        radius {}, about {}, over {:.1} deg, {points} points",
                    with(radius_mm, u_radius_mm, "mm"),
                    at(centre_mm),
                    sweep_deg.abs()
                )
            }
            FeatureFigures::Free { ends_mm, points, .. } => writeln!(
                text,
                "free       {} to {}, {points} points: neither line nor arc",
                at(ends_mm[0]),
                at(ends_mm[1])
            ),
            FeatureFigures::Corner { at_mm, angle_deg, u_angle_deg, .. } => {
                writeln!(text, "corner     {}: {}", at(at_mm), with(angle_deg, u_angle_deg, "deg"))
            }
            FeatureFigures::Chamfer { at_mm, width_mm, u_width_mm, angles_deg, .. } => writeln!(
                text,
                "chamfer    {}: width {}, {} and {} deg to the lines beside it",
                at(at_mm),
                with(width_mm, u_width_mm, "mm"),
                short(angles_deg[0]),
                short(angles_deg[1])
            ),
            FeatureFigures::Edge { at_mm, radius_mm, u_radius_mm, angle_deg, .. } => writeln!(
                text,
                "edge       {}: radius {} between lines at {} deg",
                at(at_mm),
                with(radius_mm, u_radius_mm, "mm"),
                short(angle_deg)
            ),
            FeatureFigures::Enclosed {
                area_mm2, u_area_mm2, perimeter_mm, u_perimeter_mm, ..
            } => {
                write!(text, "enclosed   {}", with(area_mm2, u_area_mm2, "mm²"))?;
                if let Some((length_mm, u_mm)) = perimeter_mm.zip(u_perimeter_mm) {
                    write!(text, "; perimeter {}", with(length_mm, u_mm, "mm"))?;
                }
                writeln!(text)
            }
            FeatureFigures::Airfoil { .. } => self.write_airfoil(text),
        }
    }

    fn write_airfoil(&self, text: &mut String) -> std::fmt::Result {
        let FeatureFigures::Airfoil {
            chord_mm,
            u_chord_mm,
            thickness_mm,
            u_thickness_mm,
            leading_radius_mm,
            u_leading_radius_mm,
            trailing_radius_mm,
            u_trailing_radius_mm,
            ..
        } = *self
        else {
            return Ok(());
        };
        let rows = [
            ("chord", Some(chord_mm), Some(u_chord_mm)),
            ("thickness", Some(thickness_mm), Some(u_thickness_mm)),
            ("leading", leading_radius_mm, u_leading_radius_mm),
            ("trailing", trailing_radius_mm, u_trailing_radius_mm),
        ];
        for (name, value, u) in rows {
            let Some((value, u)) = value.zip(u) else { continue };
            let radius = if name.ends_with("ing") { "radius " } else { "" };
            writeln!(text, "{name:<11}{radius}{value:.6} mm, u {} mm", short(u))?;
        }
        Ok(())
    }
}
