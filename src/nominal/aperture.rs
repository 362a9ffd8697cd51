//! `[aperture]`: the region of the part that counts.

use std::path::Path;

use asphera_form::{Aperture, middle_mm};
use asphera_geometry::outline::{Outline, ring_area_mm2};
use asphera_measure::HIGHEST_MM;
use asphera_settings::Section;

use super::drawing::{DRAWINGS, drawn_lines};
use super::surface::Surface;
use super::text::bytes_of;

/// The region that counts; `None` with a problem where it is none. The file of an outline is found from `folder`.
pub(super) fn read(section: &Section<'_>, folder: &Path) -> Option<Aperture> {
    if !section.is_present() {
        return Some(Aperture::None);
    }
    #[derive(Clone, Copy)]
    enum Shape {
        Circle,
        Rectangle,
        Annulus,
        Outline,
    }
    let words = [
        ("circle", Shape::Circle),
        ("rectangle", Shape::Rectangle),
        ("annulus", Shape::Annulus),
        ("outline", Shape::Outline),
    ];
    let aperture = match section.required_word("shape", &words)? {
        Shape::Circle => Aperture::Circle { radius_mm: section.required("radius_mm")? },
        Shape::Rectangle => {
            let (width_mm, height_mm) =
                (section.required("width_mm"), section.required("height_mm"));
            Aperture::Rectangle { width_mm: width_mm?, height_mm: height_mm? }
        }
        Shape::Annulus => {
            let (inner_mm, outer_mm) =
                (section.required("inner_radius_mm"), section.required("outer_radius_mm"));
            Aperture::Annulus { inner_mm: inner_mm?, outer_mm: outer_mm? }
        }
        Shape::Outline => Aperture::of_outline(outline(section, folder)?),
    };
    match aperture.validate() {
        Ok(()) => Some(aperture),
        Err(error) => {
            section.problem("shape", "an aperture with positive sizes", error);
            None
        }
    }
}

/// `file` with a drawing, or its closed lines as `lines_mm`: one list of x, y, x, y, … a line.
fn outline(section: &Section<'_>, folder: &Path) -> Option<Outline> {
    let (key, mut lines) = match section.has("lines_mm") {
        true => ("lines_mm", written(section)?),
        false => ("file", drawn(section, folder)?),
    };
    if section.has("lines_mm") && section.has("file") {
        section.problem("file", "either a file or lines_mm", "both");
        return None;
    }
    // The line about all others is the outline. A picture may draw a line twice, filled and as a stroke.
    lines.sort_by(|p, q| ring_area_mm2(q).abs().total_cmp(&ring_area_mm2(p).abs()));
    lines.dedup();
    let expected = "an outline, and holes that lie in it and meet nothing";
    let Some((outer, holes)) = lines.split_first() else {
        section.problem(key, expected, "no line");
        return None;
    };
    Outline::new(outer, holes).map_err(|error| section.problem(key, expected, error)).ok()
}

fn written(section: &Section<'_>) -> Option<Vec<Vec<[f64; 2]>>> {
    let lines: Vec<Vec<f64>> = section.required("lines_mm")?;
    if lines.iter().any(|line| line.len() % 2 == 1) {
        let expected = "a list of x, y, x, y, … in mm for every closed line";
        section.problem("lines_mm", expected, "an odd count of numbers");
        return None;
    }
    let places = |line: &Vec<f64>| line.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
    Some(lines.iter().map(places).collect())
}

fn drawn(section: &Section<'_>, folder: &Path) -> Option<Vec<Vec<[f64; 2]>>> {
    let name: String = section.required("file")?;
    let path = folder.join(&name);
    let bytes = bytes_of(&path)
        .map_err(|error| section.problem("file", DRAWINGS, format!("{}: {error}", path.display())))
        .ok()?;
    let lines = drawn_lines(&path, &bytes)
        .map_err(|found| section.problem("file", "a drawing", format!("{name}: {found}")))
        .ok()?;
    if let Some(line) = lines.iter().find(|line| !line.closed) {
        let [x, y] = line.pieces[0][0];
        let found = format!("{name}: a line from ({x}, {y}) mm that is open");
        section.problem("file", "closed lines", found);
        return None;
    }
    let corners = || lines.iter().flat_map(|line| line.pieces.iter().flatten());
    let extent_mm = corners().flatten().fold(0.0_f64, |most, mm| most.max(mm.abs()));
    Some(lines.iter().map(|line| line.corners(FLATNESS * extent_mm)).collect())
}

/// An aperture and its middle. An outline without a middle, over a surface without a place of its own, is about the centre
/// of the smallest circle that holds it.
pub(super) fn centred(
    aperture: Option<Aperture>,
    centre_mm: Option<[f64; 2]>,
    surface: Option<&Surface>,
) -> (Option<Aperture>, Option<[f64; 2]>) {
    let (Some(Aperture::Outline { outline, .. }), None, Some(surface)) =
        (&aperture, centre_mm, surface)
    else {
        return (aperture, centre_mm);
    };
    let slides = surface.nominal.slides();
    let has_place = surface.reference.as_ref().is_some_and(|known| known.centre_mm.is_some());
    let middle_mm = middle_mm(&outline.rings()[0]).unwrap_or_default();
    let centre_mm = [0, 1].map(|axis| if slides[axis] { middle_mm[axis] } else { 0.0 });
    if has_place || centre_mm == [0.0; 2] {
        return (aperture, None);
    }
    let ring = |ring: &Vec<[f64; 2]>| -> Vec<[f64; 2]> {
        ring.iter().map(|&[x, y]| [x - centre_mm[0], y - centre_mm[1]]).collect()
    };
    let lines: Vec<Vec<[f64; 2]>> = outline.rings().iter().map(ring).collect();
    match Outline::new(&lines[0], &lines[1..]) {
        Ok(outline) => (Some(Aperture::of_outline(outline)), Some(centre_mm)),
        // Sides so near to each other that the shift made them meet stay where they are.
        Err(_) => (aperture, None),
    }
}

/// The closed lines of an outline as `lines_mm` holds them; `None` where the aperture is none.
pub fn aperture_lines_mm(aperture: &Aperture) -> Option<Vec<Vec<f64>>> {
    let Aperture::Outline { outline, .. } = aperture else { return None };
    Some(outline.rings().iter().map(|ring| ring.iter().flatten().copied().collect()).collect())
}

/// Where a surface ends, an aperture must have ended. Heights from a file may have gaps, which show in the coverage.
pub(super) fn must_end_before(section: &Section<'_>, aperture: &Aperture, surface: &Surface) {
    let Some(reach_mm) = aperture.reach_mm() else { return };
    let (key, found) = match *aperture {
        Aperture::None => return,
        Aperture::Circle { radius_mm } => ("radius_mm", radius_mm),
        Aperture::Annulus { outer_mm, .. } => ("outer_radius_mm", outer_mm),
        Aperture::Rectangle { width_mm, .. } => ("width_mm", width_mm),
        Aperture::Outline { .. } => ("shape", reach_mm),
    };
    let domain_mm = surface.nominal.domain_mm();
    if surface.nominal.is_rotational() && aperture.is_round() && found > domain_mm {
        let shown = if domain_mm < 1e-3 {
            asphera_settings::number(domain_mm)
        } else {
            format!("{domain_mm:.6}")
        };
        let expected = format!(
            "at most {shown} mm, where the surface ends: narrow the aperture, or correct radius and conic"
        );
        section.problem(key, &expected, asphera_settings::number(found));
        return;
    }
    if surface.has_gaps {
        return;
    }
    let is_height = |height_mm: f64| height_mm.abs() <= HIGHEST_MM;
    let without = rim(aperture)
        .into_iter()
        .find(|[x_mm, y_mm]| !surface.nominal.height_mm(*x_mm, *y_mm).is_some_and(is_height));
    if let Some([x_mm, y_mm]) = without {
        let has = match surface.nominal.height_mm(x_mm, y_mm) {
            Some(height_mm) => format!("is {height_mm:e} mm high"),
            None => "has no height".to_owned(),
        };
        let expected = format!(
            "an aperture within the surface, which {has} at x {x_mm:.6}, y {y_mm:.6} mm: narrow the aperture, or correct the \
             surface"
        );
        section.problem(key, &expected, found);
    }
}

/// Places next to the rim of an aperture, inwards by less than counts.
fn rim(aperture: &Aperture) -> Vec<[f64; 2]> {
    if let Aperture::Outline { outline, .. } = aperture {
        let corners = outline.rings()[0].iter();
        return corners.map(|corner| corner.map(|mm| INWARDS * mm)).collect();
    }
    let Some([x_mm, y_mm]) = aperture.half_extents_mm() else { return Vec::new() };
    let places = (0..RIM_PLACES).map(|place| {
        let angle = std::f64::consts::TAU * f64::from(place) / f64::from(RIM_PLACES);
        let (sin, cos) = angle.sin_cos();
        // The corners of a rectangle are met at 45°.
        let out = if aperture.is_round() { 1.0 } else { sin.abs().max(cos.abs()).recip() };
        [x_mm * cos, y_mm * sin].map(|mm| INWARDS * out * mm)
    });
    places.collect()
}

/// Places on the rim of an aperture that are asked, a multiple of eight.
const RIM_PLACES: u32 = 360;
/// Rounding is not to bring a place on the end of a surface beyond it.
const INWARDS: f64 = 1.0 - 1e-9;

/// Share of its extent by which straight sides may run beside the curve of a drawing: a circle has 700 of them.
const FLATNESS: f64 = 1e-5;

#[cfg(test)]
mod tests;
