//! The contour of a session: what a station's configuration asks for, from the points to the verdict.

use std::f64::consts::SQRT_2;

use asphera_contour::features::noise_range;
use asphera_contour::{PlaceMm, Samples};
use asphera_geometry::PointMm;
use asphera_measure::{Finding, Guard, Measurement, hold_whole, undecide};
use asphera_report::contour::{
    CONTOUR_FORMAT, CircleFigures, ContourReport, DeviationFigures, InputFigures,
};
use asphera_report::{FigureName, Status, Verdict};

use super::{ContourSettings, Slab};

/// Contour that a station forms of the points of every session.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourPlan {
    /// How it is found and what is measured of it.
    pub settings: ContourSettings,
    /// The points that count; `None` for all, by their x and y.
    pub slab: Option<Slab>,
    /// Limits that the verdict holds.
    pub limits: ContourLimits,
}

/// Limits of a contour; `None` for no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContourLimits {
    /// Largest amount of a deviation from the nominal outline, mm.
    pub deviation_mm: Option<f64>,
    /// Largest roundness deviation about the least-squares circle, mm.
    pub roundness_mm: Option<f64>,
    /// The guard band by which they must hold or be broken; `None` for none.
    pub guard: Option<Guard>,
}

impl ContourPlan {
    /// The place of a point that may be used, in the plane of the contour; `None` where it lies outside the slab.
    pub(crate) fn place(&self, point: PointMm) -> Option<PlaceMm> {
        let Some(slab) = &self.slab else { return Some([point[0], point[1]]) };
        let (place, off_mm) = slab.lay(point);
        (off_mm <= slab.within_mm).then_some(place)
    }

    /// Whether its places are x and y of the measured frame.
    pub(crate) fn is_in_xy(&self) -> bool {
        let lies =
            |point: PointMm| self.slab.is_none_or(|it| it.lay(point).0 == [point[0], point[1]]);
        lies([1.0, 0.0, 0.0]) && lies([0.0, 1.0, 0.0])
    }

    /// The contour of places. Where there is none, `unknown` says why.
    pub(crate) fn contour(&self, places: &[PlaceMm]) -> ContourReport {
        match self.settings.contour(places, &mut |_| {}) {
            Ok(contour) => contour.abridged(),
            Err(error) => self.unknown(places, &error.to_string()),
        }
    }

    /// The report that there is no contour.
    pub(crate) fn unknown(&self, places: &[PlaceMm], why: &str) -> ContourReport {
        let method = self.settings.method;
        ContourReport {
            format: CONTOUR_FORMAT.to_owned(),
            input: InputFigures {
                points: places.len(),
                distinct: Samples::new(places).map_or(0, |samples| samples.len()),
                ..InputFigures::default()
            },
            method: method.name().to_owned(),
            guarantee: method.guarantee().to_owned(),
            unknown: vec![format!("contour: {why}")],
            ..ContourReport::default()
        }
    }

    /// Puts a contour into a measurement, and holds it against the limits. To be done before the session is concluded, which
    /// may take a pass back.
    pub(crate) fn conclude(&self, contour: ContourReport, measurement: &mut Measurement) {
        let report = &mut measurement.report;
        self.limits.judge(&contour, &mut report.verdict);
        report.contour = Some(contour);
    }
}

impl ContourLimits {
    /// Adds checks to a verdict. A broken limit fails; a figure that is not known takes a pass back.
    fn judge(&self, contour: &ContourReport, verdict: &mut Verdict) {
        let is_closed = matches!(&contour.chains[..], [chain] if chain.closed);
        let circle = contour.circle.as_ref().filter(|_| is_closed);
        let is_guarded = self.guard.is_some();
        let deviation = contour.deviation.as_ref().map(|it| amount(it, is_guarded));
        let figures = [
            ("deviation", "deviation", self.deviation_mm, deviation),
            ("roundness", "RONt", self.roundness_mm, circle.map(|it| roundness(it, is_guarded))),
        ];
        for (id, symbol, limit_mm, found) in figures {
            let Some(limit_mm) = limit_mm else { continue };
            let Some(finding) = found else {
                let why = contour.unknown.first().filter(|why| why.starts_with("contour: "));
                let why = why.map_or("it is no single closed curve near a circle", String::as_str);
                if verdict.status == Status::None {
                    verdict.status = Status::Undecided;
                }
                undecide(verdict, format!("the {id} of the contour is not known: {why}"));
                continue;
            };
            if verdict.status == Status::None {
                verdict.status = Status::Pass;
            }
            let figure = name(id, symbol);
            hold_whole(verdict, self.guard, figure, limit_mm, finding, "noise of the points");
        }
    }
}

/// The largest amount of a deviation, with u of the point that has it. A guard band also needs what noise alone gives the largest of so
/// many points: half the range of twice as many random numbers.
fn amount(deviation: &DeviationFigures, is_guarded: bool) -> Finding {
    let value = deviation.largest_mm.max(-deviation.least_mm);
    let noise_mm = deviation.u_mm.filter(|_| is_guarded).unwrap_or(0.0);
    let bias = 0.5 * noise_mm * noise_range(2 * deviation.points, 0.5);
    Finding { u: deviation.u_mm, bias, ..Finding::of_value(value) }
}

/// The roundness deviation, with a u that bounds what noise may have added. A guard band needs that apart, and u of the two points that the
/// roundness lies between.
fn roundness(circle: &CircleFigures, is_guarded: bool) -> Finding {
    let noise_mm = circle.noise_sigma_mm;
    let (u, bias) = match is_guarded {
        true => (SQRT_2 * noise_mm, noise_mm * noise_range(circle.points, 0.5)),
        false => (circle.u_roundness_mm, 0.0),
    };
    Finding { u: Some(u), bias, ..Finding::of_value(circle.roundness_mm) }
}

fn name(id: &str, symbol: &str) -> FigureName {
    FigureName {
        name: format!("contour_{id}_mm"),
        id: format!("contour_{id}"),
        symbol: symbol.to_owned(),
        unit: "mm".to_owned(),
        scope: Some("of the contour".to_owned()),
    }
}

#[cfg(test)]
mod tests;
