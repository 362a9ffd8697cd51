//! A curve in lines, arcs and corners, and the chamfers and edges that these make.

use super::course::{Course, LEAST};
use super::enclosed::enclosed_mm2;
use super::joined::Joined;
use super::pieces::cut;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// A figure with its standard uncertainty by the noise of the points, in the same unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The figure.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
}

/// A piece of a curve, or what pieces make together. Lengths are mm, angles degrees.
#[derive(Clone, Debug, PartialEq)]
pub enum Feature {
    /// A straight line.
    Line {
        /// Where it begins and ends, in the order of the curve.
        ends_mm: [PlaceMm; 2],
        /// The angle of the line from x, 0 to below 180.
        angle_deg: Estimate,
        /// The mean of its points; the uncertainty is that across the line.
        middle_mm: PlaceMm,
        /// That uncertainty.
        u_across_mm: f64,
        /// Largest less least distance of its points from it, unfiltered.
        straightness_mm: f64,
        /// Points that count.
        points: usize,
    },
    /// An arc of a circle.
    Arc {
        /// Where it begins and ends, in the order of the curve.
        ends_mm: [PlaceMm; 2],
        /// Its centre.
        centre_mm: [Estimate; 2],
        /// Its radius.
        radius_mm: Estimate,
        /// The angle it goes round, counter-clockwise above 0.
        sweep_deg: f64,
        /// Largest less least distance of its points from the centre, unfiltered.
        roundness_mm: f64,
        /// Points that count.
        points: usize,
    },
    /// A piece that is neither within the noise.
    Free {
        /// Its first and last point.
        ends_mm: [PlaceMm; 2],
        /// Its points.
        points: usize,
    },
    /// A corner between two pieces: where they meet when they go on.
    Corner {
        /// Its place.
        at_mm: [Estimate; 2],
        /// The angle between the pieces on its inner side, below 180.
        angle_deg: Estimate,
    },
    /// A short line between two longer ones that breaks their corner.
    Chamfer {
        /// The middle of its face.
        at_mm: PlaceMm,
        /// Length of its face between its two corners.
        width_mm: Estimate,
        /// What it takes away from the line before and the one after, from the corner that these would make.
        legs_mm: [Estimate; 2],
        /// The angles between its face and the two lines, 0 to 90.
        angles_deg: [Estimate; 2],
    },
    /// An arc between two lines.
    Edge {
        /// The middle of the arc.
        at_mm: PlaceMm,
        /// Its radius.
        radius_mm: Estimate,
        /// The angle between the lines on the inner side, below 180.
        angle_deg: Estimate,
    },
}

/// A stretch without points that the curve bridges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bridge {
    /// The points beside it.
    pub ends_mm: [PlaceMm; 2],
    /// Their distance, mm.
    pub length_mm: f64,
}

/// What a curve is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Pieces in order; then corners, chamfers and edges.
    pub features: Vec<Feature>,
    /// The area within a closed curve, mm².
    pub area_mm2: Option<Estimate>,
    /// The length of a closed curve of lines and arcs, mm.
    pub perimeter_mm: Option<Estimate>,
    /// Gaps over which the curve goes. Pieces end there, and a curve with one encloses nothing.
    pub bridges: Vec<Bridge>,
    /// Noise of the points across the curve, mm.
    pub noise_sigma_mm: Option<f64>,
    /// What is not known, and why.
    pub unknown: Vec<String>,
}

impl Profile {
    /// The profile of a course. Deviations up to `tolerance_mm` make no piece of their own; 0 for those of noise only.
    ///
    /// Points near the ends of a piece do not count where the piece beside it differs by less than 3 σ. The σ of a piece is by its own points
    /// where 100 are to spare, else by those of all pieces. Of fewer than 8 points that count a piece is unknown. Where the curve bridges a
    /// gap it is taken apart.
    pub fn new(course: &Course, tolerance_mm: f64) -> Profile {
        let mut profile = Profile {
            features: Vec::new(),
            area_mm2: None,
            perimeter_mm: None,
            bridges: Vec::new(),
            noise_sigma_mm: None,
            unknown: Vec::new(),
        };
        let count = course.places_mm().len();
        if count > MOST_POINTS {
            profile.unknown.push(format!(
                "features: at most {MOST_POINTS} points are cut into pieces, this curve has {count}"
            ));
            return profile;
        }
        let Some(noise) = course.noise() else {
            profile.unknown.push(format!(
                "features: their noise needs {LEAST} points along a curve or more, this one has {count}"
            ));
            return profile;
        };
        profile.noise_sigma_mm = Some(noise.sigma_mm);
        // Finer than this the sums of the search do not tell.
        let sigma_mm = noise.sigma_mm.max(0.5 * tolerance_mm).max(1e-6 * course.extent_mm());
        let cut = cut(course, &noise, sigma_mm);
        let joined = Joined::new(&cut, sigma_mm);
        let gaps = joined.gaps();
        if !gaps.is_empty() {
            profile.parted(&cut.course, &gaps, tolerance_mm);
            return profile;
        }
        profile.features = joined.features();
        profile.unknown = joined.unknown();
        if course.is_closed() {
            match joined.area_and_length() {
                Some([area_mm2, length_mm]) => {
                    profile.area_mm2 = Some(area_mm2);
                    profile.perimeter_mm = Some(length_mm);
                }
                None => {
                    profile.area_mm2 = Some(enclosed_mm2(course, &noise));
                    profile.unknown.push(
                        "perimeter: not all pieces are lines or arcs with points enough, and noise lengthens what is left"
                            .to_owned(),
                    );
                }
            }
        }
        profile
    }

    /// Takes the features of what is left of a course without gaps, by the points where these begin.
    fn parted(&mut self, course: &Course, gaps: &[usize], tolerance_mm: f64) {
        let places_mm = course.places_mm();
        for &from in gaps {
            let ends_mm = [from, from + 1].map(|point| places_mm[point % places_mm.len()]);
            let length_mm = distance_mm(ends_mm[0], ends_mm[1]);
            let [[x, y], [to_x, to_y]] = ends_mm;
            self.bridges.push(Bridge { ends_mm, length_mm });
            self.unknown.push(format!(
                "gap: {length_mm:.4} mm without points from {x:.4}, {y:.4} to {to_x:.4}, {to_y:.4} mm, far more than between the points beside it; the curve bridges it, its pieces end there"
            ));
        }
        if course.is_closed() {
            let why =
                "area, perimeter: a gap is closed, so they are not known; measure points there";
            self.unknown.push(why.to_owned());
        }
        for part in course.without(gaps) {
            let part = Profile::new(&part, tolerance_mm);
            self.features.extend(part.features);
            self.bridges.extend(part.bridges);
            self.unknown.extend(part.unknown);
        }
    }
}

/// Most points that are cut into pieces: with more it takes seconds.
const MOST_POINTS: usize = 200_000;
