//! The nominal file: design surface, aperture, fit and limits.

use std::path::Path;

use asphera_figures::Definition;
use asphera_form::ReferenceSettings;
use asphera_form::{Loss, MeasuredFrom, Parameter, provisional};
use asphera_measure::{COVERAGE_MIN, CorrelationFrom, Criterion, Judging, Part, Weights};
use asphera_settings::{Problems, Section};
use asphera_surface::coverage::Target;

use super::surface::{self, Surface};
use super::{aperture, criterion, defects, figures, judging, text};

/// Reads a nominal file. `name` is its path: it stands in every problem, and files it names are found
/// from its folder.
///
/// # Errors
///
/// All problems of the file, each with line and key.
pub fn parse(name: &str, text: &str) -> Result<Part, Problems> {
    let file = text::parse(name, text)?;
    let root = file.root();
    let part = read(&root, folder(name));
    root.finish();
    drop(root);
    file.conclude(part)
}

/// The folder of a file.
pub fn folder(name: &str) -> &Path {
    Path::new(name).parent().unwrap_or(Path::new(""))
}

/// Reads the tables `surface`, `aperture`, `fit`, `figures`, `tolerance`, `uncertainty`, `sampling`, `defects` and
/// `partition` of `table`. Files they name are found from `folder`.
pub fn read(table: &Section<'_>, folder: &Path) -> Option<Part> {
    let section = table.section("surface");
    let surface = surface::read(&section, folder);
    section.finish();
    let section = table.section("aperture");
    let aperture = aperture::read(&section, folder);
    let centre_mm = place_mm(&section, "centre_mm");
    let (aperture, centre_mm) = aperture::centred(aperture, centre_mm, surface.as_ref());
    let surface = match (surface, centre_mm) {
        (Some(surface), Some(centre_mm)) => surface::about(surface, &section, centre_mm),
        (surface, _) => surface,
    };
    if let (Some(surface), Some(aperture)) = (&surface, &aperture) {
        aperture::must_end_before(&section, aperture, surface);
    }
    section.finish();

    let fit = table.section("fit");
    let free = free(&fit, surface.as_ref());
    let criterion = criterion::criterion(&fit);
    let side = side(&fit, &free);
    fit.finish();

    let tolerance = table.section("tolerance");
    let figures = figures::read(table);
    let judging = judging::read(table, &tolerance, figures.texture.is_some(), aperture.as_ref());
    tolerance.finish();

    let reference = surface.as_ref().and_then(|surface| surface.reference.clone());
    if reference.is_some() {
        goes_with_unknown(&fit, &criterion, table, &judging);
        let limited = judging.standards.iter().map(|(figure, _)| figure);
        let mut asked = figures.of_points.iter().chain(limited);
        if let Some(asked) = asked.find(|figure| Definition::OF_POINTS.contains(figure)) {
            let expected = format!("no {}: an unknown surface follows the points", asked.symbol());
            table.problem("figures", expected, "one");
        }
    }

    let sampling = table.section("sampling");
    let gap_limit_mm =
        sampling.has("gap_limit_mm").then(|| sampling.within("gap_limit_mm", 1.0, 1e-6..=1e6));
    let share = |key| sampling.has(key).then(|| sampling.within(key, 1.0, 1e-6..=1.0));
    let rho_limit = share("rho_limit");
    let otherwise = rho_limit.is_none().then_some(Target::COCONE_EPSILON);
    let epsilon_limit = share("epsilon_limit").or(otherwise);
    let coverage_min = sampling.within("coverage_min", COVERAGE_MIN, 0.0..=1.0);
    sampling.finish();
    let (defects, flat_below_per_mm) = (defects::limits(table), defects::flat_below_per_mm(table));
    let aperture = aperture?;
    Some(Part {
        nominal: surface?.nominal,
        reference: reference
            .map(|settings| ReferenceSettings { aperture: aperture.clone(), ..settings }),
        aperture,
        centre_mm: centre_mm.unwrap_or_default(),
        free,
        criterion,
        side,
        judging,
        figures,
        gap_limit_mm,
        epsilon_limit,
        rho_limit,
        coverage_min,
        defects,
        flat_below_per_mm,
    })
}

/// A place, x and y in mm.
pub(super) fn place_mm(section: &Section<'_>, key: &str) -> Option<[f64; 2]> {
    let place: Vec<f64> = section.get(key)?;
    let found = place.len();
    let place: Option<[f64; 2]> = place.try_into().ok();
    let place = place.filter(|place: &[f64; 2]| place.iter().all(|mm| mm.is_finite()));
    if place.is_none() {
        section.problem(key, "x and y in mm, as [x, y]", format!("{found} numbers"));
    }
    place
}

/// The key `side` of the table `[fit]`.
fn side(fit: &Section<'_>, free: &[Parameter]) -> MeasuredFrom {
    let side = fit.word(
        "side",
        MeasuredFrom::Given,
        &[("given", MeasuredFrom::Given), ("either", MeasuredFrom::Either)],
    );
    let tilts = [Parameter::Rx, Parameter::Ry];
    if side == MeasuredFrom::Either && !tilts.iter().all(|tilt| free.contains(tilt)) {
        let expected = "\"given\": only a fit with rx and ry free can turn the part over";
        fit.problem("side", expected, "\"either\"");
    }
    side
}

/// What a surface made from the points does not go together with.
fn goes_with_unknown(
    fit: &Section<'_>,
    criterion: &Criterion,
    table: &Section<'_>,
    judging: &Judging,
) {
    if fit.has("free") {
        fit.problem("free", "no such key: an unknown surface has nothing to free", "one");
    }
    if fit.has("side") {
        fit.problem("side", "no such key: an unknown surface has no other side", "one");
    }
    if criterion.loss != Loss::Squares {
        fit.problem("loss", "\"squares\": splines are fitted by them", "another");
    }
    if criterion.weights != Weights::None {
        fit.problem(
            "weights",
            "\"none\": splines are fitted to points that count alike",
            "another",
        );
    }
    if judging.correlated == CorrelationFrom::Deviations {
        let expected =
            "\"budget\" or \"none\": a surface made from the points has no parameters to know";
        table.section("uncertainty").problem("correlation", expected, "\"deviations\"");
    }
    let budget = judging.uncertainty.as_ref().map(|(budget, _)| budget);
    if budget.is_some_and(|budget| !budget.long_waves.is_empty() || !budget.effects.is_empty()) {
        let expected = "noise alone: long waves and effects of the machine vanish in a surface made from the points";
        table.problem("uncertainty", expected, "more");
    }
}

fn free(fit: &Section<'_>, surface: Option<&Surface>) -> Vec<Parameter> {
    if surface.is_some_and(|surface| surface.reference.is_some()) {
        return provisional().1;
    }
    let Some(names) = fit.get::<Vec<String>>("free") else {
        // Where a surface is not of revolution, a turn about z counts too.
        let is_round = surface.is_none_or(|surface| surface.is_round);
        return if is_round { Parameter::RIGID.to_vec() } else { Parameter::POSE.to_vec() };
    };
    let nominal = surface.map(|surface| &surface.nominal);
    let mut free = Vec::new();
    for name in &names {
        // A freeform has names of its own; what any other has, every name tells.
        let parameter = match nominal {
            Some(nominal) if !nominal.is_rotational() => nominal.parameter(name),
            _ => name.parse::<Parameter>(),
        };
        match parameter {
            Ok(parameter) if nominal.is_some_and(|nominal| !nominal.has(parameter)) => {
                fit.problem("free", "parameters of this surface", format!("{name:?}"));
            }
            Ok(parameter) if free.contains(&parameter) => {
                fit.problem("free", "each parameter once", format!("{name:?} twice"));
            }
            Ok(parameter) => free.push(parameter),
            Err(error) => fit.problem("free", "names of parameters", error),
        }
    }
    free
}

#[cfg(test)]
mod tests {
    use asphera_figures::Definition;
    use asphera_form::Nominal;
    use asphera_uncertainty::verdict::Limit;

    use super::*;

    #[test]
    fn a_plane_needs_no_more_than_its_kind() {
        let part = parse("plane.toml", "[surface]\nkind = \"plane\"\n").unwrap();
        assert_eq!(part.nominal, Nominal::Plane);
        assert_eq!(part.free, Parameter::RIGID);
    }

    #[test]
    fn an_asphere_is_read_whole() {
        let part = parse(
            "a.toml",
            "[surface]\nkind = \"asphere\"\nradius_mm = 11.65\nconic = -1.1\nA4 = 3.69067205091e-5\n\
             [aperture]\nshape = \"circle\"\nradius_mm = 9\n[fit]\nfree = [\"tz\", \"radius\", \"A4\"]\n\
             [tolerance]\npv_nm = 300\n",
        )
        .unwrap();
        assert_eq!(part.nominal.radius_mm(), Some(11.65));
        assert_eq!(part.free, [Parameter::Tz, Parameter::Radius, Parameter::A(4)]);
        assert_eq!(part.limits(), [Limit::of_whole(Definition::PeakToValley, 300.0)]);
    }

    #[test]
    fn limits_of_the_sampling_are_shares_and_lengths() {
        let limits = |text: &str| {
            let text = format!("[surface]\nkind = \"plane\"\n[sampling]\n{text}");
            let part = parse("n.toml", &text).map_err(|problems| problems.to_string())?;
            Ok::<_, String>((part.epsilon_limit, part.rho_limit, part.gap_limit_mm))
        };
        assert_eq!(limits(""), Ok((Some(0.05), None, None)));
        assert_eq!(limits("rho_limit = 0.1\n"), Ok((None, Some(0.1), None)));
        let all = "rho_limit = 0.1\nepsilon_limit = 0.2\ngap_limit_mm = 3\n";
        assert_eq!(limits(all), Ok((Some(0.2), Some(0.1), Some(3.0))));
        for key in ["rho_limit", "epsilon_limit"] {
            for value in ["0", "-0.1", "1.5", "nan", "inf"] {
                let problems = limits(&format!("{key} = {value}\n")).unwrap_err();
                assert!(problems.contains(&format!("sampling.{key}: expected")), "{problems}");
            }
        }
    }

    #[test]
    fn the_middle_of_an_aperture_is_a_place_of_the_points_or_beside_the_vertex() {
        let circle = "[aperture]\nshape = \"circle\"\nradius_mm = 2\ncentre_mm = [3, -1.5]\n";
        let read = |surface: &str, aperture: &str| {
            parse("n.toml", &format!("[surface]\n{surface}\n{aperture}"))
                .map_err(|problems| problems.to_string())
        };
        let flat = read("kind = \"plane\"", circle).unwrap();
        assert_eq!((flat.nominal, flat.centre_mm), (Nominal::Plane, [3.0, -1.5]));
        let unknown = read("kind = \"unknown\"", circle).unwrap();
        assert_eq!(unknown.reference.unwrap().centre_mm, Some([3.0, -1.5]));
        // The piece about that place, whose middle is the origin.
        let sphere = Nominal::Sphere { radius_mm: 20.0 };
        let piece = read("kind = \"sphere\"\nradius_mm = 20", circle).unwrap();
        let rise_mm =
            |x: f64| sphere.sag_mm((3.0 + x).hypot(1.5)) - sphere.sag_mm(3.0_f64.hypot(1.5));
        assert!((piece.nominal.height_mm(1.0, 0.0).unwrap() - rise_mm(1.0)).abs() < 1e-12);
        assert_eq!(piece.free, Parameter::RIGID);
        let both = read("kind = \"unknown\"\ncentre_mm = [1, 2]", circle).unwrap_err();
        assert!(both.contains("aperture.centre_mm: expected either surface.centre_mm"), "{both}");
        let one = read("kind = \"plane\"", &circle.replace(", -1.5", "")).unwrap_err();
        assert!(one.contains("aperture.centre_mm: expected x and y in mm"), "{one}");
    }

    #[test]
    fn an_aperture_beyond_the_end_of_the_surface_is_refused() {
        let surface = "[surface]\nkind = \"asphere\"\nradius_mm = 11.65\nconic = 5\n[aperture]\n";
        let circle = "shape = \"circle\"\nradius_mm = 9\n";
        let ring = "shape = \"annulus\"\ninner_radius_mm = 1\nouter_radius_mm = 4.8\n";
        for (aperture, key) in [(circle, "aperture.radius_mm"), (ring, "aperture.outer_radius_mm")]
        {
            let problems = parse("n.toml", &format!("{surface}{aperture}")).unwrap_err();
            assert_eq!(problems.0.len(), 1, "{problems}");
            assert_eq!(problems.0[0].key, key);
            assert!(problems.to_string().contains("at most 4.756093 mm"), "{problems}");
        }
        // 11.65/√6 = 4.756…
        assert!(parse("n.toml", &format!("{surface}{}", ring.replace("4.8", "4.7"))).is_ok());
    }

    #[test]
    fn an_aperture_beyond_any_surface_is_refused_with_the_place() {
        let circle = "[aperture]\nshape = \"circle\"\nradius_mm = 9\n";
        let sheet = "[aperture]\nshape = \"rectangle\"\nwidth_mm = 18\nheight_mm = 8\n";
        let q = "kind = \"q-con\"\nradius_mm = 30\ncoefficients_mm = [1e-3]\nnormalisation_radius_mm = ";
        let chebyshev = "kind = \"chebyshev\"\nbase = \"flat\"\nhalf_x_mm = 9\nhalf_y_mm = 4\nterms = [{ x = 2, y = 0, mm = 1 }]\n";
        let toroid = "kind = \"toroid\"\nradius_mm = 30\nrotation_radius_mm = 5\n";
        let power = "kind = \"asphere\"\nradius_mm = 30\nA20 = ";
        let refused = |surface: &str, aperture: &str, said: &str| {
            let problems = parse("n.toml", &format!("[surface]\n{surface}\n{aperture}"));
            let problems = problems.unwrap_err();
            assert_eq!(problems.0.len(), 1, "{problems}");
            assert!(problems.to_string().contains(said), "{problems}");
        };
        refused(&format!("{q}5"), circle, "aperture.radius_mm: expected an aperture within");
        refused(chebyshev, circle, "no height at x 8.019059, y 4.085914 mm");
        refused(toroid, circle, "no height at x 9.000000, y 0.000000 mm");
        refused(
            "kind = \"sphere\"\nradius_mm = 8",
            sheet,
            "aperture.width_mm: expected an aperture",
        );
        refused(&format!("{power}1e300"), circle, "correct the surface");
        refused(&format!("{power}1e-3"), circle, "e16 mm high at x 9.000000");
        for (surface, aperture) in [
            (format!("{q}9"), circle),
            (chebyshev.to_owned(), sheet),
            (format!("{power}1e-20"), circle),
        ] {
            let text = format!("[surface]\n{surface}\n{aperture}");
            assert!(parse("n.toml", &text).is_ok(), "{text}");
        }
    }

    #[test]
    fn every_mistake_is_named() {
        let text = "[surface]\nkind = \"plane\"\nradius = 3\n[aperture]\nshape = \"circle\"\n\
                    [fit]\nfree = [\"tz\", \"radius\", \"piston\"]\n[tolerance]\npv_nm = -1\n[extra]\n";
        let problems = parse("n.toml", text).unwrap_err();
        let places: Vec<_> =
            problems.0.iter().map(|problem| (problem.line, problem.key.as_str())).collect();
        assert_eq!(
            places,
            [
                (3, "surface.radius"),
                (4, "aperture.radius_mm"),
                (7, "fit.free"),
                (7, "fit.free"),
                (9, "tolerance.pv_nm"),
                (10, "extra"),
            ],
            "{problems}"
        );
    }
}
