//! Scans of every kind in batches of any size, against the laws of the mesh.
//!
//! After every batch the mesh is proved Delaunay and its counts are recounted; at the end the same
//! points in other batches and other orders must give the same triangles.

#![no_main]

use asphera_fuzz::laws;
use asphera_fuzz::scan::Scan;
use asphera_mesh::Mesh;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|scan: Scan| {
    let points = scan.points();
    let mut mesh = Mesh::new();
    for batch in scan.batches(&points) {
        mesh.insert(batch);
        laws::hold(&mesh);
    }
    laws::all_is_accounted_for(&mesh, &points);
    laws::order_does_not_matter(&mesh, &points, scan.seed());
});
