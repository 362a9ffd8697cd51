//! The places to measure next of what was measured.

use asphera_measure::{Next, Wanted, sampling_of_points};
use asphera_report::Waypoints;

use super::PlanArgs;
use crate::cli::files::{measured, part};
use crate::cli::output::Failure;
use crate::cli::progress::Progress;
use crate::cli::source::Source;
use crate::cli::usage::misused;

/// Places to measure next.
pub(super) struct Missing {
    /// Places, measured frame, mm.
    pub(super) places_mm: Vec<[f64; 3]>,
    /// How many regions they lie in.
    pub(super) regions: usize,
    /// Regions without places: they would be too many.
    pub(super) left_out: usize,
    /// The coverage so far; `None`: unknown.
    pub(super) coverage: Option<f64>,
}

/// The places that lack points in what was measured, as `asphera sampling --waypoints` writes them.
pub(super) fn find(args: &PlanArgs, progress: &Progress) -> Result<Missing, Failure> {
    if args.source.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        return Err(misused(format!(
            "{}: expected what was measured, found a nominal by its name: --path raster, spiral, rings or meridians plans a path over it",
            args.source.display()
        )));
    }
    let given = args.nominal.as_deref().map(part).transpose()?;
    let source = Source::open(&args.source, &args.text, progress)?;
    source.say_reading();
    let along = source.along(args.along);
    let (waypoints, coverage, unknown) = match source.part(given) {
        Some(part) => {
            let measurement = measured(part, along, &source, progress)?;
            let sampling = measurement.report.sampling;
            (measurement.next.as_ref().map(Next::waypoints), sampling.coverage, sampling.unknown)
        }
        None => {
            progress.stage("meshing and assessing the sampling");
            let found = sampling_of_points(source.points(), along, Wanted::new(None, None, None));
            (found.waypoints, found.figures.coverage, found.figures.unknown)
        }
    };
    let name = args.source.display();
    let Some(waypoints) = waypoints else {
        let why = match unknown.is_empty() && !along.has_plane() {
            true => IN_SPACE.to_owned(),
            false => unknown.join("; "),
        };
        return Err(format!(
            "{name}: nothing is known of the sampling, so there is no plan: {why}"
        )
        .into());
    };
    let places_mm =
        places(&waypoints).ok_or_else(|| format!("{name}: a place to measure next is no place"))?;
    let Waypoints { regions, left_out, .. } = waypoints;
    Ok(Missing { places_mm, regions, left_out, coverage })
}

/// Why there is no path through places of a mesh in space.
const IN_SPACE: &str = "the points are meshed in space, and a path leads over a plane: give --along z, nx,ny,nz or fitted; `asphera \
     sampling` lists the places with the direction of the probe";

/// The places of waypoints, without their regions.
fn places(waypoints: &Waypoints) -> Option<Vec<[f64; 3]>> {
    let place = |line: &str| -> Option<[f64; 3]> {
        let mut numbers = line.split(',').skip(1).map(|number| number.parse::<f64>().ok());
        Some([numbers.next()??, numbers.next()??, numbers.next()??])
    };
    waypoints.csv.lines().skip(1).map(place).collect()
}
