//! Slopes of the deviation over an integration length.

use asphera_geometry::BoundsMm;
use rayon::prelude::*;

use super::unknown::positive;
use super::{Definition, Figure, Sample, SettingError, Unknown};

/// Over which length slopes are formed and how densely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeSettings {
    integration_mm: f64,
    step_mm: f64,
}

impl SlopeSettings {
    /// The integration length is the diameter of the disc a slope is formed over, the sampling step the
    /// distance of the stations, both in mm. Fails unless both are positive and finite.
    pub fn new(integration_mm: f64, step_mm: f64) -> Result<SlopeSettings, SettingError> {
        Ok(SlopeSettings {
            integration_mm: positive("integration length", integration_mm)?,
            step_mm: positive("sampling step", step_mm)?,
        })
    }

    /// The integration length in mm.
    pub fn integration_mm(&self) -> f64 {
        self.integration_mm
    }

    /// The integration length in words, to 0.1 µm: `over 1 mm`.
    pub fn scope(&self) -> String {
        format!("over {} mm", (self.integration_mm * 1e4).round() / 1e4)
    }

    /// The sampling step in mm.
    pub fn step_mm(&self) -> f64 {
        self.step_mm
    }
}

/// The largest and the RMS slope of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeFigure {
    /// Largest size in µrad.
    pub max_urad: f64,
    /// RMS over the stations in µrad.
    pub rms_urad: f64,
    /// The station of the largest, part frame, mm; of equal ones the first by y, then x.
    pub at_mm: [f64; 2],
    /// RMS over the stations in µrad that independent noise of 1 nm at every point makes on the average.
    pub noise_rms_urad: f64,
    /// RMS in µrad of what such noise makes at the station where it makes most.
    pub noise_most_urad: f64,
}

impl SlopeFigure {
    /// The RMS slope in µrad without what independent noise of a point in nm adds to it, in squares, on the average; 0
    /// where noise makes all of it.
    pub fn rms_without_noise_urad(&self, noise_nm: f64) -> f64 {
        let added = noise_nm * self.noise_rms_urad;
        (self.rms_urad * self.rms_urad - added * added).max(0.0).sqrt()
    }

    /// What independent noise of a point in nm raises the largest slope by, at most, on the average: the largest slope of
    /// noise alone at as many stations, s·√(2·ln 2n) with s of the worst (Boucheron, Lugosi & Massart, Concentration
    /// Inequalities, theorem 2.5). Of a gradient both components.
    pub fn noise_on_max_urad(&self, noise_nm: f64, stations: usize) -> f64 {
        noise_nm * self.noise_most_urad * (2.0 * (2.0 * stations as f64).ln()).sqrt()
    }
}

/// Slope errors of a deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes {
    /// How they were formed.
    pub settings: SlopeSettings,
    /// Along the meridian, that is the direction from the axis; on the axis along the steepest.
    pub meridional: SlopeFigure,
    /// The gradient, whatever its direction.
    pub gradient: SlopeFigure,
    /// Stations in the aperture with a slope.
    pub stations: usize,
    /// Stations in the aperture without one, because no points lie all around them within the disc.
    pub unmeasured: usize,
}

impl Slopes {
    /// The largest and RMS slopes.
    pub fn figures(&self) -> [Figure; 4] {
        [
            Figure::new(Definition::MeridionalSlopeMax, self.meridional.max_urad),
            Figure::new(Definition::MeridionalSlopeRms, self.meridional.rms_urad),
            Figure::new(Definition::GradientMax, self.gradient.max_urad),
            Figure::new(Definition::GradientRms, self.gradient.rms_urad),
        ]
    }
}

/// Slopes at stations of a square grid through the vertex: each that of the area-weighted least-squares
/// plane through the deviations of the points in the disc about it. Per mm of projected length.
///
/// Over a disc of radius a, a wave of k rad/mm keeps the share 8·J₂(ka)/(ka)² of its slope: half of it
/// at a wavelength of 1.14 integration lengths.
/// A station has a slope if its disc holds at least 6 points that surround it: centroid within a quarter of
/// the radius, and in no direction less than half the mean square extent of a full disc. So stations whose
/// disc reaches far into a gap or beyond the border are left out and counted.
///
/// `O(n·(length/step)²)`. Unknown if the stations are more than four million, or none has a slope.
pub fn slopes(sample: &Sample, settings: SlopeSettings) -> Result<Slopes, Unknown> {
    if sample.is_empty() {
        return Err(Unknown::NoPoints);
    }
    let [low, high] = bounds(sample);
    let step_mm = settings.step_mm;
    let ends = |axis: usize| [(low[axis] / step_mm).ceil(), (high[axis] / step_mm).floor()];
    let (along_x, along_y) = (ends(0), ends(1));
    let wanted = (along_x[1] - along_x[0] + 1.0) * (along_y[1] - along_y[0] + 1.0);
    if wanted > MOST_STATIONS as f64 {
        return Err(Unknown::TooManyStations { wanted, allowed: MOST_STATIONS, step_mm });
    }
    let cells = Cells::new(sample, 0.5 * settings.integration_mm);
    let line = |axis: [f64; 2]| {
        (axis[0] as i64..=axis[1] as i64).map(move |i| i as f64 * step_mm).collect::<Vec<f64>>()
    };
    let xs = line(along_x);
    let rows: Vec<Row> = line(along_y)
        .into_par_iter()
        .map(|y| {
            let mut row = Row::default();
            for &x in xs.iter().filter(|&&x| sample.aperture().contains(x, y)) {
                match cells.gradient([x, y]) {
                    Some(plane) => row.add([x, y], &plane),
                    None => row.unmeasured += 1,
                }
            }
            row
        })
        .collect();
    let mut all = Row::default();
    rows.iter().for_each(|row| all.join(row));
    let stations = all.stations;
    let (Some(meridional), Some(gradient)) =
        (all.meridional.figure(stations), all.gradient.figure(stations))
    else {
        let integration_mm = settings.integration_mm;
        return Err(Unknown::Unsupported { stations: all.unmeasured, integration_mm });
    };
    Ok(Slopes { settings, meridional, gradient, stations, unmeasured: all.unmeasured })
}

/// Lowest and highest x and y of the aperture; of the sample where there is none.
fn bounds(sample: &Sample) -> [[f64; 2]; 2] {
    let Some(half) = sample.aperture().half_extents_mm() else {
        return box_of(sample.places_mm());
    };
    [half.map(|half| -half), half]
}

fn box_of(places_mm: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let BoundsMm { low, high } = BoundsMm::about(places_mm.iter().copied());
    [low, high]
}

/// Slopes of some stations.
#[derive(Clone, Copy, Default)]
struct Row {
    meridional: Summary,
    gradient: Summary,
    stations: usize,
    unmeasured: usize,
}

impl Row {
    fn add(&mut self, at_mm: [f64; 2], plane: &Plane) {
        let Plane { gradient, noise: [xx, xy, yy] } = plane;
        let steepest = gradient[0].hypot(gradient[1]);
        let radius_mm = at_mm[0].hypot(at_mm[1]);
        let (meridional, noise) = if radius_mm > 0.0 {
            let [x, y] = at_mm.map(|part| part / radius_mm);
            let noise = x * x * xx + 2.0 * x * y * xy + y * y * yy;
            ((gradient[0] * x + gradient[1] * y).abs(), noise)
        } else {
            (steepest, xx + yy)
        };
        self.stations += 1;
        self.meridional.add(at_mm, meridional, noise);
        self.gradient.add(at_mm, steepest, xx + yy);
    }

    fn join(&mut self, other: &Row) {
        self.stations += other.stations;
        self.unmeasured += other.unmeasured;
        self.meridional.join(&other.meridional);
        self.gradient.join(&other.gradient);
    }
}

#[derive(Clone, Copy, Default)]
struct Summary {
    square: f64,
    largest: Option<(f64, [f64; 2])>,
    /// Variances of the slopes for noise of 1 nm: their sum, and the largest.
    noise: f64,
    most_noise: f64,
}

impl Summary {
    fn add(&mut self, at_mm: [f64; 2], slope: f64, noise: f64) {
        self.square += slope * slope;
        self.noise += noise;
        self.most_noise = self.most_noise.max(noise);
        self.offer(Some((slope, at_mm)));
    }

    fn join(&mut self, other: &Summary) {
        self.square += other.square;
        self.noise += other.noise;
        self.most_noise = self.most_noise.max(other.most_noise);
        self.offer(other.largest);
    }

    fn offer(&mut self, candidate: Option<(f64, [f64; 2])>) {
        if candidate.is_some_and(|(slope, _)| self.largest.is_none_or(|(most, _)| slope > most)) {
            self.largest = candidate;
        }
    }

    fn figure(&self, stations: usize) -> Option<SlopeFigure> {
        let (max_urad, at_mm) = self.largest?;
        Some(SlopeFigure {
            max_urad,
            rms_urad: (self.square / stations as f64).sqrt(),
            at_mm,
            noise_rms_urad: (self.noise / stations as f64).sqrt(),
            noise_most_urad: self.most_noise.sqrt(),
        })
    }
}

/// The points sorted into square cells, no smaller than the radius of the disc.
struct Cells<'a> {
    sample: &'a Sample,
    radius_mm: f64,
    low_mm: [f64; 2],
    side_mm: f64,
    columns: usize,
    rows: usize,
    /// Where in `order` each cell begins; one more than there are cells.
    begins: Vec<usize>,
    /// Indices of the points, cell after cell, ascending in each.
    order: Vec<usize>,
}

impl Cells<'_> {
    fn new(sample: &Sample, radius_mm: f64) -> Cells<'_> {
        let places = sample.places_mm();
        let [low_mm, high_mm] = box_of(places);
        let size = [high_mm[0] - low_mm[0], high_mm[1] - low_mm[1]];
        let side_mm = radius_mm.max(size[0].max(size[1]) / MOST_CELLS);
        let count = |axis: usize| (size[axis] / side_mm) as usize + 1;
        let mut cells = Cells {
            sample,
            radius_mm,
            low_mm,
            side_mm,
            columns: count(0),
            rows: count(1),
            begins: Vec::new(),
            order: vec![0; places.len()],
        };
        let of: Vec<usize> = places.iter().map(|&place| cells.cell(place)).collect();
        let mut begins = vec![0; cells.columns * cells.rows + 1];
        of.iter().for_each(|&cell| begins[cell + 1] += 1);
        for cell in 1..begins.len() {
            begins[cell] += begins[cell - 1];
        }
        let mut next = begins.clone();
        for (point, &cell) in of.iter().enumerate() {
            cells.order[next[cell]] = point;
            next[cell] += 1;
        }
        cells.begins = begins;
        cells
    }

    fn cell(&self, place: [f64; 2]) -> usize {
        let at = |axis: usize, count: usize| {
            (((place[axis] - self.low_mm[axis]) / self.side_mm) as usize).min(count - 1)
        };
        at(1, self.rows) * self.columns + at(0, self.columns)
    }

    /// Gradient of the plane through the points of the disc about a station, if they surround it.
    fn gradient(&self, station: [f64; 2]) -> Option<Plane> {
        let mut sums = Sums::default();
        let near = |axis: usize, count: usize| {
            let cell = ((station[axis] - self.low_mm[axis]) / self.side_mm).floor();
            let first = (cell - 1.0).max(0.0);
            // Empty if the station lies beyond all points.
            let end = (cell + 2.0).min(count as f64).max(first);
            first as usize..end as usize
        };
        let mut reference_nm = None;
        for row in near(1, self.rows) {
            for column in near(0, self.columns) {
                let cell = row * self.columns + column;
                for &point in &self.order[self.begins[cell]..self.begins[cell + 1]] {
                    let place = self.sample.places_mm()[point];
                    let (x, y) = (place[0] - station[0], place[1] - station[1]);
                    let area = self.sample.areas()[point];
                    if x * x + y * y > self.radius_mm * self.radius_mm || area == 0.0 {
                        continue;
                    }
                    // About the first height, so that a piston costs no digits.
                    let value_nm = self.sample.values_nm()[point];
                    let z = value_nm - *reference_nm.get_or_insert(value_nm);
                    sums.add(area, x / self.radius_mm, y / self.radius_mm, z);
                }
            }
        }
        sums.plane().map(|Plane { gradient, noise }| Plane {
            gradient: gradient.map(|slope| slope / self.radius_mm),
            noise: noise.map(|square| square / (self.radius_mm * self.radius_mm)),
        })
    }
}

/// The plane of least squares through the points of a disc.
struct Plane {
    /// Along x and y in nm/mm.
    gradient: [f64; 2],
    /// Its variances, xx, xy and yy, in (nm/mm)² for independent noise of 1 nm at every point.
    noise: [f64; 3],
}

/// Moments of the points of a disc in units of its radius.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: usize,
    area: f64,
    x: f64,
    y: f64,
    z: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    xz: f64,
    yz: f64,
    /// With the squares of the areas: of 1, x, y, xx, xy, yy.
    squared: [f64; 6],
}

impl Sums {
    fn add(&mut self, area: f64, x: f64, y: f64, z: f64) {
        let products = [1.0, x, y, x * x, x * y, y * y];
        self.squared.iter_mut().zip(products).for_each(|(sum, of)| *sum += area * area * of);
        self.count += 1;
        self.area += area;
        self.x += area * x;
        self.y += area * y;
        self.z += area * z;
        self.xx += area * x * x;
        self.xy += area * x * y;
        self.yy += area * y * y;
        self.xz += area * x * z;
        self.yz += area * y * z;
    }

    fn plane(&self) -> Option<Plane> {
        if self.count < LEAST_POINTS {
            return None;
        }
        let (x, y, z) = (self.x / self.area, self.y / self.area, self.z / self.area);
        let (xx, yy) = (self.xx / self.area - x * x, self.yy / self.area - y * y);
        let xy = self.xy / self.area - x * y;
        let (xz, yz) = (self.xz / self.area - x * z, self.yz / self.area - y * z);
        let least = 0.5 * (xx + yy) - (0.5 * (xx - yy)).hypot(xy);
        if x.hypot(y) > FARTHEST_CENTROID || least < LEAST_EXTENT {
            return None;
        }
        let determinant = xx * yy - xy * xy;
        let solved =
            |x: f64, y: f64| [(yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant];
        // The gradient is M⁻¹·Σ w·(x − x̄)·z with shares w of the area, so noise has M⁻¹·(Σ w²·(x − x̄)·(x − x̄)ᵀ)·M⁻¹.
        let [one, of_x, of_y, of_xx, of_xy, of_yy] =
            self.squared.map(|sum| sum / (self.area * self.area));
        let noise_xx = of_xx - 2.0 * x * of_x + x * x * one;
        let noise_xy = of_xy - x * of_y - y * of_x + x * y * one;
        let noise_yy = of_yy - 2.0 * y * of_y + y * y * one;
        let (column_x, column_y) = (solved(noise_xx, noise_xy), solved(noise_xy, noise_yy));
        let (row_x, row_y) = (solved(column_x[0], column_y[0]), solved(column_x[1], column_y[1]));
        Some(Plane { gradient: solved(xz, yz), noise: [row_x[0], row_x[1], row_y[1]] })
    }
}

/// Twice what a plane needs.
const LEAST_POINTS: usize = 6;
/// Farthest centroid from the station, in radii of the disc; that of half a disc is 0.42.
const FARTHEST_CENTROID: f64 = 0.25;
/// Half the mean square of a coordinate over a full disc, in squared radii.
const LEAST_EXTENT: f64 = 0.125;
/// More stations than this resolve nothing a form deviation has.
const MOST_STATIONS: usize = 4_000_000;
/// Cells along the longer side: with smaller ones their list would outgrow that of the points.
const MOST_CELLS: f64 = 1024.0;
