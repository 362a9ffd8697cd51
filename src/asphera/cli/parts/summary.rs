//! The parts of a scene as tables of at most 80 columns.

use std::fmt::Write as _;

use asphera_report::Status;
use asphera_report::parts::{MatchFigures, PartForm, PartReport};
use asphera_report::words::counted;

use super::super::graph::figures::part_line;
use super::super::summary::short;
use super::figures::PartsReport;

impl PartsReport {
    /// Lines for a terminal.
    pub(super) fn summary(&self) -> String {
        let mut text = format!(
            "{} points, {}, {} of {}",
            self.points,
            counted(self.parts.len() as u64, "part"),
            counted(self.islands as u64, "island"),
            counted(self.island_points, "point")
        );
        if self.crumbs > 0 {
            text += &format!(", {} left over", counted(self.crumbs, "point"));
        }
        match self.entries {
            None => {
                text.push('\n');
                self.lines(&mut text);
            }
            Some(entries) => {
                text += &format!("; {entries} entries in the library\n");
                self.matches(&mut text);
                self.forms(&mut text);
            }
        }
        text
    }

    fn numbered(&self) -> impl Iterator<Item = (usize, &PartReport)> {
        (1..).zip(&self.parts)
    }

    fn lines(&self, text: &mut String) {
        for (number, part) in self.numbered() {
            // Writing into a String cannot fail.
            let _ = writeln!(text, "{number:>4}  {}", part_line(&part.figures));
        }
    }

    /// Which entry each part is and how it lies; below why some are unknown.
    fn matches(&self, text: &mut String) {
        text.push_str(
            "  no  part                 score margin      x mm      y mm  tilt°  turn° face\n",
        );
        let found = |part: &PartReport| part.found.clone();
        for (number, part) in self.numbered() {
            let Some(found) = found(part) else { continue };
            let _ = writeln!(text, "{number:>4}  {}", row(part, &found));
        }
        for (number, part) in self.numbered() {
            if let Some(reason) = found(part).and_then(|found| found.reason) {
                text.push_str(&wrapped(&format!("{number:>4}  unknown: "), &reason));
            }
        }
    }

    /// The form of the parts that were measured; below why a verdict is not given.
    fn forms(&self, text: &mut String) {
        let measured = || {
            self.numbered().filter_map(|(number, part)| Some((number, part, part.form.as_ref()?)))
        };
        if measured().next().is_none() {
            return;
        }
        text.push_str(
            "  no  part                       PV nm      u nm    RMS nm      u nm  verdict\n",
        );
        for (number, part, form) in measured() {
            let _ = writeln!(text, "{number:>4}  {}", form_row(part, form));
        }
        for (number, _, form) in measured().filter(|(.., form)| form.verdict.status != Status::None)
        {
            for reason in &form.verdict.reasons {
                text.push_str(&wrapped(&format!("{number:>4}  "), reason));
            }
        }
    }
}

fn row(part: &PartReport, found: &MatchFigures) -> String {
    let (place_mm, lies) = match &found.pose {
        Some(pose) => {
            let turn = pose.turn_deg.map_or_else(|| "-".to_owned(), |turn| format!("{turn:.1}"));
            (pose.place_mm, format!("{:>6.2} {turn:>6} {}", pose.tilt_deg, pose.face))
        }
        None => (part.figures.centre_mm, format!("{:>6} {:>6} -", "-", "-")),
    };
    let [x, y, _] = place_mm.map(short);
    let size =
        found.scale.map_or_else(String::new, |scale| format!(", {} times as large", short(scale)));
    let name = named(found);
    format!("{name:<20} {:>5.2} {:>6.2} {x:>9} {y:>9} {lies}{size}", found.score, found.margin)
}

fn form_row(part: &PartReport, form: &PartForm) -> String {
    let figure = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), short);
    let name = part.found.as_ref().map(named).unwrap_or_default();
    format!(
        "{name:<20} {:>11} {:>9} {:>9} {:>9}  {}",
        short(form.pv_nm),
        figure(form.u_pv_nm),
        short(form.rms_nm),
        figure(form.u_rms_nm),
        form.verdict.status
    )
}

/// The name of an entry in its column, cut where it is too long.
fn named(found: &MatchFigures) -> String {
    // An unknown part has none.
    let Some(name) = &found.name else { return "unknown".to_owned() };
    match name.chars().count() > NAME {
        true => name.chars().take(NAME - 1).chain(['…']).collect(),
        false => name.clone(),
    }
}

/// Words in lines of [`WIDTH`], the first one behind a beginning, the others behind as much space.
fn wrapped(begin: &str, words: &str) -> String {
    let mut text = String::new();
    let mut line = begin.to_owned();
    let margin = begin.chars().count().min(6);
    for word in words.split(' ') {
        if line.chars().count() + word.chars().count() > WIDTH && line.trim_start() != "" {
            text.push_str(line.trim_end());
            text.push('\n');
            line = " ".repeat(margin);
        }
        line.push_str(word);
        line.push(' ');
    }
    text.push_str(line.trim_end());
    text.push('\n');
    text
}

/// Letters of the name of an entry in its column.
const NAME: usize = 20;

/// The narrowest terminal that is in use has 80 columns.
const WIDTH: usize = 79;
