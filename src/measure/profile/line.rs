//! A straight line in the plane of projection: whether points lie on one, and its part inside an aperture.

use asphera_form::Aperture;
use asphera_geometry::PointMm;

/// The line that all points lie on, seen along the direction of projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    /// Unit vector along it, towards +x, or +y where it runs along y.
    pub(super) direction: [f64; 2],
}

/// Which way a line runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    X,
    Y,
    Oblique,
}

impl Line {
    /// Through three points or more that lie within a tenth of their mean spacing of it; `None` where they do not.
    pub(crate) fn through(points: &[PointMm]) -> Option<Line> {
        let far_from = |from: &PointMm| {
            let distance = |to: &PointMm| (to[0] - from[0]).hypot(to[1] - from[1]);
            points.iter().max_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let first = far_from(points.first()?)?;
        let last = far_from(first)?;
        let [dx, dy] = [last[0] - first[0], last[1] - first[1]];
        let length_mm = dx.hypot(dy);
        if points.len() < 3 || length_mm.is_nan() || length_mm <= 0.0 {
            return None;
        }
        let sign = if dx < 0.0 || dx == 0.0 && dy < 0.0 { -1.0 } else { 1.0 };
        let direction = [sign * dx / length_mm, sign * dy / length_mm];
        let across = |point: &PointMm| {
            direction[0] * (point[1] - first[1]) - direction[1] * (point[0] - first[0])
        };
        let widest_mm = WIDEST * length_mm / (points.len() - 1) as f64;
        points.iter().all(|point| across(point).abs() <= widest_mm).then_some(Line { direction })
    }

    /// Along x or y of the frame, to a thousandth, or neither.
    pub(super) fn way(&self) -> Way {
        match self.direction {
            [_, y] if y.abs() < SQUARE => Way::X,
            [x, _] if x.abs() < SQUARE => Way::Y,
            _ => Way::Oblique,
        }
    }

    /// Unit vector across it in the plane of projection.
    pub(crate) fn across(&self) -> [f64; 3] {
        [-self.direction[1], self.direction[0], 0.0]
    }

    /// How far along the line a place lies, mm.
    pub(super) fn along_mm(&self, place: [f64; 2]) -> f64 {
        self.direction[0] * place[0] + self.direction[1] * place[1]
    }

    /// The point turned about z so that the line runs along x.
    pub(super) fn turned(&self, [x, y, z]: PointMm) -> PointMm {
        let [cos, sin] = self.direction;
        [cos * x + sin * y, cos * y - sin * x, z]
    }
}

/// Where `from + s·step` lies in an aperture: pieces of s, ascending. The `measured` piece is all of it where every point
/// counts.
pub(super) fn chord(
    aperture: &Aperture,
    from: [f64; 2],
    step: [f64; 2],
    measured: [f64; 2],
) -> Vec<[f64; 2]> {
    let disc = |radius_mm: f64| -> Option<[f64; 2]> {
        let a = step[0] * step[0] + step[1] * step[1];
        let half_b = from[0] * step[0] + from[1] * step[1];
        let c = from[0] * from[0] + from[1] * from[1] - radius_mm * radius_mm;
        let root = half_b * half_b - a * c;
        (root > 0.0).then(|| [(-half_b - root.sqrt()) / a, (-half_b + root.sqrt()) / a])
    };
    match *aperture {
        Aperture::None => vec![measured],
        Aperture::Circle { radius_mm } => disc(radius_mm).into_iter().collect(),
        Aperture::Annulus { inner_mm, outer_mm } => match (disc(outer_mm), disc(inner_mm)) {
            (Some([low, high]), Some([from, to])) => vec![[low, from], [to, high]],
            (outer, _) => outer.into_iter().collect(),
        },
        Aperture::Rectangle { width_mm, height_mm } => {
            let slab = |axis: usize, size_mm: f64| -> Option<[f64; 2]> {
                if step[axis] == 0.0 {
                    let inside = from[axis].abs() <= 0.5 * size_mm;
                    return inside.then_some([f64::NEG_INFINITY, f64::INFINITY]);
                }
                let ends = [-0.5, 0.5].map(|half| (half * size_mm - from[axis]) / step[axis]);
                Some([ends[0].min(ends[1]), ends[0].max(ends[1])])
            };
            let both = slab(0, width_mm).zip(slab(1, height_mm));
            let piece = both.map(|(x, y)| [x[0].max(y[0]), x[1].min(y[1])]);
            piece.filter(|[low, high]| low < high).into_iter().collect()
        }
        // A profile's edges are those of the outline: one moved by a ten-thousandth of its width is the same here.
        Aperture::Outline { ref outline, .. } => outline.pieces(from, step),
    }
}

/// Points lie farther from the line by this share of their spacing at most.
const WIDEST: f64 = 0.1;
/// A line that turns less than this from an axis, in rad, runs along it.
const SQUARE: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_line_make_one_whatever_its_direction() {
        for turn in [0.0_f64, 0.4, 1.2, 1.57, 2.5, -0.8] {
            let [cos, sin] = [turn.cos(), turn.sin()];
            let points: Vec<PointMm> = (0..50)
                .map(|i| [3.0 + f64::from(i) * cos, f64::from(i) * sin - 1.0, 0.5])
                .collect();
            let line = Line::through(&points).unwrap();
            assert!((line.direction[0].abs() - cos.abs()).abs() < 1e-12, "{turn}");
            let [a, b] = [points[0], points[49]].map(|point| line.turned(point));
            assert!((a[1] - b[1]).abs() < 1e-12 && ((a[0] - b[0]).abs() - 49.0).abs() < 1e-12);
        }
        let surface = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        assert_eq!(Line::through(&surface), None);
        assert_eq!(Line::through(&[[1.0; 3]; 3]), None);
    }

    #[test]
    fn chords_of_apertures() {
        let of = |aperture| chord(&aperture, [0.0, 3.0], [1.0, 0.0], [-9.0, 9.0]);
        assert_eq!(of(Aperture::None), [[-9.0, 9.0]]);
        assert_eq!(of(Aperture::Circle { radius_mm: 5.0 }), [[-4.0, 4.0]]);
        assert!(of(Aperture::Circle { radius_mm: 3.0 }).is_empty());
        let ring = Aperture::Annulus { inner_mm: 3.25_f64.hypot(0.0), outer_mm: 5.0 };
        assert_eq!(of(ring), [[-4.0, -1.25], [1.25, 4.0]]);
        let plate = Aperture::Rectangle { width_mm: 7.0, height_mm: 6.5 };
        assert_eq!(of(plate), [[-3.5, 3.5]]);
    }
}
