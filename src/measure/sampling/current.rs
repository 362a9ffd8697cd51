//! The figures of the sampling that are kept current while points arrive.
//!
//! A look at the whole mesh costs every triangle, so it is taken only when the points grew by a quarter. Between two
//! looks what changed in the mesh is taken in batch by batch (`asphera_surface::RunningSampling`), with the part
//! where it lay and the limits as they were at the last look.

use asphera_form::Pose;
use asphera_mesh::Mesh;
use asphera_report::{CurrentFigures, SamplingFigures};
use asphera_surface::{Criteria, RunningSampling};

use super::Remembered;
use crate::Part;

/// The sampling of a growing mesh, from the first look on.
#[derive(Default)]
pub(crate) struct Current {
    running: RunningSampling,
    basis: Option<Basis>,
    figures: Option<CurrentFigures>,
    whole_area_mm2: f64,
}

/// Basis of the figures.
struct Basis {
    pose: Pose,
    criteria: Criteria,
    /// Whether the local feature size is known.
    with_lfs: bool,
    /// Whether all is known that the limits hold of.
    is_decided: bool,
    /// Infinite over a plane.
    reach_mm: Option<f64>,
}

impl Current {
    /// Begins anew after a look at the whole mesh that found the part at `pose`.
    pub(crate) fn begin(
        &mut self,
        mesh: &Mesh,
        part: &Part,
        pose: &Pose,
        seen: &SamplingFigures,
        remembered: &Remembered,
    ) {
        let with_lfs = seen.lfs_source.is_some();
        let criteria = Criteria {
            gap_limit_mm: seen.gap_allowed_mm(),
            epsilon_limit: seen.epsilon_target.filter(|_| with_lfs),
            aperture_area_mm2: None,
        };
        let reach_mm = remembered.reach_mm(&part.aperture, mesh.points(), pose);
        let is_decided = with_lfs && (seen.rho_target.is_none() || reach_mm.is_some());
        self.basis = Some(Basis { pose: *pose, criteria, with_lfs, is_decided, reach_mm });
        self.running.restart();
        self.update(mesh, part, remembered);
    }

    /// Takes in what changed in the mesh, if that is not much more than arrived: where points come in no order,
    /// each changes triangles anywhere, and the figures stay as they are until the next look.
    pub(crate) fn keep_up(&mut self, mesh: &Mesh, part: &Part, remembered: &Remembered) {
        let Some(figures) = &self.figures else { return };
        let fresh = inserted(mesh).saturating_sub(figures.as_of_points);
        let most = MOST_TRIANGLES_A_POINT.saturating_mul(fresh).saturating_add(MOST_TRIANGLES);
        if fresh > 0 && self.running.outdated(mesh) as u64 <= most {
            self.update(mesh, part, remembered);
        }
    }

    /// The figures, as of the last batch that was taken in; `None` before the first look.
    pub(crate) fn figures(&self) -> Option<CurrentFigures> {
        self.figures
    }

    /// The area in space of all triangles in mm², as of then.
    pub(crate) fn whole_area_mm2(&self) -> Option<f64> {
        self.figures.map(|_| self.whole_area_mm2)
    }

    fn update(&mut self, mesh: &Mesh, part: &Part, remembered: &Remembered) {
        let Some(Basis { pose, criteria, with_lfs, is_decided, reach_mm }) = &self.basis else {
            return;
        };
        let (turn, [tx_mm, ty_mm]) = (pose.rotation(), [pose.tx_mm, pose.ty_mm]);
        // Seen along the direction of projection: tilts of a part are small.
        let inside = |x_mm: f64, y_mm: f64| {
            let (x_mm, y_mm) = (x_mm - tx_mm, y_mm - ty_mm);
            let [x_mm, y_mm] = [0, 1].map(|axis| turn[0][axis] * x_mm + turn[1][axis] * y_mm);
            part.aperture.contains(x_mm, y_mm)
        };
        let known_mm = remembered.lfs_mm(pose);
        let lfs_mm = |x_mm: f64, y_mm: f64| known_mm(x_mm, y_mm).unwrap_or(f64::NAN);
        let sampling = self.running.update(mesh, criteria, inside, lfs_mm);
        let spread = self.running.spread();
        let finite = |epsilon: f64| (*with_lfs && epsilon.is_finite()).then_some(epsilon);
        self.whole_area_mm2 = spread.whole_area_mm2;
        self.figures = Some(CurrentFigures {
            as_of_points: inserted(mesh),
            triangles: sampling.triangles.good
                + sampling.triangles.over_gap
                + sampling.triangles.over_epsilon,
            area_mm2: sampling.area_mm2,
            dense_fraction: sampling.coverage.filter(|_| *is_decided),
            gap_max_mm: sampling.gap_max_mm,
            gap_median_mm: spread.gap_median_mm,
            gap_p99_mm: spread.gap_p99_mm,
            epsilon_max: sampling.epsilon_max.and_then(finite),
            epsilon_p99: sampling.epsilon_p99.and_then(finite),
            rho_max: sampling.gap_max_mm.zip(*reach_mm).map(|(gap_mm, reach_mm)| gap_mm / reach_mm),
            spacing_median_mm: spread.spacing_median_mm,
        });
    }
}

/// How many points have arrived in the mesh.
fn inserted(mesh: &Mesh) -> u64 {
    let counts = mesh.counts();
    counts.pushed - counts.pending
}

/// More changed triangles for each new point, and more whatever the points, are not looked at.
const MOST_TRIANGLES_A_POINT: u64 = 8;
const MOST_TRIANGLES: u64 = 1 << 16;

#[cfg(test)]
mod tests {
    use crate::nominal::parse;
    use asphera_geometry::PointMm;

    use super::*;

    const PART: &str = "[surface]\nkind = \"asphere\"\nradius_mm = 200\n\
        [aperture]\nshape = \"circle\"\nradius_mm = 30\n\
        [sampling]\ngap_limit_mm = 1.0\n";

    /// A serpentine over a sphere, lines 0.5 mm apart.
    fn scan() -> impl Iterator<Item = PointMm> {
        (0..161 * 161).map(|index| {
            let (step, line) = (index % 161, index / 161);
            let step = if line % 2 == 0 { step } else { 160 - step };
            let [x, y] = [step, line].map(|index| f64::from(index) * 0.5 - 40.0);
            [x, y, 200.0 - (200.0 * 200.0 - x * x - y * y).sqrt()]
        })
    }

    fn begun(mesh: &Mesh, part: &Part) -> (Current, Remembered) {
        let (mut current, mut remembered) = (Current::default(), Remembered::default());
        let plane = asphera_surface::Plane::XY;
        let seen =
            super::super::sampling_of_mesh(mesh, part, &Pose::default(), &plane, &mut remembered);
        current.begin(mesh, part, &Pose::default(), &seen, &remembered);
        (current, remembered)
    }

    #[test]
    fn kept_up_the_figures_are_those_of_a_look_but_for_what_is_said_of_them() {
        let part = parse("part.toml", PART).unwrap();
        let points: Vec<PointMm> = scan().collect();
        let mut mesh = Mesh::new();
        mesh.insert(&points[..10_000]);
        let (mut current, mut remembered) = begun(&mesh, &part);
        for batch in points[10_000..].chunks(1000) {
            mesh.insert(batch);
            current.keep_up(&mesh, &part, &remembered);
            assert_eq!(current.figures().unwrap().as_of_points, inserted(&mesh));
        }
        let found = current.figures().unwrap();
        let plane = asphera_surface::Plane::XY;
        let seen =
            super::super::sampling_of_mesh(&mesh, &part, &Pose::default(), &plane, &mut remembered);
        let share = |found: Option<f64>, seen: Option<f64>| found.unwrap() / seen.unwrap();
        assert!((share(found.gap_max_mm, seen.gap_max_mm) - 1.0).abs() < 1e-9, "{found:?}");
        assert!((1.0..=1.125).contains(&share(found.gap_p99_mm, seen.gap_p99_mm)), "{found:?}");
        let epsilon = share(found.epsilon_max, seen.epsilon_max);
        assert!((1.0..1.02).contains(&epsilon), "{epsilon}");
        assert!((1.0..1.15).contains(&share(found.epsilon_p99, seen.epsilon_p99)), "{found:?}");
        let spacing = share(found.spacing_median_mm, seen.spacing_median_mm);
        assert!((spacing - 1.0).abs() < 0.0625, "{spacing}");
        assert_eq!(found.dense_fraction, Some(1.0));
        let whole = asphera_mesh::area(mesh.points(), mesh.triangles()).lifted_mm2;
        assert!((current.whole_area_mm2().unwrap() / whole - 1.0).abs() < 1e-12);
    }

    #[test]
    fn points_in_no_order_leave_the_figures_as_they_were_and_say_so() {
        let part = parse("part.toml", PART).unwrap();
        let mut points: Vec<PointMm> = (0..250_000)
            .map(|index| {
                // Multiples of the golden ratio and of the square root of two, modulo 1.
                let [u, v] = [0.618_033_988_749_894_9, std::f64::consts::SQRT_2]
                    .map(|step| (f64::from(index) * step).fract());
                [80.0 * u - 40.0, 80.0 * v - 40.0, 0.0]
            })
            .collect();
        let late = points.split_off(249_000);
        let mut mesh = Mesh::new();
        mesh.insert(&points);
        let (mut current, remembered) = begun(&mesh, &part);
        let before = current.figures().unwrap();
        mesh.insert(&late);
        current.keep_up(&mesh, &part, &remembered);
        assert_eq!(current.figures(), Some(before));
        assert_eq!(before.as_of_points, 249_000);
    }

    #[test]
    fn before_the_first_look_nothing_is_known() {
        let part = parse("part.toml", PART).unwrap();
        let mut current = Current::default();
        current.keep_up(&Mesh::new(), &part, &Remembered::default());
        assert_eq!((current.figures(), current.whole_area_mm2()), (None, None));
    }
}
