//! Orders to the axis.

use asphera_link::{AxisMove, MotionFailure, MotionTrouble, Nanos};

use super::{Cia402, Job, Order, steps};

impl Cia402 {
    pub(super) fn order_move(
        &mut self,
        now: Nanos,
        moves: &[AxisMove],
    ) -> Result<(), MotionFailure> {
        self.check_free()?;
        let refused = |detail| Err(MotionFailure::new(MotionTrouble::Refused, detail));
        let [order] = moves else {
            return refused(format!(
                "expected a move of one axis, found {}: a drive has one axis",
                moves.len()
            ));
        };
        if order.axis != self.settings.axis {
            return refused(format!(
                "expected axis {}, found {:?}: name the axis of the drive",
                self.settings.axis, order.axis
            ));
        }
        if !self.is_homed {
            let detail = format!(
                "axis {} does not know its place: home it, with home = true in [scan.plan]",
                self.settings.axis
            );
            return Err(MotionFailure::new(MotionTrouble::Unreferenced, detail));
        }
        let Some(steps) = steps::moving(&self.settings, order) else {
            return refused(format!(
                "place {}, speed {} or acceleration {:?} of axis {} is beyond the drive's objects: plan another, or correct step_nm and velocity_scale",
                order.to, order.speed, order.acceleration, order.axis
            ));
        };
        self.begin(now, Job::Preparing(Order::Move), steps);
        Ok(())
    }

    pub(super) fn order_home(&mut self, now: Nanos) -> Result<(), MotionFailure> {
        self.check_free()?;
        let Some(steps) = steps::homing(&self.settings) else {
            let detail = format!(
                "axis {} has no settings for homing, or speeds beyond the drive's objects: set homing = {{ method, … }} of the device",
                self.settings.axis
            );
            return Err(MotionFailure::new(MotionTrouble::Refused, detail));
        };
        // What the drive knew of its place does not count any more.
        self.is_homed = false;
        self.begin(now, Job::Preparing(Order::Home), steps);
        Ok(())
    }

    fn check_free(&self) -> Result<(), MotionFailure> {
        if !self.is_measuring || !self.is_configured {
            return Err(self.unanswered());
        }
        if self.job != Job::Rest {
            let detail = "the drive still moves: wait until it stands";
            return Err(MotionFailure::new(MotionTrouble::Refused, detail));
        }
        Ok(())
    }

    pub(super) fn unanswered(&self) -> MotionFailure {
        let detail = format!(
            "node {} is not set up and measuring on this connection: check the cable and the power of the drive",
            self.node
        );
        MotionFailure::new(MotionTrouble::Unanswered, detail)
    }

    /// Stops the drive: what waits is dropped, and the quick stop goes first. Why, where it is no order.
    pub(super) fn halt(&mut self, now: Nanos, failure: Option<MotionFailure>) {
        self.transmit.clear();
        self.send_halt(now, failure, 1);
    }

    pub(super) fn send_halt(&mut self, now: Nanos, failure: Option<MotionFailure>, attempt: u8) {
        self.begin(now, Job::Halting { failure, attempt }, steps::halting());
    }
}
