//! Lens files with known prescriptions become nominals with the heights they must have.

use asphera_form::Nominal;
use asphera_formats::zemax;

use super::*;
use asphera_measure::Part;

fn lens(unit: &str, surface: &str) -> Lens {
    let text = format!(
        "UNIT {unit} X W X CM MR CPMM\nSURF 0\n  TYPE STANDARD\n  CURV 0.0\nSURF 1\n{surface}\n"
    );
    zemax::read(text.as_bytes()).unwrap()
}

fn part(unit: &str, surface: &str) -> Part {
    let text = nominal(&lens(unit, surface), 1, "lens.zmx", None).unwrap();
    asphera_nominal::parse("lens.toml", &text)
        .unwrap_or_else(|problems| panic!("{problems}\n{text}"))
}

fn height_mm(unit: &str, surface: &str, x_mm: f64, y_mm: f64) -> f64 {
    part(unit, surface).nominal.height_mm(x_mm, y_mm).unwrap()
}

fn assert_near(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= 1e-12 * (1.0 + expected.abs()),
        "{found} is not {expected}"
    );
}

/// Thorlabs AL1815-C: its prescription, and heights worked out from it in double precision.
#[test]
fn a_thorlabs_asphere_has_the_heights_of_its_prescription() {
    const AL1815: &str = "  TYPE EVENASPH\n  CURV 8.583690987124463800E-002 0 0 0 0\n  CONI -1.1\n  DIAM 9 1 0 0 1\n  PARM 1 0\n\
        PARM 2 3.69067205091e-5\n  PARM 3 -1.285461192617e-8\n  PARM 4 -1.400167659754e-10\n  PARM 5 -2.51311664812e-13\n\
        PARM 6 5.01789877647e-16\n  PARM 7 5.855871513042e-18\n  PARM 8 -1.127794407419e-20";
    let part = part("MM", AL1815);
    for (r_mm, z_mm) in [(3.0, 0.38860699918513), (6.0, 1.58193496464626), (9.0, 3.65468364040223)]
    {
        assert!((part.nominal.sag_mm(r_mm) - z_mm).abs() < 1e-14 * 5.0 / 0.5, "{r_mm}");
    }
    // The radius of the catalogue, not its inverse with sixteen digits; and no A2.
    assert_eq!(part.nominal.radius_mm(), Some(11.65));
    assert_eq!(part.aperture, asphera_form::Aperture::Circle { radius_mm: 9.0 });
}

/// Thorlabs ASL5040-UV: heights of the conic under its Q-bfs terms, and the terms.
#[test]
fn a_thorlabs_q_asphere_stands_on_its_conic() {
    const CONIC: &str = "  CURV 5.756078762782423000E-002 0 0 0 0\n  CONI -6.7609120640407927E-001\n  DIAM 22.86 1 0 0 1\n";
    let conic = part("MM", &format!("  TYPE STANDARD\n{CONIC}")).nominal;
    for (r_mm, z_mm) in [
        (5.0, 0.72440175535287),
        (10.0, 2.95970043589438),
        (15.0, 6.92229205986660),
        (20.0, 13.11580728984559),
        (22.86, 18.09109600236299),
    ] {
        assert!(
            (conic.sag_mm(r_mm) - z_mm).abs() < 2e-14 * (1.0 + z_mm),
            "{r_mm}: {}",
            conic.sag_mm(r_mm)
        );
    }
    let terms = [-0.8148370167576, -0.32311, 0.10591, -0.05058, 0.00987, -0.0022];
    let extra: String = (4..)
        .zip(terms)
        .map(|(number, term)| format!("  XDAT {number} {term:e} 0 0 1.0 0.0 0\n"))
        .collect();
    let text =
        format!("  TYPE QED_TYPE\n{CONIC}  XDAT 1 0 0 0\n  XDAT 2 6 0 0\n  XDAT 3 27 0 0\n{extra}");
    let lens = part("MM", &text).nominal;
    let parameters: Vec<_> = lens.freeform().unwrap().parameters();
    let names: Vec<_> = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    assert_eq!(names, ["radius", "conic", "Q0", "Q1", "Q2", "Q3", "Q4", "Q5"]);
    assert_eq!(parameters[2..].iter().map(|parameter| parameter.value).collect::<Vec<_>>(), terms);
    assert_near(lens.height_mm(27.0, 0.0).unwrap(), conic.sag_mm(27.0));
    let con = part("MM", &text.replace("XDAT 1 0", "XDAT 1 1"));
    assert_eq!(con.nominal.kind(), "Q-con asphere");
}

#[test]
fn the_first_parameter_of_an_even_asphere_is_that_of_the_square() {
    let text = "  TYPE EVENASPH\n  CURV 0\n  PARM 1 1e-3\n  PARM 2 1e-5\n";
    assert_near(height_mm("MM", text, 3.0, 4.0), 0.025 + 625e-5);
    assert_near(
        height_mm("MM", "  TYPE ODDASPHE\n  CURV 0\n  PARM 1 1e-3\n  PARM 3 1e-4\n", 3.0, 4.0),
        5e-3 + 125e-4,
    );
}

#[test]
fn lengths_change_with_the_unit_and_heights_do_not() {
    let text =
        "  TYPE EVENASPH\n  CURV 0.5\n  CONI -0.3\n  DIAM 0.4\n  PARM 1 1e-2\n  PARM 3 -2e-3\n";
    let in_mm = part("MM", text).nominal;
    for (unit, unit_mm) in [("CM", 10.0), ("IN", 25.4), ("METER", 1000.0)] {
        let expected = in_mm.height_mm(0.2, 0.3).unwrap() * unit_mm;
        assert_near(height_mm(unit, text, 0.2 * unit_mm, 0.3 * unit_mm), expected);
    }
    let zernike =
        "  TYPE FZERNSAG\n  CURV 0.5\n  PARM 2 1e-2\n  XDAT 1 5\n  XDAT 2 0.5\n  XDAT 7 1e-2\n";
    let expected = height_mm("MM", zernike, 0.2, 0.3) * 25.4;
    assert_near(height_mm("IN", zernike, 5.08, 7.62), expected);
    assert_eq!(part("IN", text).aperture, asphera_form::Aperture::Circle { radius_mm: 0.4 * 25.4 });
}

#[test]
fn a_biconic_has_its_parameters_along_x() {
    let text = "  TYPE BICONICX\n  CURV 0.1\n  CONI -1\n  PARM 1 5.0\n  PARM 2 0\n";
    assert_near(height_mm("MM", text, 3.0, 0.0), 1.0);
    assert_near(height_mm("MM", text, 0.0, 2.0), 0.2);
    let flat = "  TYPE BICONICX\n  CURV 0.1\n  PARM 1 0\n  PARM 2 3\n";
    assert_near(height_mm("MM", flat, 7.0, 0.0), 0.0);
}

#[test]
fn a_toroid_turns_about_its_first_parameter_and_zero_is_infinite() {
    let text = "  TYPE TOROIDAL\n  CURV 0\n  PARM 1 5.0\n  PARM 2 1e-2\n";
    assert_near(height_mm("MM", text, 3.0, 0.0), 1.0);
    assert_near(height_mm("MM", text, 0.0, 2.0), 0.04);
    let cylinder = "  TYPE TOROIDAL\n  CURV 0.2\n  PARM 1 0\n  PARM 3 1e-2\n";
    assert_near(height_mm("MM", cylinder, 50.0, 3.0), 1.0 + 0.81);
    let with_zernike =
        lens("MM", "  TYPE TOROIDAL\n  CURV 0.2\n  XDAT 1 1\n  XDAT 2 1\n  XDAT 3 0.5\n");
    let refused = nominal(&with_zernike, 1, "lens.zmx", None).unwrap_err().to_string();
    assert_eq!(
        refused,
        "surface 1, line 5, TOROIDAL: XDAT 3, a Zernike term is 0.5, expected 0: a toroid here has none"
    );
}

/// The 12th term of the help's example is x²·y², extra datum 14.
#[test]
fn the_extended_polynomial_counts_by_degree() {
    let text = "  TYPE XPOLYNOM\n  CURV 0\n  XDAT 1 13\n  XDAT 2 2\n  XDAT 14 3.0\n";
    assert_near(height_mm("MM", text, 1.0, 4.0), 3.0 * 0.25 * 4.0);
    // Terms beyond the number of terms are ignored.
    assert_eq!(part("MM", &text.replace("XDAT 1 13", "XDAT 1 11")).nominal, Nominal::Plane);
}

#[test]
fn standard_zernike_terms_are_nolls_and_of_unit_rms() {
    // Z2 = 2ρ·cos φ, Z3 = 2ρ·sin φ, Z11 = √5·(6ρ⁴ − 6ρ² + 1).
    let text = |term: u32| {
        format!("  TYPE SZERNSAG\n  CURV 0\n  XDAT 1 11\n  XDAT 2 10\n  XDAT {} 1.0\n", term + 2)
    };
    assert_near(height_mm("MM", &text(2), 3.0, 4.0), 0.6);
    assert_near(height_mm("MM", &text(3), 3.0, 4.0), 0.8);
    assert_near(height_mm("MM", &text(11), 3.0, 4.0), -0.125 * 5.0_f64.sqrt());
    let decentred = lens("MM", &format!("{}  PARM 9 0.1\n", text(2)));
    assert!(
        nominal(&decentred, 1, "lens.zmx", None).unwrap_err().to_string().contains("PARM 9 is 0.1")
    );
}

/// OpticStudio's help, Extended Asphere: parameter 13 the number of terms, 14 the radius of ρ, from 15 on the coefficients of ρ², ρ⁴ …
/// in lens units. What stands beyond the number of terms does not count.
#[test]
fn an_extended_asphere_is_an_even_one_of_a_normalised_radius() {
    const TEXT: &str = "  TYPE XASPHERE\n  CURV 0.05\n  CONI -1\n  XDAT 1 3\n  XDAT 2 5\n  XDAT 3 0.01\n  XDAT 4 -0.02\n\
        XDAT 5 0.003\n  XDAT 6 99\n";
    // A paraboloid r²/40, and ρ = 1/2 and 1: 0.01/4 - 0.02/16 + 0.003/64 and 0.01 - 0.02 + 0.003.
    assert_near(height_mm("MM", TEXT, 1.5, 2.0), 0.15625 + 0.001296875);
    assert_near(height_mm("MM", TEXT, 3.0, 4.0), 0.625 - 0.007);
    assert_near(height_mm("CM", TEXT, 30.0, 40.0), 6.25 - 0.07);
    let plain = part("MM", "  TYPE XASPHERE\n  CURV 0.05\n  XDAT 1 2\n").nominal;
    assert_eq!(plain, Nominal::Sphere { radius_mm: 20.0 });
    let many = lens("MM", &TEXT.replace("XDAT 1 3", "XDAT 1 128"));
    let told = nominal(&many, 1, "lens.zmx", None).unwrap_err().to_string();
    assert!(
        told.contains("line 5") && told.contains("XDAT 1, the number of terms is 128"),
        "{told}"
    );
}

/// Surface 4 of US 8,427,765 example 1 as ray-optics' test file US08427765-1.ZMX has it; heights in 40 digits from the formula.
#[test]
fn a_lens_of_a_patent_has_the_heights_of_its_prescription() {
    const TEXT: &str = "  TYPE EVENASPH\n  CURV 1.117818019226470000E-001 0 0 0 0 \"\"\n  HIDE 0 0 0 0 0 0 0 0 0 0\n  MIRR 2 0\n\
        SLAB 1\n  PARM 1 0\n  PARM 2 1.10721E-5\n  PARM 3 1.837E-7\n  PARM 4 0\n  PARM 5 0\n  DISZ 4.25\n  CONI 2.0E-2\n\
        DIAM 5.58 1 0 0 1 \"\"\n  FLAP 0 5.58 0";
    let part = part("MM", TEXT);
    assert_eq!(part.nominal.radius_mm(), Some(8.946));
    for (r_mm, z_mm) in [
        (1.5, 0.126_727_382_480_701_66),
        (3.0, 0.519_365_447_067_027_6),
        (5.58, 1.975_308_554_533_854),
    ] {
        assert_near(part.nominal.sag_mm(r_mm), z_mm);
    }
}

/// Thorlabs LJ1598L1 from the vendor's file, as Optiland has it among its tests: a cylinder lens of 6 mm by 4 mm.
#[test]
fn a_cylinder_lens_of_thorlabs_is_straight_along_x_and_rectangular() {
    const TEXT: &str = "  COMM LJ1598L1\n  STOP\n  TYPE TOROIDAL\n  CURV 4.950495049504951000E-001 0 0 0 0 \"\"\n  PARM 0 0\n\
        PARM 1 0\n  PARM 2 0\n  PARM 8 0\n  XDAT 1 0.000000000000E+000 0 0 1.000000000000E+000 0.000000000000E+000 0 \"\"\n\
        XDAT 2 1.000000000000E+002 0 0 1.000000000000E+000 0.000000000000E+000 0 \"\"\n  DISZ 3.8\n  GLAS N-BK7 0 0\n\
        DIAM 2 1 0 0 1 \"\"\n  SQAP 3.0 2 0";
    let part = part("MM", TEXT);
    assert_near(part.nominal.height_mm(2.9, 1.2).unwrap(), 2.02 - (2.02_f64 * 2.02 - 1.44).sqrt());
    let expected = asphera_form::Aperture::Rectangle { width_mm: 6.0, height_mm: 4.0 };
    assert_eq!(part.aperture, expected);
}

/// OpticStudio's help: as the extended asphere, with powers of every order; ray-optics reads XOSPHERE as such.
#[test]
fn an_extended_odd_asphere_has_every_power_from_the_first_on() {
    const TEXT: &str = "  TYPE XOSPHERE\n  CURV 0.05\n  CONI -1\n  XDAT 1 4\n  XDAT 2 5\n  XDAT 3 0.02\n  XDAT 5 -0.01\n\
        XDAT 6 0.003\n  XDAT 7 99\n";
    assert_near(height_mm("MM", TEXT, 0.75, 1.0), 0.043_917_968_75);
    assert_near(height_mm("MM", TEXT, 3.0, 4.0), 0.638);
    assert_near(height_mm("IN", TEXT, 25.4 * 3.0, 25.4 * 4.0), 25.4 * 0.638);
    for kind in ["XOSPHERE", "XASPHERE"] {
        let text = format!("{}  PARM 2 1e-5\n", TEXT.replace("XOSPHERE", kind));
        let told = nominal(&lens("MM", &text), 1, "lens.zmx", None).unwrap_err().to_string();
        assert!(told.contains("PARM 2 is 0.00001, expected 0"), "{told}");
    }
}

#[test]
fn an_irregular_surface_is_its_design_where_it_does_not_deviate() {
    const TEXT: &str = "  TYPE IRREGULA\n  CURV 0.05\n  PARM 0 0\n  PARM 5 0\n  PARM 8 30\n";
    assert_eq!(part("MM", TEXT).nominal, Nominal::Sphere { radius_mm: 20.0 });
    let astigmatic = lens("MM", &format!("{TEXT}  PARM 6 1e-4\n"));
    let told = nominal(&astigmatic, 1, "lens.zmx", None).unwrap_err().to_string();
    assert!(told.contains("PARM 6 is 0.0001, expected 0: this kind models what"), "{told}");
}

/// The decentre is that of an off-axis parabola whose lines ray-optics quotes (zmxread.py).
#[test]
fn a_decentred_aperture_makes_the_piece_within_it() {
    const TEXT: &str = "  TYPE STANDARD\n  CURV -1.25E-3\n  CONI -1\n  DIAM 2.16E+02 1 0 0 1\n  CLAP 0 25.399999999999999 0\n\
        OBDC 0.000000000000E+00 1.906000000000E+02\n";
    let piece = part("MM", TEXT);
    let heights = [(0.0, 0.0), (10.0, -15.0)].map(|(x, y)| piece.nominal.height_mm(x, y).unwrap());
    assert_near(heights[1] - heights[0], 3.370_625);
    assert_eq!(piece.aperture, asphera_form::Aperture::Circle { radius_mm: 25.4 });
    // Without a form of the aperture its edge is not known: the semi-diameter is about the vertex.
    let bare = TEXT.replace("  CLAP 0 25.399999999999999 0\n", "");
    assert_ne!(bare, TEXT);
    assert_eq!(part("MM", &bare).aperture, asphera_form::Aperture::None);
}

/// Heights over a paraboloid: a tilt along x and one along y tell every corner.
#[test]
fn a_grid_sag_stands_on_its_base() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a \"b\".DAT");
    let mut heights = "! x from -3 to 3, y from 2 to -2\n7 5 1 1 0 0 0\n".to_owned();
    for row in 0..5 {
        for column in 0..7 {
            let (x, y) = (f64::from(column) - 3.0, 2.0 - f64::from(row));
            heights += &format!("{:?} 0 0 0 0\n", 1e-3 * x + 1e-4 * y + 1e-5 * x * x * y);
        }
    }
    std::fs::write(&path, heights).unwrap();
    let path = path.to_str().unwrap();
    // A lens in inches; the heights keep their own unit.
    const TEXT: &str = "  TYPE GRID_SAG\n  CURV 0.254\n  CONI -1\n  PARM 0 1\n  PARM 2 1e-3\n  PARM 9 0.5\n  XDAT 1 0\n  XDAT 2 1\n";
    let text = nominal(&lens("IN", TEXT), 1, "lens.zmx", Some(path)).unwrap();
    assert!(text.contains("\n# Between heights OpticStudio interpolates"), "{text}");
    let part =
        asphera_nominal::parse("lens.toml", &text).unwrap_or_else(|told| panic!("{told}\n{text}"));
    for [x, y] in [[-3.0, 2.0], [3.0, -2.0], [0.5, -1.25], [0.0, 0.0]] {
        let r2: f64 = x * x + y * y;
        let base = r2 / 200.0 + 1e-3 * r2 * r2 / 25.4_f64.powi(3);
        let departure = 1e-3 * x + 1e-4 * y + 1e-5 * x * x * y;
        assert_near(part.nominal.height_mm(x, y).unwrap(), base + departure);
    }
    assert_eq!(part.nominal.height_mm(3.1, 0.0), None);
    let flat = nominal(&lens("MM", "  TYPE GRID_SAG\n"), 1, "lens.zmx", Some(path)).unwrap();
    let flat = asphera_nominal::parse("lens.toml", &flat).unwrap().nominal;
    assert_near(flat.height_mm(-3.0, 2.0).unwrap(), -3e-3 + 2e-4 + 18e-5);

    for (surface, heights, said) in [
        (TEXT, None, "is of the kind GRID_SAG, and its heights are in another file: add --grid"),
        (
            "  TYPE EVENASPH\n",
            Some(path),
            "is of the kind EVENASPH, expected GRID_SAG for a file of heights",
        ),
        (
            "  TYPE GRID_SAG\n  XDAT 1 1\n  XDAT 2 1\n  XDAT 3 0.1\n",
            Some(path),
            "the number of Zernike terms is 1, expected 0",
        ),
    ] {
        let told = nominal(&lens("MM", surface), 1, "lens.zmx", heights).unwrap_err().to_string();
        assert!(told.contains(said), "{told}");
    }
}

#[test]
fn what_has_no_kind_names_the_cure() {
    for (kind, cure) in [
        ("CHEBYSHV", "Write kind = \"chebyshev\" by hand"),
        ("COORDBRK", "choose the one after it"),
        ("BINARY_2", "change its TYPE to STANDARD or EVENASPH in a copy of the file"),
        ("PARAXIAL", "an ideal lens has no shape"),
        ("PERIODIC", "use kind = \"grid\""),
    ] {
        let lens = lens("MM", &format!("  TYPE {kind}\n"));
        let told = nominal(&lens, 1, "lens.zmx", None).unwrap_err().to_string();
        assert!(
            told.contains(cure) && told.contains("expected one of STANDARD, EVENASPH"),
            "{told}"
        );
    }
    let file = "UNIT MM\nSURF 0\nSURF 1\n  TYPE COORDBRK\n  PARM 2 5\nSURF 2\n  CURV 0.1\n";
    let text = nominal(&zemax::read(file.as_bytes()).unwrap(), 2, "a.zmx", None).unwrap();
    assert!(text.contains("# The coordinate breaks of the file were left out"), "{text}");
}

#[test]
fn unknown_kinds_and_numbers_list_the_surfaces() {
    let lens = lens("MM", "  TYPE CHEBYSHV\n  COMM front\n  CURV -0.04\n  DIAM 12.5\n");
    let listed = "  no  type                   R mm    semi-dia mm  comment\n   \
                    0  STANDARD           infinite       0.000000  \n   \
                    1  CHEBYSHV         -25.000000      12.500000  front\n";
    assert_eq!(list(&lens), listed);
    for (number, begins) in [
        (
            1,
            "surface 1, line 5, is of the kind CHEBYSHV (the order of its coefficients is not documented",
        ),
        (7, "there is no surface 7; "),
    ] {
        let told = nominal(&lens, number, "lens.zmx", None).unwrap_err().to_string();
        assert!(told.starts_with(begins) && told.ends_with(listed), "{told}");
    }
}

#[test]
fn the_file_says_where_it_comes_from_and_what_may_differ() {
    let text = "UNIT CM\nNAME Doublet\nSURF 0\nSURF 3\n  COMM back\n  CURV 0.1\nMNUM 2 1\n";
    let text = nominal(&zemax::read(text.as_bytes()).unwrap(), 3, "a\nb.zmx", None).unwrap();
    for said in [
        "# Surface 3 of a b.zmx (Doublet), Zemax type STANDARD.",
        "# Comment there: back",
        "unit of 10 mm",
        "2 configurations",
        "radius_mm = 100.0",
    ] {
        assert!(text.contains(said), "{text}");
    }
    assert!(text.lines().take_while(|line| !line.is_empty()).all(|line| line.starts_with('#')));
}
