//! Minimum zones with a known answer: constructed vertex solutions and flatness by hand.
//!
//! Forbes & Minh, Int. J. Metrol. Qual. Eng. 3 (2012) 145: choose the solution and as many contacts as there
//! are unknowns and one more; the multipliers span the null space of their derivatives, and the signs of
//! these say on which border each contact lies. All other points lie inside.

use asphera_form::{
    Asphere, Criterion, FitSettings, Nominal, Parameter, PointMm, Pose, Side, ZoneFit,
    ZoneSettings, minimum_zone,
};
use nalgebra::DMatrix;

use crate::common::{Noise, al1815, misaligned, pose_difference, spiral};

fn changed(parameter: Parameter, step: f64, pose: &Pose, nominal: &Nominal) -> (Pose, Nominal) {
    let (mut pose, mut nominal) = (*pose, nominal.clone());
    match (parameter, &mut nominal) {
        (Parameter::Tx, _) => pose.tx_mm += step,
        (Parameter::Ty, _) => pose.ty_mm += step,
        (Parameter::Tz, _) => pose.tz_mm += step,
        (Parameter::Rx, _) => pose.rx_rad += step,
        (Parameter::Ry, _) => pose.ry_rad += step,
        (Parameter::Rz, _) => pose.rz_rad += step,
        (Parameter::Radius, Nominal::Sphere { radius_mm }) => *radius_mm += step,
        (Parameter::Radius, Nominal::Asphere(asphere)) => asphere.radius_mm += step,
        (Parameter::Conic, Nominal::Asphere(asphere)) => asphere.conic += step,
        (Parameter::A(order), Nominal::Asphere(asphere)) => {
            asphere.coefficients[usize::from(order - 4) / 2] += step;
        }
        (parameter, nominal) => unreachable!("{parameter} of {nominal}"),
    }
    (pose, nominal)
}

/// ∂d/∂parameter by central differences: the multipliers need only their signs right.
fn derivative(parameter: Parameter, point: PointMm, pose: &Pose, nominal: &Nominal) -> f64 {
    let h = match parameter {
        Parameter::A(order) => 1e-3 * 9.0_f64.powi(-i32::from(order)),
        _ => 1e-4,
    };
    let distance = |step: f64| {
        let (pose, nominal) = changed(parameter, step, pose, nominal);
        nominal.foot(pose.to_part(point)).unwrap().distance_mm
    };
    (distance(h) - distance(-h)) / (2.0 * h)
}

/// A part whose minimum zone is known.
struct Vertex {
    nominal: Nominal,
    pose: Pose,
    half_mm: f64,
    points: Vec<PointMm>,
    multipliers: Vec<f64>,
}

impl Vertex {
    /// `unknowns` are the parameters the points determine, `offset` whether an offset is one besides. The
    /// contacts come first.
    fn new(
        nominal: Nominal,
        pose: Pose,
        unknowns: &[Parameter],
        offset: bool,
        half_mm: f64,
        seed: u64,
    ) -> Vertex {
        let mut noise = Noise::new(seed);
        let size = unknowns.len() + usize::from(offset);
        loop {
            let places: Vec<[f64; 2]> = (0..=size)
                .map(|_| {
                    let (r, phi) = (8.5 * noise.next().abs().sqrt(), 3.2 * noise.next());
                    [r * phi.cos(), r * phi.sin()]
                })
                .collect();
            let mut matrix = DMatrix::zeros(size + 1, size + 1);
            for (j, &place) in places.iter().enumerate() {
                let point = pose.to_measured(over(&nominal, place, 0.0));
                for (i, &parameter) in unknowns.iter().enumerate() {
                    matrix[(i, j)] = derivative(parameter, point, &pose, &nominal);
                }
                if offset {
                    matrix[(size - 1, j)] = -1.0;
                }
            }
            for mut row in matrix.row_iter_mut().take(size) {
                row /= row.amax();
            }
            let svd = matrix.svd(false, true);
            let least = (0..=size)
                .min_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]));
            let null: Vec<f64> = svd.v_t.unwrap().row(least.unwrap()).iter().copied().collect();
            let all: f64 = null.iter().map(|entry| entry.abs()).sum();
            // A contact that hardly holds anything would leave the answer badly conditioned.
            if null.iter().any(|entry| entry.abs() < 0.02 * all) {
                continue;
            }
            let contact = |(&place, entry): (&[f64; 2], &f64)| {
                pose.to_measured(over(&nominal, place, half_mm * entry.signum()))
            };
            let mut points: Vec<PointMm> = places.iter().zip(&null).map(contact).collect();
            points.extend(
                spiral(4_000, 9.0)
                    .into_iter()
                    .map(|place| over(&nominal, place, 0.8 * half_mm * noise.next()))
                    .map(|part_mm| pose.to_measured(part_mm)),
            );
            let multipliers = null.iter().map(|entry| entry / all).collect();
            return Vertex { nominal, pose, half_mm, points, multipliers };
        }
    }

    /// Largest shares by which the zone, the pose and the multipliers are off.
    fn check(&self, name: &str, begin: &Nominal, settings: &ZoneSettings) -> ZoneFit {
        let found = minimum_zone(&self.points, begin, settings).unwrap();
        assert!(found.termination.is_settled(), "{name}: {found:?}");
        let zone = found.zone_mm / (2.0 * self.half_mm) - 1.0;
        let pose = pose_difference(&found.pose, &self.pose);
        assert_eq!(found.contacts.len(), self.multipliers.len(), "{name}: {:?}", found.contacts);
        let mut share: f64 = 0.0;
        for (contact, expected) in found.contacts.iter().zip(&self.multipliers) {
            let sign = if contact.side == Side::High { 1.0 } else { -1.0 };
            // A null vector has no sign of its own: the half width may lie on either side.
            share = share.max((contact.multiplier - expected.abs()).abs());
            assert_eq!(sign, expected.signum(), "{name}: {contact:?}");
        }
        let indices: Vec<usize> = found.contacts.iter().map(|contact| contact.index).collect();
        assert_eq!(indices, (0..self.multipliers.len()).collect::<Vec<_>>(), "{name}");
        eprintln!(
            "{name}: zone {:.1} nm off by a share of {zone:.0e}, pose by {pose:.0e}, multipliers by \
             {share:.0e}; gap {:.0e} mm, stationarity {:.0e}, {} passes",
            found.zone_mm * 1e6,
            found.certificate.gap_mm,
            found.certificate.stationarity,
            found.certificate.scans,
        );
        let rounding = 2e-14 / self.half_mm;
        assert!(zone.abs() < 1e-9 + rounding, "{name}: {zone:e}");
        assert!(share < 1e-5, "{name}: {share:e}");
        assert_eq!(found.certificate.scanned, self.points.len());
        let narrower = found.zone_mm
            <= range(&self.points, &found.least_squares.nominal, &found.least_squares.pose);
        assert!(narrower || settings.criterion == Criterion::Centred);
        found
    }
}

fn range(points: &[PointMm], nominal: &Nominal, pose: &Pose) -> f64 {
    let found = asphera_form::deviations(points, nominal, pose);
    let high = found.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    high - found.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The point of the part frame at a distance from the place (x, y) of the nominal.
fn over(nominal: &Nominal, [x, y]: [f64; 2], distance_mm: f64) -> PointMm {
    let [gx, gy] = nominal.gradient(x, y);
    let n_z = (1.0 + gx * gx + gy * gy).sqrt().recip();
    [
        x - gx * n_z * distance_mm,
        y - gy * n_z * distance_mm,
        nominal.sag_mm(x.hypot(y)) + n_z * distance_mm,
    ]
}

fn settings(free: &[Parameter], criterion: Criterion) -> ZoneSettings {
    let fit = FitSettings { free: free.to_vec(), ..FitSettings::default() };
    ZoneSettings { fit, criterion, ..ZoneSettings::default() }
}

const PLANE: [Parameter; 3] = [Parameter::Tz, Parameter::Rx, Parameter::Ry];
const CENTRE: [Parameter; 3] = [Parameter::Tx, Parameter::Ty, Parameter::Tz];

#[test]
fn planes() {
    let pose = Pose { tz_mm: 7.0, rx_rad: 0.3, ry_rad: -0.2, ..Pose::default() };
    for (seed, half_mm) in [(1, 1e-5), (2, 1e-4), (3, 1e-2), (4, 0.5)] {
        let vertex = Vertex::new(Nominal::Plane, pose, &PLANE, false, half_mm, seed);
        for criterion in [Criterion::Range, Criterion::Centred] {
            let wanted = settings(&Parameter::RIGID, criterion);
            let found = vertex.check("plane", &Nominal::Plane, &wanted);
            assert!(pose_difference(&found.pose, &pose) < 1e-9 * half_mm + 1e-14);
            assert!(found.offset_mm.abs() < 1e-9 * half_mm + 1e-14);
            assert_eq!(found.indeterminate, [Parameter::Tx, Parameter::Ty]);
        }
    }
}

#[test]
fn spheres() {
    let pose = Pose { tx_mm: 31.0, ty_mm: -22.0, tz_mm: 9.5, ..Pose::default() };
    for (seed, radius_mm, half_mm) in [(5, 14.0, 1e-4), (6, -14.0, 1e-4), (7, 25.0, 1e-3)] {
        let sphere = Nominal::Sphere { radius_mm };
        let vertex = Vertex::new(sphere.clone(), pose, &CENTRE, true, half_mm, seed);
        let wanted = settings(&Parameter::RIGID, Criterion::Range);
        let found = vertex.check("sphere, rigid", &sphere, &wanted);
        assert!(pose_difference(&found.pose, &pose) < 1e-7 * half_mm + 1e-12);
        assert!(found.offset_mm.abs() < 1e-7 * half_mm + 1e-12, "{:e}", found.offset_mm);

        let with_radius: Vec<Parameter> = CENTRE.into_iter().chain([Parameter::Radius]).collect();
        let vertex = Vertex::new(sphere.clone(), pose, &with_radius, false, half_mm, seed);
        let begin = Nominal::Sphere { radius_mm: radius_mm * 1.01 };
        let wanted = settings(&with_radius, Criterion::Range);
        let found = vertex.check("sphere with its radius", &begin, &wanted);
        assert!((found.nominal.radius_mm().unwrap() - radius_mm).abs() < 1e-7 * half_mm + 1e-12);
    }
}

#[test]
fn conics() {
    for (seed, conic) in [(8, -1.0), (9, -2.5), (10, 0.4)] {
        let nominal = Nominal::Asphere(Asphere::new(20.0, conic, &[]).unwrap());
        let vertex =
            Vertex::new(nominal.clone(), misaligned(), &Parameter::RIGID, true, 1e-4, seed);
        let wanted = settings(&Parameter::RIGID, Criterion::Range);
        let found = vertex.check("conic, rigid", &nominal, &wanted);
        assert!(pose_difference(&found.pose, &misaligned()) < 1e-9);

        let free: Vec<Parameter> =
            Parameter::RIGID.into_iter().chain([Parameter::Radius, Parameter::Conic]).collect();
        let vertex = Vertex::new(nominal, misaligned(), &free, false, 1e-4, seed);
        let begin = Nominal::Asphere(Asphere::new(20.05, conic + 0.02, &[]).unwrap());
        let found = vertex.check("conic", &begin, &settings(&free, Criterion::Centred));
        let shape = found.nominal.asphere().unwrap();
        assert!((shape.radius_mm - 20.0).abs() < 1e-8 && (shape.conic - conic).abs() < 1e-7);
    }
}

#[test]
fn even_aspheres() {
    for (seed, half_mm) in [(11, 1e-5), (12, 1e-4), (13, 1e-3)] {
        let vertex = Vertex::new(al1815(), misaligned(), &Parameter::RIGID, true, half_mm, seed);
        let wanted = settings(&Parameter::RIGID, Criterion::Range);
        let found = vertex.check("asphere", &al1815(), &wanted);
        assert!(pose_difference(&found.pose, &misaligned()) < 1e-8 * half_mm + 1e-12);

        let vertex = Vertex::new(al1815(), misaligned(), &Parameter::RIGID, false, half_mm, seed);
        let wanted = settings(&Parameter::RIGID, Criterion::Centred);
        let found = vertex.check("asphere, centred", &al1815(), &wanted);
        assert!(pose_difference(&found.pose, &misaligned()) < 1e-8 * half_mm + 1e-12);
        assert_eq!(found.offset_mm, 0.0);

        let shape = [Parameter::Radius, Parameter::A(4), Parameter::A(6)];
        let free: Vec<Parameter> = Parameter::RIGID.into_iter().chain(shape).collect();
        let vertex = Vertex::new(al1815(), misaligned(), &free, false, half_mm, seed);
        let wanted = settings(&free, Criterion::Centred);
        let found = vertex.check("asphere with shape", &al1815(), &wanted);
        let (a, b) = (found.nominal.asphere().unwrap(), vertex.nominal.asphere().unwrap());
        assert!((a.radius_mm - b.radius_mm).abs() < 1e-5 * half_mm + 1e-10, "{a:?}");
    }
}

/// The two figures every flatness zone has: three points of one border over one of the other within their
/// triangle (3-1), or the lines through two and two crossing (2-2).
#[test]
fn flatness_by_hand() {
    let plane = |points: &[PointMm]| {
        minimum_zone(points, &Nominal::Plane, &ZoneSettings::default()).unwrap()
    };
    let three_one =
        [[0., 0., 1.], [9., 0., 1.], [0., 9., 1.], [3., 3., 0.], [1., 2., 0.3], [4., 1., 0.9]];
    let found = plane(&three_one);
    assert!((found.zone_mm - 1.0).abs() < 1e-14, "{found:?}");
    let thirds: Vec<f64> = found.contacts.iter().map(|contact| contact.multiplier).collect();
    for (found, expected) in thirds.iter().zip([1. / 6., 1. / 6., 1. / 6., 0.5]) {
        assert!((found - expected).abs() < 1e-13, "{thirds:?}");
    }
    assert!(found.zone_mm < range(&three_one, &Nominal::Plane, &found.least_squares.pose));

    let two_two = [[2., 2., 3.], [-2., -2., 3.], [2., -2., 1.], [-2., 2., 1.], [1., 0., 1.5]];
    let found = plane(&two_two);
    assert!((found.zone_mm - 2.0).abs() < 1e-14, "{found:?}");
    assert!((found.pose.tz_mm - 2.0).abs() < 1e-14);
    assert!(found.contacts.iter().all(|contact| (contact.multiplier - 0.25).abs() < 1e-13));

    // A slope of 1: the zone is orthogonal, so √2 narrower than upright.
    let tilted: Vec<PointMm> = three_one.iter().map(|&[x, y, z]| [x, y, z + x]).collect();
    let found = plane(&tilted);
    assert!((found.zone_mm - 0.5_f64.sqrt()).abs() < 1e-14, "{found:?}");
}
