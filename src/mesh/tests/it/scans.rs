//! Scans of a few hundred points, of every kind by which a surface is measured, and some by which
//! none is.

use std::f64::consts::{SQRT_2, TAU};

use asphera_geometry::PointMm;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// A scan, and what it is called where a test fails.
pub(crate) struct Scan {
    pub(crate) name: String,
    pub(crate) points: Vec<PointMm>,
    /// Whether no four points lie exactly on one circle with none inside, nor more than two on one
    /// line of the hull: then every Delaunay triangulation is the same.
    pub(crate) general: bool,
}

/// One of each kind.
pub(crate) fn all() -> Vec<Scan> {
    let mut scans = Vec::new();
    scans.extend(rasters());
    scans.extend(round());
    scans.extend(crowded());
    scans.extend(fronts());
    scans.extend(revisits());
    scans
}

/// The same at other places and of other sizes.
pub(crate) fn moved_and_scaled() -> Vec<Scan> {
    let mut scans = Vec::new();
    for (size_mm, centre_mm) in
        [(1e-6, 0.0), (1e6, 0.0), (0.1, 1e6), (1e6, -1e6), (1e-30, 0.0), (1e11, 1e10)]
    {
        for original in [
            scattered("scattered", 300, 1),
            jittered("jittered", &lines(20, 16, true), 0.2, 2),
            exact("raster", lines(20, 16, true)),
            exact("spiral", spiral(300, false)),
            exact("circles", circles(4, 48)),
        ] {
            // Rounding may bring points together on circles and lines, or part them.
            let points = original.points.iter().map(|&[x, y, z]| {
                [centre_mm + size_mm * x / 16.0, 2.0 * centre_mm - size_mm * y / 16.0, z]
            });
            scans.push(Scan {
                name: format!("{} of {size_mm} mm at {centre_mm} mm", original.name),
                points: points.collect(),
                general: original.general && centre_mm.abs() < 1e6 * size_mm,
            });
        }
    }
    scans
}

/// Some of several thousand points.
pub(crate) fn large() -> Vec<Scan> {
    let raster = lines(90, 60, true);
    vec![
        scattered("scattered", 5_000, 10),
        exact("serpentine", raster.clone()),
        jittered("serpentine", &raster, 1e-3, 11),
        jittered("serpentine", &raster, 0.4, 12),
        exact("gaps", with_gaps(&lines(90, 60, false), 13)),
        exact("spiral in", spiral(5_000, true)),
        Scan { general: true, ..exact("outline", outline(5_000)) },
    ]
}

/// A closed curve with hollows, traced once.
fn outline(count: usize) -> Vec<Place> {
    let at = |index: usize| {
        let t = TAU * index as f64 / count as f64;
        let radius = 10.0 + 0.8 * (7.0 * t).cos() + 0.3 * (13.0 * t).sin();
        [radius * t.cos(), radius * t.sin()]
    };
    (0..count).map(at).collect()
}

type Place = [f64; 2];

fn rasters() -> Vec<Scan> {
    let serpentine = lines(25, 20, true);
    let one_way = lines(25, 20, false);
    let turned = |places: &[Place], turn: fn(Place) -> Place| -> Vec<Place> {
        places.iter().copied().map(turn).collect()
    };
    let columns: Vec<Place> = turned(&serpentine, |[x, y]| [y, -x]);
    let diagonal: Vec<Place> = turned(&one_way, |[x, y]| [x - y, x + y]);
    let oblique: Vec<Place> = turned(&serpentine, |[x, y]| {
        let (sin, cos) = 0.3_f64.sin_cos();
        [x * cos - y * sin, x * sin + y * cos]
    });
    let mut scans = Vec::new();
    for (name, places) in [
        ("serpentine", &serpentine),
        ("one way", &one_way),
        ("columns", &columns),
        ("diagonal", &diagonal),
        ("oblique", &oblique),
        ("slanted", &turned(&serpentine, |[x, y]| [x + 0.3 * y, y])),
        ("steep", &turned(&one_way, |[x, y]| [x + 2.7 * y, y])),
        ("upwards", &turned(&serpentine, |[x, y]| [-x, -y])),
        ("gaps", &with_gaps(&serpentine, 3)),
        ("swaths", &swaths()),
        ("from the middle", &from_the_middle(&serpentine)),
    ] {
        scans.push(exact(name, places.clone()));
        for (share, seed) in [(1e-12, 1), (1e-6, 2), (1e-3, 3), (0.1, 4), (0.4, 5)] {
            scans.push(jittered(name, places, share, seed));
        }
    }
    scans
}

fn round() -> Vec<Scan> {
    let out = spiral(450, false);
    let inwards = spiral(450, true);
    let rosette = |petals: f64| -> Vec<Place> {
        (0..450).map(|i| polar(8.0 * (petals * step(i, 449.7)).sin(), step(i, 449.7))).collect()
    };
    vec![
        exact("spiral out", out),
        exact("spiral in", inwards),
        exact("rosette of five", rosette(5.0)),
        exact("rosette of seven halves", rosette(3.5)),
        exact("one circle", circles(1, 240)),
        exact("circles from inside", circles(6, 60)),
        exact("circles from outside", circles(6, 60).into_iter().rev().collect()),
        exact("circles of twelve nodes each", nodes_on_circles(20)),
        exact("an arc", (0..300).map(|i| polar(7.0, 0.3 * step(i, 300.0))).collect()),
        exact("spokes", spokes()),
    ]
}

fn crowded() -> Vec<Scan> {
    let mut rng = Pcg64::seed_from_u64(9);
    let clusters: Vec<Place> = (0..400)
        .map(|i| polar(5.0 + 1e-5 * unit(&mut rng), f64::from(i % 5) + 1e-5 * unit(&mut rng)))
        .collect();
    let island =
        |(x, y): (f64, f64)| lines(10, 10, true).into_iter().map(move |p| [p[0] + x, p[1] + y]);
    let islands: Vec<Place> = island((0.0, 0.0)).chain(island((1e4, 77.0))).collect();
    let return_trip: Vec<Place> =
        islands.iter().copied().chain(island((3.25, 9.5))).chain(island((-1e4, -1e4))).collect();
    let nodes: Vec<Place> =
        (0..500).map(|_| [unit(&mut rng), unit(&mut rng)].map(|on| (on * 14.0).floor())).collect();
    let lattice_in_disorder: Vec<Place> =
        (0..400).map(|i| [f64::from(i * 7 % 20), f64::from(i * 171 % 400 / 20)]).collect();
    vec![
        scattered("scattered", 500, 6),
        exact("clusters", clusters),
        exact("islands", islands),
        exact("islands and back", return_trip),
        exact("nodes, many twice", nodes),
        exact("a lattice in disorder", lattice_in_disorder),
    ]
}

/// Lines whose ends lie so that the front of what is measured is straight, bulges or is hollow.
fn fronts() -> Vec<Scan> {
    let bent = |bend: f64, taper: f64| -> Vec<Place> {
        lines(25, 18, true)
            .into_iter()
            .map(|[x, y]| {
                let off = x - 12.0;
                [12.0 + off * (1.0 + taper * y), y + bend * off * off]
            })
            .collect()
    };
    let zigzag = (0..400).map(|i| {
        let i = f64::from(i);
        [0.31 * i, 5.0 * (i % 10.0 - 4.5).abs() - 0.01 * i]
    });
    let line = (0..300).map(|i| [f64::from(i * 7 % 300) * 0.25, f64::from(i * 7 % 300) * 0.5]);
    let needle = (0..300).map(|i| [f64::from(i % 150), 1e-9 * f64::from(i / 150)]);
    vec![
        exact("bulging", bent(0.02, 0.0)),
        exact("hollow", bent(-0.02, 0.0)),
        exact("all but straight", bent(1e-15, 0.0)),
        exact("all but straight, hollow", bent(-1e-15, 0.0)),
        exact("widening", bent(0.0, 0.1)),
        exact("narrowing", bent(0.0, -0.05)),
        exact("widening and bulging", bent(0.02, 0.1)),
        exact("widening and hollow", bent(-0.02, 0.1)),
        exact("a smile around all before", smiles()),
        exact("zigzag", zigzag.collect()),
        exact("one line", line.clone().collect()),
        exact("one line and a point", line.chain([[10.0, 300.0]]).collect()),
        exact("two lines all but one", needle.collect()),
    ]
}

fn revisits() -> Vec<Scan> {
    let raster = lines(20, 12, true);
    let there_and_back: Vec<Place> = raster.iter().chain(raster.iter().rev()).copied().collect();
    let each_line_twice: Vec<Place> =
        raster.chunks(20).flat_map(|line| line.iter().chain(line.iter().rev())).copied().collect();
    let interleaved: Vec<Place> = lines(20, 20, true)
        .into_iter()
        .filter(|p| p[1] % 2.0 == 0.0)
        .chain(lines(20, 20, true).into_iter().filter(|p| p[1] % 2.0 == 1.0))
        .collect();
    let mut framed = frame(22.0, 14.0);
    framed.extend(raster.iter().map(|p| [p[0] + 1.0, p[1] + 1.0]));
    vec![
        exact("there and back", there_and_back),
        exact("each line twice", each_line_twice),
        exact("every other line first", interleaved.clone()),
        jittered("every other line first", &interleaved, 0.1, 7),
        exact("a frame and then its inside", framed.clone()),
        jittered("a frame and then its inside", &framed, 0.1, 8),
    ]
}

/// `rows` lines upwards of `columns` points each.
fn lines(columns: u32, rows: u32, there_and_back: bool) -> Vec<Place> {
    (0..rows * columns)
        .map(|i| {
            let (row, index) = (i / columns, i % columns);
            let back = there_and_back && row % 2 == 1;
            [f64::from(if back { columns - 1 - index } else { index }), f64::from(row)]
        })
        .collect()
}

/// Some spans of some lines left out.
fn with_gaps(places: &[Place], seed: u64) -> Vec<Place> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let spans = places.chunks(5).filter(|_| unit(&mut rng) > 0.3);
    spans.flatten().copied().collect()
}

/// Three fields side by side, of which the last overlaps with the second.
fn swaths() -> Vec<Place> {
    let field = |x: f64, y: f64| lines(9, 18, true).into_iter().map(move |p| [p[0] + x, p[1] + y]);
    field(0.0, 0.0).chain(field(9.0, 0.5)).chain(field(15.5, -0.25)).collect()
}

/// The upper half first, then the lower half downwards.
fn from_the_middle(places: &[Place]) -> Vec<Place> {
    let middle = places.len() / 2;
    let (lower, upper) = places.split_at(middle);
    upper.iter().chain(lower.iter().rev()).copied().collect()
}

fn spiral(count: u32, inwards: bool) -> Vec<Place> {
    let outwards = (0..count).map(|i| {
        let turn = (2.0 * TAU * f64::from(i)).sqrt();
        [turn / TAU * turn.cos(), turn / TAU * turn.sin()]
    });
    if inwards { outwards.rev().collect() } else { outwards.collect() }
}

fn circles(rings: u32, count: u32) -> Vec<Place> {
    (0..rings * count)
        .map(|i| polar(f64::from(1 + i / count), step(i % count, f64::from(count))))
        .collect()
}

/// Twelve whole nodes on each circle: no rounding parts them.
fn nodes_on_circles(rings: u32) -> Vec<Place> {
    (1..=rings)
        .flat_map(|ring| {
            let radius = f64::from(ring);
            [[5.0, 0.0], [4.0, 3.0], [3.0, 4.0]].map(|[x, y]| [x * radius, y * radius])
        })
        .flat_map(|[x, y]| [[x, y], [-y, x], [-x, -y], [y, -x]])
        .collect()
}

/// Diameters of a disc, one after another.
fn spokes() -> Vec<Place> {
    (0..20)
        .flat_map(|spoke| (-10..=10).map(move |i| polar(f64::from(i), step(spoke, 40.0))))
        .collect()
}

/// Each line passes below all before it and ends above it on both sides.
fn smiles() -> Vec<Place> {
    (1..16)
        .flat_map(|row| {
            let size = f64::from(row);
            (-10..=10).map(move |i| {
                let across = f64::from(i) / 10.0;
                [size * size * across, 0.8 * size * size * across * across - size]
            })
        })
        .collect()
}

/// The outline of a rectangle, counter-clockwise.
fn frame(width: f64, height: f64) -> Vec<Place> {
    let along = |length: f64| (0..length as u32).map(f64::from);
    along(width)
        .map(|x| [x, 0.0])
        .chain(along(height).map(|y| [width, y]))
        .chain(along(width).map(|x| [width - x, height]))
        .chain(along(height).map(|y| [0.0, height - y]))
        .collect()
}

fn polar(radius: f64, angle: f64) -> Place {
    [radius * angle.cos(), radius * angle.sin()]
}

/// The angle of step `index` of `count` around the circle.
fn step(index: u32, count: f64) -> f64 {
    TAU * f64::from(index) / count
}

fn exact(name: &str, places: Vec<Place>) -> Scan {
    let points = places.into_iter().map(|[x, y]| [x, y, 0.0]).collect();
    Scan { name: name.to_owned(), points, general: false }
}

/// Each coordinate moved by up to `share` of a step to either side.
fn jittered(name: &str, places: &[Place], share: f64, seed: u64) -> Scan {
    let mut rng = Pcg64::seed_from_u64(seed);
    let points = places
        .iter()
        .map(|place| place.map(|on| on / SQRT_2 + share * (2.0 * unit(&mut rng) - 1.0)))
        .map(|[x, y]| [x, y, 0.0])
        .collect();
    // Less is not much above the rounding of a coordinate.
    Scan { name: format!("{name}, jitter {share}"), points, general: share >= 1e-6 }
}

fn scattered(name: &str, count: u32, seed: u64) -> Scan {
    let mut rng = Pcg64::seed_from_u64(seed);
    let points = (0..count).map(|_| [16.0 * unit(&mut rng), 16.0 * unit(&mut rng), 0.0]).collect();
    Scan { name: name.to_owned(), points, general: true }
}

/// Evenly distributed from 0 to below 1.
fn unit(rng: &mut Pcg64) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}
