//! `kind = "unknown"`: no design is known, and the points themselves make the reference.

use asphera_form::{Base, Knots, ReferenceSettings, Smoothing};
use asphera_settings::{OrAuto, Section};

use super::super::part::place_mm;

/// How the reference is made. The aperture is not known yet.
pub(super) fn unknown(surface: &Section<'_>) -> ReferenceSettings {
    let bases = [
        ("auto", None),
        ("plane", Some(Base::Plane)),
        ("sphere", Some(Base::Sphere)),
        ("quadric", Some(Base::Quadric)),
    ];
    ReferenceSettings {
        base: surface.word("base", None, &bases),
        knots: knots(surface),
        smoothing: smoothing(surface),
        centre_mm: place_mm(surface, "centre_mm"),
        ..ReferenceSettings::default()
    }
}

fn knots(surface: &Section<'_>) -> Knots {
    let spacing = surface.or("knots_mm", OrAuto::Auto);
    if surface.has("cells") {
        if surface.has("knots_mm") {
            surface.problem("cells", "either cells or knots_mm", "both");
        }
        return Knots::Across(surface.within("cells", 32, 1..=asphera_form::shape::LARGEST_SIDE));
    }
    match spacing {
        OrAuto::Auto => Knots::Auto,
        OrAuto::Number(spacing_mm) => {
            if spacing_mm <= 0.0 {
                surface.problem("knots_mm", "a length above 0 in mm, or \"auto\"", spacing_mm);
            }
            Knots::Spacing(spacing_mm)
        }
    }
}

fn smoothing(surface: &Section<'_>) -> Smoothing {
    let smoothing = surface.or("smoothing", OrAuto::Auto);
    if let Some(noise_nm) = surface.get::<f64>("noise_nm") {
        if surface.has("smoothing") {
            surface.problem("noise_nm", "either smoothing or noise_nm", "both");
        }
        if noise_nm <= 0.0 {
            surface.problem("noise_nm", "a length above 0 in nm", noise_nm);
        }
        return Smoothing::Noise { sigma_mm: noise_nm * 1e-6 };
    }
    match smoothing {
        OrAuto::Auto => Smoothing::CrossValidation,
        OrAuto::Number(lambda) => {
            if lambda <= 0.0 {
                surface.problem("smoothing", "a number above 0, or \"auto\"", lambda);
            }
            Smoothing::Relative { lambda }
        }
    }
}

#[cfg(test)]
mod tests {
    use asphera_form::Aperture;

    use asphera_measure::Part;

    use super::super::super::part;
    use super::*;

    fn parse(rest: &str) -> Result<Part, String> {
        part::parse("n.toml", &format!("[surface]\nkind = \"unknown\"\n{rest}"))
            .map_err(|problems| problems.to_string())
    }

    #[test]
    fn everything_is_found_by_itself_or_given() {
        assert_eq!(parse("").unwrap().reference, Some(ReferenceSettings::default()));
        let given = parse(
            "base = \"sphere\"\nknots_mm = 0.5\nnoise_nm = 20\ncentre_mm = [1, 2]\n[aperture]\nshape = \"circle\"\n\
             radius_mm = 4\n[tolerance]\npvr_nm = 9\n",
        );
        let expected = ReferenceSettings {
            base: Some(Base::Sphere),
            knots: Knots::Spacing(0.5),
            smoothing: Smoothing::Noise { sigma_mm: 20.0 * 1e-6 },
            aperture: Aperture::Circle { radius_mm: 4.0 },
            centre_mm: Some([1.0, 2.0]),
        };
        assert_eq!(given.unwrap().reference, Some(expected));
        let other = parse("cells = 12\nsmoothing = 0.5\n").unwrap().reference.unwrap();
        assert_eq!(other.knots, Knots::Across(12));
        assert_eq!(other.smoothing, Smoothing::Relative { lambda: 0.5 });
        assert_eq!(
            parse("knots_mm = \"auto\"\nsmoothing = \"auto\"\nbase = \"auto\"\n"),
            parse("")
        );
    }

    #[test]
    fn what_makes_no_sense_is_named() {
        for (rest, said) in [
            ("base = \"torus\"\n", "surface.base: expected \"auto\" or \"plane\""),
            ("knots_mm = 0\n", "surface.knots_mm: expected a length above 0"),
            ("knots_mm = \"fine\"\n", "surface.knots_mm: expected a finite number or \"auto\""),
            ("cells = 129\n", "surface.cells: expected 1 to 128"),
            ("cells = 8\nknots_mm = 1\n", "surface.cells: expected either cells or knots_mm"),
            ("smoothing = -1\n", "surface.smoothing: expected a number above 0"),
            ("smoothing = 1\nnoise_nm = 3\n", "surface.noise_nm: expected either"),
            ("noise_nm = 0\n", "surface.noise_nm: expected a length above 0"),
            ("centre_mm = [1]\n", "surface.centre_mm: expected x and y in mm"),
            ("radius_mm = 3\n", "surface.radius_mm"),
            ("[surface.off_axis]\ndx_mm = 1\n", "surface.off_axis: expected no such table"),
            ("[fit]\nfree = [\"tz\"]\n", "fit.free: expected no such key"),
            ("[fit]\nloss = \"huber\"\n", "fit.loss: expected \"squares\""),
            ("[fit]\nweights = \"uncertainty\"\n", "fit.weights: expected \"none\""),
            ("[uncertainty]\ncorrelation = \"deviations\"\n", "uncertainty.correlation: expected"),
            ("[uncertainty]\nscale_x_ppm = 1\n", "uncertainty: expected noise alone"),
        ] {
            let problems = parse(rest).unwrap_err();
            assert!(problems.contains(said), "{problems}");
        }
    }
}
