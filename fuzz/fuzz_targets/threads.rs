//! Scans whose batches two threads share, against the same by one thread.
//!
//! Batches of a few points are shared as large ones are, lines as two blocks and scattered points as two
//! halves. After every batch the two meshes must be the same, bit for bit.

#![no_main]

use std::sync::LazyLock;

use arbitrary::Arbitrary;
use asphera_fuzz::laws;
use asphera_fuzz::scan::Scan;
use asphera_mesh::{Location, Mesh};
use libfuzzer_sys::fuzz_target;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// A scan, and how many points a batch has that is shared.
#[derive(Arbitrary, Debug)]
struct SharedScan {
    from: u8,
    scan: Scan,
}

fuzz_target!(|shared: SharedScan| {
    let points = shared.scan.points();
    let mut alone = Mesh::new();
    let mut mesh = Mesh::shared_from(usize::from(shared.from % 64));
    for (index, batch) in shared.scan.batches(&points).into_iter().enumerate() {
        ONE.install(|| alone.insert(batch));
        TWO.install(|| mesh.insert(batch));
        laws::hold(&mesh);
        assert!(mesh.points() == alone.points(), "the vertices differ");
        assert!(mesh.triangles() == alone.triangles(), "the triangles differ");
        assert_eq!(mesh.counts(), alone.counts());
        // A table by which triangles are found is made by the first question, and grows from then on.
        if index % 3 == usize::from(shared.from / 64) {
            for (vertex, &[x, y, _]) in (0..).zip(mesh.points()).step_by(1 + points.len() / 8) {
                assert_eq!(mesh.locate(x, y), Location::At { vertex });
            }
        }
    }
    let outcomes = |mesh: &Mesh| (0..points.len()).map(|i| mesh.outcome(i)).collect::<Vec<_>>();
    assert_eq!(outcomes(&mesh), outcomes(&alone));
    laws::all_is_accounted_for(&mesh, &points);
});

static ONE: LazyLock<ThreadPool> = LazyLock::new(|| pool(1));
static TWO: LazyLock<ThreadPool> = LazyLock::new(|| pool(2));

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool can be made")
}
