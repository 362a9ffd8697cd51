//! The figures of a volume in words.

use std::fmt::Write as _;

use super::figures::{MeshFigures, VolumeReport};
use super::measures::{AreaMeasure, VolumeMeasure};
use super::nominal::NominalFigures;
use crate::cli::summary::short;

/// Lines for a terminal.
pub(super) fn of(report: &VolumeReport) -> String {
    let mut text = String::new();
    let [nx, ny, nz] = report.volume.size;
    let [hx, hy, hz] = report.volume.spacing_mm.map(short);
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<10} {value}");
    };
    line("volume", format!("{nx} × {ny} × {nz} samples, spacing {hx} × {hy} × {hz} mm"));
    line(
        "threshold",
        format!(
            "{} ({}): {} samples of material",
            report.volume.threshold, report.volume.threshold_source, report.volume.foreground
        ),
    );
    line("grid", format!("{}: {}", report.grid.verdict.to_uppercase(), report.grid.why));
    if let (Some(needed), Some(margin)) = (report.grid.needed_spacing_mm, report.grid.margin) {
        line("", format!("needed spacing below {} mm, margin {margin:.2}", short(needed)));
    }
    if let Some(mesh) = report.grid.mesh.as_ref().filter(|mesh| mesh.proved_mm.is_some()) {
        line("", mesh.why.clone());
    }
    for (name, value) in report.grid.nominal.iter().flat_map(of_nominal) {
        line(name, value);
    }
    if let Some(form) = &report.form {
        let deviation = &form.deviation;
        let value = format!("PV {} nm, RMS {} nm", short(deviation.pv_nm), short(deviation.rms_nm));
        line("form", value);
    }
    let topology = &report.topology;
    line(
        "topology",
        format!(
            "components {}, tunnels {}, cavities {}; Euler number {} (6), {} (26)",
            topology.components,
            topology.tunnels,
            topology.cavities,
            topology.euler_6,
            topology.euler_26
        ),
    );
    if let Some(counts) = &topology.with_missing {
        let value = format!(
            "with missing samples as material: components {}, tunnels {}, cavities {}",
            counts.components, counts.tunnels, counts.cavities
        );
        line("", value);
    }
    let measures = &report.measures;
    for (name, value) in
        of_volume(&measures.volume_mm3).into_iter().chain(of_area(&measures.area_mm2))
    {
        line(name, value);
    }
    line("mesh", of_mesh(&report.mesh));
    for reason in &report.reasons {
        line("note", reason.clone());
    }
    text
}

/// Lines for the volume.
fn of_volume(measure: &VolumeMeasure) -> Vec<(&'static str, String)> {
    let mut value = match measure.with_missing {
        Some(most) => format!(
            "{} to {} mm³, with missing samples as background and as material",
            short(measure.value),
            short(most)
        ),
        None => format!("{} mm³", short(measure.value)),
    };
    if let Some(u) = measure.u {
        let _ = write!(value, ", u {} mm³ from the place of the grid", short(u));
    }
    value.push_str(&certainly(measure.low, measure.high));
    let mut lines = vec![("V", value)];
    if let Some([low, high]) = measure.at_threshold_moved {
        let [low, high] = [low, high].map(short);
        let value =
            format!("{low} and {high} mm³ at the threshold − 1 % and + 1 % of the contrast");
        lines.push(("", value));
    }
    lines
}

/// The mesh, and whether it is closed.
fn of_mesh(mesh: &MeshFigures) -> String {
    let kind = match (mesh.closed, mesh.borders) {
        (true, _) => ", closed".to_owned(),
        (false, borders) => format!(", OPEN with {borders} borders, {} sides", mesh.border_sides),
    };
    format!(
        "{}: {} vertices, {} triangles, Euler number {}{kind}{}",
        mesh.method,
        mesh.vertices,
        mesh.triangles,
        mesh.euler,
        if mesh.oriented { " and oriented" } else { ", NOT oriented" }
    )
}

/// Lines for the area.
fn of_area(area: &AreaMeasure) -> Vec<(&'static str, String)> {
    let mut value = format!("{} mm²", short(area.value));
    if let Some(u) = area.u {
        let _ = write!(value, ", u {} mm²", short(u));
    }
    let _ = write!(value, " by the {}", area.estimator);
    if area.has_edges == Some(true) {
        value.push_str(", edges or fine detail found");
    }
    value.push_str(&certainly(area.low, area.high));
    let mut lines = vec![("A", value)];
    if let Some([low, high]) = area.at_threshold_moved {
        let [low, high] = [low, high].map(short);
        lines.push((
            "",
            format!("{low} and {high} mm² at the threshold − 1 % and + 1 % of the contrast"),
        ));
    }
    lines
}

/// Bounds that hold for certain, where both are known.
fn certainly(low: Option<f64>, high: Option<f64>) -> String {
    match (low, high) {
        (Some(low), Some(high)) => format!("; certainly {} to {}", short(low), short(high)),
        _ => String::new(),
    }
}

/// Lines for what a nominal asks of the grid.
fn of_nominal(nominal: &NominalFigures) -> Vec<(&'static str, String)> {
    let mut lines =
        vec![("nominal", format!("{}: {}", nominal.verdict.to_uppercase(), nominal.why))];
    if let (Some(reach), Some(needed), Some(margin)) =
        (nominal.reach_mm, nominal.needed_spacing_mm, nominal.margin)
    {
        let [reach, needed] = [reach, needed].map(short);
        let line = format!(
            "r {reach} mm by its reach, needed spacing below {needed} mm, margin {margin:.2}; of its face alone"
        );
        lines.push(("", line));
    }
    lines
}
