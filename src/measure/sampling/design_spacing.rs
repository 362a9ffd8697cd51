//! The spacing that a design needs, before anything is measured.

use std::f64::consts::{SQRT_2, TAU};

use asphera_form::{Aperture, Pose};
use asphera_geometry::PointMm;

use super::{Remembered, height_mm};
use crate::Part;

/// The spacing of a square raster in the plane that samples a design densely enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignSpacing {
    /// The spacing in mm; infinite of a plane without a limit of gaps.
    pub spacing_mm: f64,
    /// The smallest local feature size over the aperture in mm; infinite of a plane.
    pub lfs_min_mm: f64,
    /// The steepest slope over the aperture.
    pub slope_max: f64,
}

/// The spacing at which no gap exceeds ε times the local feature size anywhere in the aperture, nor the part's limit of gaps.
///
/// Half the diagonal of a square of the raster is the gap. On a slope t the square is longer in space, and the diagonal is longest where the slope
/// leads along a side: s·√(2 + t²) for a spacing s. So s is enough whichever way the slope leads.
///
/// # Errors
///
/// Without a design or an aperture, or where the local feature size is not known; in words.
pub fn design_spacing(part: &Part, epsilon: f64) -> Result<DesignSpacing, String> {
    if part.reference.is_some() {
        return Err("expected a design, found [surface] kind = \"unknown\"".to_owned());
    }
    let places: Vec<[f64; 2]> = places(&part.aperture)
        .ok_or("expected [aperture] with a shape, found none: nothing says how far the path goes")?
        .collect();
    let lift =
        |&place: &[f64; 2]| -> PointMm { [place[0], place[1], height_mm(&part.nominal, place)] };
    let points: Vec<PointMm> = places.iter().map(lift).collect();
    let pose = Pose::default();
    let mut remembered = Remembered::default();
    remembered.look_at_nominal(part, &points, &pose)?;
    let lfs_mm = remembered.lfs_mm(&pose);
    let limit_mm = part.gap_limit_mm.unwrap_or(f64::INFINITY);
    let mut found =
        DesignSpacing { spacing_mm: f64::INFINITY, lfs_min_mm: f64::INFINITY, slope_max: 0.0 };
    for [x, y] in places {
        let lfs_mm = lfs_mm(x, y).ok_or_else(|| {
            format!("the local feature size of the nominal is not known at x {x:.3}, y {y:.3} mm")
        })?;
        let [along_x, along_y] = part.nominal.gradient(x, y);
        let slope = along_x.hypot(along_y);
        let spacing_mm = 2.0 * limit_mm.min(epsilon * lfs_mm) / slope.hypot(SQRT_2);
        if slope.is_finite() {
            found.slope_max = found.slope_max.max(slope);
            found.spacing_mm = found.spacing_mm.min(spacing_mm);
        }
        found.lfs_min_mm = found.lfs_min_mm.min(lfs_mm);
    }
    Ok(found)
}

/// Places of a raster over an aperture, and of its border; `None` where every point counts.
fn places(aperture: &Aperture) -> Option<impl Iterator<Item = [f64; 2]> + '_> {
    let half = aperture.half_extents_mm()?;
    let radii: &[f64] = if aperture.is_round() { &[1.0] } else { &[] };
    let raster = (0..STEPS * STEPS).map(move |index| {
        let at = |step: u32, half: f64| (2.0 * f64::from(step) / f64::from(STEPS - 1) - 1.0) * half;
        [at(index % STEPS, half[0]), at(index / STEPS, half[1])]
    });
    let border = radii.iter().flat_map(move |share| {
        (0..RIM).map(move |step| {
            let (sin, cos) = (TAU * f64::from(step) / f64::from(RIM)).sin_cos();
            // The border itself may be beyond the domain by rounding.
            [half[0] * share * INSIDE * cos, half[1] * share * INSIDE * sin]
        })
    });
    Some(raster.filter(|&[x, y]| aperture.contains(x, y)).chain(border))
}

/// Steps of the raster along each axis.
const STEPS: u32 = 129;
/// Places of the border.
const RIM: u32 = 360;
const INSIDE: f64 = 1.0 - 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pipeline;
    use crate::nominal::parse;

    fn part(text: &str) -> Part {
        parse("part.toml", text).unwrap()
    }

    #[test]
    fn a_sphere_needs_less_where_it_is_steep() {
        let text = "[surface]\nkind = \"sphere\"\nradius_mm = 20\n[aperture]\nshape = \"circle\"\nradius_mm = 12\n";
        let found = design_spacing(&part(text), 0.05).unwrap();
        // Slope 12/16 at the rim.
        let diagonal = (2.0_f64 + 0.75 * 0.75).sqrt();
        assert!((found.lfs_min_mm / 20.0 - 1.0).abs() < 5e-3, "{found:?}");
        assert!((found.slope_max - 0.75).abs() < 1e-6, "{found:?}");
        assert!(
            (found.spacing_mm / (2.0 * 0.05 * 20.0 / diagonal) - 1.0).abs() < 6e-3,
            "{found:?}"
        );
        let limited = part(&format!("{text}[sampling]\ngap_limit_mm = 0.2\n"));
        let found = design_spacing(&limited, 0.05).unwrap();
        assert!((found.spacing_mm / (2.0 * 0.2 / diagonal) - 1.0).abs() < 1e-6, "{found:?}");
        let flat =
            part("[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 12\n");
        assert_eq!(design_spacing(&flat, 0.05).unwrap().spacing_mm, f64::INFINITY);
    }

    /// Measured with this spacing, the sampling report finds the condition met, and with 1.2 times it not.
    #[test]
    fn the_sampling_report_agrees() {
        for surface in [
            "kind = \"asphere\"\nradius_mm = 12\nconic = 0.8\n",
            "kind = \"biconic\"\nradius_x_mm = 20\nradius_y_mm = 9\n",
        ] {
            let text = format!(
                "[surface]\n{surface}[aperture]\nshape = \"rectangle\"\nwidth_mm = 8\nheight_mm = 6\n\
                 [sampling]\nepsilon_limit = 0.05\n"
            );
            let part = part(&text);
            let needed_mm = design_spacing(&part, 0.05).unwrap().spacing_mm;
            let epsilon = |spacing_mm: f64| {
                let mut pipeline = Pipeline::new(part.clone());
                let steps = [10.0, 8.0].map(|mm: f64| (mm / spacing_mm).ceil() as usize);
                let places = (0..=steps[0]).flat_map(|i| (0..=steps[1]).map(move |j| [i, j]));
                let places =
                    places.map(|[i, j]| [spacing_mm * i as f64 - 5.0, spacing_mm * j as f64 - 4.0]);
                pipeline
                    .take_positions(places.map(|[x, y]| [x, y, height_mm(&part.nominal, [x, y])]));
                pipeline.finish().report.sampling.epsilon_max.unwrap()
            };
            let [enough, wide] = [1.0, 1.45].map(|factor| epsilon(factor * needed_mm));
            assert!(enough <= 0.0505 && wide > 0.05, "{surface}: {enough} {wide}");
        }
    }

    #[test]
    fn what_has_no_spacing_says_why() {
        let open = part("[surface]\nkind = \"sphere\"\nradius_mm = 20\n");
        assert!(design_spacing(&open, 0.05).unwrap_err().contains("[aperture]"));
        let free =
            part("[surface]\nkind = \"unknown\"\n[aperture]\nshape = \"circle\"\nradius_mm = 2\n");
        assert!(design_spacing(&free, 0.05).unwrap_err().contains("unknown"));
    }
}
