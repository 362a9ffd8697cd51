//! A real airborne scan of 110,000 points with repeated places, where it is at hand.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use asphera_geometry::VertexId;
use asphera_mesh::{Mesh, Outcome, check};
use asphera_surface::{Kind, Relief, topography};

/// Where reference data is kept: beside the repository, or where `ASPHERA_DATA` says.
fn data_folder() -> PathBuf {
    std::env::var_os("ASPHERA_DATA").map_or_else(
        || Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).to_path_buf(),
        PathBuf::from,
    )
}

/// The points of a LAS 1.0 to 1.3 file in steps of its scale, and the scale. Field offsets are those
/// of the public header block in ASPRS, *LAS Specification Version 1.2* (2008), section "Public
/// Header Block"; X, Y, Z start each point record of every format.
fn read_las(bytes: &[u8]) -> (Vec<[i32; 3]>, [f64; 3]) {
    assert_eq!((&bytes[..4], bytes[24]), (&b"LASF"[..], 1));
    let first_point = u32::from_le_bytes(field(bytes, 96)) as usize;
    let record_length = usize::from(u16::from_le_bytes(field(bytes, 105)));
    let count = u32::from_le_bytes(field(bytes, 107)) as usize;
    let points = bytes[first_point..]
        .chunks_exact(record_length)
        .take(count)
        .map(|record| [0, 4, 8].map(|at| i32::from_le_bytes(field(record, at))))
        .collect();
    (points, [131, 139, 147].map(|at| f64::from_le_bytes(field(bytes, at))))
}

/// The scan, where it is at hand; skipped, and said so, where it is not.
struct Scan {
    /// The file.
    bytes: Vec<u8>,
    /// Its points in steps of the scale.
    steps: Vec<[i32; 3]>,
    scale: [f64; 3],
    mesh: Mesh,
}

impl Scan {
    #[expect(clippy::print_stderr, reason = "what is skipped must be seen")]
    fn load() -> Option<Scan> {
        let path = data_folder().join("lidar/autzen_trim.las");
        let Ok(bytes) = std::fs::read(&path) else {
            eprintln!("skipped: {} not found", path.display());
            return None;
        };
        let (steps, scale) = read_las(&bytes);
        let mut mesh = Mesh::new();
        mesh.extend(
            steps
                .iter()
                .map(|step| std::array::from_fn(|axis| f64::from(step[axis]) * scale[axis])),
        );
        mesh.flush();
        Some(Scan { bytes, steps, scale, mesh })
    }
}

/// The `N` bytes at an offset.
fn field<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes[at..at + N].try_into().expect("a slice of N bytes makes an array of N")
}

#[test]
fn autzen() {
    let Some(Scan { steps, scale, mesh, .. }) = Scan::load() else { return };
    assert_eq!(steps.len(), 110_000);
    let counts = mesh.counts();
    assert_eq!((counts.vertices, counts.triangles, counts.hull), (109_993, 219_955, 29));
    assert_eq!(counts.vertices + counts.triangles, counts.edges + 1);
    assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));

    let mut first: HashMap<[i32; 2], usize> = HashMap::new();
    for (index, &[x, y, z]) in steps.iter().enumerate() {
        let of = *first.entry([x, y]).or_insert(index);
        match mesh.outcome(index) {
            Some(Outcome::Vertex(_)) => assert_eq!(of, index),
            Some(Outcome::Duplicate { of: vertex }) => {
                assert_eq!(mesh.outcome(of), Some(Outcome::Vertex(vertex)));
                assert_eq!(steps[of][2], z);
            }
            Some(Outcome::Conflict { of: vertex, height_mm }) => {
                assert_eq!(mesh.outcome(of), Some(Outcome::Vertex(vertex)));
                let height = f64::from(z - steps[of][2]) * scale[2];
                assert!((height_mm - height).abs() < 1e-9 && height != 0.0);
            }
            other => panic!("point {index}: {other:?}"),
        }
    }
    assert_eq!(counts.duplicates + counts.conflicts, 7);
    assert_eq!(mesh.projectable(), counts.conflicts == 0);

    // Twice the hull's area in whole steps, by Andrew's monotone chain and the shoelace formula.
    let mut places: Vec<[i128; 2]> = first.keys().map(|place| place.map(i128::from)).collect();
    places.sort_unstable();
    let mut twice_area = 0;
    for chain in [places.clone(), places.into_iter().rev().collect()] {
        let mut hull: Vec<[i128; 2]> = Vec::new();
        for c in chain {
            while let [.., a, b] = hull[..]
                && (b[0] - a[0]) * (c[1] - a[1]) <= (b[1] - a[1]) * (c[0] - a[0])
            {
                hull.pop();
            }
            hull.push(c);
        }
        twice_area += hull.windows(2).map(|e| e[0][0] * e[1][1] - e[0][1] * e[1][0]).sum::<i128>();
    }
    let hull_area = 0.5 * twice_area as f64 * scale[0] * scale[1];
    let projected = mesh.area().projected_mm2;
    assert!((projected / hull_area - 1.0).abs() < 1e-12, "{projected} against {hull_area}");
}

#[test]
fn folds_are_where_the_laser_met_several_surfaces() {
    let Some(Scan { bytes, steps, mesh, .. }) = Scan::load() else { return };
    let first_point = u32::from_le_bytes(field(&bytes, 96)) as usize;
    let record_length = usize::from(u16::from_le_bytes(field(&bytes, 105)));
    // "Number of Returns" are bits 3 to 5 of byte 14 of a record of formats 0 to 5. Two or more mean
    // that a pulse met something and, below it, something else: a crown and the ground.
    assert!(bytes[104] <= 5);
    let several = |index: usize| bytes[first_point + index * record_length + 14] >> 3 & 7 > 1;

    let mut of_several = vec![false; mesh.points().len()];
    for index in 0..steps.len() {
        if let Some(Outcome::Vertex(vertex)) = mesh.outcome(index) {
            of_several[vertex as usize] = several(index);
        }
    }
    let triangles: Vec<[VertexId; 3]> = mesh.triangles();
    let found = topography(mesh.points(), &triangles, &Relief::default());
    let share = |chosen: &dyn Fn(Option<Kind>) -> bool| {
        let corners: Vec<VertexId> = (0..triangles.len())
            .filter(|&index| chosen(found.region_of(index).map(|at| found.regions()[at].kind)))
            .flat_map(|index| triangles[index])
            .collect();
        let several = corners.iter().filter(|&&corner| of_several[corner as usize]).count();
        several as f64 / corners.len() as f64
    };
    let [folded, elsewhere] =
        [share(&|kind| kind == Some(Kind::Fold)), share(&|kind| kind != Some(Kind::Fold))];
    assert!(folded > 0.6 && elsewhere < 0.05, "{folded} against {elsewhere}");
}
