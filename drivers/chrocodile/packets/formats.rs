//! Formats that the device sent, by their counters.

use std::collections::VecDeque;

use super::sample::{SamplePlan, UnusableFormat};
use crate::packets::PacketSettings;
use crate::wire::packet::Format;

/// Formats that are remembered: data of an earlier one may still be on their way.
const REMEMBERED: usize = 8;

/// The formats of one connection, the newest last.
#[derive(Debug, Default)]
pub(super) struct Formats {
    known: VecDeque<Known>,
}

#[derive(Debug)]
pub(super) struct Known {
    pub(super) format: Format,
    pub(super) plan: Result<SamplePlan, UnusableFormat>,
}

impl Formats {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.known.clear();
    }

    /// Adds a format; whether its samples give readings.
    pub(super) fn insert(
        &mut self,
        format: Format,
        settings: &PacketSettings,
        full_scale_um: f64,
    ) -> &Known {
        self.known.retain(|known| known.format.counter != format.counter);
        if self.known.len() == REMEMBERED {
            self.known.pop_front();
        }
        let plan = SamplePlan::new(&format, settings, full_scale_um);
        self.known.push_back(Known { format, plan });
        &self.known[self.known.len() - 1]
    }

    /// Reads from now on with another full scale.
    pub(super) fn rescale(&mut self, settings: &PacketSettings, full_scale_um: f64) {
        for known in &mut self.known {
            known.plan = SamplePlan::new(&known.format, settings, full_scale_um);
        }
    }

    /// The format of a counter.
    pub(super) fn get(&self, counter: i32) -> Option<&Known> {
        self.known.iter().rev().find(|known| known.format.counter == counter)
    }
}
