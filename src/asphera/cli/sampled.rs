//! Points drawn from the triangles of a mesh, for commands that take points.

use std::path::Path;

use asphera_formats::read_triangles;
use asphera_geometry::sampled_surface;
use clap::Args;

use super::files::read;
use super::output::Failure;
use super::progress::Progress;
use super::source::Source;
use super::text::TextArgs;
use super::usage::misused;

/// What the command line says of the triangles of a mesh.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(super) struct SampledArgs {
    /// Of a mesh (PLY, STL, OBJ, OFF): draw so many points of its triangles, evenly by area, instead of taking its corners.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    sample: Option<u32>,
    /// Seed of these points.
    #[arg(long, value_name = "S", default_value_t = 1, requires = "sample")]
    seed: u64,
}

impl SampledArgs {
    /// Whether points are drawn.
    pub(super) fn is_asked(&self) -> bool {
        self.sample.is_some()
    }

    /// The points at a path: those of its triangles where these are asked for.
    pub(super) fn open(
        &self,
        path: &Path,
        text: &TextArgs,
        progress: &Progress,
    ) -> Result<Source, Failure> {
        let source = Source::open(path, text, progress)?;
        let Some(count) = self.sample else { return Ok(source) };
        let name = path.display().to_string();
        let origin = source.origin().ok_or_else(|| no_triangles(&name))?;
        let mesh = read_triangles(&name, &read(source.file())?, &text.options())
            .map_err(|error| format!("{name}: {error}"))?
            .ok_or_else(|| no_triangles(&name))?;
        progress.stage("sampling the triangles");
        let places = sampled_surface(&mesh.points_mm, &mesh.triangles, count as usize, self.seed);
        if places.is_empty() {
            return Err(format!(
                "{name}: expected triangles with an area for --sample, found none"
            )
            .into());
        }
        let points_mm = places.into_iter().map(|place| place.at_mm).collect();
        Ok(Source::of_points(path, points_mm, origin.format))
    }
}

fn no_triangles(name: &str) -> Failure {
    misused(format!(
        "{name}: expected a mesh with faces (PLY, STL, OBJ or OFF) for --sample, found points alone: leave --sample out"
    ))
}
