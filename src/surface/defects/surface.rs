//! One look at a surface: a reference, without bodies that would bend it, and what stands off.

use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::bodies::Body;
use super::cells::{self, Cells};
use super::detect::{self, Detection};
use super::ground::Ground;
use super::measure::{Field, Zone};
use super::placed::{Looked, Placed};
use super::reference::{self, Reference};
use super::residuals::Residuals;
use super::rim_zones::RimZones;
use super::steps::Step;
use super::tail::Tail;
use super::{
    Defect, DefectSettings, Defects, DefectsUnknown, OWN_LEAST, OWN_SPACINGS, Samples, WINDOW,
    areas_mm2, by_significance, of_step, used, zones,
};

/// Samples, and what is known of them before anything is fitted.
pub(super) struct Surface<'a> {
    samples: &'a Samples<'a>,
    settings: &'a DefectSettings,
    ground: Option<&'a Ground>,
    /// Projected area of each vertex.
    areas_mm2: Vec<f64>,
    used: Vec<bool>,
    spacing_mm: f64,
    largest_mm: f64,
    pub(super) window_mm: f64,
}

impl<'a> Surface<'a> {
    pub(super) fn new(
        samples: &'a Samples<'a>,
        settings: &'a DefectSettings,
        ground: Option<&'a Ground>,
    ) -> Result<Surface<'a>, DefectsUnknown> {
        let areas_mm2 = areas_mm2(samples)?;
        let used = used(samples, &areas_mm2);
        let (mut area_mm2, mut count) = (0.0, 0_u64);
        for (area, _) in areas_mm2.iter().zip(&used).filter(|&(_, &used)| used) {
            area_mm2 += area;
            count += 1;
        }
        if count == 0 {
            return Err(DefectsUnknown::NoArea);
        }
        let spacing_mm = (area_mm2 / count as f64).sqrt();
        let largest_mm =
            settings.largest_mm.unwrap_or(DefectSettings::LARGEST_SPACINGS * spacing_mm);
        let window_mm = WINDOW * largest_mm;
        let surface = Surface {
            samples,
            settings,
            ground,
            areas_mm2,
            used,
            spacing_mm,
            largest_mm,
            window_mm,
        };
        Ok(surface)
    }

    pub(super) fn cells(&self, samples: &Samples<'_>) -> Result<Cells, DefectsUnknown> {
        Cells::new(samples, &self.used, reference::side_mm(self.window_mm, self.spacing_mm))
    }

    /// The defects against a reference that is fitted without some bodies.
    pub(super) fn defects(&self, bodies: &[Body]) -> Result<Defects, DefectsUnknown> {
        let Surface { samples, settings, ground, spacing_mm, largest_mm, .. } = *self;
        let lowered = Lowered::new(samples, bodies);
        let without = &lowered.samples(samples);
        let cells = self.cells(without)?;
        let looked =
            Looked { samples: without, cells: &cells, largest_mm, spacing_mm, settings, ground };
        let Placed { steps, reference, missed_mm, mut residuals, tail } = looked.place()?;
        for (vertex, residual_mm) in residuals.normal_mm.iter_mut().enumerate() {
            let cell = residuals.cell[vertex];
            if cell != cells::NONE && !bodies.is_empty() {
                let [x, y, _] = samples.points[vertex];
                let height_mm: f64 = bodies.iter().map(|body| body.height_mm([x, y])).sum();
                *residual_mm += height_mm / reference.secants[cell as usize];
            }
        }
        let against = Against { cells, steps, reference, missed_mm, residuals, tail };
        let mut found = self.against(&against);
        for defect in &mut found.defects {
            let [x, y, _] = defect.centre_mm;
            for body in bodies.iter().filter(|body| body.holds([x, y])) {
                let u_mm = &mut defect.height_uncertainty_mm;
                *u_mm = u_mm.hypot(body.uncertainty_mm);
            }
        }
        Ok(found)
    }

    /// The defects against a reference.
    fn against(&self, against: &Against) -> Defects {
        let Surface { samples, settings, ground, spacing_mm, .. } = *self;
        let Against { cells, steps, reference, residuals, tail, .. } = against;
        let Residuals { normal_mm, cell, sigma_mm, cell_mm } = residuals;
        let values: Vec<f64> =
            normal_mm.iter().enumerate().map(|(at, mm)| mm / against.noise_mm(at)).collect();
        let rim_zones = RimZones::new(samples.points, samples.adjacency, &self.used, spacing_mm);
        let Detection { mut found, threshold, scales } = detect::detect(
            samples.adjacency,
            (&values, &against.shared()),
            (&rim_zones, *tail, ground.map_or([1.0; detect::SCALES], |ground| ground.colour)),
            settings.false_expected,
        );
        // Which side the samples nearest to a step lie on is not known: those are its own.
        found.retain(|found| {
            !steps.iter().any(|step| {
                found.vertices.iter().all(|&vertex| {
                    let [x, y, _] = samples.points[vertex as usize];
                    step.line.away_mm([x, y]).abs() <= OWN_SPACINGS * spacing_mm
                })
            })
        });
        // Beside an edge means over rings may stand off by what lies about the vertices, while these themselves do not.
        found.retain(|found| found.significance >= OWN_LEAST);
        found.sort_by(|p, q| q.significance.total_cmp(&p.significance));
        let field_at = |zone: &Zone<'_>| Field {
            samples: *samples,
            residuals_mm: normal_mm,
            areas_mm2: &self.areas_mm2,
            sigma_mm: against.noise_mm(zone.found.vertices[0] as usize) * scales[0],
            spacing_mm,
            threshold,
        };
        let zones = zones(samples, &found, cell, reference, cell_mm);
        let mut defects: Vec<Defect> =
            zones.par_iter().map(|zone| field_at(zone).measure(zone)).collect();
        defects.extend(steps.iter().map(|step| of_step(samples, &self.used, step)));
        defects.sort_by(by_significance);
        let unreferenced =
            cells.all().iter().filter(|&&vertex| !normal_mm[vertex as usize].is_finite());
        let unreferenced = unreferenced.count() as u64;
        Defects {
            defects,
            sigma_mm: sigma_mm * scales[0],
            threshold,
            largest_mm: self.largest_mm,
            window_mm: self.window_mm,
            spacing_mm,
            unreferenced,
            residuals_mm: residuals.normal_mm.clone(),
        }
    }
}

/// What defects stand off.
struct Against {
    cells: Cells,
    steps: Vec<Step>,
    reference: Reference,
    /// By cell what the reference misses of the form.
    missed_mm: Vec<f64>,
    residuals: Residuals,
    tail: Tail,
}

impl Against {
    /// Noise about a vertex.
    fn noise_mm(&self, vertex: usize) -> f64 {
        match self.residuals.cell[vertex] {
            cells::NONE => self.residuals.sigma_mm,
            cell => self.residuals.cell_mm[cell as usize],
        }
    }

    /// By vertex the variance of the reference over that of the noise.
    fn shared(&self) -> Vec<f64> {
        let of = |&cell: &u32| match cell {
            cells::NONE => 0.0,
            cell => {
                let cell = cell as usize;
                let missed = self.missed_mm[cell] / self.residuals.cell_mm[cell];
                self.reference.uncertainties[cell].powi(2) + missed * missed
            }
        };
        self.residuals.cell.iter().map(of).collect()
    }
}

/// Heights without some bodies; nothing where there are none.
struct Lowered {
    points: Vec<PointMm>,
    deviations_mm: Vec<f64>,
}

impl Lowered {
    fn new(samples: &Samples<'_>, bodies: &[Body]) -> Lowered {
        let mut lowered = Lowered { points: Vec::new(), deviations_mm: Vec::new() };
        if bodies.is_empty() {
            return lowered;
        }
        let height_mm =
            |[x, y, _]: PointMm| -> f64 { bodies.iter().map(|body| body.height_mm([x, y])).sum() };
        match samples.deviations_mm {
            Some(deviations_mm) => {
                let pairs = deviations_mm.iter().zip(samples.points);
                lowered.deviations_mm = pairs.map(|(mm, &point)| mm - height_mm(point)).collect();
            }
            None => {
                let points = samples.points.iter();
                lowered.points = points.map(|&of| [of[0], of[1], of[2] - height_mm(of)]).collect();
            }
        }
        lowered
    }

    fn samples<'a>(&'a self, samples: &Samples<'a>) -> Samples<'a> {
        let points = if self.points.is_empty() { samples.points } else { &self.points };
        let lowered = Some(&self.deviations_mm[..]).filter(|mm| !mm.is_empty());
        Samples { points, deviations_mm: lowered.or(samples.deviations_mm), ..*samples }
    }
}
