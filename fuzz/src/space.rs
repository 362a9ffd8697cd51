//! Clouds in space a fuzzer can draw, and what must hold for every surface through them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use arbitrary::Arbitrary;
use asphera_geometry::{PointMm, TINY_MM};
use asphera_reconstruct::{
    Delaunay, FaceRule, GraphChoices, LandmarkOrder, LeftOut, LiveGraph, LocalSurface, PointGraph,
    Reconstruction, TileShelf, TileShelfFailure, TiledGraph, Unsound,
    alpha_shape, check_delaunay, cocone, convection, loc_cocone, local, natural, prove,
    robust_cocone, sculpture, super_cocone, tangential, wrap,
};
use rayon::ThreadPool;

/// Points, what becomes of all of them, a method and batches.
#[derive(Arbitrary, Debug)]
pub struct Cloud {
    pieces: Vec<Piece>,
    shift: u8,
    power: i8,
    method: u8,
    size: u8,
    batches: Vec<u8>,
}

/// Places that lie regularly, or nearly so.
#[derive(Arbitrary, Clone, Copy, Debug)]
enum Piece {
    Lattice(i8, i8, i8),
    /// All lie on a sphere of radius 3 exactly: (±1, ±2, ±2) and (±3, 0, 0) in any order.
    Sphere(u8),
    /// A turn of a spiral on a ball, by a radius and a number of points.
    Spiral(u8, u8),
    /// A raster on a cylinder, or on a plane where the radius is 0.
    Raster(u8, u8),
    /// Both rings of a torus with exact ties.
    Rings(u8),
    /// The last place moved by so many units in the last place.
    Beside(i8, i8, i8),
    Anywhere(f32, f32, f32),
}

/// What a cloud has at most.
const MOST_POINTS: usize = 96;

impl Piece {
    fn add_to(self, places: &mut Vec<PointMm>) {
        match self {
            Piece::Lattice(x, y, z) => places.push([x, y, z].map(|value| f64::from(value % 5))),
            Piece::Sphere(number) => places.push(on_sphere(number)),
            Piece::Spiral(radius, count) => {
                let (radius, count) = (f64::from(1 + radius % 8), 8 + usize::from(count % 48));
                places.extend((0..count).map(|at| {
                    let z = 1.0 - (2 * at + 1) as f64 / count as f64;
                    let (sin, cos) = (2.4 * at as f64).sin_cos();
                    let across = (1.0 - z * z).sqrt();
                    [across * cos, across * sin, z].map(|value| radius * value)
                }));
            }
            Piece::Raster(radius, side) => {
                let (radius, side) = (f64::from(radius % 4), 2 + usize::from(side % 7));
                places.extend((0..side * side).map(|at| {
                    let (x, y) = ((at % side) as f64, (at / side) as f64);
                    if radius == 0.0 {
                        [x, y, 0.0]
                    } else {
                        [radius * x.cos(), radius * x.sin(), y]
                    }
                }));
            }
            Piece::Rings(count) => {
                let count = 3 + usize::from(count % 10);
                let ring = |radius: f64, z: f64| {
                    (0..count).map(move |at| {
                        let turn = at as f64 / count as f64 * std::f64::consts::TAU;
                        [radius * turn.cos(), radius * turn.sin(), z]
                    })
                };
                places.extend(ring(4.0, 1.0).chain(ring(4.0, -1.0)).chain(ring(3.0, 0.0)));
            }
            Piece::Beside(x, y, z) => {
                let last = places.last().copied().unwrap_or([1.0; 3]);
                let steps = [x, y, z];
                places.push(std::array::from_fn(|axis| {
                    let bits = last[axis].to_bits() as i64;
                    f64::from_bits(bits.wrapping_add(i64::from(steps[axis] % 3)) as u64)
                }));
            }
            Piece::Anywhere(x, y, z) => places.push([x, y, z].map(f64::from)),
        }
    }
}

/// One of the 30 places with whole coordinates on the sphere of radius 3.
fn on_sphere(number: u8) -> PointMm {
    let sign = |bit: u8| if number >> bit & 1 == 0 { 1.0 } else { -1.0 };
    let axis = usize::from(number >> 3) % 3;
    let is_pole = number >> 5 & 3 == 3;
    let mut place = if is_pole { [0.0; 3] } else { [2.0 * sign(0), 2.0 * sign(1), 2.0 * sign(2)] };
    place[axis] = sign(axis as u8) * if is_pole { 3.0 } else { 1.0 };
    place
}

impl Cloud {
    fn places_mm(&self) -> Vec<PointMm> {
        let mut places = Vec::new();
        for piece in self.pieces.iter().take(MOST_POINTS) {
            piece.add_to(&mut places);
        }
        places.truncate(MOST_POINTS);
        let scale = 2_f64.powi(i32::from(self.power % 40));
        let shift = [0.0, 1e3, 1e9][usize::from(self.shift % 3)];
        for value in places.as_flattened_mut() {
            *value = *value * scale + shift;
        }
        places
    }
}

/// The surface of one method, or why there is none.
type Method = fn(&[PointMm], usize) -> Result<Reconstruction, String>;

const METHODS: [(&str, Method); 11] = [
    ("alpha", |points, size| words(alpha_shape(points, size as f64 / 8.0)).map(|it| it.surface)),
    ("cocone", |points, _| words(cocone(points)).map(|it| it.surface)),
    ("convection", |points, _| words(convection(points))),
    (GRAPH, |points, size| {
        let (neighbours, choices) = graph_choices(size);
        let graph = words(PointGraph::new(points, neighbours, &mut |_| {}))?;
        words(graph.surface(&choices, &mut |_| {})).map(|it| it.reconstruction)
    }),
    ("loccocone", |points, size| words(loc_cocone(points, 8 + size)).map(|it| it.cocone.surface)),
    ("natural", |points, _| words(natural(points)).map(|it| it.surface)),
    ("robust-cocone", |points, _| words(robust_cocone(points)).map(|it| it.surface)),
    ("sculpture", |points, _| words(sculpture(points))),
    ("super-cocone", |points, size| {
        words(super_cocone(points, 8 + size)).map(|it| it.cocone.surface)
    }),
    ("tangential", |points, _| words(tangential(points)).map(|it| it.surface)),
    ("wrap", |points, _| words(wrap(points, None)).map(|it| it.surface)),
];

const GRAPH: &str = "graph";

fn graph_choices(size: usize) -> (usize, GraphChoices) {
    let (hops, threshold) = (1 + (size % 4) as u8, (size / 64) as u32);
    (1 + size % 20, GraphChoices { hops, threshold, ..GraphChoices::default() })
}

/// Words of a refusal, which must be short and readable.
fn words<T, E: std::fmt::Display>(made: Result<T, E>) -> Result<T, String> {
    made.map_err(|refused| {
        let words = refused.to_string();
        assert!((10..400).contains(&words.len()) && !words.contains(char::is_control), "{words}");
        words
    })
}

/// Every method answers with a surface of these points or in words, and the order of points, batches and threads change nothing.
pub fn hold(cloud: &Cloud) {
    let places = cloud.places_mm();
    let backwards: Vec<PointMm> = places.iter().rev().copied().collect();
    tetrahedra(&places, &backwards);
    of_local(&places, &backwards, &cloud.batches);
    let (name, method) = METHODS[usize::from(cloud.method) % METHODS.len()];
    let size = usize::from(cloud.size);
    if name == GRAPH {
        of_graph(&places, size, &cloud.batches);
    }
    match (method(&places, size), method(&backwards, size)) {
        (Ok(found), Ok(other)) => {
            is_of(&places, &found, name);
            assert_eq!(by_places(&places, &found), by_places(&backwards, &other), "{name}");
        }
        (Err(found), Err(other)) => assert_eq!(found, other, "{name}"),
        (found, other) => panic!("{name}: {found:?} or {other:?}, by the order of points"),
    }
}

/// The triangulation is Delaunay by exact arithmetic, and the same from behind.
fn tetrahedra(places: &[PointMm], backwards: &[PointMm]) {
    let sorted = |points: &[PointMm]| {
        words(Delaunay::new(points)).map(|found| {
            let tetrahedra = found.tetrahedra();
            // The check knows no places that are none, and no place twice.
            let left_out: BTreeSet<u32> =
                found.left_out().iter().map(|&(point, _)| point).collect();
            let is_used = |&point: &u32| !left_out.contains(&point);
            let used: Vec<u32> = (0..points.len() as u32).filter(is_used).collect();
            let admitted = |&point: &u32| place_bits(points[point as usize]).map(f64::from_bits);
            let places: Vec<PointMm> = used.iter().map(admitted).collect();
            let number = |corner: u32| used.binary_search(&corner).expect("a used point") as u32;
            let numbered: Vec<[u32; 4]> = tetrahedra.iter().map(|all| all.map(number)).collect();
            // Between places that are neighbours in doubles the check has nowhere to stand.
            match check_delaunay(&places, &numbered) {
                Ok(()) | Err(Unsound::NoInnerPlace) => {}
                Err(unsound) => panic!("{unsound}: {places:?}"),
            }
            let bits = |corners: &[u32; 4]| {
                let mut bits = corners.map(|corner| place_bits(points[corner as usize]));
                bits.sort_unstable();
                bits
            };
            tetrahedra.iter().map(bits).collect::<BTreeSet<_>>()
        })
    };
    assert_eq!(sorted(places), sorted(backwards));
}

/// The local surface in batches is that of all points at once, and the same from behind and on two threads.
fn of_local(places: &[PointMm], backwards: &[PointMm], batches: &[u8]) {
    let expected = local(places).expect("few points");
    is_of(places, &expected, "local");
    let mut surface = LocalSurface::new();
    let mut left = places;
    let mut sizes =
        batches.iter().map(|&size| usize::from(size)).chain(std::iter::once(places.len()));
    while !left.is_empty() {
        let (batch, after) = left.split_at(left.len().min(sizes.next().unwrap_or(left.len())));
        surface.insert(batch).expect("few points");
        left = after;
    }
    assert_eq!(surface.surface(), expected);
    let other = TWO_THREADS.install(|| local(backwards)).expect("few points");
    assert_eq!(by_places(places, &expected), by_places(backwards, &other));
}

/// The graph method in batches and by tiles gives what it gives of all points.
fn of_graph(places: &[PointMm], size: usize, batches: &[u8]) {
    let (neighbours, sweep) = graph_choices(size);
    let priority = GraphChoices { order: LandmarkOrder::Priority, ..sweep };
    let mut live = LiveGraph::new(neighbours, priority.hops).expect("numbers within range");
    let mut left = places;
    let sizes = batches.iter().map(|&size| usize::from(size));
    for size in sizes.chain(std::iter::once(places.len())) {
        let (batch, after) = left.split_at(left.len().min(size));
        live.insert(batch).expect("few points");
        left = after;
    }
    let graph = PointGraph::new(places, neighbours, &mut |_| {}).expect("numbers within range");
    let at_once = |choices| graph.surface(choices, &mut |_| {}).expect("numbers within range");
    assert_eq!(live.surface(priority.threshold, FaceRule::Filled), at_once(&priority));

    let mut tiles = TiledGraph::new(Pieces::default(), neighbours, 1 + size % 70).expect("numbers");
    tiles.take(places).expect("a shelf that holds");
    let found = tiles.surface(&sweep, &mut |_| {}).expect("a shelf that holds");
    let mut expected = at_once(&sweep);
    expected.map.cells.clear();
    assert_eq!((found.map, found.no_surface), (expected.map, expected.no_surface));
    let numbers = |facet: &[u32; 3]| facet.map(|corner| found.numbers[corner as usize]);
    let facets: Vec<[u32; 3]> = found.facets.iter().map(numbers).collect();
    assert_eq!(facets, expected.reconstruction.facets);
}

/// Pieces of tiles in memory.
#[derive(Default)]
struct Pieces(BTreeMap<u32, Vec<u8>>);

impl TileShelf for Pieces {
    fn put(&mut self, piece: u32, bytes: &[u8]) -> Result<(), TileShelfFailure> {
        self.0.insert(piece, bytes.to_vec());
        Ok(())
    }

    fn get(&mut self, piece: u32, bytes: &mut Vec<u8>) -> Result<(), TileShelfFailure> {
        bytes.clone_from(self.0.get(&piece).ok_or("no such piece")?);
        Ok(())
    }

    fn forget(&mut self, piece: u32) {
        self.0.remove(&piece);
    }
}

static TWO_THREADS: LazyLock<ThreadPool> =
    LazyLock::new(|| rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("two threads"));

/// Facets join points, each point is a corner or listed once, and the surface can be proved.
fn is_of(points: &[PointMm], found: &Reconstruction, name: &str) {
    assert!(found.facets.is_sorted_by_key(|facet| facet[0]), "{name}");
    let corners: BTreeSet<u32> = found.facets.as_flattened().iter().copied().collect();
    let mut listed: BTreeSet<u32> = BTreeSet::new();
    for &(point, why) in &found.left_out {
        assert!(listed.insert(point) && !corners.contains(&point), "{name}: {point} twice");
        let is_place = points[point as usize].iter().all(|value| value.abs() <= 1e12);
        assert_eq!(why == LeftOut::NoPlace, !is_place, "{name}: {point} {why:?}");
    }
    assert_eq!(corners.len() + listed.len(), points.len(), "{name}: points without a word");
    let proof = prove(points, &found.facets).expect("corners are points");
    let joined = proof.vertices as i64 - proof.edges as i64 + proof.facets as i64;
    assert_eq!((proof.vertices, proof.facets), (corners.len(), found.facets.len()), "{name}");
    assert!(proof.euler == joined && proof.area_mm2 >= 0.0, "{name}: {proof:?}");
    if let Some(genus) = proof.genus.filter(|_| proof.is_closed && proof.is_manifold) {
        assert_eq!(2 * proof.components as i64 - 2 * genus, proof.euler, "{name}");
    }
}

fn place_bits(place: PointMm) -> [u64; 3] {
    // What is tiny counts as 0, which has two signs.
    place.map(|value| if value.abs() < TINY_MM { 0 } else { value.to_bits() })
}

fn by_places(points: &[PointMm], found: &Reconstruction) -> Vec<[[u64; 3]; 3]> {
    let mut all: Vec<_> = found
        .facets
        .iter()
        .map(|facet| {
            let mut places = facet.map(|corner| place_bits(points[corner as usize]));
            places.sort_unstable();
            places
        })
        .collect();
    all.sort_unstable();
    all
}
