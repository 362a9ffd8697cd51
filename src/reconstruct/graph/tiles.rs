//! The graph method for more points than memory holds: by tiles along the sweep of landmarks.
//!
//! Points are put in the order z, x, y, and cut into tiles of equal size. A tile is asked for its neighbours by itself and with those
//! tiles that its points reach into. All that is found of points waits on a shelf, some tiles of it in memory. What stays is the map of
//! landmarks. Every step gives what [`PointGraph`](super::PointGraph) gives, so that the surface is the same, bit for bit.

mod cells;
mod links;
mod near;
mod pages;
mod shelf;
mod sorting;

use asphera_geometry::PointMm;

use self::cells::{Walk, places};
use self::shelf::Shelved;
pub use self::shelf::{MOST_TILED_POINTS, TileError, TileShelf, TileShelfFailure};
use self::sorting::{Sorted, Sorting, Tile};
use super::mapped::Mapped;
use super::{FaceRule, GraphChoices, GraphMap, LandmarkOrder, NoSurface, Stage, check_neighbours};
use crate::surface::{LeftOut, Numbered, finished};

/// Points that become a surface of the graph method tile by tile.
///
/// Some 500 bytes a point of a tile are in memory, and some 10 a point of all for the map of landmarks.
pub struct TiledGraph<S> {
    shelf: Shelved<S>,
    sorting: Sorting,
    neighbours: usize,
    shift: u32,
}

/// What the graph method found by tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct TiledSurface {
    /// The landmarks as they came, in the order of their numbers.
    pub landmarks_mm: Vec<PointMm>,
    /// Their numbers among all points, ascending.
    pub numbers: Vec<u32>,
    /// Facets by places in these lists, otherwise as of a [`Reconstruction`](crate::Reconstruction).
    pub facets: Vec<[u32; 3]>,
    /// How many points no facet uses, for each reason that there is.
    pub left_out: Vec<(LeftOut, usize)>,
    /// The map; its `cells` are empty.
    pub map: GraphMap,
    /// Why there are no facets; `None` where there are.
    pub no_surface: Option<NoSurface>,
    /// Tiles that the points made.
    pub tiles: usize,
}

/// Tiles on a shelf.
struct Tiles<S> {
    shelf: Shelved<S>,
    tiles: Vec<Tile>,
    /// A tile has so many points as a power of two; the last may have fewer.
    shift: u32,
    /// Places of some tiles.
    held: Vec<(usize, Vec<PointMm>)>,
}

impl<S: TileShelf> Tiles<S> {
    /// The points of a tile as they came.
    fn points(&mut self, tile: usize) -> Result<Vec<Numbered>, TileError> {
        self.shelf.get(self.tiles[tile].piece)
    }

    /// The places of a tile.
    fn places(&mut self, tile: usize) -> Result<Vec<PointMm>, TileError> {
        if let Some((_, places)) = self.held.iter().find(|held| held.0 == tile) {
            return Ok(places.clone());
        }
        let places = places(&self.points(tile)?);
        if self.held.len() == PLACES_HELD {
            self.held.remove(0);
        }
        self.held.push((tile, places.clone()));
        Ok(places)
    }

    fn forget_places(&mut self) {
        self.held = Vec::new();
    }
}

impl<S: TileShelf> TiledGraph<S> {
    /// A graph with an edge from every place to its `neighbours` nearest, in tiles of at most `tile_points` points, but not fewer than one.
    ///
    /// # Errors
    ///
    /// No neighbours, or more than [`MOST_NEIGHBOURS`](crate::MOST_NEIGHBOURS).
    pub fn new(
        shelf: S,
        neighbours: usize,
        tile_points: usize,
    ) -> Result<TiledGraph<S>, TileError> {
        check_neighbours(neighbours)?;
        let shift = tile_points.clamp(1, 1 << 30).ilog2();
        let sorting = Sorting::new(RUN_TILES << shift);
        Ok(TiledGraph { shelf: Shelved::new(shelf), sorting, neighbours, shift })
    }

    /// Takes points. They are numbered on from those before.
    ///
    /// # Errors
    ///
    /// More than [`MOST_TILED_POINTS`] points in all; a shelf that fails.
    pub fn take(&mut self, points_mm: &[PointMm]) -> Result<(), TileError> {
        self.sorting.take(points_mm, &mut self.shelf)
    }

    /// The surface that [`PointGraph`](crate::PointGraph) gives of the same points, by the sweep. `enters` is given each stage as it begins.
    ///
    /// # Errors
    ///
    /// Hops out of range; the order of priority; a shelf that fails.
    pub fn surface(
        self,
        choices: &GraphChoices,
        enters: &mut dyn FnMut(Stage),
    ) -> Result<TiledSurface, TileError> {
        choices.check()?;
        if choices.order != LandmarkOrder::Sweep {
            return Err(TileError::Order);
        }
        let TiledGraph { mut shelf, sorting, neighbours, shift } = self;
        enters(Stage::Tree);
        let rejected = sorting.rejected;
        let Sorted { tiles, duplicates } = sorting.finish(1 << shift, &mut shelf)?;
        let count = tiles.iter().map(|tile| tile.len).sum::<usize>();
        let mut tiles = Tiles { shelf, tiles, shift, held: Vec::new() };
        enters(Stage::Neighbours);
        let links = links::links(&mut tiles, neighbours)?;
        enters(Stage::Landmarks);
        let mut walk = Walk::new(&mut tiles, links)?;
        let landmarks = walk.choose(choices.hops)?;
        enters(Stage::Cells);
        let touching = walk.touching()?;
        let number = tiles.tiles.len();
        // What is on the shelf has served.
        drop(tiles);
        enters(Stage::Map);
        let meetings = || (choices.faces == FaceRule::Filled).then_some(touching.meetings);
        let mut mapped =
            Mapped::of(&places(&landmarks), touching.contacts, choices.threshold, meetings, enters);
        let triangles = std::mem::take(&mut mapped.triangles);
        let ids = landmarks.iter().map(|&(_, id)| id).collect();
        let mut made = Made { landmarks, triangles }.surface(mapped.map(ids, Vec::new()), count);
        let missing = [(LeftOut::NoPlace, rejected), (LeftOut::Duplicate, duplicates)];
        made.left_out.extend(missing);
        made.left_out.retain(|&(_, count)| count > 0);
        made.left_out.sort_unstable();
        Ok(TiledSurface { tiles: number, ..made })
    }
}

/// Landmarks in their order, and triangles by their ranks.
struct Made {
    landmarks: Vec<Numbered>,
    triangles: Vec<[u32; 3]>,
}

impl Made {
    /// The surface of so many places.
    fn surface(self, map: GraphMap, places: usize) -> TiledSurface {
        let mut by_number: Vec<u32> = (0..self.landmarks.len() as u32).collect();
        by_number.sort_unstable_by_key(|&rank| self.landmarks[rank as usize].1);
        let mut place_of = vec![0; by_number.len()];
        for (place, &rank) in (0..).zip(&by_number) {
            place_of[rank as usize] = place;
        }
        let sorted = by_number.iter().map(|&rank| self.landmarks[rank as usize]);
        let (landmarks_mm, numbers): (Vec<PointMm>, Vec<u32>) = sorted.unzip();
        let facets = finished(&landmarks_mm, &place_of, self.triangles);
        let mut is_used = vec![false; numbers.len()];
        for &corner in facets.as_flattened() {
            is_used[corner as usize] = true;
        }
        let unused = is_used.iter().filter(|is_used| !**is_used).count();
        let left_out = vec![(LeftOut::Pruned, places - numbers.len()), (LeftOut::NoFace, unused)];
        let no_surface = facets.is_empty().then(|| NoSurface::of(places, numbers.len()));
        TiledSurface { landmarks_mm, numbers, facets, left_out, map, no_surface, tiles: 0 }
    }
}

/// Tiles whose points are sorted at once before they are tiles.
const RUN_TILES: usize = 8;
/// Tiles whose places are in memory.
const PLACES_HELD: usize = 3;
