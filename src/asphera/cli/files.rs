//! Files the commands read, and those they must not write.

use std::borrow::Cow;
use std::path::Path;

use asphera_formats::Topography;
use asphera_geometry::Point;
use asphera_mesh::Mesh;
use asphera_report::Timing;

use super::output::Failure;
use super::progress::Progress;
use super::source::{Content, Source, is_recording};
use super::unit_doubt::UnitCheck;
use crate::clock::Clock;
use crate::config::TOML;
use crate::weighing::Weighing;
use asphera_measure::{Along, Measurement, Pipeline, Tip};
use asphera_measure::{Part, Weights};
use asphera_nominal::{bytes_of, text_of};

/// What a nominal file says.
pub(super) fn part(path: &Path) -> Result<Part, Failure> {
    Ok(asphera_nominal::parse(&path.display().to_string(), &toml_text(path)?)?)
}

/// The text of a TOML file. A lens file and text in UTF-16 are refused as what they are.
pub(super) fn toml_text(path: &Path) -> Result<String, Failure> {
    let name = path.display().to_string();
    let text = text_of(&name, read(path)?);
    Ok(text.map_err(|found| format!("{name}: expected {TOML}, found {found}"))?)
}

/// Fails where the nominal asks for weights by uncertainty and a point of the source has none.
fn check_uncertainties(part: &Part, source: &Source) -> Result<(), Failure> {
    let name = source.path().display();
    let topography = match source.content() {
        Content::File(topography) => topography,
        Content::Session(session) => {
            return refuse_weights(part, &session.weighing(part), source.path());
        }
    };
    let uncertainties_mm = topography.uncertainties_mm();
    if uncertainties_mm.is_empty() {
        return Err(format!(
            "{name}: expected a column u_z[mm], the standard uncertainty of each z, for the weights the nominal asks \
             for; found none"
        )
        .into());
    }
    let bad = uncertainties_mm.iter().position(|u_mm| !(u_mm.is_normal() && *u_mm > 0.0));
    if let Some(index) = bad {
        return Err(format!(
            "{name}: the u_z of measured point {} is {} mm, expected a number above 0; leave out a point that is not \
             to count",
            index + 1,
            uncertainties_mm[index]
        )
        .into());
    }
    Ok(())
}

/// The points of a file, each with what the file says of its height.
fn points_of(topography: &Topography) -> Vec<Point> {
    let known = topography.uncertainties_mm().iter().map(|&u_mm| Some(u_mm));
    let known = known.chain(std::iter::repeat(None));
    topography.points().zip(known).map(|(at_mm, u_z_mm)| Point { at_mm, u_z_mm }).collect()
}

/// Fails where a nominal asks for weights that a recording does not hold.
pub(super) fn refuse_weights(
    part: &Part,
    weighing: &Weighing,
    recording: &Path,
) -> Result<(), Failure> {
    if part.criterion.weights == Weights::None || weighing.is_known() {
        return Ok(());
    }
    Err(format!(
        "{}: expected weights = \"none\" in the nominal, for points of a station carry no uncertainties unless they are \
         joined by time and [sync] has noise_nm; found \"uncertainty\"",
        recording.display()
    )
    .into())
}

/// A pipeline for the points of a source, which knows how well they are known where the nominal asks for it.
fn pipeline(
    part: Part,
    (along, tip): (Along, Option<Tip>),
    source: &Source,
) -> Result<Pipeline, Failure> {
    if part.criterion.weights == Weights::Uncertainty {
        check_uncertainties(&part, source)?;
    }
    let mut pipeline = Pipeline::along(part, along).with_tip(tip);
    match source.content() {
        Content::File(topography) => {
            let places = topography.points().map(|[x, ..]| x);
            pipeline.know_slopes(places.zip(topography.slopes().iter().copied()));
        }
        Content::Session(session) => pipeline.know_systematic(session.systematic()),
    }
    Ok(pipeline)
}

/// Measures the points of a source against a part.
pub(super) fn measured(
    part: Part,
    along: Along,
    source: &Source,
    progress: &Progress,
) -> Result<Measurement, Failure> {
    let tip = match source.content() {
        Content::File(_) => None,
        Content::Session(session) => session.tip(),
    };
    timed(part, (along, tip), source, None, progress).map(|(measurement, _)| measurement)
}

/// Measures the points of a source, in an order drawn from `seed` if there is one, and tells how long it took.
pub(super) fn timed(
    part: Part,
    (along, tip): (Along, Option<Tip>),
    source: &Source,
    seed: Option<u64>,
    progress: &Progress,
) -> Result<(Measurement, Timing), Failure> {
    let check = match source.content() {
        Content::File(topography) => UnitCheck::of(topography, &part),
        Content::Session(_) => None,
    };
    let weighing = match source.content() {
        Content::File(_) => Weighing::new(&part, None),
        Content::Session(session) => session.weighing(&part),
    };
    let mut pipeline = pipeline(part, (along, tip), source)?;
    let clock = Clock::start();
    let fed = feed(&mut pipeline, (source, tip), &weighing, seed, progress);
    let landed = clock.now();
    let mut measurement = pipeline.finish_by_steps(&mut |step| progress.step(step));
    let done = clock.now();
    let timing = Timing {
        total_s: done.as_secs_f64(),
        after_last_point_s: done.since(landed).as_secs_f64(),
        points_per_s: fed as f64 / done.as_secs_f64().max(1e-9),
        most_behind_s: 0.0,
    };
    match source.content() {
        Content::File(_) => {
            measurement.report.reading = source.reading();
            if let Some(check) = check {
                let points_mm: Vec<_> = source.points().collect();
                check.add(&points_mm, &mut measurement);
            }
        }
        Content::Session(session) => session.conclude(&mut measurement),
    }
    Ok((measurement, timing))
}

/// Hands all points of a source to a pipeline, piece by piece, and gives how many there were.
fn feed(
    pipeline: &mut Pipeline,
    (source, tip): (&Source, Option<Tip>),
    weighing: &Weighing,
    seed: Option<u64>,
    progress: &Progress,
) -> usize {
    match source.content() {
        Content::File(topography) => {
            let mut points = points_of(topography);
            if let Some(tip) = tip {
                points.iter_mut().for_each(|point| {
                    point.at_mm = tip.centre_mm(point.at_mm, [0.0, 0.0, 1.0]);
                });
            }
            shuffle(&mut points, seed);
            progress.count("meshing", Some(points.len() as u64));
            for piece in points.chunks(PIECE) {
                pipeline.take_positions(piece.iter().copied());
                progress.add(piece.len() as u64);
            }
            pipeline.take_gaps(topography.missing() as u64);
            points.len()
        }
        Content::Session(session) => {
            let mut points = Cow::Borrowed(session.points());
            if seed.is_some() {
                shuffle(points.to_mut(), seed);
            }
            progress.count("meshing", Some(points.len() as u64));
            for piece in points.chunks(PIECE) {
                piece.iter().for_each(|point| {
                    pipeline.take(weighing.weighed(point), point.reasons());
                });
                progress.add(piece.len() as u64);
            }
            points.len()
        }
    }
}

/// The mesh of the points of a source, without a nominal.
pub(super) fn meshed(source: &Source, progress: &Progress) -> Mesh {
    let points: Vec<[f64; 3]> = source.points().collect();
    let mut mesh = Mesh::new();
    progress.count("meshing", Some(points.len() as u64));
    for piece in points.chunks(PIECE) {
        mesh.extend(piece.iter().copied());
        progress.add(piece.len() as u64);
    }
    mesh.flush();
    mesh
}

/// Fisher and Yates's shuffle, driven by SplitMix64 (Steele, Lea, Flood, OOPSLA 2014). Without a seed nothing moves.
fn shuffle<T>(points: &mut [T], seed: Option<u64>) {
    let Some(mut state) = seed else { return };
    for last in (1..points.len()).rev() {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut draw = state;
        draw = (draw ^ (draw >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        draw = (draw ^ (draw >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        draw ^= draw >> 31;
        // A multiplication instead of a division: the bias is below 2^-32 for any file that fits memory.
        let other = (u128::from(draw) * (last as u128 + 1)) >> 64;
        points.swap(last, other as usize);
    }
}

/// The bytes of a file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    bytes_of(path).map_err(|error| format!("cannot read {}: {error}", path.display()).into())
}

/// Fails where `out` must not be written: it is one of the files that are read or a part of one, or it is there and not to be overwritten.
pub(super) fn refuse(
    out: &Path,
    read: impl IntoIterator<Item = impl AsRef<Path>>,
    overwrite: bool,
) -> Result<(), Failure> {
    let Ok(place) = out.canonicalize() else { return Ok(()) };
    let read = read.into_iter().filter_map(|path| path.as_ref().canonicalize().ok());
    for source in read {
        let found = if place == source {
            "is the file that is read; expected another"
        } else if place.parent() == Some(&source) && is_recording(&source) {
            "belongs to the recording that is read; expected another file"
        } else {
            continue;
        };
        return Err(format!("{} {found}", place.display()).into());
    }
    if !overwrite {
        return Err(format!("{} is there already; --force overwrites it", out.display()).into());
    }
    Ok(())
}

/// Of a command that reads none.
pub(super) const NO_FILES: [&Path; 0] = [];

/// Points are handed over by so many, so that progress moves. As many as the pipeline hands to the mesh at once.
const PIECE: usize = 65_536;
