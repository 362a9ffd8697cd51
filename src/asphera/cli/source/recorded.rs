//! A recorded session as a source of points.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::path::Path;

use asphera_geometry::PointMm;
use asphera_report::SessionFigures;

use super::super::output::Failure;
use super::super::progress::Progress;
use crate::contour::ContourPlan;
use crate::replay::{Playback, Played};
use crate::station::Point;
use crate::weighing::Weighing;
use asphera_measure::Part;
use asphera_measure::{Along, Measurement, Systematic, Tip, contacts};

/// The points of a session as its station took them, good and flagged ones, in order.
pub(in crate::cli) struct Recorded {
    part: Part,
    along: Along,
    tip: Option<Tip>,
    /// Contacts of its ball tip, once they are asked for, mm.
    contacts_mm: OnceCell<Vec<PointMm>>,
    points: Vec<Point>,
    /// Noise of their heights, mm, where they were joined by time and it is stated.
    noise_mm: Option<f64>,
    played: Played,
}

impl Recorded {
    /// Plays a recording to its end.
    pub(super) fn play(path: &Path, progress: &Progress) -> Result<Recorded, Failure> {
        let playback = Playback::open(path)?;
        let (part, along) = (playback.part().clone(), playback.along());
        let (noise_mm, tip) = (playback.noise_mm(), playback.tip());
        progress.count("replaying", None);
        let mut points = Vec::new();
        let played = playback.play(
            |_| {},
            |point| {
                points.push(*point);
                progress.add(1);
            },
        );
        let contacts_mm = OnceCell::new();
        Ok(Recorded { part, along, tip, contacts_mm, points, noise_mm, played })
    }

    /// The part as the recording names it.
    pub(super) fn part(&self) -> &Part {
        &self.part
    }

    /// The direction of projection as the recording names it.
    pub(super) fn along(&self) -> Along {
        self.along
    }

    /// The ball tip that measured it; its points are centres of the ball then.
    pub(in crate::cli) fn tip(&self) -> Option<Tip> {
        self.tip
    }

    /// The contour that the recording asks for.
    pub(in crate::cli) fn contour(&self) -> Option<&ContourPlan> {
        self.played.contour()
    }

    /// How its points get their uncertainties, for a part.
    pub(in crate::cli) fn weighing(&self, part: &Part) -> Weighing {
        Weighing::new(part, self.noise_mm)
    }

    /// All points, in order.
    pub(in crate::cli) fn points(&self) -> &[Point] {
        &self.points
    }

    /// Id, start, station and end of the session.
    pub(in crate::cli) fn session(&self) -> &SessionFigures {
        self.played.session()
    }

    /// The points of the surface that may be used, mm: of a ball tip its contacts with the part of the recording.
    pub(super) fn good_points(&self) -> Box<dyn Iterator<Item = PointMm> + '_> {
        let good = self.points.iter().filter(|point| point.is_good());
        let good = good.map(|point| point.position_mm);
        let Some(tip) = self.tip else { return Box::new(good) };
        let found = || contacts(good, &self.part, self.along, tip);
        Box::new(self.contacts_mm.get_or_init(found).iter().copied())
    }

    /// How many points may not be used.
    pub(super) fn flagged(&self) -> usize {
        self.points.iter().filter(|point| !point.is_good()).count()
    }

    /// Errors that all its points have together.
    pub(in crate::cli) fn systematic(&self) -> impl Iterator<Item = Systematic> {
        self.played.systematic()
    }

    /// Losses of the session and of its recording, in the words of the report.
    pub(super) fn losses(&self) -> Vec<String> {
        self.played.losses()
    }

    /// The session in one line: whose points these are, and which are left out.
    pub(super) fn told(&self) -> String {
        let SessionFigures { id, station, .. } = self.session();
        let mut text = format!("recording  {id} of {station}: {} points", self.points.len());
        let mut flags = BTreeMap::<&str, u64>::new();
        for point in self.points.iter().filter(|point| !point.is_good()) {
            for name in point.flags.names() {
                *flags.entry(name).or_default() += 1;
            }
        }
        if !flags.is_empty() {
            let named: Vec<_> =
                flags.iter().map(|(name, count)| format!("{name} {count}")).collect();
            text.push_str(&format!(
                ", {} flagged and left out ({})",
                self.flagged(),
                named.join(", ")
            ));
        }
        text
    }

    /// Adds to the figures of these points what the station and the recording know.
    pub(in crate::cli) fn conclude(&self, measurement: &mut Measurement) {
        self.played.clone().conclude(measurement);
    }
}
