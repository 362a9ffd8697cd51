//! Areas, points in them and figures of merit of the comparison of region methods: no data needed.

use std::collections::HashMap;
use std::f64::consts::TAU;

use asphera_geometry::Numbers;
use asphera_geometry::outline::Outline;

use crate::{
    Method, MethodError, Parameters, PlaceMm, Samples, Triangulation, intersection_over_union,
};

/// An area of some 20 mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A disc.
    Disc,
    /// A smooth closed curve, made at random.
    Blob,
    /// A star with five sharp tips.
    Star,
    /// A letter E: corners, and bays between its arms.
    Letter,
    /// Three quarters of a ring: a narrow mouth.
    Horseshoe,
    /// A ring.
    Ring,
    /// A plate with three bores.
    Plate,
    /// A disc and a square apart.
    Parts,
}

/// How points lie in an area. Sparse is four times as far apart as dense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Each place as likely as the next.
    Random,
    /// A square raster, shifted and turned at random.
    Raster,
    /// Border and interior dense.
    DenseDense,
    /// A dense border round a sparse interior.
    DenseSparse,
    /// A sparse border round a dense interior.
    SparseDense,
    /// Border and interior sparse.
    SparseSparse,
}

/// Points in an area that is known.
pub struct RegionTrial {
    /// The points.
    pub triangulation: Triangulation,
    outlines: Vec<Outline>,
}

/// Figures of a region against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionScore {
    /// Area that is in one of both only over the true area: the L² error norm of Peethambaran & Muthuganapathy 2015.
    pub l2: f64,
    /// Common area over the area of either.
    pub iou: f64,
    /// Whether the region has as many parts and holes as the truth.
    pub topology: bool,
}

impl Shape {
    /// All of them.
    pub const ALL: [Shape; 8] = [
        Shape::Disc,
        Shape::Blob,
        Shape::Star,
        Shape::Letter,
        Shape::Horseshoe,
        Shape::Ring,
        Shape::Plate,
        Shape::Parts,
    ];

    /// The name on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Shape::Disc => "disc",
            Shape::Blob => "blob",
            Shape::Star => "star",
            Shape::Letter => "letter",
            Shape::Horseshoe => "horseshoe",
            Shape::Ring => "ring",
            Shape::Plate => "plate",
            Shape::Parts => "parts",
        }
    }

    /// About so many points in it; the same seed and number give the same. With a border that has points of its own their number
    /// follows from the spacing that so many points have all over the area.
    pub fn trial(
        &self,
        distribution: Distribution,
        points: usize,
        seed: u64,
        number: u32,
    ) -> RegionTrial {
        let outlines = self.outlines(&Numbers::new(seed, number, 32));
        RegionTrial::laid(outlines, distribution, points, (seed, number))
    }

    fn outlines(&self, numbers: &Numbers) -> Vec<Outline> {
        let circle = |middle: PlaceMm, radius_mm: f64| polar(middle, 360, |_| radius_mm);
        let (lines, holes) = match self {
            Shape::Disc => (vec![circle([0.0; 2], 10.0)], vec![]),
            Shape::Blob => {
                let waves: Vec<[f64; 2]> = (0..5)
                    .map(|k| [numbers.uniform(2 * k), TAU * numbers.uniform(2 * k + 1)])
                    .collect();
                let radius_mm = |share: f64| {
                    let wave = |(k, [size, phase]): (usize, &[f64; 2])| {
                        size * ((k + 2) as f64 * TAU * share + phase).sin() / (k + 2) as f64
                    };
                    8.0 + 3.0 * waves.iter().enumerate().map(wave).sum::<f64>()
                };
                (vec![polar([0.0; 2], 360, radius_mm)], vec![])
            }
            Shape::Star => {
                let radius_mm =
                    |share: f64| if (10.0 * share).round() % 2.0 == 0.0 { 10.0 } else { 4.5 };
                (vec![polar([0.0; 2], 10, radius_mm)], vec![])
            }
            Shape::Letter => (vec![LETTER.to_vec()], vec![]),
            Shape::Horseshoe => {
                let arc = |radius_mm: f64, steps: std::ops::RangeInclusive<u32>| {
                    steps.map(move |step| {
                        let (sin, cos) = (TAU * f64::from(step) / 360.0).sin_cos();
                        [radius_mm * cos, radius_mm * sin]
                    })
                };
                let inner: Vec<PlaceMm> = arc(5.0, 45..=315).collect();
                (vec![arc(10.0, 45..=315).chain(inner.into_iter().rev()).collect()], vec![])
            }
            Shape::Ring => (vec![circle([0.0; 2], 10.0)], vec![circle([0.0; 2], 5.0)]),
            Shape::Plate => {
                let corners = vec![[-10.0, -6.0], [10.0, -6.0], [10.0, 6.0], [-10.0, 6.0]];
                let bores = [([-6.0, 0.0], 2.0), ([0.0, 2.0], 2.5), ([6.0, -1.0], 3.0)];
                (vec![corners], bores.map(|(middle, radius)| circle(middle, radius)).to_vec())
            }
            Shape::Parts => {
                let square = vec![[4.0, -5.0], [13.0, -5.0], [13.0, 4.0], [4.0, 4.0]];
                (vec![circle([-6.0, 0.0], 6.0), square], vec![])
            }
        };
        // Drawn here: no line meets another.
        let sound = |outer: Vec<PlaceMm>| {
            Outline::new(&outer, &holes).unwrap_or_else(|_| unreachable!("lines that do not meet"))
        };
        lines.into_iter().map(sound).collect()
    }
}

impl Distribution {
    /// All of them.
    pub const ALL: [Distribution; 6] = [
        Distribution::Random,
        Distribution::Raster,
        Distribution::DenseDense,
        Distribution::DenseSparse,
        Distribution::SparseDense,
        Distribution::SparseSparse,
    ];

    /// Its name; of those with a border of its own the seed's: dense or sparse border, dense or sparse interior.
    pub fn name(&self) -> &'static str {
        match self {
            Distribution::Random => "random",
            Distribution::Raster => "raster",
            Distribution::DenseDense => "DBDI",
            Distribution::DenseSparse => "DBSI",
            Distribution::SparseDense => "SBDI",
            Distribution::SparseSparse => "SBSI",
        }
    }
}

impl RegionTrial {
    /// About so many points in areas of some 20 mm about the origin.
    pub(super) fn laid(
        outlines: Vec<Outline>,
        distribution: Distribution,
        points: usize,
        (seed, number): (u64, u32),
    ) -> RegionTrial {
        let numbers = Numbers::new(seed, number, 33 + distribution as u32);
        let area_mm2: f64 = outlines.iter().map(Outline::area_mm2).sum();
        let spacing_mm = (area_mm2 / points as f64).sqrt();
        let [border_mm, interior_mm] = match distribution {
            Distribution::Random | Distribution::Raster => [0.0; 2],
            Distribution::DenseDense => [0.5; 2],
            Distribution::DenseSparse => [0.5, 2.0],
            Distribution::SparseDense => [2.0, 0.5],
            Distribution::SparseSparse => [2.0; 2],
        }
        .map(|factor: f64| factor * spacing_mm);
        let places = match distribution {
            Distribution::Random => at_random(&outlines, &numbers).take(points).collect(),
            Distribution::Raster => raster(&outlines, spacing_mm, &numbers),
            _ => {
                let mut places = borders(&outlines, border_mm);
                apart(&outlines, interior_mm, &numbers, &mut places);
                places
            }
        };
        // Made here: finite and few.
        let samples = Samples::new(&places).unwrap_or_else(|_| unreachable!("finite places"));
        RegionTrial { triangulation: Triangulation::new(samples), outlines }
    }

    /// The true lines in mm: outlines counter-clockwise, holes clockwise.
    pub fn truth_mm(&self) -> Vec<Vec<PlaceMm>> {
        self.outlines.iter().flat_map(|outline| outline.rings().to_vec()).collect()
    }

    /// The figures of a method with its defaults. A region without area has `l2` 1.
    ///
    /// # Errors
    ///
    /// As [`Method::run`].
    pub fn score(&self, method: Method) -> Result<RegionScore, MethodError> {
        let set = &self.triangulation;
        let Some(found) = method.region(set, &Parameters::new())? else {
            return Ok(RegionScore { l2: 1.0, iou: 0.0, topology: false });
        };
        let truth = self.truth_mm();
        let lines: Vec<Vec<PlaceMm>> =
            found.parts().iter().flat_map(|part| part.lines_mm(set.samples())).collect();
        let true_mm2: f64 = self.outlines.iter().map(Outline::area_mm2).sum();
        let both_mm2 = true_mm2 + found.area_mm2(set.samples());
        let iou = intersection_over_union(&lines, &truth).unwrap_or(0.0);
        let common_mm2 = iou * both_mm2 / (1.0 + iou);
        let holes: usize = found.parts().iter().map(|part| part.holes.len()).sum();
        Ok(RegionScore {
            l2: (both_mm2 - 2.0 * common_mm2) / true_mm2,
            iou,
            topology: found.parts().len() == self.outlines.len()
                && holes + self.outlines.len() == truth.len(),
        })
    }
}

/// A closed line by its distance from a place at equal angles, which it is given as shares of a turn.
fn polar(middle: PlaceMm, count: u32, radius_mm: impl Fn(f64) -> f64) -> Vec<PlaceMm> {
    let place = |step: u32| {
        let share = f64::from(step) / f64::from(count);
        let (sin, cos) = (TAU * share).sin_cos();
        let radius_mm = radius_mm(share);
        [middle[0] + radius_mm * cos, middle[1] + radius_mm * sin]
    };
    (0..count).map(place).collect()
}

fn is_in(outlines: &[Outline], place: PlaceMm) -> bool {
    outlines.iter().any(|outline| outline.contains(place))
}

/// Places at random, without end.
fn at_random<'a>(
    outlines: &'a [Outline],
    numbers: &'a Numbers,
) -> impl Iterator<Item = PlaceMm> + 'a {
    let place = |k: usize| [2 * k, 2 * k + 1].map(|index| EXTENT_MM * numbers.uniform(index));
    let all = (0..).map(place).map(|[x, y]| [x - 0.5 * EXTENT_MM, y - 0.5 * EXTENT_MM]);
    all.filter(|&place| is_in(outlines, place))
}

fn raster(outlines: &[Outline], spacing_mm: f64, numbers: &Numbers) -> Vec<PlaceMm> {
    let (sin, cos) = (TAU * numbers.uniform(0)).sin_cos();
    let shift = [numbers.uniform(1), numbers.uniform(2)];
    let rows = (EXTENT_MM / spacing_mm) as i32;
    let nodes = (-rows..=rows).flat_map(|i| (-rows..=rows).map(move |j| [i, j]));
    let places = nodes.map(|node| {
        let [x, y] = [0, 1].map(|axis| spacing_mm * (f64::from(node[axis]) + shift[axis]));
        [cos * x - sin * y, sin * x + cos * y]
    });
    places.filter(|&place| is_in(outlines, place)).collect()
}

/// Places along all lines, at their corners and no farther apart than the spacing.
fn borders(outlines: &[Outline], spacing_mm: f64) -> Vec<PlaceMm> {
    let mut places = Vec::new();
    for ring in outlines.iter().flat_map(Outline::rings) {
        let mut since_mm = f64::INFINITY;
        for (p, q) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let length_mm = (q[0] - p[0]).hypot(q[1] - p[1]);
            // Corners of a curve are nearer to each other than samples are.
            if since_mm + length_mm > spacing_mm {
                places.push(*p);
                since_mm = 0.0;
            }
            let steps = (length_mm / spacing_mm).ceil() as usize;
            for step in 1..steps {
                let share = step as f64 / steps as f64;
                places.push([0, 1].map(|axis| p[axis] + share * (q[axis] - p[axis])));
            }
            since_mm += if steps > 1 { length_mm / steps as f64 } else { length_mm };
        }
    }
    places
}

/// Adds places of the interior no nearer to each other than 0.7 of the spacing, as many as chance finds room for.
fn apart(outlines: &[Outline], spacing_mm: f64, numbers: &Numbers, places: &mut Vec<PlaceMm>) {
    let least_mm = 0.7 * spacing_mm;
    let cell = |place: PlaceMm| place.map(|mm| (mm / least_mm).floor() as i64);
    let mut cells: HashMap<[i64; 2], Vec<PlaceMm>> = HashMap::new();
    for &place in &*places {
        cells.entry(cell(place)).or_default().push(place);
    }
    let area_mm2: f64 = outlines.iter().map(Outline::area_mm2).sum();
    let tries = (TRIES * area_mm2 / (spacing_mm * spacing_mm)) as usize;
    for place in at_random(outlines, numbers).take(tries) {
        let [i, j] = cell(place);
        let mut beside = (-1..=1).flat_map(|di| (-1..=1).map(move |dj| [i + di, j + dj]));
        let is_near = |other: &PlaceMm| (other[0] - place[0]).hypot(other[1] - place[1]) < least_mm;
        let near = beside.any(|at| cells.get(&at).is_some_and(|held| held.iter().any(is_near)));
        if !near {
            cells.entry([i, j]).or_default().push(place);
            places.push(place);
        }
    }
}

/// Side of the square about all shapes.
pub(super) const EXTENT_MM: f64 = 28.0;
/// Places that are tried for each one there is room for.
const TRIES: f64 = 20.0;
/// An E.
const LETTER: [PlaceMm; 12] = [
    [-6.0, -10.0],
    [6.0, -10.0],
    [6.0, -6.0],
    [-2.0, -6.0],
    [-2.0, -2.0],
    [4.0, -2.0],
    [4.0, 2.0],
    [-2.0, 2.0],
    [-2.0, 6.0],
    [6.0, 6.0],
    [6.0, 10.0],
    [-6.0, 10.0],
];
