//! A report in a terminal: the short summary, or all of it.

use asphera_report::words::{self, MINUS, NARROW};
use asphera_report::{Block, Chapter, ChapterId, Fact, Layout, Report, Table, View};

/// What must be known of a measurement, in a few lines; all of it with `details`.
pub(super) fn summary(report: &Report, details: bool) -> String {
    let view = View::of_report(report);
    if details { all_of(&view) } else { brief(&view) }
}

/// The short lines of each chapter behind its name.
pub(super) fn brief(view: &View) -> String {
    let mut text = String::new();
    for chapter in &view.chapters {
        let name = chapter.id.word();
        if chapter.id == ChapterId::Verdict {
            text.push_str(&verdict(name, &chapter.brief));
            continue;
        }
        for (number, line) in chapter.brief.iter().enumerate() {
            let name = if number == 0 { name } else { "" };
            text.push_str(&format!("{name:<10} {}\n", plain(line)));
        }
    }
    text
}

/// The word of the verdict, with its checks below it.
fn verdict(name: &str, lines: &[String]) -> String {
    let mut text = String::new();
    for (number, line) in lines.iter().enumerate() {
        text.push_str(&match number {
            0 => format!("{name:<10} {}\n", plain(line)),
            _ => format!("  {}\n", plain(line)),
        });
    }
    text
}

/// Every chapter with its heading. Long explanations stand on paper alone.
fn all_of(view: &View) -> String {
    let mut text = String::new();
    for chapter in &view.chapters {
        text.push_str(&format!("{}\n", chapter.title.to_uppercase()));
        text.push_str(&blocks(chapter));
        text.push('\n');
    }
    if let Some(chapter) = view.chapter(ChapterId::Verdict) {
        text.push_str(&verdict(chapter.id.word(), &chapter.brief));
    }
    text
}

fn blocks(chapter: &Chapter) -> String {
    let mut text = String::new();
    for block in &chapter.blocks {
        text.push_str(&match block {
            Block::Facts { facts } => pairs(facts),
            Block::Table(table) => rows(table),
            Block::Note { text } => wrapped("", text),
            Block::Caution { text } => wrapped("caution: ", text),
        });
    }
    text
}

/// The tables of a chapter, as of the regions to measure next.
pub(super) fn tables(view: &View, id: ChapterId) -> String {
    let blocks = view.chapter(id).map_or(&[][..], |chapter| &chapter.blocks);
    let tables = blocks.iter().filter_map(|block| match block {
        Block::Table(table) => Some(rows(table)),
        _ => None,
    });
    tables.collect()
}

fn pairs(facts: &[Fact]) -> String {
    let width = facts.iter().map(|fact| fact.name.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for fact in facts {
        text.push_str(&format!("  {:<width$}  {}\n", fact.name, plain(&fact.value)));
        if let Some(note) = &fact.note {
            text.push_str(&wrapped(&" ".repeat(width + 2), note));
        }
    }
    text
}

/// Rows under their heads, numbers to the right.
fn rows(table: &Table) -> String {
    let columns: Vec<usize> = (0..table.columns.len())
        .filter(|&column| table.columns[column].layout != Layout::Fine)
        .collect();
    let head: Vec<String> = table.columns.iter().map(|column| column.title.clone()).collect();
    let lines = || std::iter::once(&head).chain(&table.rows);
    let width = |column: usize| lines().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = columns.iter().map(|&column| width(column)).collect();
    let mut text = String::new();
    if let Some(title) = &table.title {
        text.push_str(&format!("  {title}:\n"));
    }
    for row in lines() {
        let mut line = String::from("  ");
        for (&column, &width) in columns.iter().zip(&widths) {
            let (cell, layout) = (plain(&row[column]), table.columns[column].layout);
            line.push_str(&match layout {
                Layout::Number => format!("{cell:>width$}  "),
                _ => format!("{cell:<width$}  "),
            });
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// Words in lines of [`WIDTH`], all behind the same margin.
fn wrapped(begin: &str, words: &str) -> String {
    let margin = " ".repeat(2 + begin.chars().count());
    let (mut text, mut line) = (String::new(), format!("  {begin}"));
    let mut is_empty = true;
    for word in plain(words).split(' ') {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            text.push_str(&line);
            text.push('\n');
            (line, is_empty) = (margin.clone(), true);
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    text.push_str(&line);
    text.push('\n');
    text
}

/// Four significant digits, with the signs of a keyboard.
pub(super) fn short(value: f64) -> String {
    plain(&words::short(value))
}

/// Words with the signs of a keyboard: numbers can be searched for and copied.
pub(super) fn plain(words: &str) -> String {
    words
        .chars()
        .filter(|&sign| sign != NARROW)
        .map(|sign| if sign == MINUS { '-' } else { sign })
        .collect()
}

/// Characters of a line of words.
const WIDTH: usize = 100;

#[cfg(test)]
mod tests {
    use asphera_report::Column;

    use super::*;

    #[test]
    fn numbers_are_right_and_explanations_left_out() {
        let column = |title: &str, layout| Column { title: title.to_owned(), layout };
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        let table = Table {
            title: Some("Figures".to_owned()),
            columns: vec![
                column("figure", Layout::Head),
                column("value", Layout::Number),
                column("definition", Layout::Fine),
            ],
            rows: vec![
                row(["PV", "\u{2212}1\u{202f}234 nm", "largest"]),
                row(["RMSi", "7 nm", ""]),
            ],
        };
        assert_eq!(
            rows(&table),
            "  Figures:\n  figure      value\n  PV       -1234 nm\n  RMSi         7 nm\n"
        );
    }

    #[test]
    fn long_words_are_wrapped_behind_their_margin() {
        let text = wrapped("caution: ", &"word ".repeat(30));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|line| line.chars().count() <= WIDTH), "{text}");
        assert!(lines[1].starts_with("           word"), "{text}");
        assert_eq!(wrapped("", &"x".repeat(200)).lines().count(), 1, "a word is never cut");
    }
}
