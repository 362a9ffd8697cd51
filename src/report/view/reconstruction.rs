//! A mesh in space in words.

use super::{Block, Chapter, Fact, Layout, Table};
use crate::words::{DASH, count, counted, direction, place, quantity, short};
use crate::{BorderFigures, MeshFigures, ReconstructionFigures};

/// Adds a mesh in space to the chapter of the mesh.
pub(super) fn add(chapter: &mut Chapter, mesh: &MeshFigures, found: &ReconstructionFigures) {
    chapter.brief.extend(brief(found));
    chapter.facts(facts(mesh, found));
    chapter.note(format!("Meshed in space: {}.", found.reason));
    chapter.note(format!("Guarantee: {}.", found.guarantee));
    for flaw in flaws(found) {
        chapter.blocks.push(Block::Caution { text: format!("The mesh is no surface: {flaw}.") });
    }
    borders(chapter, found);
}

fn brief(found: &ReconstructionFigures) -> Vec<String> {
    let closed = if found.closed { "closed" } else { "open" };
    let genus = found.genus.map_or(String::new(), |genus| format!(", genus {genus}"));
    let mut lines = vec![format!(
        "in space, {} in {}, {closed}{genus}, {} mm²",
        counted(found.facets, "facet"),
        counted(found.components, "part"),
        short(found.area_mm2)
    )];
    let loops = found.border_loops.len() as u64 + found.border_loops_more;
    if let Some(longest) = found.border_loops.first() {
        lines.push(format!(
            "{} of border, the longest {} mm about {}",
            counted(loops, "loop"),
            short(longest.length_mm),
            place(&longest.at_mm)
        ));
    }
    lines.extend(flaws(found));
    lines
}

/// What makes the mesh no surface.
fn flaws(found: &ReconstructionFigures) -> Vec<String> {
    let counts = [
        (
            found.nonmanifold_edges,
            "edge with three facets or more",
            "edges with three facets or more",
        ),
        (found.singular_vertices, "singular vertex", "singular vertices"),
        (found.self_intersections, "crossing of facets", "crossings of facets"),
    ];
    let told = counts.into_iter().filter(|(number, ..)| *number > 0);
    told.map(|(number, one, many)| {
        format!("{} {}", count(number), if number == 1 { one } else { many })
    })
    .collect()
}

fn facts(mesh: &MeshFigures, found: &ReconstructionFigures) -> Vec<Fact> {
    let yes = |is: bool| if is { "yes" } else { "no" };
    let left_out: u64 = found.left_out.values().sum();
    let mut facts = vec![
        Fact::new("Mesh", format!("in space, method {}", found.method)),
        Fact::new("Vertices", count(mesh.vertices)),
        Fact::new("Facets", count(found.facets)),
        Fact::new("Parts", count(found.components)),
        Fact::new("Closed", yes(found.closed)),
        Fact::new("Two-sided", yes(found.orientable)).bad_if(!found.orientable),
        Fact::new("Genus", found.genus.map_or_else(|| DASH.to_owned(), |genus| genus.to_string())),
    ];
    facts.extend(found.betti.map(|[parts, tunnels, cavities]| {
        Fact::new("Components, tunnels, cavities", format!("{parts}, {tunnels}, {cavities}"))
    }));
    facts.extend([
        Fact::new("Area", quantity(Some(found.area_mm2), "mm²")),
        Fact::new("Volume", quantity(found.volume_mm3, "mm³")),
        Fact::new("Largest ε of a facet", quantity(found.epsilon_max, "")),
        Fact::new("Points in no facet", count(left_out)).bad_if(left_out > 0),
        Fact::new("As of", counted(found.as_of_points, "point")),
    ]);
    facts
}

fn borders(chapter: &mut Chapter, found: &ReconstructionFigures) {
    let mut table = Table::new(&[
        ("", Layout::Head),
        ("length", Layout::Number),
        ("about", Layout::Number),
        ("opening", Layout::Number),
        ("from", Layout::Number),
    ])
    .titled("Border");
    let row = |(number, border): (usize, &BorderFigures)| {
        let what = if border.is_gap { "gap" } else { "rim" };
        vec![
            format!("{number} {what}"),
            quantity(Some(border.length_mm), "mm"),
            place(&border.at_mm),
            quantity(border.area_mm2, "mm²"),
            border.approach.as_ref().map_or_else(|| DASH.to_owned(), direction),
        ]
    };
    table.rows.extend((1..).zip(&found.border_loops).take(SHOWN).map(row));
    chapter.table(table);
    let more = found.border_loops.len().saturating_sub(SHOWN) as u64 + found.border_loops_more;
    if more > 0 {
        chapter.note(format!("And {} of border.", counted(more, "shorter loop")));
    }
}

/// Loops that are shown.
const SHOWN: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::ChapterId;

    fn told(found: &ReconstructionFigures) -> Chapter {
        let mut chapter = Chapter::new(ChapterId::Mesh, "Mesh");
        add(&mut chapter, &MeshFigures::default(), found);
        chapter
    }

    #[test]
    fn a_closed_body_and_one_with_a_gap_are_told_apart() {
        let ball = ReconstructionFigures {
            facets: 12_000,
            components: 1,
            closed: true,
            genus: Some(0),
            area_mm2: 1256.0,
            ..ReconstructionFigures::default()
        };
        assert_eq!(
            told(&ball).brief,
            ["in space, 12\u{202f}000 facets in 1 part, closed, genus 0, 1256 mm²"]
        );
        let border = BorderFigures {
            edges: 9,
            length_mm: 3.5,
            at_mm: [0.0, 0.0, -10.0],
            area_mm2: Some(0.9),
            approach: Some([0.0, 0.0, -1.0]),
            is_gap: true,
        };
        let open = ReconstructionFigures {
            closed: false,
            border_loops: vec![border],
            singular_vertices: 1,
            ..ball
        };
        let told = told(&open);
        assert!(told.brief[1].starts_with("1 loop of border, the longest 3.500 mm"), "{told:?}");
        assert_eq!(told.brief[2], "1 singular vertex");
        let table = told.blocks.iter().find_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        });
        assert_eq!(table.unwrap().rows[0][4], "(0.000, 0.000, \u{2212}1.000)");
    }
}
