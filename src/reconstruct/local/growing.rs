//! The surface while points arrive: what a batch changes is made anew, and nothing else.
//!
//! Every figure of a point is a function of the points within a distance that it knows: its nearest neighbours, its plane, its star.
//! So a batch asks only the points that see a new place, then the stars that asked for a plane that changed, then the facets of
//! stars that changed, then the holes about these. [`local`](super::local()) is this, with one batch.

use std::collections::HashMap;

use asphera_geometry::{BoxMm, PointMm};
use rayon::prelude::*;

use super::mend::Mending;
use super::near_lists::{self, NearList, NearLists};
use super::normals::{self, NEAREST, Places as _, TangentPlane};
use super::place_tree::{Inserted, LEAF, NewInLeaf, PlaceTree, Sight};
use super::stars::{self, Exchange, Facet, Stars, sort, sorted};
use super::{MOST_POINTS, TooManyPoints};
use crate::geometry::{gap, squared};
use crate::surface::{LeftOut, Numbered, as_place};

/// A surface by local stars that takes points in batches.
///
/// After every batch it is the surface that [`local`](super::local()) makes of the same points at once, bit for bit: batches and
/// threads change nothing. A batch costs time in proportion to its points and to those within a few spacings of them. Some 240
/// bytes a point.
#[derive(Clone, Debug, Default)]
pub struct LocalSurface {
    received: usize,
    pub(super) tree: PlaceTree,
    pub(super) near: NearLists,
    pub(super) planes: Vec<Option<TangentPlane>>,
    /// For each point the square of the distance of the farthest plane that its star asked for, mm²; below 0 where none was.
    pub(super) asked_mm2: Vec<f64>,
    /// Whether a star has asked for the plane of a point. Few do: where four points are bent.
    pub(super) is_asked: Vec<bool>,
    /// For a point those that asked for its plane without being among its nearest.
    pub(super) strangers: HashMap<u32, Vec<u32>>,
    pub(super) stars: Stars,
    /// Points whose stars are in doubt.
    pub(super) listed: Listed,
    pub(super) mending: Mending,
    /// Points without a place of their own.
    pub(super) left_out: Vec<(u32, LeftOut)>,
}

/// Facets that a batch changed, by numbers of points in ascending order. They are not turned.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FacetChanges {
    /// Facets that are in the surface now and were not before.
    pub added: Vec<[u32; 3]>,
    /// Facets that were in the surface and are no more.
    pub removed: Vec<[u32; 3]>,
}

/// An earlier point and new ones of a leaf within the sight of its plane: in one number, that of the earlier point first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Seen(u64);

impl Seen {
    /// The new points are bits of a mask, from the first of their leaf on.
    fn new(earlier: u32, from: u32, mask: u64) -> Seen {
        Seen(u64::from(earlier) << 40 | u64::from(from) << 16 | mask)
    }

    fn earlier(self) -> u32 {
        (self.0 >> 40) as u32
    }

    /// The new points, in ascending order.
    fn points(self) -> impl Iterator<Item = u32> {
        let (from, mask) = ((self.0 >> 16) as u32 & NUMBER, self.0 as u16);
        let without_first = |&mask: &u16| Some(mask & (mask - 1)).filter(|&mask| mask > 0);
        std::iter::successors(Some(mask), without_first)
            .map(move |mask| from + mask.trailing_zeros())
    }
}

/// Stands for the place of a point that has none.
const NO_PLACE: PointMm = [f64::NAN; 3];

/// Fewer points than twice as many are placed by one thread.
const SHARED: usize = 4096;

/// The bits of a number of a point.
const NUMBER: u32 = (1 << 24) - 1;
const _: () =
    assert!(MOST_POINTS <= NUMBER as usize && LEAF <= 16, "one number must hold them all");

/// Answers to the new points of some leaves, beside their lists.
#[derive(Default)]
struct Asked {
    seen: Vec<Seen>,
    /// Earlier points whose stars may change.
    stars: Vec<u32>,
}

impl Asked {
    /// Asks for new points of a leaf: together, or one by one where they lie far from each other.
    fn ask(
        &mut self,
        tree: &PlaceTree,
        new: NewInLeaf,
        room: &mut near_lists::Room,
        lists: &mut [NearList],
    ) {
        if near_lists::ask_together(tree, new, room, lists) {
            self.see(tree, new);
        } else {
            for (at, list) in (new.from..new.to).zip(lists.chunks_mut(1)) {
                self.ask(tree, NewInLeaf { from: at, to: at + 1 }, room, list);
            }
        }
    }

    /// Finds the earlier points that see the new points of a leaf.
    fn see(&mut self, tree: &PlaceTree, new: NewInLeaf) {
        if tree.is_blind(&NEW_PLACE) {
            return;
        }
        let points_mm = tree.points_mm();
        let own = tree.about(new.from..new.to);
        tree.seeing(&NEW_PLACE, &own, &mut |at| {
            let place = points_mm[at as usize];
            let any = tree.sight_mm2(at, &NEW_PLACE);
            if gap(&BoxMm { low: place, high: place }, &own) * (1.0 - 1e-12) > any {
                return;
            }
            let plane = tree.sight_mm2(at, &[Sight::Plane]);
            let (mut is_seen, mut mask) = (false, 0);
            for number in (new.from..new.to).rev() {
                let square = squared(place, points_mm[number as usize]);
                is_seen |= square <= any;
                mask = mask << 1 | u64::from(square <= plane);
            }
            if is_seen {
                self.stars.push(at);
            }
            if mask > 0 {
                self.seen.push(Seen::new(at, new.from, mask));
            }
        });
    }
}

/// Points to ask again after a batch.
#[derive(Default)]
pub(super) struct Doubts {
    /// The first of the new points: they all are asked.
    pub(super) first_new: u32,
    /// Earlier points whose planes may change.
    pub(super) planes: Vec<u32>,
    /// Points whose stars may change, each once, in any order; the new ones too.
    pub(super) stars: Vec<u32>,
    /// Room for what leaves a list of neighbours.
    lost: Vec<u32>,
}

/// Marks of points, by the number of a list, so that each is in it once.
#[derive(Clone, Debug, Default)]
pub(super) struct Listed {
    list: u32,
    last: Vec<u32>,
}

impl Listed {
    /// Begins a list of some of so many points.
    pub(super) fn begin(&mut self, points: usize) {
        self.list += 1;
        self.last.resize(points, 0);
    }

    /// Adds points to the list that are not in it.
    pub(super) fn add(&mut self, to: &mut Vec<u32>, points: impl IntoIterator<Item = u32>) {
        to.extend(points.into_iter().filter(|&at| {
            let last = &mut self.last[at as usize];
            std::mem::replace(last, self.list) != self.list
        }));
    }

    pub(super) fn mark(&mut self, at: u32) {
        self.last[at as usize] = self.list;
    }

    pub(super) fn has(&self, at: u32) -> bool {
        self.last[at as usize] == self.list
    }
}

impl LocalSurface {
    /// A surface without points.
    pub fn new() -> LocalSurface {
        LocalSurface::default()
    }

    /// How many points were taken.
    pub fn received(&self) -> usize {
        self.received
    }

    /// Takes points. They are numbered on from those before.
    ///
    /// # Errors
    ///
    /// More than [`MOST_POINTS`] points in all; then none of these is taken.
    pub fn insert(&mut self, points_mm: &[PointMm]) -> Result<FacetChanges, TooManyPoints> {
        let exchange = self.take(points_mm, true)?;
        let numbered = |facets: Vec<Facet>| {
            let ids = |facet: Facet| sorted(facet.map(|corner| self.tree.ids[corner as usize]));
            let mut facets: Vec<Facet> = facets.into_iter().map(ids).collect();
            stars::sort_facets(&mut facets);
            facets
        };
        let Exchange { added, removed } = exchange;
        Ok(FacetChanges { added: numbered(added), removed: numbered(removed) })
    }

    /// Takes points; gives what changed, by numbers of the tree. Facets of a first batch are not listed where nobody `asks`.
    pub(super) fn take(
        &mut self,
        points_mm: &[PointMm],
        asks: bool,
    ) -> Result<Exchange, TooManyPoints> {
        let first = self.received;
        let received = first + points_mm.len();
        if received > MOST_POINTS {
            return Err(TooManyPoints { found: received });
        }
        self.received = received;
        let place =
            |(&point, number): (&PointMm, u32)| (as_place(point).unwrap_or(NO_PLACE), number);
        let numbers = first as u32..received as u32;
        let mut batch: Vec<Numbered> =
            points_mm.par_iter().zip(numbers).with_min_len(SHARED).map(place).collect();
        let has_place = |&(place, _): &Numbered| !place[0].is_nan();
        if !batch.par_iter().with_min_len(SHARED).all(has_place) {
            let without = batch.iter().filter(|one| !has_place(one));
            self.left_out.extend(without.map(|&(_, number)| (number, LeftOut::NoPlace)));
            batch.retain(has_place);
        }
        let inserted = self.tree.insert(&mut batch);
        drop(batch);
        let duplicates = inserted.duplicates.iter().map(|&id| (id, LeftOut::Duplicate));
        self.left_out.extend(duplicates);
        if inserted.leaves.is_empty() {
            return Ok(Exchange::default());
        }
        let doubts = self.doubts(&inserted);
        let changed = self.fit_planes(doubts);
        Ok(self.make_stars(changed, asks))
    }

    /// Gives back the memory of what only further points would need.
    pub(super) fn forget_neighbours(&mut self) {
        self.near = NearLists::default();
        self.asked_mm2 = Vec::new();
        self.is_asked = Vec::new();
        self.tree.forget_nodes();
    }

    /// Finds the neighbours of new points, and the points that see these.
    fn doubts(&mut self, inserted: &Inserted) -> Doubts {
        let first_new = self.planes.len() as u32;
        let mut doubts = Doubts { first_new, ..Doubts::default() };
        self.listed.begin(self.tree.len());
        let mut seen = Vec::new();
        let mut lists = self.near.grow(self.tree.len());
        for leaves in inserted.leaves.chunks(LEAVES_HELD) {
            for Asked { seen: own, stars } in asked(&self.tree, leaves, &mut lists) {
                seen.extend(own);
                self.listed.add(&mut doubts.stars, stars);
            }
        }
        sort(&mut seen);
        for group in seen.chunk_by(|a, b| a.earlier() == b.earlier()) {
            self.take_new(group, &mut doubts);
        }
        grow(&mut self.planes, self.tree.len(), || None);
        grow(&mut self.asked_mm2, self.tree.len(), || -1.0);
        grow(&mut self.is_asked, self.tree.len(), || false);
        self.stars.grow(self.tree.len());
        self.listed.add(&mut doubts.stars, first_new..self.tree.len() as u32);
        doubts
    }

    /// Takes new points into the list of an earlier point that sees them.
    fn take_new(&mut self, group: &[Seen], doubts: &mut Doubts) {
        let at = group[0].earlier();
        let LocalSurface { tree, near, .. } = self;
        let lost = &mut doubts.lost;
        lost.clear();
        let is_changed = near.take(tree, at, group.iter().flat_map(|seen| seen.points()), lost);
        let own = near.of(at);
        let far_mm2 = own.last().map_or(0.0, |&far| {
            squared(tree.points_mm()[at as usize], tree.points_mm()[far as usize])
        });
        let is_whole = own.len() == NEAREST;
        if is_changed || !is_whole || !normals::is_of_nearest(self.planes[at as usize], far_mm2) {
            doubts.planes.push(at);
        }
        if self.is_asked[at as usize] {
            // They asked for this plane and are no more told by the list: they ask again.
            self.listed.add(&mut doubts.stars, lost.iter().copied());
        }
    }
}

/// Asks for the new points of some leaves, in order; takes their lists off those that are to be filled.
fn asked(tree: &PlaceTree, leaves: &[NewInLeaf], lists: &mut &mut [NearList]) -> Vec<Asked> {
    let parts = leaves.chunks(LEAVES_AT_ONCE).map(|leaves| {
        let count: u32 = leaves.iter().map(NewInLeaf::len).sum();
        let (own, others) = std::mem::take(lists).split_at_mut(count as usize);
        *lists = others;
        (leaves, own)
    });
    let ask = |(leaves, mut lists): (&[NewInLeaf], &mut [NearList])| {
        let mut room = near_lists::Room::default();
        let mut asked = Asked::default();
        for new in leaves {
            let (own, others) = lists.split_at_mut(new.len() as usize);
            asked.ask(tree, *new, &mut room, own);
            lists = others;
        }
        asked
    };
    parts.collect::<Vec<_>>().into_par_iter().map(ask).collect()
}

/// Makes room for new points; so many that memory is new to the process are filled by all threads.
pub(super) fn grow<T: Clone + Send>(items: &mut Vec<T>, len: usize, new: impl Fn() -> T + Sync) {
    let more = len.saturating_sub(items.len());
    if more < FILLED_ALONE {
        items.resize_with(len, new);
    } else {
        items.par_extend((0..more).into_par_iter().with_min_len(FILLED_ALONE).map(|_| new()));
    }
}

/// What a new place may change.
const NEW_PLACE: [Sight; 2] = [Sight::Plane, Sight::Star];
/// Leaves whose answers are held before they are taken over.
const LEAVES_HELD: usize = 1 << 12;
/// Items that one thread writes faster than many.
const FILLED_ALONE: usize = 1 << 14;
/// Leaves that a thread asks for in turn.
const LEAVES_AT_ONCE: usize = 32;
