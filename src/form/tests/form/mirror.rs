//! A measured X-ray mirror, a hyperbolic cylinder, and its fits.

use std::path::PathBuf;
use std::sync::Arc;

use asphera_form::shape::Mirror;
use asphera_form::{Fit, FitSettings, Nominal, Parameter, PointMm, fit};

/// The points of the file, or `None` where the shared data are absent.
pub(crate) fn mirror() -> Option<Vec<PointMm>> {
    let data = std::env::var_os("ASPHERA_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let path = data.join("mirrors/xmf_02_hyperbolic_cylinder.xyz");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} not found", path.display());
        return None;
    };
    let point = |line: &str| {
        let mut numbers = line.split_whitespace().map(|number| number.parse().unwrap());
        std::array::from_fn(|_| numbers.next().unwrap())
    };
    Some(text.lines().map(point).collect())
}

/// p, q and θ of the design: the source is virtual, for the mirror is a hyperbolic cylinder.
pub(crate) const DESIGN: [f64; 3] = [-306.0, 115.0, 4.6e-3];
/// Its parameters.
pub(crate) const SHAPE: [Parameter; 3] =
    [Parameter::Shape(0), Parameter::Shape(1), Parameter::Shape(2)];

/// The map about the centre its authors give, laid on the design with more parameters free.
pub(crate) fn hyperbolic(points: &[PointMm], shift_mm: f64, free: &[Parameter]) -> Fit {
    let centred: Vec<PointMm> =
        points.iter().map(|&[x, y, z]| [x - 28.512 - shift_mm, y - 3.312, z]).collect();
    let [p, q, theta] = DESIGN;
    let design = Nominal::Freeform(Arc::new(Mirror::cylindrical(p, q, theta).unwrap()));
    let pose = [Parameter::Tz, Parameter::Rx, Parameter::Ry, Parameter::Rz];
    let settings = FitSettings { free: [&pose, free].concat(), ..FitSettings::default() };
    let fitted = fit(&centred, &design, &settings).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    fitted
}
