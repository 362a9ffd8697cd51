//! The deviation map: colours as PNG, what is around them as SVG.

use std::fmt::{Result, Write as _};

use asphera_report::words::signed;
use asphera_report::{Measured, Picture};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::charts::{Axes, open, ticks};

/// The map of a measurement; nothing where there is none.
pub(super) fn figure(out: &mut String, measurement: &dyn Measured) -> Result {
    let Some(map) = &measurement.picture() else { return Ok(()) };
    let scale_nm = scale_nm(&map.values_nm);
    let Some(scale_nm) = scale_nm else { return Ok(()) };
    let cells = Cells::new(measurement, map);
    let [x, y] = cells.limits_mm(map);
    let shape = (y[1] - y[0]) / (x[1] - x[0]);
    let width = (HEIGHT_MOST / shape).clamp(40.0, WIDTH_MOST);
    let height = (width * shape).clamp(24.0, HEIGHT_MOST);
    let left = 70.0 + (WIDTH_MOST - width) / 2.0;
    let axes = Axes::new([left, 12.0, width, height], x, y);
    open(out, 720.0, height + 50.0, "map of the deviations")?;
    let png = STANDARD.encode(png(measurement, map, &cells, scale_nm));
    writeln!(
        out,
        r#"<image x="{left:.1}" y="12" width="{width:.1}" height="{height:.1}" preserveAspectRatio="none" image-rendering="pixelated" href="data:image/png;base64,{png}"/>"#
    )?;
    let projected = measurement.report().mesh.projection.is_some();
    let [name_x, name_y] = if projected {
        ["u of the plane of projection / mm", "v of the plane of projection / mm"]
    } else {
        ["x, measured frame / mm", "y, measured frame / mm"]
    };
    out.push_str("<g class=\"faint\">\n");
    axes.draw(out, name_x, name_y)?;
    out.push_str("</g>\n");
    if let Some(form) = &measurement.report().form {
        marks(out, measurement, &axes, form.deviation.at_max_mm, "max")?;
        marks(out, measurement, &axes, form.deviation.at_min_mm, "min")?;
    }
    bar(out, scale_nm, height)?;
    out.push_str("</svg>\n");
    let beyond = map.values_nm.iter().filter(|nm| nm.abs() > scale_nm).count();
    write!(
        out,
        "<p class=\"note\">Measured minus nominal along the normal, after alignment. Hatched: in the \
         aperture, but not measured densely enough. White: outside."
    )?;
    if beyond > 0 {
        write!(
            out,
            " {beyond} nodes lie beyond the ends of the scale and have the colour of the end."
        )?;
    }
    out.push_str("</p>\n");
    Ok(())
}

fn marks(
    out: &mut String,
    measurement: &dyn Measured,
    axes: &Axes,
    part_mm: [f64; 3],
    name: &str,
) -> Result {
    let Some([u, v, _]) = measurement.on_plane(part_mm) else { return Ok(()) };
    let (x, y) = (axes.at_x(u), axes.at_y(v));
    // The name stands on the side with more room.
    let (at, class) =
        if x < axes.left + axes.width / 2.0 { (x + 8.0, "") } else { (x - 8.0, " end") };
    writeln!(out, r#"<circle class="mark" cx="{x:.1}" cy="{y:.1}" r="5"/>"#)?;
    writeln!(out, r#"<text class="halo{class}" x="{at:.1}" y="{:.1}">{name}</text>"#, y + 4.0)
}

/// The scale's colours with numbers, right of the map.
fn bar(out: &mut String, scale_nm: f64, height: f64) -> Result {
    let axes = Axes::new([640.0, 12.0, 16.0, height], [0.0, 1.0], [-scale_nm, scale_nm]);
    let steps = 64;
    for step in 0..steps {
        let t = 2.0 * (f64::from(step) + 0.5) / f64::from(steps) - 1.0;
        let [r, g, b] = colour(t);
        let y = axes.at_y(scale_nm * 2.0 * f64::from(step + 1) / f64::from(steps) - scale_nm);
        writeln!(
            out,
            r#"<rect x="640" y="{y:.2}" width="16" height="{:.2}" fill="rgb({r},{g},{b})"/>"#,
            height / f64::from(steps) + 0.4
        )?;
    }
    writeln!(out, r#"<rect class="frame" x="640" y="12" width="16" height="{height:.1}"/>"#)?;
    let (at, _) = ticks(axes.y, (height / 40.0).clamp(2.0, 10.0));
    for value in at {
        writeln!(
            out,
            r#"<text x="661" y="{:.1}">{}</text>"#,
            axes.at_y(value) + 4.0,
            signed((value * 1e6).round() / 1e6)
        )?;
    }
    writeln!(out, r#"<text x="648" y="{:.1}" class="mid name">nm</text>"#, height + 28.0)
}

/// Up to where the colours go: the size that 99.8 % of the nodes do not exceed, rounded up to two digits.
fn scale_nm(values_nm: &[f64]) -> Option<f64> {
    let mut sizes: Vec<f64> =
        values_nm.iter().map(|nm| nm.abs()).filter(|nm| nm.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    let last = sizes.len().checked_sub(1)?;
    let size = sizes[(0.998 * last as f64).ceil() as usize].max(1e-3);
    let digit = 10.0_f64.powi(size.log10().floor() as i32 - 1);
    Some((size / digit).ceil() * digit)
}

/// The cells of the picture: those of the map, and as many around them as the aperture needs.
struct Cells {
    /// Columns left of the map's and rows below it.
    before: [usize; 2],
    nx: usize,
    ny: usize,
}

impl Cells {
    fn new(measurement: &dyn Measured, map: &Picture) -> Cells {
        let low = [map.x0_mm - map.dx_mm / 2.0, map.y0_mm - map.dy_mm / 2.0];
        let pitch = [map.dx_mm, map.dy_mm];
        let size = [map.nx, map.ny];
        let high = [0, 1].map(|axis| low[axis] + pitch[axis] * size[axis] as f64);
        let aperture = measurement.aperture_extent_mm().unwrap_or([low, high]);
        let missing = |axis: usize, length_mm: f64| {
            // A small patch of a large aperture stays legible.
            ((length_mm / pitch[axis]).ceil().max(0.0) as usize).min(2 * size[axis])
        };
        let before = [0, 1].map(|axis| missing(axis, low[axis] - aperture[0][axis]));
        let after = [0, 1].map(|axis| missing(axis, aperture[1][axis] - high[axis]));
        Cells { before, nx: before[0] + size[0] + after[0], ny: before[1] + size[1] + after[1] }
    }

    /// Lowest and highest x, lowest and highest y of the picture. A node is the middle of its cell.
    fn limits_mm(&self, map: &Picture) -> [[f64; 2]; 2] {
        let limits = |origin: f64, pitch: f64, before: usize, cells: usize| {
            let low = origin - pitch * (before as f64 + 0.5);
            [low, low + pitch * cells as f64]
        };
        [
            limits(map.x0_mm, map.dx_mm, self.before[0], self.nx),
            limits(map.y0_mm, map.dy_mm, self.before[1], self.ny),
        ]
    }
}

/// The map as an indexed PNG: the first row is that of the largest y.
fn png(measurement: &dyn Measured, map: &Picture, cells: &Cells, scale_nm: f64) -> Vec<u8> {
    let mut pixels = Vec::with_capacity(cells.nx * cells.ny);
    for row in (0..cells.ny).rev() {
        for column in 0..cells.nx {
            let of_map = |at: usize, axis: usize, size: usize| {
                at.checked_sub(cells.before[axis]).filter(|index| *index < size)
            };
            let node = of_map(column, 0, map.nx).zip(of_map(row, 1, map.ny));
            let nm = node.map_or(f64::NAN, |(i, j)| map.values_nm[j * map.nx + i]);
            let place_mm = [
                map.x0_mm + (column as f64 - cells.before[0] as f64) * map.dx_mm,
                map.y0_mm + (row as f64 - cells.before[1] as f64) * map.dy_mm,
            ];
            pixels.push(if nm.is_finite() {
                let level = (nm / scale_nm).clamp(-1.0, 1.0) * f64::from(HALF);
                (f64::from(MIDDLE_INDEX) + level).round() as u8
            } else if measurement.counts_at(place_mm) {
                if (column + row) % 6 < 2 { HATCH } else { GAP }
            } else {
                OUTSIDE
            });
        }
    }
    let mut palette = vec![255, 255, 255, 238, 238, 238, 178, 178, 178];
    for level in -HALF..=HALF {
        palette.extend(colour(f64::from(level) / f64::from(HALF)));
    }
    encoded(cells.nx, cells.ny, palette, &pixels)
}

fn encoded(columns: usize, rows: usize, palette: Vec<u8>, pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(pixels)?;
        writer.finish()
    });
    written.expect("a grid has at least two nodes a side, and memory takes every byte");
    bytes
}

/// The colour of t from -1 to 1: blue, near-white, orange-brown.
///
/// Both arms fall in lightness alike, so that size reads without hue, on a grey printer too, and blue
/// against orange stays apart for red-green and blue-yellow colour blindness. The colours are those of the
/// live page (`page/colours.js`).
fn colour(t: f64) -> [u8; 3] {
    let arm = if t < 0.0 { BLUE } else { ORANGE };
    let at = t.abs().min(1.0) * (arm.len() - 1) as f64;
    let low = (at.floor() as usize).min(arm.len() - 2);
    std::array::from_fn(|channel| {
        let (from, to) = (f64::from(arm[low][channel]), f64::from(arm[low + 1][channel]));
        (from + (to - from) * (at - low as f64)).round() as u8
    })
}

const MIDDLE: [u8; 3] = [244, 243, 239];
const BLUE: [[u8; 3]; 4] = [MIDDLE, [146, 186, 222], [49, 112, 180], [10, 40, 92]];
const ORANGE: [[u8; 3]; 4] = [MIDDLE, [243, 182, 128], [206, 96, 30], [104, 30, 6]];
/// Places of the palette: outside the aperture, not measured, its hatching, and the levels from there on.
const OUTSIDE: u8 = 0;
const GAP: u8 = 1;
const HATCH: u8 = 2;
/// Levels on either side of zero.
const HALF: i16 = 126;
const MIDDLE_INDEX: u8 = 3 + HALF as u8;
/// Largest size of the map on the page, px.
const WIDTH_MOST: f64 = 540.0;
const HEIGHT_MOST: f64 = 520.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_holds_nearly_all_and_is_round() {
        let mut values_nm: Vec<f64> = (0..1000).map(|i| f64::from(i % 100) - 50.0).collect();
        values_nm[7] = 1e6;
        values_nm[8] = f64::NAN;
        assert_eq!(scale_nm(&values_nm), Some(50.0));
        assert_eq!(scale_nm(&[f64::NAN; 1000]), None);
    }

    #[test]
    fn both_arms_fall_in_lightness_alike() {
        let lightness = |t: f64| {
            let [r, g, b] = colour(t).map(|channel| {
                let channel = f64::from(channel) / 255.0;
                if channel <= 0.04045 {
                    channel / 12.92
                } else {
                    ((channel + 0.055) / 1.055).powf(2.4)
                }
            });
            // CIE 1976 L* of the sRGB colour (IEC 61966-2-1).
            let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            if y > 0.008_856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
        };
        let mut before = lightness(0.0);
        for step in 1..=50 {
            let t = f64::from(step) / 50.0;
            let (below, above) = (lightness(-t), lightness(t));
            assert!((below - above).abs() < 9.0, "{t}: {below} and {above}");
            assert!(0.5 * (below + above) < before, "{t}");
            before = 0.5 * (below + above);
        }
        assert_eq!(colour(0.0), MIDDLE);
    }

    #[test]
    fn the_picture_is_read_back_as_written() {
        let palette: Vec<u8> = (0..=255).flat_map(|index| [index, 0, 255 - index]).collect();
        let pixels: Vec<u8> = (0..6).map(|index| index * 40).collect();
        let bytes = encoded(3, 2, palette, &pixels);
        let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        let mut reader = decoder.read_info().unwrap();
        let mut read = vec![0; 6];
        let info = reader.next_frame(&mut read).unwrap();
        assert_eq!((info.width, info.height, read), (3, 2, pixels));
    }
}
