//! Our mesh, fed batch by batch; the only file of this benchmark that knows its interface.

use std::num::NonZeroUsize;

use asphera_mesh::Mesh;
use rayon::ThreadPoolBuilder;

use crate::clock::timed;
use crate::orders::Scan;

/// The number of threads ours is measured with besides one.
pub(crate) const TWO: NonZeroUsize = NonZeroUsize::new(2).expect("two is not zero");

/// A scan meshed while it arrived.
pub(crate) struct Meshed {
    /// Seconds of each batch, in order of arrival.
    pub(crate) batches_s: Vec<f64>,
    pub(crate) triangles: u64,
}

impl Meshed {
    /// Seconds of all batches together.
    pub(crate) fn total_s(&self) -> f64 {
        self.batches_s.iter().sum()
    }
}

/// Meshes a scan by batches, in a pool of so many threads.
///
/// The clock runs while a batch is inserted, not while the next one is generated.
pub(crate) fn mesh(scan: Scan, batch: NonZeroUsize, threads: NonZeroUsize) -> Meshed {
    let pool = ThreadPoolBuilder::new().num_threads(threads.get()).build();
    pool.expect("threads can be started").install(|| {
        let mut mesh = Mesh::new();
        let mut batches_s = Vec::with_capacity(scan.count.div_ceil(batch.get()));
        scan.for_each_batch(batch.get(), |points| {
            let ((), seconds) = timed(|| mesh.insert(points));
            batches_s.push(seconds);
        });
        Meshed { batches_s, triangles: mesh.counts().triangles }
    })
}
