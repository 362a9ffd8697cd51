//! A finished measurement as a front sees a station whose session has ended.

use std::future::{pending, ready};
use std::sync::Arc;

use asphera_face::VolumeViewer;
use asphera_measure::{Measurement, Next};
use asphera_report::{
    Answer, ControlError, Cut, FormViewAnswer, Label, LiveStation, Progress, Report, ResultFile,
    SamplingMaps, SectionRequest, SessionEntry, SessionFile, SliceAnswer, SliceRequest, Snapshot,
    Term, VolumeState, VolumeView, Waypoints,
};
use tokio::task::spawn_blocking;

use crate::results;
use crate::snapshot::{empty, take_measurement};

/// A finished measurement, and the volume that it was made of, if any.
pub(crate) struct ShownMeasurement {
    snapshot: Arc<Snapshot>,
    report: Arc<Report>,
    measurement: Arc<Measurement>,
    volume: Option<Arc<VolumeViewer>>,
}

impl ShownMeasurement {
    /// A measurement under the name of what was measured.
    pub(crate) fn new(
        name: &str,
        measurement: Measurement,
        volume: Option<VolumeViewer>,
    ) -> ShownMeasurement {
        let mut snapshot = Snapshot { sequence: 1, ..empty(name) };
        take_measurement(&mut snapshot, &measurement);
        let received = measurement.report.points.received;
        snapshot.progress = Progress {
            expected_points: Some(received),
            fraction: Some(1.0),
            ..Progress::default()
        };
        snapshot.volume = volume
            .as_ref()
            .and(measurement.report.volume.as_ref())
            .map(|face| VolumeState { size: face.size, face: Box::new(face.clone()) });
        ShownMeasurement {
            snapshot: Arc::new(snapshot),
            report: Arc::new(measurement.report.clone()),
            measurement: Arc::new(measurement),
            volume: volume.map(Arc::new),
        }
    }

    /// Answers from the measurement, on a thread that may take its time.
    fn ask<T: Send + 'static>(
        &self,
        question: impl FnOnce(&Measurement) -> Option<T> + Send + 'static,
    ) -> Answer<'_, Option<T>> {
        let measurement = Arc::clone(&self.measurement);
        Box::pin(async move {
            let answer = spawn_blocking(move || question(&measurement)).await;
            answer.ok().flatten()
        })
    }
}

impl LiveStation for ShownMeasurement {
    fn snapshot(&self) -> Arc<Snapshot> {
        Arc::clone(&self.snapshot)
    }

    fn snapshot_after(&self, sequence: u64) -> Answer<'_, Option<Arc<Snapshot>>> {
        if sequence == self.snapshot.sequence {
            // Nothing changes any more.
            return Box::pin(pending());
        }
        Box::pin(ready(Some(self.snapshot())))
    }

    fn mesh_ply(&self) -> Answer<'_, Option<Vec<u8>>> {
        self.ask(results::finished_mesh_ply)
    }

    fn maps(&self) -> Answer<'_, Option<Arc<SamplingMaps>>> {
        self.ask(|measurement| measurement.surface.maps())
    }

    fn contour(&self) -> Answer<'_, Option<Arc<asphera_report::contour::SessionContour>>> {
        Box::pin(ready(None))
    }

    fn parts(&self) -> Answer<'_, Option<Arc<asphera_report::parts::SessionParts>>> {
        Box::pin(ready(None))
    }

    fn volume(&self) -> Answer<'_, Option<Arc<VolumeView>>> {
        Box::pin(ready(self.volume.as_ref().map(|viewer| Arc::clone(viewer.view()))))
    }

    fn volume_slice(&self, request: SliceRequest) -> Answer<'_, SliceAnswer> {
        let viewer = self.volume.clone();
        Box::pin(async move {
            let viewer = viewer?;
            spawn_blocking(move || viewer.slice(request)).await.ok()
        })
    }

    fn section(&self, request: SectionRequest) -> Answer<'_, Cut> {
        self.ask(move |measurement| measurement.surface.section(&request))
    }

    fn without(&self, terms: Vec<Term>) -> Answer<'_, FormViewAnswer> {
        self.ask(move |measurement| measurement.surface.without(&terms))
    }

    fn waypoints(&self) -> Answer<'_, Option<Waypoints>> {
        self.ask(|measurement| measurement.next.as_ref().map(Next::waypoints))
    }

    fn report(&self) -> Option<Arc<Report>> {
        Some(Arc::clone(&self.report))
    }

    fn sessions(&self) -> Answer<'_, Vec<SessionEntry>> {
        Box::pin(ready(Vec::new()))
    }

    fn session_file(&self, _id: String, _of: ResultFile) -> Answer<'_, Option<SessionFile>> {
        Box::pin(ready(None))
    }

    fn start(&self, _label: Label) -> Answer<'_, Result<(), ControlError>> {
        Box::pin(ready(Err(no_station())))
    }

    fn stop(&self) -> Answer<'_, Result<(), ControlError>> {
        Box::pin(ready(Err(no_station())))
    }
}

/// The answer to every command.
fn no_station() -> ControlError {
    let message =
        "this page shows a finished measurement: expected a station, which `asphera run` starts";
    ControlError { conflict: true, message: message.to_owned() }
}
