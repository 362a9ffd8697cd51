//! Level sets of a function over links: what of a level hangs together, and how that changes from level to level.
//!
//! Levels lie between thin strips. A link crosses the levels between the strips of its ends. Links across a level that share an
//! end belong to one piece of that level: such a piece takes no width, so a hole shows that is open over less than a strip of
//! the graph. The pieces of two consecutive levels meet in the thin strip between them.

use asphera_geometry::Sets;

/// Links between positions, which are sorted by strip.
pub(crate) struct Linked<'a> {
    /// Both positions, that in the lower strip first, sorted.
    pub(crate) links: &'a [[u32; 2]],
    /// The strip of each position, ascending.
    pub(crate) strip_of: &'a [u32],
    /// The most strips that a link leads up.
    pub(crate) span: u32,
}

/// A thin strip: pieces of it, and those of the levels at its lower and its upper bound.
#[derive(Clone, Debug, Default)]
pub(crate) struct ThinStrip {
    /// A position of each piece, the first one.
    pub(crate) pieces: Vec<u32>,
    /// The piece that each piece of the level below lies in.
    pub(crate) below: Vec<u32>,
    /// The piece that each piece of the level above lies in.
    pub(crate) above: Vec<u32>,
    /// The piece of each position of the strip.
    pub(crate) own: Vec<u32>,
}

/// The pieces of a level by the ends of links across it.
#[derive(Default)]
struct Level {
    /// Positions that are ends, in the order in which they are met.
    ends: Vec<u32>,
    /// The first position of each piece.
    firsts: Vec<u32>,
}

/// A link across a level.
struct Crossing {
    ends: [u32; 2],
    /// The strip of its upper end.
    until: u32,
}

/// What is known of positions about some strips.
struct Known {
    /// The first of these positions.
    first: usize,
    /// The piece of each position in the level below and in the one above.
    pieces: [Vec<u32>; 2],
    /// Positions above each other in the set that it belongs to while a level is made.
    parents: Vec<u32>,
}

impl Known {
    fn piece(&self, level: usize, position: u32) -> Option<u32> {
        let piece = self.pieces[level][position as usize - self.first];
        (piece != NONE).then_some(piece)
    }

    /// The root of a position's set (path halving); a set of its own for one that is met for the first time.
    fn root(&mut self, position: usize, ends: &mut Vec<u32>) -> usize {
        if self.parents[position] == NONE {
            self.parents[position] = position as u32;
            ends.push((self.first + position) as u32);
            return position;
        }
        let mut at = position;
        while self.parents[at] as usize != at {
            self.parents[at] = self.parents[self.parents[at] as usize];
            at = self.parents[at] as usize;
        }
        at
    }
}

impl Linked<'_> {
    /// The thin strips from one to another. Time grows with links times the levels that each crosses.
    pub(crate) fn thin_strips(&self, strips: std::ops::Range<u32>) -> Vec<ThinStrip> {
        let first = self.first_of(strips.start.saturating_sub(self.span));
        let end = self.first_of(strips.end.saturating_add(self.span));
        let none = vec![NONE; end - first];
        let pieces = [none.clone(), none.clone()];
        let mut known = Known { first, pieces, parents: none };
        let mut active = Vec::new();
        let early = strips.start.saturating_sub(self.span)..strips.start;
        self.start_links(early, strips.start, &mut active);
        let mut below = level(strips.start, &active, 0, &mut known);
        let mut found = Vec::with_capacity(strips.len());
        for strip in strips {
            active.retain(|link| link.until > strip);
            self.start_links(strip..strip + 1, strip + 1, &mut active);
            let above = level(strip + 1, &active, 1, &mut known);
            found.push(self.between(strip, [&below, &above], &known));
            below.ends.iter().for_each(|&end| known.pieces[0][end as usize - first] = NONE);
            known.pieces.swap(0, 1);
            below = above;
        }
        found
    }

    fn strip(&self, position: u32) -> u32 {
        self.strip_of[position as usize]
    }

    fn first_of(&self, strip: u32) -> usize {
        self.strip_of.partition_point(|&other| other < strip)
    }

    fn links_from(&self, strips: std::ops::Range<u32>) -> &[[u32; 2]] {
        let at = |strip| self.links.partition_point(|link| self.strip(link[0]) < strip);
        &self.links[at(strips.start)..at(strips.end)]
    }

    /// Adds the links that begin in some strips and cross a level.
    fn start_links(&self, strips: std::ops::Range<u32>, level: u32, active: &mut Vec<Crossing>) {
        let links = self.links_from(strips).iter();
        let crossing = links.map(|&ends| Crossing { ends, until: self.strip(ends[1]) });
        active.extend(crossing.filter(|link| link.until >= level));
    }

    /// The pieces of a strip between two levels.
    fn between(&self, strip: u32, [below, above]: [&Level; 2], known: &Known) -> ThinStrip {
        let own = self.first_of(strip)..self.first_of(strip + 1);
        let skipped = [0, below.firsts.len() as u32];
        let levels = below.firsts.len() + above.firsts.len();
        let mut sets = Sets::new(levels + own.len());
        let piece = |level: usize, position: u32| {
            known.piece(level, position).map(|piece| (skipped[level] + piece) as usize)
        };
        for &end in &above.ends {
            if let (Some(a), Some(b)) = (piece(0, end), piece(1, end)) {
                sets.join(a, b);
            }
        }
        for (at, position) in own.clone().enumerate() {
            let pieces = [0, 1].map(|level| piece(level, position as u32));
            pieces.into_iter().flatten().for_each(|piece| {
                sets.join(levels + at, piece);
            });
        }
        let inner = self.links_from(strip..strip + 1);
        for &[a, b] in inner.iter().filter(|link| self.strip(link[1]) == strip) {
            let [a, b] = [a, b].map(|position| levels + position as usize - own.start);
            sets.join(a, b);
        }
        let (piece_of, count) = sets.numbered();
        let mut pieces = vec![NONE; count as usize];
        let firsts = below.firsts.iter().chain(&above.firsts).copied();
        for (&piece, position) in piece_of.iter().zip(firsts.chain(own.map(|at| at as u32))) {
            let first = &mut pieces[piece as usize];
            *first = (*first).min(position);
        }
        let (of_below, others) = piece_of.split_at(below.firsts.len());
        let (of_above, of_own) = others.split_at(above.firsts.len());
        let [below, above, own] = [of_below, of_above, of_own].map(<[u32]>::to_vec);
        ThinStrip { pieces, below, above, own }
    }
}

/// The pieces of the level below strip `level`, none of level 0. They are numbered by the order in which their ends are met, and
/// `known` has the piece of each end afterwards.
fn level(level: u32, active: &[Crossing], side: usize, known: &mut Known) -> Level {
    let (mut ends, mut firsts) = (Vec::new(), Vec::new());
    if level == 0 {
        return Level::default();
    }
    let first = known.first;
    // Links of the same lower end follow one another, and all its upper ends join the same set.
    let mut last = (NONE, 0);
    for link in active {
        let [a, b] = link.ends;
        if a != last.0 {
            last = (a, known.root(a as usize - first, &mut ends));
        }
        let root = known.root(b as usize - first, &mut ends);
        known.parents[root] = last.1 as u32;
    }
    for &end in &ends {
        let root = known.root(end as usize - first, &mut Vec::new());
        let piece = &mut known.pieces[side][root];
        if *piece == NONE {
            *piece = firsts.len() as u32;
            firsts.push(end);
        }
        let piece = *piece;
        known.pieces[side][end as usize - first] = piece;
        firsts[piece as usize] = firsts[piece as usize].min(end);
    }
    ends.iter().for_each(|&end| known.parents[end as usize - first] = NONE);
    Level { ends, firsts }
}

/// No number.
const NONE: u32 = u32::MAX;

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Sets of links and positions that share an end, by the definition: joined until nothing changes.
    fn joined(links: &[[u32; 2]], positions: &[u32]) -> Vec<BTreeSet<u32>> {
        let alone = positions.iter().map(|&position| BTreeSet::from([position]));
        let mut sets: Vec<BTreeSet<u32>> =
            links.iter().map(|&link| BTreeSet::from(link)).chain(alone).collect();
        while let Some((a, b)) = (0..sets.len())
            .flat_map(|b| (0..b).map(move |a| (a, b)))
            .find(|&(a, b)| !sets[a].is_disjoint(&sets[b]))
        {
            let gone = sets.swap_remove(b);
            sets[a].extend(gone);
        }
        sets
    }

    #[test]
    fn pieces_are_those_of_the_definition() {
        // A generator of numbers at random (Knuth's constants).
        let mut state = 7_u64;
        let mut below = |count: u32| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % u64::from(count)) as u32
        };
        for _ in 0..30 {
            let mut strip_of: Vec<u32> = (0..40).map(|_| below(12)).collect();
            strip_of.sort_unstable();
            let mut links: Vec<[u32; 2]> = (0..45)
                .map(|_| [below(40), below(40)])
                .filter(|[a, b]| {
                    a != b && strip_of[*a as usize].abs_diff(strip_of[*b as usize]) < 4
                })
                .map(|[a, b]| [a.min(b), a.max(b)])
                .collect();
            links.sort_unstable();
            links.dedup();
            let linked = Linked { links: &links, strip_of: &strip_of, span: 3 };
            let found = linked.thin_strips(0..12);
            let parted: Vec<ThinStrip> =
                (0..12).flat_map(|strip| linked.thin_strips(strip..strip + 1)).collect();
            for strip in 0..12_u32 {
                let of = |end: u32| strip_of[end as usize];
                let across = |level: u32| -> Vec<[u32; 2]> {
                    let is_across = |link: &&[u32; 2]| of(link[0]) < level && level <= of(link[1]);
                    links.iter().filter(is_across).copied().collect()
                };
                let inner = links.iter().filter(|[a, b]| of(*a) == strip && of(*b) == strip);
                let all: Vec<[u32; 2]> = [across(strip), across(strip + 1)]
                    .concat()
                    .into_iter()
                    .chain(inner.copied())
                    .collect();
                let own: Vec<u32> = (0..40).filter(|&position| of(position) == strip).collect();
                let pieces = joined(&all, &own);
                let at = own.clone();
                let own = &found[strip as usize];
                for (&position, &piece) in at.iter().zip(&own.own) {
                    let holder = pieces.iter().find(|piece| piece.contains(&position)).unwrap();
                    assert_eq!(own.pieces[piece as usize], *holder.first().unwrap());
                }
                let mut firsts: Vec<u32> = own.pieces.clone();
                firsts.sort_unstable();
                let mut expected: Vec<u32> =
                    pieces.iter().filter_map(|piece| piece.first().copied()).collect();
                expected.sort_unstable();
                assert_eq!(firsts, expected);
                for (level, of_level) in [(strip, &own.below), (strip + 1, &own.above)] {
                    let on_level = joined(&across(level), &[]);
                    assert_eq!(of_level.len(), on_level.len());
                    let mut under: Vec<u32> =
                        of_level.iter().map(|&piece| own.pieces[piece as usize]).collect();
                    under.sort_unstable();
                    let holder = |of: &BTreeSet<u32>| {
                        let piece = pieces.iter().find(|piece| piece.is_superset(of)).unwrap();
                        *piece.first().unwrap()
                    };
                    let mut expected: Vec<u32> = on_level.iter().map(holder).collect();
                    expected.sort_unstable();
                    assert_eq!(under, expected);
                }
                let alone = &parted[strip as usize];
                assert_eq!((&own.pieces, &own.below), (&alone.pieces, &alone.below));
                assert_eq!((&own.above, &own.own), (&alone.above, &alone.own));
            }
        }
    }
}
