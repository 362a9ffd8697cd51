//! The report: what was measured where, its figures, and how it is printed.

use std::fs;
use std::num::NonZeroUsize;
use std::thread::available_parallelism;

use serde::Serialize;

use crate::orders::Scan;
use crate::ours::Meshed;

/// One invocation of this benchmark.
#[derive(Serialize)]
pub(crate) struct Report<Row> {
    pub(crate) points: usize,
    pub(crate) seed: u64,
    pub(crate) runs: usize,
    pub(crate) batch: usize,
    /// Where two threads are to share a batch.
    pub(crate) batch2: usize,
    pub(crate) machine: Machine,
    pub(crate) orders: Vec<Row>,
}

/// Where it was measured.
#[derive(Serialize)]
pub(crate) struct Machine {
    /// Cores this process may use; `None` where the system does not say.
    cores: Option<usize>,
    /// The processor as `/proc/cpuinfo` names it; `None` elsewhere than on Linux.
    cpu: Option<String>,
}

impl Machine {
    pub(crate) fn this() -> Machine {
        let cpu = fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
        Machine { cores: available_parallelism().ok().map(NonZeroUsize::get), cpu }
    }
}

impl<Row: Serialize> Report<Row> {
    /// Prints the report to standard output, as JSON or as `table` has it.
    #[expect(clippy::print_stdout, reason = "the figures are what this program is for")]
    pub(crate) fn print(&self, json: bool, table: impl FnOnce(&[Row]) -> String) {
        if json {
            let text = serde_json::to_string_pretty(self).expect("no key of a report is a map");
            println!("{text}");
        } else {
            let Report { points, seed, runs, batch, batch2, machine, .. } = self;
            let cores = machine.cores.map_or_else(|| "-".to_owned(), |cores| cores.to_string());
            let cpu = machine.cpu.as_deref().unwrap_or("-");
            println!("{points} points an order, batches of {batch}, seed {seed}");
            println!("large batch and 2 threads: batches of {batch2}");
            println!("medians of {runs} runs; processor {cpu}, cores {cores}\n");
            println!("{}", table(&self.orders));
        }
    }
}

/// Times of the batches of ours in ms, by nearest rank.
#[derive(Serialize)]
pub(crate) struct BatchMs {
    pub(crate) p50: f64,
    pub(crate) p99: f64,
    pub(crate) max: f64,
}

impl BatchMs {
    /// Of all batches of all runs, of which there is at least one.
    pub(crate) fn of(runs: &[Meshed]) -> BatchMs {
        let mut batches_s: Vec<f64> = runs.iter().flat_map(|run| &run.batches_s).copied().collect();
        batches_s.sort_unstable_by(f64::total_cmp);
        let at = |percent: usize| 1e3 * batches_s[(batches_s.len() * percent).div_ceil(100) - 1];
        BatchMs { p50: at(50), p99: at(99), max: at(100) }
    }
}

/// The median; the mean of the two in the middle of an even number; `None` of nothing.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_unstable_by(f64::total_cmp);
    let upper = values.len() / 2;
    let lower = values.len().checked_sub(1)? / 2;
    Some((values[lower] + values[upper]) / 2.0)
}

/// Says on standard error what is measured now.
#[expect(clippy::print_stderr, reason = "a benchmark of minutes should show that it goes on")]
pub(crate) fn progress(scan: Scan, run: usize, runs: NonZeroUsize) {
    eprintln!("{}, {} points: run {run} of {runs}", scan.order.name(), scan.count);
}

/// Says on standard error what was found.
#[expect(clippy::print_stderr, reason = "a benchmark of minutes should show that it goes on")]
pub(crate) fn say(line: &str) {
    eprintln!("{line}");
}
