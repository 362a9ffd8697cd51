//! Betti numbers of a mesh with coefficients in Z/2.

use asphera_geometry::Sets;

use super::edges::Edges;

/// Components, tunnels and cavities.
///
/// Triangles joined by edges of two make patches. A set of patches is closed where every other edge has an even number of its
/// triangles: the closed sets are the kernel of a matrix of edges and patches, found by elimination.
pub(super) fn betti(
    edges: &Edges,
    facets: usize,
    components: usize,
    euler: i64,
) -> Option<[i64; 3]> {
    let cavities = closed_sets(edges, facets)?;
    let components = components as i64;
    Some([components, components + cavities - euler, cavities])
}

fn closed_sets(edges: &Edges, facets: usize) -> Option<i64> {
    let mut patches = Sets::new(facets);
    for [one, other] in &edges.inner {
        patches.join(one.facet() as usize, other.facet() as usize);
    }
    let mut has_border = vec![false; facets];
    for side in &edges.border {
        has_border[patches.root(side.facet() as usize)] = true;
    }
    // Patches with a border of their own are in no closed set.
    let mut number = vec![u32::MAX; facets];
    let mut count = 0;
    for facet in 0..facets {
        if patches.root(facet) == facet && !has_border[facet] {
            number[facet] = count;
            count += 1;
        }
    }
    if edges.nonmanifold.is_empty() {
        return Some(i64::from(count));
    }
    if count > MOST_PATCHES {
        return None;
    }
    let words = count.div_ceil(64) as usize;
    let mut rows: Vec<Vec<u64>> = Vec::new();
    for edge in &edges.nonmanifold {
        let mut row = vec![0; words];
        // What joins a patch with a border must be balanced by none of it: such a patch counts as zero.
        for &facet in &edge.facets {
            let patch = number[patches.root(facet as usize)];
            if patch != u32::MAX {
                row[patch as usize / 64] ^= 1 << (patch % 64);
            }
        }
        reduce(&mut rows, row);
    }
    Some(i64::from(count) - rows.len() as i64)
}

/// Adds a row to rows in echelon form, unless it is a sum of them.
fn reduce(rows: &mut Vec<Vec<u64>>, mut row: Vec<u64>) {
    for other in rows.iter() {
        let Some(word) = other.iter().position(|&bits| bits != 0) else { continue };
        let lead = 1 << other[word].trailing_zeros();
        if row[word] & lead != 0 {
            row.iter_mut().zip(other).for_each(|(bits, other)| *bits ^= other);
        }
    }
    if row.iter().any(|&bits| bits != 0) {
        rows.push(row);
    }
}

const MOST_PATCHES: u32 = 4096;
