//! What a reduction did, as JSON, as text, and as remarks in its file.

use std::fmt;

use asphera_mesh::Mesh;
use asphera_surface::reduce::{Averaged, Reduction, Split, Spread, Tally};
use serde::Serialize;

/// Version of the layout.
pub(super) const FORMAT: &str = "asphera.reduction/1";

/// All of it.
#[derive(Serialize)]
pub(super) struct Figures {
    pub(super) format: &'static str,
    /// The file that was read.
    pub(super) source: String,
    /// Losses of a session that was read, and of its recording.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) losses: Vec<String>,
    pub(super) input: Input,
    /// Largest share of the local feature size asked for.
    pub(super) epsilon: Option<f64>,
    /// Largest share of the reach asked for, `lfs.reach_mm`.
    pub(super) rho: Option<f64>,
    /// The largest tilt of a facet by noise.
    pub(super) tilt_limit_rad: f64,
    /// `fewest`, `truest` or `most`.
    pub(super) keep: String,
    pub(super) lfs: Lfs,
    pub(super) noise: Noise,
    pub(super) kept: u64,
    pub(super) dropped: u64,
    /// Of the kept, those taken back because a facet between the others was longer than ε allows.
    pub(super) mended: u64,
    pub(super) by: By,
    pub(super) sparse: Sparse,
    /// From each kept point to its nearest; absent with one point.
    pub(super) spacing: Option<Spacings>,
    /// How many kept points were averaged; absent where averaging was not asked for.
    pub(super) averaged: Option<u64>,
    /// Figures of the averages; absent with it.
    pub(super) averages: Option<Averages>,
    pub(super) before: Condition,
    pub(super) after: Condition,
    /// The file that was written.
    pub(super) output: String,
}

/// What was read.
#[derive(Serialize)]
pub(super) struct Input {
    pub(super) points: u64,
    /// Points of the mesh: those that may be kept.
    pub(super) vertices: u64,
    /// Places of the file without a height.
    pub(super) missing: u64,
    pub(super) duplicates: u64,
    /// Points in the place of another, at another height.
    pub(super) conflicts: u64,
    pub(super) not_meshable: u64,
}

/// Local feature size.
#[derive(Serialize)]
pub(super) struct Lfs {
    pub(super) source: &'static str,
    /// As used: where nothing bends, so large that the spacing is a fifth of the width. Absent where it is known
    /// nowhere.
    pub(super) range_mm: Option<Range>,
    /// The reach: the smallest of the whole surface, measured or not. Absent where it is not known.
    pub(super) reach_mm: Option<f64>,
    /// What larger ones count as, where one does: so points a fifth of the width apart still stay.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) limited_to_mm: Option<f64>,
}

impl Lfs {
    /// Range and reach as used: none is above `most_mm`.
    pub(super) fn new(
        source: &'static str,
        (range_mm, reach_mm): (Option<Range>, Option<f64>),
        most_mm: f64,
    ) -> Lfs {
        let is_limited = range_mm.is_some_and(|range| range.max_mm >= most_mm);
        Lfs { source, range_mm, reach_mm, limited_to_mm: is_limited.then_some(most_mm) }
    }
}

#[derive(Clone, Copy, Serialize)]
pub(super) struct Range {
    pub(super) min_mm: f64,
    pub(super) max_mm: f64,
}

#[derive(Serialize)]
pub(super) struct Noise {
    /// Standard deviation.
    pub(super) sigma_nm: f64,
    pub(super) source: &'static str,
    /// Standard uncertainty of that; this and what follows is absent where the noise was given.
    pub(super) uncertainty_nm: Option<f64>,
    /// How many residuals it comes from.
    pub(super) residuals: Option<u64>,
    /// Share of the samples looked at that stood off and were left out.
    pub(super) outlier_share: Option<f64>,
}

/// Points by what their spacing followed from.
#[derive(Serialize)]
pub(super) struct By {
    /// As asked for by `keep`, no wider than ε and no narrower than the noise allows: the target is reached.
    pub(super) epsilon: KeptDropped,
    /// From the noise, wider than ε allows.
    pub(super) noise: KeptDropped,
    /// Measured hardly densely enough for ε.
    pub(super) sparse: KeptDropped,
    /// Of unknown local feature size.
    pub(super) unknown: KeptDropped,
}

#[derive(Serialize)]
pub(super) struct KeptDropped {
    pub(super) kept: u64,
    pub(super) dropped: u64,
}

/// Triangles of the measured points that are too wide for ε.
#[derive(Serialize)]
pub(super) struct Sparse {
    pub(super) triangles: u64,
    pub(super) area_mm2: f64,
}

#[derive(Serialize)]
pub(super) struct Spacings {
    pub(super) min_mm: f64,
    pub(super) median_mm: f64,
    pub(super) max_mm: f64,
}

/// Heights that were averaged.
#[derive(Serialize)]
pub(super) struct Averages {
    /// `heights`, or `deviations` from the nominal.
    of: &'static str,
    /// Half of the heights have this standard uncertainty or less, the bias included.
    u_median_nm: f64,
    u_max_nm: f64,
    /// The largest bias that an uncertainty holds.
    bias_max_nm: f64,
}

/// A mesh beside both conditions.
#[derive(Serialize)]
pub(super) struct Condition {
    pub(super) triangles: u64,
    /// Projected.
    pub(super) area_mm2: f64,
    /// Share of the area in space whose facets noise tilts by more than the limit.
    pub(super) overdense_fraction: Option<f64>,
    /// Area in space of facets along the outline that it tilts so far because they are thin there.
    pub(super) outline_area_mm2: f64,
    /// Half of the area has facets that it tilts by this or less.
    pub(super) tilt_median_rad: Option<f64>,
    pub(super) epsilon_max: Option<f64>,
    pub(super) epsilon_p99: Option<f64>,
    pub(super) rho_max: Option<f64>,
    /// Projected area of triangles beyond ε or ρ.
    pub(super) over_epsilon_area_mm2: f64,
}

impl Input {
    /// The input of a mesh from a file with so many places without a height.
    pub(super) fn of(mesh: &Mesh, missing: usize) -> Input {
        let counts = mesh.counts();
        Input {
            points: counts.pushed,
            vertices: counts.vertices,
            missing: missing as u64,
            duplicates: counts.duplicates,
            conflicts: counts.conflicts,
            not_meshable: counts.rejected,
        }
    }
}

impl Sparse {
    pub(super) fn of(reduction: &Reduction) -> Sparse {
        Sparse { triangles: reduction.sparse_triangles, area_mm2: reduction.sparse_area_mm2 }
    }
}

impl Range {
    pub(super) fn of(sizes_mm: impl Iterator<Item = f64>) -> Option<Range> {
        sizes_mm.fold(None, |range: Option<Range>, mm| {
            let Range { min_mm, max_mm } = range.unwrap_or(Range { min_mm: mm, max_mm: mm });
            Some(Range { min_mm: min_mm.min(mm), max_mm: max_mm.max(mm) })
        })
    }
}

impl Averages {
    pub(super) fn of(averaged: &Averaged, with_nominal: bool) -> Averages {
        let mut u_nm: Vec<f64> = averaged.points.iter().map(|point| 1e6 * point.u_mm).collect();
        u_nm.sort_by(f64::total_cmp);
        let biases_nm = averaged.points.iter().map(|point| 1e6 * point.bias_mm);
        Averages {
            of: if with_nominal { "deviations" } else { "heights" },
            u_median_nm: u_nm.get(u_nm.len() / 2).copied().unwrap_or(0.0),
            u_max_nm: u_nm.last().copied().unwrap_or(0.0),
            bias_max_nm: biases_nm.fold(0.0, f64::max),
        }
    }
}

impl From<Tally> for By {
    fn from(tally: Tally) -> By {
        let of = |Split { retained, dropped }| KeptDropped { kept: retained, dropped };
        By {
            epsilon: of(tally.epsilon),
            noise: of(tally.noise),
            sparse: of(tally.sparse),
            unknown: of(tally.unknown),
        }
    }
}

impl From<Spread> for Spacings {
    fn from(Spread { min_mm, median_mm, max_mm }: Spread) -> Spacings {
        Spacings { min_mm, median_mm, max_mm }
    }
}

impl Figures {
    /// What a reader of the written file must know, a line each.
    pub(super) fn remarks(&self) -> Vec<String> {
        let mut remarks = vec![
            format!("reduced from {} by asphera {}", self.source, env!("CARGO_PKG_VERSION")),
            format!("{} of {} points kept", self.kept, self.input.points),
            format!("{} ({})", self.limits().join(", "), self.lfs.source),
            format!("noise {} nm ({})", self.noise.sigma_nm, self.noise.source),
            format!("tilt by noise up to {} rad, {} points", self.tilt_limit_rad, self.keep),
        ];
        remarks.extend(self.losses.iter().map(|loss| format!("source: {loss}")));
        let short_mm2 = self.after.over_epsilon_area_mm2;
        if short_mm2 > 0.0 {
            remarks.push(format!("{short_mm2} mm2 were measured too coarsely for that"));
        }
        remarks.push(match self.averaged {
            None => "each point as it was measured".to_owned(),
            Some(count) => format!("heights of {count} points averaged over those about them"),
        });
        remarks
    }
}

impl Figures {
    /// What was asked for, in words.
    fn limits(&self) -> Vec<String> {
        let epsilon =
            self.epsilon.map(|share| format!("epsilon {share} of the local feature size"));
        let rho = self.rho.map(|share| format!("rho {share} of the reach"));
        epsilon.into_iter().chain(rho).collect()
    }
}

/// Writes how many of the points were kept, what the source lost, and what was left out for which reason.
pub(super) fn write_points(
    f: &mut fmt::Formatter<'_>,
    [kept, points]: [u64; 2],
    losses: &[String],
    left_out: [(u64, &str); 4],
) -> fmt::Result {
    writeln!(f, "points     {kept} of {points} kept")?;
    losses.iter().try_for_each(|loss| writeln!(f, "           {loss}"))?;
    let mut some = left_out.into_iter().filter(|(count, _)| *count > 0);
    some.try_for_each(|(count, what)| writeln!(f, "           {count} {what}"))
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let input = &self.input;
        let left_out = [
            (input.missing, "places without a height"),
            (input.duplicates, "duplicates"),
            (input.conflicts, "in the place of another point at another height, left out"),
            (input.not_meshable, "not finite or out of range, left out"),
        ];
        write_points(f, [self.kept, input.points], &self.losses, left_out)?;
        let noise = &self.noise;
        write!(f, "noise      {:.2} nm ({})", noise.sigma_nm, noise.source)?;
        if let Some(uncertainty_nm) = noise.uncertainty_nm {
            write!(f, " ± {uncertainty_nm:.2} nm")?;
        }
        if let Some(share) = noise.outlier_share.filter(|&share| share > 0.0) {
            write!(f, ", {:.2} % of the samples stood off", 100.0 * share)?;
        }
        writeln!(f)?;
        if let Some(Range { min_mm, max_mm }) = self.lfs.range_mm {
            let source = self.lfs.source;
            write!(f, "lfs        {min_mm:.4} to {max_mm:.4} mm ({source})")?;
            if let Some(limit_mm) = self.lfs.limited_to_mm {
                write!(
                    f,
                    "; more counts as {limit_mm:.4} mm, so points a fifth of the width apart stay"
                )?;
            }
            writeln!(f)?;
        }
        if let Some(Spacings { min_mm, median_mm, max_mm }) = &self.spacing {
            writeln!(f, "spacing    {median_mm:.5} mm, from {min_mm:.5} to {max_mm:.5} mm")?;
        }
        for (name, condition) in [("before", &self.before), ("after", &self.after)] {
            write!(f, "{name:<10} ")?;
            condition.fmt(f)?;
            if let Some(rho) = condition.rho_max.filter(|_| self.rho.is_some()) {
                write!(f, ", largest ρ {rho:.5}")?;
            }
            writeln!(f)?;
        }
        if let Some(count) = self.averaged {
            write!(f, "averaged   {count} of {}", self.kept)?;
            if let Some(Averages { of, u_median_nm, u_max_nm, .. }) = &self.averages {
                write!(f, ", {of}, u {u_median_nm:.3} nm, at most {u_max_nm:.3} nm")?;
            }
            writeln!(f)?;
        }
        for (split, what) in [
            (&self.by.noise, "points where the noise wants a wider spacing than ε allows"),
            (&self.by.sparse, "points measured hardly densely enough for ε"),
            (&self.by.unknown, "points of unknown local feature size"),
        ] {
            let count = split.kept + split.dropped;
            if count > 0 {
                writeln!(f, "           {count} {what}: {} kept", split.kept)?;
            }
        }
        if self.sparse.triangles > 0 {
            let Sparse { triangles, area_mm2 } = self.sparse;
            writeln!(
                f,
                "           {triangles} measured triangles too wide for ε, {area_mm2:.4} mm²: `asphera sampling` says where"
            )?;
        }
        writeln!(f, "written    {}", self.output)
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4} mm²", self.area_mm2)?;
        if let Some(epsilon) = self.epsilon_max {
            write!(f, ", largest ε {epsilon:.5}")?;
        }
        if let Some(share) = self.overdense_fraction {
            write!(f, ", {:.2} % too dense for the noise", 100.0 * share)?;
        }
        Ok(())
    }
}
