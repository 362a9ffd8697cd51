//! `asphera sampling`: how densely points sample their surface, what to measure next, and what stands
//! off it.

use std::f64::consts::FRAC_1_SQRT_2;
use std::path::{Path, PathBuf};

use asphera_report::{ChapterId, FeatureFigures, Report, SamplingFigures, View, Waypoints};
use clap::Args;
use serde::Serialize;

use super::exit::Exit;
use super::files::{measured, part, refuse};
use super::output::{Failure, print, print_json};
use super::progress::Progress;
use super::source::{Source, source_help};
use super::summary::{brief, tables};
use super::text::TextArgs;
use super::threads::ThreadArgs;
use crate::whole_file::write_bytes;
use asphera_measure::Part;
use asphera_measure::{Along, Next, PointsSampling, Wanted, sampling_of_points};

#[derive(Args)]
pub(super) struct SamplingArgs {
    #[arg(help = source_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// The nominal: surface, aperture, limits. A session without it is held against its own. Of a file without it the
    /// local feature size follows from the points, and their outline stands for the aperture.
    #[arg(long, value_name = "FILE")]
    nominal: Option<PathBuf>,
    /// Largest distance from the surface to its nearest point, as a share of the local feature size; above 0,
    /// up to 1. Without E and R those of the nominal, or 0.05. Of several limits the tightest counts.
    #[arg(long, value_name = "E", value_parser = share, allow_negative_numbers = true)]
    epsilon: Option<f64>,
    /// The same as a share of the reach, the smallest local feature size of the whole surface; above 0, up to 1.
    #[arg(long, value_name = "R", value_parser = share, allow_negative_numbers = true)]
    rho: Option<f64>,
    /// Largest spacing of points in mm. Without it the nominal's limit of gaps, or four times the average
    /// distance of the points.
    #[arg(long, value_name = "MM", value_parser = length, allow_negative_numbers = true)]
    spacing: Option<f64>,
    /// Write the places to measure next into this file: region,x_mm,y_mm,z_mm.
    #[arg(long, value_name = "OUT.csv")]
    waypoints: Option<PathBuf>,
    /// Overwrite the file of places if it is there.
    #[arg(long)]
    force: bool,
    /// Along which direction the points are projected for their mesh: z, nx,ny,nz, or fitted, from the first
    /// 1000 of them. none: they are meshed in space. auto: along z, and in space where they fold.
    /// Without it that of the session, or z.
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    along: Option<Along>,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Print the figures as one JSON object on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
}

/// What is printed as JSON.
#[derive(Serialize)]
struct Told<'a> {
    #[serde(flatten)]
    sampling: &'a SamplingFigures,
    #[serde(flatten)]
    features: &'a FeatureFigures,
}

pub(super) fn run(args: &SamplingArgs) -> Result<Exit, Failure> {
    args.threads.limit_process()?;
    if let Some(out) = &args.waypoints {
        refuse(out, [&args.source].into_iter().chain(&args.nominal), args.force)?;
    }
    let given = args.nominal.as_deref().map(part).transpose()?;
    let name = args.source.display().to_string();
    let progress = Progress::start("sampling");
    let source = Source::open(&args.source, &args.text, &progress)?;
    source.say_reading();
    let along = source.along(args.along);
    let gap_mm = args.spacing.map(|spacing_mm| FRAC_1_SQRT_2 * spacing_mm);
    let PointsSampling { mut figures, features, waypoints } = match source.part(given) {
        Some(part) => {
            // A share on the command line replaces both of the nominal.
            let (epsilon_limit, rho_limit) = match (args.epsilon, args.rho) {
                (None, None) => (part.epsilon_limit, part.rho_limit),
                given => given,
            };
            let gap_limit_mm = gap_mm.or(part.gap_limit_mm);
            let part = Part { epsilon_limit, rho_limit, gap_limit_mm, ..part };
            let measurement = measured(part, along, &source, &progress)?;
            let next = measurement.next.as_ref().filter(|_| args.waypoints.is_some());
            let waypoints = next.map(Next::waypoints);
            let Report { sampling: figures, features, .. } = measurement.report;
            PointsSampling { figures, features, waypoints }
        }
        None => {
            let wanted = Wanted::new(args.epsilon, args.rho, gap_mm);
            progress.stage("meshing and assessing the sampling");
            sampling_of_points(source.points(), along, wanted)
        }
    };
    figures.unknown.extend(source.losses());
    drop(progress);
    if let Some(out) = &args.waypoints {
        write(out, waypoints.as_ref(), &name)?;
    }
    if args.json {
        print_json(&Told { sampling: &figures, features: &features })?;
    } else {
        let view = View::of_sampling(&figures, &features);
        let mut text = brief(&view);
        text.push_str(&tables(&view, ChapterId::Sampling));
        if let (Some(out), Some(found)) = (&args.waypoints, &waypoints) {
            let Waypoints { places, regions, left_out, .. } = found;
            text.push_str(&format!("waypoints  {places} in {regions} regions: {}", out.display()));
            if *left_out > 0 {
                text.push_str(&format!("; {left_out} regions left out, as they would be too many"));
            }
            text.push('\n');
        }
        print(&text);
    }
    Ok(if figures.coverage.is_some() { Exit::Done } else { Exit::Undecided })
}

fn write(out: &Path, waypoints: Option<&Waypoints>, name: &str) -> Result<(), Failure> {
    let Some(waypoints) = waypoints else {
        return Err(
            format!(
                "{name}: there are no waypoints, for nothing is known of the sampling, or the points were meshed in space; of these --json lists \
                 places with their approach under next"
            )
            .into()
        );
    };
    Ok(write_bytes(out, &waypoints.csv)?)
}

fn share(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(share) if share > 0.0 && share <= 1.0 => Ok(share),
        _ => Err(format!("expected a number above 0 and up to 1, found `{word}`")),
    }
}

fn length(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(mm) if (1e-6..=1e6).contains(&mm) => Ok(mm),
        _ => Err(format!("expected a length from 1e-6 to 1e6 in mm, found `{word}`")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_numbers_that_can_be() {
        assert_eq!(share("0.05"), Ok(0.05));
        assert_eq!(length("0.1"), Ok(0.1));
        for word in ["0", "-0.1", "NaN", "inf", "2", "", "few"] {
            assert!(share(word).is_err(), "{word}");
        }
        for word in ["0", "-1", "NaN", "inf", "1e9", ""] {
            assert!(length(word).is_err(), "{word}");
        }
    }
}
