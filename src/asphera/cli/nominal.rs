//! `asphera nominal`: a nominal file checked and told, or made from a surface of a Zemax lens file.

mod told;

use std::fs;
use std::path::PathBuf;

use clap::Args;

use super::exit::Exit;
use super::files::{part, read, refuse};
use super::output::{Failure, print};
use crate::config::Part;
use crate::lens;

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
    /// Where the nominal goes; without it to stdout.
    #[arg(short, long, value_name = "OUT.toml", requires = "surface")]
    out: Option<PathBuf>,
    /// Overwrite it.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &NominalArgs) -> Result<Exit, Failure> {
    let name = args.file.display().to_string();
    if args.file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
        if args.surface.is_some() {
            return Err(format!("{name} is a nominal file: --surface is for lens files").into());
        }
        print(&told::of(&part(&args.file)?, &args.sag)?);
        return Ok(Exit::Done);
    }
    if !args.sag.is_empty() {
        return Err(
            format!("--sag is for nominal files, .toml; {name} is taken for a lens file").into()
        );
    }
    if let Some(out) = &args.out {
        refuse(out, &args.file, args.force)?;
    }
    let read = asphera_formats::zemax::read(&read(&args.file)?);
    let lens = read.map_err(|error| format!("{name}: {error}"))?;
    let Some(number) = args.surface else {
        print(&lens::list(&lens));
        return Ok(Exit::Done);
    };
    let text = lens::nominal(&lens, number, &name).map_err(|error| format!("{name}: {error}"))?;
    // What is written can be read again: a surface that cannot be is told now, not when it is measured.
    Part::parse(&name, &text)
        .map_err(|problems| format!("surface {number} of {name} is no surface:\n{problems}"))?;
    match &args.out {
        Some(out) => fs::write(out, text)
            .map_err(|error| format!("cannot write {}: {error}", out.display()))?,
        None => print(&text),
    }
    Ok(Exit::Done)
}
