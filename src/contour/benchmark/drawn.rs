//! Curves and areas of one's own in the comparison of methods.

use asphera_geometry::outline::{Outline, OutlineError, ring_area_mm2, ring_contains};

use super::regions::EXTENT_MM;
use super::{Category, Distribution, RegionTrial, Trial};
use crate::PlaceMm;
use crate::sampler::{BezierLine, Spacing, TrueCurve};

/// A curve that somebody drew, or the border of an image.
pub struct Drawing(Source);

enum Source {
    Lines(Vec<BezierLine>),
    Border(TrueCurve),
}

/// Why a drawing is no area.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum DrawingError {
    /// Lines with ends.
    #[error("expected closed lines round an area, found {open} open ones")]
    Open {
        /// How many.
        open: usize,
    },
    /// Nothing drawn.
    #[error("expected closed lines round an area, found none")]
    Empty,
    /// Lines that cross or touch.
    #[error(transparent)]
    Outline(#[from] OutlineError),
}

/// Steps along a border of pixels that are averaged, three times over.
const SMOOTHED: usize = 3;

/// Chord of dense samples over the diagonal of the box: what 2e-4 mm is of the curves made here.
const DENSE: f64 = 7e-6;

/// Chord of the polygon that stands for an area, over the diagonal of its box.
const FINE: f64 = 1e-4;

impl Drawing {
    /// Drawn lines, mm.
    pub fn of_lines(lines: Vec<BezierLine>) -> Drawing {
        Drawing(Source::Lines(lines))
    }

    /// Closed borders of pixels, mm; steps are taken out of them.
    pub fn of_borders(borders_mm: Vec<Vec<PlaceMm>>) -> Drawing {
        let lines: Vec<_> = borders_mm.into_iter().map(|line| (line, true)).collect();
        Drawing(Source::Border(TrueCurve::of_places(&lines).smoothed(SMOOTHED)))
    }

    /// The curve, fine enough for a spacing.
    pub(super) fn curve(&self, spacing: &Spacing) -> TrueCurve {
        match &self.0 {
            Source::Lines(lines) => TrueCurve::of_beziers(lines, spacing),
            Source::Border(curve) => curve.clone(),
        }
    }

    /// The diagonal of the box round it, mm.
    fn diagonal_mm(&self) -> f64 {
        let coarse = Spacing { epsilon: Some(1.0), ..Spacing::default() };
        self.curve(&coarse).diagonal_mm()
    }

    /// The areas that its lines go round, each with its holes, moved and scaled into the square of the shapes made here.
    fn outlines(&self) -> Result<Vec<Outline>, DrawingError> {
        let chord_mm = FINE * self.diagonal_mm();
        let fine = Spacing { chord_mm: Some(chord_mm), ..Spacing::default() };
        let curve = self.curve(&fine);
        let lines = curve.lines_mm();
        let open = lines.iter().filter(|(_, is_closed)| !is_closed).count();
        if open > 0 {
            return Err(DrawingError::Open { open });
        }
        let rings = in_square(lines.into_iter().map(|(places, _)| places).collect());
        if rings.is_empty() {
            return Err(DrawingError::Empty);
        }
        // A ring within an odd number of others is a hole of the smallest about it.
        let about = |ring: &[PlaceMm]| -> Vec<usize> {
            let holds = |at: &usize| {
                !std::ptr::eq(rings[*at].as_slice(), ring) && ring_contains(&rings[*at], ring[0])
            };
            (0..rings.len()).filter(holds).collect()
        };
        let depths: Vec<Vec<usize>> = rings.iter().map(|ring| about(ring)).collect();
        let outline = |at: usize| {
            let is_hole =
                |of: &usize| depths[*of].len() == depths[at].len() + 1 && depths[*of].contains(&at);
            let holes: Vec<Vec<PlaceMm>> =
                (0..rings.len()).filter(is_hole).map(|of| rings[of].clone()).collect();
            Outline::new(&rings[at], &holes)
        };
        let outer = (0..rings.len()).filter(|&at| depths[at].len().is_multiple_of(2));
        Ok(outer.map(outline).collect::<Result<_, _>>()?)
    }
}

/// Rings moved and scaled so that the longer side of their box is 20 mm about the origin; none without area.
fn in_square(rings: Vec<Vec<PlaceMm>>) -> Vec<Vec<PlaceMm>> {
    let rings: Vec<Vec<PlaceMm>> =
        rings.into_iter().filter(|ring| ring_area_mm2(ring) != 0.0).collect();
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for place in rings.iter().flatten() {
        for axis in 0..2 {
            low[axis] = low[axis].min(place[axis]);
            high[axis] = high[axis].max(place[axis]);
        }
    }
    let scale = 20.0 / (high[0] - low[0]).max(high[1] - low[1]);
    let moved = |place: PlaceMm| -> PlaceMm {
        std::array::from_fn(|axis| scale * (place[axis] - f64::midpoint(low[axis], high[axis])))
    };
    const { assert!(EXTENT_MM > 20.0) };
    rings.into_iter().map(|ring| ring.into_iter().map(moved).collect()).collect()
}

impl Category {
    /// The categories that say how samples lie, whatever the curve. The others make curves of their own: with corners, ends, crossings,
    /// or several.
    pub const OF_DRAWINGS: [Category; 5] = [
        Category::NonUniform,
        Category::UniformNoise,
        Category::NonUniformNoise,
        Category::Outliers,
        Category::Manifold,
    ];

    /// Samples of a drawing as this category has them; the same seed and number give the same. Dense samples have a chord of 7e-6 of
    /// the diagonal.
    pub fn trial_of(&self, drawing: &Drawing, seed: u64, number: u32) -> Trial {
        self.sampled(
            |spacing| drawing.curve(spacing),
            DENSE * drawing.diagonal_mm(),
            (seed, number),
        )
    }
}

impl RegionTrial {
    /// About so many points in the area of a drawing, as [`Shape::trial`](super::Shape::trial) has them in its own. The drawing is scaled
    /// to the same size.
    ///
    /// # Errors
    ///
    /// Lines that go round no area.
    pub fn of_drawing(
        drawing: &Drawing,
        (distribution, points): (Distribution, usize),
        (seed, number): (u64, u32),
    ) -> Result<RegionTrial, DrawingError> {
        Ok(RegionTrial::laid(drawing.outlines()?, distribution, points, (seed, number)))
    }
}
