//! Room for what grows with the scan.

/// Makes room for so many more.
///
/// By half, not twice: what is kept for points to come is lost to others. From some size on at least as
/// much as is taken from the system directly: what is not used takes no memory then, and whenever there
/// is to be more the system leads it elsewhere without copying.
pub(crate) fn make_room<T>(items: &mut Vec<T>, more: usize) {
    if items.capacity() - items.len() >= more {
        return;
    }
    let mut wanted = items.len() + more.max(items.len() / 2);
    if wanted * size_of::<T>() > LARGE_BYTES {
        wanted = wanted.max(MAPPED_BYTES / size_of::<T>());
    }
    items.reserve_exact(wanted - items.len());
}

/// Less is not worth the system's trouble.
const LARGE_BYTES: usize = 1 << 20;

/// More than 32 MiB the allocator of glibc never takes from what others have freed
/// (`M_MMAP_THRESHOLD` in mallopt(3)).
const MAPPED_BYTES: usize = 33 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_for_what_comes_and_some_more() {
        let mut items: Vec<u64> = Vec::new();
        for more in [0, 1, 7, 1_000, 100_000, 100_000, 5_000_000] {
            make_room(&mut items, more);
            assert!(items.capacity() - items.len() >= more);
            items.resize(items.len() + more, 0);
        }
        assert!(items.capacity() < 2 * items.len());
        let room = items.capacity() - items.len();
        make_room(&mut items, room);
        assert_eq!(items.capacity() - items.len(), room);
    }

    #[test]
    fn little_takes_little() {
        let mut items: Vec<u64> = Vec::new();
        make_room(&mut items, 1_000);
        assert!(items.capacity() < 2_000);
    }
}
