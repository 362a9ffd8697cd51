//! Minimum zones of inputs that determine little or nothing.

use asphera_form::{
    Aperture, Criterion, Excluded, FitError, FitSettings, Nominal, Parameter, PointMm, Side,
    ZoneFit, ZoneSettings, ZoneTermination, minimum_zone,
};

use crate::common::{Noise, al1815, misaligned, spiral};

fn plane(points: &[PointMm]) -> ZoneFit {
    minimum_zone(points, &Nominal::Plane, &ZoneSettings::default()).unwrap()
}

fn lens(count: usize) -> Vec<PointMm> {
    let mut noise = Noise::new(4);
    spiral(count, 9.0)
        .into_iter()
        .map(|[x, y]| [x, y, al1815().sag_mm(x.hypot(y)) + 1e-5 * noise.next()])
        .map(|point| misaligned().to_measured(point))
        .collect()
}

#[test]
fn points_that_fix_the_surface_leave_no_zone() {
    let found = plane(&[[0.0, 0.0, 1.0], [1.0, 0.0, 1.5], [0.0, 2.0, 0.6]]);
    assert!(found.zone_mm < 1e-14 && found.termination.is_settled(), "{found:?}");
    assert!(found.contacts.is_empty());
    let few = [[1.0, 2.0, 3.0], [2.0, 0.0, 1.0]];
    assert_eq!(
        minimum_zone(&few, &Nominal::Plane, &ZoneSettings::default()),
        Err(FitError::TooFewPoints { used: 2, needed: 3, excluded: Excluded::default() })
    );
    for count in [5, 6] {
        let found = minimum_zone(&lens(count), &al1815(), &ZoneSettings::default()).unwrap();
        assert!(found.zone_mm < 1e-13, "{count}: {found:?}");
    }
}

#[test]
fn nothing_to_change_is_only_evaluated() {
    let fit = FitSettings { free: Vec::new(), ..FitSettings::default() };
    let settings = ZoneSettings { fit, criterion: Criterion::Centred, ..ZoneSettings::default() };
    let points = [[0., 0., 1.], [1., 0., -3.], [0., 1., 2.]];
    let found = minimum_zone(&points, &Nominal::Plane, &settings).unwrap();
    assert_eq!(found.zone_mm, 6.0);
    assert_eq!((found.contacts[0].index, found.contacts[0].side), (1, Side::Low));
    let settings = ZoneSettings { criterion: Criterion::Range, ..settings };
    let found = minimum_zone(&points, &Nominal::Plane, &settings).unwrap();
    assert_eq!((found.zone_mm, found.offset_mm), (5.0, -0.5));
    assert!(found.termination.is_settled());
}

#[test]
fn duplicates_change_nothing() {
    let points = lens(700);
    let once = minimum_zone(&points, &al1815(), &ZoneSettings::default()).unwrap();
    let twice: Vec<PointMm> = points.iter().chain(&points).copied().collect();
    let twice = minimum_zone(&twice, &al1815(), &ZoneSettings::default()).unwrap();
    assert!((once.zone_mm / twice.zone_mm - 1.0).abs() < 2e-9, "{once:?} {twice:?}");
    let same = plane(&[[1.0, 2.0, 3.0]; 40]);
    assert!(same.zone_mm < 1e-14 && same.termination.is_settled(), "{same:?}");
}

#[test]
fn exact_lattices() {
    let lattice = |z: &dyn Fn(i32, i32) -> f64| -> Vec<PointMm> {
        (0..3600)
            .map(|i| (i % 60, i / 60))
            .map(|(x, y)| [f64::from(x), f64::from(y), z(x, y)])
            .collect()
    };
    let flat = plane(&lattice(&|_, _| 2.0));
    assert!(flat.zone_mm < 1e-13 && flat.termination.is_settled());
    // Steps of two heights: every point touches a border.
    let chess = plane(&lattice(&|x, y| f64::from((x + y) % 2) * 1e-3));
    assert!((chess.zone_mm - 1e-3).abs() < 1e-15, "{chess:?}");
    assert!(chess.termination.is_settled());
    // A step along the middle. With a slope of s steps a pitch the zone is 1 − s steps wide as long as the near
    // corner of the high half is its highest point, up to s = 1/30, and 59·s − 1 from there on.
    let step = plane(&lattice(&|x, _| if x < 30 { 0.0 } else { 1e-3 }));
    assert!(step.termination.is_settled());
    let width = 29.0 / 30.0 * 1e-3;
    assert!((step.zone_mm / width - 1.0).abs() < 2e-9, "{:e} {width:e}", step.zone_mm);
}

#[test]
fn collinear_points_have_the_zone_of_their_profile() {
    // Heights 0, 1, 0 over a line: the middle stands 1 above the chord.
    let points: Vec<PointMm> = [0.0, 1.0, 0.0, 0.4]
        .iter()
        .zip([0.0, 5.0, 10.0, 7.0])
        .map(|(z, s)| [0.6 * s, 0.8 * s, z * 1e-3])
        .collect();
    let found = plane(&points);
    assert!((found.zone_mm - 1e-3).abs() < 1e-15, "{found:?}");
    assert_eq!(found.indeterminate.len(), 3);
    assert!(found.termination.is_settled());
}

#[test]
fn one_outlier_of_a_millimetre() {
    // Over the middle of a flat square the plane cannot give way: the zone is as high as the outlier.
    let mut points: Vec<PointMm> =
        (0..441).map(|i| [f64::from(i % 21 - 10), f64::from(i / 21 - 10), 0.0]).collect();
    points[220][2] = 1.0;
    let found = plane(&points);
    assert!((found.zone_mm - 1.0).abs() < 1e-14, "{found:?}");
    assert!(found.contacts.iter().any(|contact| contact.index == 220));

    let mut points = lens(20_000);
    points[11_000][2] += 1.0;
    for criterion in [Criterion::Range, Criterion::Centred] {
        let settings = ZoneSettings { criterion, ..ZoneSettings::default() };
        let found = minimum_zone(&points, &al1815(), &settings).unwrap();
        eprintln!("outlier: {:?} {:?} {:?}", found.zone_mm, found.termination, found.certificate);
        assert!(found.termination.is_settled(), "{found:?}");
        assert!(found.contacts.iter().any(|contact| contact.index == 11_000));
    }
}

#[test]
fn excluded_points_are_counted_and_indices_are_those_given() {
    let mut points: Vec<PointMm> =
        vec![[f64::NAN, 0.0, 0.0], [0.0, 0.0, f64::INFINITY], [50.0, 0.0, 9.0]];
    points.extend([[2., 2., 3.], [-2., -2., 3.], [2., -2., 1.], [-2., 2., 1.], [0., 1., 2.]]);
    let fit =
        FitSettings { aperture: Aperture::Circle { radius_mm: 10.0 }, ..FitSettings::default() };
    let settings = ZoneSettings { fit, ..ZoneSettings::default() };
    let found = minimum_zone(&points, &Nominal::Plane, &settings).unwrap();
    let excluded = Excluded { not_finite: 2, outside_aperture: 1, outside_domain: 0 };
    assert_eq!((found.used, found.excluded), (5, excluded));
    let indices: Vec<usize> = found.contacts.iter().map(|contact| contact.index).collect();
    assert_eq!(indices, [3, 4, 5, 6]);
    assert_eq!(
        minimum_zone(&points[..2], &Nominal::Plane, &settings),
        Err(FitError::NoPoints { given: 2 })
    );
}

#[test]
fn huge_offsets_cost_only_their_rounding() {
    let mut noise = Noise::new(8);
    let near: Vec<PointMm> =
        spiral(3_000, 10.0).into_iter().map(|[x, y]| [x, y, 1e-3 * noise.next()]).collect();
    let expected = plane(&near).zone_mm;
    for offset in [1e4, 1e6] {
        let far: Vec<PointMm> =
            near.iter().map(|&[x, y, z]| [x + offset, y - offset, z + offset]).collect();
        let found = plane(&far);
        assert!(found.termination.is_settled(), "{found:?}");
        let off = (found.zone_mm - expected).abs();
        eprintln!("offset {offset:e}: zone off by {off:e} mm, {} passes", found.certificate.scans);
        assert!(off < 1e-15 * offset, "{off:e}");
    }
}

#[test]
fn a_limit_of_passes_is_told() {
    let settings = ZoneSettings { max_scans: 2, ..ZoneSettings::default() };
    let found = minimum_zone(&lens(60_000), &al1815(), &settings).unwrap();
    let ZoneTermination::MaxScans { limit: 2, gap_mm } = found.termination else {
        panic!("{:?}", found.termination)
    };
    assert!(gap_mm > 0.0 && gap_mm < found.zone_mm);
    assert_eq!(gap_mm, found.certificate.gap_mm);
}

#[test]
fn settings_fail_as_those_of_the_fit() {
    let fit = FitSettings { free: vec![Parameter::Radius], ..FitSettings::default() };
    let settings = ZoneSettings { fit, ..ZoneSettings::default() };
    assert_eq!(
        minimum_zone(&lens(10), &Nominal::Plane, &settings),
        Err(FitError::NoSuchParameter { parameter: Parameter::Radius, kind: "plane" })
    );
}
