//! Faces of bodies whose blurred values are known in closed form.

use asphera_form::{Aperture, FitSettings, Nominal, Parameter, fit};
use asphera_measure::Part;
use asphera_uncertainty::uncertainty;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;

/// The middle of the ball, in samples: no grid plane goes through it.
const MIDDLE: [f64; 3] = [31.37, 30.81, 31.59];
const BACKGROUND: f64 = 1000.0;
const CONTRAST: f64 = 20_000.0;

/// A ball blurred by a Gaussian, in closed form: the integral of the Gaussian over the ball.
fn blurred_ball(r: f64, radius: f64, sigma: f64) -> f64 {
    let erf = |x: f64| libm::erf(x / (sigma * 2.0_f64.sqrt()));
    let bell = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
    let edge = sigma / (r * (2.0 * std::f64::consts::PI).sqrt());
    0.5 * (erf(radius - r) + erf(radius + r)) - edge * (bell(r - radius) - bell(r + radius))
}

pub(crate) fn normal(random: &mut Pcg64Mcg) -> f64 {
    let uniform = |random: &mut Pcg64Mcg| (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let (a, b) = (1.0 - uniform(random), uniform(random));
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// A ball of `radius` samples on a cubic lattice of `h_mm`.
fn ball(radius: f64, sigma: f64, h_mm: f64, noise: f64, seed: u64) -> Scan {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let size = [64_usize; 3];
    let mut values = Vec::with_capacity(size.iter().product());
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..size[0] {
                let from = [0, 1, 2].map(|i| [x, y, z][i] as f64 - MIDDLE[i]);
                let r = from.iter().map(|side| side * side).sum::<f64>().sqrt();
                let share = blurred_ball(r, radius, sigma);
                let wobble = if noise > 0.0 { noise * normal(&mut random) } else { 0.0 };
                values.push((BACKGROUND + CONTRAST * (share + wobble)) as f32);
            }
        }
    }
    Scan { values, size, lattice: cubic(h_mm) }
}

fn cubic(h_mm: f64) -> Lattice {
    let steps_mm = [[h_mm, 0.0, 0.0], [0.0, h_mm, 0.0], [0.0, 0.0, h_mm]];
    Lattice { origin_mm: [0.0; 3], steps_mm }
}

/// The ball seen from outside: its centre lies below the vertex.
fn cap(radius_mm: f64) -> Part {
    let aperture = Aperture::Circle { radius_mm: 0.6 * radius_mm };
    Part { aperture, ..Part::new(Nominal::Sphere { radius_mm: -radius_mm }) }
}

fn halfway(along: Option<[f64; 3]>) -> Settings {
    let threshold = Threshold::Halfway(BACKGROUND + 0.45 * CONTRAST);
    Settings { threshold, u_threshold: None, along }
}

/// Radius and height of the centre of the sphere through the points of a face.
fn sphere(face: &Face, part: &Part) -> (f64, [f64; 3]) {
    let mut free = Parameter::RIGID.to_vec();
    free.push(Parameter::Radius);
    let settings = FitSettings { free, ..FitSettings::default() };
    let found = fit(&face.points_mm, &part.nominal, &settings).unwrap();
    let radius_mm = found.nominal.radius_mm().unwrap();
    (-radius_mm, found.pose.to_measured([0.0, 0.0, radius_mm]))
}

/// Blur makes the halfway surface of a ball smaller by σ²/R. The face takes that back.
#[test]
fn the_edge_of_a_ball_lies_where_the_ball_ends() {
    let (radius, h_mm) = (18.0, 0.05);
    for (sigma, smoothing) in [(1.0, 0.0), (1.0, 1.0), (1.6, 0.0)] {
        let body = Body::new(ball(radius, sigma, h_mm, 0.0, 0), smoothing);
        let part = cap(radius * h_mm);
        let face = body.face(&part, &halfway(Some([0.0, 0.0, 1.0]))).unwrap();
        let variance = sigma * sigma + smoothing * smoothing;
        let blur_um = 1e3 * h_mm * variance.sqrt();
        assert!((face.figures.blur_um / blur_um - 1.0).abs() < 0.02, "{:?}", face.figures);
        let shift_nm = -1e6 * h_mm * variance / radius;
        let corrected_nm = -face.figures.curvature_correction_nm;
        assert!((corrected_nm / shift_nm - 1.0).abs() < 0.04, "{corrected_nm} {shift_nm}");
        let (found_mm, centre_mm) = sphere(&face, &part);
        let off_nm = 1e6 * (found_mm - radius * h_mm);
        // A polynomial through samples meets an edge blurred by one sample to 0.004 of them only.
        let interpolated_nm = if variance < 1.5 { 0.004 * 1e6 * h_mm } else { 0.0 };
        let allowed_nm = 0.05 * shift_nm.abs() + interpolated_nm;
        // σ²·H is the first term of a series in σ/R: the next is of the order (σ/R)² of it.
        assert!(off_nm.abs() < allowed_nm, "{off_nm} of {shift_nm}");
        for axis in 0..3 {
            let off_nm = 1e6 * (centre_mm[axis] - h_mm * MIDDLE[axis]);
            assert!(off_nm.abs() < allowed_nm, "axis {axis}: {off_nm}");
        }
        let levels = [face.figures.background, face.figures.material];
        assert!((levels[0] - BACKGROUND).abs() < 0.01 * CONTRAST, "{levels:?}");
        assert!((levels[1] - BACKGROUND - CONTRAST).abs() < 0.01 * CONTRAST, "{levels:?}");
    }
}

/// Scatter of many noisy scans against the uncertainty that the budget of one tells.
#[test]
fn noise_scatters_as_much_as_the_budget_says() {
    let (radius, h_mm, scans) = (18.0, 0.05, 24);
    for smoothing in [0.0, 1.0] {
        let mut heights = Vec::new();
        let mut told = 0.0;
        for seed in 0..scans {
            let body = Body::new(ball(radius, 1.0, h_mm, 0.02, seed), smoothing);
            let plain = cap(radius * h_mm);
            let settings = Settings {
                // The levels' own noise is no matter here.
                threshold: Threshold::Stated(BACKGROUND + 0.5 * CONTRAST),
                u_threshold: Some(0.0),
                along: Some([0.0, 0.0, 1.0]),
            };
            let face = body.face(&plain, &settings).unwrap();
            let part = face.part(plain.clone());
            let free = vec![Parameter::Tx, Parameter::Ty, Parameter::Tz];
            let settings = FitSettings { free, ..FitSettings::default() };
            let found = fit(&face.points_mm, &part.nominal, &settings).unwrap();
            heights.push(found.pose.tz_mm);
            let (budget, _) = part.judging.uncertainty.unwrap();
            let known =
                uncertainty(&face.points_mm, &found, &Aperture::None, None, &budget).unwrap();
            told += known.parameters[2].u.powi(2) / scans as f64;
        }
        let mean = heights.iter().sum::<f64>() / scans as f64;
        let scatter = heights.iter().map(|height| (height - mean).powi(2)).sum::<f64>();
        let scatter = (scatter / (scans as f64 - 1.0)).sqrt();
        // 24 scans tell a standard deviation to 15 %.
        let ratio = scatter / told.sqrt();
        assert!((0.55..1.45).contains(&ratio), "smoothing {smoothing}: {ratio}");
    }
}

/// A threshold off by its uncertainty moves the face by what is told.
#[test]
fn a_threshold_moves_the_whole_face() {
    let (radius, h_mm) = (18.0, 0.05);
    let body = Body::new(ball(radius, 1.0, h_mm, 0.0, 0), 1.0);
    let part = cap(radius * h_mm);
    let at = |value: f64| {
        let threshold = Threshold::Stated(value);
        let u_threshold = Some(0.03 * CONTRAST);
        body.face(&part, &Settings { threshold, u_threshold, along: Some([0.0, 0.0, 1.0]) })
            .unwrap()
    };
    let [low, high] = [0.47, 0.53].map(|share| sphere(&at(BACKGROUND + share * CONTRAST), &part).0);
    let told_mm = at(BACKGROUND + 0.5 * CONTRAST).shift_mm();
    let ratio = (low - high) / (2.0 * told_mm);
    assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
}

/// The same points whatever the threads; found from any side that is asked for.
#[test]
fn sides_and_threads() {
    let (radius, h_mm) = (18.0, 0.05);
    let part = cap(radius * h_mm);
    let from = |along, threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let body = Body::new(ball(radius, 1.0, h_mm, 0.02, 7), 1.0);
            body.face(&part, &halfway(Some(along))).unwrap().points_mm
        })
    };
    let up = from([0.0, 0.0, 1.0], 1);
    assert_eq!(up, from([0.0, 0.0, 1.0], 3));
    let side = from([3.0, 0.0, 0.0], 1);
    let least = side.iter().map(|point| point[0]).fold(f64::INFINITY, f64::min);
    assert!(least > h_mm * (MIDDLE[0] + 0.68 * radius), "{least}");
}

#[test]
fn what_is_no_face_is_refused() {
    let (radius, h_mm) = (18.0, 0.05);
    let body = Body::new(ball(radius, 1.0, h_mm, 0.0, 0), 0.0);
    let refused = |part: &Part, settings: &Settings| body.face(part, settings).unwrap_err();
    let part = cap(radius * h_mm);
    let above = Settings { threshold: Threshold::Stated(1e6), ..halfway(None) };
    assert!(matches!(refused(&part, &above), FaceError::NoSurface { .. }));
    // A plane ten times as wide as the ball.
    let aperture = Aperture::Circle { radius_mm: 10.0 };
    let wide = Part { aperture, ..Part::new(Nominal::Plane) };
    assert!(matches!(refused(&wide, &halfway(None)), FaceError::NoFace { .. }));
    // A ball that all but fills the volume has no background around it.
    let near = Body::new(ball(30.0, 1.0, h_mm, 0.0, 0), 0.0);
    let found = near.face(&cap(30.0 * h_mm), &halfway(Some([0.0, 0.0, 1.0])));
    assert!(
        matches!(found, Err(FaceError::TooNear { .. })),
        "{:?}",
        found.map(|face| face.figures)
    );
}

/// Two spheres: the thickness along the line through their centres. Errors of the threshold add up.
#[test]
fn a_ball_is_two_faces() {
    let (radius, h_mm) = (18.0, 0.05);
    let body = Body::new(ball(radius, 1.0, h_mm, 0.02, 4), 1.0);
    let of = |along| {
        let settings = Settings { u_threshold: Some(0.01 * CONTRAST), ..halfway(Some(along)) };
        let face = body.face(&cap(radius * h_mm), &settings).unwrap();
        let part = face.part(cap(radius * h_mm));
        let mut pipeline = asphera_measure::Pipeline::along(part.clone(), face.projection());
        pipeline.take_positions(face.points_mm.iter().copied());
        let report = pipeline.finish().report;
        // Of so few points one on the border of the aperture may go in and out for ever: not with this seed.
        assert!(report.form.as_ref().unwrap().deviation.uncertainty.is_some(), "{report:?}");
        (Lying::in_report(&face, &part.nominal, &report).unwrap(), face)
    };
    let ((first, face), (second, _)) = (of([0.0, 0.0, 1.0]), of([0.0, 0.0, -1.0]));
    let found = between(&first, &second).unwrap();
    let off_um = 1e3 * (found.centre_thickness.value - 2.0 * radius * h_mm);
    let u_um = 1e3 * found.centre_thickness.u.unwrap();
    assert!(off_um.abs() < 3.0 * u_um && off_um.abs() < 1.0, "{off_um} {u_um}");
    // Points of a ball that move out by 1 lift the fit by Σc/Σc², c the cosines: evenly over a disc of 0.6 R by 1.102, and by noise and
    // uneven levels, which are a tenth of it here, u grows by some percent more.
    let by_threshold_um = 2.0 * 1.102 * 1e3 * face.shift_mm();
    assert!((0.98..1.08).contains(&(u_um / by_threshold_um)), "{u_um} {by_threshold_um}");
    assert_eq!(found.along, "common normal of the two faces");
    assert!(found.wedge.is_none() && found.decentre.is_none() && found.unknown.len() == 2);
}
