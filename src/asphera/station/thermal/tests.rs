//! Lengths of known bodies at known temperatures.

use super::*;
use asphera_link::Values;
use proptest::prelude::*;

fn expansion(temperature: Temperature, per_k: f64) -> Expansion {
    Expansion { temperature, per_k, u_per_k: 0.0, u_k: 0.0 }
}

fn settings(part: Option<Expansion>, scales: Option<Expansion>) -> ThermalSettings {
    ThermalSettings {
        part,
        scales,
        stale: Duration::from_secs(60),
        range_degc: (10.0, 40.0),
        starts_with_angle: false,
    }
}

fn point(at_s: u64, position_mm: [f64; 3]) -> Point {
    let host = Nanos::from_millis(1000 * at_s);
    Point { count: None, host, position_mm, flags: Flags::empty(), u_mm: [0.0; 3] }
}

fn reading(at_s: u64, values: &[Option<f64>]) -> Reading {
    let values: Values = values.iter().copied().collect();
    let (host, flags) = (Nanos::from_millis(1000 * at_s), Flags::empty());
    Reading { host, device_time_ns: None, count: None, values, flags }
}

fn at_20(thermal: &mut Thermal, mut point: Point) -> Point {
    thermal.apply(&mut point);
    point
}

/// A steel gauge block of 100 mm (11.5 µm/m/K) is 11.5 µm longer at 30 °C; a scale of the same steel does not see it.
#[test]
fn a_gauge_block_has_its_length_at_20_degc() {
    let steel = expansion(Temperature::Constant(30.0), 11.5e-6);
    let mut alone = Thermal::new(settings(Some(steel), None), Vec::new());
    let found = at_20(&mut alone, point(0, [0.0, -100.0115, 0.0]));
    assert_eq!(found.position_mm[0], 0.0);
    assert!((found.position_mm[1] + 100.0).abs() < 1e-13 && found.is_good());
    let mut both = Thermal::new(settings(Some(steel), Some(steel)), Vec::new());
    assert_eq!(at_20(&mut both, point(0, [100.0, 5.0, 1.0])).position_mm, [100.0, 5.0, 1.0]);
    // A glass scale (8 µm/m/K) at 30 °C has graduations too far apart, so it indicates too little.
    let glass = expansion(Temperature::Constant(30.0), 8e-6);
    let mut scale = Thermal::new(settings(None, Some(glass)), Vec::new());
    assert!(
        (at_20(&mut scale, point(0, [100.0, 0.0, 0.0])).position_mm[0] - 100.008).abs() < 1e-13
    );
}

#[test]
fn at_20_degc_nothing_changes_and_an_angle_never_does() {
    let body = expansion(Temperature::Constant(20.0), 23e-6);
    let mut thermal = Thermal::new(settings(Some(body), Some(body)), Vec::new());
    let place = [1.0 / 3.0, -7.7, 1e-9];
    assert_eq!(at_20(&mut thermal, point(0, place)).position_mm, place);
    let warm = expansion(Temperature::Constant(30.0), 1e-4);
    let angle = ThermalSettings { starts_with_angle: true, ..settings(Some(warm), None) };
    let mut thermal = Thermal::new(angle, Vec::new());
    let [angle, radius, height] = at_20(&mut thermal, point(0, [4000.0, 1.001, 2.002])).position_mm;
    assert!(angle == 4000.0 && (radius - 1.0).abs() < 1e-15 && (height - 2.0).abs() < 1e-15);
}

/// The second device of the configuration is the first on line 1; its channel 1 is the part's.
#[test]
fn a_point_needs_a_temperature_that_is_not_stale() {
    let channel = Temperature::Channel { device: 1, channel: 1 };
    let places = vec![(0, 0), (1, 0)];
    let mut thermal = Thermal::new(settings(Some(expansion(channel, 1e-5)), None), places);
    let before = at_20(&mut thermal, point(0, [1.0, 2.0, 3.0]));
    assert_eq!((before.position_mm, before.flags), ([1.0, 2.0, 3.0], Flags::NO_TEMPERATURE));
    assert!(!thermal.is_ready() && !before.is_good() && thermal.figures().is_none());
    let [other, missing, odd, right] = [
        (0, [Some(20.0), Some(25.0)]),
        (1, [Some(25.0), None]),
        (1, [Some(25.0), Some(-200.0)]),
        (1, [Some(0.0), Some(21.0)]),
    ];
    for (line, values) in [other, missing, odd] {
        thermal.take(line, 0, &reading(9, &values));
        assert!(!thermal.is_ready(), "{values:?}");
    }
    thermal.take(right.0, 0, &reading(10, &right.1));
    assert!(thermal.is_ready());
    // A point that was joined late has a later temperature.
    for at_s in [9, 10, 70] {
        let found = at_20(&mut thermal, point(at_s, [0.0, 0.0, 100.0]));
        assert!((found.position_mm[2] - 100.0 / 1.000_01).abs() < 1e-13 && found.is_good());
    }
    assert_eq!(at_20(&mut thermal, point(71, [0.0; 3])).flags, Flags::NO_TEMPERATURE);
    // What is not believed leaves the latest, which grows old.
    thermal.take(1, 0, &reading(71, &[None, Some(55.0)]));
    assert!(!at_20(&mut thermal, point(72, [0.0; 3])).is_good());
    thermal.take(1, 0, &reading(72, &[None, Some(22.0)]));
    assert!(at_20(&mut thermal, point(72, [0.0; 3])).is_good());
    let figures = thermal.figures().unwrap();
    assert_eq!((figures.part_degc, figures.scales_degc), (Some([21.0, 22.0]), None));
    let [least, most] = figures.lengths_um_per_m;
    assert!((least + 20.0).abs() < 1e-3 && (most + 10.0).abs() < 1e-3, "{least} {most}");
}

/// JCGM 100: 10 K · 1e-6/K, 11.5e-6/K · 0.2 K; of one thermometer the temperatures cancel as the coefficients do.
#[test]
fn the_uncertainty_is_that_of_coefficients_and_temperatures() {
    let steel =
        Expansion { u_per_k: 1e-6, u_k: 0.2, ..expansion(Temperature::Constant(30.0), 11.5e-6) };
    let u = |settings: ThermalSettings, places: Vec<(usize, usize)>| {
        let mut thermal = Thermal::new(settings, places);
        thermal.take(0, 0, &reading(0, &[Some(30.0)]));
        at_20(&mut thermal, point(0, [1.0; 3]));
        thermal.figures().unwrap().u_um_per_m
    };
    let alone = (10.0_f64.powi(2) + 2.3_f64.powi(2)).sqrt();
    assert!((u(settings(Some(steel), None), Vec::new()) - alone).abs() < 1e-9);
    let apart = u(settings(Some(steel), Some(steel)), Vec::new());
    assert!((apart - alone * 2.0_f64.sqrt()).abs() < 1e-9);
    let temperature = Temperature::Channel { device: 0, channel: 0 };
    let one = Expansion { temperature, ..steel };
    let together = u(settings(Some(one), Some(one)), vec![(0, 0)]);
    assert!((together - 200.0_f64.sqrt()).abs() < 1e-9, "{together}");
}

proptest! {
    /// A body that grows as its coefficient says, under scales that grow as theirs says, has its size at 20 °C.
    #[test]
    fn a_part_of_any_temperature_is_the_part(
        place_mm in prop::array::uniform3(-500.0..500.0_f64),
        part in (10.0..40.0_f64, -1e-6..100e-6_f64),
        scales in (10.0..40.0_f64, 0.0..30e-6_f64),
    ) {
        let grown = |(degc, per_k): (f64, f64)| 1.0 + per_k * (degc - 20.0);
        let indicated = place_mm.map(|mm| mm * grown(part) / grown(scales));
        let body = |(degc, per_k)| Some(expansion(Temperature::Constant(degc), per_k));
        let mut thermal = Thermal::new(settings(body(part), body(scales)), Vec::new());
        let found = at_20(&mut thermal, point(0, indicated)).position_mm;
        for (found, truth) in found.iter().zip(place_mm) {
            prop_assert!((found - truth).abs() <= 1e-15 * truth.abs().max(1e-300) * 4.0);
        }
    }
}
