//! Ball pivoting in the plane: a disc rolls from sample to sample.

use asphera_geometry::predicates::{compare_circumradius, compare_distances, scalar_product};

use crate::graphs::longest_spanning;
use crate::triangulation::{EdgeId, TriangleId};
use crate::{Graph, SampleId, Triangulation};

/// The edges that discs roll over, each through its ends and with no sample within.
///
/// For each radius, rising: the disc rolls on from every end of a curve, then from every edge between two samples without edges, shortest
/// first. It turns about the sample in front until it meets another, which is joined if it has fewer than two edges. So no sample has more
/// than two. The disc begins on the side of an edge with the wider empty disc, and changes sides where it cannot go on. Where the disc of a radius touches three
/// samples, the edges are those of a disc slightly smaller on the near side ([`crate::regions::alpha_curve`]).
///
/// F. Bernardini, C. L. Bajaj, *Sampling and reconstructing manifolds using alpha-shapes*, CCCG 1997, and F. Bernardini and others, IEEE
/// Transactions on Visualization and Computer Graphics 5 (1999) 349-359, of which this is the form in the plane; the texts were not
/// at hand: order and joining are ours. No condition is proven of it here. Decided exactly. n·log n time a radius.
///
/// # Panics
///
/// If a radius is not above 0 or not finite.
pub fn ball_pivoting(triangulation: &Triangulation, radii_mm: &[f64]) -> Graph {
    let mut rolled = Rolled { triangulation, others: vec![[None; 2]; triangulation.len()] };
    let mut ball = Ball::new(triangulation);
    let mut open: Vec<EdgeId> = (0..triangulation.edges().len() as EdgeId).collect();
    for &radius_mm in radii_mm {
        assert!(
            radius_mm.is_finite() && radius_mm > 0.0,
            "expected a finite radius above 0, found {radius_mm}"
        );
        // A disc comes over no edge between two samples that have two: after the first radius few are left.
        open.retain(|&edge| triangulation.ends(edge).iter().any(|&end| rolled.degree(end) < 2));
        ball.grow(triangulation, radius_mm, &open);
        let rests = open.iter().copied().filter(|&edge| ball.touches[edge as usize] != [false; 2]);
        let by_length = triangulation.sorted_by_length(&rests.collect::<Vec<EdgeId>>());
        for &edge in &by_length {
            let [p, q] = triangulation.ends(edge);
            if rolled.joins(p, q) {
                rolled.roll_on(&ball, edge);
            }
        }
        for &edge in &by_length {
            let [p, q] = triangulation.ends(edge);
            if rolled.degree(p) == 0 && rolled.degree(q) == 0 {
                rolled.join(p, q);
                rolled.roll_on(&ball, edge);
            }
        }
    }
    let edges = (0..).zip(&rolled.others);
    Graph::new(edges.flat_map(|(at, others)| others.iter().flatten().map(move |&to| [at, to])))
}

/// The radii that [`ball_pivoting`] takes where none is given, in mm: the median of the distances to the nearest sample, and that
/// doubled up to four times, no more often than until it exceeds the longest edge of the spanning tree; none of fewer than two samples.
pub fn pivoting_radii_mm(triangulation: &Triangulation) -> Vec<f64> {
    let nearest = (0..triangulation.len() as SampleId).filter_map(|at| triangulation.nearest(at));
    let mut edges: Vec<EdgeId> = nearest.map(|spoke| spoke.edge).collect();
    edges.sort_unstable();
    let by_length = triangulation.sorted_by_length(&edges);
    let Some(&median) = by_length.get(by_length.len() / 2) else { return Vec::new() };
    let first_mm = triangulation.length_mm(median);
    let longest = longest_spanning(triangulation);
    let longest_mm = longest.map_or(first_mm, |edge| triangulation.length_mm(edge));
    let mut radii = vec![first_mm];
    for doubling in 1..=DOUBLINGS {
        if radii.last().is_some_and(|&last_mm| last_mm <= longest_mm) {
            radii.push(first_mm * 2_f64.powi(doubling));
        }
    }
    radii
}

/// Where discs of one radius rest.
struct Ball {
    /// Whether a disc through the ends of each edge, centred on its left or on its right, holds no sample.
    touches: Vec<[bool; 2]>,
}

impl Ball {
    fn new(triangulation: &Triangulation) -> Ball {
        Ball { touches: vec![[false; 2]; triangulation.edges().len()] }
    }

    /// Takes a radius. Only of these edges is known where it rests then.
    fn grow(&mut self, triangulation: &Triangulation, radius_mm: f64, edges: &[EdgeId]) {
        let is_wide = |triangle: TriangleId| {
            let corners = triangulation.triangles()[triangle as usize];
            let places = corners.map(|corner| triangulation.place(corner));
            compare_circumradius(places, radius_mm).is_gt()
        };
        for &id in edges {
            let [p, q] = triangulation.ends_mm(id);
            if compare_distances(p, q, [2.0 * radius_mm, 0.0], [0.0; 2]).is_gt() {
                self.touches[id as usize] = [false; 2];
                continue;
            }
            let triangles = triangulation.edges()[id as usize].triangles();
            let apexes = triangulation.opposite(id);
            let beside = [0, 1].map(|side| {
                let apex = triangulation.place(apexes[side]?);
                Some((is_wide(triangles[side]?), scalar_product(apex, p, q)))
            });
            // The centre lies no farther out than that of the triangle on its side, and no nearer than that of the other.
            let is_below = beside.map(|it| it.is_none_or(|(is_wide, way)| is_wide && way.is_gt()));
            let is_above =
                beside.map(|it| it.is_none_or(|(is_wide, way)| !is_wide || !way.is_lt()));
            self.touches[id as usize] = [is_below[0] && is_above[1], is_below[1] && is_above[0]];
        }
    }
}

/// A disc at the end of a curve.
#[derive(Clone, Copy)]
struct Head {
    /// The sample in front.
    at: SampleId,
    /// The edge that leads there.
    edge: EdgeId,
    /// The side of the way on which the disc rolls: 0 left, 1 right.
    side: usize,
}

/// The edges so far, at most two a sample.
struct Rolled<'a> {
    triangulation: &'a Triangulation,
    others: Vec<[Option<SampleId>; 2]>,
}

impl Rolled<'_> {
    fn degree(&self, sample: SampleId) -> usize {
        self.others[sample as usize].iter().flatten().count()
    }

    fn joins(&self, p: SampleId, q: SampleId) -> bool {
        self.others[p as usize].contains(&Some(q))
    }

    fn join(&mut self, p: SampleId, q: SampleId) {
        for (at, to) in [(p, q), (q, p)] {
            let others = &mut self.others[at as usize];
            *(if others[0].is_none() { &mut others[0] } else { &mut others[1] }) = Some(to);
        }
    }

    /// Rolls on from both ends of an edge, the shorter step first, until the curve is closed or ends.
    fn roll_on(&mut self, ball: &Ball, edge: EdgeId) {
        let [p, q] = self.triangulation.ends(edge);
        let side = usize::from(self.is_wider_right(edge));
        // Left of the way from the first end to the second is right of the way back.
        let mut heads = [Head { at: q, edge, side }, Head { at: p, edge, side: 1 - side }];
        loop {
            let steps = heads.map(|head| self.step(ball, head));
            let chosen = match steps.map(|step| step.map(|head| head.edge)) {
                [None, None] => return,
                [Some(_), None] => 0,
                [None, Some(_)] => 1,
                [Some(first), Some(second)] => {
                    let order = self.triangulation.compare_lengths(second, first);
                    usize::from(order.then(second.cmp(&first)).is_lt())
                }
            };
            if let Some(head) = steps[chosen] {
                self.join(heads[chosen].at, head.at);
                heads[chosen] = head;
            }
        }
    }

    /// The step that a disc takes, on its side or else on the other; none at the end of the curve.
    fn step(&self, ball: &Ball, head: Head) -> Option<Head> {
        if self.degree(head.at) != 1 {
            return None;
        }
        let [first, _] = self.triangulation.ends(head.edge);
        [head.side, 1 - head.side].into_iter().find_map(|side| {
            let at_edge = if first == head.at { 1 - side } else { side };
            if !ball.touches[head.edge as usize][at_edge] {
                return None;
            }
            let (to, edge) = self.met(ball, head.at, head.edge, side)?;
            let is_free = edge != head.edge && self.degree(to) < 2;
            is_free.then_some(Head { at: to, edge, side })
        })
    }

    /// The sample that the disc meets when it turns about another, away from an edge, and the edge to it.
    fn met(
        &self,
        ball: &Ball,
        at: SampleId,
        edge: EdgeId,
        side: usize,
    ) -> Option<(SampleId, EdgeId)> {
        let fan = self.triangulation.fan(at);
        let count = fan.edges.len();
        let start = fan.edges.iter().position(|&other| other == edge)?;
        // On the left of the way the disc turns clockwise about the sample, on the right counter-clockwise.
        let steps = (1..=count).map(|step| match side {
            0 => (start + count - step) % count,
            _ => (start + step) % count,
        });
        for index in steps {
            let next = fan.edges[index];
            let [first, second] = self.triangulation.ends(next);
            let (to, side) = if first == at { (second, side) } else { (first, 1 - side) };
            if ball.touches[next as usize][side] {
                return Some((to, next));
            }
        }
        None
    }

    /// Whether the empty disc through the ends of an edge on its right is wider than that on its left.
    fn is_wider_right(&self, edge: EdgeId) -> bool {
        let [p, q] = self.triangulation.ends_mm(edge);
        // The flatter the apex, the less lies between: beyond the hull there is no bound.
        let room = |apex: Option<SampleId>| match apex.map(|apex| self.triangulation.place(apex)) {
            None => f64::INFINITY,
            Some([x, y]) => {
                let [px, py, qx, qy] = [p[0] - x, p[1] - y, q[0] - x, q[1] - y];
                (px * qx + py * qy) / (px * qy - py * qx).abs()
            }
        };
        let [left, right] = self.triangulation.opposite(edge).map(room);
        right > left
    }
}

/// How often the first radius is doubled.
const DOUBLINGS: i32 = 4;
