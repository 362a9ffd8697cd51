//! Systematic errors of stations: which there are, and where they move points.

use asphera_calibrate::AxisErrors;
use asphera_measure::{Part, Pipeline};
use asphera_report::SystematicFigures;

use super::*;
use crate::station::{ErrorTable, Source};

fn axis(u: Option<f64>) -> Axis {
    let errors = AxisErrors::linear(vec![[-20.0, 0.0], [0.0, 0.0], [20.0, 0.0]]).unwrap();
    let errors = match u {
        Some(u) => errors.with_uncertainties(vec![u; 3]).unwrap(),
        None => errors,
    };
    let errors = Some(Arc::new(ErrorTable { file: "axis.csv".to_owned(), errors }));
    Axis { source: Some(Source { stream: 0, channel: 0 }), scale: 1.0, offset: 0.0, errors }
}

fn plain() -> Axis {
    Axis { errors: None, ..axis(None) }
}

fn calibration(machine: &str, parameters: &str) -> CalibrationFile {
    let text = format!(
        "format = \"asphera.calibration/1\"\nmade = \"2026-11-26T08:00:00Z\"\nmachine = \"{machine}\"\n{parameters}"
    );
    CalibrationFile::parse("c.toml", &text).unwrap()
}

/// What the sources add to a bowl with waves.
fn listed(all: Vec<Systematic>) -> Vec<SystematicFigures> {
    let mut pipeline = Pipeline::new(Part::new(asphera_form::Nominal::Sphere { radius_mm: 30.0 }));
    let side = || (-12..=12).map(|i| 0.5 * f64::from(i));
    let places = side().flat_map(|x| side().map(move |y| [x, y]));
    pipeline.take_positions(places.map(|[x, y]| {
        let waves_mm = 20e-6 * (1.1 * x).sin() * (0.7 * y).cos();
        [x, y, 30.0 - (900.0 - x * x - y * y).sqrt() + waves_mm]
    }));
    pipeline.know_systematic(all);
    pipeline.finish().report.form.unwrap().deviation.systematic
}

fn cartesian(x: Axis) -> Kinematics {
    Kinematics::Cartesian { x, y: plain(), z: plain() }
}

fn polar() -> Kinematics {
    Kinematics::Polar { rotary: plain(), radial: plain(), probe: plain() }
}

#[test]
fn each_source_is_listed_with_what_it_adds_or_why_not() {
    let parameters = "[parameters.scale_x]\nvalue_um_per_m = 100.0\nu_um_per_m = 10.0\n\
                      [parameters.squareness]\nvalue_urad = 0.0\nu_urad = 0.0\n";
    let calibration = calibration("cartesian", parameters);
    let thermal = ThermalFigures {
        part_degc: None,
        scales_degc: None,
        lengths_um_per_m: [0.0, 0.0],
        u_um_per_m: 5.0,
    };
    let found = |axis| {
        let kinematics = cartesian(axis);
        let all = systematic(&kinematics, Sides::default(), Some(&calibration), Some(&thermal));
        listed(all)
    };
    let rows = found(axis(Some(200e-6)));
    let sources: Vec<&str> = rows.iter().map(|row| &row.source[..]).collect();
    let absent = "calibration: scale_y, scale_z, tilt_x, tilt_y";
    let expected = [
        "calibration: scale_x",
        "calibration: squareness",
        absent,
        "error table axis.csv",
        "thermal expansion",
    ];
    assert_eq!(sources, expected);
    assert!(rows[0].u_rms_nm.unwrap() > 0.5, "{:?}", rows[0]);
    assert_eq!((rows[1].u_rms_nm, rows[1].u_pv_nm), (Some(0.0), Some(0.0)));
    assert!(rows[2].not_counted.is_some() && rows[2].u_pv_nm.is_none());
    assert!(rows[3].u_rms_nm.unwrap() > 0.2, "{:?}", rows[3]);
    // The radius is 150 nm larger: over angles up to 16.4° that leaves 150·(1 − cos 16.4°) = 6.1 nm at most, and the extremes of the
    // waves, at 1.5 and 4.7 mm from the middle, lie apart by 1.7 nm of it.
    assert!((0.5..1.7).contains(&rows[4].u_pv_nm.unwrap()), "{:?}", rows[4]);
    let without = found(axis(None));
    assert_eq!(without[3].not_counted.as_deref(), Some("it has no column u"));
    // A machine without any of it has nothing to list.
    let none = systematic(&cartesian(plain()), Sides::default(), None, None);
    assert!(none.is_empty());
}

/// A radial offset moves points outwards before the centre and inwards beyond it; on both sides it is not known which.
#[test]
fn the_side_of_the_centre_counts() {
    let parameters = "[parameters.offset_radial]\nvalue_um = 0.0\nu_um = 1.0\n\
                      [parameters.scale_radial]\nvalue_um_per_m = 0.0\nu_um_per_m = 10.0\n";
    let calibration = calibration("polar", parameters);
    let rows = |before, beyond| {
        let sides = Sides { before, beyond };
        listed(systematic(&polar(), sides, Some(&calibration), None))
    };
    let (before, beyond, both) = (rows(true, false), rows(false, true), rows(true, true));
    for which in [0, 1] {
        let [one, other] = [&before, &beyond].map(|rows| rows[which].u_rms_nm.unwrap());
        assert!(one > 0.1 && (one - other).abs() < 0.01 * one, "{one} {other}");
        assert!(both[which].not_counted.as_ref().unwrap().contains("both sides"));
    }
}

#[test]
fn fields_of_a_polar_machine_lie_along_its_axes() {
    let parameter = Parameter::OffsetRadial;
    let at_mm = [3.0, 4.0, 1.0];
    for (beyond, expected) in [(false, [0.6, 0.8, 0.0]), (true, [-0.6, -0.8, 0.0])] {
        let found = parameter.displacement_mm(axes_at(Machine::Polar, beyond, at_mm));
        let off = (0..3).map(|axis| (found[axis] - expected[axis]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-15, "{found:?}");
    }
}

/// Scales that go together are an expansion, which is less than three scales of their own.
#[test]
fn correlations_of_a_calibration_count() {
    let scale = |of: &str| format!("[parameters.{of}]\nvalue_um_per_m = 0.0\nu_um_per_m = 10.0\n");
    let scales: String = ["scale_x", "scale_y", "scale_z"].map(scale).concat();
    let pair = |of: &str, with: &str| {
        format!("[[correlation]]\nof = \"{of}\"\nwith = \"{with}\"\nvalue = 1.0\n")
    };
    let pairs =
        pair("scale_x", "scale_y") + &pair("scale_x", "scale_z") + &pair("scale_y", "scale_z");
    let rows = |parameters: &str| {
        let calibration = calibration("cartesian", parameters);
        listed(systematic(&cartesian(plain()), Sides::default(), Some(&calibration), None))
    };
    let (apart, together) = (rows(&scales), rows(&format!("{scales}{pairs}")));
    assert_eq!(together[0].source, "calibration: scale_x, scale_y, scale_z");
    assert_eq!((apart.len(), together.len()), (4, 2));
    let thermal = ThermalFigures { u_um_per_m: 10.0, ..ThermalFigures::default() };
    let expansion = listed(systematic(&cartesian(plain()), Sides::default(), None, Some(&thermal)));
    let [one, other] = [&together[0], &expansion[0]].map(|row| row.u_pv_nm.unwrap());
    assert!((one / other - 1.0).abs() < 1e-6, "{one} {other}");
}
