//! The figures of a plan: as JSON, and in words.

use std::fmt;

use asphera_plan::Schedule;
use serde::Serialize;

use super::machine::AxisFigures;
use super::{PlanArgs, shown};

/// The figures of a plan.
#[derive(Serialize)]
pub(super) struct Figures {
    format: &'static str,
    source: String,
    /// `raster`, `spiral`, `rings`, `meridians`, or `next`: places to measure next.
    path: String,
    /// Points of the plan.
    points: usize,
    /// Lines, turns and stops.
    pieces: usize,
    /// Distance of lines and points; absent of places to measure next.
    spacing_mm: Option<f64>,
    /// Distance of points along lines, where the trigger sets it.
    #[serde(skip_serializing_if = "Option::is_none")]
    trigger_mm: Option<f64>,
    /// Time of the whole path in s, and its parts.
    total_s: f64,
    scan_s: f64,
    move_s: f64,
    dwell_s: f64,
    /// Length of lines and turns, as much of it as is run at the scan speed, and the straight way between them.
    scan_mm: f64,
    full_speed_mm: f64,
    move_mm: f64,
    scan_speed_mm_s: f64,
    axes: Vec<AxisFigures>,
    #[serde(skip_serializing_if = "Option::is_none")]
    needed: Option<Needed>,
    #[serde(skip_serializing_if = "Option::is_none")]
    next: Option<Regions>,
    output: String,
}

/// A path that was laid.
pub(super) struct Gone {
    pub(super) path: String,
    pub(super) spacing_mm: Option<f64>,
    pub(super) pieces: usize,
}

/// The spacing that a design needs.
#[derive(Serialize)]
pub(super) struct Needed {
    pub(super) epsilon: f64,
    pub(super) spacing_mm: f64,
    pub(super) lfs_min_mm: f64,
    pub(super) slope_max: f64,
}

/// Places to measure next.
#[derive(Serialize)]
pub(super) struct Regions {
    pub(super) regions: usize,
    pub(super) left_out: usize,
    /// Absent where it is not known.
    pub(super) coverage: Option<f64>,
    /// Length of the path through the places as the sampling lists them, mm.
    pub(super) as_listed_mm: f64,
}

impl Figures {
    pub(super) fn new(args: &PlanArgs, gone: Gone, schedule: &Schedule) -> Figures {
        Figures {
            format: "asphera-plan-1",
            source: shown(&args.source),
            path: gone.path,
            points: schedule.points.len(),
            pieces: gone.pieces,
            spacing_mm: gone.spacing_mm,
            trigger_mm: gone.spacing_mm.and(args.trigger),
            total_s: schedule.total_s,
            scan_s: schedule.scan_s,
            move_s: schedule.move_s,
            dwell_s: schedule.dwell_s,
            scan_mm: schedule.scan_mm,
            full_speed_mm: schedule.full_speed_mm,
            move_mm: schedule.move_mm,
            scan_speed_mm_s: args.machine.scan_speed_mm_s(),
            axes: args.machine.figures(),
            needed: None,
            next: None,
            output: shown(&args.out),
        }
    }

    pub(super) fn with_needed(self, needed: Option<Needed>) -> Figures {
        Figures { needed, ..self }
    }

    pub(super) fn with_regions(self, regions: Regions) -> Figures {
        Figures { next: Some(regions), ..self }
    }
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Figures { path, points, .. } = self;
        match (self.spacing_mm, self.trigger_mm) {
            (Some(mm), Some(trigger_mm)) => writeln!(
                f,
                "plan       {path}, {points} points, lines {mm:.4} mm apart, a point every {trigger_mm} mm"
            ),
            (Some(mm), None) => writeln!(f, "plan       {path}, {points} points, {mm:.4} mm apart"),
            (None, _) => writeln!(f, "plan       {points} places to measure next"),
        }?;
        writeln!(
            f,
            "time       {:.1} s: {:.1} s on the path, {:.1} s between, {:.1} s at stops",
            self.total_s, self.scan_s, self.move_s, self.dwell_s
        )?;
        if self.scan_mm > 0.0 {
            let share = 100.0 * self.full_speed_mm / self.scan_mm;
            writeln!(
                f,
                "path       {:.1} mm, {share:.0} % of it at {} mm/s; {:.1} mm between",
                self.scan_mm, self.scan_speed_mm_s, self.move_mm
            )?;
        }
        if let Some(Needed { epsilon, spacing_mm, lfs_min_mm, slope_max }) = &self.needed {
            writeln!(
                f,
                "needed     {spacing_mm:.4} mm for ε {epsilon}: local feature size {lfs_min_mm:.3} mm, slope {slope_max:.3}"
            )?;
        }
        if let Some(Regions { regions, left_out, as_listed_mm, .. }) = &self.next {
            writeln!(
                f,
                "next       {regions} regions; {:.1} mm through the places, {as_listed_mm:.1} mm as they were listed",
                self.move_mm
            )?;
            if *left_out > 0 {
                writeln!(
                    f,
                    "           {left_out} regions left out, as their places would be too many"
                )?;
            }
        }
        for axis in &self.axes {
            writeln!(f, "axis       {}", axis.line())?;
        }
        writeln!(f, "written    {}", self.output)
    }
}
