//! The nearest neighbours of the points of a tile, wherever they lie.
//!
//! A tile is asked by itself first. What it gives bounds how far the nearest can be. So the few points whose bound reaches into the
//! box of another tile are asked there too, and no others.

use asphera_geometry::{BoxMm, PointMm};
use rayon::prelude::*;

use super::Tiles;
use super::shelf::{TileError, TileShelf};
use super::sorting::Tile;
use crate::geometry::{gap, squared};
use crate::neighbours::{Near, Neighbours, by_coordinates};

/// Stands in a list for a neighbour that is not there.
pub(super) const NONE: u32 = u32::MAX;

/// A point whose nearest may lie in another tile.
struct Open {
    /// Its number in the tile.
    at: usize,
    place: PointMm,
    /// Its nearest so far: square of the distance in mm², place, rank.
    near: Vec<(f64, PointMm, u32)>,
}

impl Open {
    /// The square of the distance within which nearer ones may lie, mm².
    fn reach_mm2(&self, count: usize) -> f64 {
        if self.near.len() < count { f64::INFINITY } else { self.near[count - 1].0 }
    }

    fn reaches(&self, bounds: &BoxMm, count: usize) -> bool {
        meets(self.place, bounds, self.reach_mm2(count))
    }

    fn take(&mut self, found: impl Iterator<Item = (f64, PointMm, u32)>, count: usize) {
        self.near.extend(found);
        self.near
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then_with(|| by_coordinates(a.1, b.1)));
        self.near.truncate(count);
    }
}

/// Whether a box lies within the root of a limit of a place.
fn meets(place: PointMm, bounds: &BoxMm, limit_mm2: f64) -> bool {
    gap(&BoxMm { low: place, high: place }, bounds) * (1.0 - MARGIN) <= limit_mm2
}

/// The ranks of the `count` nearest of every point of a tile, then [`NONE`] where there are fewer.
pub(super) fn lists(
    tiles: &mut Tiles<impl TileShelf>,
    own: usize,
    count: usize,
) -> Result<Vec<u32>, TileError> {
    let places = tiles.places(own)?;
    let (mut lists, mut open) = asked_alone(&tiles.tiles, &places, own, tiles.shift, count);
    for other in (0..tiles.tiles.len()).filter(|&other| other != own) {
        let bounds = &tiles.tiles[other].bounds;
        if open.iter().any(|one| one.reaches(bounds, count)) {
            ask(tiles, other, count, &mut open)?;
        }
    }
    for one in open {
        let list = &mut lists[one.at * count..(one.at + 1) * count];
        for (to, &(_, _, rank)) in list.iter_mut().zip(&one.near) {
            *to = rank;
        }
    }
    Ok(lists)
}

/// The lists within a tile, and the points that are to be asked elsewhere.
fn asked_alone(
    tiles: &[Tile],
    places: &[PointMm],
    own: usize,
    shift: u32,
    count: usize,
) -> (Vec<u32>, Vec<Open>) {
    let first = (own << shift) as u32;
    let tree = Neighbours::of(places.iter().copied().zip(0..).collect());
    let nearest = tree.nearest_of_all(count);
    let stride = count.min(places.len() - 1);
    let mut lists = vec![NONE; places.len() * count];
    let mut place_of = vec![0; places.len()];
    for (at, &id) in tree.ids.iter().enumerate() {
        place_of[id as usize] = at;
        let list = &mut lists[id as usize * count..][..stride];
        for (to, &near) in list.iter_mut().zip(&nearest[at * stride..]) {
            *to = first + tree.ids[near as usize];
        }
    }
    let others = along_the_sweep(tiles, own);
    let open = (0..places.len()).into_par_iter().filter_map(|at| {
        let near: Vec<(f64, PointMm, u32)> = lists[at * count..][..stride]
            .iter()
            .map(|&rank| {
                let near = places[(rank - first) as usize];
                (squared(places[at], near), near, rank)
            })
            .collect();
        let far_mm2 = if stride < count { f64::INFINITY } else { near[count - 1].0 };
        let is_open = others.iter().any(|bounds| meets(places[at], bounds, far_mm2));
        is_open.then_some(Open { at, place: places[at], near })
    });
    let open = open.collect();
    (lists, open)
}

/// Boxes that hold all other tiles: of those next to this one each, of all before and of all behind together.
fn along_the_sweep(tiles: &[Tile], own: usize) -> Vec<BoxMm> {
    let bounds = |tiles: &[Tile]| {
        tiles.iter().map(|tile| tile.bounds).reduce(|a, b| crate::geometry::joined(&a, &b))
    };
    let near = own.saturating_sub(NEXT)..(own + NEXT + 1).min(tiles.len());
    let next = near.clone().filter(|&other| other != own).map(|other| tiles[other].bounds);
    let far = [bounds(&tiles[..near.start]), bounds(&tiles[near.end..])];
    next.chain(far.into_iter().flatten()).collect()
}

/// Asks another tile for points that may have their nearest there.
fn ask(
    tiles: &mut Tiles<impl TileShelf>,
    other: usize,
    count: usize,
    open: &mut [Open],
) -> Result<(), TileError> {
    let places = tiles.places(other)?;
    let (bounds, first) = (tiles.tiles[other].bounds, (other << tiles.shift) as u32);
    let mut asking: Vec<&mut Open> =
        open.iter_mut().filter(|one| one.reaches(&bounds, count)).collect();
    let about = BoxMm::about(asking.iter().map(|one| one.place));
    let reach_mm2 = asking.iter().map(|one| one.reach_mm2(count)).fold(0.0, f64::max);
    let near =
        places.iter().copied().zip(first..).filter(|&(place, _)| meets(place, &about, reach_mm2));
    let tree = Neighbours::of(near.collect());
    asking.par_iter_mut().for_each_init(Vec::new, |found: &mut Vec<Near>, one| {
        tree.nearest_within(one.place, one.reach_mm2(count), count, found);
        let named =
            |&(square, at): &Near| (square, tree.points_mm[at as usize], tree.ids[at as usize]);
        one.take(found.iter().map(named), count);
    });
    Ok(())
}

/// Of a square of a distance: more than its rounding.
const MARGIN: f64 = 1e-12;
/// Tiles on either side that are asked by themselves whether they are near.
const NEXT: usize = 2;
