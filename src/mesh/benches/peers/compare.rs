//! One order of arrival: ours and the others in turn, run by run, and the medians.

use std::num::NonZeroUsize;

use serde::Serialize;
use spade::Point2;

use crate::Options;
use crate::memory::bytes_per_point;
use crate::orders::{Order, Scan};
use crate::ours::{self, Meshed, TWO};
use crate::peers::{self, Triangulated};
use crate::report::{BatchMs, median, progress};

/// Measurements of an order of arrival. Times are medians; `None` was not measured.
#[derive(Serialize)]
pub(crate) struct Row {
    pub(crate) order: Order,
    pub(crate) points: usize,
    pub(crate) ours_s: f64,
    /// By the large batches, one thread and two.
    pub(crate) ours_large_s: Option<f64>,
    pub(crate) ours_two_threads_s: Option<f64>,
    pub(crate) delaunator_s: Option<f64>,
    /// The faster of spade's two bulk loads.
    pub(crate) spade_bulk_s: Option<f64>,
    pub(crate) spade_incremental_s: Option<f64>,
    /// Fewer than all where it was given up.
    pub(crate) spade_incremental_points: Option<usize>,
    pub(crate) spade_incremental_capped: Option<bool>,
    /// Time of delaunator over that of ours.
    pub(crate) ratio_delaunator: Option<f64>,
    pub(crate) ratio_two_threads: Option<f64>,
    /// Time of one thread over that of two, both by the large batches.
    pub(crate) ratio_threads: Option<f64>,
    pub(crate) bytes_per_point: Option<f64>,
    /// Of all batches of all runs of ours with one thread.
    pub(crate) batch_ms: BatchMs,
    pub(crate) triangles: Triangles,
    /// Whether all found as many triangles; `None` where ties let them differ.
    pub(crate) triangles_agree: Option<bool>,
}

/// How many triangles each found.
#[derive(Serialize)]
pub(crate) struct Triangles {
    pub(crate) ours: u64,
    pub(crate) ours_two_threads: Option<u64>,
    pub(crate) delaunator: Option<u64>,
    pub(crate) spade_bulk: Option<u64>,
    /// Of the points inserted.
    pub(crate) spade_incremental: Option<u64>,
}

pub(crate) fn measure(scan: Scan, options: &Options) -> Row {
    let bytes_per_point = bytes_per_point(scan, options.batch);
    let runs = Runs::take(scan, options);
    let ours_s = median(runs.ours.iter().map(Meshed::total_s)).expect("there is a run");
    let delaunator_s = median(runs.delaunator.iter().map(|run| run.seconds));
    let ours_large_s = median(runs.ours_large.iter().map(Meshed::total_s));
    let ours_two_threads_s = median(runs.ours_two_threads.iter().map(Meshed::total_s));
    let spade_bulk_s = [&runs.spade_bulk, &runs.spade_bulk_stable]
        .into_iter()
        .filter_map(|load| median(load.iter().map(|run| run.seconds)))
        .min_by(f64::total_cmp);
    let incremental = runs.spade_incremental.last();
    // Where one run was given up it was the last, and no median of whole runs.
    let capped = incremental.map(|run| run.points < scan.count);
    let spade_incremental_s = match (incremental, capped) {
        (Some(run), Some(true)) => Some(run.seconds),
        _ => median(runs.spade_incremental.iter().map(|run| run.seconds)),
    };
    Row {
        order: scan.order,
        points: scan.count,
        ours_s,
        ours_large_s,
        ours_two_threads_s,
        delaunator_s,
        spade_bulk_s,
        spade_incremental_s,
        spade_incremental_points: incremental.map(|run| run.points),
        spade_incremental_capped: capped,
        ratio_delaunator: delaunator_s.map(|theirs_s| theirs_s / ours_s),
        ratio_two_threads: delaunator_s
            .zip(ours_two_threads_s)
            .map(|(theirs_s, two_s)| theirs_s / two_s),
        ratio_threads: ours_large_s.zip(ours_two_threads_s).map(|(one_s, two_s)| one_s / two_s),
        bytes_per_point,
        batch_ms: BatchMs::of(&runs.ours),
        triangles: runs.triangles(),
        triangles_agree: scan.order.is_in_general_position().then(|| runs.agree(scan.count)),
    }
}

/// All runs of all implementations; empty where there were none.
#[derive(Default)]
struct Runs {
    ours: Vec<Meshed>,
    ours_large: Vec<Meshed>,
    ours_two_threads: Vec<Meshed>,
    delaunator: Vec<Triangulated>,
    spade_bulk: Vec<Triangulated>,
    spade_bulk_stable: Vec<Triangulated>,
    spade_incremental: Vec<Triangulated>,
}

impl Runs {
    fn take(scan: Scan, options: &Options) -> Runs {
        let (for_delaunator, for_spade) = inputs(scan, options);
        let mut runs = Runs::default();
        for run in 1..=options.runs.get() {
            progress(scan, run, options.runs);
            runs.ours.push(ours::mesh(scan, options.batch, NonZeroUsize::MIN));
            runs.ours_large.push(ours::mesh(scan, options.batch2, NonZeroUsize::MIN));
            runs.ours_two_threads.push(ours::mesh(scan, options.batch2, TWO));
            if !options.no_delaunator {
                runs.delaunator.push(peers::delaunator(&for_delaunator));
            }
            if options.no_spade {
                continue;
            }
            runs.spade_bulk.push(peers::spade_bulk(&for_spade));
            runs.spade_bulk_stable.push(peers::spade_bulk_stable(&for_spade));
            // What was given up once would be given up again.
            if runs.spade_incremental.iter().all(|run| run.points == scan.count) {
                runs.spade_incremental.push(peers::spade_incremental(&for_spade));
            }
        }
        runs
    }

    fn triangles(&self) -> Triangles {
        let first = |runs: &[Triangulated]| runs.first().map(|run| run.triangles);
        Triangles {
            ours: self.ours[0].triangles,
            ours_two_threads: self.ours_two_threads.first().map(|run| run.triangles),
            delaunator: first(&self.delaunator),
            spade_bulk: first(&self.spade_bulk),
            spade_incremental: self.spade_incremental.last().map(|run| run.triangles),
        }
    }

    /// Whether every run that took all points found as many triangles.
    fn agree(&self, count: usize) -> bool {
        let ours = [&self.ours, &self.ours_large, &self.ours_two_threads];
        let ours = ours.into_iter().flatten().map(|run| run.triangles);
        let theirs =
            [&self.delaunator, &self.spade_bulk, &self.spade_bulk_stable, &self.spade_incremental];
        let theirs =
            theirs.into_iter().flatten().filter(|run| run.points == count).map(|run| run.triangles);
        ours.chain(theirs).all(|triangles| triangles == self.ours[0].triangles)
    }
}

/// The points as each of the others wants them; none for one that is left out.
fn inputs(scan: Scan, options: &Options) -> (Vec<delaunator::Point>, Vec<Point2<f64>>) {
    let points: Vec<_> = scan.points().collect();
    let for_spade = if options.no_spade { Vec::new() } else { peers::for_spade(&points) };
    let for_delaunator =
        if options.no_delaunator { Vec::new() } else { peers::for_delaunator(&points) };
    (for_delaunator, for_spade)
}
