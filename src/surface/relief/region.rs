//! A region of steep triangles: what it looks like, where it is, and its figures.

use std::cmp::Ordering;
use std::fmt;

use asphera_geometry::{PointMm, Sum};

/// What a region of steep triangles looks like, the gravest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Samples of two or more sheets are mixed in the projection. Its triangles are not surface.
    Fold,
    /// A step or a steep flank between a higher and a lower side.
    Wall,
    /// Single samples, a few together or a line of at most two side by side stand off all around
    /// them, upwards or downwards: wrong readings, or details finer than the sampling.
    Spike,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Fold => "fold",
            Kind::Wall => "wall",
            Kind::Spike => "spike",
        })
    }
}

/// A connected region of steep triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// What it looks like.
    pub kind: Kind,
    /// Corner with the smallest x, y and z in mm of the bounding box of its steep sides. A long thin
    /// triangle may reach beyond.
    pub min_mm: PointMm,
    /// Corner of that box with the largest x, y and z in mm.
    pub max_mm: PointMm,
    /// A place of it: the middle of the steep side with the largest rise; the first along x, then y,
    /// of several.
    pub at_mm: PointMm,
    /// Corners of its triangles.
    pub vertices: u64,
    /// How many of its vertices lie where two levels take turns, next to another such vertex on the
    /// other level, or stand one above the other: what makes a fold.
    pub entangled: u64,
    /// How many of its vertices have all neighbours on another level: what wrong readings do.
    pub alone: u64,
    /// Triangles with a steep side; of a fold, also those shut in between them, all of whose corners
    /// are corners of such ones.
    pub triangles: u64,
    /// Area in mm² of the projection of its triangles.
    pub projected_area_mm2: f64,
    /// Largest difference in height of two neighbours in mm.
    pub rise_max_mm: f64,
    /// Largest slope of a side that is steep, in rad.
    pub slope_max_rad: f64,
}

impl Region {
    /// Difference between the highest and the lowest end of its steep sides in mm.
    pub fn height_mm(&self) -> f64 {
        self.max_mm[2] - self.min_mm[2]
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [at, min, max] = [self.at_mm, self.min_mm, self.max_mm].map(|p| p.map(legible));
        write!(
            f,
            "{} at ({}, {}, {}) mm, from ({}, {}, {}) to ({}, {}, {}) mm: {} vertices, {} triangles, \
             {} mm² projected, rise up to {} mm, slope up to {:.2}°",
            self.kind,
            at[0],
            at[1],
            at[2],
            min[0],
            min[1],
            min[2],
            max[0],
            max[1],
            max[2],
            self.vertices,
            self.triangles,
            legible(self.projected_area_mm2),
            legible(self.rise_max_mm),
            self.slope_max_rad.to_degrees()
        )
    }
}

/// A length rounded to the nm, or an area to as many places, for people.
pub(crate) fn legible(mm: f64) -> f64 {
    (mm * 1e6).round() / 1e6
}

/// What the figures of a region are made of.
pub(crate) struct Tally {
    min_mm: PointMm,
    max_mm: PointMm,
    pub(crate) vertices: u64,
    pub(crate) entangled: u64,
    pub(crate) alone: u64,
    pub(crate) steep: u64,
    /// Steep triangles with a corner that stands off.
    pub(crate) about_pieces: u64,
    triangles: Vec<u32>,
    areas_mm2: Vec<f64>,
    /// Rise and middle of the steep side with the largest rise.
    highest: Option<(f64, PointMm)>,
    slope_max_rad: f64,
}

impl Default for Tally {
    fn default() -> Tally {
        Tally {
            min_mm: [f64::INFINITY; 3],
            max_mm: [f64::NEG_INFINITY; 3],
            vertices: 0,
            entangled: 0,
            alone: 0,
            steep: 0,
            about_pieces: 0,
            triangles: Vec::new(),
            areas_mm2: Vec::new(),
            highest: None,
            slope_max_rad: 0.0,
        }
    }
}

impl Tally {
    pub(crate) fn triangle(&mut self, index: u32, mut corners: [PointMm; 3]) {
        // Always the same rounding, whichever corner comes first.
        corners.sort_by(|&left, &right| lexicographic(left, right));
        let [p, q, r] = corners;
        let twice = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        self.areas_mm2.push(0.5 * twice.abs());
        self.triangles.push(index);
    }

    pub(crate) fn side(&mut self, [p, q]: [PointMm; 2]) {
        for end in [p, q] {
            self.min_mm = std::array::from_fn(|axis| self.min_mm[axis].min(end[axis]));
            self.max_mm = std::array::from_fn(|axis| self.max_mm[axis].max(end[axis]));
        }
        let rise_mm = (q[2] - p[2]).abs();
        let way_mm = (q[0] - p[0]).hypot(q[1] - p[1]);
        self.slope_max_rad = self.slope_max_rad.max(rise_mm.atan2(way_mm));
        let middle: PointMm = std::array::from_fn(|axis| 0.5 * (p[axis] + q[axis]));
        let first = self.highest.is_none_or(|(highest_mm, at_mm)| {
            rise_mm > highest_mm || rise_mm == highest_mm && lexicographic(middle, at_mm).is_lt()
        });
        if first {
            self.highest = Some((rise_mm, middle));
        }
    }

    pub(crate) fn kind(&self) -> Kind {
        if self.entangled >= FOLD_VERTICES && 2 * self.entangled >= self.alone {
            Kind::Fold
        } else if 2 * self.about_pieces > self.steep {
            Kind::Spike
        } else {
            Kind::Wall
        }
    }

    pub(crate) fn finish(mut self) -> (Region, Vec<u32>) {
        // In ascending order the sum has the same bits whatever the order of the triangles.
        self.areas_mm2.sort_unstable_by(f64::total_cmp);
        let mut area = Sum::default();
        self.areas_mm2.iter().for_each(|&area_mm2| area.add(area_mm2));
        let (rise_max_mm, at_mm) = self.highest.expect("each region has a steep side");
        let region = Region {
            kind: self.kind(),
            min_mm: self.min_mm,
            max_mm: self.max_mm,
            at_mm,
            vertices: self.vertices,
            entangled: self.entangled,
            alone: self.alone,
            triangles: self.triangles.len() as u64,
            projected_area_mm2: area.total(),
            rise_max_mm,
            slope_max_rad: self.slope_max_rad,
        };
        (region, self.triangles)
    }
}

/// By x, then y, then z.
pub(crate) fn lexicographic(left: PointMm, right: PointMm) -> Ordering {
    left.iter()
        .zip(&right)
        .map(|(left, right)| left.total_cmp(right))
        .find(|ordering| ordering.is_ne())
        .unwrap_or(Ordering::Equal)
}

/// Entangled vertices that make a fold, at least.
const FOLD_VERTICES: u64 = 8;
