//! How columns and units of a file were read that leaves them open.

use serde::{Deserialize, Serialize};

/// Columns and units as a file was read whose format leaves them open, such as text or PLY.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReadingFigures {
    /// The columns that were read, x first.
    pub columns: Vec<ColumnFigures>,
    /// Origin of the names: `the file`, `the command line`, or nothing.
    pub named_by: String,
    /// Origin of the units.
    pub units_by: String,
    /// Whether mm is an assumption: neither file nor command line states a unit.
    pub units_assumed: bool,
    /// Whether decimals have a comma.
    pub decimal_commas: bool,
    /// Lines of text before the points that name neither columns nor units, and were not read.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lines_passed_over: u64,
    /// Doubts about the heights, in words: marks for no data that were left out, heights far from all others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cautions: Vec<String>,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// One column that was read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColumnFigures {
    /// `x`, `y`, `z`, `slope`, `u_z`.
    pub name: String,
    /// Its number in the file, from 1.
    pub number: u64,
    /// Its unit in the file.
    pub unit: String,
}
