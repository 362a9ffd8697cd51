//! Metamorphic tests: the same part, changed in a known way, must have a report changed in that way and no other.
//!
//! Nobody needs to know the right figures for this. Every number of a report states in [`laws`] how it changes when
//! the part is moved, turned, mirrored, scaled or lifted, or its points come in another order. A number without a
//! law fails the test, so a new figure has to state its own.

mod compare;
mod laws;
mod scenes;

use std::sync::OnceLock;

use asphera_tests::number;
use serde_json::Value;

use compare::differences;
use laws::{Change, Turn};
use scenes::{Part, SCENES};

/// The report of every scene as it is.
fn unchanged() -> &'static [Value] {
    static REPORTS: OnceLock<Vec<Value>> = OnceLock::new();
    REPORTS.get_or_init(|| SCENES.iter().map(|scene| Part::new(scene).report()).collect())
}

/// Holds the reports of all changed parts to the laws.
fn check(change: &Change) {
    let mut wrong = Vec::new();
    for (scene, before) in SCENES.iter().zip(unchanged()) {
        let after = Part::new(scene).changed(change).report();
        let found = differences(before, &after, change);
        wrong.extend(found.into_iter().map(|line| format!("{}: {line}", scene.name)));
    }
    assert!(wrong.is_empty(), "{} numbers break their law:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn points_in_another_order() {
    check(&Change { shuffled: true, ..Change::NONE });
}

#[test]
fn a_part_moved_in_the_plane() {
    check(&Change { shift_mm: [37.25, -112.5, 0.0], ..Change::NONE });
}

#[test]
fn a_constant_added_to_the_heights() {
    check(&Change { shift_mm: [0.0, 0.0, 0.875], ..Change::NONE });
}

#[test]
fn a_part_turned_by_a_quarter() {
    check(&Change { turn: Turn::Quarter, ..Change::NONE });
}

#[test]
fn a_part_mirrored() {
    check(&Change { turn: Turn::Mirror, ..Change::NONE });
}

#[test]
fn all_lengths_doubled() {
    check(&Change { scale: 2.0, ..Change::NONE });
}

/// With the pose held, the extremes of a part are those of its halves, and its mean square is the mean of theirs.
#[test]
fn two_halves_make_the_whole() {
    let part = || Part::new(&SCENES[0]).held();
    let whole = part().report();
    let halves = [0, 1].map(|half| part().every_second(half).report());
    let of = |key: &str| {
        halves.each_ref().map(|report| number(report, &format!("/form/deviation/{key}")))
    };
    let deviation = |key: &str| number(&whole, &format!("/form/deviation/{key}"));
    assert_eq!(deviation("max_nm"), of("max_nm")[0].max(of("max_nm")[1]));
    assert_eq!(deviation("min_nm"), of("min_nm")[0].min(of("min_nm")[1]));
    let used = halves.each_ref().map(|report| number(report, "/points/used"));
    assert_eq!(number(&whole, "/points/used"), used[0] + used[1]);
    let squares: f64 = of("rms_nm").iter().zip(used).map(|(rms, used)| rms * rms * used).sum();
    let rms = (squares / number(&whole, "/points/used")).sqrt();
    assert!((rms / deviation("rms_nm") - 1.0).abs() < 1e-9, "{rms}");
}

/// Fewer points of the same part: nothing becomes better sampled, and what is known of the form stays.
#[test]
fn a_part_thinned_by_two() {
    for scene in &SCENES {
        let whole = Part::new(scene).report();
        let thin = Part::new(scene).every_second(0).report();
        let both = |place: &str| [&whole, &thin].map(|report| number(report, place));
        let name = scene.name;
        for place in ["/sampling/gap_max_mm", "/sampling/gap_p99_mm", "/sampling/spacing_median_mm"]
        {
            let [had, has] = both(place);
            assert!(has > had, "{name} {place}: {has} after {had}");
        }
        let [had, has] = both("/sampling/coverage");
        assert!(has <= had, "{name}: coverage {has} after {had}");
        let [had, has] = both("/form/deviation/rms_nm");
        assert!((has / had - 1.0).abs() < 0.05, "{name}: RMS {has} nm after {had} nm");
        let [had, has] = both("/form/deviation/pv_nm");
        assert!(has <= 1.02 * had, "{name}: PV {has} nm after {had} nm");
        let [had, has] = both("/sampling/noise_sigma_nm");
        // Waves that fewer points do not resolve count as noise.
        assert!(has > 0.75 * had, "{name}: noise {has} nm after {had} nm");
    }
}
