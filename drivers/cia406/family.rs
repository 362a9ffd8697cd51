//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use asphera_link::{BusNumber, Carries, Channel, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::{Cia406, Kind, PositionObject, Settings, Transmission};

/// Encoders and transducers after CiA 406: `driver = "cia406"`, on a CAN bus.
pub const FAMILY: Family = Family {
    name: "cia406",
    carries: Carries::CanFrames,
    settings: |table| Some(Box::new(read(table))),
    propose: None,
};

fn read(table: &Section<'_>) -> Settings {
    let default = Settings::default();
    let objects = [
        ("6020", PositionObject::MultiSensor),
        ("6004", PositionObject::Single),
        ("6004-unsigned", PositionObject::SingleUnsigned),
    ];
    Settings {
        node_id: table.required("node_id").unwrap_or(default.node_id),
        vendor_id: table.get("vendor_id"),
        position: table.word("position_object", default.position, &objects),
        kind: kind(table),
        listen_only: table.or("listen_only", default.listen_only),
        map_velocity: table.or("map_velocity", default.map_velocity),
        velocity_step_mm_s: table.get("velocity_step_mm_s"),
        map_status: table.or("map_status", default.map_status),
        transmission: match table.get("event_timer_ms") {
            Some(period_ms) => Transmission::EventTimer { period_ms },
            None => Transmission::Sync { every: table.or("every_sync", 1) },
        },
        sync_counter_overflow: match table.or("sync_counter_overflow", 240u8) {
            0 => None,
            overflow => Some(overflow),
        },
        sync_window_us: table.get("sync_window_us"),
        heartbeat_ms: table.or("heartbeat_ms", default.heartbeat_ms),
        sdo_timeout_ms: table.or("sdo_timeout_ms", default.sdo_timeout_ms),
    }
}

fn kind(table: &Section<'_>) -> Kind {
    let words = ["linear", "rotary", "counts"].map(|word| (word, word));
    match table.word("kind", "linear", &words) {
        "rotary" => {
            Kind::Rotary { counts_per_turn: table.required("counts_per_turn").unwrap_or(1) }
        }
        "counts" => Kind::Counts,
        _ => Kind::Linear { step_nm: table.get("step_nm") },
    }
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        Settings::channels(self)
    }

    fn count_cycle(&self) -> Result<u32, &'static str> {
        match (self.transmission, self.sync_counter_overflow) {
            (Transmission::Sync { every: 1 }, Some(overflow)) => Ok(overflow.into()),
            (Transmission::Sync { every: 1 }, None) => Err("its SYNC has no counter"),
            _ => Err("it does not answer every SYNC"),
        }
    }

    fn bus_number(&self) -> Option<BusNumber> {
        Some(BusNumber { key: "node_id", number: self.node_id })
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(Cia406::new(self.clone())?))
    }
}

#[cfg(test)]
mod tests {
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("stage", text)
    }

    #[test]
    fn a_node_counts_by_its_sync_and_has_a_number_on_the_bus() {
        let known = settings("node_id = 5").unwrap();
        assert_eq!(known.count_cycle(), Ok(240));
        assert_eq!(known.bus_number(), Some(BusNumber { key: "node_id", number: 5 }));
        assert_eq!(known.driver().unwrap().channels(), known.channels());
        let why =
            |key| settings(&format!("node_id = 5\n{key}")).unwrap().count_cycle().unwrap_err();
        assert!(why("sync_counter_overflow = 0").contains("no counter"));
        assert!(why("every_sync = 2").contains("not answer every SYNC"));
        assert!(why("event_timer_ms = 10").contains("not answer every SYNC"));
    }

    #[test]
    fn every_mistake_is_told_with_its_line_under_the_key_of_the_table() {
        let text = "kind = \"rotary\"\ncounts_per_turn = 0\nevery_sync = 241\nstep_nm = 5";
        let problems = settings(text).unwrap_err();
        let told: Vec<_> =
            problems.0.iter().map(|found| (found.line, found.key.as_str())).collect();
        let expected = [(1, "node_id"), (2, "counts_per_turn"), (3, "every_sync"), (4, "step_nm")];
        assert_eq!(told, expected);
        let problems = settings("node_id = 5\nstep_nm = -1\nevent_timer_ms = 0").unwrap_err();
        let told: Vec<_> =
            problems.0.iter().map(|found| (found.line, found.key.as_str())).collect();
        assert_eq!(told, [(2, "step_nm"), (3, "event_timer_ms")]);
    }
}
