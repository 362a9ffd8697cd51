//! Every profile of the DABAM library (Sanchez del Rio et al., J. Synchrotron Rad. 23 (2016) 665), fitted by the
//! shape its header names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use asphera_form::shape::Mirror;
use asphera_form::{Fit, FitSettings, Nominal, Parameter, PointMm, fit};

/// Image distance and grazing angle of a mirror.
const Q: Parameter = Parameter::Shape(1);
const THETA: Parameter = Parameter::Shape(2);

/// A profile with what its header says.
struct Profile {
    number: u32,
    /// In the words and letters of the header.
    shape: String,
    /// p, q in mm and θ of the header, if it has them.
    design: Option<[f64; 3]>,
    /// Heights over the middle of the scan, on the line y = 0.
    points: Vec<PointMm>,
}

/// One line of the table.
struct Row {
    number: u32,
    fitted: Fit,
    caution: &'static str,
}

fn folder() -> Option<PathBuf> {
    let data = std::env::var_os("ASPHERA_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let folder = data.join("mirrors/dabam");
    if !folder.is_dir() {
        eprintln!("skipped: {} not found", folder.display());
        return None;
    }
    Some(folder)
}

/// The value of a key of a flat JSON object, without quotes.
fn value<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let (_, after) = header.split_once(&format!("\"{key}\":"))?;
    let end = after.find([',', '\n', '}'])?;
    Some(after[..end].trim().trim_matches('"'))
}

fn number(header: &str, key: &str) -> Option<f64> {
    value(header, key)?.parse().ok()
}

/// Slopes, of formats 1 and 3, are integrated by trapezia; heights, of formats 2 and 4, are as they are.
fn profile(folder: &Path, number_of: u32) -> Profile {
    let path = folder.join(format!("dabam-{number_of:03}.txt"));
    let read = |path: &Path| String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned();
    let (header, data) = (read(&path), read(&path.with_extension("dat")));
    let factor = |key: &str| number(&header, key).unwrap();
    let skipped = factor("FILE_HEADER_LINES") as usize;
    let lines = data.lines().skip(skipped).filter(|line| !line.trim().is_empty());
    let samples = lines.map(|line| {
        let words = line.split([' ', '\t', ',', ';']).filter(|word| !word.is_empty());
        let columns: Vec<f64> = words.take(2).map(|word| word.parse().unwrap()).collect();
        [1e3 * factor("X1_FACTOR") * columns[0], factor("Y1_FACTOR") * columns[1]]
    });
    let samples: Vec<[f64; 2]> = samples.collect();
    let middle_mm = 0.5 * (samples[0][0] + samples[samples.len() - 1][0]);
    let holds_slopes = matches!(value(&header, "FILE_FORMAT"), Some("1" | "3"));
    let mut z_mm = 0.0;
    let mut before = samples[0];
    let point = |&[x_mm, ordinate]: &[f64; 2]| {
        if holds_slopes {
            z_mm += 0.5 * (before[1] + ordinate) * (x_mm - before[0]);
            before = [x_mm, ordinate];
        } else {
            z_mm = 1e3 * ordinate;
        }
        [x_mm - middle_mm, 0.0, z_mm]
    };
    let points = samples.iter().map(point).collect();
    let of_ellipse = |key: &str| number(&header, &format!("ELLIPSE_DESIGN_{key}"));
    let design = of_ellipse("P").zip(of_ellipse("Q")).zip(of_ellipse("THETA"));
    Profile {
        number: number_of,
        shape: value(&header, "SURFACE_SHAPE").unwrap().to_owned(),
        design: design.map(|((p, q), theta)| [1e3 * p, 1e3 * q, theta]),
        points,
    }
}

fn laid(points: &[PointMm], nominal: &Nominal, free: &[Parameter]) -> Fit {
    let settings = FitSettings { free: free.to_vec(), search: false, ..FitSettings::default() };
    let fitted = fit(points, nominal, &settings).unwrap();
    assert!(fitted.termination.is_converged(), "{nominal}: {:?}", fitted.termination);
    assert!(fitted.indeterminate.is_empty(), "{nominal}: {:?}", fitted.undetermined);
    assert_eq!((fitted.used, fitted.excluded.total()), (points.len(), 0));
    fitted
}

fn mirror([p_mm, q_mm, theta_rad]: [f64; 3]) -> Nominal {
    Nominal::Freeform(Arc::new(Mirror::cylindrical(p_mm, q_mm, theta_rad).unwrap()))
}

/// A circle that begins with the curvature of the best parabola.
fn circle(points: &[PointMm]) -> Fit {
    let n = points.len() as f64;
    let mean = |of: &dyn Fn(&PointMm) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x2, z) = (mean(&|[x, _, _]| x * x), mean(&|[_, _, z]| *z));
    let above = |[x, _, _]: &PointMm| x * x - x2;
    let curvature_per_mm =
        2.0 * mean(&|point| above(point) * (point[2] - z)) / mean(&|point| above(point).powi(2));
    let radius_mm = curvature_per_mm.recip();
    laid(points, &Nominal::Sphere { radius_mm }, &[Parameter::Tx, Parameter::Tz, Parameter::Radius])
}

fn row(profile: &Profile) -> Row {
    use Parameter::{Ry, Tx, Tz};
    let Profile { number, points, .. } = profile;
    let shape = profile.shape.to_lowercase();
    let (fitted, caution) = match (*number, profile.design) {
        (_, Some(_)) if shape.contains("detrended") => {
            (laid(points, &Nominal::Plane, &[Tz, Ry]), "its ellipse is taken off already")
        }
        // The data file says 499.14 mm, 4500 mm and 34.99 mrad.
        (6, Some([p, q, theta])) => (
            laid(points, &mirror([q, p, 10.0 * theta]), &[Tx, Tz, Ry]),
            "header has p and q exchanged and a tenth of the angle",
        ),
        (19, Some(design)) => (
            laid(points, &mirror(design), &[Tz, Ry, Q]),
            "its radius is that of q 8.2 m, not of 0.9 m: q free",
        ),
        (_, Some(design)) => (laid(points, &mirror(design), &[Tx, Tz, Ry]), ""),
        // `paraboloid of rotation … angle of incidence: 0.3deg; entrance arm: 17050mm`.
        (22, None) => {
            let design = [17_050.0, f64::INFINITY, 0.3_f64.to_radians()];
            let facing: Vec<PointMm> = points.iter().map(|&[x, y, z]| [x, y, -z]).collect();
            (laid(&facing, &mirror(design), &[Tz, Ry]), "a parabola seen from behind: sign changed")
        }
        (_, None) if shape.starts_with("elliptical") => {
            (laid(points, &Nominal::Plane, &[Tz, Ry]), "measured unbent: no ellipse to find")
        }
        (_, None) if shape == "plane" => (laid(points, &Nominal::Plane, &[Tz, Ry]), ""),
        (_, None) => (circle(points), ""),
    };
    Row { number: *number, fitted, caution }
}

/// The nominal in short, and what was free.
fn told(fitted: &Fit) -> String {
    let free = fitted.estimates.iter().map(|of| of.parameter.name(&fitted.nominal));
    let free = free.collect::<Vec<_>>().join(" ");
    let values: Vec<f64> = fitted
        .nominal
        .freeform()
        .map_or(vec![], |s| s.parameters().iter().map(|p| p.value).collect());
    match (<[f64; 3]>::try_from(values), fitted.nominal.radius_mm()) {
        (Ok([p, q, theta]), _) => {
            format!("p {p:.1} q {q:.1} mm theta {:.3} mrad; {free}", 1e3 * theta)
        }
        (_, Some(radius_mm)) => format!("circle, R {:.4e} m; {free}", 1e-3 * radius_mm),
        _ => format!("{}; {free}", fitted.nominal.kind()),
    }
}

fn rms_nm(fitted: &Fit) -> f64 {
    fitted.residuals.rms_mm * 1e6
}

/// No header names a shape that is not fitted, and no fit fails.
#[test]
fn every_profile_is_fitted_by_the_shape_it_names() {
    let Some(folder) = folder() else { return };
    let profiles: Vec<Profile> = (1..=59).map(|number| profile(&folder, number)).collect();
    let rows: Vec<Row> = profiles.iter().map(row).collect();
    eprintln!(
        " no  header                 fitted; free                                    rms/nm     PV/nm  caution"
    );
    for (profile, row) in profiles.iter().zip(&rows) {
        let told = told(&row.fitted);
        let pv_nm = (row.fitted.residuals.high_mm - row.fitted.residuals.low_mm) * 1e6;
        let rms_nm = rms_nm(&row.fitted);
        eprintln!(
            "{:03}  {:21}  {told:52}  {rms_nm:8.2}  {pv_nm:8.1}  {}",
            profile.number, profile.shape, row.caution
        );
        assert!(rms_nm.is_finite() && rms_nm > 0.0 && rms_nm < pv_nm);
    }
    let named = |name: &str| {
        let is_named = |profile: &&Profile| profile.shape.to_lowercase().starts_with(name);
        profiles.iter().filter(is_named).count()
    };
    let counts = ["elliptical", "toroid", "spherical", "cylindrical", "plane"].map(named);
    assert_eq!(counts, [8, 15, 9, 2, 25]);
    let of = |number: u32| &rows.iter().find(|row| row.number == number).unwrap().fitted;
    for (number, most_nm) in [(4, 1.1), (6, 10.0), (19, 1.0), (20, 2.5), (21, 7.6)] {
        assert!(rms_nm(of(number)) < most_nm, "{number}: {} nm", rms_nm(of(number)));
    }
    for (number, header_nm) in RMS_OF_HEADERS {
        let off = rms_nm(of(number)) / header_nm - 1.0;
        assert!(off.abs() < 0.02, "{number}: {} nm, header {header_nm}", rms_nm(of(number)));
    }
}

/// RMS heights in nm in the headers of profiles that are as long as what they were worked out from.
const RMS_OF_HEADERS: [(u32, f64); 10] = [
    (14, 15.372782),
    (15, 97.355965),
    (16, 36.539151),
    (17, 47.577432),
    (41, 10.854),
    (45, 62.0),
    (46, 55.0),
    (47, 64.0),
    (48, 34.0),
    (50, 27.0),
];

/// With p as designed and q and θ free, the middle of the scan being the pole.
#[test]
fn q_and_theta_of_the_elliptical_profiles() {
    let Some(folder) = folder() else { return };
    for (number, design) in [
        (4, [98_000.0, 75.5, 3.9e-3]),
        (6, [499.14, 4_500.0, 34.99e-3]),
        (20, [9_000.0, 350.0, 2.5_f64.to_radians()]),
        (21, [7_500.0, 2_500.0, 0.6_f64.to_radians()]),
    ] {
        let profile = profile(&folder, number);
        let free = [Parameter::Tz, Parameter::Ry, Q, THETA];
        let fitted = laid(&profile.points, &mirror(design), &free);
        let found = [fitted.estimates[2].value, fitted.estimates[3].value];
        let off = [found[0] / design[1] - 1.0, found[1] / design[2] - 1.0];
        eprintln!(
            "{number:03}: q {:.2} mm ({:+.2} %), theta {:.4} mrad ({:+.2} %), rms {:.2} nm",
            found[0],
            100.0 * off[0],
            1e3 * found[1],
            100.0 * off[1],
            rms_nm(&fitted)
        );
        assert!(off.iter().all(|off| off.abs() < 0.1), "{number}: {off:?}");
    }
}
