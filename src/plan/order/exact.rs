//! The shortest open path through a few places.

use super::Ruler;

/// Most places of a shortest path.
pub(super) const MOST: usize = 12;

/// The shortest path from node 0 through all others: by the sets of places that were passed. Of equal paths that of the
/// first places counts.
pub(super) fn shortest(ruler: &Ruler) -> Vec<usize> {
    let count = ruler.places();
    if count == 0 {
        return Vec::new();
    }
    let sets = 1_usize << count;
    // Length of the shortest path through a set that ends at a place, and the place before that.
    let mut best = vec![(i64::MAX, usize::MAX); sets * count];
    for last in 0..count {
        best[(1 << last) * count + last] = (ruler.length(0, last + 1), usize::MAX);
    }
    for set in 1..sets {
        for last in (0..count).filter(|last| set & (1 << last) != 0) {
            let (length, _) = best[set * count + last];
            if length == i64::MAX {
                continue;
            }
            for next in (0..count).filter(|next| set & (1 << next) == 0) {
                let longer = length + ruler.length(last + 1, next + 1);
                let entry = &mut best[(set | (1 << next)) * count + next];
                if longer < entry.0 {
                    *entry = (longer, last);
                }
            }
        }
    }
    let mut set = sets - 1;
    let ends = (0..count).min_by_key(|&last| best[set * count + last].0);
    let mut order = Vec::with_capacity(count);
    let mut at = ends;
    while let Some(last) = at {
        order.push(last + 1);
        let (_, before) = best[set * count + last];
        set &= !(1 << last);
        at = (before != usize::MAX).then_some(before);
    }
    order.reverse();
    order
}
