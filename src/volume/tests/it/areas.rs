//! Areas by the blurred boundary: the bodies of the table of the README in many poses, and what is left as the grid grows finer.

use std::f64::consts::PI;

use asphera_volume::{Gaps, Samples, blurred_area, open_area};

use crate::noise::Random;

/// A body by what is inside of it, centred at the origin.
pub(crate) struct Shape {
    name: &'static str,
    is_inside: Box<dyn Fn([f64; 3]) -> bool>,
    reach: f64,
    area: f64,
    volume: f64,
}

fn sphere(r: f64) -> Shape {
    Shape {
        name: "sphere",
        is_inside: Box::new(move |p| p.iter().map(|x| x * x).sum::<f64>() < r * r),
        reach: r,
        area: 4.0 * PI * r * r,
        volume: 4.0 / 3.0 * PI * r.powi(3),
    }
}

fn torus(ring: f64, tube: f64) -> Shape {
    Shape {
        name: "torus",
        is_inside: Box::new(move |p| (p[0].hypot(p[1]) - ring).hypot(p[2]) < tube),
        reach: ring + tube,
        area: 4.0 * PI * PI * ring * tube,
        volume: 2.0 * PI * PI * ring * tube * tube,
    }
}

fn ellipsoid(axes: [f64; 3]) -> Shape {
    // By the midpoint rule on the sphere, which converges with every order for it is periodic in one angle and smooth in the other.
    let steps = 2000;
    let mut area = 0.0;
    for i in 0..steps {
        let z = -1.0 + (2.0 * f64::from(i) + 1.0) / f64::from(steps);
        for j in 0..400 {
            let (s, c) = (2.0 * PI * f64::from(j) / 400.0).sin_cos();
            let w = (1.0 - z * z).sqrt();
            let n = [w * c / axes[0], w * s / axes[1], z / axes[2]];
            area += n.iter().map(|x| x * x).sum::<f64>().sqrt();
        }
    }
    area *= axes.iter().product::<f64>() * 4.0 * PI / (400.0 * f64::from(steps));
    Shape {
        name: "ellipsoid",
        is_inside: Box::new(move |p| {
            p.iter().zip(axes).map(|(x, a)| (x / a).powi(2)).sum::<f64>() < 1.0
        }),
        reach: axes.iter().copied().fold(0.0, f64::max),
        area,
        volume: 4.0 / 3.0 * PI * axes.iter().product::<f64>(),
    }
}

fn cube(side: f64) -> Shape {
    Shape {
        name: "cube",
        is_inside: Box::new(move |p| p.iter().all(|x| x.abs() < side / 2.0)),
        reach: side * 0.75_f64.sqrt(),
        area: 6.0 * side * side,
        volume: side.powi(3),
    }
}

fn cylinder(radius: f64, height: f64) -> Shape {
    Shape {
        name: "cylinder",
        is_inside: Box::new(move |p| p[0].hypot(p[1]) < radius && p[2].abs() < height / 2.0),
        reach: radius.hypot(height / 2.0),
        area: 2.0 * PI * radius * (radius + height),
        volume: PI * radius * radius * height,
    }
}

impl Shape {
    fn has_edges(&self) -> bool {
        ["cube", "cylinder"].contains(&self.name)
    }

    fn digitized(&self, h: f64, random: &mut Random) -> Samples {
        let half = (self.reach / h).ceil() + 1.0;
        let turn = random.rotation();
        let shift: [f64; 3] = std::array::from_fn(|_| random.between(-0.5, 0.5));
        Samples::from_fn([2 * half as usize + 1; 3], |x, y, z| {
            let place = [x, y, z];
            let from: [f64; 3] =
                std::array::from_fn(|axis| (place[axis] as f64 - half + shift[axis]) * h);
            (self.is_inside)(turn.map(|row| row.iter().zip(from).map(|(a, b)| a * b).sum()))
        })
        .unwrap()
    }
}

/// Poses of each body; 20 with `ASPHERA_LONG`.
fn poses() -> usize {
    if std::env::var_os("ASPHERA_LONG").is_some() { 20 } else { 2 }
}

/// Spheres, tori, an ellipsoid and a cube in random poses: the largest error of each is below 0.5 %, where a figure of 0.8 % is asked for
/// (0.3 % is aimed at, and met by all but a cube). Integral invariants of DGtal 2.2 err by 0.3 to 2.3 % on the same.
#[test]
fn areas_in_any_pose_are_within_half_a_percent() {
    let bodies = [
        sphere(10.0),
        sphere(20.0),
        sphere(30.0),
        torus(30.0, 10.0),
        torus(20.0, 5.0),
        ellipsoid([15.0, 30.0, 45.0]),
        cube(40.0),
    ];
    for body in bodies {
        let mut random = Random::new(31);
        let mut worst = 0.0_f64;
        for _ in 0..poses() {
            let found = blurred_area(&body.digitized(1.0, &mut random));
            let error = found.area / body.area - 1.0;
            worst = worst.max(error.abs());
            assert_eq!(found.has_edges, body.name == "cube", "{} {found:?}", body.name);
            assert!(error.abs() < 0.005, "{} {}: {error}", body.name, body.area);
        }
        eprintln!("{} of {:.0}: {:.3} %", body.name, body.area, 100.0 * worst);
    }
}

/// Bodies along the axes, whose faces have long steps, are no bodies with edges.
#[test]
fn large_smooth_bodies_have_no_edges() {
    for body in [ellipsoid([30.0, 60.0, 100.0]), sphere(50.0)] {
        let half = body.reach + 2.0;
        let samples = Samples::from_fn([2 * half as usize + 1; 3], |x, y, z| {
            (body.is_inside)([x, y, z].map(|at| at as f64 - half))
        })
        .unwrap();
        let found = blurred_area(&samples);
        assert!(!found.has_edges, "{} {found:?}", body.name);
        assert!(
            (found.area / body.area - 1.0).abs() < 0.001,
            "{} {found:?} {}",
            body.name,
            body.area
        );
    }
}

/// Bodies of few spacings: the errors are what is stated, their RMS over u, 2 u in 95 %, 3 u in a dozen poses; no ball or ellipsoid is taken for
/// one with edges. Pins and discs have short edges beside much curvature.
///
/// How many samples fall on a body is chance: 81 on a ball of 2.5 about a sample, as many as on a ball of 2.68, whose area is 15 % larger. So the
/// largest error is that against the same body with as much volume as was counted. Spacings differ by up to an eighth: the count of a ball whose
/// radius is a whole number of them scatters up to 1.2 times as much as that of others.
#[test]
fn uncertainties_of_small_bodies_hold_their_errors() {
    let poses = if std::env::var_os("ASPHERA_LONG").is_some() { 200 } else { 12 };
    for body in [
        sphere(2.5),
        sphere(4.0),
        sphere(10.0),
        ellipsoid([2.5, 3.75, 5.0]),
        ellipsoid([3.0, 4.0, 5.0]),
        ellipsoid([4.0, 6.0, 8.0]),
        torus(10.0, 2.5),
        torus(20.0, 5.0),
        cube(5.0),
        cube(8.0),
        cube(12.0),
        cube(20.0),
        cylinder(4.0, 24.0),
        cylinder(6.0, 24.0),
        cylinder(5.0, 30.0),
        cylinder(6.0, 12.0),
        cylinder(12.0, 8.0),
        cylinder(10.0, 32.0),
        cylinder(15.0, 30.0),
    ] {
        let mut random = Random::new(33);
        let (mut beyond, mut over_u, mut squares) = (0, 0.0, 0.0);
        let (mut worst, mut worst_of_counted) = (0.0_f64, 0.0_f64);
        for pose in 0..poses {
            let spacing = random.between(0.875, 1.0);
            let samples = body.digitized(spacing, &mut random);
            let found = blurred_area(&samples);
            let area = body.area / (spacing * spacing);
            let volume = body.volume / spacing.powi(3);
            let counted = area * (samples.foreground() as f64 / volume).powf(2.0 / 3.0);
            worst_of_counted = worst_of_counted.max((found.area / counted - 1.0).abs());
            let error = (found.area - area).abs();
            over_u += (error / found.u).powi(2);
            assert!(!found.has_edges || body.has_edges(), "{} {found:?}", body.name);
            beyond += usize::from(error > 2.0 * found.u);
            squares += (error / area).powi(2);
            // Of as many poses as are tried without `ASPHERA_LONG`.
            if pose < 12 {
                assert!(error < 3.0 * found.u, "{} {:.1}: {found:?}", body.name, body.area);
                worst = worst.max(error / area);
            }
        }
        let [rms, over_u] = [squares, over_u].map(|sum| (sum / poses as f64).sqrt());
        eprintln!(
            "{} of {:.0}: {:.2} %, of the counted {:.2} %, RMS {:.2} %, over u {:.2}, {beyond} beyond 2 u",
            body.name,
            body.area,
            100.0 * worst,
            100.0 * worst_of_counted,
            100.0 * rms,
            over_u
        );
        assert!(rms < 0.035 || body.name == "cube", "{}: {rms}", body.name);
        let most = 1.0 + 1.5 / (poses as f64).sqrt();
        assert!(over_u < most || body.name == "cube", "{} {:.1}: {over_u}", body.name, body.area);
        assert!(20 * beyond <= poses + 8, "{} {:.1}: {beyond}", body.name, body.area);
        assert!(worst < 0.11 || body.name == "cube", "{}: {worst}", body.name);
    }
}

/// Flat faces at small angles to the grid, across the whole volume: steps of the grid add to their area what blur does not take off.
#[test]
fn uncertainties_of_flat_faces_hold_steps_of_the_grid() {
    let mut random = Random::new(36);
    let side = 64;
    for degrees in 0..=20 {
        let slope = f64::from(degrees).to_radians().tan();
        let (sine, cosine) = random.between(0.0, 2.0 * PI).sin_cos();
        let middle = (side as f64 - 1.0) / 2.0;
        let height = middle + random.between(-0.5, 0.5);
        let samples = Samples::from_fn([side; 3], |x, y, z| {
            let [x, y] = [x, y].map(|at| at as f64 - middle);
            z as f64 <= height + slope * (cosine * x + sine * y)
        })
        .unwrap();
        let gaps = Gaps { missing: None, at_border: true };
        let open = open_area(&samples, gaps);
        let truth = (side as f64 - 1.0).powi(2) * slope.hypot(1.0);
        let error = open.area - truth;
        eprintln!("{degrees}°: {:.3} %, u {:.3} %", 100.0 * error / truth, 100.0 * open.u / truth);
        assert!(error.abs() < 3.0 * open.u, "{degrees}: {open:?} {truth}");
    }
}

/// A ball that the border cuts in half: its flat face has a rim, which is no edge of the part.
#[test]
fn the_rim_at_the_border_is_no_edge() {
    let mut random = Random::new(34);
    for radius in [12.0, 24.0] {
        let place = [0, 1, 2].map(|_| random.between(-0.5, 0.5) + radius + 3.0);
        let side = (2.0 * radius) as usize + 8;
        let samples = Samples::from_fn([side, side, place[2] as usize + 1], |x, y, z| {
            let from: [f64; 3] = std::array::from_fn(|axis| [x, y, z][axis] as f64 - place[axis]);
            from.iter().map(|x| x * x).sum::<f64>() < radius * radius
        })
        .unwrap();
        // The zone up to half a spacing beyond the last slice, and the flat face there.
        let height = place[2].floor() + 0.5 - place[2];
        let flat = PI * (radius * radius - height * height);
        let truth = 2.0 * PI * radius * (radius + height) + flat;
        let found = blurred_area(&samples);
        assert!(!found.has_edges, "{found:?}");
        assert!((found.area - truth).abs() < 2.0 * found.u, "{found:?} {truth}");
        assert!((found.area / truth - 1.0).abs() < 0.012, "{found:?} {truth}");
    }
}

/// The order of convergence: the slope of the line through the logarithms of the root mean square errors over poses.
fn order(errors: &[f64]) -> f64 {
    let middle = (errors.len() - 1) as f64 / 2.0;
    let from_middle = |at: usize| at as f64 - middle;
    let slope: f64 =
        errors.iter().enumerate().map(|(at, error)| -from_middle(at) * error.log2()).sum();
    slope / (0..errors.len()).map(|at| from_middle(at).powi(2)).sum::<f64>()
}

/// The root mean square error over poses falls by the order 1.5 at least as the spacing is halved four times, from a radius of 5 spacings,
/// and from one of 2.5, where the theorems ask for 1.73. Twice without `ASPHERA_LONG`, from 2.5.
#[test]
fn areas_and_volumes_converge() {
    let is_long = std::env::var_os("ASPHERA_LONG").is_some();
    let (halvings, firsts) = if is_long { (4, vec![0.4, 0.2]) } else { (2, vec![0.4]) };
    for body in [sphere(1.0), torus(2.0, 1.0), torus(4.0, 1.0), ellipsoid([1.0, 1.5, 2.0])] {
        // From 5 spacings on the wide torus would end with 5·10⁸ samples a pose.
        let is_wide = body.reach > 4.0;
        for &first in firsts.iter().filter(|first| !is_wide || **first > 0.3) {
            let (mut areas, mut volumes) = (Vec::new(), Vec::new());
            for halved in 0..=halvings {
                let h = first / f64::from(1 << halved);
                let mut random = Random::new(32);
                let poses = if is_long { [24, 24, 12, 6, 3][halved] } else { 8 };
                let (mut of_area, mut of_volume) = (0.0, 0.0);
                for _ in 0..poses {
                    let samples = body.digitized(h, &mut random);
                    let area = blurred_area(&samples).area * h * h;
                    of_area += (area / body.area - 1.0).powi(2);
                    let volume = samples.foreground() as f64 * h.powi(3);
                    of_volume += (volume / body.volume - 1.0).powi(2);
                }
                areas.push((of_area / f64::from(poses)).sqrt());
                volumes.push((of_volume / f64::from(poses)).sqrt());
            }
            for (what, errors) in [("area", areas), ("volume", volumes)] {
                let percent: Vec<String> =
                    errors.iter().map(|e| format!("{:.4}", 100.0 * e)).collect();
                let order = order(&errors);
                eprintln!(
                    "{what} {} of {} from {first}: {} %, order {order:.2}",
                    body.name,
                    body.reach,
                    percent.join(", ")
                );
                assert!(order > 1.5, "{what} {} {errors:?}", body.name);
            }
        }
    }
}
