//! Chains as CSV, SVG and DXF.

use asphera_geometry::BoundsMm;
use std::fmt::Write as _;
use std::path::Path;

use asphera_contour::PlaceMm;
use asphera_report::contour::{ChainFigures, ContourReport};

use crate::cli::output::Failure;
use crate::cli::usage::misused;

/// What turns a contour into the text of a file.
pub(super) type Drawing = fn(&ContourReport) -> String;

/// The drawing that a file's name asks for.
pub(super) fn drawing_of(path: &Path) -> Result<Drawing, Failure> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("csv") => Ok(csv),
        Some("svg") => Ok(svg),
        Some("dxf") => Ok(dxf),
        _ => Err(misused(format!(
            "{}: expected a name that ends in .csv, .svg or .dxf",
            path.display()
        ))),
    }
}

/// One place a line with the number of its chain, in order; of a closed chain the first place is not repeated. Closed gaps follow as
/// gap0, gap1 and so on.
fn csv(report: &ContourReport) -> String {
    let mut text = "chain,closed,x[mm],y[mm]\n".to_owned();
    for (number, chain) in report.chains.iter().enumerate() {
        for [x, y] in &chain.points_mm {
            // Writing into a String cannot fail.
            let _ = writeln!(text, "{number},{},{x},{y}", u8::from(chain.closed));
        }
    }
    for (number, gap) in report.gaps.iter().enumerate() {
        for [x, y] in &gap.points_mm {
            let _ = writeln!(text, "gap{number},0,{x},{y}");
        }
    }
    text
}

/// Scalable vector graphics (W3C SVG 1.1): one path a chain, y upwards, a unit of the picture is 1 mm. Of a region each part is
/// filled but for its holes. Closed gaps are dashed.
fn svg(report: &ContourReport) -> String {
    let (low, high) = bounds(&report.chains);
    let [width, height] = [high[0] - low[0], high[1] - low[1]];
    let rim = 0.02 * width.max(height).max(f64::MIN_POSITIVE);
    let [left, top] = [low[0] - rim, -high[1] - rim];
    let [width, height] = [width + 2.0 * rim, height + 2.0 * rim];
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
         viewBox=\"{left} {top} {width} {height}\">\n\
         <g fill=\"none\" stroke=\"black\" stroke-width=\"{}\" stroke-linejoin=\"round\">\n",
        0.1 * rim
    );
    for part in report.regions.iter().flatten() {
        let lines = std::iter::once(&part.outline_mm).chain(&part.holes_mm);
        let lines: Vec<String> = lines.map(|line| way(line, true)).collect();
        // Writing into a String cannot fail.
        let _ = writeln!(
            text,
            "<path fill=\"lightgray\" fill-rule=\"evenodd\" stroke=\"none\" d=\"{}\"/>",
            lines.join(" ")
        );
    }
    for chain in &report.chains {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "<path d=\"{}\"/>", way(&chain.points_mm, chain.closed));
    }
    for gap in &report.gaps {
        let _ = writeln!(
            text,
            "<path stroke-dasharray=\"{} {}\" d=\"{}\"/>",
            0.4 * rim,
            0.3 * rim,
            way(&gap.points_mm, false)
        );
    }
    text.push_str("</g>\n</svg>\n");
    text
}

/// A line as the data of a path.
fn way(places_mm: &[PlaceMm], closed: bool) -> String {
    let places: Vec<String> = places_mm.iter().map(|[x, y]| format!("{x} {}", 0.0 - y)).collect();
    format!("M {}{}", places.join(" L "), if closed { " Z" } else { "" })
}

/// Drawing exchange format of AutoCAD R12: one POLYLINE a chain, flag 1 where it is closed; lengths in mm. Closed gaps lie on the
/// layer GAPS.
fn dxf(report: &ContourReport) -> String {
    let mut text = "999\nlengths in mm\n0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
        .to_owned();
    for chain in &report.chains {
        polyline(&mut text, "0", &chain.points_mm, chain.closed);
    }
    for gap in &report.gaps {
        polyline(&mut text, "GAPS", &gap.points_mm, false);
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    text
}

fn polyline(text: &mut String, layer: &str, places_mm: &[PlaceMm], closed: bool) {
    // Writing into a String cannot fail.
    let _ = write!(
        text,
        "0\nPOLYLINE\n8\n{layer}\n66\n1\n10\n0.0\n20\n0.0\n30\n0.0\n70\n{}\n",
        u8::from(closed)
    );
    for [x, y] in places_mm {
        let _ = write!(text, "0\nVERTEX\n8\n{layer}\n10\n{x:?}\n20\n{y:?}\n30\n0.0\n");
    }
    let _ = write!(text, "0\nSEQEND\n8\n{layer}\n");
}

/// The smallest box round all places, mm; zero without any.
fn bounds(chains: &[ChainFigures]) -> (PlaceMm, PlaceMm) {
    let places = chains.iter().flat_map(|chain| &chain.points_mm);
    BoundsMm::about(places.copied())
        .corners()
        .map_or(([0.0; 2], [0.0; 2]), |[low, high]| (low, high))
}
