//! `asphera calibrate`: errors of a machine, from a measured ball or flat.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use asphera_calibrate::{
    Artefact, Axes, Calibration, Machine, Parameter, Pose, Settings, Term, calibrate,
};
use asphera_form::NM_PER_MM;
use asphera_report::words::counted;
use clap::{ArgGroup, Args};
use serde::Serialize;

use super::exit::Exit;
use super::files::refuse;
use super::output::{Failure, print, print_json};
use super::progress::Progress;
use super::source::{Source, is_recording, session_at};
use super::summary::short;
use super::text::TextArgs;
use super::usage::misused;
use crate::calibration::{LONGEST_DAYS, written};
use crate::clock::Clock;
use crate::replay::Playback;
use crate::whole_file::write_bytes;

#[derive(Args)]
#[command(group = ArgGroup::new("artefact").required(true).args(["sphere", "flat"]))]
pub(super) struct CalibrateArgs {
    /// Measurements of the artefact: sessions, of which the bare readings are taken, or files of uncorrected points.
    #[arg(required = true)]
    sources: Vec<PathBuf>,
    #[command(flatten)]
    text: TextArgs,
    /// Kind of machine: cartesian or polar. A session knows it. Points of a polar machine are those before the centre.
    #[arg(long, value_name = "KIND", value_parser = machine)]
    machine: Option<Machine>,
    /// The artefact is a sphere, seen from outside or inside: its radius by the certificate, mm.
    #[arg(long, value_name = "MM")]
    sphere: Option<f64>,
    /// Standard uncertainty of that radius, nm.
    #[arg(long, value_name = "NM", default_value_t = 0.0, requires = "sphere")]
    u_radius: f64,
    /// The artefact is a flat. Only errors of height are found with it.
    #[arg(long)]
    flat: bool,
    /// Turn of the artefact at each measurement, degrees counter-clockwise about z, as 0,90,180.
    #[arg(long, value_name = "DEG,…", value_delimiter = ',', allow_hyphen_values = true)]
    turn: Vec<f64>,
    /// Place of the flat's origin in the machine at each measurement, mm, as 0:0,5:0.
    #[arg(long, value_name = "X:Y,…", value_delimiter = ',', value_parser = place, allow_hyphen_values = true, requires = "flat")]
    shift: Vec<[f64; 2]>,
    /// Parameters to find; without it all of the machine, and none with a flat.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', value_parser = parameter)]
    parameters: Option<Vec<Parameter>>,
    /// Find errors of height of the machine as well: Zernike terms up to this radial order, 2 to 10.
    #[arg(long, value_name = "ORDER", default_value_t = 0, hide_default_value = true)]
    map: u32,
    /// Find the form of the artefact as well, up to this radial order, 2 to 10: measurements must differ by a turn or shift.
    #[arg(long, value_name = "ORDER", default_value_t = 0, hide_default_value = true)]
    form: u32,
    /// For how many days a station may use it.
    #[arg(long, value_name = "DAYS", default_value_t = 90, value_parser = clap::value_parser!(u32).range(1..=i64::from(LONGEST_DAYS)))]
    valid_days: u32,
    /// Where the calibration goes.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Overwrite --out if it is there.
    #[arg(long)]
    force: bool,
    /// Print the figures as one JSON object on stdout.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &CalibrateArgs) -> Result<Exit, Failure> {
    for source in &args.sources {
        if let Some(out) = &args.out {
            refuse(out, [source], args.force)?;
        }
    }
    let progress = Progress::start("calibrate");
    let (machine, poses) = measured(args, &progress)?;
    let artefact = match args.sphere {
        Some(radius_mm) => Artefact::Sphere { radius_mm, u_radius_mm: args.u_radius / NM_PER_MM },
        None => Artefact::Flat,
    };
    let parameters = args.parameters.clone().unwrap_or_else(|| match artefact {
        Artefact::Sphere { .. } => machine.parameters().to_vec(),
        Artefact::Flat => Vec::new(),
    });
    if artefact == Artefact::Flat && parameters.is_empty() && args.map < 2 && args.form < 2 {
        return Err(misused(
            "nothing to find: with a flat give --map ORDER, and --form ORDER for its own form",
        ));
    }
    let settings = Settings { parameters, map_order: args.map, form_order: args.form };
    progress.stage("fitting");
    let found = calibrate(machine, artefact, &poses, &settings)?;
    drop(progress);
    if let Some(out) = &args.out {
        let made = Clock::start().started_wall_ns();
        write_bytes(out, written(&found, artefact, made, args.valid_days))?;
    }
    if args.json {
        print_json(&CalibrationReport::new(&found))?;
    } else {
        print(&summary(&found, args.out.as_deref()));
    }
    Ok(Exit::Done)
}

/// The machine, and each measurement with where the artefact lay.
fn measured(args: &CalibrateArgs, progress: &Progress) -> Result<(Machine, Vec<Pose>), Failure> {
    let count = args.sources.len();
    for (name, given) in [("--turn", args.turn.len()), ("--shift", args.shift.len())] {
        if given != 0 && given != count {
            return Err(misused(format!(
                "expected {name} for each of the {}, found {given}",
                counted(count as u64, "measurement")
            )));
        }
    }
    let mut known = args.machine;
    let mut poses = Vec::new();
    for (index, path) in args.sources.iter().enumerate() {
        let path = &session_at(path)?;
        let axes = if is_recording(path) {
            let (machine, axes) = bare(path, progress)?;
            if let Some(other) = known.filter(|known| *known != machine) {
                return Err(format!(
                    "{} is of a {} machine, the others of a {} one",
                    path.display(),
                    machine.word(),
                    other.word()
                )
                .into());
            }
            known = Some(machine);
            axes
        } else {
            let machine = known.ok_or_else(|| {
                misused(format!(
                    "{} is a file of points: --machine says of which machine",
                    path.display()
                ))
            })?;
            let source = Source::open(path, &args.text, progress)?;
            source.points().map(|point_mm| Axes::of_point(machine, point_mm)).collect()
        };
        let turn_deg: f64 = args.turn.get(index).copied().unwrap_or(0.0);
        let shift_mm = args.shift.get(index).copied().unwrap_or([0.0; 2]);
        poses.push(Pose { axes, turn_rad: turn_deg.to_radians(), shift_mm });
    }
    let machine = known.ok_or("no measurement is given")?;
    Ok((machine, poses))
}

/// The bare readings of a session's axes at its good points.
fn bare(path: &Path, progress: &Progress) -> Result<(Machine, Vec<Axes>), Failure> {
    let (machine, playback) = Playback::open(path)?.bare()?;
    progress.count("replaying", None);
    let mut axes = Vec::new();
    playback.play(
        |_| {},
        |point| {
            progress.add(1);
            if point.is_good() {
                let [first, second, third] = point.position_mm;
                axes.push(match machine {
                    Machine::Cartesian => Axes::Cartesian(point.position_mm),
                    Machine::Polar => {
                        Axes::Polar { angle_rad: first, radius_mm: second, z_mm: third }
                    }
                });
            }
        },
    );
    Ok((machine, axes))
}

/// Figures of a calibration. Values of parameters are in the unit beside them.
#[derive(Debug, PartialEq, Serialize)]
struct CalibrationReport {
    format: &'static str,
    machine: &'static str,
    points: usize,
    parameters: Vec<ParameterReport>,
    undetermined: Vec<&'static str>,
    map: Vec<TermReport>,
    map_undetermined: Vec<(u32, i32)>,
    form: Vec<TermReport>,
    form_undetermined: Vec<(u32, i32)>,
    form_radius_mm: f64,
    form_rms_nm: Option<f64>,
    u_form_rms_nm: Option<f64>,
    radius_mm: Option<f64>,
    u_radius_nm: Option<f64>,
    before_nm: f64,
    after_nm: f64,
    inflation: f64,
}

#[derive(Debug, PartialEq, Serialize)]
struct ParameterReport {
    name: &'static str,
    unit: &'static str,
    value: f64,
    u: f64,
}

#[derive(Debug, PartialEq, Serialize)]
struct TermReport {
    n: u32,
    m: i32,
    value_nm: f64,
    u_nm: f64,
}

impl CalibrationReport {
    fn new(found: &Calibration) -> CalibrationReport {
        let parameters = found.parameters.iter().map(|estimate| {
            let quantity = estimate.parameter.quantity();
            ParameterReport {
                name: estimate.parameter.word(),
                unit: quantity.unit(),
                value: estimate.value * quantity.units(),
                u: estimate.u * quantity.units(),
            }
        });
        let terms = |terms: &[Term]| -> Vec<TermReport> {
            terms
                .iter()
                .map(|&Term { n, m, value_mm, u_mm }| TermReport {
                    n,
                    m,
                    value_nm: value_mm * NM_PER_MM,
                    u_nm: u_mm * NM_PER_MM,
                })
                .collect()
        };
        CalibrationReport {
            format: "asphera.calibrate/1",
            machine: found.correction.machine().word(),
            points: found.points,
            parameters: parameters.collect(),
            undetermined: found.undetermined.iter().map(|parameter| parameter.word()).collect(),
            map: terms(&found.map),
            map_undetermined: found.map_undetermined.clone(),
            form: terms(&found.form),
            form_undetermined: found.form_undetermined.clone(),
            form_radius_mm: found.form_radius_mm,
            form_rms_nm: found.form_rms_mm.map(|[rms, _]| rms * NM_PER_MM),
            u_form_rms_nm: found.form_rms_mm.map(|[_, u]| u * NM_PER_MM),
            radius_mm: found.radius_mm.map(|[radius, _]| radius),
            u_radius_nm: found.radius_mm.map(|[_, u]| u * NM_PER_MM),
            before_nm: found.before_mm * NM_PER_MM,
            after_nm: found.after_mm * NM_PER_MM,
            inflation: found.inflation,
        }
    }
}

fn summary(found: &Calibration, out: Option<&Path>) -> String {
    let report = CalibrationReport::new(found);
    let mut text = format!(
        "machine            {}, {}\n",
        report.machine,
        counted(report.points as u64, "point")
    );
    for ParameterReport { name, unit, value, u } in &report.parameters {
        let _ = writeln!(text, "{name:<19}{} {unit} (u {})", short(*value), short(*u));
    }
    for name in &report.undetermined {
        let _ = writeln!(text, "{name:<19}not determined by these points: 0");
    }
    for (title, terms, missing) in [
        ("height", &report.map, &report.map_undetermined),
        ("form", &report.form, &report.form_undetermined),
    ] {
        for TermReport { n, m, value_nm, u_nm } in terms {
            let name = format!("{title} Z({n},{m})");
            let _ = writeln!(text, "{name:<19}{} nm (u {})", short(*value_nm), short(*u_nm));
        }
        for (n, m) in missing {
            let name = format!("{title} Z({n},{m})");
            let _ = writeln!(text, "{name:<19}not told from the machine by these measurements: 0");
        }
    }
    if let (Some(rms), Some(u)) = (report.form_rms_nm, report.u_form_rms_nm) {
        let _ = writeln!(text, "{:<19}{} nm RMS (u {})", "form", short(rms), short(u));
    }
    if let (Some(radius), Some(u)) = (report.radius_mm, report.u_radius_nm) {
        let _ = writeln!(text, "{:<19}{radius:.6} mm (u {} nm)", "radius", short(u));
    }
    let _ = writeln!(
        text,
        "{:<19}{} nm RMS before, {} nm after",
        "off the artefact",
        short(report.before_nm),
        short(report.after_nm)
    );
    if report.inflation > CORRELATED {
        let _ = writeln!(
            text,
            "caution            residuals are alike from point to point (factor {}): form or errors are left that no parameter \
             describes; u counts them as noise",
            short(report.inflation)
        );
    }
    if let Some(out) = out {
        let _ = writeln!(text, "written            {}", out.display());
    }
    text
}

/// Residuals of noise alone enlarge variances by less.
const CORRELATED: f64 = 3.0;

fn machine(word: &str) -> Result<Machine, String> {
    Machine::of_word(word).ok_or_else(|| "expected cartesian or polar".to_owned())
}

fn parameter(word: &str) -> Result<Parameter, String> {
    let all = [Machine::Cartesian, Machine::Polar].map(Machine::parameters).concat();
    all.iter().copied().find(|parameter| parameter.word() == word).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|parameter| parameter.word()).collect();
        format!("expected one of {}", names.join(", "))
    })
}

fn place(word: &str) -> Result<[f64; 2], String> {
    let parsed = word.split_once(':').and_then(|(x, y)| {
        let number = |word: &str| word.parse::<f64>().ok().filter(|value| value.is_finite());
        Some([number(x)?, number(y)?])
    });
    parsed.ok_or_else(|| "expected X:Y in mm, as 5:0".to_owned())
}
