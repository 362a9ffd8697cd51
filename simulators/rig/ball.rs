//! A whole ball, measured from all sides by a probe that comes along the normal: once round and round from pole to pole.
//!
//! The machine says where it met the part by two transducers and the probe, as everywhere on this bench. They are rounded to
//! their steps, and the noise of the probe is along the normal. The form error is projected on the null space of the centre, and of
//! the radius where it is free, as in [`crate::part`]: the distances from the true sphere are their own least-squares residuals.

use std::f64::consts::{PI, TAU};

use asphera_form::{Aperture, Figures, Nominal, Parameter, PointMm};

use crate::noise::standard_normal;
use crate::plan::{Plan, PlanError};
use crate::truth::{DeviationTruth, FitTruth, FormTruth, PartTruth, Truth};
use crate::{Scene, Stop, Trigger};

/// Computes the scan of a ball. Its scene has a sphere.
pub(crate) fn plan(scene: &Scene) -> Result<Plan, PlanError> {
    let radius_mm = scene.nominal.radius_mm().unwrap_or_default();
    let size_mm = radius_mm.abs();
    let centre_mm = scene.pose.to_measured([0.0, 0.0, radius_mm]);
    let ways = directions(scene.points);
    let errors_mm = form_errors_mm(scene, size_mm, &ways);
    let at = |way: &PointMm, from_centre_mm: f64| -> PointMm {
        std::array::from_fn(|axis| centre_mm[axis] + from_centre_mm * way[axis])
    };
    let (mut triggers, mut measured_mm, mut ideal_mm) = (Vec::new(), Vec::new(), Vec::new());
    for ((k, way), error_mm) in (0..).zip(&ways).zip(&errors_mm) {
        let noise_mm = scene.noise_nm * 1e-6 * standard_normal(scene.seed, k);
        let met_mm = at(way, size_mm + error_mm + noise_mm);
        let step_mm = f64::from(scene.motion.step_nm()) * 1e-6;
        let steps = [met_mm[0], met_mm[1]].map(|mm| (mm / step_mm).round() as i32);
        let distance_um = ((scene.standoff_mm + met_mm[2]) * 1e3) as f32;
        if !(distance_um > 0.0 && f64::from(distance_um) <= scene.full_scale_um) {
            let full_scale_um = scene.full_scale_um;
            return Err(PlanError::Distance { trigger: k, distance_um, full_scale_um });
        }
        triggers.push(Trigger { stop: Stop { rotary_counts: 0, stage_steps: steps }, distance_um });
        let [x_mm, y_mm] = steps.map(|steps| f64::from(steps) * step_mm);
        measured_mm.push([x_mm, y_mm, f64::from(distance_um) / 1e3 - scene.standoff_mm]);
        ideal_mm.push(at(way, size_mm + error_mm));
    }
    let realised_mm: Vec<f64> =
        measured_mm.iter().map(|point| distance_mm(*point, centre_mm) - size_mm).collect();
    let figures = |points: &[PointMm], deviations_mm: &[f64]| {
        Figures::new(points, deviations_mm, &scene.pose, &Aperture::None).map(DeviationTruth::from)
    };
    let deviation = figures(&measured_mm, &realised_mm).ok_or(PlanError::Empty)?;
    let of_part = figures(&ideal_mm, &errors_mm).ok_or(PlanError::Empty)?;
    let truth = Truth {
        scene: scene.name.clone(),
        seed: scene.seed,
        points: scene.points,
        noise_nm: scene.noise_nm,
        form: FormTruth {
            nominal: scene.nominal.to_string(),
            fit: FitTruth::new(&scene.free, &scene.pose, &scene.nominal),
            deviation,
        },
        part: PartTruth { deviation: of_part },
    };
    Ok(Plan::of_parts(triggers, measured_mm, ideal_mm, truth))
}

/// Whether a nominal can be scanned so.
pub(crate) fn is_ball(nominal: &Nominal) -> bool {
    matches!(nominal, Nominal::Sphere { .. })
}

/// Directions along a spiral from the lower pole to the upper one, of turns as far apart as the points along them: equal steps of
/// height hold equal areas.
fn directions(points: u64) -> Vec<PointMm> {
    let pitch = (4.0 * PI / points as f64).sqrt();
    (0..points)
        .map(|k| {
            let z = (2.0 * k as f64 + 1.0) / points as f64 - 1.0;
            let (sin, cos) = (TAU * (PI - z.acos()) / pitch).sin_cos();
            let r = (1.0 - z * z).sqrt();
            [r * cos, r * sin, z]
        })
        .collect()
}

/// Form error along each direction, mm, orthogonal to shifts of the centre, and to the size where that is free.
fn form_errors_mm(scene: &Scene, size_mm: f64, ways: &[PointMm]) -> Vec<f64> {
    let height = |[x, y, z]: &PointMm| {
        // The two halves differ, so that nothing rests on symmetry.
        let side = 0.75 + 0.25 * z;
        1e-6 * side * scene.form_error.height_nm(size_mm * x, size_mm * y)
    };
    let mut errors_mm: Vec<f64> = ways.iter().map(height).collect();
    let mut columns: Vec<Vec<f64>> =
        (0..3).map(|axis| ways.iter().map(|way| way[axis]).collect()).collect();
    if scene.free.contains(&Parameter::Radius) {
        columns.push(vec![1.0; ways.len()]);
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    // Modified Gram and Schmidt; the second pass removes what rounding left of the first.
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        for one in basis.iter().chain(&basis) {
            let share = dot(&column, one);
            column.iter_mut().zip(one).for_each(|(column, one)| *column -= share * one);
        }
        let length = dot(&column, &column).sqrt();
        if length > 1e-9 * (ways.len() as f64).sqrt() {
            basis.push(column.into_iter().map(|value| value / length).collect());
        }
    }
    for one in basis.iter().chain(&basis) {
        let share = dot(&errors_mm, one);
        errors_mm.iter_mut().zip(one).for_each(|(error, one)| *error -= share * one);
    }
    errors_mm
}

fn distance_mm(a: PointMm, b: PointMm) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spiral_is_even_and_goes_from_pole_to_pole() {
        let ways = directions(4000);
        let upper = ways.iter().filter(|way| way[2] > 0.5).count();
        assert_eq!(upper, 1000, "a quarter of the area lies above half the radius");
        let step = (4.0 * PI / 4000.0_f64).sqrt();
        for pair in ways[200..3800].windows(2) {
            let moved = distance_mm(pair[0], pair[1]);
            assert!((moved / step - 1.0).abs() < 0.05, "{moved} {step}");
        }
        assert!(ways[0][2] < -0.999 && ways[3999][2] > 0.999);
    }

    #[test]
    fn the_truth_is_its_own_best_fit_and_the_readings_carry_its_noise() {
        let scene = Scene::built_in("ball").unwrap().with_points(6000);
        let plan = Plan::new(&scene).unwrap();
        let truth = plan.truth();
        let centre = scene.pose.to_measured([0.0, 0.0, scene.nominal.radius_mm().unwrap()]);
        let radius = scene.nominal.radius_mm().unwrap();
        // The gradient of the sum of squares by the centre is nought.
        let mut gradient = [0.0; 3];
        for point in plan.ideal_mm() {
            let far = distance_mm(*point, centre);
            for axis in 0..3 {
                gradient[axis] += (far - radius) * (point[axis] - centre[axis]) / far;
            }
        }
        assert!(gradient.iter().all(|sum| sum.abs() < 1e-9), "{gradient:?}");
        let noise = scene.noise_nm;
        let squares = truth.form.deviation.rms_nm.powi(2) - truth.part.deviation.rms_nm.powi(2);
        assert!((squares.sqrt() / noise - 1.0).abs() < 0.1, "{} {noise}", squares.sqrt());
        assert_eq!(plan.triggers().len(), 6000);
    }
}
