//! Every kind of surface from its text: the height it must have, and what a mistake is called.

use std::fs;
use std::path::{Path, PathBuf};

use asphera_form::Parameter;

use asphera_measure::Part;
use asphera_settings::Problem;

use super::super::part::parse;

fn nominals() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../config/nominals")
}

fn part(surface: &str) -> Part {
    match parse("part.toml", surface) {
        Ok(part) => part,
        Err(problems) => panic!("{problems}"),
    }
}

fn height_mm(surface: &str, x_mm: f64, y_mm: f64) -> f64 {
    part(surface).nominal.height_mm(x_mm, y_mm).unwrap()
}

fn assert_near(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= 1e-12 * (1.0 + expected.abs()),
        "{found} is not {expected}"
    );
}

/// What is wrong with a file, as line, key and text.
fn problems(text: &str) -> Vec<(usize, String, String)> {
    let problems = parse("part.toml", text).unwrap_err();
    let tell = |problem: &Problem| {
        (
            problem.line,
            problem.key.clone(),
            format!("{}, found {}", problem.expected, problem.found),
        )
    };
    problems.0.iter().map(tell).collect()
}

#[test]
fn every_family_has_an_example_that_parses_and_has_a_surface_within_its_aperture() {
    let mut kinds = Vec::new();
    for entry in fs::read_dir(nominals()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let part = parse(&path.display().to_string(), &text)
            .unwrap_or_else(|problems| panic!("{problems}"));
        for [x, y] in [[0.0, 0.0], [7.0, 0.0], [0.0, -4.0], [-4.0, 4.0]] {
            assert!(part.nominal.jet(x, y).is_some(), "{} at {x}, {y}", path.display());
        }
        kinds.push(part.nominal.kind());
    }
    assert_eq!(kinds.len(), 16, "{kinds:?}");
}

#[test]
fn an_even_asphere_with_a_square_term_is_a_freeform_and_without_it_followed_in_its_meridian() {
    const TEXT: &str = "[surface]\nkind = \"asphere\"\nradius_mm = 27.0\n";
    // Optiland 0.5, tests/test_geometries.py: R 27, k 0, coefficients of r² and r⁴.
    let with = format!("{TEXT}A2 = 1e-3\nA4 = -1e-5\n");
    assert_near(height_mm(&with, 1.0, 1.0), 0.039022474574473776);
    assert_near(height_mm(&with, -2.0, 3.0), 0.25313367948069593);
    assert!(!part(&with).nominal.is_rotational());
    assert_eq!(part(&with).free, Parameter::RIGID);
    assert!(part(&format!("{TEXT}A4 = -1e-5\n")).nominal.is_rotational());

    let corrector = "[surface]\nkind = \"asphere\"\nbase = \"flat\"\nA4 = 1e-5\n";
    assert_near(height_mm(corrector, 3.0, 4.0), 625e-5);
}

#[test]
fn odd_powers_count_by_their_order() {
    let text = "[surface]\nkind = \"odd-asphere\"\nbase = \"flat\"\nA1 = 0.5\nA3 = 1e-3\n";
    assert_near(height_mm(text, 3.0, 4.0), 2.5 + 0.125);
}

#[test]
fn a_thorlabs_q_asphere_ends_at_its_normalisation_radius() {
    let text = fs::read_to_string(nominals().join("q-bfs.toml")).unwrap();
    let nominal = part(&text).nominal;
    // The departure is 0 at the vertex and at the normalisation radius.
    let conic = "[surface]\nkind = \"conic\"\nradius_mm = 17.3729\nconic = -0.67609120640407927\n";
    assert_eq!(nominal.height_mm(0.0, 0.0), Some(0.0));
    assert_near(nominal.height_mm(27.0, 0.0).unwrap(), height_mm(conic, 27.0, 0.0));
    assert_eq!(nominal.height_mm(27.01, 0.0), None);
    assert_eq!(nominal.parameter("Q5").ok(), Some(Parameter::Shape(7)));
}

#[test]
fn a_cylinder_is_straight_along_the_axis_it_names() {
    for (axis, [x, y]) in [("y", [3.0, 100.0]), ("x", [100.0, 3.0])] {
        let text = format!(
            "[surface]\nkind = \"cylinder\"\nstraight_along = \"{axis}\"\nradius_mm = 5.0\n"
        );
        assert_near(height_mm(&text, x, y), 1.0);
        assert_eq!(part(&text).free, Parameter::POSE);
    }
    let acylinder = "[surface]\nkind = \"cylinder\"\nstraight_along = \"y\"\nradius_mm = 2.0\nconic = -1.0\nA4 = 0.5\n";
    assert_near(height_mm(acylinder, 2.0, 7.0), 1.0 + 8.0);
}

#[test]
fn a_biconic_takes_its_radii_by_direction() {
    let text = "[surface]\nkind = \"biconic\"\nradius_x_mm = 5.0\n";
    assert_near(height_mm(text, 3.0, 4.0), 1.0);
    let text =
        "[surface]\nkind = \"biconic\"\nradius_x_mm = 5.0\nradius_y_mm = 10.0\nconic_y = -1.0\n";
    assert_near(height_mm(text, 0.0, 2.0), 0.2);
}

#[test]
fn a_toroid_has_the_circle_of_its_rotation_along_x() {
    let text = "[surface]\nkind = \"toroid\"\nrotation_radius_mm = 5.0\nradius_mm = 13.0\n";
    assert_near(height_mm(text, 3.0, 0.0), 1.0);
    assert_near(height_mm(text, 0.0, 5.0), 1.0);
}

#[test]
fn a_mirror_takes_finite_virtual_and_infinite_distances() {
    let text = |source: &str, image: &str| {
        format!(
            "[surface]\nkind = \"mirror\"\nfigure = \"cylindrical\"\nsource_mm = {source}\n\
             image_mm = {image}\ngrazing_rad = 0.003\n"
        )
    };
    let nominal = part(&text("30000.0", "500.0")).nominal;
    let bend_per_mm = nominal.jet(0.0, 0.0).unwrap().hessian_per_mm[0];
    // R = 2·p·q/((p + q)·sin θ).
    let radius_mm = 2.0 * 30000.0 * 500.0 / (30500.0 * 0.003_f64.sin());
    assert!((bend_per_mm * radius_mm - 1.0).abs() < 1e-12);
    for (source, image, kind) in
        [("\"infinite\"", "500.0", 2), ("306.0", "-115.0", 3), ("306.0", "115.0", 3)]
    {
        let parameters = part(&text(source, image)).nominal.parameters();
        assert_eq!(parameters.len(), 6 + kind);
    }
}

#[test]
fn zernike_terms_mean_what_their_counting_says() {
    let text = |indices: &str, normalisation: &str, term: &str| {
        format!(
            "[surface]\nkind = \"zernike\"\nindices = \"{indices}\"\nnormalisation = \"{normalisation}\"\n\
             normalisation_radius_mm = 10.0\nbase = \"flat\"\n[[surface.terms]]\n{term}\nmm = 2.0\n"
        )
    };
    // Primary spherical aberration, 6ρ⁴ − 6ρ² + 1, is 1 − 1.5 + 0.375 = −0.125 at ρ = 1/2, and √5 in RMS.
    for (indices, term) in [
        ("fringe", "index = 9"),
        ("noll", "index = 11"),
        ("ansi", "index = 12"),
        ("orders", "n = 4\nm = 0"),
    ] {
        assert_near(height_mm(&text(indices, "unit-height", term), 3.0, 4.0), -0.25);
        assert_near(height_mm(&text(indices, "unit-rms", term), 3.0, 4.0), -0.25 * 5.0_f64.sqrt());
    }
    // The last of the fringe set is (12, 0), which is 1 at the rim whatever the azimuth.
    for [x, y] in [[10.0, 0.0], [6.0, 8.0]] {
        assert_near(height_mm(&text("fringe", "unit-height", "index = 37"), x, y), 2.0);
    }
    assert_eq!(
        problems(&text("fringe", "unit-height", "index = 38")),
        [(8, "surface.terms[0].index".to_owned(), "1 to 37, found 38".to_owned())]
    );
}

#[test]
fn a_series_stands_on_its_base_and_its_powers() {
    let text = "[surface]\nkind = \"zernike\"\nindices = \"noll\"\nnormalisation = \"unit-rms\"\n\
                normalisation_radius_mm = 10.0\nradius_mm = 50.0\nconic = -1.0\nA4 = 1e-4\n\
                terms = [{ index = 2, mm = 0.5 }]\n";
    assert_near(height_mm(text, 3.0, 4.0), 25.0 / 100.0 + 625e-4 + 0.5 * 2.0 * 0.3);
    let names: Vec<_> = part(text).nominal.parameters().into_iter().map(|(_, name)| name).collect();
    assert_eq!(names[6..], ["radius", "conic", "A4", "Z1", "Z2"]);
    assert_eq!(
        part(text).nominal.to_string(),
        "Noll Zernike series, radius 50 mm, conic -1, A4 0.0001 mm^-3, Z2 0.5 mm"
    );
}

#[test]
fn products_take_their_orders_along_x_and_y() {
    let text = |kind: &str, scale: &str| {
        format!(
            "[surface]\nkind = \"{kind}\"\nbase = \"flat\"\n{scale}\nterms = [{{ x = 2, y = 1, mm = 3.0 }}]\n"
        )
    };
    let rectangle = "half_x_mm = 10.0\nhalf_y_mm = 5.0";
    assert_near(height_mm(&text("chebyshev", rectangle), 5.0, 1.0), 3.0 * -0.5 * 0.2);
    assert_near(height_mm(&text("legendre", rectangle), 5.0, 1.0), 3.0 * -0.125 * 0.2);
    assert_near(
        height_mm(&text("xy", "normalisation_radius_mm = 2.0"), 1.0, 4.0),
        3.0 * 0.25 * 2.0,
    );
}

#[test]
fn a_q_2d_term_is_measured_along_the_normal_of_its_sphere() {
    let text = |base: &str| {
        format!(
            "[surface]\nkind = \"q-2d\"\n{base}\nnormalisation_radius_mm = 3.0\n\
             terms = [{{ n = 0, m = 2, mm = 0.01 }}]\n"
        )
    };
    let (flat, curved) = (text("base = \"flat\""), text("radius_mm = 5.0"));
    // At the rim the sphere is 1 mm high and its normal has the cosine 0.8.
    assert_near(height_mm(&curved, 3.0, 0.0), 1.0 + height_mm(&flat, 3.0, 0.0) / 0.8);
}

#[test]
fn a_piece_off_the_axis_lies_in_its_own_frame() {
    let text = |axes: &str| {
        format!(
            "[surface]\nkind = \"conic\"\nradius_mm = 50.0\nconic = -1.0\n\
             [surface.off_axis]\ndx_mm = 10.0\ndy_mm = 0.0\naxes = \"{axes}\"\n"
        )
    };
    assert_near(height_mm(&text("parallel"), 5.0, 0.0), 2.25 - 1.0);
    let tilted = part(&text("normal"));
    assert_eq!(
        tilted.nominal.jet(0.0, 0.0).unwrap().gradient.map(f64::abs).map(|slope| slope < 1e-15),
        [true; 2]
    );
    assert_eq!(tilted.free, Parameter::POSE);
}

/// 0.01·(x + 4)² over 8 × 8 mm about the origin, as `sags.x3p`.
fn write_sags(folder: &Path) {
    let map = asphera_formats::HeightMap {
        nx: 9,
        ny: 9,
        dx_mm: 1.0,
        dy_mm: 1.0,
        x0_mm: -4.0,
        y0_mm: -4.0,
        z_mm: (0..81).map(|node| 0.01 * f64::from((node % 9) * (node % 9))).collect(),
    };
    let metadata = asphera_formats::x3p::Metadata {
        date: "2026-01-31T12:00:00.0Z",
        calibration_date: "2026-01-01T00:00:00.0Z",
        creator: None,
        manufacturer: "asphera",
        model: "station",
        serial: "1",
        version: "0.1.0",
        probing: asphera_formats::x3p::Probing::NonContacting,
        probe: "chromatic sensor",
        comment: None,
    };
    let mut bytes = Vec::new();
    asphera_formats::x3p::write_map(&mut bytes, &map, &metadata).unwrap();
    fs::write(folder.join("sags.x3p"), bytes).unwrap();
}

#[test]
fn heights_of_a_file_are_found_beside_the_nominal() {
    let folder = tempfile::tempdir().unwrap();
    write_sags(folder.path());
    let name = folder.path().join("nominal.toml").display().to_string();
    let text = "[surface]\nkind = \"grid\"\nfile = \"sags.x3p\"\n";
    let part = parse(&name, text).unwrap();
    assert_near(part.nominal.height_mm(0.5, 0.0).unwrap(), 0.01 * 4.5 * 4.5);
    assert_eq!(part.nominal.freeform().unwrap().parameters(), []);

    // Over a paraboloid and r⁴, which may be fitted.
    let based = format!(
        "{text}radius_mm = 20\nconic = -1\nA4 = 1e-3\n[fit]\nfree = [\"tz\", \"radius\"]\n"
    );
    let based = parse(&name, &based).unwrap();
    assert_near(
        based.nominal.height_mm(0.5, 0.0).unwrap(),
        0.01 * 4.5 * 4.5 + 0.25 / 40.0 + 1e-3 * 0.0625,
    );
    assert_eq!(based.free, [Parameter::Tz, Parameter::Shape(0)]);
    let unbased = parse(&name, &format!("{text}conic = -1\n")).unwrap_err().to_string();
    assert!(unbased.contains("surface.radius_mm"), "{unbased}");

    let missing = parse("elsewhere/nominal.toml", text).unwrap_err().to_string();
    assert!(missing.starts_with("elsewhere/nominal.toml:3: surface.file: "), "{missing}");
    assert!(missing.contains("elsewhere/sags.x3p"), "{missing}");
}

#[test]
fn mistakes_are_named_with_line_key_and_cure() {
    let cases = [
        (
            "[surface]\nkind = \"asphere\"\nradius_mm = 9.0\nA3 = 1.0\n",
            4,
            "surface.A3",
            "an even order, as A4 (odd-asphere takes odd ones), found `A3`",
        ),
        (
            "[surface]\nkind = \"asphere\"\nbase = \"flat\"\nradius_mm = 9.0\n",
            4,
            "surface.radius_mm",
            "no such key where base is \"flat\", found one",
        ),
        (
            "[surface]\nkind = \"biconic\"\nconic_x = 9.0\n",
            1,
            "surface.radius_x_mm",
            "radius_x_mm, radius_y_mm, or both, found neither",
        ),
        (
            "[surface]\nkind = \"toroid\"\nrotation_radius_mm = 0.0\nradius_mm = 3\n",
            2,
            "surface.kind",
            "values that make a surface, found rotation_radius of the toroid is 0, expected a number other than 0, at most 1e307 in size",
        ),
        ("[surface]\nkind = \"plane\"\n[fit]\nfree = [\"Z5\"]\n", 4, "fit.free", ""),
    ];
    for (text, line, key, said) in cases {
        let found = problems(text);
        assert!(
            found
                .iter()
                .any(|(at, of, told)| (*at, of.as_str()) == (line, key) && told.contains(said)),
            "{found:?}"
        );
    }
    let twice = "[surface]\nkind = \"xy\"\nbase = \"flat\"\nnormalisation_radius_mm = 1\n\
                 terms = [{ x = 1, y = 1, mm = 1.0 }, { x = 1, y = 1, mm = 2.0 }, { x = 1, z = 1, mm = 2.0 }]\n";
    let keys: Vec<_> = problems(twice).into_iter().map(|(_, key, _)| key).collect();
    assert_eq!(keys, ["surface.terms[1].mm", "surface.terms[2].y", "surface.terms[2].z"]);
    let unnamed = "[surface]\nkind = \"zernike\"\nbase = \"flat\"\nnormalisation_radius_mm = 1\nterms = [{ index = 1, mm = 1.0 }]\n";
    let keys: Vec<_> = problems(unnamed).into_iter().map(|(_, key, _)| key).collect();
    assert_eq!(keys, ["surface.indices", "surface.normalisation"]);
}

#[test]
fn a_fit_may_free_what_the_surface_has() {
    let text =
        "[surface]\nkind = \"biconic\"\nradius_x_mm = 5.0\n[fit]\nfree = [\"tz\", \"radius_x\"]\n";
    let part = part(text);
    assert_eq!(part.free, [Parameter::Tz, Parameter::Shape(0)]);
    let wrong = problems(&text.replace("\"radius_x\"", "\"radius_y\""));
    assert_eq!(wrong[0].1, "fit.free");
    assert!(wrong[0].2.contains("radius_x, conic_x"), "{wrong:?}");
}
