//! Heights that come in steps: an instrument whose resolution is coarser than its noise.
//!
//! Where the heights of neighbours are mostly the same number, what they leave of a smooth surface tells nothing of the
//! errors: they may be wrong by half a step all together. Readings in steps q are off by q/√12 at least (GUM, JCGM 100:2008, F.2.2.1).
//!
//! On a slope that climbs several steps from point to point the errors differ from one to the next, and the usual estimate
//! sees them. So only steps that neighbours share count here.

use asphera_geometry::{PointMm, VertexId};

/// Standard deviation of heights that are rounded to such a step, mm.
pub fn step_sigma_mm(step_mm: f64) -> f64 {
    step_mm / 12_f64.sqrt()
}

/// How heights come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeightSteps {
    /// Neighbours differ, by noise or by form.
    Fine,
    /// Most neighbours differ by one step or not at all.
    Of {
        /// The step in mm.
        step_mm: f64,
    },
    /// Most neighbours have the very same height, as of steps, but how large these are is not known: the noise and the form
    /// below them are hidden.
    Hidden,
}

/// How the heights of a mesh come. Each of the `edges` joins two neighbours.
///
/// Surfaces of few points, of which nothing can be said, count as fine.
pub fn height_steps(points: &[PointMm], edges: &[[VertexId; 2]]) -> HeightSteps {
    if points.len() < POINTS_MIN || !points.iter().all(|point| point[2].is_finite()) {
        return HeightSteps::Fine;
    }
    match step_mm(points) {
        Some(step_mm) if neighbours_share(points, edges, step_mm) => HeightSteps::Of { step_mm },
        None if neighbours_share(points, edges, 0.0) => HeightSteps::Hidden,
        _ => HeightSteps::Fine,
    }
}

/// The edges of triangles; those within come twice.
pub fn edges_of(triangles: &[[VertexId; 3]]) -> Vec<[VertexId; 2]> {
    triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect()
}

/// Step that all heights are a multiple of, mm; `None` where heights have none in common.
fn step_mm(points: &[PointMm]) -> Option<f64> {
    let mut heights: Vec<f64> = points.iter().map(|point| point[2]).collect();
    heights.sort_unstable_by(f64::total_cmp);
    let [low, high] = [heights[0], heights[heights.len() - 1]];
    // Sums of a scale and an offset are rounded to this.
    let rounding = ROUNDING * low.abs().max(high.abs());
    let mut levels = vec![(low, 1_usize)];
    for &height in &heights[1..] {
        let last = levels.len() - 1;
        if height - levels[last].0 <= rounding {
            levels[last].1 += 1;
        } else {
            levels.push((height, 1));
        }
    }
    if levels.len() == 1 {
        return None;
    }
    let gaps = levels.windows(2).map(|pair| pair[1].0 - pair[0].0);
    let step = gaps.clone().fold(f64::INFINITY, f64::min);
    let is_multiple = |gap: f64| {
        let multiple = gap / step;
        (multiple - multiple.round()).abs() <= TOLERANCE
    };
    let common = (heights.len() / COMMON).max(1);
    let crowded = levels.iter().filter(|(_, count)| *count >= common).count();
    let is_stepped = gaps.into_iter().all(is_multiple) && (levels.len() >= LEVELS || crowded >= 2);
    is_stepped.then_some(step)
}

/// Whether most edges climb no more than one step.
fn neighbours_share(points: &[PointMm], edges: &[[VertexId; 2]], step: f64) -> bool {
    let height = |vertex: VertexId| points[vertex as usize][2];
    let near = |&&[one, other]: &&[VertexId; 2]| (height(one) - height(other)).abs() <= 1.5 * step;
    2 * edges.iter().filter(near).count() > edges.len()
}

/// Fewer heights may be alike by chance.
const POINTS_MIN: usize = 100;
/// Levels on one lattice that are no chance, however few points each has.
const LEVELS: usize = 5;
/// Of few levels two have at least this part of the points each: one in twenty.
const COMMON: usize = 20;
/// Largest distance of a gap from a whole number of steps, in steps.
const TOLERANCE: f64 = 1e-3;
const ROUNDING: f64 = 4.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use super::*;

    /// A raster of 40 × 40 places, 0.1 mm apart, with these heights.
    fn raster(height_mm: impl Fn(f64, f64) -> f64) -> (Vec<PointMm>, Vec<[VertexId; 3]>) {
        let place = |index: usize| [0.1 * (index % 40) as f64, 0.1 * (index / 40) as f64];
        let points = (0..1600).map(|index| {
            let [x, y] = place(index);
            [x, y, height_mm(x, y)]
        });
        let square =
            |index: u32| [[index, index + 1, index + 40], [index + 1, index + 41, index + 40]];
        let squares = (0..1559).filter(|index| index % 40 != 39);
        (points.collect(), squares.flat_map(square).collect())
    }

    fn steps(height_mm: impl Fn(f64, f64) -> f64) -> HeightSteps {
        let (points, triangles) = raster(height_mm);
        height_steps(&points, &edges_of(&triangles))
    }

    fn rounded(height_mm: f64, step_mm: f64) -> f64 {
        2.5 + (height_mm / step_mm).round() * step_mm
    }

    #[test]
    fn rounded_heights_of_a_smooth_surface_have_their_step() {
        for step_mm in [6.1e-4, 1e-5] {
            let dome =
                |x: f64, y: f64| rounded(3e-4 * step_mm / 1e-4 * (x * x + 0.3 * y * y), step_mm);
            let HeightSteps::Of { step_mm: found_mm } = steps(dome) else { panic!("{step_mm}") };
            assert!((found_mm - step_mm).abs() < 1e-9 * step_mm, "{found_mm}");
        }
        let two = steps(|x, _| if x < 1.0 { 0.0 } else { 6e-4 });
        assert_eq!(two, HeightSteps::Of { step_mm: 6e-4 });
        let sigma_mm = step_sigma_mm(12.0);
        assert!((sigma_mm * sigma_mm - 12.0).abs() < 1e-12);
    }

    /// They may come in any step, and that hides noise and form below it.
    #[test]
    fn heights_of_one_number_hide_their_step() {
        assert_eq!(steps(|_, _| 1.25), HeightSteps::Hidden);
        // One level more, and nobody knows whether it is a step or a defect.
        assert_eq!(steps(|x, y| if x + y > 7.7 { 1e-4 } else { 0.0 }), HeightSteps::Hidden);
    }

    #[test]
    fn heights_of_other_surfaces_have_none() {
        // Neighbours climb many steps: their errors differ, and the usual estimate sees them.
        assert_eq!(steps(|x, y| rounded(0.1 * x + 0.07 * y, 1e-5)), HeightSteps::Fine);
        // Noise above the step blurs it.
        let noise = asphera_geometry::Numbers::new(1, 0, 0);
        let noisy = |x: f64, y: f64| 2e-3 * noise.normal((400.0 * y + 10.0 * x).round() as usize);
        assert_eq!(steps(|x, y| rounded(noisy(x, y), 1e-4)), HeightSteps::Fine);
        assert_eq!(steps(|x, y| 1e-3 * (x * x + y * y).sqrt()), HeightSteps::Fine);
        // A pit of exact depth is a pit.
        let pit = |x: f64, y: f64| if (x - 2.0).hypot(y - 2.0) < 0.25 { -1e-3 } else { 0.0 };
        assert_eq!(steps(pit), HeightSteps::Hidden);
        let (points, triangles) = raster(|_, _| 0.0);
        assert_eq!(height_steps(&points[..50], &edges_of(&triangles[..4])), HeightSteps::Fine);
    }
}
