//! Ranges of a scene's numbers, and whether they fit each other.

use asphera_form::Parameter;
use asphera_form::form_error::LARGEST_FRINGE;
use asphera_link::{Problem, check_range};

use super::Scene;
use crate::ball;
use crate::motion::Motion;
use crate::{Link, SceneError, Speed};

impl Scene {
    /// Whether the scene can be played; the numbers of the builder are looked at again here.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        let problems = self.problems();
        if problems.is_empty() {
            return Ok(());
        }
        Err(SceneError::Values { scene: self.name.clone(), problems })
    }

    /// Everything that keeps the scene from being played. Keys are those of its file.
    pub(super) fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        self.part_problems(&mut problems);
        self.scan_problems(&mut problems);
        self.instrument_problems(&mut problems);
        self.fault_problems(&mut problems);
        problems
    }

    fn part_problems(&self, problems: &mut Vec<Problem>) {
        let semi_mm = self.semi_diameter_mm;
        check_range(problems, "part.semi_diameter_mm", semi_mm, 1e-3, 1e3);
        if !self.nominal.is_rotational() {
            let expected = "a plane, a sphere or an asphere";
            problems.push(Problem::new("part.surface", expected, self.nominal.kind()));
        } else if !self.nominal.slope(semi_mm).is_finite() {
            let expected = "a radius within the surface's domain";
            problems.push(Problem::new("part.semi_diameter_mm", expected, semi_mm));
        }
        let pose = self.pose;
        for (key, value, limit) in [
            ("part.pose.tx_mm", pose.tx_mm, 100.0),
            ("part.pose.ty_mm", pose.ty_mm, 100.0),
            ("part.pose.tz_mm", pose.tz_mm, 100.0),
            // Steeper, and the place under the probe is no longer found by small steps.
            ("part.pose.rx_rad", pose.rx_rad, 0.05),
            ("part.pose.ry_rad", pose.ry_rad, 0.05),
            ("part.pose.rz_rad", pose.rz_rad, std::f64::consts::PI),
        ] {
            check_range(problems, key, value, -limit, limit);
        }
        for (term, &(index, height_nm)) in self.form_error.fringe_nm.iter().enumerate() {
            let key = |key| format!("part.form_error.fringe[{term}].{key}");
            check_range(problems, &key("index"), index, 1, LARGEST_FRINGE);
            check_range(problems, &key("height_nm"), height_nm, -1e5, 1e5);
        }
        if let Some(ring) = self.form_error.ring {
            // Of a part without a size nothing lies within.
            if semi_mm > 0.0 {
                let key = "part.form_error.ring.radius_mm";
                check_range(problems, key, ring.radius_mm, 0.0, semi_mm);
                check_range(
                    problems,
                    "part.form_error.ring.width_mm",
                    ring.width_mm,
                    1e-3,
                    semi_mm,
                );
            }
            check_range(problems, "part.form_error.ring.height_nm", ring.height_nm, -1e5, 1e5);
        }
        let limits = self.tolerance;
        for (key, limit) in [("tolerance.pv_nm", limits.pv_nm), ("tolerance.rms_nm", limits.rms_nm)]
        {
            if let Some(limit_nm) = limit {
                check_range(problems, key, limit_nm, 1e-3, 1e9);
            }
        }
    }

    fn scan_problems(&self, problems: &mut Vec<Problem>) {
        check_range(problems, "scan.points", self.points, 1, MAX_POINTS);
        check_range(problems, "scan.rate_hz", self.rate_hz, 1.0, 66_000.0);
        if let Speed::Times(times) = self.speed {
            check_range(problems, "speed", times, 1e-3, 1e3);
        }
        let step_nm = self.motion.step_nm();
        check_range(problems, "stage.step_nm", step_nm, 1, 1_000_000);
        let reach_mm = self.motion.reach_mm();
        let key = match self.motion {
            Motion::Spiral { counts_per_turn, .. } => {
                let counts = counts_per_turn;
                check_range(problems, "scan.counts_per_turn", counts, 1, 1_000_000_000);
                "scan.radius_mm"
            }
            Motion::Raster { .. } => "scan.half_width_mm",
            Motion::Section { section, noise_nm, .. } => {
                check_range(problems, "scan.noise_nm", noise_nm, 0.0, 1e6);
                check_range(problems, "scan.naca", section.naca, 1, 9940);
                let thickness = section.naca % 100;
                check_range(problems, "scan.naca (its last two digits)", thickness, 1, 40);
                "scan.chord_mm"
            }
            Motion::Ball { .. } => {
                self.ball_problems(problems);
                return;
            }
        };
        let decentre_mm = self.pose.tx_mm.hypot(self.pose.ty_mm);
        let semi_mm = self.semi_diameter_mm;
        if semi_mm > 0.0 && !(reach_mm > 0.0 && reach_mm + decentre_mm <= semi_mm) {
            let expected =
                format!("points within part.semi_diameter_mm = {semi_mm} of the decentred part");
            let found = format!("a reach of {} mm", reach_mm + decentre_mm);
            problems.push(Problem::new(key, expected, found));
        }
        if step_nm > 0 && reach_mm * 1e6 / f64::from(step_nm) > f64::from(i32::MAX) {
            let expected = "positions within 32 bits";
            problems.push(Problem::new("stage.step_nm", expected, "a finer step"));
        }
        let end = self.motion.rotary_end_counts(self.points);
        if self.points <= MAX_POINTS && end > f64::from(i32::MAX) {
            let expected = format!("points whose turns stay within {} rotary counts", i32::MAX);
            problems.push(Problem::new("scan.points", expected, format!("{end:.0} counts")));
        }
    }

    /// Of a scan that is where the part is.
    fn ball_problems(&self, problems: &mut Vec<Problem>) {
        if !ball::is_ball(&self.nominal) {
            let expected = "a sphere, for a ball is scanned";
            problems.push(Problem::new("part.surface", expected, self.nominal.kind()));
        }
        let far_mm = self.nominal.radius_mm().unwrap_or_default().abs()
            + self.pose.tx_mm.hypot(self.pose.ty_mm);
        let step_nm = self.motion.step_nm();
        if step_nm > 0 && far_mm * 1e6 / f64::from(step_nm) > f64::from(i32::MAX) {
            let expected = "positions within 32 bits";
            problems.push(Problem::new("stage.step_nm", expected, "a finer step"));
        }
        if !self.free.iter().all(|free| BALL_FREE.contains(free)) {
            let expected = "tx, ty, tz and radius, which are all that a ball has";
            problems.push(Problem::new("fit.free", expected, "another"));
        }
    }

    fn instrument_problems(&self, problems: &mut Vec<Problem>) {
        check_range(problems, "probe.noise_nm", self.noise_nm, 0.0, 1e5);
        check_range(problems, "probe.standoff_mm", self.standoff_mm, 0.0, 1e3);
        check_range(problems, "probe.full_scale_um", self.full_scale_um, 1.0, 1e6);
        check_range(problems, "probe.intensity", self.intensity, 0.0, 1e6);
        let wanted = self.motion.transducers();
        let given = self.node_ids.len();
        if given != wanted {
            let expected = format!("{wanted} for this kind of scan");
            problems.push(Problem::new("stage.node_ids", expected, given));
        }
        for (index, &id) in self.node_ids.iter().enumerate() {
            if !(1..=127).contains(&id) || self.node_ids[..index].contains(&id) {
                let key = format!("stage.node_ids[{index}]");
                problems.push(Problem::new(key, "1 to 127, each once", id));
            }
        }
        let Some(thermal) = self.thermal else { return };
        if (248..=254).contains(&thermal.unit_id) {
            problems.push(Problem::new("thermal.unit_id", "0 to 247, or 255", thermal.unit_id));
        }
        // The registers hold hundredths of a degree in 16 bits with sign.
        check_range(problems, "thermal.mean_degc", thermal.mean_degc, -200.0, 200.0);
        check_range(problems, "thermal.amplitude_degc", thermal.amplitude_degc, 0.0, 100.0);
        check_range(problems, "thermal.period_s", thermal.period_s, 1e-3, 1e6);
    }

    fn fault_problems(&self, problems: &mut Vec<Problem>) {
        for (index, scheduled) in self.faults.iter().enumerate() {
            let key = |key: &str| format!("fault[{index}].{key}");
            if scheduled.at_point >= self.points {
                let expected = format!("a trigger below scan.points = {}", self.points);
                problems.push(Problem::new(key("at_point"), expected, scheduled.at_point));
            }
            if !scheduled.fault.suits(scheduled.link) {
                let expected = format!("a fault that can happen to {}", scheduled.link);
                problems.push(Problem::new(key("kind"), expected, scheduled.fault.kind()));
            }
            if scheduled.link == Link::Thermal && self.thermal.is_none() {
                problems.push(Problem::new(key("link"), "a link of the scene", "thermal"));
            }
        }
    }
}

/// Parameters of a ball.
const BALL_FREE: [Parameter; 4] = [Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Radius];
/// Every trigger is kept in memory, 16 bytes each.
const MAX_POINTS: u64 = 10_000_000;
