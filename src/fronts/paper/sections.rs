//! Two sections through the origin: the deviation along x and along y.

use std::fmt::{self, Write as _};

use asphera_report::words::short;
use asphera_report::{Columns, Measured, SectionRequest};

use super::charts::{Axes, open};

/// The sections of a measurement, each with its PV and RMS; nothing without a fit.
pub(super) fn figures(out: &mut String, measurement: &dyn Measured) -> fmt::Result {
    let Some([u, v, _]) = measurement.on_plane([0.0; 3]) else { return Ok(()) };
    let Some([low, high]) = measurement.extent_mm() else { return Ok(()) };
    let projected = measurement.report().mesh.projection.is_some();
    let names = if projected { ["u", "v"] } else { ["x", "y"] };
    let paths = [([low[0], v], [high[0], v]), ([u, low[1]], [u, high[1]])];
    for (axis, (from_mm, to_mm)) in paths.into_iter().enumerate() {
        let request = SectionRequest::Line { from_mm, to_mm };
        let name = names[axis];
        let section = measurement.section(&request).and_then(Result::ok);
        let met = section.as_ref().and_then(|section| Some((section, section.points.as_ref()?)));
        let Some((section, columns)) = met.filter(|(_, columns)| !columns.s_mm.is_empty()) else {
            writeln!(
                out,
                "<p class=\"note\">Along {name} through the origin nothing was measured.</p>"
            )?;
            continue;
        };
        let places_mm = if axis == 0 { &columns.x_mm } else { &columns.y_mm };
        let centre_mm = [u, v][axis];
        writeln!(out, "<h3>Along {name} through the origin</h3>")?;
        chart(out, name, columns, places_mm, centre_mm)?;
        if let Some(deviation) = &section.deviation {
            writeln!(
                out,
                "<p class=\"note\">PV {} nm, RMS {} nm about the nominal, over {} mm in {}.</p>",
                short(deviation.pv_nm),
                short(deviation.rms_nm),
                short(deviation.length_mm),
                if section.pieces.len() == 1 {
                    "one piece".to_owned()
                } else {
                    format!("{} pieces", section.pieces.len())
                }
            )?;
        }
    }
    Ok(())
}

fn chart(
    out: &mut String,
    name: &str,
    columns: &Columns,
    places_mm: &[f64],
    centre_mm: f64,
) -> fmt::Result {
    let Some(deviations_nm) = &columns.deviation_nm else { return Ok(()) };
    let known =
        || (0..places_mm.len()).filter_map(|i| Some((places_mm[i] - centre_mm, deviations_nm[i]?)));
    let range = |pick: fn((f64, f64)) -> f64| {
        known().map(pick).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        })
    };
    let (x, y) = (range(|(place, _)| place), range(|(_, nm)| nm));
    if x[0] > x[1] {
        return Ok(());
    }
    let margin = 0.06 * (y[1] - y[0]);
    let axes = Axes::new([70.0, 8.0, 620.0, 150.0], x, [y[0] - margin, y[1] + margin]);
    open(out, 720.0, 202.0, "deviation along a section")?;
    axes.draw(out, &format!("{name} from the origin / mm"), "deviation / nm")?;
    writeln!(
        out,
        r#"<path class="line" d="{}"/>"#,
        path(columns, deviations_nm, places_mm, centre_mm, &axes)
    )?;
    out.push_str("</svg>\n");
    Ok(())
}

/// The curve, broken where a piece ends and where there is no deviation.
fn path(
    columns: &Columns,
    deviations_nm: &[Option<f64>],
    places_mm: &[f64],
    centre_mm: f64,
    axes: &Axes,
) -> String {
    let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut piece = None;
    for (index, nm) in deviations_nm.iter().enumerate() {
        let Some(nm) = nm else {
            piece = None;
            continue;
        };
        if piece != Some(columns.piece[index]) {
            piece = Some(columns.piece[index]);
            runs.push(Vec::new());
        }
        let at = [axes.at_x(places_mm[index] - centre_mm), axes.at_y(*nm)];
        if let Some(run) = runs.last_mut() {
            run.push(at);
        }
    }
    let mut path = String::new();
    for run in &runs {
        for (index, [x, y]) in thinned(run).into_iter().enumerate() {
            let pen = if index == 0 { 'M' } else { 'L' };
            path.push_str(&format!("{pen}{x:.1} {y:.1}"));
        }
    }
    path
}

/// Of the points in each column of one px the lowest and the highest, in the order in which they come: what
/// the eye sees of all.
fn thinned(run: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for column in run.chunk_by(|a, b| a[0].round() == b[0].round()) {
        let by_height = |a: &usize, b: &usize| column[*a][1].total_cmp(&column[*b][1]);
        let low = (0..column.len()).min_by(by_height);
        let high = (0..column.len()).max_by(by_height);
        let mut both: Vec<usize> = low.into_iter().chain(high).collect();
        both.sort_unstable();
        both.dedup();
        kept.extend(both.into_iter().map(|index| column[index]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_keeps_its_extremes_in_order() {
        let run = [[1.0, 5.0], [1.1, 9.0], [1.2, 2.0], [1.3, 4.0], [2.0, 7.0]];
        assert_eq!(thinned(&run), [[1.1, 9.0], [1.2, 2.0], [2.0, 7.0]]);
        assert!(thinned(&[]).is_empty());
    }
}
