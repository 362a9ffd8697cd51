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
}

/// The pieces of a level by the ends of links across it.
#[derive(Default)]
struct Level {
    /// Positions that are ends, in the order in which they are met.
    ends: Vec<u32>,
    piece_of_end: Vec<u32>,
    pieces: u32,
}

impl Linked<'_> {
    /// The thin strips from one to another. Time grows with links times the levels that each crosses.
    pub(crate) fn thin_strips(&self, strips: std::ops::Range<u32>) -> Vec<ThinStrip> {
        let first = self.first_of(strips.start.saturating_sub(self.span));
        let end = self.first_of(strips.end.saturating_add(self.span));
        let mut index = [vec![NONE; end - first], vec![NONE; end - first]];
        let mut active = Vec::new();
        let early = strips.start.saturating_sub(self.span)..strips.start;
        self.start_links(early, strips.start, &mut active);
        let mut below = self.level(strips.start, &active, first, &mut index[0]);
        let mut found = Vec::with_capacity(strips.len());
        for strip in strips {
            active.retain(|link| self.strip(link[1]) > strip);
            self.start_links(strip..strip + 1, strip + 1, &mut active);
            let above = self.level(strip + 1, &active, first, &mut index[1]);
            found.push(self.between(strip, [&below, &above], first, &index));
            below.ends.iter().for_each(|&end| index[0][end as usize - first] = NONE);
            index.swap(0, 1);
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
    fn start_links(&self, strips: std::ops::Range<u32>, level: u32, active: &mut Vec<[u32; 2]>) {
        let crossing = self.links_from(strips).iter().filter(|link| self.strip(link[1]) >= level);
        active.extend(crossing);
    }

    /// The pieces of the level below strip `level`, none of level 0. `index` numbers the ends.
    fn level(&self, level: u32, active: &[[u32; 2]], first: usize, index: &mut [u32]) -> Level {
        let mut ends = Vec::new();
        if level == 0 {
            return Level::default();
        }
        for link in active {
            for &end in link {
                let number = &mut index[end as usize - first];
                if *number == NONE {
                    *number = ends.len() as u32;
                    ends.push(end);
                }
            }
        }
        let number = |end: u32| index[end as usize - first] as usize;
        let mut sets = Sets::new(ends.len());
        active.iter().for_each(|&[a, b]| {
            sets.join(number(a), number(b));
        });
        let (piece_of_end, pieces) = sets.numbered();
        Level { ends, piece_of_end, pieces }
    }

    /// The pieces of a strip between two levels.
    fn between(
        &self,
        strip: u32,
        [below, above]: [&Level; 2],
        first: usize,
        index: &[Vec<u32>; 2],
    ) -> ThinStrip {
        let own = self.first_of(strip)..self.first_of(strip + 1);
        let levels = (below.pieces + above.pieces) as usize;
        let mut sets = Sets::new(levels + own.len());
        let piece = |level: usize, position: u32| {
            let number = index[level][position as usize - first];
            let of = [below, above][level];
            let skipped = if level == 0 { 0 } else { below.pieces };
            (number != NONE).then(|| (skipped + of.piece_of_end[number as usize]) as usize)
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
        let ends = |level: &Level, skipped: u32| {
            let of = level.piece_of_end.iter().zip(&level.ends);
            of.map(move |(&piece, &end)| ((skipped + piece) as usize, end)).collect::<Vec<_>>()
        };
        let positions = own.enumerate().map(|(at, position)| (levels + at, position as u32));
        let ends = [ends(below, 0), ends(above, below.pieces)].concat();
        for (member, position) in positions.chain(ends) {
            let known = &mut pieces[piece_of[member] as usize];
            *known = (*known).min(position);
        }
        let (of_below, rest) = piece_of.split_at(below.pieces as usize);
        let above = rest[..above.pieces as usize].to_vec();
        ThinStrip { pieces, below: of_below.to_vec(), above }
    }
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
                let own = &found[strip as usize];
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
                assert_eq!(own.above, alone.above);
            }
        }
    }
}
