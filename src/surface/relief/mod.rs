//! Folds, walls and spikes: where the surface may not be projectable, from its points alone.
//!
//! A surface can be meshed by its projection only where the projection is one-to-one (W. El-Hayek
//! et al., J. Phys.: Conf. Ser. 483 (2014) 012003, doi:10.1088/1742-6596/483/1/012003, section 6).
//! Where it is not, two or more sheets lie one above the other, and the triangulation of their
//! projection jumps from one to the other: its triangles are steep and are no part of the surface.
//! But a step of the surface and a wrong reading make steep triangles as well. [`topography`] finds
//! the regions of steep triangles and tells what they look like:
//!
//! 1. A triangle is steep if one of its sides is (see `steep.rs`).
//! 2. Steep triangles with a common corner belong to one region; so do those joined by a triangle
//!    whose three corners all are corners of steep ones, as between two sheets.
//! 3. About each corner the samples are split into two levels. Where they lie on them by turns, at
//!    corners next to each other and on both levels, sheets are mixed (see `tears.rs`). A region
//!    with at least 8 such corners, and at least half as many of them as of single samples off
//!    all their neighbours, is a [`Kind::Fold`].
//! 4. Of the other regions, those about samples that stand off their surroundings (see `pieces.rs`)
//!    are a [`Kind::Spike`], the rest a [`Kind::Wall`].
//!
//! What points cannot tell is said at [`topography`].

mod pieces;
mod region;
mod steep;
mod tears;

use asphera_geometry::{PointMm, Sets, VertexId};
use asphera_mesh::Mesh;
use thiserror::Error;

use self::pieces::standing_off;
pub(crate) use self::region::legible;
pub use self::region::{Kind, Region};
use self::region::{Tally, lexicographic};
pub(crate) use self::steep::sides;
use self::steep::{Spokes, Steep, Steepness, numbered, steep};
use self::tears::Tears;

/// What counts as steep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relief {
    slope_limit_rad: f64,
    step_mm: f64,
}

/// Why a [`Relief`] is not usable.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ReliefError {
    /// The slope limit is not an angle between level and upright.
    #[error("slope limit {slope_limit_rad} rad is not between 0 and π/2")]
    SlopeLimit {
        /// The limit in rad.
        slope_limit_rad: f64,
    },
    /// The smallest step is negative or not finite.
    #[error("smallest step {step_mm} mm is not finite and at least 0")]
    Step {
        /// The step in mm.
        step_mm: f64,
    },
}

impl Relief {
    /// Default of the slope limit in rad: 75°, above the flanks of aspheres in use.
    pub const SLOPE_LIMIT_RAD: f64 = 75.0 / 180.0 * std::f64::consts::PI;

    /// A slope limit in rad, above 0 and below π/2, and the smallest step in mm that counts however
    /// near the samples are. The step should be several times the noise of the heights.
    pub fn new(slope_limit_rad: f64, step_mm: f64) -> Result<Relief, ReliefError> {
        if !(slope_limit_rad > 0.0 && slope_limit_rad < std::f64::consts::FRAC_PI_2) {
            Err(ReliefError::SlopeLimit { slope_limit_rad })
        } else if !(step_mm >= 0.0 && step_mm.is_finite()) {
            Err(ReliefError::Step { step_mm })
        } else {
            Ok(Relief { slope_limit_rad, step_mm })
        }
    }

    pub(crate) fn step_mm(&self) -> f64 {
        self.step_mm
    }

    fn steepness(&self) -> Steepness {
        Steepness { tangent: self.slope_limit_rad.tan(), step_mm: self.step_mm }
    }
}

impl Default for Relief {
    /// 75° and [`Mesh::CONFLICT_TOLERANCE_MM`].
    fn default() -> Relief {
        Relief { slope_limit_rad: Relief::SLOPE_LIMIT_RAD, step_mm: Mesh::CONFLICT_TOLERANCE_MM }
    }
}

/// The regions of steep triangles of a mesh.
#[derive(Clone, Debug, Default)]
pub struct Topography {
    regions: Vec<Region>,
    /// The region of each triangle, or [`NOWHERE`]. Empty if there is no region.
    region_of: Vec<u32>,
}

impl Topography {
    /// The regions: folds, walls, spikes, of each kind the largest area first.
    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// Whether no region looks like a fold.
    ///
    /// See [`topography`] for what points cannot tell, and [`Mesh::projectable`] for points exactly
    /// above each other.
    pub fn projectable(&self) -> bool {
        self.regions.iter().all(|region| region.kind != Kind::Fold)
    }

    /// The region that the triangle `index` belongs to: an index into [`Topography::regions`].
    pub fn region_of(&self, index: usize) -> Option<usize> {
        let region = *self.region_of.get(index)?;
        (region != NOWHERE).then_some(region as usize)
    }

    /// Indices of the triangles that belong to folds, ascending: those to be left out, since they
    /// join samples of different sheets.
    pub fn triangles_of_folds(&self) -> impl Iterator<Item = usize> + '_ {
        self.region_of.iter().enumerate().filter_map(|(index, &region)| {
            let region = self.regions.get(region as usize)?;
            (region.kind == Kind::Fold).then_some(index)
        })
    }
}

/// Finds the regions of steep triangles.
///
/// `triangles` are those of a Delaunay triangulation of the projection, counter-clockwise, with
/// indices into `points` as corners; some of them may be left out. The regions do not depend on
/// the order of the triangles, on the corner each begins with, or on the numbering of the points,
/// to the bit.
///
/// **What points cannot tell.** The samples of a surface are all there is, and some different
/// surfaces have the same samples:
///
/// - Sheets nearer to each other than the spacing times the tangent of the slope limit (some four
///   spacings at 75°) make no steep triangle; they are taken for a rough surface.
/// - An overhang whose shadow is narrower than a spacing or two is taken for a wall, which it is but
///   for its foot.
/// - Samples exactly above each other never come to lie in one mesh: look at
///   [`asphera_mesh::Counts::conflicts`].
/// - A sheet with less than about a seventh of the samples looks like scattered wrong readings, and
///   wrong readings, from about a sixth of all, look like a sheet.
/// - A grating or a saw-tooth whose flanks are one sample apart looks like a fold, with equal right.
/// - A step of only a few spacings may fall apart into several walls where samples are scattered:
///   some of the sides across it are too long to be steep.
/// - Noise larger than the spacing is steep. The smallest step of [`Relief`] rules it out.
///
/// Linear time but for sorting what is steep; where nothing is, a single pass without memory.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn topography(points: &[PointMm], triangles: &[[VertexId; 3]], relief: &Relief) -> Topography {
    let Some(steep) = steep(points, triangles, relief.steepness()) else {
        return Topography::default();
    };
    let spokes = &steep.spokes;
    let shut_in = shut_in(triangles, &steep);
    let mut sets = Sets::new(spokes.len());
    for &index in steep.triangles.iter().chain(&shut_in) {
        let [a, b, c] = slots(spokes, triangles[index as usize]);
        sets.join(a, b);
        sets.join(b, c);
    }
    let tears = Tears::find(points, spokes, &steep.rise_mm);
    let off = standing_off(points, spokes, &tears);

    let mut number_of_root = vec![NOWHERE; spokes.len()];
    let mut tallies: Vec<Tally> = Vec::new();
    let mut tally_of_slot = vec![0_usize; spokes.len()];
    for slot in 0..spokes.len() {
        let number = &mut number_of_root[sets.root(slot)];
        if *number == NOWHERE {
            *number = tallies.len() as u32;
            tallies.push(Tally::default());
        }
        tally_of_slot[slot] = *number as usize;
        let tally = &mut tallies[*number as usize];
        tally.vertices += 1;
        tally.entangled += u64::from(tears.entangled(slot));
        tally.alone += u64::from(tears.alone(slot));
    }
    for &index in &steep.triangles {
        let corners = triangles[index as usize];
        let slots = slots(spokes, corners);
        let tally = &mut tallies[tally_of_slot[slots[0]]];
        tally.triangle(index, corners.map(|corner| points[corner as usize]));
        tally.steep += 1;
        tally.about_pieces += u64::from(slots.iter().any(|&slot| off[slot]));
        let sides = sides(corners).into_iter();
        sides.filter_map(|side| steep.steep_side(points, side)).for_each(|side| tally.side(side));
    }
    for &index in &shut_in {
        let corners = triangles[index as usize];
        let tally = &mut tallies[tally_of_slot[slots(spokes, corners)[0]]];
        if tally.kind() == Kind::Fold {
            tally.triangle(index, corners.map(|corner| points[corner as usize]));
        }
    }
    Topography::of(tallies, triangles.len())
}

impl Topography {
    fn of(tallies: Vec<Tally>, triangles: usize) -> Topography {
        let mut found: Vec<(Region, Vec<u32>)> = tallies.into_iter().map(Tally::finish).collect();
        found.sort_by(|(left, _), (right, _)| {
            left.kind
                .cmp(&right.kind)
                .then(right.projected_area_mm2.total_cmp(&left.projected_area_mm2))
                .then(lexicographic(left.at_mm, right.at_mm))
        });
        let mut region_of = vec![NOWHERE; triangles];
        for (number, (_, indices)) in (0..).zip(&found) {
            indices.iter().for_each(|&index| region_of[index as usize] = number);
        }
        Topography { regions: found.into_iter().map(|(region, _)| region).collect(), region_of }
    }
}

/// Indices of the triangles that are not steep but have corners of steep ones only.
fn shut_in(triangles: &[[VertexId; 3]], steep: &Steep) -> Vec<u32> {
    let mut steep_ones = steep.triangles.iter().copied().peekable();
    numbered(triangles)
        .filter(|&(index, corners)| {
            steep_ones.next_if_eq(&index).is_none()
                && corners.iter().all(|&corner| steep.spokes.slot(corner).is_some())
        })
        .map(|(index, _)| index)
        .collect()
}

/// The slots of the corners of a triangle that is steep or shut in.
fn slots(spokes: &Spokes, corners: [VertexId; 3]) -> [usize; 3] {
    corners.map(|corner| spokes.slot(corner).expect("corners of steep triangles have slots"))
}

/// Marks a triangle without a region.
const NOWHERE: u32 = u32::MAX;
