//! `asphera volume`: a volume becomes a surface, with what is certain of it.

mod figures;
mod form;
mod measures;
mod meshed;
mod nominal;
pub(super) mod opened;
mod regular;
mod sliced;
mod summary;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use asphera_volume::{Ambiguity, BALL_RADIUS, Blend, MAX_REFINE, Majority, Method};
use clap::{Args, ValueEnum};

use super::exit::Exit;
use super::files::{part, refuse};
use super::output::{Failure, print, print_json, write_json};
use super::progress::Progress;
use super::text::UnitArgs;
use super::threads::ThreadArgs;
use super::usage::misused;
use regular::Regular;

#[derive(Args)]
pub(super) struct VolumeArgs {
    /// The volume: .vol, NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI (.nii, .nii.gz, .hdr), a TIFF stack (.tif with a page a slice,
    /// or a folder of numbered slices), VTK (.vti), or raw samples with .toml or .vgi beside them.
    file: PathBuf,
    /// What is material: this value and above; `otsu`, or `iso50`, halfway between the modes of background and material. Without it
    /// the middle of two values, or of more Otsu's.
    #[arg(long, value_name = "T|otsu|iso50", allow_hyphen_values = true)]
    threshold: Option<Threshold>,
    /// The spacing of the samples, one length or three, for what the file says, or does not.
    #[arg(long, value_name = "MM[,MM,MM]", value_parser = spacing, allow_hyphen_values = true)]
    spacing: Option<[f64; 3]>,
    /// The radius r of the part: balls of this radius touch every point of its boundary from inside and outside. It is its smallest
    /// radius of curvature, or half its thinnest wall or gap. Or a mesh of the part (.stl, .ply, .obj, .off), whose reach on both sides
    /// proves an r; one with sharp edges proves none.
    #[arg(long, value_name = "R_MM|MESH", allow_hyphen_values = true)]
    regular: Option<Regular>,
    #[command(flatten)]
    unit: UnitArgs,
    /// A nominal of the part: the form of its face, and the reach of that, the smallest local feature size on both sides, against the
    /// spacing. It says nothing of the rest of the part.
    #[arg(long, value_name = "FILE")]
    nominal: Option<PathBuf>,
    /// How the samples become a surface: modified marching cubes, majority interpolation, its complement, balls about the samples,
    /// trilinear interpolation, the same blended, or the faces of voxels.
    #[arg(long, value_enum, default_value = "mmc")]
    method: MethodName,
    /// Pieces a side of a cell is cut into by --method balls, trilinear or smooth, 3 without it; with grey values trilinear needs none.
    #[arg(long, value_name = "K", value_parser = refinement)]
    refine: Option<usize>,
    /// How pieces are blended by --method smooth; infinite without it.
    #[arg(long, value_enum)]
    blend: Option<BlendName>,
    /// Which of the connected parts: all of them, the largest, or one by its number, the largest first.
    #[arg(long, value_name = "all|largest|N", default_value = "all")]
    part: Part,
    /// Put a layer of background about the volume, so that the surface of a part that touches the border is closed there. Without it the
    /// surface ends in the outermost samples.
    #[arg(long)]
    pad: bool,
    /// End with exit code 11 where the grid is contradicted.
    #[arg(long)]
    check: bool,
    /// Write the surface, in mm of the file's frame.
    #[arg(long, value_name = "OUT.ply|OUT.stl")]
    mesh: Option<PathBuf>,
    /// Write volume.json and mesh.ply into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite such files if they are there.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Print the figures as one JSON object on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
}

/// What is material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Threshold {
    Value(f64),
    Otsu,
    Iso50,
}

impl FromStr for Threshold {
    type Err = String;

    fn from_str(word: &str) -> Result<Threshold, String> {
        match word {
            "otsu" => Ok(Threshold::Otsu),
            "iso50" => Ok(Threshold::Iso50),
            _ => match word.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(Threshold::Value(value)),
                _ => Err(format!("expected a number, otsu or iso50, found `{word}`")),
            },
        }
    }
}

/// Which of the parts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    All,
    /// Counted from 1, the largest first.
    Number(usize),
}

impl FromStr for Part {
    type Err = String;

    fn from_str(word: &str) -> Result<Part, String> {
        match (word, word.parse()) {
            ("all", _) => Ok(Part::All),
            ("largest", _) => Ok(Part::Number(1)),
            (_, Ok(number @ 1..)) => Ok(Part::Number(number)),
            _ => Err(format!("expected all, largest or a number from 1, found `{word}`")),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum MethodName {
    Mmc,
    Mi,
    Cmi,
    Balls,
    Trilinear,
    Smooth,
    Voxels,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum BlendName {
    Linear,
    Cubic,
    Infinite,
}

impl VolumeArgs {
    /// The method with its options.
    ///
    /// # Errors
    ///
    /// Where an option belongs to another method.
    fn method(&self) -> Result<Method, Failure> {
        let cuts = [MethodName::Balls, MethodName::Trilinear, MethodName::Smooth];
        if self.refine.is_some() && !cuts.contains(&self.method) {
            let expected = "expected --method balls, trilinear or smooth: leave it out for others";
            return Err(misused(format!("--refine: {expected}")));
        }
        if self.blend.is_some() && self.method != MethodName::Smooth {
            return Err(misused("--blend: expected --method smooth: leave it out for others"));
        }
        let refine = self.refine.unwrap_or(3);
        Ok(match self.method {
            MethodName::Mmc => Method::Marching(Ambiguity::Paired),
            MethodName::Mi => Method::Majority(Majority::Foreground),
            MethodName::Cmi => Method::Majority(Majority::Complement),
            MethodName::Balls => Method::Balls { radius: BALL_RADIUS, refine },
            MethodName::Trilinear => Method::Trilinear { refine },
            MethodName::Voxels => Method::Voxels,
            MethodName::Smooth => {
                let blend = match self.blend {
                    Some(BlendName::Linear) => Blend::Linear,
                    Some(BlendName::Cubic) => Blend::Cubic,
                    Some(BlendName::Infinite) | None => Blend::Infinite,
                };
                Method::Smooth { blend, refine }
            }
        })
    }
}

impl VolumeArgs {
    /// The files that are read.
    fn read(&self) -> impl Iterator<Item = &Path> {
        let regular = match &self.regular {
            Some(Regular::Mesh(path)) => Some(&**path),
            _ => None,
        };
        [&*self.file].into_iter().chain(regular).chain(self.nominal.as_deref())
    }
}

pub(super) fn run(args: &VolumeArgs) -> Result<Exit, Failure> {
    let meshes = [args.mesh.clone(), args.out.as_deref().map(|folder| folder.join("mesh.ply"))];
    let meshes: Vec<PathBuf> = meshes.into_iter().flatten().collect();
    let report_file = args.out.as_deref().map(|folder| folder.join("volume.json"));
    if args.unit.is_given() && !matches!(args.regular, Some(Regular::Mesh(_))) {
        return Err(misused(
            "--unit is that of a mesh in --regular: leave it out, and give --spacing in mm where the volume states no unit",
        ));
    }
    for path in meshes.iter().chain(&report_file) {
        refuse(path, args.read(), args.force)?;
    }
    meshed::check_names(&meshes)?;
    if let Some(folder) = &args.out {
        std::fs::create_dir_all(folder)
            .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    }
    let progress = Progress::start("volume");
    let work = || -> Result<figures::VolumeReport, Failure> {
        progress.stage("reading");
        let opened = opened::open(args, WHOLE)?;
        progress.stage("making the surface");
        let surface = meshed::of(args, &opened, &meshes)?;
        progress.stage("measuring");
        let given = args.nominal.as_deref().map(part).transpose()?;
        let mut report = figures::of(args, &opened, &surface, given.as_ref())?;
        if let Some(part) = given {
            form::add(&mut report, args, (&part, opened.into_volume()), &progress);
        }
        Ok(report)
    };
    let report = args.threads.run(work)?;
    if let Some(path) = &report_file {
        write_json(path, &report)?;
    }
    drop(progress);
    if args.json {
        print_json(&report)?;
    } else {
        print(&summary::of(&report));
    }
    if args.check && report.is_contradicted() {
        return Ok(Exit::Undecided);
    }
    Ok(Exit::Done)
}

/// Samples up to which a volume is held in memory whole.
const WHOLE: u64 = 1 << 26;

fn length(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("expected a length in mm above 0, found `{word}`")),
    }
}

pub(super) fn spacing(word: &str) -> Result<[f64; 3], String> {
    let lengths: Vec<f64> = word.split(',').map(length).collect::<Result<_, _>>()?;
    match lengths[..] {
        [all] => Ok([all; 3]),
        [x, y, z] => Ok([x, y, z]),
        _ => Err(format!("expected one length or three, found {}", lengths.len())),
    }
}

fn refinement(word: &str) -> Result<usize, String> {
    match word.parse() {
        Ok(pieces) if (1..=MAX_REFINE).contains(&pieces) => Ok(pieces),
        _ => Err(format!("expected 1 to {MAX_REFINE}, found `{word}`")),
    }
}
