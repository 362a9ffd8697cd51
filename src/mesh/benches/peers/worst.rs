//! A search for orders of arrival that cost more than the same points shuffled: ours alone.

use std::num::NonZeroUsize;

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use rayon::ThreadPoolBuilder;
use serde::Serialize;

use crate::Options;
use crate::clock::working;
use crate::families::{Draw, FAMILIES, Place};
use crate::report::median;

/// An order that was tried, by batches of one size.
#[derive(Serialize)]
pub(crate) struct Row {
    pub(crate) family: &'static str,
    pub(crate) parameters: String,
    pub(crate) batch: usize,
    /// Median of the shuffled points, and of the ratios to it; at least so much where the order was given up.
    pub(crate) shuffled_s: f64,
    pub(crate) ratio: f64,
    pub(crate) given_up: bool,
    /// Triangles that were not there after the batch before, a point: no mesh that is current after every batch makes
    /// fewer.
    pub(crate) triangles: f64,
    pub(crate) shuffled_triangles: f64,
}

/// An order is given up where it takes so many times as long as the shuffled one.
const GIVEN_UP: f64 = 20.0;

/// Tries so many orders of each family, each by all sizes of batches; the worst come first.
pub(crate) fn search(each: NonZeroUsize, options: &Options) -> Vec<Row> {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
    let count = options.points.get();
    let batches =
        if options.batches.is_empty() { vec![1, 1000, count] } else { options.batches.clone() };
    let mut rows = Vec::new();
    for (index, &(family, draw_one)) in FAMILIES.iter().enumerate() {
        if !options.family.is_empty() && !options.family.iter().any(|name| name == family) {
            continue;
        }
        let seed = options.seed ^ (index as u64) << 32;
        let mut draw = Draw(Pcg64::seed_from_u64(seed));
        for _ in 0..each.get() {
            let (parameters, places) = draw_one(&mut draw, count);
            let points = lifted(&places);
            let mut shuffled = points.clone();
            draw.shuffle(&mut shuffled);
            for &batch in &batches {
                let row = pool.install(|| {
                    compare(family, &parameters, &points, &shuffled, batch, options.runs.get())
                });
                crate::report::say(&line(&row));
                rows.push(row);
            }
        }
    }
    rows.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    rows
}

fn lifted(places: &[Place]) -> Vec<PointMm> {
    places.iter().map(|&[x, y]| [x, y, 0.0]).collect()
}

fn compare(
    family: &'static str,
    parameters: &str,
    points: &[PointMm],
    shuffled: &[PointMm],
    batch: usize,
    runs: usize,
) -> Row {
    let (mut shuffled_s, mut ratios, mut given_up) = (Vec::new(), Vec::new(), false);
    for _ in 0..runs {
        let base_s = mesh(shuffled, batch, f64::INFINITY);
        let ours_s = mesh(points, batch, GIVEN_UP * base_s);
        shuffled_s.push(base_s);
        ratios.push(ours_s / base_s);
        given_up |= ours_s > GIVEN_UP * base_s;
        if given_up {
            break;
        }
    }
    Row {
        family,
        parameters: parameters.to_owned(),
        batch,
        shuffled_s: median(shuffled_s).expect("there is a run"),
        ratio: median(ratios).expect("there is a run"),
        given_up,
        triangles: made(points, batch),
        shuffled_triangles: made(shuffled, batch),
    }
}

/// Seconds of work by the batches, or until they were too many.
fn mesh(points: &[PointMm], batch: usize, most_s: f64) -> f64 {
    let mut mesh = Mesh::new();
    let start_s = working();
    // The clock is read a few times only, as that takes time.
    let often = points.len().div_ceil(batch).div_ceil(64);
    for (index, batch) in points.chunks(batch).enumerate() {
        mesh.insert(batch);
        if index % often == 0 && working() - start_s > most_s {
            break;
        }
    }
    working() - start_s
}

/// How many triangles a point came to be with a batch, by batches.
///
/// A triangle of old vertices alone that is Delaunay now was so before: so the new ones are those with a new corner.
fn made(points: &[PointMm], batch: usize) -> f64 {
    let mut mesh = Mesh::new();
    let mut made = 0;
    for batch in points.chunks(batch) {
        let first = mesh.points().len() as u32;
        mesh.insert(batch);
        let now = mesh.now();
        let written = mesh.written().enumerate().filter(|&(_, moment)| moment == now);
        let chunks: Vec<usize> = written.map(|(chunk, _)| chunk).collect();
        made += chunks
            .into_iter()
            .flat_map(|chunk| mesh.triangles_of(chunk))
            .filter(|corners| corners.iter().any(|&corner| corner >= first))
            .count();
    }
    made as f64 / points.len() as f64
}

/// A row in words.
pub(crate) fn line(row: &Row) -> String {
    let Row {
        family,
        parameters,
        batch,
        shuffled_s,
        ratio,
        given_up,
        triangles,
        shuffled_triangles,
    } = row;
    let more = if *given_up { ">" } else { " " };
    format!(
        "{more}{ratio:6.2}  by {batch:>7}  triangles {triangles:6.1} / {shuffled_triangles:4.1}  shuffled {shuffled_s:.3} s  {family}: {parameters}"
    )
}
