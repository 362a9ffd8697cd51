//! Uncertainties with a known answer: closed forms, dense matrices, equal bits.

use crate::common::{Noise as Uniform, al1815, misaligned, spiral};
use asphera_figures::{Reference, Sample, Term, Terms, remove, rms};
use asphera_form::artefact::Artefact;
use asphera_form::form_error::FormError;
use asphera_form::{
    Aperture, Fit, FitSettings, Nominal, Parameter, PointMm, Pose, ZoneSettings, deviations, fit,
    fit_weighted, minimum_zone,
};
use asphera_uncertainty::verdict::{
    Decision, Finding, Guard, Limit, Over, Status, decide, finding, least,
};
use asphera_uncertainty::{
    Average, Budget, Draws, Effect, Kernel, LongWave, Noise, Uncertainty, UncertaintyError,
    coverage_factor, glance, type_a, uncertainty,
};
use nalgebra::DMatrix;
use rayon::prelude::*;

fn rigid_and_radius() -> Vec<Parameter> {
    Parameter::RIGID.iter().copied().chain([Parameter::Radius]).collect()
}

fn part(count: usize) -> (Vec<PointMm>, Vec<[f64; 2]>, Fit) {
    let sample = spiral(count, 9.0);
    let error = FormError { ring: None, ..FormError::typical(9.0) };
    let error_mm = move |x: f64, y: f64| error.height_nm(x, y) * 1e-6;
    let free = rigid_and_radius();
    let artefact = Artefact::new(al1815(), misaligned(), &free, &sample, error_mm).unwrap();
    let points: Vec<PointMm> =
        sample.iter().map(|&[x, y]| artefact.point_mm(x, y).unwrap()).collect();
    let settings = FitSettings { free, ..FitSettings::default() };
    let fitted = fit(&points, &al1815(), &settings).unwrap();
    (points, sample, fitted)
}

fn uniform(sigma_mm: f64) -> Noise {
    Noise::Uniform { sigma_mm, dof: f64::INFINITY }
}

fn wave(kernel: Kernel, length_mm: f64) -> LongWave {
    LongWave { sigma_mm: 30e-6, length_mm, kernel, dof: f64::INFINITY }
}

/// J by central differences of the public deviations.
fn jacobian(points: &[PointMm], fitted: &Fit) -> DMatrix<f64> {
    let columns: Vec<Vec<f64>> = rigid_and_radius()
        .iter()
        .map(|parameter| {
            let at = |step: f64| {
                let (mut pose, mut nominal) = (fitted.pose, fitted.nominal.clone());
                match (parameter, &mut nominal) {
                    (Parameter::Tx, _) => pose.tx_mm += step,
                    (Parameter::Ty, _) => pose.ty_mm += step,
                    (Parameter::Tz, _) => pose.tz_mm += step,
                    (Parameter::Rx, _) => pose.rx_rad += step,
                    (Parameter::Ry, _) => pose.ry_rad += step,
                    (Parameter::Radius, Nominal::Asphere(asphere)) => asphere.radius_mm += step,
                    other => panic!("{other:?}"),
                }
                deviations(points, &nominal, &pose)
            };
            let h = 1e-4;
            let (above, below) = (at(h), at(-h));
            above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * h)).collect()
        })
        .collect();
    DMatrix::from_fn(points.len(), columns.len(), |i, j| columns[j][i])
}

/// G·U·Gᵀ with every matrix written out, for weights w.
fn dense(
    jacobian: &DMatrix<f64>,
    weights: &[f64],
    u: impl Fn(usize, usize) -> f64,
) -> DMatrix<f64> {
    let n = weights.len();
    let weighted = DMatrix::from_fn(n, jacobian.ncols(), |i, j| weights[i] * jacobian[(i, j)]);
    let gram = jacobian.tr_mul(&weighted);
    let gain = gram.try_inverse().unwrap() * weighted.transpose();
    let u = DMatrix::from_fn(n, n, u);
    &gain * u * gain.transpose()
}

fn assert_close(found: &Uncertainty, truth: &DMatrix<f64>, relative: f64) {
    for (index, parameter) in found.parameters.iter().enumerate() {
        let u = truth[(index, index)].sqrt();
        let name = parameter.parameter;
        assert!((parameter.u / u - 1.0).abs() < relative, "{name}: {} {u}", parameter.u);
        for other in 0..truth.ncols() {
            let size = u * truth[(other, other)].sqrt();
            let error =
                (found.covariance.entry(index, other).unwrap() - truth[(index, other)]).abs();
            assert!(error < 2.0 * relative * size, "{name} with {other}: {error:e} of {size:e}");
        }
        let square: f64 = parameter.sources.iter().map(|(_, u)| u * u).sum();
        assert!((square.sqrt() / parameter.u - 1.0).abs() < 1e-12);
    }
}

#[test]
fn noise_as_large_as_the_residuals_gives_the_covariance_of_the_fit() {
    let (points, _, fitted) = part(500);
    let budget = Budget { noise: uniform(fitted.sigma_mm), ..Budget::default() };
    let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
    for (estimate, of) in fitted.estimates.iter().zip(&found.parameters) {
        assert!((of.u / estimate.u.unwrap() - 1.0).abs() < 1e-9, "{:?}", of.parameter);
        assert_eq!(of.dof, f64::INFINITY);
        assert!((of.expanded(0.95).k - 1.959_963_985).abs() < 1e-8);
    }
    assert!((coverage_factor(0.95, 10.0) - 2.228_138_852).abs() < 1e-8);
    // Noise alone leaves √((n − p)/n) of itself.
    let left = fitted.sigma_mm * 1e6 * (494.0_f64 / 500.0).sqrt();
    assert!((found.rms.noise_nm / left - 1.0).abs() < 1e-9);
    assert!(found.rms.form_nm < 1e-3 && found.rms.interval_nm(0.95)[0] == 0.0);
}

#[test]
fn unequal_noise_under_weights_and_effects_as_by_dense_matrices() {
    let (points, _, _) = part(300);
    let sigma_mm: Vec<f64> = (0..300).map(|i| 1e-5 * (1.0 + f64::from(i % 7))).collect();
    // Weights that are not those of the noise.
    let stated: Vec<f64> = (0..300).map(|i| 1e-5 * (1.0 + f64::from(i % 3))).collect();
    let settings = FitSettings { free: rigid_and_radius(), ..FitSettings::default() };
    let fitted = fit_weighted(&points, Some(&stated), &al1815(), &settings).unwrap();
    let effects = vec![Effect::scale(0, 2e-6), Effect::squareness(1, 2, 3e-6)];
    let budget = Budget {
        noise: Noise::EachPoint(sigma_mm.clone()),
        effects: effects.clone(),
        ..Budget::default()
    };
    let found = uncertainty(&points, &fitted, &Aperture::None, Some(&stated), &budget).unwrap();
    let j = jacobian(&points, &fitted);
    let weights: Vec<f64> = stated.iter().map(|u| (1e-5 / u).powi(2)).collect();
    // The normal is the derivative by the shifts with the other sign.
    let lifted = |effect: usize, i: usize| match effect {
        0 => -j[(i, 0)] * 2e-6 * points[i][0],
        _ => -j[(i, 1)] * 3e-6 * points[i][2],
    };
    let truth = dense(&j, &weights, |a, b| {
        let own = if a == b { sigma_mm[a] * sigma_mm[a] } else { 0.0 };
        own + (0..2).map(|effect| lifted(effect, a) * lifted(effect, b)).sum::<f64>()
    });
    assert_close(&found, &truth, 1e-6);
    assert_eq!(found.parameters[0].sources[1].0, "scale of x");
}

#[test]
fn long_waves_as_by_dense_matrices() {
    for (count, kernel, length_mm, relative) in [
        (400, Kernel::Gaussian, 5.0, 2e-3),
        (400, Kernel::Exponential, 5.0, 2e-2),
        // More points than nodes.
        (2500, Kernel::Gaussian, 4.0, 5e-3),
        (2500, Kernel::Exponential, 4.0, 3e-2),
    ] {
        let (points, sample, fitted) = part(count);
        let wave = wave(kernel, length_mm);
        let budget = Budget { noise: uniform(5e-6), long_waves: vec![wave], ..Budget::default() };
        let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
        let truth = dense(&jacobian(&points, &fitted), &vec![1.0; count], |a, b| {
            let h = (sample[a][0] - sample[b][0]).hypot(sample[a][1] - sample[b][1]) / length_mm;
            let correlation = match kernel {
                Kernel::Gaussian => (-0.5 * h * h).exp(),
                Kernel::Matern => (1.0 + h) * (-h).exp(),
                Kernel::Exponential => (-h).exp(),
            };
            9e-10 * correlation + if a == b { 2.5e-11 } else { 0.0 }
        });
        assert_close(&found, &truth, relative);
        let independent = Budget { noise: uniform(30.4e-6), ..Budget::default() };
        let optimistic =
            uncertainty(&points, &fitted, &Aperture::None, None, &independent).unwrap();
        let ratio = found.parameters[0].u / optimistic.parameters[0].u;
        eprintln!(
            "{count} points, {kernel:?}: {:.1e} neglected, u(tx) {ratio:.1} times that of independent noise",
            found.neglected[0]
        );
        assert!(ratio > 2.0);
    }
}

#[test]
fn warmth_makes_a_sphere_larger_and_moves_its_centre() {
    let nominal = Nominal::Sphere { radius_mm: 20.0 };
    let pose = Pose { tx_mm: 3.0, tz_mm: -5.0, ..Pose::default() };
    let place = |&[x, y]: &[f64; 2]| pose.to_measured([x, y, nominal.sag_mm(x.hypot(y))]);
    let points: Vec<PointMm> = spiral(400, 9.0).iter().map(place).collect();
    let free = vec![Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Radius];
    let settings = FitSettings { free, start: pose, ..FitSettings::default() };
    let fitted = fit(&points, &nominal, &settings).unwrap();
    let effects = vec![Effect::thermal(1e-5, 0.2)];
    let budget = Budget { noise: uniform(0.0), effects, ..Budget::default() };
    let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
    // Every coordinate grows by 2e-6: the radius of 20 mm, and the vertex at (3, 0, −5) mm.
    for (of, truth) in found.parameters.iter().zip([6e-6, 0.0, 1e-5, 4e-5]) {
        assert!((of.u - truth).abs() < 1e-12, "{:?}: {}", of.parameter, of.u);
    }
}

/// By noise alone u is that of two places; the same bits come from any number of threads, and without errors nothing is in
/// doubt.
#[test]
fn single_places_tell_the_peak_to_valley() {
    let (points, _, fitted) = part(3000);
    let draws = Draws { count: 400, seed: 5 };
    for (noise_mm, long_waves, u_nm) in [
        (5e-6, vec![], 5.0 * 2.0_f64.sqrt()..=5.0 * 2.0_f64.sqrt() * (1.0 + 1e-9)),
        // Of two places that are far apart, u would be √2·√(10² + 30²) but for what the fit takes up.
        (10e-6, vec![wave(Kernel::Gaussian, 5.0)], 20.0..=44.8),
        (0.0, vec![], 0.0..=1e-9),
    ] {
        let budget = Budget { noise: uniform(noise_mm), long_waves, ..Budget::default() };
        let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
        let pv = found.peak_to_valley_nm(&draws).unwrap();
        assert!(u_nm.contains(&pv.u), "{} {u_nm:?}", pv.u);
        let range = |mm: &[f64]| {
            let ends = mm.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| {
                [low.min(value), high.max(value)]
            });
            Some((ends[1] - ends[0]) * 1e6)
        };
        let plain = found.simulate(&draws, range).unwrap().unwrap();
        assert_eq!(pv.measured, plain.measured);
        let [low, high] = pv.interval(0.95);
        eprintln!(
            "PV {:.1} nm, u {:.2} nm, bias {:.2} nm, {low:.1} to {high:.1} nm, {} candidates",
            pv.measured, pv.u, pv.bias, pv.candidates
        );
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(alone.install(|| found.peak_to_valley_nm(&draws).unwrap()), pv);
        if noise_mm > 0.0 {
            // Draws of what holds noise already tell a part of the bias.
            assert!(pv.bias > plain.bias && low < pv.measured - pv.bias && pv.measured < high);
        } else {
            assert!(pv.bias < 1e-9 && high - low < 1e-9, "{pv:?}");
        }
    }
}

/// 500 measurements of 800 points, noise a tenth of the form: how often the interval of the PV holds it.
#[test]
fn peak_to_valley_of_form_that_stands_out() {
    let (points, _, fitted) = part(800);
    let normals: Vec<[f64; 3]> = points
        .iter()
        .map(|&point| {
            let normal = al1815().foot(fitted.pose.to_part(point)).unwrap().normal;
            let (end, origin) =
                (fitted.pose.to_measured(normal), fitted.pose.to_measured([0.0; 3]));
            std::array::from_fn(|axis| end[axis] - origin[axis])
        })
        .collect();
    let truth = (fitted.residuals.high_mm - fitted.residuals.low_mm) * 1e6;
    let mut random = Uniform::new(3);
    let mut inside = 0;
    for seed in 0..500 {
        let noisy: Vec<PointMm> = points
            .iter()
            .zip(&normals)
            .map(|(point, normal)| {
                // Twelve uniform numbers of variance 1/3 make a nearly normal one.
                let error: f64 = (0..12).map(|_| random.next()).sum::<f64>() * 0.5 * 3e-6;
                std::array::from_fn(|axis| point[axis] + error * normal[axis])
            })
            .collect();
        let settings = FitSettings {
            free: rigid_and_radius(),
            start: fitted.pose,
            search: false,
            ..FitSettings::default()
        };
        let again = fit(&noisy, &al1815(), &settings).unwrap();
        let budget = Budget::default();
        let found = uncertainty(&noisy, &again, &Aperture::None, None, &budget).unwrap();
        let pv = found.peak_to_valley_nm(&Draws { count: 400, seed }).unwrap();
        let [low, high] = pv.interval(0.95);
        inside += usize::from((low..=high).contains(&truth));
    }
    eprintln!("PV of {truth:.1} nm inside its 95 % interval in {:.1} %", inside as f64 / 5.0);
    assert!(inside >= 450, "{inside} of 500");
}

/// All that there is, every point alike.
const OVER: Over<'static> = Over { aperture: &Aperture::None, areas_mm2: None };

/// Held by a guard band, with as much hidden.
fn held(
    (limit, nominal): (&Limit, &Nominal),
    found: &Uncertainty,
    guard: Guard,
    hidden: Option<f64>,
) -> Decision {
    let draws = Draws { count: 40, seed: 1 };
    let finding = finding(limit, found, nominal, OVER, &draws).unwrap().unwrap();
    decide(&Finding { hidden, ..finding }, limit.value, guard).unwrap()
}

#[test]
fn limits_over_zones_are_judged_with_their_uncertainty() {
    let (points, _, fitted) = part(1500);
    let budget = Budget { noise: uniform(5e-6), ..Budget::default() };
    let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
    let zone = Aperture::Annulus { inner_mm: 0.0, outer_mm: 4.5 };
    let mut limits: Vec<Limit> =
        ["pv 1e4", "rms 1", "pvr 1e4", "A 1e4", "B 1e4", "C 1e4", "RMSt 1e4", "RMSa 1e4"]
            .iter()
            .map(|text| text.parse().unwrap())
            .collect();
    limits.push(Limit { zone: zone.clone(), ..limits[0].clone() });
    let terms = [Term::Power, Term::Astigmatism, Term::Coma];
    limits.push(Limit { value: 1e4, less: Terms::new(&terms), ..limits[1].clone() });
    limits.push(Limit { less: Terms::new(&terms), zone, ..limits[0].clone() });
    let nominal = &fitted.nominal;
    let held_all =
        limits.iter().map(|limit| held((limit, nominal), &found, Guard::default(), Some(0.0)));
    let decisions: Vec<Decision> = held_all.collect();
    for (index, (limit, decision)) in limits.iter().zip(&decisions).enumerate() {
        let expected = if index == 1 { Status::Fail } else { Status::Pass };
        assert_eq!(decision.status, expected, "{limit:?}");
        let u = decision.finding.u.unwrap();
        assert!(u > 0.0 && u < 10.0, "{limit:?}: {u}");
        assert!((decision.band.unwrap() / u - 1.644_853_627).abs() < 1e-6);
    }
    let value = |index: usize| decisions[index].finding.value;
    assert!(value(8) < value(0));
    // Of a range over a zone or without terms, u is that of two places too.
    for index in [0, 8, 10] {
        let finding = decisions[index].finding;
        assert!((finding.u.unwrap() - 5.0 * 2.0_f64.sqrt()).abs() < 1e-6, "{finding:?}");
        assert!((0.0..20.0).contains(&finding.bias), "{finding:?}");
    }
    let distances = deviations(&points, &fitted.nominal, &fitted.pose);
    let places: Vec<[f64; 2]> =
        points.iter().map(|&point| fitted.pose.to_part(point)).map(|[x, y, _]| [x, y]).collect();
    let whole = Sample::new(&places, &distances, None, &Aperture::None).unwrap();
    let left = rms(&remove(&whole, &terms).unwrap().sample, Reference::Zero).unwrap().value;
    assert!((value(9) - left).abs() < 1e-6 && left < 0.9 * value(1), "{} {left}", value(9));
    // Nothing can be accepted as long as anything may hide.
    let blind = held((&limits[0], nominal), &found, Guard::None, None);
    assert_eq!(blind.status, Status::Undecided);
}

/// What part of the points promises of the final figures, over scans that come line by line, with noise on top.
#[test]
fn the_final_figures_never_fall_below_what_was_promised() {
    let (mut points, _, _) = part(1200);
    let mut random = Uniform::new(11);
    points.iter_mut().for_each(|point| point[2] += 2e-5 * random.next());
    points.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let settings =
        FitSettings { free: rigid_and_radius(), start: misaligned(), ..FitSettings::default() };
    let all = fit(&points, &al1815(), &settings).unwrap();
    let pv_nm = (all.residuals.high_mm - all.residuals.low_mm) * 1e6;
    let rms_nm = all.residuals.rms_mm * 1e6;
    let mut promised = 0.0;
    for count in [500, 800, 1100] {
        let so_far = fit(&points[..count], &al1815(), &settings).unwrap();
        let share = count as f64 / 1200.0;
        let least_nm = share.sqrt() * so_far.residuals.rms_mm * 1e6;
        assert!(so_far.indeterminate.is_empty() && least_nm <= rms_nm, "{least_nm} {rms_nm}");
        let free: Vec<_> = so_far.estimates.iter().map(|estimate| estimate.parameter).collect();
        let left =
            least(&points[..count], &so_far.nominal, &so_far.pose, &free, &Terms::NONE).unwrap();
        // What the fit leaves, it leaves.
        let square_nm2 = 1e12 * so_far.residuals.rms_mm.powi(2) * count as f64;
        assert!((left.square_nm2 / square_nm2 - 1.0).abs() < 1e-6, "{left:?} {square_nm2}");

        let zone = ZoneSettings { fit: settings.clone(), ..ZoneSettings::default() };
        let zone = minimum_zone(&points[..count], &al1815(), &zone).unwrap();
        let zone_nm = zone.certificate.lower_mm * 1e6;
        assert!(zone_nm <= pv_nm && zone_nm >= promised, "{zone_nm} {pv_nm}");
        // Never wider than the minimum zone, and near it.
        assert!((0.9..1.0 + 1e-6).contains(&(left.range_nm / zone_nm)), "{left:?} {zone_nm}");
        promised = zone_nm;
    }
    eprintln!("PV {pv_nm:.1} nm, promised {promised:.1} nm");
    assert!(promised > 0.5 * pv_nm);
}

/// Few points stand for many: spread and bias of an RMS and of a coefficient are those of draws of all 50,000.
#[test]
fn averages_of_some_points_are_those_of_all() {
    let (points, _, fitted) = part(50_000);
    let draws = Draws { count: 300, seed: 11 };
    for (sigma_mm, length_mm, long_waves) in [(20e-6, 0.0, false), (20e-6, 6.0, true)] {
        let waves = if long_waves { vec![wave(Kernel::Gaussian, length_mm)] } else { vec![] };
        let budget = Budget { noise: uniform(sigma_mm), long_waves: waves, ..Budget::default() };
        let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
        let rms_nm = |_: &[[f64; 2]], deviations_mm: &[f64]| {
            let square = deviations_mm.iter().map(|d| d * d).sum::<f64>();
            Some((square / deviations_mm.len() as f64).sqrt() * 1e6)
        };
        // The coefficient of a saddle, nearly.
        let saddle_nm = |places_mm: &[[f64; 2]], deviations_mm: &[f64]| {
            let pairs = places_mm.iter().zip(deviations_mm);
            let sum: f64 = pairs.map(|([x, y], d)| d * (x * x - y * y)).sum();
            Some(sum / deviations_mm.len() as f64)
        };
        for (kind, figure) in [
            (Average::OfSquares, &rms_nm as &(dyn Fn(&[[f64; 2]], &[f64]) -> Option<f64> + Sync)),
            (Average::OfHeights, &saddle_nm),
        ] {
            let places_mm = found.places_mm();
            let all = found.simulate(&draws, |d| figure(places_mm, d)).unwrap().unwrap();
            let of_some = |some: &[usize], deviations_mm: &[f64]| {
                let places_mm: Vec<[f64; 2]> = some.iter().map(|&index| places_mm[index]).collect();
                figure(&places_mm, deviations_mm)
            };
            let some = found.simulate_average(&draws, kind, of_some).unwrap().unwrap();
            assert!((some.measured - all.measured).abs() <= 1e-12 * all.measured.abs());
            assert!(some.candidates < 17_000 && all.candidates == 50_000);
            // Either is known to 4 %. Of squares u is that of the figure without noise.
            let alike = match kind {
                Average::OfHeights => all.u,
                Average::OfSquares => {
                    let found = found.simulate_of_squares(&draws, |d| figure(places_mm, d));
                    found.unwrap().unwrap().u
                }
            };
            assert!((some.u / alike - 1.0).abs() < 0.2, "{kind:?}: {} {alike}", some.u);
            let mean_of_all = all.measured + all.bias;
            let square = match kind {
                Average::OfHeights => some.measured + some.bias,
                Average::OfSquares => {
                    let less = (some.measured - some.bias).powi(2);
                    (2.0 * some.measured * some.measured - less).sqrt()
                }
            };
            assert!((square - mean_of_all).abs() < 0.3 * all.u, "{kind:?}: {square} {mean_of_all}");
        }
    }
}

#[test]
fn what_cannot_be_told_is_refused() {
    let (points, _, fitted) = part(300);
    let refused = |points: &[PointMm], fitted: &Fit, budget: &Budget| {
        uncertainty(points, fitted, &Aperture::None, None, budget).unwrap_err()
    };
    let budget = Budget::default();
    let other = refused(&points[1..], &fitted, &budget);
    assert_eq!(other, UncertaintyError::OtherPoints { found: 299, used: 300 });
    let few = FitSettings { free: vec![Parameter::Tz], ..FitSettings::default() };
    let few = fit(&points[..8], &al1815(), &few).unwrap();
    let error = refused(&points[..8], &few, &budget);
    assert_eq!(error, UncertaintyError::TooFewPoints { used: 8, needed: 12 });
    let three = [points[0], points[100], points[200]];
    let fitted_plane = fit(&three, &Nominal::Plane, &FitSettings::default()).unwrap();
    let error = refused(&three, &fitted_plane, &budget);
    assert_eq!(error, UncertaintyError::NoFreedom { used: 3, parameters: 3 });
    let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
    assert!(found.peak_to_valley_nm(&Draws { count: 19, seed: 0 }).is_err());
    let never = found.simulate(&Draws { count: 20, seed: 0 }, |_| None).unwrap();
    assert_eq!(never, None);
}

/// What the deviations alone tell: of independent noise about what the fit says of it; of too few points, and of
/// points that are not those of the fit, nothing.
#[test]
fn type_a_of_noise_weights_and_few_points() {
    let (points, _, fitted) = part(3_000);
    let found = type_a(&points, &fitted, &Aperture::None, None).unwrap();
    assert_eq!((found.patches, found.parameters.len()), (256, 6));
    assert!(found.independence.unwrap().p < 1e-9);
    let chances: f64 = found.kernels.iter().map(|(_, chance)| chance).sum();
    assert!((chances - 1.0).abs() < 1e-12);
    for (index, parameter) in found.parameters.iter().enumerate() {
        let variance = found.covariance.entry(index, index).unwrap();
        assert!((parameter.u / variance.sqrt() - 1.0).abs() < 1e-12);
        let [narrow, wide] = [0.6827, 0.99].map(|p| parameter.expanded(p).expanded);
        assert!(narrow < 1.2 * parameter.u && narrow < wide && wide > 2.0 * parameter.u);
        // Form of several waves is what this part has: far less is known than noise would leave.
        assert!(parameter.u > 1.5 * fitted.estimates[index].u.unwrap(), "{parameter:?}");
    }
    let equal = vec![3e-6; points.len()];
    let settings = FitSettings { free: rigid_and_radius(), ..FitSettings::default() };
    let weighted = fit_weighted(&points, Some(&equal), &al1815(), &settings).unwrap();
    let again = type_a(&points, &weighted, &Aperture::None, Some(&equal)).unwrap();
    for (a, b) in found.parameters.iter().zip(&again.parameters) {
        assert!((a.u / b.u - 1.0).abs() < 1e-6, "{a:?} {b:?}");
    }
    let held = FitSettings { free: vec![], search: false, ..FitSettings::default() };
    let held = fit(&points, &al1815(), &FitSettings { start: fitted.pose, ..held }).unwrap();
    assert!(type_a(&points, &held, &Aperture::None, None).unwrap().parameters.is_empty());

    let other = type_a(&points[1..], &fitted, &Aperture::None, None).unwrap_err();
    assert_eq!(other, UncertaintyError::OtherPoints { found: 2_999, used: 3_000 });
    let few = fit(&points[..12], &al1815(), &FitSettings::default()).unwrap();
    let error = type_a(&points[..12], &few, &Aperture::None, None).unwrap_err();
    assert_eq!(error, UncertaintyError::TooFewPoints { used: 12, needed: 13 });
    // One place measured a hundred times has no wave to see.
    let plane = FitSettings { free: vec![Parameter::Tz], ..FitSettings::default() };
    let same: Vec<PointMm> = (0..100).map(|i| [1.0, 2.0, 1e-5 * f64::from(i * i % 7)]).collect();
    let fitted = fit(&same, &Nominal::Plane, &plane).unwrap();
    let found = type_a(&same, &fitted, &Aperture::None, None).unwrap();
    assert!(found.parameters[0].u.is_finite() && found.parameters[0].u > 0.0);
    // Nothing deviates: nothing is uncertain.
    let exact: Vec<PointMm> =
        (0..100).map(|i| [f64::from(i % 10), f64::from(i / 10), 0.0]).collect();
    let fitted = fit(&exact, &Nominal::Plane, &plane).unwrap();
    let found = type_a(&exact, &fitted, &Aperture::None, None).unwrap();
    assert!(found.parameters[0].expanded(0.95).expanded < 1e-100);
}

/// At a glance roughly the same (found: 0.9 to 2.2 times, the most of the height), of few points and many, whatever the order they come in; and none where there is nothing to
/// see by.
#[test]
fn a_glance_tells_roughly_what_type_a_does() {
    for count in [1_500, 20_000] {
        let (points, _, fitted) = part(count);
        let deviations_mm = deviations(&points, &fitted.nominal, &fitted.pose);
        let found = type_a(&points, &fitted, &Aperture::None, None).unwrap();
        let seen =
            glance(&points, &deviations_mm, &fitted, &Aperture::None, None).unwrap().unwrap();
        assert!((56..=64).contains(&seen.patches), "{}", seen.patches);
        assert!(seen.independence.unwrap().p < 1e-9 && seen.independence.unwrap().ratio > 10.0);
        for (rough, fine) in seen.parameters.iter().zip(&found.parameters) {
            let ratio = rough.u / fine.u;
            eprintln!("{count} points, {}: {ratio:.2}", rough.parameter);
            assert!(rough.parameter == fine.parameter && (0.5..3.0).contains(&ratio), "{ratio}");
        }
        // What does not deviate does not count.
        let mut gaps = deviations_mm.clone();
        gaps.iter_mut().step_by(3).for_each(|deviation| *deviation = f64::NAN);
        let fewer = glance(&points, &gaps, &fitted, &Aperture::None, None).unwrap().unwrap();
        assert!((fewer.parameters[0].u / seen.parameters[0].u - 1.0).abs() < 0.3);
    }
    let (points, _, fitted) = part(3_000);
    let error = glance(&points, &[0.0; 5], &fitted, &Aperture::None, None).unwrap_err();
    assert_eq!(error, UncertaintyError::Lengths { points: 3_000, found: 5 });
    let few = glance(&points[..40], &[1e-6; 40], &fitted, &Aperture::None, None);
    assert_eq!(few, Ok(None));
}

/// Of noise alone the means of patches are taken for correlated as often as the probability says.
#[test]
fn noise_is_independent_as_often_as_it_says() {
    let lattice: Vec<PointMm> =
        (0..2_500).map(|i| [f64::from(i % 50), f64::from(i / 50), 0.0]).collect();
    let small = |seed: u64| {
        let mut noise = Uniform::new(seed);
        let points: Vec<PointMm> = lattice
            .iter()
            .map(|[x, y, _]| [*x, *y, 1e-5 * (noise.next() + noise.next() + noise.next())])
            .collect();
        let fitted = fit(&points, &Nominal::Plane, &FitSettings::default()).unwrap();
        let deviations_mm = deviations(&points, &fitted.nominal, &fitted.pose);
        let seen = glance(&points, &deviations_mm, &fitted, &Aperture::None, None);
        seen.unwrap().unwrap().independence.unwrap().p
    };
    let all: Vec<f64> = (0..600).into_par_iter().map(small).collect();
    for (p, off) in [(0.05, 0.03), (0.5, 0.07)] {
        let share = all.iter().filter(|found| **found < p).count() as f64 / all.len() as f64;
        assert!((share - p).abs() < off, "{share} for {p}");
    }
}
