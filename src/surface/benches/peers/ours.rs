//! Our mesh, fed batch by batch; the only file of this benchmark that knows its interface.

use std::num::NonZeroUsize;

use asphera_surface::{Mesh, PointMm};

use crate::clock::timed;
use crate::orders::Scan;

/// The number of threads ours is measured with besides one.
pub(crate) const TWO: NonZeroUsize = NonZeroUsize::new(2).expect("two is not zero");

/// Our mesh, current after each [`Ours::insert`].
pub(crate) struct Ours {
    mesh: Mesh,
}

impl Ours {
    /// An empty mesh; `None` where the mesh cannot use as many threads.
    pub(crate) fn with_threads(threads: NonZeroUsize) -> Option<Ours> {
        (threads.get() == 1).then(|| Ours { mesh: Mesh::new() })
    }

    /// Meshes a batch to its last point.
    pub(crate) fn insert(&mut self, batch: &[PointMm]) {
        self.mesh.insert(batch);
    }

    pub(crate) fn triangles(&self) -> u64 {
        self.mesh.counts().triangles
    }
}

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

/// Meshes a scan by batches; `None` where the mesh cannot use as many threads.
///
/// The clock runs while a batch is inserted, not while the next one is generated.
pub(crate) fn mesh(scan: Scan, batch: NonZeroUsize, threads: NonZeroUsize) -> Option<Meshed> {
    let mut ours = Ours::with_threads(threads)?;
    let mut batches_s = Vec::with_capacity(scan.count.div_ceil(batch.get()));
    scan.for_each_batch(batch.get(), |points| {
        let ((), seconds) = timed(|| ours.insert(points));
        batches_s.push(seconds);
    });
    Some(Meshed { batches_s, triangles: ours.triangles() })
}
