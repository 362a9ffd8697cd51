//! The figures of a reconstruction: `asphera.reconstruct/1`.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use asphera_geometry::PointMm;
use asphera_reconstruct::{LeftOut, Proof, Reconstruction};
use serde::Serialize;

use super::delaunay::DelaunayFigures;
use super::graph::GraphStages;
use crate::cli::summary::short;

#[derive(Debug, Serialize)]
pub(super) struct ReconstructReport {
    format: &'static str,
    file: String,
    mesh: MeshFigures,
}

#[derive(Debug, Serialize)]
struct MeshFigures {
    points: usize,
    vertices: usize,
    reconstruction: ReconstructionFigures,
}

#[derive(Debug, Serialize)]
struct ReconstructionFigures {
    method: &'static str,
    facets: usize,
    /// Points that no facet uses, by reason.
    left_out: BTreeMap<&'static str, usize>,
    /// The first of them, by number from 0, with place and reason.
    left_out_first: Vec<LeftOutFigures>,
    components: usize,
    closed: bool,
    manifold: bool,
    orientable: bool,
    genus: Option<i64>,
    betti: Option<[i64; 3]>,
    border_loops: Vec<LoopFigures>,
    nonmanifold_edges: usize,
    singular_vertices: usize,
    self_intersections: usize,
    degenerate_facets: usize,
    area_mm2: f64,
    volume_mm3: Option<f64>,
    guarantee: String,
    /// Tiles that the points were cut into; of the graph method with --tiles only.
    #[serde(skip_serializing_if = "Option::is_none")]
    tiles: Option<usize>,
    /// Figures of a method over the Delaunay triangulation, with its sampling condition.
    #[serde(flatten)]
    delaunay: Option<DelaunayFigures>,
    stages_s: StageFigures,
    as_of_points: usize,
}

#[derive(Debug, Serialize)]
struct LeftOutFigures {
    point: u32,
    /// `None` of coordinates that are not finite.
    place_mm: [Option<f64>; 3],
    why: &'static str,
}

#[derive(Debug, Serialize)]
struct LoopFigures {
    edges: usize,
    length_mm: f64,
    place_mm: PointMm,
}

#[derive(Debug, Serialize)]
struct StageFigures {
    mesh: f64,
    proof: f64,
    /// Stages of the mesh; of the graph method only.
    #[serde(flatten)]
    graph: Option<GraphStages>,
}

impl ReconstructReport {
    pub(super) fn new(
        file: String,
        points_mm: &[PointMm],
        made: &Reconstruction,
        proof: &Proof,
        [mesh_s, proof_s]: [f64; 2],
    ) -> ReconstructReport {
        let mut left_out = BTreeMap::new();
        for (_, why) in &made.left_out {
            *left_out.entry(word(*why)).or_default() += 1;
        }
        let first = made.left_out.iter().take(MOST_LISTED).map(|&(point, why)| {
            let place = points_mm[point as usize];
            let place_mm = place.map(|value| value.is_finite().then_some(value));
            LeftOutFigures { point, place_mm, why: word(why) }
        });
        let loops = proof.border_loops.iter().map(|border| LoopFigures {
            edges: border.edges,
            length_mm: border.length_mm,
            place_mm: points_mm[border.vertex as usize],
        });
        let reconstruction = ReconstructionFigures {
            method: "local",
            facets: proof.facets,
            left_out,
            left_out_first: first.collect(),
            components: proof.components,
            closed: proof.is_closed,
            manifold: proof.is_manifold,
            orientable: proof.is_orientable,
            genus: proof.genus,
            betti: proof.betti,
            border_loops: loops.collect(),
            nonmanifold_edges: proof.nonmanifold_edges.count,
            singular_vertices: proof.singular_vertices.count,
            self_intersections: proof.self_intersections.count,
            degenerate_facets: proof.degenerate_facets.count,
            area_mm2: proof.area_mm2,
            volume_mm3: proof.volume_mm3,
            guarantee: LOCAL_GUARANTEE.to_owned(),
            tiles: None,
            delaunay: None,
            stages_s: StageFigures { mesh: mesh_s, proof: proof_s, graph: None },
            as_of_points: points_mm.len(),
        };
        let mesh =
            MeshFigures { points: points_mm.len(), vertices: proof.vertices, reconstruction };
        ReconstructReport { format: "asphera.reconstruct/1", file, mesh }
    }

    /// With the stages of the graph method, if it was that.
    pub(super) fn with_stages(mut self, stages: Option<GraphStages>) -> ReconstructReport {
        let found = &mut self.mesh.reconstruction;
        if stages.is_some() {
            found.method = "graph";
            found.guarantee = GRAPH_GUARANTEE.to_owned();
        }
        found.stages_s.graph = stages;
        self
    }

    /// With what is known of all points where the mesh is of the landmarks alone.
    pub(super) fn with_tiles(
        mut self,
        points: usize,
        left_out: &[(LeftOut, usize)],
        tiles: usize,
    ) -> ReconstructReport {
        self.mesh.points = points;
        let found = &mut self.mesh.reconstruction;
        found.as_of_points = points;
        found.left_out = left_out.iter().map(|&(why, count)| (word(why), count)).collect();
        found.tiles = Some(tiles);
        self
    }

    /// With the figures of a method over the Delaunay triangulation, if it was one.
    pub(super) fn with_delaunay(
        mut self,
        figures: Option<DelaunayFigures>,
        proof: &Proof,
    ) -> ReconstructReport {
        let found = &mut self.mesh.reconstruction;
        if let Some(figures) = figures {
            found.method = figures.method();
            found.guarantee = figures.guarantee(proof);
            found.delaunay = Some(figures);
        }
        self
    }

    /// Lines for a terminal.
    pub(super) fn summary(&self) -> String {
        let found = &self.mesh.reconstruction;
        let mut text = String::new();
        // Writing into a String cannot fail.
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "{name:<10} {value}");
        };
        line(
            "surface",
            format!(
                "{} facets through {} of {} points, method {}",
                found.facets, self.mesh.vertices, self.mesh.points, found.method
            ),
        );
        for (why, count) in &found.left_out {
            line("left out", format!("{count}: {why}"));
        }
        let closed = if found.closed { "closed" } else { "open" };
        let sides = if found.orientable { "two-sided" } else { "one-sided" };
        let genus = found.genus.map_or("not known".to_owned(), |genus| genus.to_string());
        line(
            "topology",
            format!("{closed}, {sides}, components {}, genus {genus}", found.components),
        );
        for border in found.border_loops.iter().take(MOST_PRINTED) {
            let [x, y, z] = border.place_mm.map(short);
            let length = short(border.length_mm);
            line("border", format!("{} edges, {length} mm, at {x}, {y}, {z} mm", border.edges));
        }
        if found.border_loops.len() > MOST_PRINTED {
            line("", format!("{} borders in all; --json lists them", found.border_loops.len()));
        }
        line(
            "proof",
            format!(
                "{} non-manifold edges, {} singular vertices, {} crossings of facets",
                found.nonmanifold_edges, found.singular_vertices, found.self_intersections
            ),
        );
        let volume = found.volume_mm3.map(|volume| format!(", volume {} mm³", short(volume)));
        line("area", format!("{} mm²{}", short(found.area_mm2), volume.unwrap_or_default()));
        line("guarantee", found.guarantee.clone());
        for (name, value) in found.delaunay.iter().flat_map(DelaunayFigures::lines) {
            line(name, value);
        }
        if let Some(tiles) = found.tiles {
            line("tiles", tiles.to_string());
        }
        if let Some(stages) = &found.stages_s.graph {
            line("stages", stages.line());
        }
        text
    }
}

fn word(why: LeftOut) -> &'static str {
    match why {
        LeftOut::NoPlace => "no finite place",
        LeftOut::Duplicate => "place of an earlier point",
        LeftOut::NoPlane => "neighbours on a line, or too few",
        LeftOut::Pruned => "a landmark stands for it",
        LeftOut::NoFacet => "a corner of no facet of the method",
        LeftOut::Noise => "touches no big ball outside: noise, or behind the surface",
        LeftOut::NoFace => "a landmark in no face",
        LeftOut::Folding => "as a vertex it would fold the surface",
        LeftOut::Disagreement => {
            "corners do not agree: spacing beyond the features, crossing sheets or noise"
        }
    }
}

/// So many points left out are listed in JSON.
const MOST_LISTED: usize = 100;
/// So many borders are printed on a terminal.
const MOST_PRINTED: usize = 6;

/// The guarantee of the local method.
pub(super) const LOCAL_GUARANTEE: &str =
    "unknown: the local feature size of the part is not known here";
/// The guarantee of the graph method.
pub(super) const GRAPH_GUARANTEE: &str =
    "none: the graph method sees hops, not lengths; the proof says what the surface is";
