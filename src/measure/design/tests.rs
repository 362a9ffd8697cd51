//! Figures of ISO 10110-5 with parameters of the shape free, against the same with the shape held.

use asphera_figures::Definition;
use asphera_report::{FormFigures, Status};

use crate::nominal::parse;
use crate::{Along, Measurement, Pipeline};

/// A raster over a disc, on a surface with 20 nm of astigmatism at the rim.
fn measured(part: &str, reach_mm: f64, sag_mm: impl Fn(f64, f64) -> f64) -> Measurement {
    let part = parse("part.toml", part).unwrap();
    let mut pipeline = Pipeline::along(part, Along::Z);
    for i in -40..=40 {
        for j in -40..=40 {
            let (x, y) = (f64::from(i) * reach_mm / 40.0, f64::from(j) * reach_mm / 40.0);
            if x.hypot(y) <= 0.999 * reach_mm {
                let astigmatism_mm = 2e-5 * (x * x - y * y) / (reach_mm * reach_mm);
                pipeline.take_position([x, y, sag_mm(x, y) + astigmatism_mm]);
            }
        }
    }
    pipeline.finish()
}

fn form(measurement: &Measurement) -> &FormFigures {
    measurement.report.form.as_ref().unwrap()
}

fn value(form: &FormFigures, name: &str) -> f64 {
    form.figures.iter().find(|figure| figure.name == name).unwrap().value
}

fn cautions(form: &FormFigures) -> Vec<&str> {
    let cautions = form.fit.details.cautions.iter();
    cautions.filter(|caution| caution.kind == "free_shape").map(|one| &one.text[..]).collect()
}

fn sphere(radius_mm: f64) -> impl Fn(f64, f64) -> f64 {
    move |x, y| {
        let rr = x * x + y * y;
        rr / (radius_mm + radius_mm.signum() * (radius_mm * radius_mm - rr).sqrt())
    }
}

const FIGURES: [&str; 6] = ["A", "B", "C", "RMSt", "RMSi", "RMSa"];

/// R 50.1 for 50 over Ø20: the sagittas differ by 2,057.7 nm along the axis, the spheres by 2,016.2 nm along the normal
/// where they touch at the vertex. Held at 50, A lies between. Before, with the radius free, A was 0.00 and passed.
#[test]
fn a_of_a_free_radius_is_that_of_the_design() {
    let sagitta_nm = 1e6 * (sphere(50.0)(9.99, 0.0) - sphere(50.1)(9.99, 0.0));
    let nominal = |free: &str| {
        format!(
            "[surface]\nkind = \"sphere\"\nradius_mm = 50.0\n[aperture]\nshape = \"circle\"\nradius_mm = 10.0\n\
             [fit]\nfree = [\"tx\", \"ty\", \"tz\"{free}]\n[tolerance]\na_nm = 500.0\npv_nm = 500.0\n\
             [uncertainty]\nnoise_nm = 1.0\n"
        )
    };
    let free = measured(&nominal(", \"radius\""), 10.0, sphere(50.1));
    let held = measured(&nominal(""), 10.0, sphere(50.1));
    let a_nm = value(form(&free), "A");
    assert!((a_nm / sagitta_nm - 0.99).abs() < 0.011, "{a_nm} of {sagitta_nm} nm");
    for name in FIGURES {
        let [free, held] = [&free, &held].map(|of| value(form(of), name));
        assert!((free - held).abs() < 0.02, "{name}: {free}, held {held}");
    }
    let verdict = &free.report.verdict;
    assert_eq!(verdict.status, Status::Fail, "{verdict:?}");
    let check = |name: &str| verdict.checks.iter().find(|check| check.figure.name == name).unwrap();
    assert!((check("a_nm").value - a_nm).abs() < 0.01 * a_nm && !check("a_nm").ok);
    assert!(check("a_nm").u.is_some_and(|u| u > 0.0 && u < 1.0), "{:?}", check("a_nm"));
    // What the fit leaves is what is asked for of the PV, and it is said.
    assert!(check("pv_nm").ok && check("pv_nm").value < 50.0);
    let said = cautions(form(&free));
    assert!(
        said.len() == 1 && said[0].starts_with("the fit changes the shape (free: radius). PV, RMS"),
        "{said:?}"
    );
    assert_eq!(cautions(form(&held)), Vec::<&str>::new());
    let indication = form(&free).standards.indication.as_ref().unwrap();
    assert!(indication.found.starts_with("3/20"), "{}", indication.found);
}

/// A surface, a parameter of it that is off on the part, and the part.
type Case = (&'static str, &'static str, Box<dyn Fn(f64, f64) -> f64>);

fn cases() -> [Case; 4] {
    let paraboloid = |x: f64, y: f64| (x * x + y * y) / 100.0;
    let off = move |x: f64, y: f64| {
        let rr = x * x + y * y;
        paraboloid(x, y) + 2e-7 * rr * rr
    };
    let toroid = |x: f64, y: f64| {
        let f = sphere(80.0)(0.0, y);
        60.02 - ((60.02 - f) * (60.02 - f) - x * x).sqrt()
    };
    let conic = "kind = \"conic\"\nradius_mm = 50.0\nconic = -1.0\n";
    let asphere = "kind = \"asphere\"\nradius_mm = 50.0\nconic = -1.0\nA4 = 0.0\n";
    let of_toroid = "kind = \"toroid\"\nrotation_radius_mm = 60.0\nradius_mm = 80.0\n";
    [
        (conic, "conic", Box::new(off)),
        (asphere, "A4", Box::new(off)),
        (asphere, "radius", Box::new(off)),
        (of_toroid, "rotation_radius", Box::new(toroid)),
    ]
}

/// Measurements with the parameter free and held.
fn free_and_held((surface, name, sag_mm): &Case, rest: &str) -> [Measurement; 2] {
    [format!(", \"{name}\""), String::new()].map(|free| {
        let nominal = format!(
            "[surface]\n{surface}[aperture]\nshape = \"circle\"\nradius_mm = 5.0\n\
             [fit]\nfree = [\"tz\", \"rx\", \"ry\"{free}]\n{rest}"
        );
        measured(&nominal, 5.0, sag_mm)
    })
}

/// Of each shape a parameter that is off: with it free the figures are those with it held.
#[test]
fn whatever_is_free_of_the_shape_the_indication_is_of_the_design() {
    for case in cases() {
        let name = case.1;
        let [free, held] = free_and_held(&case, "");
        let [of_free, of_held] = [&free, &held].map(form);
        for figure in FIGURES {
            let [free, held] = [of_free, of_held].map(|of| value(of, figure));
            assert!(
                (free - held).abs() < 1e-3 + 1e-6 * held,
                "{name}: {figure} {free}, held {held}"
            );
        }
        assert!(of_free.deviation.rms_nm < 0.9 * of_held.deviation.rms_nm, "{name} takes nothing");
        let figure = of_free.figures.iter().find(|figure| figure.name == "A").unwrap();
        assert!(figure.variant.starts_with("against the design, shape held"), "{}", figure.variant);
        let said = cautions(of_free);
        assert!(said.len() == 1 && said[0].contains(&format!("(free: {name}). ")), "{said:?}");
    }
}

/// Every figure that has a limit, with each kind of parameter free that is off: those of the indication are judged against the
/// design, and no other passes without saying what it is about. Before, PV or a slope passed by its bare name.
#[test]
fn no_limit_passes_without_a_word_where_the_shape_is_free() {
    let all = Definition::LIMITED.into_iter().chain(Definition::OF_POINTS);
    let limit = |of: Definition| if of == Definition::RmsTotal { 10 } else { 90 };
    let limits: Vec<String> = all.map(|of| format!("{} = {}\n", of.key(), limit(of))).collect();
    let rest = format!(
        "[tolerance]\n{}sq_nm = 60\nslope_over_mm = 1\nslope_step_mm = 1\n[figures.texture]\n",
        limits.concat()
    );
    for case in cases() {
        let name = case.1;
        let [free, held] = free_and_held(&case, &rest);
        let (checks, of_held) = (&free.report.verdict.checks, &held.report.verdict.checks);
        assert_eq!(checks.len(), limits.len() + 1, "{name}: {:?}", free.report.verdict.reasons);
        for (check, held) in checks.iter().zip(of_held) {
            let of_slope = check.figure.unit == "µrad";
            let over = of_slope.then_some("over 1 mm");
            assert_eq!(held.figure.scope.as_deref(), over, "{name}: {held:?}");
            let of_design = FIGURES.contains(&&check.figure.symbol[..]);
            let scope = match &check.figure.id[..] {
                // Filters take off the shape: there is no design of a texture.
                "sq" => None,
                _ if of_slope => Some("over 1 mm, about the fitted shape"),
                _ if of_design => Some("against the design"),
                _ => Some("about the fitted shape"),
            };
            assert_eq!(check.figure.scope.as_deref(), scope, "{name}: {check:?}");
            if of_design {
                let off = (check.value - held.value).abs();
                assert!(off < 1e-3 + 1e-6 * held.value, "{name}: {check:?}, {held:?}");
            }
        }
        let of = |id: &str| checks.iter().find(|check| check.figure.id == id).unwrap();
        assert!(of("pv").ok && !of("rmst").ok, "{name}: {:?} {:?}", of("pv"), of("rmst"));
        assert_eq!(of("pv").figure.words(), "PV about the fitted shape");
        assert_eq!((free.report.verdict.status, cautions(form(&free)).len()), (Status::Fail, 1));
    }
}

/// A limit that refers to the design takes the deviation from the design, with and without its uncertainty.
#[test]
fn limits_of_an_indication_are_of_the_design_without_uncertainties_too() {
    let part = |rest: &str| {
        format!(
            "[surface]\nkind = \"sphere\"\nradius_mm = 50\n[aperture]\nshape = \"circle\"\nradius_mm = 5\n\
             [fit]\nfree = [\"tx\", \"ty\", \"tz\", \"radius\"]\n[tolerance]\na_nm = 900\nb_nm = 60\n{rest}"
        )
    };
    let held = |rest: &str| -> Vec<(String, f64)> {
        let found = measured(&part(rest), 5.0, sphere(50.1));
        let checks = found.report.verdict.checks.iter();
        checks.map(|check| (check.figure.name.clone(), check.value)).collect()
    };
    let plain = held("");
    assert_eq!(plain, held("[uncertainty]\nnoise_nm = 0.1\ndraws = 20\n"));
    // The radius is 100 µm too long: some 500 nm of sagitta that the fit itself takes away.
    assert!(plain[0].1 > 400.0, "{plain:?}");
}
