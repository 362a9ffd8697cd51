//! Defects that were put on known surfaces, and surfaces without any.

use super::*;
use crate::curvature::Adjacency;
use crate::curvature::truth::*;

/// 142² points, 2.8 mm wide.
const PITCH_MM: f64 = 0.02;
const SIDE: usize = 142;

fn part(surface: fn(f64, f64) -> Truth, sigma_mm: f64, seed: u64) -> Vec<PointMm> {
    let mut points = over(&raster([0.3, -0.2], SIDE, PITCH_MM, 0.3, seed), surface);
    roughen(&mut points, sigma_mm, 1000 + seed);
    points
}

fn found_with(points: &[PointMm], reach_mm: f64, settings: &DefectSettings) -> Defects {
    let triangles = triangles(points);
    let adjacency = Adjacency::new(points, &triangles, Some(reach_mm)).unwrap();
    let samples =
        Samples { points, triangles: &triangles, adjacency: &adjacency, deviations_mm: None };
    find_defects(&samples, settings).unwrap()
}

fn found(points: &[PointMm]) -> Defects {
    found_with(points, 3.0 * PITCH_MM, &DefectSettings::default())
}

/// Adds a height that depends on the place.
fn add(points: &mut [PointMm], height_mm: impl Fn(f64, f64) -> f64) {
    points.iter_mut().for_each(|point| point[2] += height_mm(point[0], point[1]));
}

/// A Gaussian hill of a full width at half maximum, and the area of that width.
fn hill(centre: [f64; 2], height_mm: f64, width_mm: f64) -> impl Fn(f64, f64) -> f64 {
    let scale = 4.0 * 2.0_f64.ln() / (width_mm * width_mm);
    move |x, y| {
        height_mm * (-scale * ((x - centre[0]).powi(2) + (y - centre[1]).powi(2))).exp()
    }
}

/// 20 surfaces of 20,164 points, by the default setting 0.1 false defects each at most: 2 in all are
/// expected at most, and more than 6 come by chance once in 200 times if the bound were reached.
#[test]
fn clean_surfaces_have_no_defects() {
    let mut total = 0;
    for seed in 0..20 {
        let surface = [asphere, freeform, sphere, cylinder][seed as usize % 4];
        let sigma_mm = [5e-6, 1e-5, 2e-5][seed as usize % 3];
        let defects = found(&part(surface, sigma_mm, seed));
        assert_eq!(defects.unreferenced, 0);
        assert!((defects.sigma_mm / sigma_mm - 1.0).abs() < 0.06, "{seed}: {}", defects.sigma_mm);
        eprintln!("{seed}: {} {:.3} {:?}", defects.defects.len(), defects.sigma_mm / sigma_mm, defects.defects);
        total += defects.defects.len();
    }
    assert!(total <= 6, "{total}");
}

#[test]
fn pits_and_dust_are_found_and_measured() {
    for (surface, name) in [(asphere as fn(f64, f64) -> Truth, "asphere"), (freeform, "freeform")] {
        for (seed, (sigma_mm, height_mm)) in
            [(5e-6, -5e-5), (2e-5, -5e-5), (1e-5, -2e-4), (5e-6, -1e-3), (2e-5, 3e-4)].into_iter().enumerate()
        {
            let mut points = part(surface, sigma_mm, 50 + seed as u64);
            let centre = [0.61, -0.53];
            add(&mut points, hill(centre, height_mm, 0.1));
            let defects = found(&points);
            for d in &defects.defects {
                eprintln!(
                    "{name} σ {sigma_mm:e} h {height_mm:e}: {:?} at {:.4} {:.4} h {:.2e} ± {:.1e} A {:.5} ± {:.5} l {:?} w {:?} V {:?} n {} t {:.1}",
                    d.kind, d.centre_mm[0], d.centre_mm[1], d.height_mm, d.height_uncertainty_mm,
                    d.area_mm2.unwrap_or(0.0), d.area_uncertainty_mm2.unwrap_or(0.0), d.length_mm, d.width_mm, d.volume_mm3, d.vertices, d.significance
                );
            }
            let truth = std::f64::consts::PI * 0.05 * 0.05;
            eprintln!("   truth A {truth:.5} V {:.3e}", height_mm * truth / 2.0_f64.ln());
        }
    }
}

#[test]
fn scratches_are_found_and_measured() {
    let angle = 0.4_f64;
    for (sigma_mm, depth_mm) in [(1e-5, 2e-4), (2e-5, 2e-4), (5e-6, 1e-3)] {
        let mut points = over(&raster([0.3, -0.2], 420, 0.008, 0.3, 7), asphere);
        roughen(&mut points, sigma_mm, 8);
        let (sin, cos) = angle.sin_cos();
        add(&mut points, |x, y| {
            let [t, d] = [(x - 0.3) * cos + (y + 0.2) * sin, (y + 0.2) * cos - (x - 0.3) * sin];
            if t.abs() <= 1.5 && d.abs() <= 0.01 { -depth_mm } else { 0.0 }
        });
        let defects = found_with(&points, 0.024, &DefectSettings::default());
        for d in defects.defects.iter().take(5) {
            eprintln!(
                "σ {sigma_mm:e} d {depth_mm:e}: {:?} at {:.4} {:.4} h {:.3e} ± {:.1e} A {:?} ± {:?} l {:?} w {:?} dir {:?} n {} t {:.1}",
                d.kind, d.centre_mm[0], d.centre_mm[1], d.height_mm, d.height_uncertainty_mm,
                d.area_mm2, d.area_uncertainty_mm2, d.length_mm, d.width_mm, d.direction, d.vertices, d.significance
            );
        }
    }
}

#[test]
fn a_step_is_found_and_measured() {
    for (sigma_mm, angle) in [(5e-6, 0.0_f64), (1e-5, 0.5), (2e-5, 0.785)] {
        let mut points = part(asphere, sigma_mm, 9);
        let (sin, cos) = angle.sin_cos();
        add(&mut points, |x, y| if (x - 0.35) * cos + (y + 0.13) * sin > 0.0 { 1e-4 } else { 0.0 });
        let defects = found(&points);
        for d in defects.defects.iter().take(5) {
            eprintln!(
                "σ {sigma_mm:e}: {:?} at {:.4} {:.4} h {:.3e} ± {:.1e} l {:?} w {:?} dir {:?} n {} t {:.1}",
                d.kind, d.centre_mm[0], d.centre_mm[1], d.height_mm, d.height_uncertainty_mm,
                d.length_mm, d.width_mm, d.direction, d.vertices, d.significance
            );
        }
        eprintln!("  {} σ {:.2e}", defects.defects.len(), defects.sigma_mm);
    }
}
