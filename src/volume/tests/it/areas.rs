//! Areas by the blurred boundary: the bodies of the table of the README in many poses, and what is left as the grid grows finer.

use std::f64::consts::PI;

use asphera_volume::{Samples, blurred_area};

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

impl Shape {
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

/// The root mean square error over poses falls by the order 1.5 at least as the spacing is halved four times. At first a sphere or tube
/// has a radius of 2.5 spacings; the theorems ask for 1.73. Twice without `ASPHERA_LONG`.
#[test]
fn areas_and_volumes_converge() {
    let halvings = if std::env::var_os("ASPHERA_LONG").is_some() { 4 } else { 2 };
    for body in [sphere(1.0), torus(2.0, 1.0), torus(4.0, 1.0), ellipsoid([1.0, 1.5, 2.0])] {
        let (mut areas, mut volumes) = (Vec::new(), Vec::new());
        for halved in 0..=halvings {
            let h = 0.4 / f64::from(1 << halved);
            let mut random = Random::new(32);
            let poses = if halved < 3 { 8 } else { 2 };
            let (mut of_area, mut of_volume) = (0.0, 0.0);
            for _ in 0..poses {
                let samples = body.digitized(h, &mut random);
                of_area += (blurred_area(&samples).area * h * h / body.area - 1.0).powi(2);
                let volume = samples.foreground() as f64 * h.powi(3);
                of_volume += (volume / body.volume - 1.0).powi(2);
            }
            areas.push((of_area / f64::from(poses)).sqrt());
            volumes.push((of_volume / f64::from(poses)).sqrt());
        }
        for (what, errors) in [("area", areas), ("volume", volumes)] {
            let percent: Vec<String> = errors.iter().map(|e| format!("{:.4}", 100.0 * e)).collect();
            let order = (errors[0] / errors[halvings]).log2() / halvings as f64;
            eprintln!(
                "{} {} of {}: {} %, order {order:.2}",
                what,
                body.name,
                body.reach,
                percent.join(", ")
            );
            assert!(order > 1.5, "{what} {} {errors:?}", body.name);
        }
    }
}
