//! Pages of tiles, of which a few are in memory.

use super::shelf::{Shelved, TileError, TileShelf};

/// What is kept of the points of a tile.
pub(super) trait Page: Sized {
    fn load(shelf: &mut Shelved<impl TileShelf>, pieces: &Self::Pieces) -> Result<Self, TileError>;

    /// Puts what has changed since it was loaded back on the shelf.
    fn save(
        &self,
        shelf: &mut Shelved<impl TileShelf>,
        pieces: &Self::Pieces,
    ) -> Result<(), TileError>;

    /// Where it lies on the shelf.
    type Pieces;
}

/// Pages of a kind, at most a few in memory: the one that was asked for longest ago goes first.
pub(super) struct Pages<P: Page> {
    pages: Vec<Option<P>>,
    pieces: Vec<P::Pieces>,
    asked: Vec<u64>,
    now: u64,
    loaded: Vec<usize>,
    most: usize,
}

impl<P: Page> Pages<P> {
    pub(super) fn new(pieces: Vec<P::Pieces>, most: usize) -> Pages<P> {
        let pages = pieces.iter().map(|_| None).collect();
        let asked = vec![0; pieces.len()];
        Pages { pages, pieces, asked, now: 0, loaded: Vec::new(), most }
    }

    #[inline]
    pub(super) fn page(
        &mut self,
        tile: usize,
        shelf: &mut Shelved<impl TileShelf>,
    ) -> Result<&mut P, TileError> {
        self.now += 1;
        self.asked[tile] = self.now;
        if self.pages[tile].is_none() {
            self.load(tile, shelf)?;
        }
        let missing = || TileError::Shelf("a tile that was not loaded".into());
        self.pages[tile].as_mut().ok_or_else(missing)
    }

    #[cold]
    fn load(&mut self, tile: usize, shelf: &mut Shelved<impl TileShelf>) -> Result<(), TileError> {
        if self.loaded.len() == self.most {
            let longest = (0..self.most).min_by_key(|&at| self.asked[self.loaded[at]]);
            let oldest = self.loaded.swap_remove(longest.unwrap_or(0));
            if let Some(page) = self.pages[oldest].take() {
                page.save(shelf, &self.pieces[oldest])?;
            }
        }
        self.loaded.push(tile);
        self.pages[tile] = Some(P::load(shelf, &self.pieces[tile])?);
        Ok(())
    }
}

/// The edges of the graph at the points of a tile.
pub(super) struct LinksPage {
    starts: Vec<u32>,
    ends: Vec<u32>,
}

impl LinksPage {
    /// The ranks of the neighbours of a point of the tile.
    #[inline]
    pub(super) fn at(&self, at: usize) -> &[u32] {
        &self.ends[self.starts[at] as usize..self.starts[at + 1] as usize]
    }
}

impl Page for LinksPage {
    type Pieces = [u32; 2];

    fn load(
        shelf: &mut Shelved<impl TileShelf>,
        &[starts, ends]: &[u32; 2],
    ) -> Result<LinksPage, TileError> {
        Ok(LinksPage { starts: shelf.get(starts)?, ends: shelf.get(ends)? })
    }

    fn save(&self, _: &mut Shelved<impl TileShelf>, _: &[u32; 2]) -> Result<(), TileError> {
        Ok(())
    }
}

/// What is found of the points of a tile.
pub(super) struct StatePage {
    /// Hops to the nearest landmark.
    pub(super) hops: Vec<u8>,
    /// Ranks of their landmarks.
    pub(super) owners: Vec<u32>,
}

impl Page for StatePage {
    type Pieces = [u32; 2];

    fn load(
        shelf: &mut Shelved<impl TileShelf>,
        &[hops, owners]: &[u32; 2],
    ) -> Result<StatePage, TileError> {
        Ok(StatePage { hops: shelf.get(hops)?, owners: shelf.get(owners)? })
    }

    fn save(
        &self,
        shelf: &mut Shelved<impl TileShelf>,
        &[hops, owners]: &[u32; 2],
    ) -> Result<(), TileError> {
        shelf.put_as(hops, &self.hops)?;
        shelf.put_as(owners, &self.owners)
    }
}
