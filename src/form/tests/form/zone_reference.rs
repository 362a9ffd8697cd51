//! Minimum zones against linear programs of SciPy's HiGHS: `tests/minimum_zone.py` made
//! `tests/minimum_zone.txt`, and makes it anew where `ASPHERA_PYTHON` (by default `python3`) has SciPy.

use std::process::Command;

use asphera_form::{
    Asphere, Criterion, FitSettings, Nominal, Parameter, PointMm, Pose, ZoneSettings, minimum_zone,
};

use crate::common::al1815;
use crate::reference::{lens_pose, made};

struct Case {
    name: &'static str,
    points: Vec<PointMm>,
    begin: Nominal,
    start: Pose,
    free: Vec<Parameter>,
    criterion: Criterion,
}

fn cases() -> Vec<Case> {
    let rigid = Parameter::RIGID.to_vec();
    let shape = [&rigid[..], &[Parameter::Radius, Parameter::Conic]].concat();
    let centre = vec![Parameter::Tx, Parameter::Ty, Parameter::Tz];
    let with_radius = [&centre[..], &[Parameter::Radius]].concat();
    let lens = made(400, 9.0, &al1815(), 1e-3, &lens_pose());
    let Nominal::Asphere(asphere) = al1815() else { unreachable!() };
    let other = Nominal::Asphere(Asphere { radius_mm: 11.7, conic: -1.05, ..asphere });
    let ball = Nominal::Sphere { radius_mm: -40.0 };
    let far = Pose { tx_mm: 120.0, ty_mm: -80.0, tz_mm: 15.0, ..Pose::default() };
    let cap = made(300, 12.0, &ball, 1e-2, &far);
    let tilted = Pose { tz_mm: 7.0, rx_rad: 0.3, ry_rad: -0.2, ..Pose::default() };
    let flat = made(500, 12.0, &Nominal::Plane, 1e-3, &tilted);
    let case = |name, points: &[PointMm], begin, free: &[Parameter], criterion| Case {
        name,
        points: points.to_vec(),
        begin,
        start: Pose::default(),
        free: free.to_vec(),
        criterion,
    };
    use Criterion::{Centred, Range};
    vec![
        case("asphere_range", &lens, al1815(), &rigid, Range),
        case("asphere_centred", &lens, al1815(), &rigid, Centred),
        case("asphere_shape", &lens, other, &shape, Centred),
        case("sphere_free", &cap, Nominal::Sphere { radius_mm: -40.5 }, &with_radius, Range),
        case("sphere_range", &cap, ball, &centre, Range),
        case("plane", &flat, Nominal::Plane, &[Parameter::Tz, Parameter::Rx, Parameter::Ry], Range),
    ]
}

/// Widths within 1e-9, parameters within 1e-8 mm, rad or 1.
fn compare(table: &str) {
    for Case { name, points, begin, start, free, criterion } in cases() {
        let line = table.lines().find(|line| line.split(' ').next() == Some(name)).unwrap();
        let numbers = line.split(' ').skip(1).map(|number| number.parse().unwrap());
        let expected: Vec<f64> = numbers.collect();
        assert_eq!(expected.len(), free.len() + 2);
        let fit = FitSettings { free: free.clone(), start, ..FitSettings::default() };
        let settings = ZoneSettings { fit, criterion, ..ZoneSettings::default() };
        let found = minimum_zone(&points, &begin, &settings).unwrap();
        assert!(found.termination.is_settled(), "{name}: {found:?}");
        let zone = found.zone_mm / expected[free.len() + 1] - 1.0;
        let mut off = (found.offset_mm - expected[free.len()]).abs();
        for (parameter, expected) in free.iter().zip(&expected) {
            let value = parameter.value(&found.pose, &found.nominal).unwrap();
            off = off.max((value - expected).abs());
        }
        eprintln!("{name}: zone off by a share of {zone:.0e}, parameters by {off:.0e}");
        assert!(zone.abs() < 1e-9, "{name}: {zone:e}");
        assert!(off < 1e-8, "{name}: {off:e}");
    }
}

#[test]
fn committed_zones() {
    compare(include_str!("../minimum_zone.txt"));
}

#[test]
fn zones_made_anew() {
    let python = std::env::var_os("ASPHERA_PYTHON").unwrap_or_else(|| "python3".into());
    let imported = Command::new(&python).args(["-c", "import numpy, scipy"]).output();
    if !imported.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: {} with numpy and scipy not found", python.display());
        return;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/minimum_zone.py");
    let output = Command::new(&python).args(["-B", script]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    compare(&String::from_utf8(output.stdout).unwrap());
}
