//! Facts, tables and notes of a chapter as HTML.

use std::fmt::{Result, Write as _};

use asphera_report::{Block, Fact, Layout, Table};

use super::words::text;

/// The blocks in their order.
pub(super) fn draw(out: &mut String, blocks: &[Block]) -> Result {
    blocks.iter().try_for_each(|block| match block {
        Block::Facts { facts } => pairs(out, facts),
        Block::Table(table) => rows(out, table),
        Block::Note { text: note } => writeln!(out, "<p class=\"note\">{}</p>", text(note)),
        Block::Caution { text: caution } => {
            writeln!(out, "<p class=\"caution\"><b>Caution:</b> {}</p>", text(caution))
        }
    })
}

/// Names with their values, in two columns.
fn pairs(out: &mut String, facts: &[Fact]) -> Result {
    out.push_str("<div class=\"columns\">\n");
    for half in facts.chunks(facts.len().div_ceil(2).max(1)) {
        out.push_str("<table class=\"pairs\"><tbody>\n");
        for fact in half {
            let note = fact.note.as_ref().map_or(String::new(), |note| {
                format!("<br/><span class=\"note\">{}</span>", text(note))
            });
            writeln!(
                out,
                "<tr><th>{}</th><td{}>{}{note}</td></tr>",
                text(&fact.name),
                if fact.bad { " class=\"bad\"" } else { "" },
                text(&fact.value)
            )?;
        }
        out.push_str("</tbody></table>\n");
    }
    out.push_str("</div>\n");
    Ok(())
}

fn rows(out: &mut String, table: &Table) -> Result {
    if let Some(title) = &table.title {
        writeln!(out, "<h3>{}</h3>", text(title))?;
    }
    let is_wide = table.columns.iter().any(|column| column.layout == Layout::Fine);
    writeln!(out, "<table{}><thead><tr>", if is_wide { " class=\"wide\"" } else { "" })?;
    for column in &table.columns {
        let class = if column.layout == Layout::Number { " class=\"n\"" } else { "" };
        write!(out, "<th{class}>{}</th>", text(&column.title))?;
    }
    out.push_str("</tr></thead><tbody>\n");
    for row in &table.rows {
        out.push_str("<tr>");
        for (cell, column) in row.iter().zip(&table.columns) {
            let cell = text(cell);
            match column.layout {
                Layout::Head => write!(out, "<th>{cell}</th>")?,
                Layout::Text => write!(out, "<td>{cell}</td>")?,
                Layout::Number => write!(out, "<td class=\"n\">{cell}</td>")?,
                Layout::Fine => write!(out, "<td class=\"small\">{cell}</td>")?,
            }
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody></table>\n");
    Ok(())
}

#[cfg(test)]
mod tests {
    use asphera_report::Column;

    use super::*;

    #[test]
    fn words_of_others_are_escaped_everywhere() {
        let hostile = || "<b>&\"".to_owned();
        let fact = Fact { name: hostile(), value: hostile(), note: Some(hostile()), bad: true };
        let table = Table {
            title: Some(hostile()),
            columns: vec![Column { title: hostile(), layout: Layout::Fine }],
            rows: vec![vec![hostile()]],
        };
        let blocks = [
            Block::Facts { facts: vec![fact] },
            Block::Table(table),
            Block::Note { text: hostile() },
            Block::Caution { text: hostile() },
        ];
        let mut out = String::new();
        draw(&mut out, &blocks).unwrap();
        assert_eq!(out.matches("&lt;b&gt;&amp;&quot;").count(), 8, "{out}");
        assert!(!out.contains("<b>&"), "{out}");
    }
}
