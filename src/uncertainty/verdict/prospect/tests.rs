//! Prospects by hand.

use super::*;
use crate::verdict::Predicted;

fn predicted() -> Predicted {
    Predicted::of_values((0..100).map(|i| 90.0 + 0.2 * f64::from(i)).collect())
}

fn running<'a>(raised: Raised, predicted: Option<&'a Predicted>) -> Running<'a> {
    Running {
        value_nm: 90.0,
        at_least_nm: Some(80.0),
        u_nm: Some(2.0),
        dof: f64::INFINITY,
        raised,
        between_nm: Some(1.0),
        beyond_nm: Some(0.0),
        coverage: 0.4,
        zone: None,
        predicted,
    }
}

#[test]
fn a_fail_is_certain_once_the_rest_cannot_help() {
    let fails = |raised, limit_nm| {
        let found = prospect(&running(raised, None), limit_nm, Guard::Factor(2.0), 0.95).unwrap();
        found.fail_is_certain
    };
    // 80 less a bias of 3 and a band of 4.
    let range = Raised::Range { bias_nm: 3.0 };
    assert!(fails(range, 72.9) && !fails(range, 73.0));
    // 48 of the 80 nm are noise, and 64 are left.
    let rms = Raised::Rms { noise_nm: 48.0 };
    assert!(fails(rms, 59.9) && !fails(rms, 60.1));
    let blind = Running { at_least_nm: None, ..running(range, None) };
    assert!(!prospect(&blind, 1.0, Guard::None, 0.9).unwrap().fail_is_certain);
    assert!(prospect(&blind, 1.0, Guard::None, 0.4).is_err());
}

#[test]
fn a_pass_waits_for_what_may_stand_out_and_for_the_rest() {
    let predicted = predicted();
    let from = |running: &Running<'_>, limit_nm| {
        prospect(running, limit_nm, Guard::Factor(2.0), 0.95).unwrap().pass_from_coverage
    };
    let rms = running(Raised::Rms { noise_nm: 0.0 }, Some(&predicted));
    // 95 % of the wholes are below 109 nm; the band takes 4, what may stand out between the points 1.
    assert_eq!(from(&rms, 114.0), Some(0.4));
    let halfway = (90.0_f64 * 90.0).midpoint(109.0 * 109.0).sqrt();
    assert!((from(&rms, halfway + 5.0).unwrap() - 0.7).abs() < 1e-12);
    // The limit holds as it is, but not with what may stand out.
    assert_eq!(from(&rms, 94.9), None);
    assert_eq!(from(&Running { between_nm: None, ..rms }, 1e4), None);
    assert_eq!(from(&Running { predicted: None, ..rms }, 1e4), None);
    let range = Running { raised: Raised::Range { bias_nm: 3.0 }, ..rms };
    assert_eq!(from(&range, 114.0), Some(0.975));
    // A tenth of the wholes is beyond 107.9 nm.
    let later = Running { coverage: 0.9, ..range };
    assert_eq!(from(&later, 107.9 + 5.0), Some(0.975));
    // A zone that is measured waits for the rest no more than the forecast does; one that is not may come last.
    let zone = |coverage| Running { zone: Some(Zone { coverage, area: 0.2 }), ..range };
    assert_eq!(from(&zone(0.98), 114.0), Some(0.4));
    assert_eq!(from(&zone(0.97), 114.0), Some(0.995));
    assert_eq!(from(&Running { coverage: 1.0, ..zone(1.0) }, 96.0), None);
    // By patches the RMS may be 20 nm more, whatever is forecast.
    assert!(from(&Running { beyond_nm: Some(20.0), ..rms }, 114.0).unwrap() > 0.4);
    // Nearly all of them are beyond 91 nm: of what is left a twentieth may be.
    let all_beyond = from(&later, 96.0).unwrap();
    assert!((all_beyond - (1.0 - 0.1 * 0.05 / 0.94)).abs() < 1e-12, "{all_beyond}");
}

#[test]
fn the_rms_of_the_whole_by_its_patches() {
    let patches = [20.0, 300.0, 60.0, 150.0, 40.0, 80.0, 120.0, 30.0];
    let t = student_quantile(0.95, 7.0);
    assert!((t - 1.894_6).abs() < 1e-4);
    // Half of the aperture measured by 8 patches of mean 100, which leaves 8.
    let rest = 100.0 + t * (59_800.0_f64 / 7.0).sqrt() * 0.5;
    let whole_nm = rms_of_whole_nm(10.0, &patches, 0.5, 0.95).unwrap();
    assert!((whole_nm - (50.0 + 0.5 * rest).sqrt()).abs() < 1e-5, "{whole_nm}");
    assert_eq!(rms_of_whole_nm(10.0, &[], 1.0, 0.95), Some(10.0));
    assert_eq!(rms_of_whole_nm(10.0, &patches[1..], 0.99, 0.95), None);
}
