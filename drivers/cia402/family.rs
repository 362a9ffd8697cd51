//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use asphera_link::{BusNumber, Carries, Channel, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::{Cia402, Homing, Reference, Settings, Step};

/// Drives after CiA 402: `driver = "cia402"`, on a CAN bus.
pub const FAMILY: Family = Family {
    name: "cia402",
    carries: Carries::CanFrames,
    settings: |table| read(table).map(|settings| Box::new(settings) as _),
    propose: None,
};

fn read(table: &Section<'_>) -> Option<Settings> {
    let default = Settings::default();
    let node_id = table.required("node_id");
    let step = match (table.get("step_nm"), table.get("counts_per_turn")) {
        (Some(nm), None) => Some(Step::Nanometres(nm)),
        (None, Some(counts)) => Some(Step::CountsPerTurn(counts)),
        (nm, _) => {
            let found = if nm.is_some() { "both" } else { "nothing" };
            table.problem("step_nm", "one of `step_nm` and `counts_per_turn`", found);
            None
        }
    };
    let references = [("homing", Reference::Homing), ("absolute", Reference::Absolute)];
    let settings = Settings {
        node_id: node_id.unwrap_or(default.node_id),
        vendor_id: table.get("vendor_id"),
        axis: table.or("axis", default.axis),
        step: step.unwrap_or(default.step),
        velocity_scale: table.or("velocity_scale", default.velocity_scale),
        acceleration_scale: table.or("acceleration_scale", default.acceleration_scale),
        reference: table.word("reference", default.reference, &references),
        homing: None,
        period_ms: table.or("period_ms", default.period_ms),
        heartbeat_ms: table.or("heartbeat_ms", default.heartbeat_ms),
        sdo_timeout_ms: table.or("sdo_timeout_ms", default.sdo_timeout_ms),
        state_timeout_ms: table.or("state_timeout_ms", default.state_timeout_ms),
    };
    let homing = table.section("homing");
    let homing = if homing.is_present() { read_homing(&homing, &settings) } else { None };
    step?;
    Some(Settings { homing, ..settings })
}

fn read_homing(table: &Section<'_>, settings: &Settings) -> Option<Homing> {
    let unit = settings.homing_unit();
    let [switch, zero, acceleration, offset] =
        settings.homing_keys().map(|key| key.trim_start_matches("homing."));
    let method = table.required::<i64>("method").and_then(|method| {
        let known = i8::try_from(method).ok();
        if known.is_none() {
            table.problem("method", "a homing method, -128 to 127", method);
        }
        known
    });
    let speeds = [switch, zero].map(|key| table.required::<f64>(key));
    let acceleration = table.get::<f64>(acceleration).map(|value| value * unit);
    let offset = table.or(offset, 0.0) * unit;
    table.finish();
    let [switch, zero] = speeds;
    Some(Homing { method: method?, speeds: [switch? * unit, zero? * unit], acceleration, offset })
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        Settings::channels(self)
    }

    fn bus_number(&self) -> Option<BusNumber> {
        Some(BusNumber { key: "node_id", number: self.node_id })
    }

    fn moves_axes(&self) -> bool {
        true
    }

    fn homes(&self) -> bool {
        self.homing.is_some()
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(Cia402::new(self.clone())?))
    }
}

#[cfg(test)]
mod tests {
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("stage", text)
    }

    fn wrong(text: &str) -> Vec<(usize, String)> {
        let problems = settings(text).unwrap_err();
        problems.0.into_iter().map(|problem| (problem.line, problem.key)).collect()
    }

    #[test]
    fn a_drive_has_one_axis_and_a_number_on_the_bus() {
        let known = settings("node_id = 5\naxis = \"x\"\nstep_nm = 100").unwrap();
        assert_eq!(known.bus_number(), Some(BusNumber { key: "node_id", number: 5 }));
        assert_eq!(known.channels()[0].name, "x");
        assert!(known.moves_axes() && !known.homes());
        let homing = "homing = { method = 17, switch_mm_s = 10, zero_mm_s = 1 }";
        assert!(settings(&format!("node_id = 5\nstep_nm = 100\n{homing}")).unwrap().homes());
        let homing =
            "homing = { method = -1, switch_deg_s = 36, zero_deg_s = 3.6, offset_deg = 90 }";
        assert!(
            settings(&format!("node_id = 5\ncounts_per_turn = 4000\n{homing}")).unwrap().homes()
        );
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let named = |line, key: &str| (line, key.to_owned());
        assert_eq!(wrong("node_id = 0\nstep_nm = 0"), [named(1, "node_id"), named(2, "step_nm")]);
        assert_eq!(wrong("node_id = 1"), [named(1, "step_nm")]);
        let text = "node_id = 1\nstep_nm = 1\ncounts_per_turn = 1";
        assert_eq!(wrong(text), [named(2, "step_nm")]);
        let text =
            "node_id = 1\nstep_nm = 100\nhoming = { method = 0, switch_mm_s = 0, zero_mm_s = 1 }";
        assert_eq!(wrong(text), [named(3, "homing.method"), named(3, "homing.switch_mm_s")]);
        let text = "node_id = 1\nstep_nm = 100\nhoming = { switch_mm_s = 1, zero_deg_s = 1 }";
        let keys: Vec<String> = wrong(text).into_iter().map(|(_, key)| key).collect();
        assert!(
            keys.contains(&"homing.method".to_owned())
                && keys.contains(&"homing.zero_mm_s".to_owned())
        );
    }
}
