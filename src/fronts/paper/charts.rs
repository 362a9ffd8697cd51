//! Charts as SVG: axes, histogram, rings, Zernike terms.

use std::fmt::{Result, Write as _};

use asphera_report::words::{minus, short};
use asphera_report::{HistogramFigures, RingFigures, ZernikeFigures};

use super::words::text;

/// A rectangle of the page on which values are plotted. Coordinates of the page grow downwards, in px.
pub(super) struct Axes {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    /// Lowest and highest value along x.
    pub(super) x: [f64; 2],
    /// Lowest and highest value along y.
    pub(super) y: [f64; 2],
}

impl Axes {
    /// Limits that are no range are opened by a little.
    pub(super) fn new([left, top, width, height]: [f64; 4], x: [f64; 2], y: [f64; 2]) -> Axes {
        Axes { left, top, width, height, x: opened(x), y: opened(y) }
    }

    pub(super) fn at_x(&self, value: f64) -> f64 {
        self.left + self.width * (value - self.x[0]) / (self.x[1] - self.x[0])
    }

    pub(super) fn at_y(&self, value: f64) -> f64 {
        self.top + self.height * (1.0 - (value - self.y[0]) / (self.y[1] - self.y[0]))
    }

    /// Frame, grid, numbers and names.
    pub(super) fn draw(&self, out: &mut String, name_x: &str, name_y: &str) -> Result {
        let Axes { left, top, width, height, .. } = *self;
        let (right, bottom) = (left + width, top + height);
        let (at_x, step_x) = ticks(self.x, (width / 80.0).clamp(2.0, 10.0));
        for value in at_x {
            let x = self.at_x(value);
            writeln!(out, r#"<path class="grid" d="M{x:.1} {top:.1}V{bottom:.1}"/>"#)?;
            let (y, number) = (bottom + 15.0, number(value, step_x));
            writeln!(out, r#"<text x="{x:.1}" y="{y:.1}" class="mid">{number}</text>"#)?;
        }
        let (at_y, step_y) = ticks(self.y, (height / 38.0).clamp(2.0, 10.0));
        for value in at_y {
            let y = self.at_y(value);
            writeln!(out, r#"<path class="grid" d="M{left:.1} {y:.1}H{right:.1}"/>"#)?;
            let (x, y, number) = (left - 5.0, y + 4.0, number(value, step_y));
            writeln!(out, r#"<text x="{x:.1}" y="{y:.1}" class="end">{number}</text>"#)?;
        }
        writeln!(
            out,
            r#"<rect class="frame" x="{left:.1}" y="{top:.1}" width="{width:.1}" height="{height:.1}"/>"#
        )?;
        let (x, y) = (left + width / 2.0, bottom + 32.0);
        writeln!(out, r#"<text x="{x:.1}" y="{y:.1}" class="mid name">{}</text>"#, text(name_x))?;
        let (x, y) = (left - 52.0, top + height / 2.0);
        writeln!(
            out,
            r#"<text transform="translate({x:.1} {y:.1}) rotate(-90)" class="mid name">{}</text>"#,
            text(name_y)
        )
    }
}

fn opened([low, high]: [f64; 2]) -> [f64; 2] {
    if high > low {
        return [low, high];
    }
    let room = (1e-3 * low.abs()).max(1e-3);
    [low - room, high + room]
}

/// Multiples of 1, 2 or 5 times a power of ten within a range, about as many as are wanted, and their step.
pub(super) fn ticks([low, high]: [f64; 2], wanted: f64) -> (Vec<f64>, f64) {
    let rough = (high - low) / wanted;
    let decade = 10.0_f64.powi(rough.log10().floor() as i32);
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * decade);
    let step = steps.into_iter().find(|step| *step >= rough).unwrap_or(10.0 * decade);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    ((first..=last).map(|index| index as f64 * step).collect(), step)
}

/// A number with as many places as the step of its axis needs.
pub(super) fn number(value: f64, step: f64) -> String {
    let places = (-(step * 1.000_001).log10().floor()).clamp(0.0, 12.0) as usize;
    minus(format!("{:.places$}", value + 0.0))
}

/// Opens a drawing. `label` says what it shows to whoever cannot see it.
pub(super) fn open(out: &mut String, width: f64, height: f64, label: &str) -> Result {
    writeln!(
        out,
        r#"<svg viewBox="0 0 {width:.0} {height:.0}" role="img" aria-label="{}">"#,
        text(label)
    )
}

/// The histogram, with the band that the PV limit leaves about the middle of the range.
pub(super) fn histogram(
    out: &mut String,
    histogram: &HistogramFigures,
    [min_nm, max_nm]: [f64; 2],
) -> Result {
    let HistogramFigures { low_nm, width_nm, counts, pv_limit_nm, .. } = histogram;
    let high_nm = low_nm + width_nm * counts.len() as f64;
    let middle_nm = 0.5 * (min_nm + max_nm);
    let band = pv_limit_nm.map(|limit| [middle_nm - 0.5 * limit, middle_nm + 0.5 * limit]);
    // A wide tolerance must not squeeze the bars to nothing: its lines are then beyond the edges, and said.
    let reach = (high_nm - low_nm) * 3.0;
    let shown = band.filter(|[from, to]| middle_nm - from < reach && to - middle_nm < reach);
    let [from, to] = shown.unwrap_or([*low_nm, high_nm]);
    let margin = 0.03 * (high_nm.max(to) - low_nm.min(from));
    let most = counts.iter().copied().max().unwrap_or(1) as f64;
    let axes = Axes::new(
        [70.0, 12.0, 620.0, 190.0],
        [low_nm.min(from) - margin, high_nm.max(to) + margin],
        [0.0, 1.08 * most],
    );
    open(out, 720.0, 246.0, "histogram of the deviations")?;
    axes.draw(out, "deviation / nm", "points")?;
    for (index, count) in counts.iter().enumerate() {
        let from = low_nm + width_nm * index as f64;
        let (x, y) = (axes.at_x(from), axes.at_y(*count as f64));
        let (width, height) = (axes.at_x(from + width_nm) - x, axes.at_y(0.0) - y);
        writeln!(
            out,
            r#"<rect class="bar" x="{x:.2}" y="{y:.2}" width="{:.2}" height="{height:.2}"/>"#,
            (width - 0.6).max(0.4)
        )?;
    }
    for at in shown.into_iter().flatten() {
        let x = axes.at_x(at);
        writeln!(out, r#"<path class="limit" d="M{x:.1} 12V202"/>"#)?;
    }
    out.push_str("</svg>\n");
    match (pv_limit_nm, shown) {
        (None, _) => writeln!(out, "<p class=\"note\">No PV limit was given.</p>"),
        (Some(limit), Some(_)) => writeln!(
            out,
            "<p class=\"note\">The dashed lines are {} nm apart, which is the PV limit, about the middle of the range. If no bar lies outside, the limit holds.</p>",
            short(*limit)
        ),
        (Some(limit), None) => writeln!(
            out,
            "<p class=\"note\">The PV limit, {} nm, lies beyond the edges of this chart.</p>",
            short(*limit)
        ),
    }
}

/// Mean deviation by distance from the origin, between smallest and largest.
pub(super) fn rings(out: &mut String, rings: &[RingFigures]) -> Result {
    let known =
        || rings.iter().filter_map(|ring| Some((ring, ring.mean_nm?, ring.low_nm?, ring.high_nm?)));
    let low = known().map(|(_, _, low, _)| low).fold(f64::INFINITY, f64::min);
    let high = known().map(|(_, _, _, high)| high).fold(f64::NEG_INFINITY, f64::max);
    let (Some(first), Some(last)) = (rings.first(), rings.last()) else { return Ok(()) };
    if low > high {
        return Ok(());
    }
    let margin = 0.05 * (high - low);
    let axes = Axes::new(
        [70.0, 12.0, 620.0, 190.0],
        [first.from_mm, last.to_mm],
        [low - margin, high + margin],
    );
    open(out, 720.0, 246.0, "mean deviation by distance from the origin")?;
    axes.draw(out, "distance from the origin / mm", "deviation / nm")?;
    for (ring, _, low, high) in known() {
        let (x, y) = (axes.at_x(ring.from_mm), axes.at_y(high));
        let (width, height) = (axes.at_x(ring.to_mm) - x, axes.at_y(low) - y);
        writeln!(
            out,
            r#"<rect class="spread" x="{x:.2}" y="{y:.2}" width="{width:.2}" height="{height:.2}"/>"#
        )?;
    }
    // A ring without points breaks the line.
    let mut pen = 'M';
    let mut path = String::new();
    for ring in rings {
        let Some(mean_nm) = ring.mean_nm else {
            pen = 'M';
            continue;
        };
        let x = axes.at_x(0.5 * (ring.from_mm + ring.to_mm));
        write!(path, "{pen}{x:.1} {:.1}", axes.at_y(mean_nm))?;
        pen = 'L';
    }
    writeln!(out, r#"<path class="line" d="{path}"/>"#)?;
    out.push_str("</svg>\n");
    writeln!(
        out,
        "<p class=\"note\">Line: area-weighted mean of each ring. Band: from its smallest to its largest \
         deviation.</p>"
    )
}

/// One bar a term.
pub(super) fn zernike(out: &mut String, zernike: &ZernikeFigures) -> Result {
    let size = zernike.terms.iter().map(|term| term.value_nm.abs()).fold(0.0, f64::max);
    let rows = zernike.terms.len() as f64;
    let height = 13.0 * rows;
    let reach = if size > 0.0 { 1.05 * size } else { 1.0 };
    let axes = Axes::new([250.0, 6.0, 380.0, height], [-reach, reach], [0.0, 1.0]);
    open(out, 720.0, height + 44.0, "coefficients of the Zernike terms")?;
    let (at_x, step) = ticks(axes.x, 6.0);
    for value in at_x {
        let (x, bottom) = (axes.at_x(value), 6.0 + height);
        writeln!(out, r#"<path class="grid" d="M{x:.1} 6V{bottom:.1}"/>"#)?;
        let y = bottom + 15.0;
        writeln!(out, r#"<text x="{x:.1}" y="{y:.1}" class="mid">{}</text>"#, number(value, step))?;
    }
    let zero = axes.at_x(0.0);
    for (row, term) in zernike.terms.iter().enumerate() {
        let y = 6.0 + 13.0 * row as f64;
        let end = axes.at_x(term.value_nm);
        writeln!(
            out,
            r#"<rect class="bar" x="{:.2}" y="{:.2}" width="{:.2}" height="9"/>"#,
            zero.min(end),
            y + 2.0,
            (end - zero).abs()
        )?;
        let name = format!("{} {}", term.index, term.name);
        let y = y + 10.0;
        writeln!(out, r#"<text x="242" y="{y:.1}" class="end">{}</text>"#, text(&name))?;
        writeln!(
            out,
            r#"<text x="714" y="{y:.1}" class="end">{} nm</text>"#,
            minus(format!("{:+.2}", (100.0 * term.value_nm).round() / 100.0 + 0.0))
        )?;
    }
    writeln!(out, r#"<path class="zero" d="M{zero:.1} 6V{:.1}"/>"#, 6.0 + height)?;
    writeln!(
        out,
        r#"<text x="440" y="{:.1}" class="mid name">coefficient / nm</text>"#,
        height + 38.0
    )?;
    out.push_str("</svg>\n");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let (at, step) = ticks([-0.37, 1.03], 5.0);
        assert_eq!(step, 0.5);
        assert_eq!(at, [0.0, 0.5, 1.0]);
        assert_eq!(number(0.5, step), "0.5");
        assert_eq!(number(-20.0, 10.0), "\u{2212}20");
    }

    #[test]
    fn a_chart_of_equal_values_has_a_range() {
        let axes = Axes::new([0.0, 0.0, 100.0, 100.0], [5.0, 5.0], [0.0, 0.0]);
        assert!((axes.at_x(5.0) - 50.0).abs() < 1e-6 && (axes.at_y(0.0) - 50.0).abs() < 1e-6);
    }
}
