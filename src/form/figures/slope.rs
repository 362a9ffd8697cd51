//! Slopes of the deviation over an integration length.

use rayon::prelude::*;

use super::unknown::positive;
use super::{Definition, Figure, Sample, SettingError, Unknown};
use crate::Aperture;

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
                    Some(gradient) => row.add([x, y], gradient),
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
    let half = match *sample.aperture() {
        Aperture::Circle { radius_mm } => [radius_mm; 2],
        Aperture::Annulus { outer_mm, .. } => [outer_mm; 2],
        Aperture::Rectangle { width_mm, height_mm } => [0.5 * width_mm, 0.5 * height_mm],
        Aperture::None => return box_of(sample.places_mm()),
    };
    [half.map(|half| -half), half]
}

fn box_of(places_mm: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let end = |start: f64, pick: fn(f64, f64) -> f64| {
        [0, 1].map(|axis| places_mm.iter().map(|place| place[axis]).fold(start, pick))
    };
    [end(f64::INFINITY, f64::min), end(f64::NEG_INFINITY, f64::max)]
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
    fn add(&mut self, at_mm: [f64; 2], gradient: [f64; 2]) {
        let steepest = gradient[0].hypot(gradient[1]);
        let radius_mm = at_mm[0].hypot(at_mm[1]);
        let meridional = if radius_mm > 0.0 {
            ((gradient[0] * at_mm[0] + gradient[1] * at_mm[1]) / radius_mm).abs()
        } else {
            steepest
        };
        self.stations += 1;
        self.meridional.add(at_mm, meridional);
        self.gradient.add(at_mm, steepest);
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
}

impl Summary {
    fn add(&mut self, at_mm: [f64; 2], slope: f64) {
        self.square += slope * slope;
        self.offer(Some((slope, at_mm)));
    }

    fn join(&mut self, other: &Summary) {
        self.square += other.square;
        self.offer(other.largest);
    }

    fn offer(&mut self, candidate: Option<(f64, [f64; 2])>) {
        if candidate.is_some_and(|(slope, _)| self.largest.is_none_or(|(most, _)| slope > most)) {
            self.largest = candidate;
        }
    }

    fn figure(&self, stations: usize) -> Option<SlopeFigure> {
        let (max_urad, at_mm) = self.largest?;
        Some(SlopeFigure { max_urad, rms_urad: (self.square / stations as f64).sqrt(), at_mm })
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

    /// Gradient in nm/mm of the plane through the points of the disc about a station, if they surround it.
    fn gradient(&self, station: [f64; 2]) -> Option<[f64; 2]> {
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
        sums.gradient().map(|gradient| gradient.map(|slope| slope / self.radius_mm))
    }
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
}

impl Sums {
    fn add(&mut self, area: f64, x: f64, y: f64, z: f64) {
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

    fn gradient(&self) -> Option<[f64; 2]> {
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
        Some([(yy * xz - xy * yz) / determinant, (xx * yz - xy * xz) / determinant])
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
