//! The graph method for files that memory has no room for.

use std::fs::File;
use std::io::Read as _;

use asphera_formats::ply::VertexRecords;
use asphera_reconstruct::{Reconstruction, Stage, TiledGraph, prove};

use super::figures::ReconstructReport;
use super::graph::Stages;
use super::shelf::DiskShelf;
use super::{Made, ReconstructArgs};
use crate::cli::output::Failure;
use crate::cli::progress::Progress;
use crate::cli::source::{Source, is_recording};
use crate::clock::Clock;

/// The surface by tiles of some megabytes of memory. Its points are the landmarks.
pub(super) fn made(args: &ReconstructArgs, megabytes: u32) -> Result<Made, Failure> {
    let progress = Progress::start("reconstruct");
    let clock = Clock::start();
    let mut stages = Stages::new(&clock);
    stages.enter(Stage::Tree);
    let mut graph = args.graph.by_tiles(DiskShelf::new(&std::env::temp_dir())?, megabytes)?;
    let points = take(args, &mut graph, &progress)?;
    let found = graph.surface(&args.graph.choices(), &mut |stage| {
        progress.stage(words(stage));
        stages.enter(stage);
    })?;
    if let Some(why) = found.no_surface {
        return Err(format!("{}: {why}", args.source.display()).into());
    }
    let surface = Reconstruction { facets: found.facets, left_out: Vec::new() };
    let points_mm = found.landmarks_mm;
    let surface = match args.toward {
        Some(way) => surface.facing(&points_mm, way),
        None => surface,
    };
    let meshed = clock.now();
    let stages = stages.end();
    progress.stage("proving");
    let proof = prove(&points_mm, &surface.facets)?;
    let times_s = [meshed.as_secs_f64(), clock.now().since(meshed).as_secs_f64()];
    let file = args.source.display().to_string();
    let report = ReconstructReport::new(file, &points_mm, &surface, &proof, times_s)
        .with_stages(Some(stages))
        .with_tiles(points, &found.left_out, found.tiles);
    Ok((report, points_mm, surface.facets))
}

/// Hands all points of the source to a graph; gives how many there are.
fn take(
    args: &ReconstructArgs,
    graph: &mut TiledGraph<DiskShelf>,
    progress: &Progress,
) -> Result<usize, Failure> {
    if let Some(points) = take_records(args, graph, progress)? {
        return Ok(points);
    }
    let source = Source::open(&args.source, &args.text, progress)?;
    source.say_reading();
    progress.count("sorting", None);
    let (mut points, mut part) = (0, Vec::with_capacity(READ_AT_ONCE));
    let mut all = source.points();
    loop {
        part.clear();
        part.extend(all.by_ref().take(READ_AT_ONCE));
        if part.is_empty() {
            return Ok(points);
        }
        points += part.len();
        graph.take(&part)?;
        progress.add(part.len() as u64);
    }
}

/// The same of a binary PLY file, which is read some points at a time; `None` of any other source.
fn take_records(
    args: &ReconstructArgs,
    graph: &mut TiledGraph<DiskShelf>,
    progress: &Progress,
) -> Result<Option<usize>, Failure> {
    let path = &args.source;
    if path.is_dir() || is_recording(path) {
        return Ok(None);
    }
    let name = path.display();
    let failed = |error: std::io::Error| format!("cannot read {name}: {error}");
    let mut file = File::open(path).map_err(failed)?;
    // A pipe cannot be begun again.
    let metadata = file.metadata().map_err(failed)?;
    if !metadata.is_file() {
        return Ok(None);
    }
    let mut bytes = Vec::new();
    file.by_ref().take(MOST_HEADER_BYTES).read_to_end(&mut bytes).map_err(failed)?;
    let records = VertexRecords::found_in(&bytes, &args.text.options())
        .map_err(|error| format!("{name}: {error}"))?;
    let Some(records) = records else { return Ok(None) };
    records.check_length(metadata.len()).map_err(|error| format!("{name}: {error}"))?;
    bytes.drain(..records.first_byte());
    progress.count("reading", Some(records.count()));
    let (mut points, mut first) = (0, 0);
    while first < records.count() {
        let count = (records.count() - first).min(READ_AT_ONCE as u64);
        let wanted = count as usize * records.record_bytes();
        let missing = wanted.saturating_sub(bytes.len());
        file.by_ref().take(missing as u64).read_to_end(&mut bytes).map_err(failed)?;
        let own = &bytes[..wanted.min(bytes.len())];
        if own.len() < wanted {
            let index = first + (own.len() / records.record_bytes()) as u64;
            return Err(format!("{name}: {}", records.ended(index)).into());
        }
        let found = records.points_mm(own, first).map_err(|error| format!("{name}: {error}"))?;
        points += found.len();
        graph.take(&found)?;
        progress.add(count);
        bytes.drain(..wanted);
        first += count;
    }
    Ok(Some(points))
}

fn words(stage: Stage) -> &'static str {
    match stage {
        Stage::Tree => "cutting tiles",
        Stage::Neighbours => "finding neighbours",
        Stage::Landmarks => "choosing landmarks",
        Stage::Cells => "finding cells",
        Stage::Map | Stage::Faces => "finding faces",
        Stage::Triangles | Stage::PutBack => "cutting faces",
    }
}

/// A header is no longer than this.
const MOST_HEADER_BYTES: u64 = 1 << 16;
/// Points that are read at once.
const READ_AT_ONCE: usize = 1 << 16;
