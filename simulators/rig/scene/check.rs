//! Ranges of a scene's numbers, and whether they fit each other.

use asphera_form::form_error::LARGEST_FRINGE;

use super::Scene;
use super::read::Place;
use crate::motion::Motion;
use crate::{Link, SceneError, Speed};

impl Scene {
    /// Whether the scene can be played; the numbers of the builder are looked at again here.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        self.check_part()?;
        self.check_scan()?;
        self.check_instruments()?;
        self.check_faults()
    }

    fn check_part(&self) -> Result<(), SceneError> {
        self.within("part.semi_diameter_mm", self.semi_diameter_mm, 1e-3, 1e3)?;
        if !self.nominal.is_rotational() {
            return Err(Place(&self.name).wrong(
                "part.surface",
                "a plane, a sphere or an asphere",
                self.nominal.kind(),
            ));
        }
        let steepest = self.nominal.slope(self.semi_diameter_mm);
        if !steepest.is_finite() {
            return Err(Place(&self.name).wrong(
                "part.semi_diameter_mm",
                "a radius within the surface's domain",
                self.semi_diameter_mm,
            ));
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
            self.within(key, value, -limit, limit)?;
        }
        for &(index, height_nm) in &self.form_error.fringe_nm {
            if !(1..=LARGEST_FRINGE).contains(&index) {
                let key = "part.form_error.fringe.index";
                return Err(Place(&self.name).wrong(key, "1 to 100", index));
            }
            self.within("part.form_error.fringe.height_nm", height_nm, -1e5, 1e5)?;
        }
        if let Some(ring) = self.form_error.ring {
            let semi_mm = self.semi_diameter_mm;
            self.within("part.form_error.ring.radius_mm", ring.radius_mm, 0.0, semi_mm)?;
            self.within("part.form_error.ring.width_mm", ring.width_mm, 1e-3, semi_mm)?;
            self.within("part.form_error.ring.height_nm", ring.height_nm, -1e5, 1e5)?;
        }
        for (key, limit) in
            [("tolerance.pv_nm", self.tolerance.pv_nm), ("tolerance.rms_nm", self.tolerance.rms_nm)]
        {
            if let Some(limit_nm) = limit {
                self.within(key, limit_nm, 1e-3, 1e9)?;
            }
        }
        Ok(())
    }

    fn check_scan(&self) -> Result<(), SceneError> {
        let place = Place(&self.name);
        if !(1..=MAX_POINTS).contains(&self.points) {
            return Err(place.wrong("scan.points", "1 to 10000000", self.points));
        }
        self.within("scan.rate_hz", self.rate_hz, 1.0, 66_000.0)?;
        if let Speed::Times(times) = self.speed {
            self.within("speed", times, 1e-3, 1e3)?;
        }
        self.within("stage.step_nm", self.motion.step_nm().into(), 1.0, 1e6)?;
        let reach_mm = self.motion.reach_mm();
        let key = match self.motion {
            Motion::Spiral { counts_per_turn, .. } => {
                self.within("scan.counts_per_turn", counts_per_turn.into(), 1.0, 1e9)?;
                "scan.radius_mm"
            }
            Motion::Raster { .. } => "scan.half_width_mm",
        };
        let decentre_mm = self.pose.tx_mm.hypot(self.pose.ty_mm);
        if !(reach_mm > 0.0 && reach_mm + decentre_mm <= self.semi_diameter_mm) {
            let expected = format!(
                "points within part.semi_diameter_mm = {} of the decentred part",
                self.semi_diameter_mm
            );
            let found = format!("a reach of {} mm", reach_mm + decentre_mm);
            return Err(place.wrong(key, expected, found));
        }
        if reach_mm * 1e6 / f64::from(self.motion.step_nm()) > f64::from(i32::MAX) {
            return Err(place.wrong("stage.step_nm", "positions within 32 bits", "a finer step"));
        }
        let end = self.motion.rotary_end_counts(self.points);
        if end > f64::from(i32::MAX) {
            let expected = format!("points whose turns stay within {} rotary counts", i32::MAX);
            return Err(place.wrong("scan.points", expected, format!("{end:.0} counts")));
        }
        Ok(())
    }

    fn check_instruments(&self) -> Result<(), SceneError> {
        let place = Place(&self.name);
        self.within("probe.noise_nm", self.noise_nm, 0.0, 1e5)?;
        self.within("probe.standoff_mm", self.standoff_mm, 0.0, 1e3)?;
        self.within("probe.full_scale_um", self.full_scale_um, 1.0, 1e6)?;
        self.within("probe.intensity", self.intensity, 0.0, 1e6)?;
        let wanted = self.motion.transducers();
        if self.node_ids.len() != wanted {
            let expected = format!("{wanted} for this kind of scan");
            return Err(place.wrong("stage.node_ids", expected, self.node_ids.len()));
        }
        for (index, &id) in self.node_ids.iter().enumerate() {
            if !(1..=127).contains(&id) || self.node_ids[..index].contains(&id) {
                return Err(place.wrong("stage.node_ids", "1 to 127, each once", id));
            }
        }
        let Some(thermal) = self.thermal else { return Ok(()) };
        if (248..=254).contains(&thermal.unit_id) {
            return Err(place.wrong("thermal.unit_id", "0 to 247, or 255", thermal.unit_id));
        }
        // The registers hold hundredths of a degree in 16 bits with sign.
        self.within("thermal.mean_degc", thermal.mean_degc, -200.0, 200.0)?;
        self.within("thermal.amplitude_degc", thermal.amplitude_degc, 0.0, 100.0)?;
        self.within("thermal.period_s", thermal.period_s, 1e-3, 1e6)
    }

    fn check_faults(&self) -> Result<(), SceneError> {
        for (index, scheduled) in self.faults.iter().enumerate() {
            let place = Place(&self.name);
            let key = |key: &str| format!("fault[{index}].{key}");
            if scheduled.at_point >= self.points {
                let expected = format!("a trigger below scan.points = {}", self.points);
                return Err(place.wrong(key("at_point"), expected, scheduled.at_point));
            }
            if !scheduled.fault.suits(scheduled.link) {
                let expected = format!("a fault that can happen to {}", scheduled.link);
                return Err(place.wrong(key("kind"), expected, scheduled.fault.kind()));
            }
            if scheduled.link == Link::Thermal && self.thermal.is_none() {
                return Err(place.wrong(key("link"), "a link of the scene", "thermal"));
            }
        }
        Ok(())
    }

    fn within(&self, key: &str, value: f64, low: f64, high: f64) -> Result<(), SceneError> {
        if (low..=high).contains(&value) {
            Ok(())
        } else {
            Err(Place(&self.name).wrong(key, format!("{low} to {high}"), value))
        }
    }
}

/// Every trigger is kept in memory, 16 bytes each.
const MAX_POINTS: u64 = 10_000_000;
