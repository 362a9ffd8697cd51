//! Scans of a plane whose need of points is a known function of the place.

use super::*;

const SQUARE: Aperture = Aperture::Rectangle { width_mm: 16.0, height_mm: 16.0 };

fn goal() -> Goal {
    Goal { coverage: 1.0, u_max: None, budget_s: None, batch_places: 100_000, finest_mm: 0.0 }
}

fn boxed(low: [f64; 2], high: [f64; 2]) -> WantedRegion {
    let outline_mm = vec![low, [high[0], low[1]], high, [low[0], high[1]]];
    let polygons = vec![Polygon { outline_mm, holes_mm: Vec::new() }];
    WantedRegion { polygons, spacing_mm: None, gain: 0.5 }
}

fn known(regions: &[WantedRegion]) -> Known<'_> {
    Known {
        regions,
        coverage: Some(0.5),
        verdict: VerdictState::NotAsked,
        u: None,
        spent_s: 0.0,
        stands_mm: [0.0; 2],
    }
}

/// Places of the pieces of a batch.
fn places(batch: &Batch) -> Vec<[f64; 2]> {
    let each = |(piece, spacing): &(Piece, Spacing)| -> Vec<[f64; 2]> {
        spacing.ways_mm(piece).into_iter().map(|way| piece.at(way)).collect()
    };
    batch.pieces.iter().flat_map(each).collect()
}

fn measured(step: Step) -> Batch {
    match step {
        Step::Measure(batch) => batch,
        Step::End(ending) => panic!("{ending:?}"),
    }
}

/// Each place needs a spacing; a square lattice with the spacing there, or a finer one, is enough.
#[test]
fn each_place_gets_the_spacing_it_needs_and_no_half_of_it() {
    // Left of the middle 2 mm do, on the right it must be 0.5 mm.
    let mut scan = AdaptiveScan::new(goal(), SQUARE, [0.0; 2], 2.0).unwrap();
    let mut all = places(&scan.begin([0.0; 2]));
    assert_eq!(all.len(), 81);
    let right = [boxed([0.0, -8.0], [8.0, 8.0])];
    for _ in 0..4 {
        let batch = measured(scan.next_step(&known(&right)));
        let new = places(&batch);
        assert_eq!(new.len(), batch.places);
        all.extend(new);
    }
    let count = all.len();
    all.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    all.dedup();
    assert_eq!(all.len(), count, "a place came twice");
    // 17 columns of 33 places on the right, those of level 0 on the left.
    let on_right = all.iter().filter(|place| place[0] >= -1e-9).count();
    assert_eq!((on_right, count - on_right), (17 * 33, 4 * 9));
}

#[test]
fn a_scan_ends_for_its_reason() {
    let regions = [boxed([-8.0, -8.0], [8.0, 8.0])];
    let begun = |goal: Goal| {
        let mut scan = AdaptiveScan::new(goal, SQUARE, [0.0; 2], 2.0).unwrap();
        scan.begin([0.0; 2]);
        scan
    };
    let covered = Known { coverage: Some(1.0), ..known(&regions) };
    assert_eq!(begun(goal()).next_step(&covered), Step::End(Ending::Reached));
    let fails = Known { verdict: VerdictState::FailCertain, ..covered };
    assert_eq!(begun(goal()).next_step(&fails), Step::End(Ending::FailCertain));
    let late = Known { spent_s: 60.0, ..known(&regions) };
    let hurried = Goal { budget_s: Some(60.0), ..goal() };
    assert_eq!(begun(hurried).next_step(&late), Step::End(Ending::BudgetSpent));
    let early = Known { spent_s: 59.0, ..late };
    assert!(matches!(begun(hurried).next_step(&early), Step::Measure(_)));
    // Reached counts though the time is spent.
    let late = Known { spent_s: 60.0, ..covered };
    assert_eq!(begun(hurried).next_step(&late), Step::End(Ending::Reached));
    assert_eq!(begun(goal()).next_step(&known(&[])), Step::End(Ending::NothingToGain));
    // Half of what a region needs is the finest.
    let satisfied = [WantedRegion { spacing_mm: Some(4.1), ..regions[0].clone() }];
    assert_eq!(begun(goal()).next_step(&known(&satisfied)), Step::End(Ending::NothingToGain));
    let noisy = Goal { finest_mm: 1.5, ..goal() };
    assert_eq!(begun(noisy).next_step(&known(&regions)), Step::End(Ending::NothingToGain));
}

#[test]
fn an_open_verdict_asks_for_more_as_long_as_that_helps() {
    let mut scan =
        AdaptiveScan::new(Goal { u_max: Some(1.0), ..goal() }, SQUARE, [0.0; 2], 2.0).unwrap();
    scan.begin([0.0; 2]);
    let covered = |u: f64| Known { coverage: Some(1.0), u: Some(u), ..known(&[]) };
    let batch = measured(scan.next_step(&covered(4.0)));
    assert_eq!((batch.places, batch.regions), (64, 0));
    assert_eq!(measured(scan.next_step(&covered(2.9))).places, 144);
    assert_eq!(scan.clone().next_step(&covered(0.9)), Step::End(Ending::Reached));
    assert_eq!(scan.next_step(&covered(2.85)), Step::End(Ending::NothingToGain));
    let open = Known { verdict: VerdictState::Open, ..covered(0.5) };
    let mut scan = AdaptiveScan::new(goal(), SQUARE, [0.0; 2], 2.0).unwrap();
    scan.begin([0.0; 2]);
    assert!(matches!(scan.next_step(&open), Step::Measure(_)));
    assert_eq!(scan.next_step(&open), Step::End(Ending::NothingToGain));
}

#[test]
fn a_small_batch_takes_the_region_of_most_gain_first() {
    let small = WantedRegion { gain: 0.1, ..boxed([-8.0, -8.0], [-4.0, -4.0]) };
    let large = WantedRegion { gain: 0.2, ..boxed([4.0, 4.0], [8.0, 8.0]) };
    let mut scan =
        AdaptiveScan::new(Goal { batch_places: 4, ..goal() }, SQUARE, [0.0; 2], 2.0).unwrap();
    scan.begin([0.0; 2]);
    let regions = [small, large];
    let first = measured(scan.next_step(&known(&regions)));
    assert_eq!((first.places, first.regions), (4, 1));
    assert!(places(&first).iter().all(|place| place[0] > 4.0));
    let second = measured(scan.next_step(&known(&regions)));
    // Four squares a region: then its finer level.
    assert!(places(&second).iter().all(|place| place[0] > 3.5), "{second:?}");
}

/// Points enclose a round aperture but for slivers, and no two come together, whatever the levels.
#[test]
fn places_reach_the_border_and_stay_apart() {
    let disc = Aperture::Circle { radius_mm: 5.0 };
    let mut scan = AdaptiveScan::new(goal(), disc, [1.0, 2.0], 1.7).unwrap();
    let mut all = places(&scan.begin([0.0; 2]));
    let everywhere = [boxed([-5.0, -4.0], [7.0, 8.0])];
    for level in 1..6 {
        let batch = measured(scan.next_step(&known(&everywhere)));
        all.extend(places(&batch));
        let spacing_mm = 1.7 * (-0.5 * f64::from(level)).exp2();
        let farthest = (0..720).map(|step| {
            let (sin, cos) = (f64::from(step) * std::f64::consts::PI / 360.0).sin_cos();
            let rim = [1.0 + 5.0 * cos, 2.0 + 5.0 * sin];
            all.iter().map(|&place| distance_mm(place, rim)).fold(f64::INFINITY, f64::min)
        });
        let farthest = farthest.fold(0.0, f64::max);
        assert!(farthest < 1.1 * spacing_mm, "{level}: {farthest} {spacing_mm}");
        for (index, &place) in all.iter().enumerate() {
            let near = |other: &&[f64; 2]| distance_mm(place, **other) < 0.05 * spacing_mm;
            let other = all[..index].iter().find(near);
            assert!(other.is_none(), "{level}: {place:?} {other:?}");
            assert!(distance_mm(place, [1.0, 2.0]) < 5.0 + 1e-9);
        }
    }
}

#[test]
fn goals_that_cannot_be_are_refused() {
    let refused = |goal: Goal| AdaptiveScan::new(goal, SQUARE, [0.0; 2], 2.0).unwrap_err().key;
    assert_eq!(refused(Goal { coverage: 1.1, ..goal() }), "coverage");
    assert_eq!(refused(Goal { coverage: f64::NAN, ..goal() }), "coverage");
    assert_eq!(refused(Goal { batch_places: 0, ..goal() }), "batch");
    assert_eq!(refused(Goal { budget_s: Some(-1.0), ..goal() }), "budget");
    assert_eq!(AdaptiveScan::new(goal(), SQUARE, [0.0; 2], 0.0).unwrap_err().key, "spacing");
}
