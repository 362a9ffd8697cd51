//! Landmarks, cells and contacts of tiles, found along the sweep.
//!
//! The ranks of points are the order in which they may become landmarks. So a walk over the tiles in their order meets the same points
//! in the same order as in memory, and asks for tiles near the one it is in.

use asphera_geometry::PointMm;

use super::Tiles;
use super::pages::{LinksPage, Pages, StatePage};
use super::shelf::{TileError, TileShelf};
use crate::graph::Contact;
use crate::graph::landmarks::FAR;
use crate::surface::Numbered;

/// The graph of tiles and what is found in it.
pub(super) struct Walk<'a, S> {
    tiles: &'a mut Tiles<S>,
    links: Pages<LinksPage>,
    state: Pages<StatePage>,
    /// Points that wait for their owners.
    waiting: Vec<u32>,
}

/// Where cells touch.
#[derive(Default)]
pub(super) struct Touching {
    pub(super) contacts: Vec<Contact>,
    pub(super) meetings: Vec<[u32; 2]>,
}

impl<'a, S: TileShelf> Walk<'a, S> {
    pub(super) fn new(
        tiles: &'a mut Tiles<S>,
        links: Vec<[u32; 2]>,
    ) -> Result<Walk<'a, S>, TileError> {
        let mut state = Vec::new();
        for at in 0..tiles.tiles.len() {
            let len = tiles.tiles[at].len;
            let hops = tiles.shelf.put(&vec![FAR; len])?;
            state.push([hops, tiles.shelf.put(&vec![NO_OWNER; len])?]);
        }
        let (links, state) = (Pages::new(links, LINKS_HELD), Pages::new(state, STATES_HELD));
        Ok(Walk { tiles, links, state, waiting: Vec::new() })
    }

    /// The tile of a point, and its number there.
    fn split(&self, rank: u32) -> (usize, usize) {
        ((rank >> self.tiles.shift) as usize, rank as usize & ((1 << self.tiles.shift) - 1))
    }

    #[inline]
    fn hops(&mut self, rank: u32) -> Result<&mut u8, TileError> {
        let (tile, at) = self.split(rank);
        Ok(&mut self.state.page(tile, &mut self.tiles.shelf)?.hops[at])
    }

    #[inline]
    fn owner(&mut self, rank: u32) -> Result<&mut u32, TileError> {
        let (tile, at) = self.split(rank);
        Ok(&mut self.state.page(tile, &mut self.tiles.shelf)?.owners[at])
    }

    /// Gets the neighbours of a point.
    fn get_near(&mut self, rank: u32, near: &mut Vec<u32>) -> Result<(), TileError> {
        let (tile, at) = self.split(rank);
        near.clear();
        near.extend_from_slice(self.links.page(tile, &mut self.tiles.shelf)?.at(at));
        Ok(())
    }

    /// Chooses landmarks that are `apart` hops from each other, as [`landmarks`](crate::graph::landmarks::landmarks()) does.
    pub(super) fn choose(&mut self, apart: u8) -> Result<Vec<Numbered>, TileError> {
        let mut chosen = Vec::new();
        for tile in 0..self.tiles.tiles.len() {
            let points = self.tiles.points(tile)?;
            for (point, rank) in points.into_iter().zip((tile << self.tiles.shift) as u32..) {
                if *self.hops(rank)? == FAR {
                    *self.owner(rank)? = chosen.len() as u32;
                    chosen.push(point);
                    self.spread(rank, apart)?;
                }
            }
        }
        Ok(chosen)
    }

    /// Counts hops from a landmark, as far as none is nearer.
    fn spread(&mut self, landmark: u32, apart: u8) -> Result<(), TileError> {
        *self.hops(landmark)? = 0;
        let (mut ring, mut next, mut near) = (vec![landmark], Vec::new(), Vec::new());
        for distance in 1..apart {
            next.clear();
            for &inner in &ring {
                self.get_near(inner, &mut near)?;
                for &outer in &near {
                    let found = self.hops(outer)?;
                    if *found > distance {
                        *found = distance;
                        next.push(outer);
                    }
                }
            }
            std::mem::swap(&mut ring, &mut next);
        }
        Ok(())
    }

    /// The owner of a point: the first of those of its neighbours that are a hop nearer to their landmarks.
    fn settled(&mut self, rank: u32, near: &mut Vec<u32>) -> Result<u32, TileError> {
        let found = *self.owner(rank)?;
        if found != NO_OWNER {
            return Ok(found);
        }
        self.waiting.clear();
        self.waiting.push(rank);
        // Every further one is a hop nearer to its landmark.
        while let Some(&last) = self.waiting.last() {
            let hops = *self.hops(last)?;
            self.get_near(last, near)?;
            let (mut owner, mut is_whole) = (NO_OWNER, true);
            for &inner in &*near {
                if *self.hops(inner)? < hops {
                    let found = *self.owner(inner)?;
                    if found == NO_OWNER {
                        self.waiting.push(inner);
                        is_whole = false;
                    }
                    owner = owner.min(found);
                }
            }
            if is_whole {
                *self.owner(last)? = owner;
                self.waiting.pop();
            }
        }
        Ok(*self.owner(rank)?)
    }

    /// Finds the cells of all points, and where they touch.
    pub(super) fn touching(&mut self) -> Result<Touching, TileError> {
        let (mut contacts, mut meetings) = (Tally::default(), Tally::default());
        let (mut near, mut room) = (Vec::new(), Vec::new());
        for tile in 0..self.tiles.tiles.len() {
            let first = (tile << self.tiles.shift) as u32;
            for rank in first..first + self.tiles.tiles[tile].len as u32 {
                let own = self.settled(rank, &mut room)?;
                self.get_near(rank, &mut near)?;
                let mut is_alone = true;
                for owner in &mut near {
                    *owner = self.settled(*owner, &mut room)?;
                    is_alone &= *owner == own;
                }
                if is_alone {
                    continue;
                }
                near.push(own);
                near.sort_unstable();
                near.dedup();
                let others = near.iter().filter(|&&other| other != own);
                contacts.new.extend(others.map(|&other| [own.min(other), own.max(other)]));
                for (at, &one) in near.iter().enumerate() {
                    meetings.new.extend(near[at + 1..].iter().map(|&other| [one, other]));
                }
            }
            contacts.count();
            meetings.count();
        }
        let contact = |(landmarks, points)| Contact { landmarks, points };
        Ok(Touching {
            contacts: contacts.counted.into_iter().map(contact).collect(),
            meetings: meetings.counted.into_iter().map(|(pair, _)| pair).collect(),
        })
    }
}

/// Pairs with how often they came, in ascending order.
#[derive(Default)]
struct Tally {
    new: Vec<[u32; 2]>,
    counted: Vec<([u32; 2], u32)>,
}

impl Tally {
    /// Counts the new ones.
    fn count(&mut self) {
        self.new.sort_unstable();
        let groups = self.new.chunk_by(|one, other| one == other);
        let groups = groups.map(|group| (group[0], group.len() as u32));
        // What was counted before is sorted, and most of it lies before the new pairs.
        let least = self.new.first().copied().unwrap_or([u32::MAX; 2]);
        let kept = self.counted.partition_point(|&(pair, _)| pair < least);
        let mut later = self.counted.split_off(kept);
        later.extend(groups);
        later.sort_unstable();
        for (pair, count) in later {
            match self.counted.last_mut().filter(|last| last.0 == pair) {
                Some(last) => last.1 += count,
                None => self.counted.push((pair, count)),
            }
        }
        self.new.clear();
    }
}

/// The places of points.
pub(super) fn places(points: &[Numbered]) -> Vec<PointMm> {
    points.iter().map(|&(point, _)| super::sorting::place(point)).collect()
}

/// No owner found yet.
const NO_OWNER: u32 = u32::MAX;
/// Tiles whose edges are in memory.
const LINKS_HELD: usize = 4;
/// Tiles whose hops and owners are in memory.
const STATES_HELD: usize = 8;
