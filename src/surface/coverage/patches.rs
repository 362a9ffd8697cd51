//! The regions that are not covered, with what is known of each.

use asphera_geometry::predicates::Place;
use asphera_geometry::{Sum, Triangle};

use super::aperture::Aperture;
use super::border::Border;
use super::draw::{Drawing, Line, Open, Scene};
use super::gauge::{Gauged, Standing, sound_lfs};
use super::polygon::{Polygon, place_inside, polygons};
use super::target::{Spacing, Target};

/// A region of the aperture that is not covered.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Its area in the plane in mm², that of its polygons: what is to be measured.
    pub area_mm2: f64,
    /// Of this, places beyond the target that were scanned, but not densely enough.
    pub undersampled_mm2: f64,
    /// Of this, places beyond the target that were not scanned.
    pub uncovered_mm2: f64,
    /// The largest gap of its triangles in mm; none if it lies outside the hull.
    pub gap_max_mm: Option<f64>,
    /// The largest ε of its triangles; none if it lies outside the hull or no local feature size is
    /// known there.
    pub epsilon_max: Option<f64>,
    /// The spacing, in space, that meets the target all over it: at its triangles and its corners,
    /// where the local feature size is known.
    pub spacing: Spacing,
    /// How much larger its triangles are in space than in the plane, 1 and above; 1 if it lies
    /// outside the hull.
    pub stretch: f64,
    /// A place x, y inside it in mm, away from its lines.
    pub inside_mm: [f64; 2],
    /// Where it lies, the largest polygon first. Several only where the aperture's border cuts it.
    pub polygons: Vec<Polygon>,
}

impl Patch {
    /// The area in mm² of its places that are not covered: what measuring it adds to the coverage.
    pub fn missing_mm2(&self) -> f64 {
        self.undersampled_mm2 + self.uncovered_mm2
    }

    /// How many samples on a raster of the spacing it needs fill its area; none if that is not known.
    pub fn samples_needed(&self) -> Option<f64> {
        let spacing_mm = self.spacing_in_plane_mm()?;
        Some((self.area_mm2 / (spacing_mm * spacing_mm)).ceil())
    }

    /// The spacing it needs as seen in the plane, in mm: smaller than in space by its stretch, as if
    /// it were one slope. None if any spacing will do or it is not known.
    pub fn spacing_in_plane_mm(&self) -> Option<f64> {
        Some(self.spacing.mm()? / self.stretch)
    }
}

/// All regions.
pub(super) struct Patches {
    pub(super) listed: Vec<Patch>,
    pub(super) remainder_mm2: f64,
    pub(super) remainder: u64,
}

impl Patches {
    pub(super) fn none() -> Patches {
        Patches { listed: Vec::new(), remainder_mm2: 0.0, remainder: 0 }
    }

    /// The whole aperture as one region.
    pub(super) fn whole(
        aperture: &Aperture,
        border: &Border,
        target: &Target,
        lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
    ) -> Patches {
        let polygons = polygons(border.lines());
        let mut found = Patches::none();
        let Some(inside_mm) = place_inside(&polygons) else { return found };
        let places = polygons.iter().flat_map(Polygon::sides).map(|(place, ..)| place);
        let mut gap_mm = None;
        for [x, y] in places.chain([inside_mm]) {
            tighten(&mut gap_mm, target.gap_mm(sound_lfs(lfs_mm(x, y))));
        }
        let area_mm2 = aperture.area_mm2();
        found.listed.push(Patch {
            area_mm2,
            undersampled_mm2: 0.0,
            uncovered_mm2: area_mm2,
            gap_max_mm: None,
            epsilon_max: None,
            spacing: Spacing::of_gap(gap_mm),
            stretch: 1.0,
            inside_mm,
            polygons,
        });
        found
    }
}

/// What the figures of a region are made of.
#[derive(Clone, Default)]
struct Gathered {
    area: Sum,
    undersampled: Sum,
    uncovered: Sum,
    in_space: Sum,
    in_plane: Sum,
    gap_max_mm: Option<f64>,
    epsilon_max: Option<f64>,
    /// The smallest gap the target asks for.
    limit_mm: Option<f64>,
}

/// The regions of a drawing, first the one that adds most to the coverage. The first of the open triangles are those gauged, the rest
/// lies outside the hull.
pub(super) fn patches(
    scene: &Scene<'_>,
    (open, gauged): (&[Open], &[Gauged]),
    drawing: Drawing,
    target: &Target,
    lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
) -> Patches {
    let mut gathered = vec![Gathered::default(); drawing.lines.len()];
    for (index, (open, &region)) in open.iter().zip(&drawing.region_of).enumerate() {
        if open.area_mm2 > 0.0 {
            gathered[region].add(scene, open, gauged.get(index), target);
        }
    }
    let mut found = Patches::none();
    let mut remainder = Sum::default();
    for (mut gathered, lines) in gathered.into_iter().zip(drawing.lines) {
        let missing_mm2 = gathered.missing_mm2();
        if missing_mm2 > 0.0 {
            match gathered.patch(lines, target, lfs_mm) {
                Some(patch) => found.listed.push(patch),
                None => {
                    remainder.add(missing_mm2);
                    found.remainder += 1;
                }
            }
        }
    }
    found.listed.sort_by(|left, right| {
        let at = |patch: &Patch| patch.inside_mm;
        right
            .missing_mm2()
            .total_cmp(&left.missing_mm2())
            .then(at(left)[0].total_cmp(&at(right)[0]))
            .then(at(left)[1].total_cmp(&at(right)[1]))
    });
    found.remainder_mm2 = remainder.total();
    found
}

impl Gathered {
    fn add(&mut self, scene: &Scene<'_>, open: &Open, gauged: Option<&Gauged>, target: &Target) {
        let sum = match open.standing {
            Standing::Undersampled => &mut self.undersampled,
            Standing::Bridge => &mut self.uncovered,
        };
        sum.add(open.beyond_mm2);
        self.area.add(open.area_mm2);
        if let Some(gauged) = gauged {
            let triangle = Triangle::new(scene.points, open.corners);
            self.in_space.add(triangle.area_mm2());
            self.in_plane.add(triangle.projected_area_mm2());
            let larger = |largest: Option<f64>, value: f64| {
                Some(largest.map_or(value, |largest| largest.max(value)))
            };
            self.gap_max_mm = larger(self.gap_max_mm, gauged.gap.mm);
            if let Some(epsilon) = gauged.epsilon() {
                self.epsilon_max = larger(self.epsilon_max, epsilon);
            }
            tighten(&mut self.limit_mm, target.gap_mm(gauged.lfs_mm));
        }
    }

    fn missing_mm2(&self) -> f64 {
        let mut sum = self.undersampled;
        sum.add(self.uncovered.total());
        sum.total()
    }

    /// The region with these lines, or none if it is too small to be listed.
    fn patch(
        &mut self,
        lines: Vec<Line>,
        target: &Target,
        lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
    ) -> Option<Patch> {
        let area_mm2 = self.area.total();
        let too_small = |limit_mm: Option<f64>| {
            let spacing_mm = Spacing::of_gap(limit_mm).mm();
            spacing_mm.is_some_and(|spacing_mm| area_mm2 < spacing_mm * spacing_mm)
        };
        for &[x, y] in lines.iter().flat_map(|line| &line.places_mm) {
            tighten(&mut self.limit_mm, target.gap_mm(sound_lfs(lfs_mm(x, y))));
        }
        if too_small(self.limit_mm) {
            return None;
        }
        let polygons = polygons(lines);
        let inside_mm: Place = place_inside(&polygons)?;
        let (in_space_mm2, in_plane_mm2) = (self.in_space.total(), self.in_plane.total());
        let stretch = if in_plane_mm2 > 0.0 { (in_space_mm2 / in_plane_mm2).max(1.0) } else { 1.0 };
        Some(Patch {
            area_mm2,
            undersampled_mm2: self.undersampled.total(),
            uncovered_mm2: self.uncovered.total(),
            gap_max_mm: self.gap_max_mm,
            epsilon_max: self.epsilon_max,
            spacing: Spacing::of_gap(self.limit_mm),
            stretch,
            inside_mm,
            polygons,
        })
    }
}

/// The smaller of two limits; one that is not known does not count.
fn tighten(limit_mm: &mut Option<f64>, other_mm: Option<f64>) {
    if let Some(other_mm) = other_mm {
        *limit_mm = Some(limit_mm.map_or(other_mm, |limit_mm| limit_mm.min(other_mm)));
    }
}
