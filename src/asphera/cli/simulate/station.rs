//! A station's own configuration, its devices simulated over a simulated part.

mod courses;

use std::path::Path;

use asphera_stand::{Instrument, Listing, Stand};
use clap::Args;
use toml_edit::{DocumentMut, Item, value};

use super::super::Speed;
use super::super::exit::Exit;
use super::super::output::{Failure, print, say};
use super::super::serve::interrupted;
use super::super::usage::misused;
use super::links::{Lead, lead};
use super::silence::allow_silence;
use crate::config::Config;
use courses::{Order, Scan, scan};

/// The part, and how it is scanned.
#[derive(Args, Clone, Debug)]
pub(super) struct PartArgs {
    /// Of a station's configuration: about how many points are measured.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(3..=1_000_000))]
    points: u64,
    /// Of a station's configuration: triggers a second; without it 1000, or 10 mm a second where devices are joined by time.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Of a station's configuration: form error of the part from peak to valley, nm.
    #[arg(long, value_name = "NM", default_value_t = 100.0)]
    form_nm: f64,
    /// Of a station's configuration: standard deviation of the measured heights, nm.
    #[arg(long, value_name = "NM", default_value_t = 2.0)]
    noise_nm: f64,
    /// Of a station's configuration: seed of the noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// How many times as fast as usual a machine with a program is.
    #[arg(skip)]
    pub(super) speed: Option<Speed>,
}

/// Whether a file is the configuration of a station: it has devices, as no bench has.
pub(super) fn is_station(text: &str) -> bool {
    text.parse::<DocumentMut>().is_ok_and(|document| document.contains_key("device"))
}

/// Simulates every device of a configuration until it is interrupted.
pub(super) async fn simulate(
    file: &Path,
    args: &PartArgs,
    speed: Option<Speed>,
    station: Option<&Path>,
) -> Result<Exit, Failure> {
    let args = &PartArgs { speed, ..args.clone() };
    check(args)?;
    let config = Config::load(file)?;
    let scan = scan(&config, args)?;
    let (points, rate_hz) = (scan.points, scan.rate_hz);
    let ends_by_count = config.end.points.is_some() || scan.ends_by_count();
    say(&described(&scan, args));
    let mut text: DocumentMut = config.text.parse()?;
    for left_out in flawless(&mut text) {
        say(&format!("The simulated machine has no errors: {left_out} is left out"));
    }
    for changed in allow_silence(&mut text) {
        say(&format!("Simulated devices are silent after the scan: {changed} is left out"));
    }
    let mut stand = match scan.order {
        Order::Plan(moving) => Stand::start_moving(scan.played, rate_hz, moving).await?,
        Order::Simulation | Order::Program => Stand::start(scan.played, rate_hz).await?,
    };
    for listing in stand.listing() {
        let Listing { kind, address, second_port, .. } = *listing;
        let name = &config.links[listing.link].name;
        let second = second_port.map_or_else(String::new, |port| format!(" and {port}"));
        print(&format!(
            "{name:<10} {kind:<14} {address}{second}  {}\n",
            listing.devices.join(", ")
        ));
        // A scanner on UDP sends to where the station listens.
        if kind != "udp" {
            let carries_fd = listing.sends_fd;
            lead(&mut text, name, Lead { kind, address, second_port, carries_fd });
        }
    }
    if ends_by_count {
        text["scan"]["points"] = value(i64::try_from(points)?);
    }
    match station {
        Some(station) => {
            std::fs::write(station, text.to_string())
                .map_err(|error| format!("cannot write {}: {error}", station.display()))?;
            say(&format!("Measure it: asphera run --config {}", station.display()));
        }
        None => say("--station FILE writes a configuration whose links lead here"),
    }
    say("simulating; Ctrl-C ends it");
    let mut scans = 0_u64;
    tokio::select! {
        done = interrupted() => done?,
        () = async {
            loop {
                stand.scanned().await;
                scans += 1;
                say(&format!("scan {scans} is over"));
            }
        } => {}
    }
    Ok(Exit::Done)
}

/// Takes corrections of a machine out of a configuration. What was there.
fn flawless(text: &mut DocumentMut) -> Vec<String> {
    let tables = ["calibration", "thermal"];
    let there = tables.into_iter().filter(|table| text.remove(table).is_some());
    let mut left_out: Vec<String> = there.map(|table| format!("[{table}]")).collect();
    let Some(axes) = text.get_mut("kinematics").and_then(Item::as_table_like_mut) else {
        return left_out;
    };
    for (name, axis) in axes.iter_mut() {
        let removed = axis.as_table_like_mut().and_then(|axis| axis.remove("error_table"));
        left_out.extend(removed.map(|_| format!("error_table of {name}")));
    }
    left_out
}

fn check(args: &PartArgs) -> Result<(), Failure> {
    let rates = 0.001..=66_000.0;
    if let Some(rate_hz) = args.rate.filter(|rate_hz| !rates.contains(rate_hz)) {
        return Err(misused(format!("--rate: expected 0.001 to 66000 Hz, found {rate_hz}")));
    }
    for (key, nm) in [("--form-nm", args.form_nm), ("--noise-nm", args.noise_nm)] {
        if !(0.0..=1e6).contains(&nm) {
            return Err(misused(format!("{key}: expected 0 to 1000000 nm, found {nm}")));
        }
    }
    Ok(())
}

/// How many times as fast as usual a machine with a program is.
fn machine_speed(args: &PartArgs) -> Result<f64, Failure> {
    match args.speed {
        None => Ok(1.0),
        Some(Speed::Times(times)) => Ok(times),
        Some(Speed::Max) => Err(misused(
            "--speed: expected how many times as fast as usual the machine is, found max",
        )),
    }
}

/// What is measured, for a person.
fn described(scan: &Scan, args: &PartArgs) -> String {
    let seconds = scan.points as f64 / scan.rate_hz;
    let shift = match scan.shift_mm {
        0.0 => String::new(),
        shift_mm => format!(", moved by {shift_mm:.3} mm along z so that the probe reaches it"),
    };
    let pace = match scan.order {
        Order::Simulation => format!("{} triggers in {seconds:.0} s", scan.points),
        Order::Plan(_) => {
            format!("{} readings a second, while the station moves its axes", scan.rate_hz)
        }
        Order::Program => "the machine runs the program of the station".to_owned(),
    };
    format!(
        "{} with {} nm of form error and {} nm of noise{shift}; {pace}",
        scan.part, args.form_nm, args.noise_nm
    )
}

/// All devices of a configuration as instruments.
fn instruments(config: &Config) -> Result<Vec<Instrument>, Failure> {
    let instrument = |device: &crate::config::DeviceConfig| {
        Instrument::new(&device.name, device.link, &*device.settings)
    };
    let made: Result<Vec<Instrument>, _> = config.devices.iter().map(instrument).collect();
    Ok(made?)
}
