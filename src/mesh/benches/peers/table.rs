//! The tables for people.

use crate::{compare, large};

/// Times, ratios and memory of ours and the others, then their counts of triangles.
pub(crate) fn comparison(rows: &[compare::Row]) -> String {
    let mut times = Table::new(&[
        "seconds",
        "ours",
        "large batch",
        "2 threads",
        "delaunator",
        "spade bulk",
        "spade one by one",
        "del./ours",
        "del./2 thr.",
        "large/2 thr.",
        "bytes/point",
        "batch ms p50",
        "p99",
        "max",
    ]);
    let mut counts = Table::new(&[
        "triangles",
        "ours",
        "2 threads",
        "delaunator",
        "spade bulk",
        "spade one by one",
        "agree",
    ]);
    for row in rows {
        times.push([
            row.order.name(),
            decimals(3, row.ours_s),
            dash(row.ours_large_s, |large_s| decimals(3, large_s)),
            dash(row.ours_two_threads_s, |two_s| decimals(3, two_s)),
            dash(row.delaunator_s, |theirs_s| decimals(3, theirs_s)),
            dash(row.spade_bulk_s, |bulk_s| decimals(3, bulk_s)),
            spade_incremental(row),
            dash(row.ratio_delaunator, |ratio| decimals(2, ratio)),
            dash(row.ratio_two_threads, |ratio| decimals(2, ratio)),
            dash(row.ratio_threads, |ratio| decimals(2, ratio)),
            dash(row.bytes_per_point, |bytes| decimals(0, bytes)),
            decimals(3, row.batch_ms.p50),
            decimals(3, row.batch_ms.p99),
            decimals(3, row.batch_ms.max),
        ]);
        counts.push([
            row.order.name(),
            row.triangles.ours.to_string(),
            dash(row.triangles.ours_two_threads, |count| count.to_string()),
            dash(row.triangles.delaunator, |count| count.to_string()),
            dash(row.triangles.spade_bulk, |count| count.to_string()),
            dash(row.triangles.spade_incremental, |count| {
                if row.spade_incremental_capped == Some(true) {
                    format!("({count})")
                } else {
                    count.to_string()
                }
            }),
            dash(row.triangles_agree, |agree| if agree { "yes" } else { "NO" }.to_owned()),
        ]);
    }
    format!("{}\n{}", times.text(), counts.text())
}

/// Times of ours and of a tenth of the points.
pub(crate) fn large(rows: &[large::Row]) -> String {
    let mut table = Table::new(&[
        "seconds",
        "points",
        "tenth",
        "one thread",
        "tenth",
        "ratio",
        "2 threads",
        "tenth",
        "ratio",
        "bytes/point",
    ]);
    for row in rows {
        let two = row.two_threads.as_ref();
        table.push([
            row.order.name(),
            row.points.to_string(),
            row.tenth_points.to_string(),
            decimals(3, row.one_thread.seconds),
            decimals(3, row.one_thread.tenth_seconds),
            decimals(2, row.one_thread.ratio),
            dash(two, |growth| decimals(3, growth.seconds)),
            dash(two, |growth| decimals(3, growth.tenth_seconds)),
            dash(two, |growth| decimals(2, growth.ratio)),
            dash(row.bytes_per_point, |bytes| decimals(0, bytes)),
        ]);
    }
    table.text()
}

/// The time, or how far spade came before it was given up.
fn spade_incremental(row: &compare::Row) -> String {
    match (row.spade_incremental_s, row.spade_incremental_points) {
        (Some(seconds), Some(points)) if row.spade_incremental_capped == Some(true) => {
            format!("capped: {points} at {:.0}/s", points as f64 / seconds)
        }
        (seconds, _) => dash(seconds, |seconds| decimals(3, seconds)),
    }
}

fn decimals(places: usize, value: f64) -> String {
    format!("{value:.places$}")
}

/// What was not measured is a dash.
pub(crate) fn dash<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), text)
}

/// Rows of cells under a heading, each column as wide as its widest cell.
struct Table<const COLUMNS: usize> {
    rows: Vec<[String; COLUMNS]>,
}

impl<const COLUMNS: usize> Table<COLUMNS> {
    fn new(heading: &[&str; COLUMNS]) -> Table<COLUMNS> {
        Table { rows: vec![heading.map(str::to_owned)] }
    }

    fn push(&mut self, row: [String; COLUMNS]) {
        self.rows.push(row);
    }

    /// The first column is flush left, the others right.
    fn text(&self) -> String {
        let width = |column: usize| self.rows.iter().map(|row| row[column].len()).max();
        let widths: [usize; COLUMNS] = std::array::from_fn(|column| width(column).unwrap_or(0));
        let mut text = String::new();
        for row in &self.rows {
            text += &format!("{:<1$}", row[0], widths[0]);
            for (cell, width) in row.iter().zip(widths).skip(1) {
                text += &format!("  {cell:>width$}");
            }
            text.push('\n');
        }
        text
    }
}
