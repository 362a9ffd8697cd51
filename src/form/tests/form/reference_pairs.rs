//! Reference pairs after Forbes & Minh (Int. J. Metrol. Qual. Eng. 3 (2012) 145) on parts of revolution: form errors from
//! 10 nm to 10 µm, poses to 1 mm and 1°, and what double precision leaves of the known solution.

use std::sync::Arc;

use asphera_form::artefact::Artefact;
use asphera_form::shape::{ConicSection, Projection, QAsphere};
use asphera_form::{Asphere, FitSettings, Nominal, Parameter, PointMm, Pose, deviations, fit};

use crate::common::{al1815, pose_difference, spiral};

/// Shifts of 1 mm, and tilts of 1° together.
const POSE: Pose =
    Pose { tx_mm: 1.0, ty_mm: -1.0, tz_mm: 1.0, rx_rad: 0.0123, ry_rad: -0.0123, rz_rad: 0.0 };

/// A part, its semi-diameter in mm, and the parameters a fit determines.
struct Pair {
    name: &'static str,
    nominal: Nominal,
    radius_mm: f64,
    free: Vec<Parameter>,
    start: Pose,
}

fn pairs() -> Vec<Pair> {
    use Parameter::{Conic, Radius, Rx, Ry, Tx, Ty, Tz};
    let asphere = |radius_mm, conic| Nominal::Asphere(Asphere::new(radius_mm, conic, &[]).unwrap());
    let base = ConicSection::new(17.3729, -0.67609).unwrap();
    // The first terms of Thorlabs ASL5040-UV.
    let bfs = [-0.814837, -0.32311, 0.10591, -0.05058];
    let q = |shape: QAsphere| Nominal::Freeform(Arc::new(shape));
    let bfs = q(QAsphere::bfs(base, 27.0, Projection::ConicNormal, &bfs).unwrap());
    let con = q(QAsphere::con(base, 15.0, &[0.4, -0.08, 0.02]).unwrap());
    let turned = Pose { rx_rad: POSE.rx_rad, ry_rad: POSE.ry_rad, ..Pose::default() };
    let rigid = Parameter::RIGID.to_vec();
    let pair = |name, nominal, radius_mm, free: &[Parameter], start| Pair {
        name,
        nominal,
        radius_mm,
        free: free.to_vec(),
        start,
    };
    let still = Pose::default();
    let of_sphere = [Tx, Ty, Tz, Radius];
    let with_shape = [Tx, Ty, Tz, Rx, Ry, Radius, Conic];
    vec![
        // A turn about the vertex of a sphere is a shift: the turns stay as they were made.
        pair("sphere", Nominal::Sphere { radius_mm: 40.0 }, 12.0, &[Tx, Ty, Tz], turned),
        pair("sphere, radius", Nominal::Sphere { radius_mm: -40.0 }, 12.0, &of_sphere, turned),
        pair("conic", asphere(-35.0, -1.0), 20.0, &rigid, still),
        pair("conic, radius, conic", asphere(20.0, -1.8), 15.0, &with_shape, still),
        pair("even asphere", al1815(), 9.0, &rigid, still),
        pair("even asphere, radius, conic", al1815(), 9.0, &with_shape, still),
        pair("Q-bfs", bfs, 22.0, &rigid, still),
        pair("Q-con", con, 14.0, &rigid, still),
    ]
}

/// Poses come back to 1e-9 mm and 1e-12 rad, residuals to 1e-9 mm.
#[test]
fn parts_of_revolution_give_back_what_they_were_made_from() {
    eprintln!(
        "                              form/mm   shift/mm  turn/rad  residual/mm  shape     condition"
    );
    for Pair { name, nominal, radius_mm, free, start } in pairs() {
        let sample = spiral(4_000, radius_mm);
        for amplitude_mm in [1e-5, 1e-4, 1e-3, 1e-2] {
            let wave = 10.0 / radius_mm;
            let error_mm = move |x: f64, y: f64| {
                amplitude_mm * (1.1 * wave * x + 0.3).sin() * (0.8 * wave * y).cos()
            };
            let artefact = Artefact::new(nominal.clone(), POSE, &free, &sample, error_mm).unwrap();
            let points: Vec<PointMm> =
                sample.iter().map(|&[x, y]| artefact.point_mm(x, y).unwrap()).collect();
            let settings = FitSettings { free: free.clone(), start, ..FitSettings::default() };
            let fitted = fit(&points, &begin(&nominal, &free), &settings).unwrap();
            assert!(fitted.termination.is_converged(), "{name}: {:?}", fitted.termination);
            assert!(fitted.indeterminate.is_empty(), "{name}: {:?}", fitted.undetermined);
            let turns = |pose: &Pose| Pose { tx_mm: 0.0, ty_mm: 0.0, tz_mm: 0.0, ..*pose };
            let shifts = |pose: &Pose| Pose { rx_rad: 0.0, ry_rad: 0.0, rz_rad: 0.0, ..*pose };
            let off_mm = pose_difference(&shifts(&fitted.pose), &shifts(&POSE));
            let off_rad = pose_difference(&turns(&fitted.pose), &turns(&POSE));
            let found = deviations(&points, &fitted.nominal, &fitted.pose);
            let worst_mm = sample.iter().zip(&found).fold(0.0, |worst: f64, (&[x, y], found)| {
                worst.max((found - artefact.deviation_mm(x, y).unwrap()).abs())
            });
            let own = |parameter| {
                let value = |of: &Nominal| parameter_of(of, parameter);
                (value(&fitted.nominal) - value(&nominal)).abs()
            };
            let shape = own(Parameter::Radius).max(own(Parameter::Conic));
            eprintln!(
                "{name:28}  {amplitude_mm:.0e}      {off_mm:.1e}   {off_rad:.1e}   {worst_mm:.1e}      {shape:.1e}   {:.1e}",
                fitted.condition
            );
            assert!(off_mm < 1e-9 && off_rad < 1e-12, "{name}: {off_mm:e} mm, {off_rad:e} rad");
            assert!(worst_mm < 1e-9 && shape < 1e-9, "{name}: {worst_mm:e} mm, {shape:e}");
        }
    }
}

/// The shape a fit begins with: another where it is free.
fn begin(nominal: &Nominal, free: &[Parameter]) -> Nominal {
    let by = |parameter, step: f64| if free.contains(&parameter) { step } else { 0.0 };
    match nominal {
        Nominal::Sphere { radius_mm } => {
            Nominal::Sphere { radius_mm: radius_mm + by(Parameter::Radius, 0.5) }
        }
        Nominal::Asphere(asphere) => Nominal::Asphere(Asphere {
            radius_mm: asphere.radius_mm + by(Parameter::Radius, 0.02),
            conic: asphere.conic + by(Parameter::Conic, 0.03),
            ..*asphere
        }),
        _ => nominal.clone(),
    }
}

fn parameter_of(nominal: &Nominal, parameter: Parameter) -> f64 {
    match parameter {
        Parameter::Conic => nominal.asphere().map_or(0.0, |asphere| asphere.conic),
        _ => nominal.radius_mm().unwrap_or(0.0),
    }
}
