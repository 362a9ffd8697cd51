//! `asphera nominal`: a nominal file checked and told, or made from a surface of a Zemax lens file.

mod description;

use std::path::{Path, PathBuf};

use asphera_formats::zemax;
use clap::Args;

use super::exit::Exit;
use super::files::{part, read, refuse};
use super::output::{Failure, print};
use super::usage::misused;
use crate::lens;
use crate::whole_file::write_bytes;
use asphera_measure::Part;
use asphera_nominal::flipped;

#[derive(Args)]
pub(super) struct NominalArgs {
    /// The nominal file, .toml, or the lens file, .zmx.
    file: PathBuf,
    /// Of a nominal file: distances from the axis, mm, at which its heights are told; without it from the axis to the
    /// rim of the aperture.
    #[arg(long, value_name = "R,R,...", value_delimiter = ',', conflicts_with = "surface")]
    sag: Vec<f64>,
    /// Of a lens file: number of the surface, as the file counts; without it the surfaces are listed.
    #[arg(long, value_name = "N")]
    surface: Option<u32>,
    /// Of a grid sag in a lens file: the file of heights that was imported into it, .DAT.
    #[arg(long, value_name = "FILE.DAT", requires = "surface")]
    grid: Option<PathBuf>,
    /// Make the nominal of the other side: turned by half a turn about x, convex and concave exchanged.
    #[arg(long, conflicts_with = "sag")]
    flip: bool,
    /// Where the nominal goes; without it to stdout.
    #[arg(short, long, value_name = "OUT.toml")]
    out: Option<PathBuf>,
    /// Overwrite it.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &NominalArgs) -> Result<Exit, Failure> {
    let name = args.file.display().to_string();
    let bytes = read(&args.file)?;
    let is_toml =
        args.file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    // The content of a lens file counts for more than its name.
    if is_toml && !zemax::is_zemax(&bytes) {
        if args.surface.is_some() {
            return Err(misused(format!("{name} is a nominal file: --surface is for lens files")));
        }
        let part = part(&args.file)?;
        return match (args.flip, &args.out) {
            (true, _) => {
                let text = String::from_utf8_lossy(&bytes);
                write(args, &turned(&name, &text)?)
            }
            (false, Some(_)) => Err(misused(format!(
                "{name} is a nominal file already: -o is for --flip and --surface"
            ))),
            (false, None) => {
                print(&description::describe(&part, &args.sag)?);
                Ok(Exit::Done)
            }
        };
    }
    if !args.sag.is_empty() {
        return Err(misused(format!(
            "--sag is for nominal files, .toml; {name} is taken for a lens file"
        )));
    }
    if args.surface.is_none() && (args.flip || args.out.is_some()) {
        return Err(misused(format!("{name} is a lens file: --surface N says which surface")));
    }
    let lens = zemax::read(&bytes).map_err(|error| format!("{name}: {error}"))?;
    let Some(number) = args.surface else {
        print(&lens::list(&lens));
        return Ok(Exit::Done);
    };
    let heights =
        args.grid.as_deref().map(|grid| heights(grid, args.out.as_deref())).transpose()?;
    let text = lens::nominal(&lens, number, &name, heights.as_deref())
        .map_err(|error| format!("{name}: {error}"))?;
    let text = if args.flip { turned(&name, &text)? } else { text };
    // What is written can be read again: a surface that cannot be is told now, not when it is measured.
    let place = args.out.as_ref().map_or_else(|| name.clone(), |out| out.display().to_string());
    asphera_nominal::parse(&place, &text)
        .map_err(|problems| format!("surface {number} of {name} is no surface:\n{problems}"))?;
    write(args, &text)
}

/// What a nominal says, as a person reads it.
pub(super) fn told(part: &Part) -> Result<String, Failure> {
    description::describe(part, &[])
}

fn turned(name: &str, text: &str) -> Result<String, Failure> {
    flipped(text).map_err(|error| format!("{name}: {error}").into())
}

/// Writes a nominal where it was asked for.
fn write(args: &NominalArgs, text: &str) -> Result<Exit, Failure> {
    match &args.out {
        Some(out) => {
            refuse(out, [&args.file].into_iter().chain(&args.grid), args.force)?;
            write_bytes(out, text)?;
        }
        None => print(text),
    }
    Ok(Exit::Done)
}

/// The file of heights as a nominal at `out` is to name it: alone where both are in one folder, else by its whole path.
fn heights(grid: &Path, out: Option<&Path>) -> Result<String, Failure> {
    let whole = grid.canonicalize().map_err(|error| format!("{}: {error}", grid.display()))?;
    let folder = out.map(|out| out.parent().filter(|folder| *folder != Path::new("")));
    let folder = folder.map(|folder| folder.unwrap_or(Path::new(".")).canonicalize());
    let is_beside = matches!(&folder, Some(Ok(folder)) if whole.parent() == Some(folder));
    let named = if is_beside { whole.file_name().map(Path::new) } else { None };
    let text = named.unwrap_or(&whole).to_str().map(str::to_owned);
    text.ok_or_else(|| format!("{}: expected a path in UTF-8", grid.display()).into())
}
