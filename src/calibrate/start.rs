//! Where the artefact lies, before anything else is known.

use asphera_form::linear::{System, Triangle};
use asphera_geometry::vector::Vector;

use crate::artefact::Artefact;
use crate::columns::PLACE;
use crate::error::CalibrateError;
use crate::rows::Problem;

/// Values of the unknowns to start with: places of the poses and the certified radius; the side from which the sphere
/// is seen, and the discs of height and form.
pub(crate) fn start(problem: &mut Problem<'_>) -> Result<Vec<f64>, CalibrateError> {
    let mut state = vec![0.0; problem.columns.count()];
    let mut sides = Vec::new();
    for index in 0..problem.poses.len() {
        let places: Vec<Vector> =
            problem.poses[index].axes.iter().map(|axes| axes.place().0).collect();
        let plane = plane(&places).ok_or(CalibrateError::NoArea { pose: index + 1 })?;
        let place = match problem.artefact {
            Artefact::Flat => plane.at_origin(),
            Artefact::Sphere { radius_mm, .. } => {
                state[problem.columns.radius()] = radius_mm;
                let (centre, side) = plane.centre(&places, radius_mm, index + 1)?;
                sides.push(side);
                centre
            }
        };
        state[problem.columns.place(index)].copy_from_slice(&place);
    }
    if let Some(side) = sides.first() {
        problem.side = *side;
        if sides.iter().any(|other| other != side) {
            let found = "of some measurements the artefact is convex, of others concave".to_owned();
            return Err(CalibrateError::NotTheArtefact { found });
        }
    }
    problem.map_radius_mm = reach(problem, |_, _, place| [place[0], place[1]]);
    problem.form_radius_mm = reach(problem, |problem, pose, place| {
        let origin = match problem.artefact {
            Artefact::Sphere { .. } => {
                let at = problem.columns.place(pose).start;
                [state[at], state[at + 1]]
            }
            Artefact::Flat => problem.poses[pose].shift_mm,
        };
        problem.on_artefact(pose, [place[0] - origin[0], place[1] - origin[1]])
    });
    Ok(state)
}

/// The largest distance from the origin of what `of` makes of a place.
fn reach(problem: &Problem<'_>, of: impl Fn(&Problem<'_>, usize, Vector) -> [f64; 2]) -> f64 {
    let mut reach = 0.0_f64;
    for (index, pose) in problem.poses.iter().enumerate() {
        for axes in &pose.axes {
            let [x, y] = of(problem, index, axes.place().0);
            reach = reach.max(x.hypot(y));
        }
    }
    reach
}

/// The plane of least squares z = c + a·(x − x₀) + b·(y − y₀), and the middle of its points.
struct Plane {
    middle: Vector,
    /// Height above the middle, and slopes.
    height_and_slopes: [f64; PLACE],
}

/// `None` where the points lie on a line across z.
fn plane(places: &[Vector]) -> Option<Plane> {
    let count = places.len() as f64;
    let mean = |axis: usize| places.iter().map(|place| place[axis]).sum::<f64>() / count;
    let middle = [0, 1, 2].map(mean);
    let mut triangle = Triangle::new(PLACE + 1);
    for [x, y, z] in places {
        triangle.push(&[1.0, x - middle[0], y - middle[1], middle[2] - z]);
    }
    triangle.flush();
    if !triangle.is_finite() {
        return None;
    }
    let system = System::new(&triangle);
    let kept = system.determinate(&[vec![0, 1, 2]], LEAST_RATIO);
    (kept.len() == PLACE).then(|| {
        let change = system.solve(&kept, 0.0).change;
        Plane { middle, height_and_slopes: [change[0], change[1], change[2]] }
    })
}

/// Points nearer to a line than this share of their extent are on one.
const LEAST_RATIO: f64 = 1e-6;

impl Plane {
    /// Height above the origin, and slopes.
    fn at_origin(&self) -> [f64; PLACE] {
        let [height, along_x, along_y] = self.height_and_slopes;
        let [x, y, z] = self.middle;
        [z + height - along_x * x - along_y * y, along_x, along_y]
    }

    /// The centre of a sphere of known radius that bulges from the plane as the points do, and the side from which it
    /// is seen: that on which the points beyond the middle ones lie.
    fn centre(
        &self,
        places: &[Vector],
        radius_mm: f64,
        pose: usize,
    ) -> Result<(Vector, f64), CalibrateError> {
        let [height, along_x, along_y] = self.height_and_slopes;
        let off = |place: &Vector| {
            let [x, y, z] = [0, 1, 2].map(|axis| place[axis] - self.middle[axis]);
            (x.hypot(y), z - height - along_x * x - along_y * y)
        };
        // The sign of the curvature, as the moment of heights with the square of the distance from the middle.
        let mean_square =
            places.iter().map(|place| off(place).0.powi(2)).sum::<f64>() / places.len() as f64;
        let moment: f64 =
            places.iter().map(off).map(|(far, height)| height * (far * far - mean_square)).sum();
        let side = if moment > 0.0 { -1.0 } else { 1.0 };
        let reach = places.iter().map(|place| off(place).0).fold(0.0, f64::max);
        if reach > 1.2 * radius_mm {
            let found = format!(
                "points of measurement {pose} lie up to {reach:.6} mm from their middle, on a sphere of radius {radius_mm} mm"
            );
            return Err(CalibrateError::NotTheArtefact { found });
        }
        let size = (1.0 + along_x * along_x + along_y * along_y).sqrt();
        // The middle of the points lies within the cap, at a depth that the mean square tells for a whole one.
        let depth = mean_square / (2.0 * radius_mm);
        let step = side * (radius_mm - depth) / size;
        let [x, y, z] = self.middle;
        Ok(([x + step * along_x, y + step * along_y, z + height - step], side))
    }
}
