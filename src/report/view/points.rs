//! Points and mesh in words.

use super::reconstruction;
use super::{Block, Chapter, ChapterId, Fact};
use crate::words::{count, counted, quantity, short};
use crate::{MeshFigures, Points, ProjectionFigures, ReadingFigures, RepeatFigures, TipFigures};

/// Points: how many came, and what became of them; how the columns of their file were read.
pub(super) fn chapter(points: &Points, reading: Option<&ReadingFigures>) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Points, "Points");
    let reasons = points.flagged.iter().map(|(name, number)| (name.replace('_', " "), *number));
    let reasons: Vec<(String, u64)> = reasons.collect();
    let mut line = format!("{} received, {} used", count(points.received), count(points.used));
    for (reason, number) in &reasons {
        line.push_str(&format!(", {} {reason}", count(*number)));
    }
    let counts =
        [(points.duplicates, "duplicate"), (points.lost, "lost"), (points.missing, "never came")];
    for (number, what) in counts {
        if number > 0 {
            line.push_str(&format!(", {} {what}", count(number)));
        }
    }
    chapter.brief.push(line);
    let mut facts =
        vec![Fact::new("Received", count(points.received)), Fact::new("Used", count(points.used))];
    facts.extend(
        reasons
            .iter()
            .map(|(reason, number)| Fact::new(format!("Not used: {reason}"), count(*number))),
    );
    facts.push(Fact::new("Duplicates", count(points.duplicates)));
    facts.push(Fact::new("Lost triggers", count(points.lost)).bad_if(points.lost > 0));
    if points.missing > 0 {
        facts.push(Fact::new("Triggers that never came", count(points.missing)).bad_if(true));
    }
    facts.extend(points.tip.as_deref().map(|tip| Fact::new("Ball tip", ball_tip(tip))));
    chapter.facts(facts);
    if let Some(tip) = &points.tip {
        chapter.brief.push(format!("ball tip: {}", ball_tip(tip)));
        chapter.note(NOT_CORRECTED);
    }
    if let Some(reading) = reading {
        let line = columns(reading);
        chapter.brief.push(format!("read as {line}"));
        chapter.note(format!("Read as {line}."));
        for caution in &reading.cautions {
            chapter.brief.push(format!("caution: {caution}"));
            chapter.blocks.push(Block::Caution { text: format!("{caution}.") });
        }
    }
    chapter
}

/// Radius of a ball tip, its largest correction, and its u.
fn ball_tip(tip: &TipFigures) -> String {
    let radius = format!("radius {} mm", short(tip.radius_mm));
    if let Some(why) = &tip.uncompensated {
        return format!("{radius}, not compensated: {why}");
    }
    if tip.contacts == Some(0) {
        return format!("{radius}, and no centre has a contact with the nominal");
    }
    let mut text = format!(
        "{radius} compensated, up to {} nm in height at {}°",
        short(tip.largest_height_nm),
        short(tip.steepest_deg)
    );
    if let (Some(pv_nm), Some(rms_nm)) = (tip.u_pv_nm, tip.u_rms_nm) {
        text.push_str(&format!(
            "; its u of {} nm adds {} nm to u of PV and {} nm to u of RMS",
            short(tip.u_radius_mm * 1e6),
            short(pv_nm),
            short(rms_nm)
        ));
    }
    text
}

/// Errors of a ball tip that its compensation leaves.
const NOT_CORRECTED: &str = "Not corrected of the ball tip: its form, contacts on edges, and valleys narrower than the ball.";

/// How columns and units of a file were read.
pub fn columns(reading: &ReadingFigures) -> String {
    if let [only] = &reading.columns[..] {
        return format!("a matrix of heights in {}, the top row first", only.unit);
    }
    let columns = reading
        .columns
        .iter()
        .map(|column| format!("{} in column {} in {}", column.name, column.number, column.unit));
    let columns = columns.collect::<Vec<_>>().join(", ");
    let commas = if reading.decimal_commas { ", decimal commas" } else { "" };
    let assumed =
        if reading.units_assumed { " (mm is assumed: the file states no unit)" } else { "" };
    let over = match reading.lines_passed_over {
        0 => String::new(),
        lines => format!("; {} of text before the points passed over", counted(lines, "line")),
    };
    format!("{columns}{commas}{assumed}{over}")
}

/// The mesh, its plane, and where the surface is too steep for it.
pub(super) fn mesh(mesh: &MeshFigures) -> Chapter {
    let mut chapter = Chapter::new(ChapterId::Mesh, "Mesh");
    if let Some(found) = &mesh.reconstruction {
        reconstruction::add(&mut chapter, mesh, found);
        return chapter;
    }
    let relief = &mesh.relief;
    let steep =
        [(relief.folds.len() as u64, "fold"), (relief.walls, "wall"), (relief.spikes, "spike")];
    let found: Vec<String> = steep
        .iter()
        .filter(|(number, _)| *number > 0)
        .map(|(number, what)| counted(*number, what))
        .collect();
    if !found.is_empty() {
        chapter.brief.push(found.join(", "));
    }
    let is_empty = mesh.vertices == 0;
    let mut facts = vec![
        Fact::new("Vertices", count(mesh.vertices)),
        Fact::new("Triangles", count(mesh.triangles)),
        Fact::new("Edges", count(mesh.edges)),
        Fact::new("On the hull", count(mesh.hull)),
        Fact::new("Area", quantity(mesh.area_mm2.filter(|_| !is_empty), "mm²")),
    ];
    facts.extend(mesh.projection.as_ref().map(plane));
    facts.extend(mesh.decision.as_ref().map(|chosen| Fact::new("Chosen", chosen.clone())));
    if !is_empty {
        let projectable = if mesh.projectable { "yes" } else { "no" };
        facts.push(Fact::new("Projectable", projectable).bad_if(!mesh.projectable));
        facts.push(
            Fact::new("Folds, walls, spikes", steep.map(|(number, _)| count(number)).join(", "))
                .bad_if(!relief.folds.is_empty()),
        );
    }
    if let Some(spread_nm) = mesh.repeats.spread_nm {
        let RepeatFigures { places, measurements, .. } = mesh.repeats;
        facts.push(Fact::new(
            "Places measured again",
            format!(
                "{} places, {} times, spread {} nm",
                count(places),
                count(measurements),
                short(spread_nm)
            ),
        ));
    }
    chapter.facts(facts);
    chapter
}

fn plane(projection: &ProjectionFigures) -> Fact {
    let unfitted = matches!(projection, ProjectionFigures::Unfitted { .. });
    Fact::new("Plane of projection", projection.to_string()).bad_if(unfitted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_fold_is_one_fold() {
        let mut figures = MeshFigures::default();
        figures.relief.walls = 1;
        figures.relief.spikes = 2;
        assert_eq!(mesh(&figures).brief, ["1 wall, 2 spikes"]);
    }

    #[test]
    fn cautions_of_a_file_stand_in_the_summary_and_in_the_report() {
        let reading = ReadingFigures {
            columns: Vec::new(),
            named_by: String::new(),
            units_by: String::new(),
            units_assumed: false,
            decimal_commas: false,
            lines_passed_over: 1,
            cautions: vec!["2 heights of -999 um left out".to_owned()],
        };
        let chapter = chapter(&Points::default(), Some(&reading));
        assert!(chapter.brief[1].contains("1 line of text before the points passed over"));
        assert_eq!(chapter.brief[2], "caution: 2 heights of -999 um left out");
        let caution = Block::Caution { text: "2 heights of -999 um left out.".to_owned() };
        assert!(chapter.blocks.contains(&caution));
    }
}
