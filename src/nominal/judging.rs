//! The tables `tolerance` and `uncertainty`: limits, guard band and error budget.

use std::f64::consts::PI;

use asphera_figures::{Definition, Indication, SlopeSettings, Subject, Term, Terms, Unit};
use asphera_form::Aperture;
use asphera_measure::{CorrelationFrom, Judging};
use asphera_settings::Section;
use asphera_uncertainty::verdict::{Guard, Limit};
use asphera_uncertainty::{Budget, Draws, Effect, Kernel, LongWave, Noise};

/// Reads the tables `tolerance` and `uncertainty`.
/// `has_texture` if the scale of the texture is stated; `aperture` is what zones must lie in.
pub(super) fn read(
    table: &Section<'_>,
    tolerance: &Section<'_>,
    has_texture: bool,
    aperture: Option<&Aperture>,
) -> Judging {
    let (mut limits, guard) = limits(tolerance, aperture);
    let indication = indication(tolerance, &mut limits);
    let above_0 = |key: &str| {
        let value = tolerance.get::<f64>(key)?;
        if value <= 0.0 {
            tolerance.problem(key, "a limit above 0", value);
        }
        Some(value)
    };
    let standards = Definition::AT_END.into_iter().filter_map(|definition| {
        let key = definition.key();
        let limit = above_0(&key)?;
        if definition.subject() == Subject::Filtered && !has_texture {
            tolerance.problem(&key, "the table figures.texture, which states the scale", "none");
        }
        Some((definition, limit))
    });
    let section = table.section("uncertainty");
    let (correlated, uncertainty) = (correlated(&section), uncertainty(&section, guard.is_some()));
    section.finish();
    Judging { indication, standards: standards.collect(), correlated, uncertainty, limits, guard }
}

/// Reads `indication`, and adds its limits to those there are.
fn indication(tolerance: &Section<'_>, limits: &mut Vec<Limit>) -> Option<Indication> {
    let text = tolerance.get::<String>("indication")?;
    let indication = match text.parse::<Indication>() {
        Ok(indication) => indication,
        Err(error) => {
            let expected = "an indication such as 3/500 nm(100 nm/50 nm); RMSi<20 nm";
            tolerance.problem("indication", expected, format!("{text:?}: {error}"));
            return None;
        }
    };
    for (definition, value) in indication.limits() {
        if value <= 0.0 {
            tolerance.problem("indication", "limits above 0, or a dash", format!("{definition} 0"));
        }
        if limits.iter().any(|limit| limit.is_of_whole() && limit.definition == definition) {
            tolerance.problem(&definition.key(), "one limit, here or in the indication", "both");
        }
        limits.push(Limit::of_whole(definition, value));
    }
    if indication.limits().is_empty() {
        tolerance.problem("indication", "a limit", format!("{text:?}, which has none"));
    }
    Some(indication)
}

/// Reads limits of figures and zones, and the guard band.
fn limits(tolerance: &Section<'_>, aperture: Option<&Aperture>) -> (Vec<Limit>, Option<Guard>) {
    let slope = slope(tolerance);
    let whole = &Definition::LIMITED;
    let mut limits = figures(tolerance, whole, &Aperture::None, slope, Terms::NONE);
    for zone in tolerance.array("zone") {
        let (inner_mm, outer_mm) = (zone.or("inner_mm", 0.0), zone.required("outer_mm"));
        let Some(outer_mm) = outer_mm else { continue };
        let ring = Aperture::Annulus { inner_mm, outer_mm };
        if let Err(error) = ring.validate() {
            zone.problem("outer_mm", "a radius above inner_mm", error);
        }
        lies_within(&zone, inner_mm, outer_mm, aperture);
        let before = limits.len();
        limits.extend(figures(&zone, &Definition::LIMITED, &ring, slope, Terms::NONE));
        must_limit(&zone, &limits[before..]);
        zone.finish();
    }
    for less in tolerance.array("less") {
        let terms = terms(&less).unwrap_or_default();
        let before = limits.len();
        limits.extend(figures(&less, &Definition::LIMITED, &Aperture::None, slope, terms));
        must_limit(&less, &limits[before..]);
        less.finish();
    }
    (limits, guard(tolerance))
}

/// The guard band of a table of limits, by `guard_factor` or `guard_probability`; `None` without both.
pub fn guard(table: &Section<'_>) -> Option<Guard> {
    let factor = table
        .has("guard_factor")
        .then(|| Guard::Factor(table.within("guard_factor", 2.0, 0.0..=10.0)));
    let probability = table
        .has("guard_probability")
        .then(|| Guard::Probability(table.within("guard_probability", 0.95, 0.501..=0.9999)));
    if factor.is_some() && probability.is_some() {
        table.problem("guard_factor", "either guard_factor or guard_probability", "both");
    }
    factor.or(probability)
}

/// Nothing is measured of a zone beside the aperture.
fn lies_within(zone: &Section<'_>, inner_mm: f64, outer_mm: f64, aperture: Option<&Aperture>) {
    let Some(aperture) = aperture else { return };
    let Some(to_mm) = aperture.reach_mm() else { return };
    let from_mm = aperture.hole_mm();
    if outer_mm > to_mm {
        zone.problem("outer_mm", format!("at most {to_mm} mm, where the aperture ends"), outer_mm);
    }
    if inner_mm < outer_mm && outer_mm <= from_mm {
        let expected = format!("above {from_mm} mm, where the aperture begins");
        zone.problem("outer_mm", expected, outer_mm);
    }
}

/// A table of limits that has none would be passed over in silence.
fn must_limit(table: &Section<'_>, limits: &[Limit]) {
    let keys = Definition::LIMITED.map(|one| one.key());
    if limits.is_empty() && !keys.iter().any(|key| table.has(key)) {
        table.problem("rms_nm", format!("a limit, one of {}", keys.join(", ")), "none");
    }
}

/// The limits of one table.
fn figures(
    table: &Section<'_>,
    definitions: &[Definition],
    zone: &Aperture,
    slope: Option<SlopeSettings>,
    less: Terms,
) -> Vec<Limit> {
    let read = |&definition: &Definition| {
        let key = definition.key();
        let value = table.get::<f64>(&key)?;
        if value <= 0.0 {
            table.problem(&key, "a limit above 0", value);
            return None;
        }
        let of_slope = definition.unit() == Unit::Microradians;
        if of_slope && slope.is_none() {
            table.problem(&key, "slope_over_mm and slope_step_mm in the table tolerance", "none");
            return None;
        }
        let slope = slope.filter(|_| of_slope);
        Some(Limit { definition, value, zone: zone.clone(), slope, less })
    };
    definitions.iter().filter_map(read).collect()
}

/// The terms that a table of limits has removed.
fn terms(table: &Section<'_>) -> Option<Terms> {
    let names = table.required::<Vec<String>>("terms")?;
    let found: Vec<Term> = Term::ALL
        .into_iter()
        .filter(|term| names.iter().any(|name| *name == term.to_string()))
        .collect();
    if found.len() < names.len() || found.is_empty() {
        let expected = format!("some of {}, each once", Terms::new(&Term::ALL));
        table.problem("terms", expected, format!("{names:?}"));
        return None;
    }
    Some(Terms::new(&found))
}

fn slope(tolerance: &Section<'_>) -> Option<SlopeSettings> {
    let (over_mm, step_mm) = (tolerance.get("slope_over_mm"), tolerance.get("slope_step_mm"));
    match SlopeSettings::new(over_mm?, step_mm?) {
        Ok(settings) => Some(settings),
        Err(error) => {
            tolerance.problem("slope_over_mm", "lengths above 0", error);
            None
        }
    }
}

/// Reads the table `uncertainty`; `needed` if something asks for uncertainties without it.
fn uncertainty(section: &Section<'_>, needed: bool) -> Option<(Budget, Draws)> {
    let noise = match section.get::<f64>("noise_nm") {
        None => Noise::Measured,
        Some(noise_nm) => {
            if noise_nm < 0.0 {
                section.problem("noise_nm", "a number not below 0", noise_nm);
            }
            Noise::Uniform { sigma_mm: noise_nm.max(0.0) * 1e-6, dof: f64::INFINITY }
        }
    };
    let long_waves = long_wave(section).into_iter().collect();
    let budget = Budget { noise, long_waves, effects: effects(section), ..Budget::default() };
    let is_exact = matches!(budget.noise, Noise::Uniform { sigma_mm: 0.0, .. });
    if is_exact
        && budget.effects.is_empty()
        && budget.long_waves.iter().all(|wave| wave.sigma_mm == 0.0)
    {
        let expected =
            "an error above 0; without noise_nm it is measured by the scatter of neighbours";
        section.problem("noise_nm", expected, "0, and no other error");
    }
    let count = section.within("draws", DRAWS, 20..=1_000_000);
    let draws = Draws { count, seed: section.or("seed", 0) };
    (section.is_present() || needed).then_some((budget, draws))
}

/// Reads where the correlation of errors comes from.
fn correlated(section: &Section<'_>) -> CorrelationFrom {
    let words = [
        ("none", CorrelationFrom::Nothing),
        ("budget", CorrelationFrom::Budget),
        ("deviations", CorrelationFrom::Deviations),
    ];
    let found = section.word("correlation", CorrelationFrom::Budget, &words);
    for key in ["long_wave_nm", "long_wave_mm", "long_wave_kernel"] {
        if found != CorrelationFrom::Budget && section.has(key) {
            section.problem(
                key,
                "no such key beside that correlation, or correlation = \"budget\"",
                "one",
            );
        }
    }
    found
}

fn long_wave(section: &Section<'_>) -> Option<LongWave> {
    let kernels = [Kernel::Gaussian, Kernel::Matern, Kernel::Exponential];
    let kernels = kernels.map(|kernel| (kernel.name(), kernel));
    let kernel = section.word("long_wave_kernel", Kernel::Gaussian, &kernels);
    let length_mm = section.get::<f64>("long_wave_mm");
    if length_mm.is_some() && !section.has("long_wave_nm") {
        section.problem("long_wave_nm", "a number not below 0, for long_wave_mm", "none");
    }
    let sigma_nm = section.get::<f64>("long_wave_nm")?;
    if sigma_nm < 0.0 {
        section.problem("long_wave_nm", "a number not below 0", sigma_nm);
        return None;
    }
    let Some(length_mm) = length_mm.filter(|length_mm| *length_mm > 0.0) else {
        section.problem("long_wave_mm", "a length above 0, for long_wave_nm", "none");
        return None;
    };
    Some(LongWave { sigma_mm: sigma_nm * 1e-6, length_mm, kernel, dof: f64::INFINITY })
}

fn effects(section: &Section<'_>) -> Vec<Effect> {
    let stated = |key: &str| {
        let u = section.get::<f64>(key)?;
        if u < 0.0 {
            section.problem(key, "a number not below 0", u);
        }
        (u > 0.0).then_some(u)
    };
    let mut effects = Vec::new();
    for (axis, key) in ["scale_x_ppm", "scale_y_ppm", "scale_z_ppm"].into_iter().enumerate() {
        effects.extend(stated(key).map(|u| Effect::scale(axis, u * 1e-6)));
    }
    let angles =
        [("square_xy_arcsec", 0, 1), ("square_xz_arcsec", 0, 2), ("square_yz_arcsec", 1, 2)];
    for (key, first, second) in angles {
        let u_rad = stated(key).map(|u| u * PI / (180.0 * 3600.0));
        effects.extend(u_rad.map(|u_rad| Effect::squareness(first, second, u_rad)));
    }
    let (expansion, u_k) = (stated("expansion_ppm_per_k"), stated("temperature_k"));
    match (expansion, u_k) {
        (Some(expansion), Some(u_k)) => effects.push(Effect::thermal(expansion * 1e-6, u_k)),
        (None, None) => {}
        _ => {
            section.problem(
                "temperature_k",
                "expansion_ppm_per_k and temperature_k",
                "one of them",
            );
        }
    }
    effects
}

/// Tells a standard uncertainty to 5 %.
const DRAWS: u32 = 200;

#[cfg(test)]
mod tests {
    use asphera_figures::Definition;

    use asphera_measure::Part;

    use super::super::part;
    use super::*;

    fn parse(rest: &str) -> Result<Part, String> {
        part::parse("n.toml", &format!("[surface]\nkind = \"plane\"\n{rest}"))
            .map_err(|problems| problems.to_string())
    }

    #[test]
    fn limits_alone_ask_for_no_uncertainty() {
        let part = parse("[tolerance]\nrms_nm = 20\npv_nm = 100\npvr_nm = 90\n").unwrap();
        let names: Vec<String> = part.judging.limits.iter().map(Limit::name).collect();
        assert_eq!(names, ["pv_nm", "rms_nm", "pvr_nm"]);
        assert_eq!((part.judging.uncertainty, part.judging.guard), (None, None));
    }

    #[test]
    fn limits_guard_and_budget_are_read() {
        let part = parse(
            "[tolerance]\npvr_nm = 80\nslope_max_urad = 30\nslope_over_mm = 1\nslope_step_mm = 0.5\n\
             guard_probability = 0.95\n[[tolerance.zone]]\nouter_mm = 4.5\nrms_nm = 5\n\
             [uncertainty]\nnoise_nm = 3\nlong_wave_nm = 10\nlong_wave_mm = 8\nscale_x_ppm = 2\n\
             expansion_ppm_per_k = 7.1\ntemperature_k = 0.2\ndraws = 500\nseed = 4\n",
        )
        .unwrap();
        let judging = part.judging;
        let names: Vec<String> = judging.limits.iter().map(Limit::name).collect();
        assert_eq!(names, ["pvr_nm", "slope_max_urad", "rms_nm 0-4.5 mm"]);
        assert_eq!(judging.limits[2].definition, Definition::RmsOverPoints);
        assert_eq!(judging.guard, Some(Guard::Probability(0.95)));
        let (budget, draws) = judging.uncertainty.unwrap();
        assert_eq!((budget.effects.len(), budget.long_waves.len()), (2, 1));
        assert_eq!(draws, Draws { count: 500, seed: 4 });
    }

    #[test]
    fn limits_may_be_of_what_terms_leave() {
        let part = parse(
            "[[tolerance.less]]\nterms = [\"tilt\", \"piston\", \"power\"]\nrms_nm = 9\npvr_nm = 40\n\
             [[tolerance.less]]\nterms = [\"astigmatism\"]\nrms_nm = 12\n",
        );
        let limits = part.unwrap().judging.limits;
        let names: Vec<String> = limits.iter().map(Limit::name).collect();
        let expected = [
            "rms_nm less piston, tilt, power",
            "pvr_nm less piston, tilt, power",
            "rms_nm less astigmatism",
        ];
        assert_eq!(names, expected);
        assert_eq!(limits[2].less, Terms::new(&[Term::Astigmatism]));
    }

    #[test]
    fn a_drawing_gives_limits() {
        let part = parse(
            "[tolerance]\nindication = \"3/0.5(0.1/0.05) RMSi < 0.02; λ = 546.07 nm\"\nrmsa_nm = 4\n",
        )
        .unwrap();
        let found: Vec<(String, f64)> =
            part.judging.limits.iter().map(|limit| (limit.definition.key(), limit.value)).collect();
        let expected = [
            ("rmsa_nm", 4.0),
            ("a_nm", 0.25 * 546.07),
            ("b_nm", 0.05 * 546.07),
            ("c_nm", 0.025 * 546.07),
            ("rmsi_nm", 0.01 * 546.07),
        ];
        for ((name, value), (expected, nm)) in found.iter().zip(expected) {
            assert!(*name == expected && (value - nm).abs() < 1e-9, "{name} {value}");
        }
        assert_eq!(found.len(), expected.len());
    }

    #[test]
    fn limits_of_texture_and_zone_are_read() {
        let part =
            parse("[tolerance]\nminimum_zone_nm = 80\nsq_nm = 3\n[figures.texture]\n").unwrap();
        let judging = part.judging;
        let expected = [
            (Definition::MinimumZone, 80.0),
            (Definition::Texture(asphera_figures::texture::Parameter::Sq), 3.0),
        ];
        assert_eq!(judging.standards, expected);
        assert_eq!((judging.limits, judging.uncertainty), (Vec::new(), None));
    }

    #[test]
    fn a_guard_band_alone_takes_the_noise_from_the_points() {
        let part = parse("[tolerance]\npv_nm = 9\nguard_factor = 2\n").unwrap();
        assert_eq!(part.judging.uncertainty.unwrap().0, Budget::default());
    }

    #[test]
    fn correlation_comes_from_the_budget_the_deviations_or_nowhere() {
        let correlated = |rest: &str| {
            let judging = parse(&format!("[uncertainty]\n{rest}")).unwrap().judging;
            (judging.correlated, judging.uncertainty.unwrap().0.long_waves)
        };
        assert_eq!(correlated(""), (CorrelationFrom::Budget, Vec::new()));
        assert_eq!(correlated("correlation = \"none\"\n"), (CorrelationFrom::Nothing, Vec::new()));
        let deviations = correlated("correlation = \"deviations\"\nscale_z_ppm = 1\n");
        assert_eq!(deviations, (CorrelationFrom::Deviations, Vec::new()));
        for (name, kernel) in [
            ("gaussian", Kernel::Gaussian),
            ("matern", Kernel::Matern),
            ("exponential", Kernel::Exponential),
        ] {
            let text =
                format!("long_wave_nm = 1\nlong_wave_mm = 2\nlong_wave_kernel = \"{name}\"\n");
            let (from, waves) = correlated(&text);
            assert_eq!((from, waves[0].kernel), (CorrelationFrom::Budget, kernel));
        }
    }

    #[test]
    fn what_does_not_go_together_is_named() {
        for (rest, key) in [
            ("[tolerance]\nguard_factor = 2\nguard_probability = 0.9\n", "tolerance.guard_factor"),
            ("[tolerance]\nslope_rms_urad = 2\n", "tolerance.slope_rms_urad"),
            ("[tolerance]\nb_nm = 0\n", "tolerance.b_nm"),
            ("[[tolerance.zone]]\npv_nm = 3\n", "outer_mm"),
            ("[[tolerance.less]]\nrms_nm = 3\n", "tolerance.less[0].terms"),
            ("[[tolerance.less]]\nterms = [\"trefoil\"]\n", "each once"),
            ("[[tolerance.less]]\nterms = []\n", "tolerance.less[0].terms"),
            ("[tolerance]\nsq_nm = 3\n", "tolerance.sq_nm"),
            ("[[tolerance.zone]]\nouter_mm = 3\n", "tolerance.zone[0].rms_nm: expected a limit"),
            ("[uncertainty]\nnoise_nm = 0\n", "uncertainty.noise_nm: expected an error above 0"),
            ("[uncertainty]\nlong_wave_mm = 3\n", "uncertainty.long_wave_nm"),
            ("[tolerance]\nminimum_zone_nm = 0\n", "tolerance.minimum_zone_nm"),
            ("[tolerance]\nindication = \"3/2(1/x)\"\n", "at character 7, found \"x\""),
            ("[tolerance]\nindication = \"3/-\"\n", "which has none"),
            ("[tolerance]\nindication = \"3/0\"\n", "tolerance.indication"),
            ("[tolerance]\nb_nm = 2\nindication = \"3/-(2)\"\n", "tolerance.b_nm"),
            ("[uncertainty]\nlong_wave_nm = 3\n", "uncertainty.long_wave_mm"),
            ("[uncertainty]\ntemperature_k = 3\n", "uncertainty.temperature_k"),
            ("[uncertainty]\nnoise_um = 3\n", "uncertainty.noise_um"),
            ("[uncertainty]\ncorrelation = \"data\"\n", "\"none\" or \"budget\" or \"deviations\""),
            (
                "[uncertainty]\ncorrelation = \"none\"\nlong_wave_nm = 1\nlong_wave_mm = 1\n",
                "uncertainty.long_wave_mm",
            ),
        ] {
            let problems = parse(rest).unwrap_err();
            assert!(problems.contains(key), "{problems}");
        }
    }

    #[test]
    fn zones_lie_in_the_aperture() {
        let ring = "[aperture]\nshape = \"annulus\"\ninner_radius_mm = 3\nouter_radius_mm = 9\n";
        let zone = |inner_mm: f64, outer_mm: f64| {
            let zone = format!(
                "[[tolerance.zone]]\ninner_mm = {inner_mm}\nouter_mm = {outer_mm}\nrms_nm = 5\n"
            );
            parse(&format!("{ring}{zone}")).map(|part| part.judging.limits.len())
        };
        assert_eq!(zone(0.0, 9.0), Ok(1));
        assert!(
            zone(8.0, 9.5)
                .unwrap_err()
                .contains("outer_mm: expected at most 9 mm, where the aperture")
        );
        assert!(
            zone(0.0, 3.0)
                .unwrap_err()
                .contains("outer_mm: expected above 3 mm, where the aperture")
        );
    }
}
