//! From the tables of a file to a scene: words become types. What is absent, unknown or of the wrong kind is
//! reported here; ranges are checked afterwards.
//!
//! `scenes/asphere.toml` says what each key means.

use std::time::Duration;

use asphera_form::artefact::Artefact;
use asphera_form::form_error::{FormError, Ring};
use asphera_form::{Asphere, Nominal, Parameter, Pose};
use asphera_settings::{File, Section as Table};

use super::{Limits, Protocol, Scene, SceneError, Thermal};
use crate::fault::Scheduled;
use crate::motion::Motion;
use crate::part::settle;
use crate::section::Section;
use crate::{Fault, Link, Speed};

/// Reads a scene of another kind; `None` where the file has no table `kind`. `name` stands in errors.
///
/// # Errors
///
/// All that is wrong, each with its line and key.
pub(crate) fn scene_with<T>(
    kind: &str,
    name: &str,
    text: &str,
    scene: impl FnOnce(&Table<'_>) -> Option<T>,
) -> Option<Result<T, SceneError>> {
    let file = File::parse(name, text).ok()?;
    let root = file.root();
    if !root.has(kind) {
        return None;
    }
    let scene = scene(&root);
    root.finish();
    drop(root);
    let unusable = |problems| SceneError::File { scene: name.to_owned(), problems };
    Some(file.conclude(scene).map_err(unusable))
}

/// Reads the whole file; `None` if something is missing, and the tables say what.
pub(super) fn scene(name: &str, root: &Table<'_>) -> Option<Scene> {
    let title = root.required("title");
    let seed = root.required("seed");
    let part = part(&root.section("part"));
    let fit = root.section("fit");
    let nominal = part.as_ref().map(|part| &part.nominal);
    let free = free(&fit, nominal);
    fit.finish();
    let tolerance = root.section("tolerance");
    let limits = Limits { pv_nm: tolerance.get("pv_nm"), rms_nm: tolerance.get("rms_nm") };
    tolerance.finish();
    let stage = root.section("stage");
    let node_ids = stage.required("node_ids");
    let scan = root.section("scan");
    let (points, rate_hz) = (scan.required("points"), scan.required("rate_hz"));
    let motion = motion(&scan, stage.required("step_nm"));
    stage.finish();
    let probe = root.section("probe");
    let (noise_nm, standoff_mm) = (probe.required("noise_nm"), probe.required("standoff_mm"));
    let (full_scale_um, intensity) = (probe.required("full_scale_um"), probe.required("intensity"));
    let protocols = [("dollar", Protocol::Dollar), ("packets", Protocol::Packets)];
    let protocol = probe.word("protocol", Protocol::Dollar, &protocols);
    probe.finish();
    let thermal = root.section("thermal");
    let thermal = thermal.is_present().then(|| thermometer(&thermal));
    let faults: Vec<Option<Scheduled>> = root.array("fault").iter().map(fault).collect();
    root.finish();
    let part = part?;
    Some(Scene {
        name: name.to_owned(),
        title: title?,
        seed: seed?,
        speed: Speed::Times(1.0),
        nominal: part.nominal,
        semi_diameter_mm: part.semi_diameter_mm,
        pose: part.pose,
        form_error: part.form_error,
        free: free?,
        tolerance: limits,
        points: points?,
        rate_hz: rate_hz?,
        motion: motion?,
        noise_nm: noise_nm?,
        standoff_mm: standoff_mm?,
        full_scale_um: full_scale_um?,
        protocol,
        intensity: intensity?,
        node_ids: node_ids?,
        thermal: match thermal {
            Some(thermal) => Some(thermal?),
            None => None,
        },
        faults: faults.into_iter().collect::<Option<_>>()?,
    })
}

/// Part of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub(crate) nominal: Nominal,
    pub(crate) semi_diameter_mm: f64,
    pub(crate) pose: Pose,
    pub(crate) form_error: FormError,
}

impl Part {
    /// Height of the part in mm over a place of its frame, (x, y) in mm; `None` beside it.
    pub(crate) fn height_mm(&self, [x_mm, y_mm]: [f64; 2]) -> Option<f64> {
        if x_mm.hypot(y_mm) > self.semi_diameter_mm {
            return None;
        }
        let error_mm = |x_mm: f64, y_mm: f64| self.form_error.height_nm(x_mm, y_mm) * 1e-6;
        let part = Artefact::new(self.nominal.clone(), self.pose, &[], &[], error_mm).ok()?;
        let mut place = [[x_mm, y_mm]];
        settle(&part, &[[x_mm, y_mm]], &mut place).ok()?;
        Some(part.point_mm(place[0][0], place[0][1])?[2])
    }
}

/// Reads the table `part`.
pub(crate) fn part(table: &Table<'_>) -> Option<Part> {
    let surface = table.section("surface");
    let nominal = nominal(table, &surface);
    let semi_diameter_mm = table.required("semi_diameter_mm");
    let pose = table.section("pose");
    let number = |key| pose.or(key, 0.0);
    let place = Pose {
        tx_mm: number("tx_mm"),
        ty_mm: number("ty_mm"),
        tz_mm: number("tz_mm"),
        rx_rad: number("rx_rad"),
        ry_rad: number("ry_rad"),
        rz_rad: number("rz_rad"),
    };
    pose.finish();
    let form_error = form_error(&table.section("form_error"), semi_diameter_mm);
    table.finish();
    Some(Part {
        nominal: nominal?,
        semi_diameter_mm: semi_diameter_mm?,
        pose: place,
        form_error: form_error?,
    })
}

/// Without a kind nobody knows which keys there may be.
fn nominal(part: &Table<'_>, surface: &Table<'_>) -> Option<Nominal> {
    let words = ["asphere", "sphere", "plane"].map(|word| (word, word));
    let nominal = match surface.required_word("kind", &words)? {
        "plane" => Some(Nominal::Plane),
        "sphere" => surface.required("radius_mm").map(|radius_mm| Nominal::Sphere { radius_mm }),
        _ => asphere(part, surface).map(Nominal::Asphere),
    };
    surface.finish();
    let nominal = nominal?;
    let valid = nominal.validate();
    valid.inspect_err(|error| part.problem("surface", "values that make a surface", error)).ok()?;
    Some(nominal)
}

fn asphere(part: &Table<'_>, surface: &Table<'_>) -> Option<Asphere> {
    let (radius_mm, conic) = (surface.required("radius_mm"), surface.or("conic", 0.0));
    let coefficients = surface.section("coefficients");
    let terms = coefficients.numbered("A");
    coefficients.finish();
    let names = || terms.iter().map(|(order, _)| format!("A{order}"));
    if let Some(name) = names().find(|name| !matches!(name.parse(), Ok(Parameter::A(_)))) {
        coefficients.problem(&name, "A4, A6 to A20", &name);
        return None;
    }
    let asphere = Asphere::new(radius_mm?, conic, &terms);
    asphere.inspect_err(|error| part.problem("surface", "an asphere that can be", error)).ok()
}

/// `nominal` is not there if its own table has problems.
fn free(table: &Table<'_>, nominal: Option<&Nominal>) -> Option<Vec<Parameter>> {
    let names: Vec<String> = table.required("free")?;
    let mut free = Vec::with_capacity(names.len());
    for name in &names {
        let Ok(parameter) = name.parse::<Parameter>() else {
            table.problem("free", "names of parameters", format!("{name:?}"));
            continue;
        };
        if let Some(nominal) = nominal.filter(|nominal| !nominal.has(parameter)) {
            table.problem("free", format!("parameters of a {}", nominal.kind()), name);
        }
        if free.contains(&parameter) {
            table.problem("free", "each parameter once", format!("{name} twice"));
        }
        free.push(parameter);
    }
    Some(free)
}

fn form_error(table: &Table<'_>, semi_diameter_mm: Option<f64>) -> Option<FormError> {
    let fringe: Vec<Option<(u8, f64)>> = table
        .array("fringe")
        .iter()
        .map(|term| {
            let (index, height_nm) = (term.required("index"), term.required("height_nm"));
            term.finish();
            Some((index?, height_nm?))
        })
        .collect();
    let ring = table.section("ring");
    let ring = ring.is_present().then(|| {
        let (radius_mm, width_mm) = (ring.required("radius_mm"), ring.required("width_mm"));
        let height_nm = ring.required("height_nm");
        ring.finish();
        Some(Ring { radius_mm: radius_mm?, width_mm: width_mm?, height_nm: height_nm? })
    });
    table.finish();
    Some(FormError {
        radius_mm: semi_diameter_mm?,
        fringe_nm: fringe.into_iter().collect::<Option<_>>()?,
        ring: match ring {
            Some(ring) => Some(ring?),
            None => None,
        },
    })
}

/// The last keys of the table. Without a kind nobody knows which there may be.
fn motion(scan: &Table<'_>, step_nm: Option<u32>) -> Option<Motion> {
    let words = ["spiral", "raster", "section", "ball"].map(|word| (word, word));
    let motion = match scan.required_word("kind", &words)? {
        "spiral" => {
            let (radius_mm, counts) =
                (scan.required("radius_mm"), scan.required("counts_per_turn"));
            radius_mm.zip(counts).zip(step_nm).map(|((radius_mm, counts_per_turn), step_nm)| {
                Motion::Spiral { radius_mm, counts_per_turn, step_nm }
            })
        }
        "ball" => step_nm.map(|step_nm| Motion::Ball { step_nm }),
        "section" => {
            let (chord_mm, naca) = (scan.required("chord_mm"), scan.required("naca"));
            let noise_nm: Option<f64> = scan.required("noise_nm");
            let section = chord_mm.zip(naca).map(|(chord_mm, naca)| Section { chord_mm, naca });
            section.zip(noise_nm).zip(step_nm).map(|((section, noise_nm), step_nm)| {
                Motion::Section { section, noise_nm, step_nm }
            })
        }
        _ => {
            let half_width_mm = scan.required("half_width_mm").zip(step_nm);
            half_width_mm.map(|(half_width_mm, step_nm)| Motion::Raster { half_width_mm, step_nm })
        }
    };
    scan.finish();
    motion
}

fn thermometer(table: &Table<'_>) -> Option<Thermal> {
    let (unit_id, mean_degc) = (table.required("unit_id"), table.required("mean_degc"));
    let (amplitude_degc, period_s) = (table.required("amplitude_degc"), table.required("period_s"));
    table.finish();
    Some(Thermal {
        unit_id: unit_id?,
        mean_degc: mean_degc?,
        amplitude_degc: amplitude_degc?,
        period_s: period_s?,
    })
}

/// Beside link, at_point and kind, each kind has keys of its own and no others.
fn fault(table: &Table<'_>) -> Option<Scheduled> {
    let links = [Link::Probe, Link::Stage, Link::Thermal].map(|link| (link.name(), link));
    let link = table.required_word("link", &links);
    let at_point = table.required("at_point");
    let words =
        ["unplug", "silent", "noise", "emergency", "drop", "restart"].map(|word| (word, word));
    // Without a kind nobody knows which keys there may be.
    let fault = match table.required_word("kind", &words)? {
        "unplug" => {
            let restart = table.or("restart", false);
            duration(table).map(|duration| Fault::Unplug { duration, restart })
        }
        "silent" => duration(table).map(|duration| Fault::Silent { duration }),
        "noise" => {
            table.required::<usize>("bytes");
            Some(Fault::Noise { bytes: table.within("bytes", 1, 1..=MAX_NOISE_BYTES) })
        }
        "emergency" => {
            let (code, register) = (table.required("code"), table.required("register"));
            code.zip(register).map(|(code, register)| Fault::Emergency { code, register })
        }
        "drop" => Some(Fault::Drop),
        _ => Some(Fault::Restart),
    };
    table.finish();
    Some(Scheduled { at_point: at_point?, link: link?, fault: fault? })
}

fn duration(table: &Table<'_>) -> Option<Duration> {
    let duration_s: f64 = table.required("duration_s")?;
    if !(1e-3..=3600.0).contains(&duration_s) {
        table.problem("duration_s", "0.001 to 3600 s", duration_s);
        return None;
    }
    Some(Duration::from_secs_f64(duration_s))
}

/// Noise is made in memory at once.
const MAX_NOISE_BYTES: usize = 1_000_000;
