//! One order of arrival, ours alone: many points against a tenth of them.

use std::num::NonZeroUsize;

use serde::Serialize;

use crate::Options;
use crate::memory::bytes_per_point;
use crate::orders::{Order, Scan};
use crate::ours::{self, TWO};
use crate::report::{median, progress};

/// Measurements of an order of arrival. Times are medians; `None` was not measured.
#[derive(Serialize)]
pub(crate) struct Row {
    pub(crate) order: Order,
    pub(crate) points: usize,
    pub(crate) tenth_points: usize,
    pub(crate) one_thread: Growth,
    pub(crate) two_threads: Option<Growth>,
    pub(crate) bytes_per_point: Option<f64>,
}

/// Time of all points against time of a tenth of them.
#[derive(Serialize)]
pub(crate) struct Growth {
    pub(crate) seconds: f64,
    pub(crate) tenth_seconds: f64,
    /// Ten where the time grows as the points do.
    pub(crate) ratio: f64,
}

/// Measures the scan and one of a tenth of its points, which is whole in itself and not the first
/// tenth of the other.
pub(crate) fn measure(scan: Scan, options: &Options) -> Row {
    let tenth = Scan { count: scan.count / 10, ..scan };
    let bytes_per_point = bytes_per_point(scan, options.batch);
    let mut one_thread = Runs::default();
    let mut two_threads = Runs::default();
    for run in 1..=options.runs.get() {
        progress(scan, run, options.runs);
        for (runs, batch, threads) in [
            (&mut one_thread, options.batch, NonZeroUsize::MIN),
            (&mut two_threads, options.batch2, TWO),
        ] {
            let total_s = |scan| ours::mesh(scan, batch, threads).total_s();
            runs.tenth_s.push(total_s(tenth));
            runs.all_s.push(total_s(scan));
        }
    }
    Row {
        order: scan.order,
        points: scan.count,
        tenth_points: tenth.count,
        one_thread: one_thread.growth().expect("there is a run with one thread"),
        two_threads: two_threads.growth(),
        bytes_per_point,
    }
}

#[derive(Default)]
struct Runs {
    all_s: Vec<f64>,
    tenth_s: Vec<f64>,
}

impl Runs {
    fn growth(self) -> Option<Growth> {
        let seconds = median(self.all_s)?;
        let tenth_seconds = median(self.tenth_s)?;
        Some(Growth { seconds, tenth_seconds, ratio: seconds / tenth_seconds })
    }
}
