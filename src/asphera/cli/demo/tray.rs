//! The scene `tray`: lenses, a flat and rings on a tray, told apart by a library of their nominals, and measured.

use std::fmt::Write as _;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::path::Path;
use std::sync::Arc;

use asphera_form::{Aperture, Nominal};
use asphera_report::{Connection, State};
use asphera_rig::{Departure, TrayKind, TrayScene, send};

use super::super::Speed;
use super::super::columns::{Style, head, row, whole};
use super::super::exit::Exit;
use super::super::files::refuse;
use super::super::output::{Failure, say, write_json};
use super::super::serve::block_on;
use super::ct::asphere_keys;
use super::{DemoArgs, folder_of, measured, page_of};
use crate::live::Handle;
use crate::whole_file::write_bytes;

/// The name of the scene.
pub(super) const NAME: &str = "tray";

/// Writes the library of the parts, the truth, and a file of points of the same tray; then a line scanner goes over it, and its parts are
/// found and measured while it does.
pub(super) fn run(args: DemoArgs) -> Result<Exit, Failure> {
    let scene = TrayScene::lenses(args.seed.unwrap_or(1));
    let scene = match args.points {
        Some(points) => scene.with_points(points),
        None => scene,
    };
    block_on(demo(scene, args))
}

async fn demo(scene: TrayScene, mut args: DemoArgs) -> Result<Exit, Failure> {
    let folder = folder_of(&mut args)?;
    lay_out(&folder, &scene, args.output.force)?;
    let rate_hz = match args.speed {
        Speed::Times(times) => PROFILES_HZ * times,
        Speed::Max => FASTEST_HZ,
    };
    let departures: Arc<[Departure]> = scene.departures(rate_hz.min(FASTEST_HZ))?.into();
    // A port that is free now: the station takes it when its session begins.
    let scanner = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr()?;
    say(&format!("simulated: scanner  RIFTEK RF627, UDP to {scanner}"));
    let library = folder.join("library");
    let toml = scene.station_toml(scanner, [&folder, &library], page_of(&args));
    measured(&toml, &args, &folder, |station| {
        tokio::spawn(scan(station, departures, scanner));
        Ok(())
    })
    .await
}

/// Goes over the tray once a session, when the station has opened its port.
async fn scan(station: Handle, departures: Arc<[Departure]>, to: SocketAddr) {
    let mut snapshots = station.watch();
    let mut scanned = None;
    loop {
        let wanted = snapshots.wait_for(|now| {
            let id = now.session.as_ref().map(|session| &session.id);
            let is_open = now.links.first().is_some_and(|link| link.state != Connection::Opening);
            now.state == State::Measuring && id.is_some() && id != scanned.as_ref() && is_open
        });
        let Ok(now) = wanted.await.map(|now| now.session.clone()) else { return };
        scanned = now.map(|session| session.id);
        if let Err(error) = send(&departures, to).await {
            say(&format!("the simulated scanner cannot send: {error}"));
            return;
        }
    }
}

/// Profiles a second of a scanner as it would really be.
const PROFILES_HZ: f64 = 40.0;
/// A faster one loses datagrams: the receiver has no way to hold it back.
const FASTEST_HZ: f64 = 400.0;

/// Writes `tray.xyz`, `library/*.toml` and `truth.json`.
pub(in crate::cli) fn lay_out(
    folder: &Path,
    scene: &TrayScene,
    overwrite: bool,
) -> Result<(), Failure> {
    let library = folder.join("library");
    std::fs::create_dir_all(&library)
        .map_err(|error| format!("cannot make {}: {error}", library.display()))?;
    let (points, truth) = (folder.join("tray.xyz"), folder.join("truth.json"));
    for path in [&points, &truth] {
        refuse(path, [folder], overwrite)?;
    }
    let tray = scene.scan()?;
    whole(&points, |writer| {
        head(writer, Style::Spaces, &[], &["x[mm]", "y[mm]", "z[mm]"])?;
        tray.points_mm.iter().try_for_each(|point| row(writer, Style::Spaces, point))
    })?;
    write_json(&truth, &tray.truth)?;
    for kind in &scene.kinds {
        let path = library.join(format!("{}.toml", kind.name));
        write_bytes(&path, nominal(kind))?;
    }
    Ok(())
}

/// The nominal file of a kind.
fn nominal(kind: &TrayKind) -> String {
    let mut text = "[surface]\n".to_owned();
    // Writing into a String cannot fail.
    let _ = match &kind.nominal {
        Nominal::Sphere { radius_mm } => {
            writeln!(text, "kind = \"sphere\"\nradius_mm = {radius_mm:?}")
        }
        Nominal::Asphere(asphere) => write!(text, "{}", asphere_keys(asphere)),
        _ => writeln!(text, "kind = \"plane\""),
    };
    let _ = match kind.aperture {
        Aperture::Annulus { inner_mm, outer_mm } => writeln!(
            text,
            "\n[aperture]\nshape = \"annulus\"\ninner_radius_mm = {inner_mm:?}\nouter_radius_mm = {outer_mm:?}"
        ),
        Aperture::Circle { radius_mm } => {
            writeln!(text, "\n[aperture]\nshape = \"circle\"\nradius_mm = {radius_mm:?}")
        }
        _ => Ok(()),
    };
    let free = match kind.nominal {
        Nominal::Plane => "\"tz\", \"rx\", \"ry\"",
        Nominal::Sphere { .. } => "\"tx\", \"ty\", \"tz\"",
        _ => "\"tx\", \"ty\", \"tz\", \"rx\", \"ry\"",
    };
    let _ = writeln!(text, "\n[fit]\nfree = [{free}]\n\n[tolerance]\nrms_nm = 2000");
    text
}
