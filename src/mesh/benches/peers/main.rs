//! The mesh against other Delaunay triangulations: one process, the same points, runs interleaved.
//!
//! `cargo bench -p asphera-mesh --bench peers -- --help` lists the options; `../README.md` says
//! what is measured and how to read it.

mod clock;
mod compare;
mod families;
mod large;
mod long;
mod memory;
mod orders;
mod ours;
mod peers;
mod report;
mod table;
mod worst;

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};

use crate::memory::Peak;
use crate::orders::{Order, Scan};
use crate::report::{Machine, Report};

fn main() -> ExitCode {
    let options = Options::parse();
    if let Some(peak) = options.peak {
        return memory::child(peak, options.scan(options.chosen()[0]), options.batch);
    }
    if let Some(points) = options.long {
        return long::measure(points.get(), &options);
    }
    if options.shuffled || options.worst.is_some() {
        let rows = options.worst.map(|each| worst::search(each, &options));
        let report = options.report_of(rows.unwrap_or_else(|| worst::named(&options)));
        report.print(options.json, |rows| {
            rows.iter().map(|row| worst::line(row) + "\n").collect::<String>()
        });
        return ExitCode::SUCCESS;
    }
    if options.large.is_some() {
        options.report(large::measure).print(options.json, table::large);
        return ExitCode::SUCCESS;
    }
    let report = options.report(compare::measure);
    report.print(options.json, table::comparison);
    if report.orders.iter().any(|row| row.triangles_agree == Some(false)) {
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// Meshes the same points with ours and with delaunator and spade, and prints times and memory.
#[derive(Parser)]
#[command(name = "peers")]
struct Options {
    /// Points of each order of arrival.
    #[arg(long, value_name = "N", default_value = "1000000")]
    points: NonZeroUsize,
    /// Measure only this order of arrival; may be given several times.
    #[arg(long, value_name = "NAME")]
    order: Vec<Order>,
    /// How often everything is measured; medians are printed.
    #[arg(long, value_name = "N", default_value = "5")]
    runs: NonZeroUsize,
    /// Points of a batch of ours.
    #[arg(long, value_name = "N", default_value = "1000")]
    batch: NonZeroUsize,
    /// Points of a batch of ours where two threads are to share it.
    #[arg(long, value_name = "N", default_value = "100000")]
    batch2: NonZeroUsize,
    /// Seed of the irregularities.
    #[arg(long, value_name = "N", default_value_t = 42)]
    seed: u64,
    /// Leave out spade.
    #[arg(long)]
    no_spade: bool,
    /// Leave out delaunator: outlines may take it very long.
    #[arg(long)]
    no_delaunator: bool,
    /// Print one JSON object in place of the tables.
    #[arg(long)]
    json: bool,
    /// Measure ours alone: N points, at least 10, against a tenth of them.
    #[arg(long, value_name = "N", conflicts_with_all = ["points", "no_spade"], value_parser = ten_or_more)]
    large: Option<NonZeroUsize>,
    /// Measure the mesh of a line scan of N points that memory has no room for.
    #[arg(long, value_name = "N", conflicts_with_all = ["points", "no_spade", "large", "order", "json"])]
    long: Option<NonZeroUsize>,
    /// Try so many orders of each family, ours alone against the same points shuffled.
    #[arg(long, value_name = "N", group = "against", conflicts_with_all = ["no_spade", "large", "long", "order"])]
    worst: Option<NonZeroUsize>,
    /// Measure the orders against the same points shuffled, ours alone.
    #[arg(long, group = "against", conflicts_with_all = ["no_spade", "large", "long"])]
    shuffled: bool,
    /// Try only this family; may be given several times.
    #[arg(long, value_name = "NAME", requires = "worst")]
    family: Vec<String>,
    /// Points of a batch; may be given several times. 1, 1,000 and all at once unless given.
    #[arg(long, value_name = "N", requires = "against")]
    batches: Vec<usize>,
    /// Megabytes (10^6 bytes) of memory the chunks of that mesh may take.
    #[arg(long, value_name = "MB", default_value = "1900", requires = "long")]
    memory_mb: NonZeroUsize,
    /// Folder of the file for the other chunks; that of temporary files unless given.
    #[arg(long, value_name = "FOLDER", requires = "long")]
    shelf: Option<PathBuf>,
    /// Be the child process whose peak of memory is measured.
    #[arg(long, hide = true)]
    peak: Option<Peak>,
    /// Given by `cargo bench` to every benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

impl Options {
    /// The orders to measure, all unless some are named.
    fn chosen(&self) -> Vec<Order> {
        if self.order.is_empty() { Order::value_variants().to_vec() } else { self.order.clone() }
    }

    /// Points of each order of arrival.
    fn count(&self) -> usize {
        self.large.unwrap_or(self.points).get()
    }

    fn scan(&self, order: Order) -> Scan {
        Scan { order, count: self.count(), seed: self.seed }
    }

    /// Measures the chosen orders one after the other.
    fn report<Row>(&self, measure: impl Fn(Scan, &Options) -> Row) -> Report<Row> {
        let chosen = self.chosen().into_iter();
        self.report_of(chosen.map(|order| measure(self.scan(order), self)).collect())
    }

    fn report_of<Row>(&self, orders: Vec<Row>) -> Report<Row> {
        Report {
            points: self.count(),
            seed: self.seed,
            runs: self.runs.get(),
            batch: self.batch.get(),
            batch2: self.batch2.get(),
            machine: Machine::this(),
            orders,
        }
    }
}

/// A number of points that has a tenth.
fn ten_or_more(text: &str) -> Result<NonZeroUsize, String> {
    let points: NonZeroUsize = text.parse().map_err(|error| format!("{error}"))?;
    if points.get() < 10 {
        Err("fewer than 10 points have no tenth".to_owned())
    } else {
        Ok(points)
    }
}
