//! The neighbourhood graph of tiles: each tile gets the edges that others know.

use super::Tiles;
use super::near::{NONE, lists};
use super::shelf::{TileError, TileShelf};

/// Finds the edges at the points of every tile; gives where they lie on the shelf.
pub(super) fn links(
    tiles: &mut Tiles<impl TileShelf>,
    count: usize,
) -> Result<Vec<[u32; 2]>, TileError> {
    let mut inboxes: Vec<Vec<u32>> = tiles.tiles.iter().map(|_| Vec::new()).collect();
    let mut all = Vec::new();
    for own in 0..tiles.tiles.len() {
        let lists = lists(tiles, own, count)?;
        for (tile, edges) in outgoing(&lists, own, tiles.shift, count) {
            inboxes[tile].push(tiles.shelf.put(&edges)?);
        }
        all.push(tiles.shelf.put(&lists)?);
    }
    tiles.forget_places();
    let mut pieces = Vec::new();
    for (own, inbox) in inboxes.into_iter().enumerate() {
        let lists: Vec<u32> = tiles.shelf.take(all[own])?;
        let mut incoming: Vec<[u32; 2]> = Vec::new();
        for piece in inbox {
            incoming.extend(tiles.shelf.take::<[u32; 2]>(piece)?);
        }
        let (starts, ends) = joined(&lists, incoming, own, tiles.shift, count);
        pieces.push([tiles.shelf.put(&starts)?, tiles.shelf.put(&ends)?]);
    }
    Ok(pieces)
}

/// Edges from a tile to others, by tile: end and start.
fn outgoing(lists: &[u32], own: usize, shift: u32, count: usize) -> Vec<(usize, Vec<[u32; 2]>)> {
    let starts = (own << shift) as u32..;
    let pairs = lists.chunks(count).zip(starts).flat_map(|(list, start)| {
        let ends = list.iter().copied().filter(|&end| end != NONE);
        ends.filter(|&end| (end >> shift) as usize != own).map(move |end| [end, start])
    });
    let mut pairs: Vec<[u32; 2]> = pairs.collect();
    pairs.sort_unstable();
    let groups = pairs.chunk_by(|one, other| one[0] >> shift == other[0] >> shift);
    groups.map(|group| ((group[0][0] >> shift) as usize, group.to_vec())).collect()
}

/// The edges of a tile: its lists and what points to it, each once.
fn joined(
    lists: &[u32],
    incoming: Vec<[u32; 2]>,
    own: usize,
    shift: u32,
    count: usize,
) -> (Vec<u32>, Vec<u32>) {
    let first = (own << shift) as u32;
    let list = |at: usize| &lists[at * count..(at + 1) * count];
    let len = lists.len() / count;
    let within = (0..len).flat_map(|at| {
        let ends = list(at).iter().copied().filter(|&end| end != NONE);
        ends.filter(|&end| (end >> shift) as usize == own).map(move |end| [end, first + at as u32])
    });
    // Edges that only the point at their start knows.
    let is_one_way = |&[end, start]: &[u32; 2]| !list((end - first) as usize).contains(&start);
    let mut back: Vec<[u32; 2]> = within.chain(incoming).filter(is_one_way).collect();
    back.sort_unstable();
    let mut back = back.into_iter().peekable();
    let (mut starts, mut ends) = (vec![0], Vec::with_capacity(lists.len()));
    for at in 0..len {
        ends.extend(list(at).iter().copied().filter(|&end| end != NONE));
        let rank = first + at as u32;
        while let Some([_, start]) = back.next_if(|edge| edge[0] == rank) {
            ends.push(start);
        }
        starts.push(ends.len() as u32);
    }
    (starts, ends)
}
