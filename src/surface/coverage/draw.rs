//! What is not covered, joined to regions and drawn: triangles and the border of the aperture to
//! closed lines.
//!
//! A region ends where a side of its triangles, as far as it runs inside the aperture, has no other
//! triangle of the region beyond; and where the border of the aperture runs through its triangles.
//! Where sides cross the border is decided exactly, once for each pair, so the ends of all these
//! pieces agree and they close to lines by themselves.

use std::cmp::Ordering;

use asphera_geometry::predicates::{Place, orientation};
use asphera_geometry::{PointMm, Sets, VertexId, place};

use super::border::{Border, Whereabouts};
use super::clip::{cross, minus};
use super::frame::Frame;
use super::gauge::Standing;
use crate::outline::{Loop, Starts, loops};
use crate::relief::sides;

/// A triangle that is not covered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub(super) corners: [VertexId; 3],
    /// Never [`Standing::Covered`].
    pub(super) standing: Standing,
    pub(super) whereabouts: Whereabouts,
    /// Its area inside the aperture.
    pub(super) area_mm2: f64,
    /// The part of that whose places are not within the target.
    pub(super) beyond_mm2: f64,
}

/// The plane with all that is in it.
pub(super) struct Scene<'a> {
    pub(super) points: &'a [PointMm],
    /// None if the outline of the data stands in for the aperture.
    pub(super) border: Option<&'a Border>,
    pub(super) frame: Option<&'a Frame>,
    /// Sides on the outline of the data, ascending, where that stands in for the aperture.
    pub(super) outer: &'a [[VertexId; 2]],
}

/// The regions and their closed lines.
pub(super) struct Drawing {
    /// The region of each open triangle. Regions are numbered by their first triangle.
    pub(super) region_of: Vec<usize>,
    /// For each region its closed lines; outlines have positive areas.
    pub(super) lines: Vec<Vec<Line>>,
}

/// A closed line of a region, the region on the left.
pub(super) struct Line {
    pub(super) places_mm: Vec<Place>,
    /// For each place whether the side from there faces nothing that is covered.
    pub(super) open: Vec<bool>,
    pub(super) signed_area_mm2: f64,
}

/// The border runs exactly through a vertex or so: another one is to be tried.
#[derive(Debug)]
pub(super) struct Coincidence;

/// Where pieces end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Node {
    Vertex(VertexId),
    /// Where a side of the border begins.
    Border(u32),
    /// Where a side of a triangle, its smaller end first, crosses a side of the border.
    Crossing(VertexId, VertexId, u32),
}

/// A piece of a closed line.
#[derive(Clone, Copy)]
struct Piece {
    region: usize,
    from: Node,
    to: Node,
    open: bool,
}

/// A side of a triangle at a side of the border.
struct Crossing {
    /// How far from the first end, 0 to 1.
    share: f64,
    border: u32,
    /// Whether the side leaves the aperture there.
    leaves: bool,
}

impl Scene<'_> {
    /// Joins the open triangles to regions and draws them.
    ///
    /// `opening_mm(vertex)` is how wide a seam outside the hull must be at a vertex of the hull for
    /// what lies on both sides of it to be one region.
    pub(super) fn draw(
        &self,
        open: &[Open],
        opening_mm: impl Fn(VertexId) -> f64,
    ) -> Result<Drawing, Coincidence> {
        let corners: Vec<[VertexId; 3]> = open.iter().map(|open| open.corners).collect();
        let vertices = self.points.len() + self.frame.map_or(0, |frame| frame.far.len());
        let starts = Starts::new(vertices, &corners);
        let mut pen = Pen { scene: self, near: Vec::new(), crossings: Vec::new() };
        let mut sets = Sets::new(open.len());
        let mut inside: Vec<(Node, Node)> = Vec::new();
        for (index, &triangle) in corners.iter().enumerate() {
            for [p, q] in sides(triangle) {
                let Some(other) = starts.triangle_left_of([q, p]).filter(|&other| index < other)
                else {
                    continue;
                };
                pen.side_inside([p, q], [&open[index], &open[other]], &mut inside)?;
                let ray = self.frame.and_then(|frame| frame.ray([p, q]));
                let wide = match ray {
                    Some(vertex) => {
                        let lengths = inside.iter().map(|&(from, to)| {
                            let way = minus(self.at(to), self.at(from));
                            way[0].hypot(way[1])
                        });
                        lengths.sum::<f64>() > opening_mm(vertex)
                    }
                    None => !inside.is_empty(),
                };
                if wide {
                    sets.join(index, other);
                }
            }
        }
        let mut number_of_root = vec![0; open.len()];
        let mut regions = 0;
        let mut region_of = Vec::with_capacity(open.len());
        for index in 0..open.len() {
            let root = sets.root(index);
            if root == index {
                number_of_root[root] = regions;
                regions += 1;
            }
            region_of.push(number_of_root[root]);
        }
        let mut pieces: Vec<Piece> = Vec::new();
        for (index, &triangle) in corners.iter().enumerate() {
            let region = region_of[index];
            for [p, q] in sides(triangle) {
                let beyond = starts.triangle_left_of([q, p]);
                if beyond.is_some_and(|other| region_of[other] == region) {
                    continue;
                }
                let here = &open[index];
                pen.side_inside(
                    [p, q],
                    [here, beyond.map_or(here, |other| &open[other])],
                    &mut inside,
                )?;
                let open = beyond.is_some() || self.outer.binary_search(&[p, q]).is_ok();
                pieces.extend(inside.iter().map(|&(from, to)| Piece { region, from, to, open }));
            }
            if open[index].whereabouts == Whereabouts::Near {
                pen.border_inside(triangle, region, &mut pieces)?;
            }
        }
        let lines = self.closed(pieces, regions)?;
        Ok(Drawing { region_of, lines })
    }

    pub(super) fn at_vertex(&self, vertex: VertexId) -> Place {
        match self.frame.and_then(|frame| Some((frame, vertex.checked_sub(frame.first_far)?))) {
            Some((frame, index)) => frame.far[index as usize],
            None => place(self.points[vertex as usize]),
        }
    }

    pub(super) fn corners(&self, corners: [VertexId; 3]) -> [Place; 3] {
        corners.map(|corner| self.at_vertex(corner))
    }

    fn at(&self, node: Node) -> Place {
        match (node, self.border) {
            (Node::Vertex(vertex), _) => self.at_vertex(vertex),
            (Node::Border(index), Some(border)) => border.place(index),
            (Node::Crossing(p, q, side), Some(border)) => {
                let (a, b) = border.side(side);
                let (p, q) = (self.at_vertex(p), self.at_vertex(q));
                let way = minus(q, p);
                let (at_a, at_b) = (cross(way, minus(a, p)), cross(way, minus(b, p)));
                let share = (at_a / (at_a - at_b)).clamp(0.0, 1.0);
                [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
            }
            (Node::Border(_) | Node::Crossing(..), None) => {
                unreachable!("a node on the border is made from one")
            }
        }
    }

    /// Joins pieces to closed lines.
    fn closed(&self, pieces: Vec<Piece>, regions: usize) -> Result<Vec<Vec<Line>>, Coincidence> {
        let mut nodes: Vec<Node> = pieces.iter().flat_map(|piece| [piece.from, piece.to]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let number = |node: Node| {
            nodes.binary_search(&node).expect("the ends of all pieces are nodes") as VertexId
        };
        let places: Vec<PointMm> = nodes
            .iter()
            .map(|&node| {
                let [x, y] = self.at(node);
                [x, y, 0.0]
            })
            .collect();
        let mut sides: Vec<(usize, [VertexId; 2], bool)> = pieces
            .iter()
            .map(|piece| (piece.region, [number(piece.from), number(piece.to)], piece.open))
            .collect();
        sides.sort_unstable();
        let mut ends: Vec<(usize, VertexId)> =
            sides.iter().map(|&(region, [_, to], _)| (region, to)).collect();
        ends.sort_unstable();
        let begins = sides.iter().map(|&(region, [from, _], _)| (region, from));
        if !begins.eq(ends) {
            return Err(Coincidence);
        }
        let mut lines: Vec<Vec<Line>> = Vec::new();
        lines.resize_with(regions, Vec::new);
        let bare = sides.iter().map(|&(region, side, _)| (region, side)).collect();
        for (region, Loop { contour, signed_area_mm2 }) in loops(&places, bare) {
            let vertices = &contour.vertices;
            let open = (0..vertices.len()).map(|i| {
                let side = [vertices[i], vertices[(i + 1) % vertices.len()]];
                let at = sides.partition_point(|&(r, s, _)| (r, s) < (region, side));
                sides.get(at).is_some_and(|&(_, _, open)| open)
            });
            let places_mm = vertices.iter().map(|&vertex| place(places[vertex as usize]));
            lines[region].push(Line {
                places_mm: places_mm.collect(),
                open: open.collect(),
                signed_area_mm2,
            });
        }
        Ok(lines)
    }
}

/// Finds where sides run inside the aperture.
struct Pen<'a> {
    scene: &'a Scene<'a>,
    /// Room for the sides of the border near a triangle.
    near: Vec<u32>,
    crossings: Vec<Crossing>,
}

impl Pen<'_> {
    /// The parts inside the aperture of a side of two triangles, from its first end to its second.
    fn side_inside(
        &mut self,
        [p, q]: [VertexId; 2],
        beside: [&Open; 2],
        found: &mut Vec<(Node, Node)>,
    ) -> Result<(), Coincidence> {
        found.clear();
        let border = match self.scene.border {
            Some(border) if beside.iter().all(|open| open.whereabouts == Whereabouts::Near) => {
                border
            }
            _ => {
                if beside.iter().any(|open| open.whereabouts == Whereabouts::Inside) {
                    found.push((Node::Vertex(p), Node::Vertex(q)));
                }
                return Ok(());
            }
        };
        let (low, high) = (p.min(q), p.max(q));
        self.cross(border, low, high)?;
        let mut inside = match self.crossings.first() {
            Some(crossing) => crossing.leaves,
            None => border.contains(self.scene.at_vertex(low)),
        };
        let mut from = Node::Vertex(low);
        for crossing in &self.crossings {
            if crossing.leaves != inside {
                return Err(Coincidence);
            }
            let node = Node::Crossing(low, high, crossing.border);
            if inside {
                found.push((from, node));
            }
            inside = !inside;
            from = node;
        }
        if inside {
            found.push((from, Node::Vertex(high)));
        }
        if p > q {
            found.reverse();
            for (from, to) in found.iter_mut() {
                std::mem::swap(from, to);
            }
        }
        Ok(())
    }

    /// Where the side from `low` to `high` crosses the border, in order.
    fn cross(&mut self, border: &Border, low: VertexId, high: VertexId) -> Result<(), Coincidence> {
        let (p, q) = (self.scene.at_vertex(low), self.scene.at_vertex(high));
        border.sides_near([p, q, p], &mut self.near);
        self.crossings.clear();
        for &side in &self.near {
            let (a, b) = border.side(side);
            if let Some(leaves) = crossing([p, q], [a, b])? {
                let way = minus(b, a);
                let (at_p, at_q) = (cross(way, minus(p, a)), cross(way, minus(q, a)));
                let share = at_p / (at_p - at_q);
                self.crossings.push(Crossing { share, border: side, leaves });
            }
        }
        self.crossings.sort_by(|left, right| left.share.total_cmp(&right.share));
        Ok(())
    }

    /// Adds the parts of the border inside a triangle.
    fn border_inside(
        &mut self,
        corners: [VertexId; 3],
        region: usize,
        pieces: &mut Vec<Piece>,
    ) -> Result<(), Coincidence> {
        let Some(border) = self.scene.border else { return Ok(()) };
        let triangle = self.scene.corners(corners);
        border.sides_near(triangle, &mut self.near);
        for &side in &self.near {
            let (a, b) = border.side(side);
            let (mut from, mut to) = (None, None);
            if inside(triangle, a)? {
                from = Some(Node::Border(side));
            }
            if inside(triangle, b)? {
                to = Some(Node::Border(border.next(side)));
            }
            for [p, q] in sides(corners) {
                let (low, high) = (p.min(q), p.max(q));
                let ends = [self.scene.at_vertex(low), self.scene.at_vertex(high)];
                let Some(leaves) = crossing(ends, [a, b])? else { continue };
                // The side of the triangle from its smaller end on leaves the aperture where the
                // border crosses it from right to left; so turned about if the triangle has it the
                // other way round, on whose left it lies.
                let enters = leaves == (p == low);
                let node = Some(Node::Crossing(low, high, side));
                let end = if enters { &mut from } else { &mut to };
                if end.is_some() {
                    return Err(Coincidence);
                }
                *end = node;
            }
            match (from, to) {
                (Some(from), Some(to)) => pieces.push(Piece { region, from, to, open: true }),
                (None, None) => {}
                _ => return Err(Coincidence),
            }
        }
        Ok(())
    }
}

/// Whether the side from `p` to `q` crosses the side of the border from `a` to `b`, and if so, whether
/// it leaves the aperture there, which lies on the left of the border.
fn crossing([p, q]: [Place; 2], [a, b]: [Place; 2]) -> Result<Option<bool>, Coincidence> {
    let turns = [orientation(a, b, p), orientation(a, b, q)];
    if turns[0] != Ordering::Equal && turns[0] == turns[1] {
        return Ok(None);
    }
    let returns = [orientation(p, q, a), orientation(p, q, b)];
    if returns[0] != Ordering::Equal && returns[0] == returns[1] {
        return Ok(None);
    }
    if turns.contains(&Ordering::Equal) || returns.contains(&Ordering::Equal) {
        return Err(Coincidence);
    }
    Ok(Some(turns[0] == Ordering::Greater))
}

/// Whether a place lies inside a counter-clockwise triangle.
fn inside([p, q, r]: [Place; 3], at: Place) -> Result<bool, Coincidence> {
    let turns = [orientation(p, q, at), orientation(q, r, at), orientation(r, p, at)];
    if turns.contains(&Ordering::Less) {
        Ok(false)
    } else if turns.contains(&Ordering::Equal) {
        Err(Coincidence)
    } else {
        Ok(true)
    }
}
