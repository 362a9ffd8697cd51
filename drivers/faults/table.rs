//! The matrix as tables of Markdown.

use std::fmt::Write as _;

use crate::{Fault, Outcome};

/// A driver and its outcomes, in the order of [`Fault::ALL`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// Name of the driver.
    pub driver: &'static str,
    /// Outcomes.
    pub outcomes: Vec<Outcome>,
}

/// Marker before the tables.
const BEGIN: &str = "<!-- The fault matrix: written by its test. -->";

/// Marker after the tables.
const END: &str = "<!-- End of the fault matrix. -->";

/// Drivers side by side in one table.
const COLUMNS: usize = 5;

/// Tables of faults by drivers, and the reasons of cells that stay empty.
pub fn table(rows: &[Row]) -> String {
    let mut reasons: Vec<&str> = Vec::new();
    let mut text = String::new();
    for rows in rows.chunks(COLUMNS.min(rows.len().div_ceil(3)).max(1)) {
        let heads: Vec<&str> = rows.iter().map(|row| row.driver).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| fault | {} |", heads.join(" | "));
        let _ = writeln!(text, "|---|{}", "---|".repeat(rows.len()));
        for (index, fault) in Fault::ALL.iter().enumerate() {
            let cells: Vec<String> = rows
                .iter()
                .map(|row| match &row.outcomes[index] {
                    Outcome::Played(cell, _) => cell.clone(),
                    Outcome::Absent(why) => {
                        let known = reasons.iter().position(|reason| reason == why);
                        let number = known.unwrap_or_else(|| {
                            reasons.push(why);
                            reasons.len() - 1
                        });
                        format!("– ({})", number + 1)
                    }
                })
                .collect();
            let _ = writeln!(text, "| {} | {} |", fault.name(), cells.join(" | "));
        }
        text.push('\n');
    }
    for (number, reason) in (1..).zip(&reasons) {
        let (first, rest) = reason.split_at(reason.len().min(1));
        let _ = writeln!(text, "{number}. {}{rest}.", first.to_uppercase());
    }
    text
}

/// A document with other text between the markers; `None` where it has no markers.
pub fn replaced(document: &str, text: &str) -> Option<String> {
    let (before, rest) = document.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n\n{text}\n{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_stay_empty_share_their_reasons() {
        let outcomes = |why| vec![Outcome::Absent(why); Fault::ALL.len()];
        let mut rows = vec![
            Row { driver: "a", outcomes: outcomes("no bus") },
            Row { driver: "b", outcomes: outcomes("no bus") },
        ];
        rows[1].outcomes[0] = Outcome::Played("reopened".into(), Vec::new());
        let text = table(&rows);
        assert!(text.contains("| unplugged and back | – (1) |"), "{text}");
        assert!(text.contains("| unplugged and back | reopened |"), "{text}");
        assert!(text.ends_with("\n1. No bus.\n"), "{text}");
    }

    #[test]
    fn only_what_lies_between_the_markers_is_replaced() {
        let document = format!("a\n{BEGIN}\nold\n{END}\nb\n");
        let text = replaced(&document, "new\n").unwrap_or_default();
        assert_eq!(text, format!("a\n{BEGIN}\n\nnew\n\n{END}\nb\n"));
        assert_eq!(replaced("a", "new"), None);
    }
}
