//! The reduction of points that are meshed in space.

use std::fmt;

use asphera_measure::{Part, ReducedInSpace, ReductionLimits, ReductionState, reduce_in_space};
use asphera_surface::reduce::spread;
use serde::Serialize;

use super::figures::{Spacings, write_points};
use super::limits::Limits;
use super::noise::NoiseWanted;
use super::{KeepWanted, ReduceArgs};
use crate::cli::columns::{self, Style};
use crate::cli::exit::Exit;
use crate::cli::output::{Failure, print, print_json};
use crate::cli::progress::Progress;
use crate::cli::source::Source;
use crate::cli::usage::misused;

/// Version of the layout.
const FORMAT: &str = "asphera.reduction-in-space/1";

/// All that happened.
#[derive(Serialize)]
struct Figures {
    format: &'static str,
    /// The file that was read.
    source: String,
    /// Losses of a session that was read, and of its recording.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    losses: Vec<String>,
    input: Input,
    epsilon: Option<f64>,
    rho: Option<f64>,
    lfs: Lfs,
    /// Standard deviation along the normal; absent where it is not known and not needed.
    noise_nm: Option<f64>,
    kept: u64,
    dropped: u64,
    /// Facets of the points themselves that are wider than the limit: all their points are kept.
    sparse: Sparse,
    /// The share of the limit that keeps limit and topology.
    share_of_limit: f64,
    /// The largest distance from a point of the surface to the nearest kept one.
    away_max_mm: f64,
    /// From each kept point to its nearest; absent with one point.
    spacing: Option<Spacings>,
    before: Condition,
    after: Condition,
    /// The file that was written.
    output: String,
}

#[derive(Serialize)]
struct Input {
    points: u64,
    /// Points of the surface.
    vertices: u64,
    missing: u64,
    duplicates: u64,
    /// Points that no facet uses.
    left_out: u64,
    not_meshable: u64,
}

#[derive(Serialize)]
struct Lfs {
    source: &'static str,
    /// Absent of a plane, as it is infinite.
    min_mm: Option<f64>,
    max_mm: Option<f64>,
}

#[derive(Serialize)]
struct Sparse {
    facets: u64,
    area_mm2: f64,
    /// Where the widest is; absent without one.
    widest_at_mm: Option<[f64; 3]>,
}

/// A mesh beside the limits.
#[derive(Serialize)]
struct Condition {
    facets: u64,
    area_mm2: f64,
    components: u64,
    genus: Option<i64>,
    border_loops: u64,
    flaws: u64,
    gap_max_mm: f64,
    epsilon_max: f64,
    rho_max: f64,
}

/// Reduces the points of a source, writes those that are kept, and tells of it.
pub(super) fn run(
    args: &ReduceArgs,
    source: &Source,
    part: Option<&Part>,
    limits: &Limits,
    progress: Progress,
) -> Result<Exit, Failure> {
    refuse_options(args)?;
    let name = args.source.display().to_string();
    let style = Style::of(&args.out)?;
    let points_mm: Vec<_> = source.points().collect();
    let sigma_mm = match args.noise {
        NoiseWanted::Auto => None,
        NoiseWanted::SigmaNm(sigma_nm) => Some(1e-6 * sigma_nm),
    };
    let wanted = ReductionLimits { epsilon: limits.epsilon, rho: limits.rho };
    progress.stage("meshing, choosing points and checking the result");
    let designed = part.filter(|part| part.reference.is_none());
    let found = reduce_in_space(&points_mm, designed, wanted, sigma_mm)
        .map_err(|why| format!("{name}: {why}"))?;
    let figures = Figures::of(args, source, points_mm.len(), &found);
    progress.stage("writing");
    columns::whole(&args.out, |writer| {
        columns::head(writer, style, &figures.remarks(), &["x[mm]", "y[mm]", "z[mm]"])?;
        found.retained_mm.iter().try_for_each(|point| columns::row(writer, style, point))
    })?;
    drop(progress);
    if args.json {
        print_json(&figures)?;
    } else {
        print(&figures.to_string());
    }
    Ok(Exit::Done)
}

/// Fails where an option asks for what is worked out in the plane alone.
fn refuse_options(args: &ReduceArgs) -> Result<(), Failure> {
    let asked = [
        (args.average, "--average"),
        (args.tilt.is_some(), "--tilt"),
        (args.keep != KeepWanted::Fewest, "--keep"),
    ];
    match asked.iter().find(|(is_asked, _)| *is_asked) {
        Some((_, option)) => Err(misused(format!(
            "{}: points that are meshed in space are reduced by --epsilon and --rho alone, found {option}: leave it out",
            args.source.display()
        ))),
        None => Ok(()),
    }
}

impl Figures {
    fn of(args: &ReduceArgs, source: &Source, points: usize, found: &ReducedInSpace) -> Figures {
        let finite = |mm: f64| Some(mm).filter(|mm| mm.is_finite());
        let kept = found.retained_mm.len() as u64;
        Figures {
            format: FORMAT,
            source: args.source.display().to_string(),
            losses: source.losses(),
            input: Input {
                points: points as u64,
                vertices: found.vertices,
                missing: source.missing() as u64,
                duplicates: found.duplicates,
                left_out: found.left_out,
                not_meshable: found.rejected,
            },
            epsilon: args.epsilon,
            rho: args.rho,
            lfs: Lfs {
                source: found.lfs_source,
                min_mm: finite(found.lfs_mm[0]),
                max_mm: finite(found.lfs_mm[1]),
            },
            noise_nm: found.sigma_mm.map(|mm| 1e6 * mm),
            kept,
            dropped: points as u64 - kept,
            sparse: Sparse {
                facets: found.sparse.facets,
                area_mm2: found.sparse.area_mm2,
                widest_at_mm: found.sparse.widest_at_mm,
            },
            share_of_limit: found.share,
            away_max_mm: found.away_max_mm,
            spacing: spread(&found.retained_mm).map(Spacings::from),
            before: Condition::of(&found.before),
            after: Condition::of(&found.after),
            output: args.out.display().to_string(),
        }
    }

    /// What a reader of the written file must know, a line each.
    fn remarks(&self) -> Vec<String> {
        let epsilon =
            self.epsilon.map(|share| format!("epsilon {share} of the local feature size"));
        let rho = self.rho.map(|share| format!("rho {share} of the reach"));
        let limits: Vec<String> = epsilon.into_iter().chain(rho).collect();
        let mut remarks = vec![
            format!("reduced from {} by asphera {}", self.source, env!("CARGO_PKG_VERSION")),
            format!("{} of {} points kept, meshed in space", self.kept, self.input.points),
            format!("{} ({})", limits.join(", "), self.lfs.source),
        ];
        remarks.extend(self.losses.iter().map(|loss| format!("source: {loss}")));
        if self.sparse.facets > 0 {
            let area_mm2 = self.sparse.area_mm2;
            remarks.push(format!("{area_mm2} mm2 were measured too coarsely for that"));
        }
        remarks.push("each point as it was measured".to_owned());
        remarks
    }
}

impl Condition {
    fn of(state: &ReductionState) -> Condition {
        let ReductionState { facets, area_mm2, components, genus, border_loops, flaws, .. } =
            *state;
        let ReductionState { gap_max_mm, epsilon_max, rho_max, .. } = *state;
        Condition {
            facets,
            area_mm2,
            components,
            genus,
            border_loops,
            flaws,
            gap_max_mm,
            epsilon_max,
            rho_max,
        }
    }
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let input = &self.input;
        let left_out = [
            (input.missing, "places without a height"),
            (input.duplicates, "duplicates"),
            (input.left_out, "in no facet, left out"),
            (input.not_meshable, "not finite or out of range, left out"),
        ];
        write_points(f, [self.kept, input.points], &self.losses, left_out)?;
        if let Some(noise_nm) = self.noise_nm {
            writeln!(f, "noise      {noise_nm:.2} nm")?;
        }
        let source = self.lfs.source;
        match self.lfs.min_mm.zip(self.lfs.max_mm) {
            Some((min_mm, max_mm)) => {
                writeln!(f, "lfs        {min_mm:.4} to {max_mm:.4} mm ({source})")?;
            }
            None => writeln!(f, "lfs        unlimited where nothing bends ({source})")?,
        }
        if let Some(Spacings { min_mm, median_mm, max_mm }) = &self.spacing {
            writeln!(f, "spacing    {median_mm:.5} mm, from {min_mm:.5} to {max_mm:.5} mm")?;
        }
        for (name, condition) in [("before", &self.before), ("after", &self.after)] {
            write!(f, "{name:<10} {condition}")?;
            if self.rho.is_some() {
                write!(f, ", largest ρ {:.5}", condition.rho_max)?;
            }
            writeln!(f)?;
        }
        if self.share_of_limit < 1.0 {
            let percent = 100.0 * self.share_of_limit;
            writeln!(
                f,
                "           chosen at {percent:.0} % of the limit, which limit and topology need"
            )?;
        }
        if let Some([x, y, z]) = self.sparse.widest_at_mm {
            let Sparse { facets, area_mm2, .. } = self.sparse;
            writeln!(
                f,
                "           {facets} facets of the points themselves are wider than the limit, {area_mm2:.4} mm², the worst about ({x:.4}, {y:.4}, {z:.4}) mm: their points are all kept"
            )?;
        }
        writeln!(f, "written    {}", self.output)
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} facets, {:.4} mm², components {}",
            self.facets, self.area_mm2, self.components
        )?;
        if let Some(genus) = self.genus {
            write!(f, ", genus {genus}")?;
        }
        write!(f, ", borders {}, largest ε {:.5}", self.border_loops, self.epsilon_max)
    }
}
