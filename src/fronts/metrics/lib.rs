//! A station in the text format of Prometheus, version 0.0.4: what a monitor keeps of it over days.
//!
//! Names follow the rules of Prometheus: base units (metres, seconds, ratios from 0 to 1), `_total` behind counters. A figure
//! that is not known has no line: it is never a zero. Counters begin anew with every start of the station.
//!
//! <https://prometheus.io/docs/instrumenting/exposition_formats/>
//!
//! This crate has no network: `asphera-http` answers `GET /metrics` with its text.

mod exposition;

use asphera_report::{Connection, LinkState, Snapshot, State, Status, Verdict};

use exposition::{Exposition, Kind};

/// Media type of the text.
pub const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// A snapshot of a station as text. Time in proportion to its links and limits.
///
/// # Examples
///
/// ```
/// # use asphera_report::Snapshot;
/// fn print(snapshot: &Snapshot) {
///     assert!(asphera_metrics::text(snapshot).contains("asphera_station_state{"));
/// }
/// ```
pub fn text(snapshot: &Snapshot) -> String {
    let mut out = Exposition::default();
    station(&mut out, snapshot);
    session(&mut out, snapshot);
    form(&mut out, snapshot);
    verdict(&mut out, &snapshot.verdict);
    links(&mut out, &snapshot.links);
    out.finish()
}

fn station(out: &mut Exposition, snapshot: &Snapshot) {
    let states = [
        ("idle", State::Idle),
        ("measuring", State::Measuring),
        ("finishing", State::Finishing),
        ("complete", State::Complete),
        ("failed", State::Failed),
    ];
    out.family("asphera_station_state", Kind::Gauge, "1 for the state of the station, else 0.");
    for (name, state) in states {
        let labels = [("station", snapshot.station.as_str()), ("state", name)];
        out.flag(&labels, snapshot.state == state);
    }
}

fn session(out: &mut Exposition, snapshot: &Snapshot) {
    let Snapshot { progress, points, mesh, sampling, .. } = snapshot;
    out.gauge("asphera_session_seconds", "Time since the session started.", snapshot.elapsed_s);
    out.gauge("asphera_session_points", "Points received in the session.", points.received as f64);
    out.gauge("asphera_session_points_used", "Points in fit and figures.", points.used as f64);
    out.gauge("asphera_session_points_lost", "Triggers without a reading.", points.lost as f64);
    let help = "Triggers of the scan that had not come when the session ended.";
    out.gauge("asphera_session_points_missing", help, points.missing as f64);
    let help = "Points not used, by reason.";
    out.family("asphera_session_points_flagged", Kind::Gauge, help);
    for (reason, count) in &points.flagged {
        out.sample(&[("reason", reason)], *count as f64);
    }
    out.gauge("asphera_session_points_per_second", "Points a second.", progress.rate_hz);
    out.known("asphera_session_progress_ratio", "Share of the scan plan.", progress.fraction);
    let pending = progress.pending_points as f64;
    out.gauge("asphera_session_points_pending", "Points that are not in the mesh yet.", pending);
    let behind_s = progress.backlog.map_or(0.0, |backlog| backlog.behind_s);
    let help = "Delay of the processing behind the recording.";
    out.gauge("asphera_session_behind_seconds", help, behind_s);
    out.gauge("asphera_mesh_vertices", "Vertices of the mesh.", mesh.vertices as f64);
    let help = "Share of the aperture that is sampled densely enough.";
    out.known("asphera_sampling_coverage_ratio", help, sampling.coverage);
    out.known(
        "asphera_sampling_epsilon",
        "Largest gap over local feature size.",
        sampling.epsilon_max,
    );
    out.known(
        "asphera_sampling_gap_meters",
        "Largest gap.",
        sampling.gap_max_mm.map(|mm| mm / 1e3),
    );
    let noise_m = sampling.noise_sigma_nm.map(|nm| nm / 1e9);
    out.known("asphera_noise_meters", "Standard deviation of the heights.", noise_m);
}

fn form(out: &mut Exposition, snapshot: &Snapshot) {
    let of = snapshot.form.as_ref();
    let meters = |nm: f64| nm / 1e9;
    let deviation = of.map(|form| &form.deviation);
    let known = deviation.and_then(|found| found.uncertainty.as_ref());
    let [pv, rms] =
        [deviation.map(|found| meters(found.pv_nm)), deviation.map(|found| meters(found.rms_nm))];
    out.known("asphera_form_pv_meters", "PV of the deviation.", pv);
    out.known("asphera_form_rms_meters", "RMS of the deviation.", rms);
    let help = "Standard uncertainty of PV (k = 1).";
    out.known("asphera_form_pv_uncertainty_meters", help, known.map(|of| meters(of.u_pv_nm)));
    let help = "Standard uncertainty of RMS (k = 1).";
    out.known("asphera_form_rms_uncertainty_meters", help, known.map(|of| meters(of.u_rms_nm)));
    let provisional = of.map(|form| f64::from(u8::from(form.provisional)));
    out.known("asphera_form_provisional", "1 for running figures, 0 for final ones.", provisional);
}

/// A check keeps the unit of its limit, which the label names.
fn verdict(out: &mut Exposition, verdict: &Verdict) {
    let statuses = [
        ("pass", Status::Pass),
        ("fail", Status::Fail),
        ("undecided", Status::Undecided),
        ("none", Status::None),
    ];
    out.family("asphera_verdict", Kind::Gauge, "1 for the verdict, else 0.");
    for (name, status) in statuses {
        out.flag(&[("status", name)], verdict.status == status);
    }
    let values = |out: &mut Exposition, name, help, value: fn(&asphera_report::Check) -> f64| {
        out.family(name, Kind::Gauge, help);
        for check in &verdict.checks {
            let labels = [("limit", check.figure.name.as_str()), ("unit", &check.figure.unit)];
            out.sample(&labels, value(check));
        }
    };
    values(out, "asphera_check_value", "Value held against a limit.", |check| check.value);
    values(out, "asphera_check_limit", "Largest value allowed.", |check| check.limit);
    let help = "1 where a limit holds, else 0.";
    values(out, "asphera_check_ok", help, |check| f64::from(u8::from(check.ok)));
}

/// A count of a link.
type Count = fn(&LinkState) -> u64;

fn links(out: &mut Exposition, links: &[LinkState]) {
    let help = "1 for a link on which valid frames arrive, else 0.";
    out.family("asphera_link_up", Kind::Gauge, help);
    for link in links {
        let labels = [("link", link.name.as_str()), ("kind", &link.kind)];
        out.flag(&labels, link.state == Connection::Connected);
    }
    let counters: [(&str, &str, Count); 5] = [
        ("asphera_link_readings_total", "Readings.", |link| link.readings),
        ("asphera_link_received_bytes_total", "Bytes received.", |link| link.received_bytes),
        ("asphera_link_errors_total", "Faults, discarded bytes, flagged readings.", |link| {
            link.errors
        }),
        ("asphera_link_lost_total", "Readings lost, as count gaps tell.", |link| link.lost),
        ("asphera_link_reconnects_total", "Times opened again after a loss.", |link| {
            link.reconnects
        }),
    ];
    for (name, help, count) in counters {
        out.family(name, Kind::Counter, help);
        for link in links {
            out.sample(&[("link", &link.name)], count(link) as f64);
        }
    }
    out.family("asphera_link_reading_age_seconds", Kind::Gauge, "Time since the last reading.");
    for link in links {
        if let Some(age_s) = link.age_s {
            out.sample(&[("link", &link.name)], age_s);
        }
    }
}

#[cfg(test)]
mod tests;
