//! Curves that meet a proven condition are reconstructed rightly, every one.
//!
//! `ASPHERA_LONG=1` tries a thousand of each instead of forty, `ASPHERA_CURVES` another number.

use asphera_contour::curves::{cocone, crust, hnn_crust, nn_crust, one_step_crust};
use asphera_contour::{Graph, Triangulation};

use crate::places::{Random, by_row, closed, triangulation};
use crate::smooth::{Condition, Curve};

/// How far a condition is kept from its bound: the medial axis is that of places, and cuts a bit.
const SAFETY: f64 = 0.97;

fn count() -> usize {
    let many = if std::env::var_os("ASPHERA_LONG").is_some() { 1000 } else { 40 };
    std::env::var("ASPHERA_CURVES").ok().and_then(|text| text.parse().ok()).unwrap_or(many)
}

fn all_right(name: &str, condition: Condition, method: impl Fn(&Triangulation) -> Graph) {
    all_right_of(name, condition, 600, method);
}

/// As [`all_right`], of curves that are so many places.
#[expect(clippy::print_stdout, reason = "how many curves were tried, of how many samples")]
fn all_right_of(
    name: &str,
    condition: Condition,
    places: usize,
    method: impl Fn(&Triangulation) -> Graph,
) {
    let mut random = Random::new(7);
    let (mut tried, mut samples, mut wrong) = (0, 0, 0);
    while tried < count() {
        let curve = Curve::random(&mut random, places);
        let Some(points) = curve.samples(condition, &mut random) else { continue };
        let set = triangulation(&points);
        wrong += usize::from(by_row(&method(&set), &set) != closed(points.len()));
        samples += points.len();
        tried += 1;
    }
    println!("{name}: {wrong} wrong of {tried} curves, {} samples each", samples / tried);
    assert_eq!(wrong, 0, "{name}");
}

#[test]
fn crust_at_epsilon_a_quarter() {
    all_right("crust", Condition::Epsilon(0.252 * SAFETY), crust);
}

#[test]
fn nn_crust_at_epsilon_a_third() {
    all_right("nn-crust", Condition::Epsilon(SAFETY / 3.0), nn_crust);
}

#[test]
fn hnn_crust_at_rho_nine_tenths() {
    all_right("hnn-crust", Condition::Rho(0.9 * SAFETY), |set| hnn_crust(set.samples()));
}

#[test]
fn hnn_crust_at_epsilon_047() {
    all_right("hnn-crust", Condition::Epsilon(0.47 * SAFETY), |set| hnn_crust(set.samples()));
}

#[test]
fn cocone_at_epsilon_a_twentieth() {
    // So small an ε needs places closer together.
    all_right_of("cocone", Condition::Epsilon(0.05 * SAFETY), 4_000, cocone);
}

#[test]
fn cocone_far_above_its_epsilon() {
    // Not proven, and right here.
    all_right("cocone", Condition::Epsilon(0.252 * SAFETY), cocone);
}

#[test]
fn the_one_step_crust_where_the_crust_is_proven() {
    // Not proven for it, but it holds the crust and is as right here.
    all_right("one-step-crust", Condition::Epsilon(0.252 * SAFETY), |set| {
        one_step_crust(set).crust
    });
}

#[test]
fn a_condition_far_from_met_is_told_by_wrong_edges() {
    let mut random = Random::new(8);
    let mut wrong = 0;
    for _ in 0..20 {
        let curve = Curve::random(&mut random, 600);
        let Some(points) = curve.samples(Condition::Epsilon(2.5), &mut random) else { continue };
        let set = triangulation(&points);
        wrong += usize::from(by_row(&nn_crust(&set), &set) != closed(points.len()));
    }
    assert!(wrong > 0, "the test of the guarantees could not fail");
}
