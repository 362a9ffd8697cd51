//! The scene `tray`: lenses, a flat and rings on a tray, told apart by a library of their nominals, and measured.

use std::fmt::Write as _;
use std::path::Path;

use asphera_form::{Aperture, Nominal};
use asphera_rig::{TrayKind, TrayScene};

use super::super::columns::{Style, head, row, whole};
use super::super::exit::Exit;
use super::super::files::refuse;
use super::super::output::{Failure, say, write_json};
use super::super::parts;
use super::ct::asphere_keys;
use super::{DemoArgs, default_folder};

/// The name of the scene.
pub(super) const NAME: &str = "tray";

/// Writes the scan of a tray, the library of its parts and the truth, and finds the parts as anyone would.
pub(super) fn run(args: &DemoArgs) -> Result<Exit, Failure> {
    if args.listen.is_some() {
        return Err(format!(
            "scene {NAME}: expected no --listen, for a scan that is there has no page; leave it out"
        )
        .into());
    }
    let folder = args.output.out.clone().unwrap_or_else(default_folder);
    let scene = TrayScene::lenses(args.seed.unwrap_or(1));
    let scene = match args.points {
        Some(points) => scene.with_points(points),
        None => scene,
    };
    lay_out(&folder, &scene, args.output.force)?;
    say(&format!("results: {}", folder.display()));
    parts::found(&folder, &args.output)
}

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
        refuse(path, folder, overwrite)?;
    }
    let tray = scene.scan()?;
    whole(&points, |writer| {
        head(writer, Style::Spaces, &[], &["x[mm]", "y[mm]", "z[mm]"])?;
        tray.points_mm.iter().try_for_each(|point| row(writer, Style::Spaces, point))
    })?;
    write_json(&truth, &tray.truth)?;
    for kind in &scene.kinds {
        let path = library.join(format!("{}.toml", kind.name));
        std::fs::write(&path, nominal(kind))
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
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
    let _ = writeln!(text, "\n[fit]\nfree = [{free}]");
    text
}
