//! The spectra as SVG: power spectral density over two logarithmic axes, slope spectrum as bars.

use std::fmt::{Result, Write as _};

use asphera_report::standards::{PsdFigures, QFigures};
use asphera_report::words::raised;

use super::charts::{Axes, number, open, ticks};

/// Density by frequency.
pub(super) fn psd(out: &mut String, psd: &PsdFigures) -> Result {
    let pairs = psd.frequency_per_mm.iter().zip(&psd.density_nm2_mm2);
    let points: Vec<[f64; 2]> = pairs
        .filter(|(frequency, density)| **frequency > 0.0 && **density > 0.0)
        .map(|(frequency, density)| [frequency.log10(), density.log10()])
        .collect();
    if points.len() < 2 {
        return Ok(());
    }
    let range = |axis: usize| {
        let values = points.iter().map(|point| point[axis]);
        [values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max)]
    };
    let (x, [low, high]) = (range(0), range(1));
    // Whole decades, of which what lies deeper than rounding of the heights is left out.
    let y = [low.max(high - DECADES).floor(), high.ceil()];
    let axes = Axes::new([70.0, 12.0, 620.0, 230.0], x, y);
    open(out, 720.0, 286.0, "power spectral density of the deviation by spatial frequency")?;
    frame(out, &axes)?;
    let mut path = String::new();
    for (index, &[x, y]) in points.iter().enumerate() {
        let pen = if index == 0 { 'M' } else { 'L' };
        write!(path, "{pen}{:.1} {:.1}", axes.at_x(x), axes.at_y(y.max(axes.y[0])))?;
    }
    writeln!(out, r#"<path class="line" d="{path}"/>"#)?;
    out.push_str("</svg>\n");
    Ok(())
}

/// Axes of powers of ten, with 2 and 5 between them where there is room.
fn frame(out: &mut String, axes: &Axes) -> Result {
    let &Axes { left, top, width, height, .. } = axes;
    let (right, bottom) = (left + width, top + height);
    for (value, name) in logarithmic(axes.x, width / 46.0) {
        let x = axes.at_x(value);
        writeln!(out, r#"<path class="grid" d="M{x:.1} {top:.1}V{bottom:.1}"/>"#)?;
        let y = bottom + 15.0;
        writeln!(out, r#"<text x="{x:.1}" y="{y:.1}" class="mid">{name}</text>"#)?;
    }
    for (value, name) in logarithmic(axes.y, height / 22.0) {
        let y = axes.at_y(value);
        writeln!(out, r#"<path class="grid" d="M{left:.1} {y:.1}H{right:.1}"/>"#)?;
        let (x, y) = (left - 5.0, y + 4.0);
        writeln!(out, r#"<text x="{x:.1}" y="{y:.1}" class="end">{name}</text>"#)?;
    }
    writeln!(
        out,
        r#"<rect class="frame" x="{left:.1}" y="{top:.1}" width="{width:.1}" height="{height:.1}"/>"#
    )?;
    let (x, y) = (left + width / 2.0, bottom + 32.0);
    writeln!(
        out,
        r#"<text x="{x:.1}" y="{y:.1}" class="mid name">spatial frequency / (1/mm)</text>"#
    )?;
    let (x, y) = (left - 52.0, top + height / 2.0);
    writeln!(
        out,
        r#"<text transform="translate({x:.1} {y:.1}) rotate(-90)" class="mid name">density / (nm²·mm²)</text>"#
    )
}

/// Marks of a logarithmic axis, as logarithms with their names: powers of ten, with 2 and 5 between them where
/// about so many marks as `room` are not exceeded, or only every so many powers where they are.
fn logarithmic([low, high]: [f64; 2], room: f64) -> Vec<(f64, String)> {
    let steps: &[f64] = if 3.0 * (high - low) <= room { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let every = ((high - low) / room).ceil().max(1.0) as i32;
    (low.floor() as i32..=high.ceil() as i32)
        .filter(|power| power.rem_euclid(every) == 0)
        .flat_map(|power| steps.iter().map(move |step| (power, *step)))
        .map(|(power, step)| (f64::from(power) + step.log10(), name(power, step)))
        .filter(|(value, _)| (low - EDGE..=high + EDGE).contains(value))
        .collect()
}

fn name(power: i32, step: f64) -> String {
    if (-3..=4).contains(&power) {
        // Through the shortest form: 0.02, not 0.020000000000000004.
        format!("{:.0e}", step * 10.0_f64.powi(power)).parse::<f64>().unwrap_or(step).to_string()
    } else {
        raised(&if step == 1.0 { format!("10^{power}") } else { format!("{step}·10^{power}") })
    }
}

/// One bar a coefficient.
pub(super) fn q_spectrum(out: &mut String, q: &QFigures) -> Result {
    let known = q.coefficients_nm.iter().enumerate();
    let known = known.filter_map(|(m, value)| value.map(|value| (m, value)));
    let size = known.clone().map(|(_, a)| a.abs()).fold(0.0, f64::max);
    let reach = if size > 0.0 { 1.1 * size } else { 1.0 };
    let bars = q.coefficients_nm.len() as f64;
    let axes = Axes::new([70.0, 12.0, 620.0, 150.0], [-0.6, bars - 0.4], [-reach, reach]);
    open(out, 720.0, 206.0, "coefficients of the slope spectrum")?;
    let (at_y, step) = ticks(axes.y, 4.0);
    for value in at_y {
        let y = axes.at_y(value);
        writeln!(out, r#"<path class="grid" d="M70 {y:.1}H690"/>"#)?;
        let (y, number) = (y + 4.0, number(value, step));
        writeln!(out, r#"<text x="65" y="{y:.1}" class="end">{number}</text>"#)?;
    }
    let (zero, every) = (axes.at_y(0.0), (q.coefficients_nm.len() / 20).max(1));
    let width = 0.7 * (axes.at_x(1.0) - axes.at_x(0.0));
    for (m, value) in known {
        let (x, end) = (axes.at_x(m as f64), axes.at_y(value));
        writeln!(
            out,
            r#"<rect class="bar" x="{:.2}" y="{:.2}" width="{width:.2}" height="{:.2}"/>"#,
            x - 0.5 * width,
            zero.min(end),
            (end - zero).abs()
        )?;
        if let Some(u) = q.u_nm.get(m) {
            let ends = [value - u, value + u].map(|end| axes.at_y(end.clamp(-reach, reach)));
            writeln!(out, r#"<path class="zero" d="M{x:.2} {:.2}V{:.2}"/>"#, ends[0], ends[1])?;
        }
        if m.is_multiple_of(every) {
            writeln!(out, r#"<text x="{x:.1}" y="177" class="mid">{m}</text>"#)?;
        }
    }
    writeln!(out, r#"<path class="zero" d="M70 {zero:.1}H690"/>"#)?;
    out.push_str(
        "<rect class=\"frame\" x=\"70\" y=\"12\" width=\"620\" height=\"150\"/>\n\
         <text x=\"380\" y=\"194\" class=\"mid name\">m</text>\n\
         <text transform=\"translate(18 87) rotate(-90)\" class=\"mid name\">coefficient / nm</text>\n</svg>\n",
    );
    Ok(())
}

/// Doubles have sixteen digits; squares of what is left of them lie deeper than this.
const DECADES: f64 = 14.0;
const EDGE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_a_logarithmic_axis_are_round_and_within() {
        let names = |range, room| -> Vec<String> {
            logarithmic(range, room).into_iter().map(|(_, name)| name).collect()
        };
        assert_eq!(names([-1.31, 1.0], 13.0), ["0.05", "0.1", "0.2", "0.5", "1", "2", "5", "10"]);
        assert_eq!(names([-5.0, 6.0], 20.0)[..3], ["10⁻⁵", "10⁻⁴", "0.001"]);
        assert_eq!(
            names([-14.0, 2.0], 8.0),
            ["10⁻¹⁴", "10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴", "0.01", "1", "100"]
        );
        assert_eq!(name(5, 2.0), "2·10⁵");
    }

    #[test]
    fn what_has_no_density_is_not_drawn() {
        let psd = PsdFigures {
            definition: String::new(),
            removed: String::new(),
            window: "Hann".to_owned(),
            source: "heights as measured".to_owned(),
            spacing_mm: [0.1; 2],
            up_to_per_mm: 5.0,
            bridged: 0,
            measured: 1.0,
            noise_nm2_mm2: None,
            rms_nm: 0.0,
            frequency_per_mm: vec![0.1, 0.2, 0.3],
            density_nm2_mm2: vec![0.0, 0.0, 1.0],
        };
        let mut out = String::new();
        super::psd(&mut out, &psd).unwrap();
        assert_eq!(out, "");
        let some = PsdFigures { density_nm2_mm2: vec![100.0, 1.0, 1e-30], ..psd };
        super::psd(&mut out, &some).unwrap();
        assert!(out.contains("<path class=\"line\" d=\"M70.0 ") && !out.contains("NaN"), "{out}");
    }
}
