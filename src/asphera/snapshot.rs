//! A snapshot of a finished measurement, of a station or of a file.

use asphera_measure::Measurement;
use asphera_report::contour::ContourState;
use asphera_report::parts::SessionParts;
use asphera_report::{MapsState, Progress, SNAPSHOT_FORMAT, Snapshot, State};

/// A snapshot in which nothing was measured.
pub(crate) fn empty(station: &str) -> Snapshot {
    Snapshot {
        format: SNAPSHOT_FORMAT,
        sequence: 0,
        station: station.to_owned(),
        state: State::Idle,
        elapsed_s: 0.0,
        session: None,
        progress: Progress::default(),
        points: Default::default(),
        mesh: Default::default(),
        sampling: Default::default(),
        features: Default::default(),
        form: None,
        verdict: Default::default(),
        map: None,
        maps: None,
        contour: None,
        parts: None,
        volume: None,
        scan: None,
        convergence: Default::default(),
        outputs: None,
        links: Vec::new(),
    }
}

/// Takes the figures of a finished measurement into a snapshot.
pub(crate) fn take_measurement(snapshot: &mut Snapshot, measurement: &Measurement) {
    let report = &measurement.report;
    snapshot.state = State::Complete;
    snapshot.session = report.session.clone();
    snapshot.points = report.points.clone();
    snapshot.mesh = report.mesh.clone();
    snapshot.sampling = report.sampling.clone();
    snapshot.features = report.features.clone();
    snapshot.form = report.form.clone();
    snapshot.map = measurement.cells.clone();
    // Of parts alone there is no whole to have maps of.
    let has_whole = report.form.is_some() || report.parts.is_none();
    let version = measurement.surface.maps_version().filter(|_| has_whole);
    snapshot.maps =
        version.map(|version| MapsState { version, as_of_points: report.sampling.as_of_points });
    let as_of_points = report.points.received;
    snapshot.parts = report.parts.as_ref().map(SessionParts::state);
    snapshot.contour = report.contour.as_ref().map(|_| ContourState { as_of_points });
    snapshot.verdict = report.verdict.clone();
    if let Some(form) = &report.form {
        let deviation = &form.deviation;
        let known = deviation.uncertainty.as_ref();
        let basis = known.map_or("not known", |known| known.model.as_str()).to_owned();
        snapshot.convergence.push(
            report.points.used,
            [deviation.pv_nm, deviation.rms_nm],
            [known.map(|known| known.u_pv_nm), known.map(|known| known.u_rms_nm)],
            [basis.clone(), basis],
        );
    }
}
