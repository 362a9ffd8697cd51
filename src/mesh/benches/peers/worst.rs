//! Orders of arrival against the same points shuffled, ours alone: named ones, and a search for those that cost more.

use std::num::NonZeroUsize;

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use rayon::ThreadPoolBuilder;
use serde::Serialize;

use crate::Options;
use crate::clock::{timed, working};
use crate::families::{Draw, FAMILIES, Place};
use crate::report::median;
use crate::table::dash;

/// An order that was tried, by batches of one size.
#[derive(Serialize)]
pub(crate) struct Row {
    pub(crate) family: String,
    pub(crate) parameters: String,
    pub(crate) batch: usize,
    /// Median of the shuffled points, and of the ratios to it; at least so much where the order was given up.
    pub(crate) shuffled_s: f64,
    pub(crate) ratio: f64,
    /// The same by the wall clock: others on the machine show.
    pub(crate) wall_ratio: f64,
    pub(crate) given_up: bool,
    /// Triangles that were not there after the batch before, a point: no mesh that is current after every batch makes
    /// fewer. `None` where the order was given up.
    pub(crate) triangles: Option<f64>,
    pub(crate) shuffled_triangles: Option<f64>,
}

/// An order is given up where it takes so many times as long as the shuffled one.
const GIVEN_UP: f64 = 20.0;

/// Tries so many orders of each family, each by all sizes of batches; the worst come first.
pub(crate) fn search(each: NonZeroUsize, options: &Options) -> Vec<Row> {
    let mut rows = Vec::new();
    for (index, &(family, draw_one)) in FAMILIES.iter().enumerate() {
        if !options.family.is_empty() && !options.family.iter().any(|name| name == family) {
            continue;
        }
        let seed = options.seed ^ (index as u64) << 32;
        let mut draw = Draw(Pcg64::seed_from_u64(seed));
        for _ in 0..each.get() {
            let (parameters, places) = draw_one(&mut draw, options.points.get());
            rows.extend(rows_of([family, &parameters], &lifted(&places), &mut draw, options));
        }
    }
    worst_first(rows)
}

/// Tries the chosen orders but for those that are shuffled, each by all sizes of batches; the worst come first.
pub(crate) fn named(options: &Options) -> Vec<Row> {
    let mut rows = Vec::new();
    for order in options.chosen().into_iter().filter(|order| !order.is_shuffled()) {
        let mut draw = Draw(Pcg64::seed_from_u64(options.seed));
        let points: Vec<PointMm> = options.scan(order).points().collect();
        rows.extend(rows_of(["order", &order.name()], &points, &mut draw, options));
    }
    worst_first(rows)
}

/// One order by all sizes of batches.
fn rows_of(name: [&str; 2], points: &[PointMm], draw: &mut Draw, options: &Options) -> Vec<Row> {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
    let mut shuffled = points.to_vec();
    draw.shuffle(&mut shuffled);
    let all = vec![1, 1000, points.len()];
    let batches = if options.batches.is_empty() { &all } else { &options.batches };
    let row = |&batch: &usize| {
        let compare = || compare(name, [points, &shuffled], batch, options.runs.get());
        let row = pool.install(compare);
        crate::report::say(&line(&row));
        row
    };
    batches.iter().map(row).collect()
}

fn worst_first(mut rows: Vec<Row>) -> Vec<Row> {
    rows.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    rows
}

fn lifted(places: &[Place]) -> Vec<PointMm> {
    places.iter().map(|&[x, y]| [x, y, 0.0]).collect()
}

/// Runs by turns: shuffled, in order, shuffled, …
fn compare(
    [family, parameters]: [&str; 2],
    [points, shuffled]: [&[PointMm]; 2],
    batch: usize,
    runs: usize,
) -> Row {
    let (mut shuffled_s, mut ratios, mut given_up) = (Vec::new(), [Vec::new(), Vec::new()], false);
    for _ in 0..runs {
        let base = mesh(shuffled, batch, f64::INFINITY);
        let ours = mesh(points, batch, GIVEN_UP * base.worked_s);
        shuffled_s.push(base.worked_s);
        ratios[0].push(ours.worked_s / base.worked_s);
        ratios[1].push(ours.wall_s / base.wall_s);
        given_up |= ours.worked_s > GIVEN_UP * base.worked_s;
        if given_up {
            break;
        }
    }
    let [ratio, wall_ratio] = ratios.map(|ratios| median(ratios).expect("there is a run"));
    Row {
        family: family.to_owned(),
        parameters: parameters.to_owned(),
        batch,
        shuffled_s: median(shuffled_s).expect("there is a run"),
        ratio,
        wall_ratio,
        given_up,
        triangles: (!given_up).then(|| made(points, batch)),
        shuffled_triangles: (!given_up).then(|| made(shuffled, batch)),
    }
}

/// Time of a mesh by the thread's own clock and by that on the wall.
struct Cost {
    worked_s: f64,
    wall_s: f64,
}

/// Meshes points by batches, or until that was too much work.
fn mesh(points: &[PointMm], batch: usize, most_s: f64) -> Cost {
    let mut mesh = Mesh::new();
    // The clock is read a few times only, as that takes time.
    let often = points.len().div_ceil(batch).div_ceil(64);
    let (worked_s, wall_s) = timed(|| {
        let start_s = working();
        for (index, batch) in points.chunks(batch).enumerate() {
            mesh.insert(batch);
            if index % often == 0 && working() - start_s > most_s {
                break;
            }
        }
        working() - start_s
    });
    Cost { worked_s, wall_s }
}

/// How many triangles a point came to be with a batch; of more batches than are counted one in so many is.
///
/// A triangle of old vertices alone that is Delaunay now was so before: so the new ones are those with a new corner.
fn made(points: &[PointMm], batch: usize) -> f64 {
    // An odd number, which meets all lines of those that arrive by turns.
    let stride = (points.len().div_ceil(batch) / MOST_COUNTED) | 1;
    let mut mesh = Mesh::new();
    let (mut made, mut counted) = (0, 0);
    for (index, batch) in points.chunks(batch).enumerate() {
        let first = mesh.points().len() as u32;
        mesh.insert(batch);
        if index % stride > 0 {
            continue;
        }
        counted += batch.len();
        let now = mesh.now();
        let written = mesh.written().enumerate().filter(|&(_, moment)| moment == now);
        let chunks: Vec<usize> = written.map(|(chunk, _)| chunk).collect();
        made += chunks
            .into_iter()
            .flat_map(|chunk| mesh.triangles_of(chunk))
            .filter(|corners| corners.iter().any(|&corner| corner >= first))
            .count();
    }
    made as f64 / counted as f64
}

/// Batches of which triangles are counted, about.
const MOST_COUNTED: usize = 1000;

/// A row in words.
pub(crate) fn line(row: &Row) -> String {
    let Row {
        family,
        parameters,
        batch,
        shuffled_s,
        ratio,
        wall_ratio,
        given_up,
        triangles,
        shuffled_triangles,
    } = row;
    let [new, new_shuffled] =
        [triangles, shuffled_triangles].map(|count| dash(*count, |count| format!("{count:.1}")));
    let more = if *given_up { ">" } else { " " };
    format!(
        "{more}{ratio:6.2} (wall {wall_ratio:5.2})  by {batch:>7}  triangles {new:>6} / {new_shuffled:>4}  shuffled {shuffled_s:.3} s  {family}: {parameters}"
    )
}
