//! FitConnect and StretchDenoise: noisy curves, corners, ends and outliers.

use std::f64::consts::TAU;

use asphera_contour::curves::{fit_connect, hnn_crust, stretch_denoise};
use asphera_contour::{Choice, Method, Parameters, PlaceMm};
use asphera_geometry::Numbers;

use crate::places::{by_row, circle, closed, distance, triangulation};

/// A circle of 5 mm with normal noise along its radius.
fn noisy_circle(count: usize, sigma: f64, draw: u32) -> Vec<PlaceMm> {
    let numbers = Numbers::new(77, draw, 0);
    (0..count)
        .map(|index| {
            let (sin, cos) = (TAU * index as f64 / count as f64).sin_cos();
            let radius = 5.0 + sigma * numbers.normal(index);
            [radius * cos, radius * sin]
        })
        .collect()
}

fn rms(places: &[PlaceMm]) -> f64 {
    let squares = places.iter().map(|[x, y]| (x.hypot(*y) - 5.0).powi(2));
    (squares.sum::<f64>() / places.len() as f64).sqrt()
}

#[test]
fn clean_curves_go_through_all_samples() {
    for count in [5, 12, 100, 800] {
        let set = triangulation(&circle(count));
        let found = fit_connect(&set);
        assert_eq!(by_row(&found.graph, &set), closed(count), "{count}");
        assert!(found.sigma_mm < 1e-9, "{count}: {}", found.sigma_mm);
    }
}

#[test]
fn noise_closes_to_one_curve_nearer_to_the_truth_than_the_samples() {
    for (count, sigma, least) in [(200, 0.05, 1.0), (400, 0.05, 0.9), (400, 0.1, 0.35)] {
        let (mut gains, mut joined, mut whole) = (0.0, 0.0, 0);
        for draw in 0..5 {
            let set = triangulation(&noisy_circle(count, sigma, draw));
            let found = fit_connect(&set);
            let degrees = found.graph.degrees(set.len());
            assert!(degrees.iter().all(|&degree| degree <= 2));
            let chains = found.graph.chains(set.len());
            let longest = chains.iter().max_by_key(|chain| chain.samples.len()).unwrap();
            let places = longest.samples.iter().map(|&sample| found.places_mm[sample as usize]);
            let moved: Vec<PlaceMm> = places.collect();
            gains += rms(&moved) / rms(&longest.places_mm(set.samples())) / 5.0;
            joined += longest.samples.len() as f64 / count as f64 / 5.0;
            whole += usize::from(longest.closed && chains.len() == 1);
            let broken = hnn_crust(set.samples()).ends(set.len()).len();
            assert!(chains.len() <= 2 && (count == 200 || broken >= 12), "{count} {sigma} {draw}");
        }
        println!(
            "{count} of {sigma}: RMS {gains:.3} of the samples, {joined:.3} joined, {whole} of 5 closed"
        );
        assert!(joined >= least && gains <= 1.0 + 1e-9 && whole >= 2);
        // Noise of 1.3 spacings is smoothed, noise of a third of one is followed.
        assert!(sigma < 0.1 || gains < 0.65, "{gains}");
    }
}

#[test]
fn outliers_stay_out_and_ends_open() {
    let mut points: Vec<PlaceMm> = circle(200)[..120].to_vec();
    points.extend([[20.0, 3.0], [-15.0, -9.0], [1.0, -14.0]]);
    let set = triangulation(&points);
    let found = fit_connect(&set);
    let path: Vec<[u32; 2]> = (1..120).map(|row| [row - 1, row]).collect();
    let edges = by_row(&found.graph, &set);
    // The two outermost samples have others on one side only.
    assert_eq!(edges, path[1..118]);
}

#[test]
fn the_method_gives_the_moved_places() {
    let points = noisy_circle(300, 0.05, 9);
    let set = triangulation(&points);
    let curve = Method::FitConnect.curve(&set, &Parameters::new()).unwrap();
    let found = fit_connect(&set);
    assert_eq!(curve.graph, found.graph);
    assert_eq!(curve.places_mm, Some(found.places_mm));
    assert_eq!(Method::FitConnect.run(&set, &Parameters::new()).unwrap(), found.graph);
}

#[test]
fn stretching_takes_noise_away_and_moves_nothing_farther_than_it() {
    for (count, sigma) in [(100, 0.02), (200, 0.05), (400, 0.05)] {
        for noise_mm in [0.0, 3.0 * sigma] {
            let (mut gains, mut bias) = (0.0, 0.0);
            for draw in 0..5 {
                let set = triangulation(&noisy_circle(count, sigma, draw));
                let found = stretch_denoise(&set, noise_mm);
                assert_eq!(found.graph, fit_connect(&set).graph);
                let degrees = found.graph.degrees(set.len());
                let used: Vec<usize> = (0..set.len()).filter(|&it| degrees[it] > 0).collect();
                let raw: Vec<PlaceMm> = used.iter().map(|&it| set.place(it as u32)).collect();
                let moved: Vec<PlaceMm> = used.iter().map(|&it| found.places_mm[it]).collect();
                if noise_mm > 0.0 {
                    let most = raw.iter().zip(&moved).map(|(p, q)| distance(*p, *q));
                    assert!(most.fold(0.0, f64::max) <= noise_mm * (1.0 + 1e-12));
                }
                gains += rms(&moved) / rms(&raw) / 5.0;
                let mean = |places: &[PlaceMm]| {
                    places.iter().map(|[x, y]| x.hypot(*y)).sum::<f64>() / places.len() as f64
                };
                bias += (mean(&moved) - mean(&raw)) / 5.0;
            }
            println!(
                "{count} of {sigma}, {noise_mm}: RMS {gains:.3} of the samples, bias {bias:.5}"
            );
            // Given three times the noise, runs are straightened that are arcs.
            let most = if noise_mm > 0.0 { 0.95 } else { 0.75 };
            assert!(gains < most, "{count} {sigma} {noise_mm}: {gains}");
            // The distances of the samples to the edges are balanced.
            assert!(bias.abs() < 0.15 * sigma, "{bias}");
        }
    }
}

#[test]
fn corners_wider_than_the_noise_stay() {
    let side = |from: PlaceMm, to: PlaceMm| {
        (0..20).map(move |step| {
            let share = f64::from(step) / 20.0;
            [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
        })
    };
    let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
    let points: Vec<PlaceMm> =
        (0..4).flat_map(|it| side(corners[it], corners[(it + 1) % 4])).collect();
    let set = triangulation(&points);
    let found = stretch_denoise(&set, 0.05);
    for (place, at) in found.places_mm.iter().zip(set.samples().places()) {
        assert!(distance(*place, *at) <= 0.05 * (1.0 + 1e-12));
    }
    // What the corners lose within the noise, the sides gain: the distances are balanced.
    let off = |place: &PlaceMm| {
        let [x, y] = place.map(|value| value.abs().min((value - 10.0).abs()));
        x.min(y)
    };
    let still = found.places_mm.iter().filter(|place| off(place) < 0.02).count();
    assert!(still >= 60, "{still} of 80 stay near the sides");
}

/// Three passes over one closed edge, each 10 µm beside the last, become one curve between them.
#[test]
fn several_passes_over_one_line_are_made_one() {
    let pass = |number: u32| {
        let radius = 5.0 + 0.01 * (f64::from(number) - 1.0);
        (0..700).map(move |index| {
            // No pass begins where another does.
            let angle = TAU * (f64::from(index) + 0.37 * f64::from(number)) / 700.0;
            [radius * angle.cos(), radius * angle.sin()]
        })
    };
    let points: Vec<PlaceMm> = (0..3).flat_map(pass).collect();
    let set = triangulation(&points);
    let choice = Choice::new(&set);
    assert_eq!(choice.method, Method::Lee, "{}", choice.reason());
    let found = choice.curve(&set).unwrap();
    let chains = found.graph.chains(set.len());
    assert!(chains.len() == 1 && chains[0].closed, "{} chains", chains.len());
    let places = found.places_mm.unwrap();
    let line: Vec<PlaceMm> =
        chains[0].samples.iter().map(|&sample| places[sample as usize]).collect();
    // The passes have an RMS of 8 µm about their middle.
    assert!(rms(&line) < 0.006, "{}", rms(&line));
}
