//! Gaps of thin triangles along the outline, from the samples beneath them.
//!
//! Where the outline of the points is nearly straight, the hull is closed by thin triangles that
//! reach over many samples. Their own corners are far apart, but the samples beneath them are near:
//!
//! ```text
//!   a - - - - - - - - - - - - - - - - - - - b     the hull
//!     ' -c- . _ d _ _ e _ _ f _ _ g _ . - '       the outermost samples
//! ```
//!
//! From any place over such a triangle, obtuse at its corner c and with its longest side to the
//! outside, a way of at most its height over that side leads to one of its two short sides, and
//! there the gap of the triangle on the other side of that short side applies. The gap is therefore
//! at most the height plus the larger gap of the two neighbours; and where a neighbour is itself
//! obtuse over that very side, the same holds for it in turn. Interior triangles need no such
//! care: the circumcentre of an obtuse one lies in another triangle whose gap is as large.
//!
//! The way is gone on the surface, not on the triangle. Along a curved outline a thin triangle is a chord that leaves the
//! surface by more than its gaps, while the samples beneath it follow the surface. So its height is that in the plane, over
//! the cosine of the steepest neighbour.

mod meshed;

use asphera_geometry::{Gap, PointMm, Triangle, VertexId};
use rayon::prelude::*;

pub(crate) use self::meshed::Rim;
use crate::relief::sides;

/// The triangles, by ascending index, whose gap is smaller than their corners alone tell, and that
/// gap. Linear time.
pub(crate) fn refined_gaps(points: &[PointMm], triangles: &[[VertexId; 3]]) -> Vec<(usize, Gap)> {
    let mut gaps = gaps_along(points, triangles, &Outline::new(points.len(), triangles));
    gaps.retain(|&(index, gap)| gap.mm < Triangle::new(points, triangles[index]).gap().mm);
    gaps
}

/// The triangles, by ascending index, whose circumcentre lies beyond the outline, and upper bounds of their gaps: none is
/// above what their corners alone tell.
pub(crate) fn gaps_along(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    outline: &Outline,
) -> Vec<(usize, Gap)> {
    let on_outline = |corner: &VertexId| outline.passes[*corner as usize];
    let roots: Vec<(usize, Triangle)> = outline
        .triangles
        .iter()
        .map(|&index| (index, triangles[index]))
        .filter(|(_, corners)| corners.iter().filter(|&corner| on_outline(corner)).count() >= 2)
        .map(|(index, corners)| (index, flat(points, corners)))
        .filter(|(_, triangle)| {
            triangle.is_obtuse() && triangle.longest_side().iter().all(on_outline)
        })
        .collect();
    if roots.is_empty() {
        return Vec::new();
    }
    // What lies beneath a thin triangle is hardly ever more than two rings from the outline.
    let mut near = vec![false; points.len()];
    let mut ring: Vec<usize> = outline.triangles.clone();
    for _ in 0..MOST_RINGS {
        for corner in ring.iter().flat_map(|&index| triangles[index]) {
            near[corner as usize] = true;
        }
        let is_near = |index: &usize| triangles[*index].iter().any(|&corner| near[corner as usize]);
        let chosen: Vec<usize> =
            (0..triangles.len()).into_par_iter().with_min_len(CHUNK).filter(is_near).collect();
        let mesh = Adjacency::new(points.len(), triangles, chosen.iter().copied());
        let seen = Seen { mesh: &mesh, whole: |vertex: VertexId| near[vertex as usize] };
        let refined = refine_all(points, seen, &roots);
        match refined {
            Ok(refined) => return refined,
            Err(Unseen) => ring = chosen,
        }
    }
    let mesh = Adjacency::new(points.len(), triangles, 0..triangles.len());
    let seen = Seen { mesh: &mesh, whole: |_| true };
    refine_all(points, seen, &roots).expect("all triangles are seen")
}

/// What lies along the outline of a set of triangles.
pub(crate) struct Outline {
    /// Whether each point is an end of a side with a triangle on one side only.
    pub(crate) passes: Vec<bool>,
    /// Indices of the triangles with such a corner, ascending.
    pub(crate) triangles: Vec<usize>,
}

impl Outline {
    /// Linear time.
    pub(crate) fn new(points: usize, triangles: &[[VertexId; 3]]) -> Outline {
        let passes = on_outline(points, triangles);
        let along = |index: &usize| triangles[*index].iter().any(|&c| passes[c as usize]);
        let triangles = (0..triangles.len()).filter(along).collect();
        Outline { passes, triangles }
    }
}

/// Whether each point is an end of a side with a triangle on one side only.
///
/// About an inner vertex the opposite sides of its triangles close a ring: the differences between
/// the numbers of their ends cancel. About a vertex of the outline they leave the difference
/// between the two outline neighbours. Should several such differences cancel at a vertex where
/// parts of a filtered mesh meet, it is taken for an inner one and gaps there are not refined.
pub(crate) fn on_outline(points: usize, triangles: &[[VertexId; 3]]) -> Vec<bool> {
    // A single difference is zero modulo 2³² only if both numbers are equal.
    let mut left_over = vec![0_u32; points];
    for &[a, b, c] in triangles {
        for (vertex, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            let sum = &mut left_over[vertex as usize];
            *sum = sum.wrapping_add(to.wrapping_sub(from));
        }
    }
    left_over.into_iter().map(|difference| difference != 0).collect()
}

/// The outline of a mesh, counter-clockwise from its smallest vertex; none if it is not one closed
/// line that passes no vertex twice. Linear time but for sorting the sides about it.
pub(crate) fn hull(triangles: &[[VertexId; 3]], outline: &Outline) -> Option<Vec<VertexId>> {
    let mut candidates: Vec<[VertexId; 2]> = outline
        .triangles
        .iter()
        .flat_map(|&index| sides(triangles[index]))
        .filter(|side| side.iter().all(|&end| outline.passes[end as usize]))
        .collect();
    candidates.sort_unstable();
    let open: Vec<[VertexId; 2]> = candidates
        .iter()
        .copied()
        .filter(|&[p, q]| candidates.binary_search(&[q, p]).is_err())
        .collect();
    if open.len() < 3 || open.windows(2).any(|pair| pair[0][0] == pair[1][0]) {
        return None;
    }
    let mut hull = vec![open[0][0]];
    let mut at = open[0][1];
    while at != hull[0] && hull.len() < open.len() {
        hull.push(at);
        let next = open.binary_search_by_key(&at, |side| side[0]).ok()?;
        at = open[next][1];
    }
    (at == hull[0] && hull.len() == open.len()).then_some(hull)
}

/// The triangles of a Delaunay mesh, by ascending index, whose circumcentre in the plane lies beyond
/// the outline.
///
/// The circumcentre of an obtuse triangle lies beyond its longest side, and the triangle there has a
/// circumradius as large and its own circumcentre farther on. So from every triangle a chain over
/// longest sides leads to one that holds its circumcentre, or out of the mesh. These are the latter.
/// Linear time.
pub(crate) fn cut_by_outline(points: &[PointMm], triangles: &[[VertexId; 3]]) -> Vec<usize> {
    let outline = on_outline(points.len(), triangles);
    let flat = |index: usize| {
        let triangle = flat(points, triangles[index]);
        triangle.is_obtuse().then(|| (triangle.longest_side(), triangle.short_sides()))
    };
    let roots: Vec<usize> = (0..triangles.len())
        .filter(|&index| {
            let ends = triangles[index].iter().filter(|&&corner| outline[corner as usize]).count();
            ends >= 2
                && flat(index)
                    .is_some_and(|(longest, _)| longest.iter().all(|&end| outline[end as usize]))
        })
        .collect();
    if roots.is_empty() {
        return Vec::new();
    }
    let mesh = Adjacency::new(points.len(), triangles, 0..triangles.len());
    let across = |side| mesh.across(side, &|_| true).expect("all triangles are seen");
    let mut cut = Vec::new();
    for root in roots {
        let Some((outside, _)) = flat(root) else { continue };
        if across(outside).is_some() {
            continue;
        }
        let mut open = vec![(root, outside)];
        while let Some((index, through)) = open.pop() {
            if let Some((longest, short)) = flat(index)
                && longest == through
            {
                cut.push(index);
                for [from, to] in short {
                    if let Some(beneath) = across([from, to]) {
                        open.push((beneath, [to, from]));
                    }
                }
            }
        }
    }
    cut.sort_unstable();
    cut
}

/// How many rings about the outline are looked at before the whole mesh is.
const MOST_RINGS: usize = 6;
/// Triangles of which one thread takes care.
const CHUNK: usize = 1 << 14;

/// Which triangles each point is a corner of, as far as they were chosen.
struct Adjacency<'a> {
    triangles: &'a [[VertexId; 3]],
    /// The chosen triangles at point i are `incident[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    incident: Vec<u32>,
}

/// A triangle that was not chosen would have to be seen.
#[derive(Debug)]
struct Unseen;

/// Triangles, and what lies across their sides.
trait Sides {
    /// What a triangle goes by.
    type Name: Copy;

    fn corners(&self, triangle: Self::Name) -> [VertexId; 3];

    /// The triangle on the right of the side, if there is one.
    fn across(&mut self, side: [VertexId; 2]) -> Result<Option<Self::Name>, Unseen>;
}

/// A triangle reached from outside through one of its sides.
struct Reached<N> {
    name: N,
    /// From its corners alone.
    gap: Gap,
    /// Of its own slope.
    secant: f64,
    /// Which reached triangle it lies beneath.
    above: Option<usize>,
    /// Whether it is obtuse over the side it was reached through: its circumcentre lies beyond the outline.
    is_beyond: bool,
    /// If so, and if there are triangles beneath both its short sides: what leads there.
    way: Option<Way>,
}

/// The way across a thin triangle.
struct Way {
    /// In the plane.
    height_mm: f64,
    /// The larger gap of the triangles beneath its short sides.
    beneath: Gap,
    /// Secant of the steepest slope beneath.
    secant: f64,
}

impl Way {
    fn mm(&self) -> f64 {
        self.height_mm * self.secant + self.beneath.mm
    }
}

/// A triangle as it lies in the plane.
fn flat(points: &[PointMm], corners: [VertexId; 3]) -> Triangle {
    let place = |corner: VertexId| {
        let [x, y, _] = points[corner as usize];
        [x, y, 0.0]
    };
    Triangle::at_places(corners.map(place), corners)
}

/// Secant of the slope of a triangle: its area over that in the plane.
fn secant(triangle: &Triangle) -> f64 {
    triangle.area_mm2() / triangle.projected_area_mm2().max(f64::MIN_POSITIVE)
}

impl<'a> Adjacency<'a> {
    fn new(
        points: usize,
        triangles: &'a [[VertexId; 3]],
        chosen: impl ExactSizeIterator<Item = usize> + Clone,
    ) -> Adjacency<'a> {
        // While they are written, the next triangle at point i goes to `first[i + 1]`, which is where those of
        // point i + 1 begin afterwards.
        let mut first = vec![0_u32; points + 2];
        for index in chosen.clone() {
            triangles[index].iter().for_each(|&corner| first[corner as usize + 2] += 1);
        }
        for point in 0..points {
            first[point + 2] += first[point + 1];
        }
        let mut incident = vec![0; 3 * chosen.len()];
        for index in chosen {
            for &corner in &triangles[index] {
                let next = &mut first[corner as usize + 1];
                incident[*next as usize] = index as u32;
                *next += 1;
            }
        }
        Adjacency { triangles, first, incident }
    }

    /// The triangle on the right of the side, if there is one.
    fn across(
        &self,
        [from, to]: [VertexId; 2],
        whole: &impl Fn(VertexId) -> bool,
    ) -> Result<Option<usize>, Unseen> {
        if !(whole(from) || whole(to)) {
            return Err(Unseen);
        }
        let [from_here, to_here] = [0, 1].map(|next| self.first[to as usize + next] as usize);
        let mut incident = self.incident[from_here..to_here].iter().map(|&index| index as usize);
        Ok(incident.find(|&index| {
            let [a, b, c] = self.triangles[index];
            [[a, b], [b, c], [c, a]].contains(&[to, from])
        }))
    }
}

/// The chosen triangles, as far as all those about a vertex are among them.
struct Seen<'a, W> {
    mesh: &'a Adjacency<'a>,
    /// Of which vertices they are.
    whole: W,
}

impl<W: Fn(VertexId) -> bool> Sides for Seen<'_, W> {
    type Name = usize;

    fn corners(&self, triangle: usize) -> [VertexId; 3] {
        self.mesh.triangles[triangle]
    }

    fn across(&mut self, side: [VertexId; 2]) -> Result<Option<usize>, Unseen> {
        self.mesh.across(side, &self.whole)
    }
}

/// Refines the gaps of the roots that lie at the outline; they are told by index.
fn refine_all<W: Fn(VertexId) -> bool>(
    points: &[PointMm],
    mut seen: Seen<'_, W>,
    roots: &[(usize, Triangle)],
) -> Result<Vec<(usize, Gap)>, Unseen> {
    let mut refined = Vec::new();
    for &(index, triangle) in roots {
        if seen.across(triangle.longest_side())?.is_none() {
            refine(points, &mut seen, (index, triangle), &mut refined)?;
        }
    }
    refined.sort_unstable_by_key(|&(index, _)| index);
    Ok(refined)
}

/// Refines the gaps of `root`, in the plane, and of the thin triangles beneath it, without recursion: a chain
/// of them may be as long as the outline.
fn refine<S: Sides>(
    points: &[PointMm],
    mesh: &mut S,
    (name, root): (S::Name, Triangle),
    refined: &mut Vec<(S::Name, Gap)>,
) -> Result<(), Unseen> {
    let outside = root.longest_side();
    let mut reached: Vec<Reached<S::Name>> = Vec::new();
    let mut open = vec![(name, outside, None)];
    while let Some((name, through, above)) = open.pop() {
        let here = reached.len();
        let corners = mesh.corners(name);
        let (triangle, flat) = (Triangle::new(points, corners), flat(points, corners));
        let mut way = None;
        let is_beyond = flat.is_obtuse() && flat.longest_side() == through;
        if is_beyond {
            let [left_side, right_side] = flat.short_sides();
            let beneath = [mesh.across(left_side)?, mesh.across(right_side)?];
            if let [Some(left), Some(right)] = beneath {
                for (name, [from, to]) in [(left, left_side), (right, right_side)] {
                    open.push((name, [to, from], Some(here)));
                }
                let beneath = Gap { mm: 0.0, at_mm: [0.0; 3] };
                way = Some(Way { height_mm: flat.height_mm(), beneath, secant: 1.0 });
            }
        }
        let (gap, secant) = (triangle.gap(), secant(&triangle));
        reached.push(Reached { name, gap, secant, above, is_beyond, way });
    }
    // Whatever lies beneath a triangle was reached after it.
    while let Some(Reached { name, mut gap, mut secant, above, is_beyond, way }) = reached.pop() {
        if let Some(way) = way {
            // A chord stands as steep as may be.
            secant = way.secant;
            if way.mm() < gap.mm {
                gap = Gap { mm: way.mm(), at_mm: way.beneath.at_mm };
            }
        }
        if is_beyond {
            refined.push((name, gap));
        }
        if let Some(way) = above.and_then(|above| reached[above].way.as_mut()) {
            way.secant = way.secant.max(secant);
            if gap.mm > way.beneath.mm {
                way.beneath = gap;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use asphera_mesh::Mesh;

    use super::*;

    #[test]
    fn the_outline_of_a_fan() {
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
        let passes = |points, triangles: &[_]| Outline::new(points, triangles).passes;
        assert_eq!(passes(6, &triangles), [false, true, true, true, true, false]);
        assert_eq!(passes(5, &triangles[..2]), [true, true, true, true, false]);
        assert_eq!(Outline::new(5, &triangles[..2]).triangles, [0, 1]);
    }

    #[test]
    fn triangles_whose_circumcentre_lies_outside() {
        // A flat roof over a square: the roof is cut, and the square's triangles are right-angled.
        let points =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 5.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 1.1, 9.0]];
        let triangles = [[0, 1, 2], [0, 2, 3], [3, 2, 4]];
        assert_eq!(cut_by_outline(&points, &triangles), []);
        // Turned about its longest side to the inside, with the outline above.
        let points =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.9, 9.0]];
        let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        assert_eq!(cut_by_outline(&points, &triangles), [2]);
    }

    #[test]
    fn a_thin_triangle_takes_the_gap_beneath_it() {
        // A dent of 0.01 in the middle of the upper side of 6 × 1, over two right triangles.
        let points = [
            [0.0, 1.0, 0.0],
            [3.0, 0.99, 0.0],
            [6.0, 1.0, 0.0],
            [0.0, 0.0, 0.0],
            [3.0, 0.0, 0.0],
            [6.0, 0.0, 0.0],
        ];
        let triangles = [[0, 1, 2], [0, 3, 1], [3, 4, 1], [4, 2, 1], [4, 5, 2]];
        let own = Triangle::new(&points, triangles[0]).gap();
        let found = refined_gaps(&points, &triangles);
        assert!(found.is_empty(), "{found:?} from {own:?}: the gaps beneath are not smaller");
        // With samples in between on the line beneath, the neighbours' gaps are half as large.
        let mut points = points.to_vec();
        points.extend([[1.5, 0.99, 0.0], [4.5, 0.99, 0.0], [1.5, 0.0, 0.0], [4.5, 0.0, 0.0]]);
        let triangles = [
            [0, 1, 2],
            [0, 6, 1],
            [1, 7, 2],
            [0, 3, 6],
            [3, 8, 6],
            [8, 1, 6],
            [8, 4, 1],
            [4, 7, 1],
            [4, 9, 7],
            [9, 2, 7],
            [9, 5, 2],
        ];
        let found = refined_gaps(&points, &triangles);
        let indices: Vec<usize> = found.iter().map(|&(index, _)| index).collect();
        assert_eq!(indices, [0]);
        // The two thin ones beneath are as good as their own corners make them.
        let root = Triangle::new(&points, triangles[0]);
        let beneath = [1, 2].map(|i: usize| Triangle::new(&points, triangles[i]).gap().mm);
        assert_eq!(found[0].1.mm, root.height_mm() + beneath[0].max(beneath[1]));
        assert!(found[0].1.mm < 0.52 * own.mm, "{found:?}");
        // Bent along its outline the chord leaves the surface by 2 mm, but no sample is farther from another.
        points.iter_mut().for_each(|point| point[2] = (point[0] - 3.0).powi(2) / 4.5);
        let found = refined_gaps(&points, &triangles);
        assert_eq!(found.iter().map(|&(index, _)| index).collect::<Vec<_>>(), [0]);
        let steepest = (1.0_f64 + 1.0).sqrt();
        let beneath = [1, 2].map(|i: usize| Triangle::new(&points, triangles[i]).gap().mm);
        assert!(found[0].1.mm <= 0.01 * steepest + beneath[0].max(beneath[1]), "{found:?}");
        assert!(Triangle::new(&points, triangles[0]).gap().mm > 1.5 * found[0].1.mm);
    }

    /// Rows whose ends are out of line by about one part in a thousand.
    fn rough_rows(count: i32) -> Vec<PointMm> {
        let rough = |i: i32, j: i32| 1e-3 * f64::from((i * 7_919 + j * 104_729) % 101) / 101.0;
        let nodes = (0..count).flat_map(|j| (0..count).map(move |i| (i, j)));
        nodes
            .map(|(i, j)| [f64::from(i) + rough(i, j), f64::from(j) + rough(j, i + 50), 0.0])
            .collect()
    }

    #[test]
    fn no_place_of_a_thin_triangle_is_farther_from_all_samples() {
        let mut mesh = Mesh::new();
        mesh.extend(rough_rows(30));
        mesh.flush();
        let points = mesh.points();
        let triangles: Vec<[VertexId; 3]> = mesh.triangles();
        let found = refined_gaps(points, &triangles);
        assert!(found.len() > 20, "{}", found.len());
        for (index, gap) in found {
            let triangle = Triangle::new(points, triangles[index]);
            assert!(gap.mm < triangle.gap().mm && gap.mm < 0.75, "{gap:?}");
            let [p, q, r] = triangles[index].map(|corner| points[corner as usize]);
            for (u, v) in (0..=40).flat_map(|u| (0..=40 - u).map(move |v| (u, v))) {
                let (u, v) = (f64::from(u) / 40.0, f64::from(v) / 40.0);
                let place =
                    |axis: usize| p[axis] + u * (q[axis] - p[axis]) + v * (r[axis] - p[axis]);
                let nearest = points
                    .iter()
                    .map(|point| (point[0] - place(0)).hypot(point[1] - place(1)))
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest <= gap.mm * (1.0 + 1e-12), "{nearest} above {gap:?}");
            }
        }
    }
}
