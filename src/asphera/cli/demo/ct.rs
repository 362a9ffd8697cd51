//! The scene `ct`: a lens in a simulated scanner, both its faces measured.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use asphera_form::{Asphere, Nominal};
use asphera_formats::volume::{Frame, UnitKnown, write_nrrd};
use asphera_rig::{CtScene, CtTruth, CtVolume};

use super::super::exit::Exit;
use super::super::face::{self, FaceArgs, Faces};
use super::super::files::part;
use super::super::measure::deliver_faces;
use super::super::output::{Failure, refuse_results, say, write_json};
use super::super::progress::Progress;
use super::super::serve::{bound, show};
use super::super::usage::misused;
use super::{DemoArgs, default_folder, page_of};

/// The name of the scene.
pub(super) const NAME: &str = "ct";

/// Makes the volume, its nominals and its truth, measures it from its files as anyone would, and shows it on the page.
pub(super) fn run(mut args: DemoArgs) -> Result<Exit, Failure> {
    if args.points.is_some() {
        return Err(misused(format!(
            "scene {NAME}: expected no --points, for a scan in space has none; leave it out"
        )));
    }
    if args.exit && args.listen.is_some() {
        return Err(misused(format!(
            "scene {NAME}: expected --listen or --exit, found both: its page is there when the measurement has ended"
        )));
    }
    refuse_results(&args.output)?;
    let page = (!args.exit).then(|| bound(page_of(&args))).transpose()?;
    let folder = args.output.out.clone().unwrap_or_else(default_folder);
    args.output.out = Some(folder.clone());
    std::fs::create_dir_all(&folder)
        .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    let mut scene = CtScene::lens(1.0);
    scene.seed = args.seed.unwrap_or(scene.seed);
    let progress = Progress::start("demo");
    progress.stage("scanning");
    let laid = lay_out(&folder, &scene)?;
    say(&format!("results: {}", folder.display()));
    let faces = laid.measured(&progress)?;
    let exit = deliver_faces(&faces, &args.output, progress)?;
    if let Some(page) = page {
        show(faces.shown(&laid.volume)?, page)?;
    }
    Ok(exit)
}

/// The files of a scan.
pub(in crate::cli) struct LaidOut {
    pub(in crate::cli) volume: PathBuf,
    pub(in crate::cli) nominals: [PathBuf; 2],
    #[cfg_attr(
        not(test),
        expect(dead_code, reason = "tests compare with it; it stands in truth.json")
    )]
    pub(in crate::cli) truth: CtTruth,
}

impl LaidOut {
    /// Both faces, measured from the files.
    pub(in crate::cli) fn measured(&self, progress: &Progress) -> Result<Faces, Failure> {
        let [front, back] = &self.nominals;
        let args = FaceArgs::of_pair(back.clone());
        face::measured(&self.volume, &args, Some(part(front)?), None, None, progress)
    }
}

/// Scans a lens, and writes the volume, the nominals of its faces and the truth.
pub(in crate::cli) fn lay_out(folder: &Path, scene: &CtScene) -> Result<LaidOut, Failure> {
    let path = folder.join("ct.nrrd");
    let nominals = [folder.join("front.toml"), folder.join("back.toml")];
    let scan = scene.scan()?;
    write_volume(&path, &scan)?;
    for (path, of) in nominals.iter().zip(&scene.faces) {
        std::fs::write(path, nominal(&of.nominal, scene.aperture_mm))
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    }
    write_json(&folder.join("truth.json"), &scan.truth)?;
    Ok(LaidOut { volume: path, nominals, truth: scan.truth })
}

fn write_volume(path: &Path, volume: &CtVolume) -> Result<(), Failure> {
    let frame = Frame {
        origin_mm: volume.origin_mm,
        ..Frame::aligned([volume.spacing_mm; 3], UnitKnown::Stated)
    };
    let file =
        File::create(path).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    write_nrrd(BufWriter::new(file), volume.size, &volume.values, &frame)
        .map_err(|error| format!("{}: {error}", path.display()).into())
}

/// The keys of an asphere in a nominal file.
pub(super) fn asphere_keys(asphere: &Asphere) -> String {
    let mut text = format!(
        "kind = \"asphere\"\nradius_mm = {:?}\nconic = {:?}\n",
        asphere.radius_mm, asphere.conic
    );
    for (order, coefficient) in (4..).step_by(2).zip(asphere.coefficients) {
        if coefficient != 0.0 {
            text.push_str(&format!("A{order} = {coefficient:?}\n"));
        }
    }
    text
}

/// The nominal file of an asphere.
fn nominal(of: &Nominal, aperture_mm: f64) -> String {
    let mut text = "[surface]\n".to_owned();
    if let Nominal::Asphere(asphere) = of {
        text.push_str(&asphere_keys(asphere));
    }
    text.push_str(&format!(
        "\n[aperture]\nshape = \"circle\"\nradius_mm = {aperture_mm:?}\n\n[fit]\nfree = [\"tx\", \"ty\", \"tz\", \"rx\", \"ry\"]\n"
    ));
    text
}
