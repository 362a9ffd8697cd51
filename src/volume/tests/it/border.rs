//! Cells at fault beside what was not scanned contradict nothing.

use asphera_volume::{GridCheck, Histogram, Samples, Verdict};

fn check(samples: &Samples, missing: Option<&Samples>) -> GridCheck {
    GridCheck::with_missing(samples, &Histogram::new(samples), missing)
}

/// Two samples on a face diagonal in the last slice, as a scan may cut them from a part whose next slice joins them.
#[test]
fn a_cut_at_the_border_contradicts_nothing() {
    let at = |z: usize, size: [usize; 3]| {
        Samples::from_fn(size, |x, y, slice| slice == z && [[2, 2], [3, 3]].contains(&[x, y]))
            .unwrap()
    };
    let cut = check(&at(0, [6, 6, 1]), None);
    assert!(cut.case8_unpaired > 0 && !cut.is_contradicted(), "{cut:?}");
    assert_eq!(cut.verdict([1.0; 3], Some(9.0)).0, Verdict::Unknown);
    let within = check(&at(2, [6, 6, 6]), None);
    assert_eq!(within.doubtful, 0);
    assert_eq!(within.verdict([1.0; 3], Some(9.0)).0, Verdict::Contradicted);
    // The same where the slices beside them are missing.
    let missing = Samples::from_fn([6, 6, 6], |_, _, z| z != 2).unwrap();
    let beside = check(&at(2, [6, 6, 6]), Some(&missing));
    assert!(
        !beside.is_contradicted()
            && beside.near_missing == Histogram::new(&at(2, [6, 6, 6])).mixed()
    );
    // One that is far away changes nothing.
    let far = Samples::from_fn([6, 6, 6], |x, y, z| x + y + z == 0).unwrap();
    let found = check(&at(2, [6, 6, 6]), Some(&far));
    assert!(found.is_contradicted() && found.near_missing == 0);
}

/// What the theorems forbid, they forbid for cubes.
#[test]
fn no_verdict_on_voxels_that_are_no_cubes() {
    let samples =
        Samples::from_fn([4, 4, 4], |x, y, z| x == y && y == z && (x == 1 || x == 2)).unwrap();
    let found = check(&samples, None);
    assert_eq!(found.verdict([1.0; 3], None).0, Verdict::Contradicted);
    assert_eq!(found.verdict([1.0, 1.0, 3.0], None).0, Verdict::Unknown);
}
