//! What is said while points arrive, against what comes out in the end.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use asphera_report::{Outlook, ProspectFigures, ProspectState, Report, Status};

use crate::Part;
use crate::nominal::parse;
use crate::random::Random;
use crate::{Pipeline, RunningFigures};

/// A disc of 20 mm radius scanned line by line, every 0.4 mm, with waves of 9 mm of this amplitude and a little noise.
fn scan(amplitude_nm: f64) -> Vec<PointMm> {
    let mut random = Random(7);
    let mut noise = move || random.centred();
    let mut points = Vec::new();
    for line in 0..100 {
        for column in 0..100 {
            let (x, y) = (0.4 * f64::from(column) - 19.8, 0.4 * f64::from(line) - 19.8);
            if x.hypot(y) <= 20.0 {
                let wave = (TAU * x / 9.0).sin() * (TAU * y / 9.0).cos();
                points.push([x, y, 1e-6 * (amplitude_nm * wave + noise()) + 1e-4 * x]);
            }
        }
    }
    points
}

fn part(rest: &str) -> Part {
    let text = format!(
        "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 20\n\
         [sampling]\ngap_limit_mm = 0.4\ncoverage_min = 0.5\n{rest}"
    );
    parse("part.toml", &text).unwrap()
}

/// What is said after every 250 points, and the report.
fn followed(part: Part, points: &[PointMm]) -> (Vec<RunningFigures>, Report) {
    let mut pipeline = Pipeline::new(part).expecting(Some(points.len() as u64));
    let mut said = Vec::new();
    for (index, point) in points.iter().enumerate() {
        pipeline.take_position(*point);
        if index % 250 == 249 {
            said.push(pipeline.figures());
        }
    }
    (said, pipeline.finish().report)
}

fn outlooks(said: &[RunningFigures]) -> impl Iterator<Item = &Outlook> {
    said.iter().filter_map(|figures| figures.outlook.as_ref())
}

fn of<'a>(outlook: &'a Outlook, name: &str) -> &'a ProspectFigures {
    outlook.limits.iter().find(|limit| limit.figure.name == name).unwrap()
}

#[test]
fn a_part_that_fails_early_is_told_before_the_end_and_it_is_never_taken_back() {
    let points = scan(100.0);
    for (limits, name) in [("pv_nm = 100\n", "pv_nm"), ("rms_nm = 20\n", "rms_nm")] {
        for guard in ["", "guard_probability = 0.95\n"] {
            let (said, report) = followed(part(&format!("[tolerance]\n{limits}{guard}")), &points);
            let check = &report.verdict.checks[0];
            assert_eq!(report.verdict.status, Status::Fail, "{:?}", report.verdict);
            let all: Vec<&Outlook> = outlooks(&said).collect();
            let first = all.iter().position(|one| one.state == ProspectState::FailCertain);
            let first = first.unwrap_or_else(|| panic!("{limits}{guard}: {:?}", all.last()));
            assert!(first < 3 * all.len() / 4, "{limits}{guard}: only at {first} of {}", all.len());
            assert!(all[first..].iter().all(|one| one.state == ProspectState::FailCertain));
            assert!(all[first].text.starts_with("FAIL is certain: "), "{}", all[first].text);
            let mut least = 0.0;
            for one in &all[first..] {
                let promised = of(one, name).at_least.unwrap();
                assert!(promised >= least && promised <= check.value, "{promised} {check:?}");
                least = promised;
            }
        }
    }
}

/// Limit and spread leave the pass open at first; then it is certain, and so it comes out.
#[test]
fn a_good_part_passes_from_a_coverage_that_comes_nearer_and_then_does() {
    let tolerance = "[tolerance]\nrms_nm = 57\npv_nm = 300\n";
    let (said, report) = followed(part(tolerance), &scan(100.0));
    let all: Vec<&ProspectFigures> = outlooks(&said).map(|one| of(one, "rms_nm")).collect();
    let ahead: Vec<f64> =
        all.iter().filter_map(|one| Some(one.pass_from_coverage? - one.coverage?)).collect();
    assert!(ahead.len() > 10 && ahead[0] >= 0.0, "{ahead:?}");
    assert_eq!(*ahead.last().unwrap(), 0.0, "{ahead:?}");
    let certain = all.iter().position(|one| one.state == ProspectState::PassCertain).unwrap();
    assert!(certain > 0 && certain < all.len() - 1, "{certain} of {}", all.len());
    assert!(outlooks(&said).all(|one| one.state != ProspectState::FailCertain));
    let last = outlooks(&said).last().unwrap();
    // Either end may hold an extreme of the PV, so that needs 97.5 % at least.
    let from = of(last, "pv_nm").pass_from_coverage.unwrap();
    assert!((0.975..=1.0).contains(&from), "{from}");
    assert!(
        last.text.contains("can be decided at") && last.text.contains("% coverage, now"),
        "{}",
        last.text
    );
    assert_eq!(report.verdict.status, Status::Pass, "{:?}", report.verdict);
}

#[test]
fn what_cannot_be_said_is_open_and_says_why() {
    let points = scan(100.0);
    let text = |rest: &str| {
        let (said, report) = followed(part(rest), &points[..3000]);
        assert!(report.verdict.outlook.is_none());
        said.last().unwrap().outlook.clone()
    };
    assert_eq!(text(""), None);
    // Just beyond the limit: another fit of more points may leave less.
    let wide = text("[tolerance]\npv_nm = 1e4\n").unwrap();
    let pv_nm = wide.limits[0].value.unwrap();
    let near = text(&format!("[tolerance]\npv_nm = {}\n", 0.9999 * pv_nm)).unwrap();
    assert_eq!(near.state, ProspectState::Open, "{near:?}");
    assert!(near.text.contains("may still leave less"), "{}", near.text);
    let unknown = parse("p.toml", "[surface]\nkind = \"unknown\"\n[tolerance]\nrms_nm = 1\n");
    let (said, _) = followed(unknown.unwrap(), &points);
    let last = outlooks(&said).last().unwrap();
    assert!(last.text.contains("made anew from all points at the end"), "{}", last.text);
    let other = text("[tolerance]\npvr_nm = 500\n").unwrap();
    assert_eq!(other.state, ProspectState::AtEnd);
    assert_eq!(other.text, "No decision before the end: of all points comes PVr.");
    assert_eq!(other.limits[0].text, "known at the end: PVr is worked out from all points");
    // What is not foreseen is not passed over.
    let zone = text("[tolerance]\npv_nm = 1e4\nminimum_zone_nm = 1e4\n").unwrap();
    assert_eq!((zone.state, zone.limits.len()), (ProspectState::AtEnd, 2), "{zone:?}");
    assert!(
        zone.text.starts_with(
            "No decision before the end: of all points comes minimum zone. On course for PASS"
        ),
        "{}",
        zone.text
    );
    let mut twice = points[..3000].to_vec();
    twice.push(points[5]);
    let (said, _) =
        followed(part("[tolerance]\npv_nm = 50\n"), &[&twice[..], &points[3000..]].concat());
    let last = outlooks(&said).last().unwrap();
    assert_eq!(last.text, "No decision yet: places were measured more than once");
    let nobody = parse("p.toml", "[surface]\nkind = \"plane\"\n[tolerance]\nrms_nm = 500\n");
    let (said, _) = followed(nobody.unwrap(), &points);
    let last = outlooks(&said).last().unwrap();
    assert!(last.text.contains("without an aperture"), "{}", last.text);
}
