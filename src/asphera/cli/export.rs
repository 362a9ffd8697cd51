//! `asphera export`: the points of a session or a file, for other programs.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use asphera_formats::{Topography, ply};
use asphera_geometry::PointMm;
use clap::Args;

use super::columns::{self, Style, unknown_style};
use super::exit::Exit;
use super::files::refuse;
use super::output::{Failure, print};
use super::progress::Progress;
use super::source::{Content, Recorded, Source, source_help};
use super::text::TextArgs;

#[derive(Args)]
pub(super) struct ExportArgs {
    #[arg(help = source_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// Where they go; the name says how. .xyz, .txt, .asc: x y z in mm. .csv: of a session with time, trigger count and
    /// flags (good where there is none), one line a point; NaN is the place of one that may not be used. .ply: vertices.
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Overwrite FILE if it is there.
    #[arg(long)]
    force: bool,
}

/// How points are written.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Text(Style),
    Ply,
}

impl Kind {
    /// The kind that the name of a file asks for.
    fn of(path: &Path) -> Result<Kind, Failure> {
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ply")) {
            return Ok(Kind::Ply);
        }
        let expected = ".xyz, .txt, .asc, .csv or .ply";
        let unknown = || unknown_style(path, expected);
        Style::by_name(path).map(Kind::Text).ok_or_else(unknown)
    }
}

pub(super) fn run(args: &ExportArgs) -> Result<Exit, Failure> {
    let kind = Kind::of(&args.out)?;
    refuse(&args.out, [&args.source], args.force)?;
    let progress = Progress::start("export");
    let source = Source::open(&args.source, &args.text, &progress)?;
    refuse(&args.out, [source.file()], args.force)?;
    source.say_reading();
    let remarks = remarks(&source);
    let written = match (kind, source.content()) {
        (Kind::Text(Style::Commas), Content::Session(session)) => {
            let points = session.points().len() as u64;
            progress.count("writing", Some(points));
            columns::whole(&args.out, |writer| {
                write_readings(writer, &remarks, session, &progress)
            })?;
            points
        }
        (Kind::Text(style), content) => {
            progress.count("writing", Some(source.len()));
            columns::whole(&args.out, |writer| match content {
                Content::File(topography) => {
                    write_file(writer, style, &remarks, topography, &progress)
                }
                Content::Session(_) => {
                    columns::head(writer, style, &remarks, &PLACES)?;
                    write_places(writer, style, source.points(), &progress)
                }
            })?;
            source.len()
        }
        (Kind::Ply, _) => {
            progress.stage("writing");
            let points: Vec<PointMm> = source.points().collect();
            columns::whole(&args.out, |writer| write_ply(writer, &remarks, &points))?;
            points.len() as u64
        }
    };
    drop(progress);
    print(&format!("points     {written} written to {}\n", args.out.display()));
    Ok(Exit::Done)
}

/// What a reader of the file must know beside the points.
fn remarks(source: &Source) -> Vec<String> {
    let name = source.path().display();
    let mut remarks = vec![format!("from {name} by asphera {}", env!("CARGO_PKG_VERSION"))];
    if let Content::Session(session) = source.content() {
        let figures = session.session();
        remarks.push(format!(
            "session {}, station {}, begun {}",
            figures.id, figures.station, figures.started
        ));
    }
    match source.missing() {
        0 => {}
        missing => remarks.push(format!("{missing} places without a height")),
    }
    remarks.extend(source.losses());
    remarks
}

/// Writes every point of a session, good or flagged, with its time from the start of the station's clock.
fn write_readings(
    writer: &mut impl Write,
    remarks: &[String],
    session: &Recorded,
    progress: &Progress,
) -> io::Result<()> {
    let names = ["x[mm]", "y[mm]", "z[mm]", "time[s]", "trigger", "flags"];
    columns::head(writer, Style::Commas, remarks, &names)?;
    for point in session.points() {
        // Where a flag forbids the use of a point its place is a gap, so that no program takes it for one.
        let place = if point.is_good() { point.position_mm } else { [f64::NAN; 3] };
        for coordinate in place {
            write!(writer, "{coordinate},")?;
        }
        let count = point.count.map_or_else(String::new, |count| count.to_string());
        let mut flags: Vec<&str> = point.flags.names().collect();
        if flags.is_empty() {
            flags.push("good");
        }
        writeln!(writer, "{},{count},{}", point.host.as_secs_f64(), flags.join("|"))?;
        progress.add(1);
    }
    Ok(())
}

/// Writes the points of a file with the columns it has: heights, with their uncertainties, or slopes of a profile.
fn write_file(
    writer: &mut impl Write,
    style: Style,
    remarks: &[String],
    topography: &Topography,
    progress: &Progress,
) -> io::Result<()> {
    let (uncertainties_mm, slopes) = (topography.uncertainties_mm(), topography.slopes());
    if !slopes.is_empty() {
        columns::head(writer, style, remarks, &["x[mm]", "slope[rad]"])?;
        return topography.points().zip(slopes).try_for_each(|([x, ..], &slope)| {
            progress.add(1);
            columns::row(writer, style, &[x, slope])
        });
    }
    if uncertainties_mm.is_empty() {
        columns::head(writer, style, remarks, &PLACES)?;
        return write_places(writer, style, topography.points(), progress);
    }
    columns::head(writer, style, remarks, &["x[mm]", "y[mm]", "z[mm]", "u_z[mm]"])?;
    topography.points().zip(uncertainties_mm).try_for_each(|([x, y, z], &u)| {
        progress.add(1);
        columns::row(writer, style, &[x, y, z, u])
    })
}

fn write_places(
    writer: &mut impl Write,
    style: Style,
    points: impl Iterator<Item = PointMm>,
    progress: &Progress,
) -> io::Result<()> {
    for point in points {
        columns::row(writer, style, &point)?;
        progress.add(1);
    }
    Ok(())
}

fn write_ply(writer: &mut impl Write, remarks: &[String], points: &[PointMm]) -> io::Result<()> {
    // Comments of PLY are ASCII.
    let ascii = |text: &String| -> String {
        text.chars().map(|letter| if matches!(letter, ' '..='~') { letter } else { '?' }).collect()
    };
    let mut comments: Vec<String> = remarks.iter().map(ascii).collect();
    comments.push("coordinates in mm, measured frame".to_owned());
    let comments: Vec<&str> = comments.iter().map(String::as_str).collect();
    ply::write_mesh(writer, points, &[], None, &comments).map_err(io::Error::other)
}

/// The columns of a point.
const PLACES: [&str; 3] = ["x[mm]", "y[mm]", "z[mm]"];
