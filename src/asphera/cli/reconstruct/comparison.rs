//! `--compare`: every method on the same points, a row each: `asphera.reconstruct.comparison/1`.

use std::fmt::Write as _;
use std::path::Path;

use asphera_formats::read_triangles;
use asphera_formats::xyz::TextOptions;
use asphera_geometry::{PointMm, VertexId, sampled_surface};
use asphera_reconstruct::{Proof, Reconstruction, distances_mm, prove};
use serde::Serialize;

use crate::cli::files::read;
use crate::cli::output::Failure;
use crate::cli::summary::short;

/// Figures of all methods.
#[derive(Debug, Serialize)]
pub(super) struct Comparison {
    format: &'static str,
    file: String,
    points: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    truth: Option<String>,
    rows: Vec<ComparisonRow>,
}

/// Figures of a method, or why it gives no surface.
#[derive(Debug, Serialize)]
pub(super) struct ComparisonRow {
    method: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
    #[serde(flatten)]
    found: Option<MethodFigures>,
}

#[derive(Debug, Serialize)]
struct MethodFigures {
    seconds: f64,
    facets: usize,
    points_left_out: usize,
    components: usize,
    closed: bool,
    genus: Option<i64>,
    borders: usize,
    /// Non-manifold edges, singular vertices and crossings of facets.
    defects: usize,
    guarantee: String,
    /// The farthest of the points from the surface.
    points_off_mm: Option<f64>,
    /// From the surface to the truth: mean square root and largest.
    #[serde(skip_serializing_if = "Option::is_none")]
    to_truth_mm: Option<[f64; 2]>,
    /// From the truth to the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_truth_mm: Option<[f64; 2]>,
}

/// The true surface.
pub(super) struct Truth {
    points_mm: Vec<PointMm>,
    facets: Vec<[u32; 3]>,
    /// Places on it.
    places_mm: Vec<PointMm>,
}

impl Truth {
    /// Reads a triangle mesh.
    pub(super) fn open(path: &Path, options: &TextOptions) -> Result<Truth, Failure> {
        let named = |why: &dyn std::fmt::Display| format!("{}: {why}", path.display());
        let bytes = read(path)?;
        let name = path.display().to_string();
        let mesh =
            read_triangles(&name, &bytes, options).map_err(|why| match why.names_file() {
                true => why.to_string(),
                false => named(&why),
            })?;
        let mesh = mesh.filter(|mesh| !mesh.triangles.is_empty()).ok_or_else(|| {
            named(&"expected a mesh with triangles (PLY, STL, OBJ or OFF), found points alone")
        })?;
        let places_mm = places(&mesh.points_mm, &mesh.triangles);
        Ok(Truth { points_mm: mesh.points_mm, facets: mesh.triangles, places_mm })
    }
}

/// Places all over a mesh.
fn places(points_mm: &[PointMm], facets: &[[u32; 3]]) -> Vec<PointMm> {
    let corners: Vec<[VertexId; 3]> = facets.to_vec();
    sampled_surface(points_mm, &corners, PLACES, 0).iter().map(|place| place.at_mm).collect()
}

impl Comparison {
    pub(super) fn new(file: String, points: usize, truth: Option<&Path>) -> Comparison {
        let truth = truth.map(|path| path.display().to_string());
        Comparison {
            format: "asphera.reconstruct.comparison/1",
            file,
            points,
            truth,
            rows: Vec::new(),
        }
    }

    /// Adds a method that gives no surface.
    pub(super) fn add_refused(&mut self, method: String, why: String) {
        self.rows.push(ComparisonRow { method, refused: Some(why), found: None });
    }

    /// Adds a method, its surface and the seconds that it took.
    pub(super) fn add(
        &mut self,
        method: String,
        points_mm: &[PointMm],
        (made, seconds): (&Reconstruction, f64),
        guarantee: impl FnOnce(&Proof) -> String,
        truth: Option<&Truth>,
    ) -> Result<(), Failure> {
        let proof = prove(points_mm, &made.facets)?;
        let finite: Vec<PointMm> =
            points_mm.iter().filter(|p| p.iter().all(|v| v.is_finite())).copied().collect();
        let off = distances_mm(points_mm, &made.facets, &finite);
        let off = off.into_iter().fold(0.0, f64::max);
        let to = truth.map(|truth| {
            let places = places(points_mm, &made.facets);
            spread(&distances_mm(&truth.points_mm, &truth.facets, &places))
        });
        let from =
            truth.map(|truth| spread(&distances_mm(points_mm, &made.facets, &truth.places_mm)));
        let is_finite = |pair: &[f64; 2]| pair.iter().all(|value| value.is_finite());
        self.rows.push(ComparisonRow {
            method,
            refused: None,
            found: Some(MethodFigures {
                seconds,
                facets: proof.facets,
                points_left_out: made.left_out.len(),
                components: proof.components,
                closed: proof.is_closed,
                genus: proof.genus.filter(|_| proof.facets > 0),
                borders: proof.border_loops.len(),
                defects: proof.nonmanifold_edges.count
                    + proof.singular_vertices.count
                    + proof.self_intersections.count,
                guarantee: guarantee(&proof),
                points_off_mm: Some(off).filter(|value| value.is_finite()),
                to_truth_mm: to.filter(is_finite),
                from_truth_mm: from.filter(is_finite),
            }),
        });
        Ok(())
    }

    /// A table for a terminal.
    pub(super) fn summary(&self) -> String {
        let mut text = format!(
            "{:<14} {:>8} {:>9} {:>8} {:>6} {:>6} {:>6} {:>8} {:>8} {:>9}",
            "method",
            "s",
            "facets",
            "left out",
            "parts",
            "closed",
            "genus",
            "borders",
            "defects",
            "off mm"
        );
        if self.truth.is_some() {
            let _ = write!(text, " {:>9} {:>9}", "to mm", "from mm");
        }
        text.push_str("  guarantee\n");
        for row in &self.rows {
            // Writing into a String cannot fail.
            let _ = write!(text, "{:<14}", row.method);
            let Some(found) = &row.found else {
                let _ = writeln!(text, " {}", row.refused.as_deref().unwrap_or_default());
                continue;
            };
            let length = |value: Option<f64>| value.map_or("-".to_owned(), short);
            let _ = write!(
                text,
                " {:>8.2} {:>9} {:>8} {:>6} {:>6} {:>6} {:>8} {:>8} {:>9}",
                found.seconds,
                found.facets,
                found.points_left_out,
                found.components,
                if found.closed { "yes" } else { "no" },
                found.genus.map_or("-".to_owned(), |genus| genus.to_string()),
                found.borders,
                found.defects,
                length(found.points_off_mm),
            );
            if self.truth.is_some() {
                let [to, from] = [found.to_truth_mm, found.from_truth_mm]
                    .map(|pair| length(pair.map(|[_, largest]| largest)));
                let _ = write!(text, " {to:>9} {from:>9}");
            }
            let _ = writeln!(text, "  {}", found.guarantee);
        }
        text
    }
}

/// Root of the mean square, and the largest.
fn spread(distances_mm: &[f64]) -> [f64; 2] {
    let squares: f64 = distances_mm.iter().map(|value| value * value).sum();
    let mean = squares / distances_mm.len().max(1) as f64;
    [mean.sqrt(), distances_mm.iter().copied().fold(0.0, f64::max)]
}

/// So many places of each surface are compared.
const PLACES: usize = 20_000;
