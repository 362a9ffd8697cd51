//! A surface that comes band by band is that of the whole volume, and so are its figures.

use asphera_volume::{
    Ambiguity, Bands, Gaps, Grey, GreySlices, Histogram, Middles, Parts, Samples, Surface,
    SurfaceBand, SurfaceTally, Topology, cavities, components, marching_cubes,
};

use crate::noise::Random;

/// The surface put together from bands of a number of slices.
fn in_bands(samples: &Samples, height: usize, values: Option<&[f32]>) -> Vec<SurfaceBand> {
    cut_in_bands(samples, &Bands::new(samples, Ambiguity::Paired), height, values)
}

fn cut_in_bands(
    samples: &Samples,
    bands: &Bands<'_>,
    height: usize,
    values: Option<&[f32]>,
) -> Vec<SurfaceBand> {
    let [nx, ny, nz] = samples.size();
    let mut all = Vec::new();
    for start in (0..bands.slices()).step_by(height) {
        let end = (start + height).min(bands.slices());
        let band = match values {
            None => bands.band(start..end, &Middles),
            Some(values) => {
                // Only the slices that the band may ask for.
                let (from, to) = (start.saturating_sub(1), end.min(nz));
                let part = &values[from * nx * ny..to * nx * ny];
                let grey = Grey { values: part, size: [nx, ny, to - from], threshold: 0.5 };
                bands.band(start..end, &GreySlices { grey, first_slice: from })
            }
        };
        all.push(band);
    }
    all
}

fn assert_same(samples: &Samples, whole: &Surface, bands: &[SurfaceBand]) {
    let vertices: Vec<[f64; 3]> = bands.iter().flat_map(|band| band.vertices.clone()).collect();
    let triangles: Vec<[u32; 3]> = bands.iter().flat_map(|band| band.triangles.clone()).collect();
    assert_eq!((&vertices, &triangles), (&whole.vertices, &whole.triangles));
    let mut tally = SurfaceTally::new();
    let mut corners = Vec::new();
    bands.iter().for_each(|band| tally.add(band, |of| corners.push(of)));
    let found = tally.finish(|of| corners.push(of));
    let all = whole.triangles.iter().map(|of| of.map(|at| whole.vertices[at as usize]));
    assert!(corners.into_iter().eq(all));
    assert_eq!(found.vertices, whole.vertices.len() as u64);
    assert_eq!(found.triangles, whole.triangles.len() as u64);
    let check = whole.check();
    assert_eq!(found.is_closed, check.is_closed);
    assert_eq!(found.is_oriented, check.is_oriented);
    let figures = whole.figures();
    assert_eq!((found.border_sides, found.borders), (figures.border_sides, figures.borders));
    assert_eq!(found.euler(), whole.euler());
    let pieces = whole.pieces();
    assert_eq!(found.pieces.len(), pieces.len(), "{:?}", samples.size());
    for (one, other) in found.pieces.iter().zip(&pieces) {
        assert_eq!((one.euler, one.genus), (other.euler, other.genus));
        assert!((one.area / other.area - 1.0).abs() < 1e-12, "{one:?} {other:?}");
        assert_eq!(one.border_sides, other.border_sides);
        assert_eq!(one.volume.is_some(), other.volume.is_some());
        let [one_volume, volume] = [one, other].map(|piece| piece.volume.unwrap_or_default());
        assert!((one_volume - volume).abs() < 1e-9 * other.area, "{one:?} {other:?}");
    }
}

#[test]
fn bands_are_the_surface() {
    let mut random = Random::new(11);
    for (size, share) in
        [([66, 7, 9], 0.1), ([9, 30, 12], 0.5), ([70, 5, 1], 0.7), ([1, 1, 1], 1.0)]
    {
        let samples = random.volume(size, share);
        let whole = marching_cubes(&samples, Ambiguity::Paired, &Middles);
        for height in [1, 2, 3, 100] {
            assert_same(&samples, &whole, &in_bands(&samples, height, None));
        }
    }
}

/// Noise with missing samples and with open borders: the bands end where the whole surface does, which is cut after it was made.
#[test]
fn bands_end_at_gaps() {
    let mut random = Random::new(12);
    for (size, share, lacking) in [
        ([66, 7, 9], 0.1, 0.01),
        ([9, 30, 12], 0.5, 0.05),
        ([70, 5, 1], 0.7, 0.02),
        ([130, 9, 8], 0.4, 0.1),
        ([64, 4, 8], 0.5, 0.0),
        ([63, 8, 4], 0.5, 0.01),
        ([3, 3, 3], 0.5, 1.0),
    ] {
        let missing = random.volume(size, lacking);
        let samples = Samples::from_fn(size, |x, y, z| {
            random.unit() < share && !missing.get([x as i64, y as i64, z as i64])
        })
        .unwrap();
        for gaps in [
            Gaps::missing(&missing),
            Gaps { missing: Some(&missing), at_border: true },
            Gaps { missing: None, at_border: true },
        ] {
            let whole =
                marching_cubes(&samples, Ambiguity::Paired, &Middles).without_gaps(size, gaps);
            let bands = Bands::with_gaps(&samples, gaps, Ambiguity::Paired);
            for height in [1, 2, 5, 100] {
                assert_same(&samples, &whole, &cut_in_bands(&samples, &bands, height, None));
            }
        }
    }
}

/// Two rings in one another and a hollow ball: several pieces, of which some join late and some end early.
#[test]
fn bands_of_grey_values_are_the_surface() {
    let size = [64, 40, 44];
    let value = |x: usize, y: usize, z: usize| {
        let [x, y, z] = [x as f64, y as f64, z as f64];
        let ring = |u: f64, v: f64, w: f64| ((u.hypot(v) - 11.0).powi(2) + w * w).sqrt() / 4.0;
        let first = ring(x - 16.3, y - 19.8, z - 22.1);
        let second = ring(x - 27.1, z - 21.7, y - 20.2);
        let ball = ((x - 53.2).powi(2) + (y - 20.4).powi(2) + (z - 20.6).powi(2)).sqrt();
        let shell = (ball - 6.0).abs() / 2.2;
        (1.5 - first.min(second).min(shell)) as f32
    };
    let values: Vec<f32> = (0..size.iter().product::<usize>())
        .map(|at| value(at % size[0], at / size[0] % size[1], at / size[0] / size[1]))
        .collect();
    let inside: Vec<bool> = values.iter().map(|&value| value >= 0.5).collect();
    let samples = Samples::from_bools(size, &inside).unwrap();
    let grey = Grey { values: &values, size, threshold: 0.5 };
    let whole = marching_cubes(&samples, Ambiguity::Paired, &grey);
    assert_eq!(whole.pieces().len(), 4);
    for height in [1, 5, 16] {
        assert_same(&samples, &whole, &in_bands(&samples, height, Some(&values)));
    }
    let topology = Topology::new(&samples, &Histogram::new(&samples));
    assert_eq!([topology.components, topology.cavities], [3, 1]);
    assert_eq!(topology.tunnels, 2);
    // Areas slice by slice need no mesh.
    let bands = Bands::new(&samples, Ambiguity::Paired);
    let areas = bands.areas(0..bands.slices(), &grey, |place| place.map(|at| 2.0 * at));
    let area: f64 = areas.iter().sum();
    assert!((area / whole.area() / 4.0 - 1.0).abs() < 1e-12, "{area} {}", whole.area());
}

/// A band that lacks a triangle is not closed; one whose triangle is turned round is not oriented.
#[test]
fn what_is_no_closed_surface_is_seen() {
    let samples = Random::new(5).volume([12, 12, 12], 0.4);
    let checked = |change: &dyn Fn(&mut Vec<[u32; 3]>)| {
        let mut bands = in_bands(&samples, 3, None);
        change(&mut bands[1].triangles);
        let mut tally = SurfaceTally::new();
        bands.iter().for_each(|band| tally.add(band, |_| ()));
        tally.finish(|_| ())
    };
    assert!(checked(&|_| ()).is_closed && checked(&|_| ()).is_oriented);
    let gap = checked(&|triangles| triangles.truncate(triangles.len() - 1));
    assert!(!gap.is_closed);
    let turned = checked(&|triangles| triangles[7].swap(0, 1));
    assert!(turned.is_closed && !turned.is_oriented);
    let twice = checked(&|triangles| triangles.push(triangles[0]));
    assert!(!twice.is_closed);
}

#[test]
fn parts_are_counted_as_they_are_labelled() {
    let mut random = Random::new(21);
    for size in [[66, 9, 8], [5, 5, 5], [3, 40, 20], [130, 2, 3]] {
        for share in [0.02, 0.2, 0.5, 0.9] {
            let samples = random.volume(size, share);
            assert_eq!(components(&samples), Parts::label(&samples).count() as u64);
            // Background that is joined across corners, as foreground of a volume where neighbours are filled in.
            let outside = samples.complement();
            let [nx, ny, nz] = size;
            let at = |x: usize, y: usize, z: usize| outside.get([x as i64, y as i64, z as i64]);
            let mut seen = vec![false; nx * ny * nz];
            let mut cavity_count = 0;
            for start in 0..seen.len() {
                let place = |at: usize| [at % nx, at / nx % ny, at / nx / ny];
                let [x, y, z] = place(start);
                if seen[start] || !at(x, y, z) {
                    continue;
                }
                let (mut stack, mut is_open) = (vec![start], false);
                seen[start] = true;
                while let Some(here) = stack.pop() {
                    let [x, y, z] = place(here);
                    is_open |=
                        x == 0 || y == 0 || z == 0 || x + 1 == nx || y + 1 == ny || z + 1 == nz;
                    for step in 0..27 {
                        let to = [x + step % 3, y + step / 3 % 3, z + step / 9]
                            .map(|to| to.wrapping_sub(1));
                        if to[0] < nx && to[1] < ny && to[2] < nz && at(to[0], to[1], to[2]) {
                            let next = (to[2] * ny + to[1]) * nx + to[0];
                            if !seen[next] {
                                seen[next] = true;
                                stack.push(next);
                            }
                        }
                    }
                }
                cavity_count += u64::from(!is_open);
            }
            assert_eq!(cavities(&samples), cavity_count, "{size:?} {share}");
        }
    }
}
