//! The graph and the points as PLY.

use std::io::{self, Write};
use std::path::Path;

use super::super::columns::whole;
use super::super::output::Failure;
use super::figures::Outcome;

/// Writes nodes as vertices and arcs as edges, text.
pub(super) fn write_graph(path: &Path, outcome: &Outcome) -> Result<(), Failure> {
    let graph = &outcome.found.graph;
    whole(path, |w| {
        head(w, graph.nodes().len(), &["int strip", "int places"])?;
        writeln!(w, "element edge {}", graph.arcs().len())?;
        writeln!(w, "property int vertex1\nproperty int vertex2\nend_header")?;
        for node in graph.nodes() {
            let [x, y, z] = node.centroid_mm;
            writeln!(w, "{x} {y} {z} {} {}", node.strip, node.places)?;
        }
        graph.arcs().iter().try_for_each(|arc| writeln!(w, "{} {}", arc.nodes[0], arc.nodes[1]))
    })?;
    Ok(())
}

/// Writes every point in the order of the file, with its part (−1 of an island), node, segment and value, binary.
pub(super) fn write_points(path: &Path, outcome: &Outcome) -> Result<(), Failure> {
    let Outcome { cloud, values, found, part_of_place, .. } = outcome;
    let nodes = found.graph.nodes_of_places();
    let (segments, _) = found.graph.segments_of_nodes();
    whole(path, |w| {
        writeln!(w, "ply\nformat binary_little_endian 1.0\ncomment lengths in mm")?;
        writeln!(w, "element vertex {}", cloud.places_of_rows().len())?;
        writeln!(w, "property double x\nproperty double y\nproperty double z\nproperty double f")?;
        writeln!(w, "property int part\nproperty int node\nproperty int segment\nend_header")?;
        for &place in cloud.places_of_rows() {
            let at = place as usize;
            for number in cloud.places()[at].into_iter().chain([values[at]]) {
                w.write_all(&number.to_le_bytes())?;
            }
            let node = nodes[at];
            for number in [part_of_place[at], node as i32, segments[node as usize] as i32] {
                w.write_all(&number.to_le_bytes())?;
            }
        }
        Ok(())
    })?;
    Ok(())
}

fn head(w: &mut impl Write, vertices: usize, properties: &[&str]) -> io::Result<()> {
    writeln!(w, "ply\nformat ascii 1.0\ncomment lengths in mm\nelement vertex {vertices}")?;
    writeln!(w, "property double x\nproperty double y\nproperty double z")?;
    properties.iter().try_for_each(|property| writeln!(w, "property {property}"))
}
