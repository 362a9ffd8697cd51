//! From the tables of a file to a scene: words become types.

use std::time::Duration;

use asphera_form::form_error::{FormError, Ring};
use asphera_form::{Asphere, Nominal, Parameter, Pose, Tolerance};

use super::Scene;
use crate::document::{
    Document, FaultTable, FormErrorTable, PartTable, ScanTable, StageTable, SurfaceTable,
};
use crate::fault::Scheduled;
use crate::motion::Motion;
use crate::{Fault, SceneError, Speed};

/// Errors of one scene.
pub(super) struct Place<'a>(pub(super) &'a str);

impl Place<'_> {
    pub(super) fn wrong(
        &self,
        key: impl Into<String>,
        expected: impl Into<String>,
        found: impl ToString,
    ) -> SceneError {
        SceneError::Value {
            scene: self.0.to_owned(),
            key: key.into(),
            expected: expected.into(),
            found: found.to_string(),
        }
    }
}

pub(super) fn scene(name: &str, document: Document) -> Result<Scene, SceneError> {
    let place = Place(name);
    let nominal = nominal(&place, &document.part.surface)?;
    let free = free(&place, &document.fit.free, &nominal)?;
    let (points, rate_hz, motion) = motion(&document.scan, &document.stage);
    let faults = document.fault.iter().enumerate();
    let mut faults: Vec<Scheduled> =
        faults.map(|(index, table)| fault(&place, index, table)).collect::<Result<_, _>>()?;
    // A stable sort: faults of one trigger happen in the order of the file.
    faults.sort_by_key(|fault| fault.at_point);
    Ok(Scene {
        name: name.to_owned(),
        title: document.title,
        seed: document.seed,
        speed: Speed::Times(1.0),
        nominal,
        semi_diameter_mm: document.part.semi_diameter_mm,
        pose: pose(&document.part),
        form_error: form_error(&document.part),
        free,
        tolerance: Tolerance { pv_nm: document.tolerance.pv_nm, rms_nm: document.tolerance.rms_nm },
        points,
        rate_hz,
        motion,
        noise_nm: document.probe.noise_nm,
        standoff_mm: document.probe.standoff_mm,
        full_scale_um: document.probe.full_scale_um,
        intensity: document.probe.intensity,
        node_ids: document.stage.node_ids,
        thermal: document.thermal,
        faults,
    })
}

fn nominal(place: &Place<'_>, table: &SurfaceTable) -> Result<Nominal, SceneError> {
    let nominal =
        match table {
            SurfaceTable::Plane {} => Nominal::Plane,
            SurfaceTable::Sphere { radius_mm } => Nominal::Sphere { radius_mm: *radius_mm },
            SurfaceTable::Asphere { radius_mm, conic, coefficients } => {
                let terms = coefficients.iter().map(|(name, &value)| match name.parse() {
                    Ok(Parameter::A(order)) => Ok((order, value)),
                    _ => Err(place.wrong("part.surface.coefficients", "A4, A6 to A20", name)),
                });
                let terms: Vec<(u8, f64)> = terms.collect::<Result<_, _>>()?;
                let asphere = Asphere::new(*radius_mm, *conic, &terms);
                Nominal::Asphere(asphere.map_err(|error| {
                    place.wrong("part.surface", "an asphere that can be", error)
                })?)
            }
        };
    match nominal.validate() {
        Ok(()) => Ok(nominal),
        Err(error) => Err(place.wrong("part.surface", "a surface that can be", error)),
    }
}

fn free(
    place: &Place<'_>,
    names: &[String],
    nominal: &Nominal,
) -> Result<Vec<Parameter>, SceneError> {
    let mut free = Vec::with_capacity(names.len());
    for name in names {
        let parameter: Parameter =
            name.parse().map_err(|error| place.wrong("fit.free", "names of parameters", error))?;
        if !nominal.has(parameter) {
            let expected = format!("parameters of a {}", nominal.kind());
            return Err(place.wrong("fit.free", expected, name));
        }
        if free.contains(&parameter) {
            return Err(place.wrong("fit.free", "each parameter once", format!("{name} twice")));
        }
        free.push(parameter);
    }
    Ok(free)
}

fn pose(part: &PartTable) -> Pose {
    let table = part.pose;
    Pose {
        tx_mm: table.tx_mm,
        ty_mm: table.ty_mm,
        tz_mm: table.tz_mm,
        rx_rad: table.rx_rad,
        ry_rad: table.ry_rad,
        rz_rad: table.rz_rad,
    }
}

fn form_error(part: &PartTable) -> FormError {
    let none = FormErrorTable { fringe: Vec::new(), ring: None };
    let table = part.form_error.as_ref().unwrap_or(&none);
    FormError {
        radius_mm: part.semi_diameter_mm,
        fringe_nm: table.fringe.iter().map(|term| (term.index, term.height_nm)).collect(),
        ring: table.ring.map(|ring| Ring {
            radius_mm: ring.radius_mm,
            width_mm: ring.width_mm,
            height_nm: ring.height_nm,
        }),
    }
}

fn motion(scan: &ScanTable, stage: &StageTable) -> (u64, f64, Motion) {
    let step_nm = stage.step_nm;
    match *scan {
        ScanTable::Spiral { points, rate_hz, radius_mm, counts_per_turn } => {
            (points, rate_hz, Motion::Spiral { radius_mm, counts_per_turn, step_nm })
        }
        ScanTable::Raster { points, rate_hz, half_width_mm } => {
            (points, rate_hz, Motion::Raster { half_width_mm, step_nm })
        }
    }
}

fn fault(place: &Place<'_>, index: usize, table: &FaultTable) -> Result<Scheduled, SceneError> {
    let key = |key: &str| format!("fault[{index}].{key}");
    let duration = || match table.duration_s {
        Some(duration_s) if (1e-3..=3600.0).contains(&duration_s) => {
            Ok(Duration::from_secs_f64(duration_s))
        }
        Some(duration_s) => Err(place.wrong(key("duration_s"), "0.001 to 3600 s", duration_s)),
        None => Err(place.wrong(key("duration_s"), "a time in s", "nothing")),
    };
    // Beside link, at_point and kind, each kind has keys of its own and no others.
    let (fault, keys): (Fault, &[&str]) = match table.kind.as_str() {
        "unplug" => {
            let restart = table.restart.unwrap_or(false);
            (Fault::Unplug { duration: duration()?, restart }, &["duration_s", "restart"])
        }
        "silent" => (Fault::Silent { duration: duration()? }, &["duration_s"]),
        "noise" => {
            let bytes = table.bytes.unwrap_or(0);
            if !(1..=MAX_NOISE_BYTES).contains(&bytes) {
                return Err(place.wrong(key("bytes"), "1 to 1000000", bytes));
            }
            (Fault::Noise { bytes }, &["bytes"])
        }
        "emergency" => {
            let Some((code, register)) = table.code.zip(table.register) else {
                return Err(place.wrong(key("code"), "code and register", "not both"));
            };
            (Fault::Emergency { code, register }, &["code", "register"])
        }
        "drop" => (Fault::Drop, &[]),
        "restart" => (Fault::Restart, &[]),
        other => {
            let expected = "unplug, silent, noise, emergency, drop or restart";
            return Err(place.wrong(key("kind"), expected, format!("{other:?}")));
        }
    };
    let given = [
        ("duration_s", table.duration_s.is_some()),
        ("restart", table.restart.is_some()),
        ("bytes", table.bytes.is_some()),
        ("code", table.code.is_some()),
        ("register", table.register.is_some()),
    ];
    if let Some((extra, _)) = given.iter().find(|(name, is)| *is && !keys.contains(name)) {
        return Err(place.wrong(key(extra), format!("no such key for {}", table.kind), "one"));
    }
    Ok(Scheduled { at_point: table.at_point, link: table.link, fault })
}

/// Noise is made in memory at once.
const MAX_NOISE_BYTES: usize = 1_000_000;
