//! A few of the vertices of a mesh, so near to all others as each of these allows.
//!
//! A vertex is covered where a chosen one lies within its own reach. Vertices are gone through in their order. For the first that
//! is not covered, one of the vertices within its reach is chosen: that which covers the most area that is not covered yet. So a
//! front moves over the surface and leaves few narrow strips. At the end those go that the others make needless.
//!
//! What a vertex covers is found by going from it along edges through vertices that it covers. So another sheet that is near
//! in space counts for nothing.

use asphera_geometry::PointMm;
use asphera_geometry::vector::{length, minus};

/// Vertices joined by edges.
pub(super) struct Joined {
    first: Vec<u32>,
    ends: Vec<u32>,
}

impl Joined {
    /// The vertices joined by the edges of some lines or facets.
    pub(super) fn by(vertices: usize, edges: impl Iterator<Item = [u32; 2]>) -> Joined {
        let mut pairs: Vec<[u32; 2]> = edges.flat_map(|[a, b]| [[a, b], [b, a]]).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut first = vec![0; vertices + 1];
        for [from, _] in &pairs {
            first[*from as usize + 1] += 1;
        }
        for at in 0..vertices {
            first[at + 1] += first[at];
        }
        Joined { first, ends: pairs.into_iter().map(|[_, to]| to).collect() }
    }

    pub(super) fn of(&self, vertex: u32) -> &[u32] {
        let [from, to] = [vertex, vertex + 1].map(|at| self.first[at as usize] as usize);
        &self.ends[from..to]
    }
}

/// Vertices to be covered.
pub(super) struct Cover<'a> {
    places: &'a [PointMm],
    /// How far the nearest chosen vertex may be from each.
    reach_mm: &'a [f64],
    /// What each is worth, as its area.
    worth: &'a [f64],
    /// By how many chosen ones each is covered.
    times: Vec<u32>,
    /// The last search that met each vertex, and the number of the newest.
    met: Vec<u32>,
    search: u32,
}

impl<'a> Cover<'a> {
    pub(super) fn new(places: &'a [PointMm], reach_mm: &'a [f64], worth: &'a [f64]) -> Cover<'a> {
        let count = places.len();
        Cover { places, reach_mm, worth, times: vec![0; count], met: vec![0; count], search: 0 }
    }

    /// Counts what vertices that were chosen before cover.
    pub(super) fn add(&mut self, chosen: &[u32], joined: &Joined) {
        let mut covered = Vec::new();
        for &vertex in chosen {
            self.from(vertex, joined, &mut covered);
            covered.iter().for_each(|&at| self.times[at as usize] += 1);
        }
    }

    /// Chooses vertices until all of `wanted` are covered, ascending; the vertices joined are those to choose from.
    pub(super) fn choose(
        &mut self,
        joined: &Joined,
        wanted: impl Iterator<Item = u32>,
    ) -> Vec<u32> {
        let mut chosen = Vec::new();
        let (mut about, mut covered) = (Vec::new(), Vec::new());
        for vertex in wanted {
            if self.times[vertex as usize] > 0 {
                continue;
            }
            self.within_reach_of(vertex, joined, &mut about);
            let step = about.len().div_ceil(MOST_TRIED);
            let mut best = (0.0, vertex);
            for &candidate in about.iter().step_by(step) {
                self.from(candidate, joined, &mut covered);
                let open = covered.iter().filter(|&&at| self.times[at as usize] == 0);
                let gain: f64 = open.map(|&at| self.worth[at as usize]).sum();
                if covered.contains(&vertex) && gain > best.0 {
                    best = (gain, candidate);
                }
            }
            self.from(best.1, joined, &mut covered);
            covered.iter().for_each(|&at| self.times[at as usize] += 1);
            chosen.push(best.1);
        }
        self.drop_needless(&mut chosen, joined);
        chosen.sort_unstable();
        chosen
    }

    /// Leaves out what the others cover, the last chosen first.
    fn drop_needless(&mut self, chosen: &mut Vec<u32>, joined: &Joined) {
        let mut covered = Vec::new();
        let mut left = Vec::with_capacity(chosen.len());
        for &vertex in chosen.iter().rev() {
            self.from(vertex, joined, &mut covered);
            if covered.iter().all(|&at| self.times[at as usize] > 1) {
                covered.iter().for_each(|&at| self.times[at as usize] -= 1);
            } else {
                left.push(vertex);
            }
        }
        *chosen = left;
    }

    /// All that a vertex would cover, itself first.
    fn from(&mut self, start: u32, joined: &Joined, found: &mut Vec<u32>) {
        self.walk(start, joined, found, |reach_mm, at, _| reach_mm[at as usize]);
    }

    /// All from which a vertex would be covered, itself first.
    fn within_reach_of(&mut self, start: u32, joined: &Joined, found: &mut Vec<u32>) {
        self.walk(start, joined, found, |reach_mm, _, start| reach_mm[start as usize]);
    }

    fn walk(
        &mut self,
        start: u32,
        joined: &Joined,
        found: &mut Vec<u32>,
        limit_mm: impl Fn(&[f64], u32, u32) -> f64,
    ) {
        self.search += 1;
        found.clear();
        found.push(start);
        self.met[start as usize] = self.search;
        let centre = self.places[start as usize];
        let mut next = 0;
        while let Some(&at) = found.get(next) {
            next += 1;
            for &end in joined.of(at) {
                if self.met[end as usize] == self.search {
                    continue;
                }
                self.met[end as usize] = self.search;
                let way_mm = length(minus(self.places[end as usize], centre));
                if way_mm <= limit_mm(self.reach_mm, end, start) {
                    found.push(end);
                }
            }
        }
    }
}

/// Vertices that are tried for one that is to be covered.
const MOST_TRIED: usize = 48;

#[cfg(test)]
mod tests {
    use super::*;

    /// A square lattice of 1 mm.
    fn lattice(side: u32) -> (Vec<PointMm>, Joined) {
        let places = (0..side * side)
            .map(|at| [f64::from(at / side), f64::from(at % side), 0.0])
            .collect::<Vec<PointMm>>();
        let edges = (0..side * side).flat_map(move |at| {
            let right = (at % side + 1 < side).then_some([at, at + 1]);
            let up = (at / side + 1 < side).then_some([at, at + side]);
            right.into_iter().chain(up)
        });
        let joined = Joined::by(places.len(), edges);
        (places, joined)
    }

    #[test]
    fn a_lattice_is_covered_by_not_many_more_than_a_packing_needs() {
        let (places, joined) = lattice(60);
        let count = places.len();
        for reach_mm in [0.0, 1.0, 3.0, 8.5] {
            let (reaches, worth) = (vec![reach_mm; count], vec![1.0; count]);
            let mut cover = Cover::new(&places, &reaches, &worth);
            let chosen = cover.choose(&joined, 0..count as u32);
            assert!(chosen.is_sorted());
            let away = |at: &PointMm| {
                let of = |&vertex: &u32| length(minus(places[vertex as usize], *at));
                chosen.iter().map(of).fold(f64::INFINITY, f64::min)
            };
            assert!(places.iter().all(|at| away(at) <= reach_mm), "{reach_mm}");
            // As many places as a disc of that radius holds, and the best cover of the plane by discs, 1.21.
            let held = (-9_i32..=9).flat_map(|x| (-9_i32..=9).map(move |y| x * x + y * y));
            let held = held.filter(|&square| f64::from(square) <= reach_mm * reach_mm).count();
            let least = count as f64 / held as f64;
            let times = chosen.len() as f64 / least;
            assert!((1.0..2.2).contains(&times), "{reach_mm}: {times}");
        }
    }

    #[test]
    fn nothing_is_covered_from_another_sheet() {
        // Two lines 0.1 mm apart.
        let places: Vec<PointMm> =
            (0..20).map(|at| [f64::from(at % 10), 0.1 * f64::from(at / 10), 0.0]).collect();
        let edges = (0..19_u32).filter(|at| at % 10 != 9).map(|at| [at, at + 1]);
        let joined = Joined::by(20, edges);
        let (reaches, worth) = ([4.6; 20], [1.0; 20]);
        let mut cover = Cover::new(&places, &reaches, &worth);
        let chosen = cover.choose(&joined, 0..20);
        assert_eq!(chosen.iter().filter(|&&at| at < 10).count(), 1 + usize::from(chosen.len() > 2));
        assert!(chosen.iter().any(|&at| at >= 10));
        // What was chosen before counts.
        let mut cover = Cover::new(&places, &reaches, &worth);
        cover.add(&[4], &joined);
        assert!(cover.choose(&joined, 0..20).iter().all(|&at| at == 9 || at >= 10));
    }
}
