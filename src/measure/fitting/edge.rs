//! Points on the edge of the aperture, which a fit takes in and leaves out by turns.
//!
//! A raster often has points exactly there. With them the part comes to lie so that they are outside, without them so that they
//! are inside: no choice of points agrees with the place that it gives the part. A slightly narrower aperture has none on its
//! edge.

use asphera_form::Termination;

use super::{Fitted, NoFit};
use crate::Part;

/// How far the edge is moved inwards at most, one after the other, in shares of half the width of the aperture.
const NARROWED_BY: [f64; 4] = [1e-7, 1e-6, 1e-5, 1e-4];

/// The fit that `fit` makes of a part; where its points do not settle, that in the least narrowed aperture in which they do.
pub(super) fn settled(
    part: &Part,
    fit: impl Fn(&Part) -> Result<Fitted, NoFit>,
) -> Result<Fitted, NoFit> {
    let is_settled =
        |fitted: &Fitted| !matches!(fitted.fit.termination, Termination::UnstableAperture { .. });
    let found = fit(part)?;
    if is_settled(&found) {
        return Ok(found);
    }
    let narrower = NARROWED_BY.into_iter().find_map(|share| {
        let narrowed_mm = share * part.aperture.half_width_mm();
        let aperture = part.aperture.narrowed(narrowed_mm)?;
        let again = fit(&Part { aperture, ..part.clone() }).ok().filter(is_settled)?;
        Some(Fitted { narrowed_mm: Some(narrowed_mm), ..again })
    });
    Ok(narrower.unwrap_or(found))
}

#[cfg(test)]
mod tests {
    use asphera_geometry::PointMm;
    use asphera_report::{Report, Status};

    use crate::Pipeline;
    use crate::nominal::parse;
    use crate::random::Random;

    const PART: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 50.0\n\
        [aperture]\nshape = \"circle\"\nradius_mm = 9.0\n[fit]\nfree = [\"tx\", \"ty\", \"tz\"]\n\
        [sampling]\ngap_limit_mm = 3.0\n[tolerance]\nrms_nm = 20\nguard_probability = 0.95\n";

    /// A raster of 0.9 mm over a sphere, 5 nm of noise; (±5.4, ±7.2) and (9, 0) lie on the edge.
    fn raster(seed: u64) -> Vec<PointMm> {
        let mut random = Random(seed);
        let places = (-10..=10)
            .flat_map(|j| (-10..=10).map(move |i| [0.9 * f64::from(i), 0.9 * f64::from(j)]));
        let inside = places.filter(|[x, y]| x.hypot(*y) < 9.000_001);
        inside
            .map(|[x, y]| {
                let square = x * x + y * y;
                [x, y, square / (50.0 + (2500.0 - square).sqrt()) + 5e-6 * random.normal()]
            })
            .collect()
    }

    fn measured(points: &[PointMm]) -> Report {
        let mut pipeline = Pipeline::new(parse("part.toml", PART).unwrap());
        points.iter().for_each(|&point| pipeline.take_position(point));
        pipeline.finish().report
    }

    /// Such parts were UNDECIDED: "1 points kept crossing the edge of the aperture".
    #[test]
    fn points_on_the_edge_of_the_aperture_do_not_keep_a_part_undecided() {
        let mut narrowed = 0;
        for seed in 1..=60 {
            let points = raster(seed);
            let report = measured(&points);
            let form = report.form.unwrap();
            assert_eq!(report.verdict.status, Status::Pass, "{:?}", report.verdict.reasons);
            assert_eq!(form.fit.details.converged, Some(true));
            let Some(nm) = form.fit.details.aperture_narrowed_nm else { continue };
            narrowed += 1;
            assert!(nm > 0.0 && nm <= 900.0, "{nm}");
            // The points that count are those of the figures: all on the edge are out.
            let reversed: Vec<PointMm> = points.iter().rev().copied().collect();
            let again = measured(&reversed).form.unwrap();
            assert_eq!(again.fit.details.aperture_narrowed_nm, Some(nm));
            assert!((again.deviation.rms_nm - form.deviation.rms_nm).abs() < 1e-6);
        }
        assert!(narrowed > 0, "no raster had a point that came in and went out");
    }
}
