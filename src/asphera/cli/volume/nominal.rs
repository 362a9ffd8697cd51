//! Whether the grid is fine enough for the face that a nominal describes.

use asphera_form::Pose;
use asphera_geometry::PointMm;
use asphera_geometry::vector::length;
use asphera_measure::{Part, Remembered, sampling_of_mesh};
use asphera_mesh::Mesh;
use asphera_surface::Plane;
use asphera_volume::{GridCheck, Verdict, needed_spacing_mm};
use serde::Serialize;

use super::super::output::Failure;

/// What the reach of a nominal asks of the grid. It says nothing of the rest of the part.
#[derive(Debug, Serialize)]
pub(super) struct NominalFigures {
    pub(super) verdict: &'static str,
    pub(super) why: String,
    /// The smallest local feature size of the face on both sides; absent of a plane, which has none.
    pub(super) reach_mm: Option<f64>,
    /// Samples must be nearer than this; absent of a plane.
    pub(super) needed_spacing_mm: Option<f64>,
    /// Needed over real spacing.
    pub(super) margin: Option<f64>,
    #[serde(skip)]
    pub(super) known: Verdict,
}

/// Compares the reach of a nominal over its aperture with the steps between samples.
pub(super) fn of(
    part: &Part,
    steps_mm: [[f64; 3]; 3],
    check: &GridCheck,
) -> Result<NominalFigures, Failure> {
    if part.reference.is_some() {
        return Err("--nominal: expected a design, found a surface of kind \"unknown\"".into());
    }
    let points = places(part)?;
    let mut mesh = Mesh::new();
    mesh.extend(points.iter().copied());
    mesh.flush();
    let mut remembered = Remembered::default();
    sampling_of_mesh(&mesh, part, &Pose::default(), &Plane::XY, &mut remembered);
    let reach_mm = remembered.reach_mm(&part.aperture, mesh.points(), &Pose::default());
    let Some(reach_mm) = reach_mm else {
        return Ok(NominalFigures {
            verdict: "unknown",
            why: "the reach of the nominal is not known".into(),
            reach_mm: None,
            needed_spacing_mm: None,
            margin: None,
            known: Verdict::Unknown,
        });
    };
    let coarsest_mm = steps_mm.map(length).into_iter().fold(0.0, f64::max);
    // Nothing is asked of the grid by a plane.
    let (known, why) = if reach_mm.is_finite() {
        check.verdict_on_axes(steps_mm, Some(reach_mm))
    } else {
        (Verdict::Unknown, "a plane asks for no spacing".to_owned())
    };
    let needed_mm = Some(needed_spacing_mm(reach_mm)).filter(|needed_mm| needed_mm.is_finite());
    Ok(NominalFigures {
        verdict: super::figures::word(known),
        why,
        reach_mm: Some(reach_mm).filter(|reach_mm| reach_mm.is_finite()),
        needed_spacing_mm: needed_mm,
        margin: needed_mm.map(|needed_mm| needed_mm / coarsest_mm),
        known,
    })
}

/// Places on the nominal over its aperture.
fn places(part: &Part) -> Result<Vec<PointMm>, Failure> {
    let none = "--nominal: expected an [aperture], over which its reach counts; found none";
    let half_mm = part.aperture.half_extents_mm().ok_or(none)?;
    let mut points = Vec::new();
    for j in -STEPS..=STEPS {
        for i in -STEPS..=STEPS {
            let [x, y] = [(i, half_mm[0]), (j, half_mm[1])]
                .map(|(step, half_mm)| f64::from(step) / f64::from(STEPS) * half_mm);
            let height = part.nominal.height_mm(x, y).filter(|_| part.aperture.contains(x, y));
            points.extend(height.map(|z| [x, y, z]));
        }
    }
    Ok(points)
}

/// Places from the middle of the aperture to its border.
const STEPS: i32 = 24;
