//! From triangles that are not covered to regions.

use asphera_geometry::{PointMm, VertexId};

use super::CoverageError;
use super::aperture::Aperture;
use super::border::{Border, Whereabouts};
use super::clip::common_area_mm2;
use super::draw::{Open, Scene};
use super::frame::Frame;
use super::gauge::{Gauged, Standing, sound_lfs};
use super::patches::{Patches, patches};
use super::target::Target;

/// A mesh against a target.
pub(super) struct Measured<'a> {
    pub(super) points: &'a [PointMm],
    pub(super) triangles: &'a [[VertexId; 3]],
    pub(super) target: &'a Target,
}

impl Measured<'_> {
    /// The regions of an aperture, what lies outside the hull among them.
    pub(super) fn inside(
        &self,
        aperture: &Aperture,
        border: &Border,
        hull: Vec<VertexId>,
        gauged: &[Gauged],
        lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
    ) -> Result<Patches, CoverageError> {
        let frame = Frame::new(self.points, hull, aperture.bounds_mm())
            .ok_or(CoverageError::NotAMesh { triangles: self.triangles.len() })?;
        let mut open = self.opened(gauged);
        self.add_outside(&frame, aperture, border, &mut open);
        self.draw(aperture, border, &frame, (&open, gauged), lfs_mm)
    }

    /// The triangles that are not covered, as they are drawn.
    fn opened(&self, gauged: &[Gauged]) -> Vec<Open> {
        let open = |gauged: &Gauged| Open {
            corners: self.triangles[gauged.index],
            standing: gauged.standing,
            whereabouts: gauged.whereabouts,
            area_mm2: gauged.area_mm2,
            beyond_mm2: gauged.beyond_mm2(),
        };
        gauged.iter().map(open).collect()
    }

    fn add_outside(
        &self,
        frame: &Frame,
        aperture: &Aperture,
        border: &Border,
        open: &mut Vec<Open>,
    ) {
        let scene = self.scene(Some(border), Some(frame), &[]);
        let aperture_mm2 = aperture.area_mm2();
        for &corners in &frame.triangles {
            let places = scene.corners(corners);
            let whereabouts = border.whereabouts(places);
            if whereabouts != Whereabouts::Outside {
                let area_mm2 = common_area_mm2(aperture, aperture_mm2, border, places);
                let standing = Standing::Bridge;
                let beyond_mm2 = area_mm2;
                open.push(Open { corners, standing, whereabouts, area_mm2, beyond_mm2 });
            }
        }
    }

    fn draw(
        &self,
        aperture: &Aperture,
        border: &Border,
        frame: &Frame,
        (open, gauged): (&[Open], &[Gauged]),
        lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
    ) -> Result<Patches, CoverageError> {
        let opening_mm = |vertex: VertexId| {
            let [x, y, _] = self.points[vertex as usize];
            let gap_mm = self.target.gap_mm(sound_lfs(lfs_mm(x, y)));
            gap_mm.filter(|gap_mm| gap_mm.is_finite()).unwrap_or(0.0)
        };
        let scene = self.scene(Some(border), Some(frame), &[]);
        if let Ok(drawing) = scene.draw(open, opening_mm) {
            return Ok(patches(&scene, (open, gauged), drawing, self.target, lfs_mm));
        }
        for attempt in 1..ATTEMPTS {
            let border = Border::new(aperture, self.triangles.len(), attempt);
            let open: Vec<Open> = open
                .iter()
                .map(|open| {
                    let whereabouts = border.whereabouts(scene.corners(open.corners));
                    Open { whereabouts, ..*open }
                })
                .collect();
            let scene = self.scene(Some(&border), Some(frame), &[]);
            if let Ok(drawing) = scene.draw(&open, opening_mm) {
                return Ok(patches(&scene, (&open, gauged), drawing, self.target, lfs_mm));
            }
        }
        Err(CoverageError::Coincidence)
    }

    /// The regions inside the outline of the data, which has these sides.
    pub(super) fn inside_outline(
        &self,
        gauged: &[Gauged],
        outer: &[[VertexId; 2]],
        lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
    ) -> Result<Patches, CoverageError> {
        let open = self.opened(gauged);
        let scene = self.scene(None, None, outer);
        let drawing = scene.draw(&open, |_| 0.0).map_err(|_| CoverageError::Coincidence)?;
        Ok(patches(&scene, (&open, gauged), drawing, self.target, lfs_mm))
    }

    fn scene<'a>(
        &'a self,
        border: Option<&'a Border>,
        frame: Option<&'a Frame>,
        outer: &'a [[VertexId; 2]],
    ) -> Scene<'a> {
        Scene { points: self.points, border, frame, outer }
    }
}

/// How often the border is drawn anew; once is hardly ever needed.
const ATTEMPTS: u32 = 8;

#[cfg(test)]
mod tests {
    use asphera_geometry::place;
    use asphera_mesh::Mesh;

    use super::*;
    use crate::coverage::cover;
    use crate::rim::{Outline, hull};

    #[test]
    fn a_sample_right_on_the_drawn_border_is_no_obstacle() {
        let aperture = Aperture::circle([0.0; 2], 3.0).unwrap();
        let corner = |count: usize, index: u32| {
            let [x, y] = Border::new(&aperture, count, 0).place(index);
            [x, y, 0.0]
        };
        let mut mesh = Mesh::new();
        mesh.insert(&[[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]]);
        mesh.insert(&[corner(0, 0), corner(0, 100), [0.1, 0.2, 0.0]]);
        let triangles = mesh.triangles();
        let border = Border::new(&aperture, triangles.len(), 0);
        assert!(mesh.points().iter().any(|&point| place(point) == border.place(100)));
        let target = Target::spacing_mm(0.1);
        let points = mesh.points();
        let measured = Measured { points, triangles: &triangles, target: &target };
        let hull = hull(&triangles, &Outline::new(points.len(), &triangles)).unwrap();
        let frame = Frame::new(points, hull, aperture.bounds_mm()).unwrap();
        let open: Vec<Open> = triangles
            .iter()
            .map(|&corners| Open {
                corners,
                standing: Standing::Undersampled,
                whereabouts: Whereabouts::Near,
                area_mm2: 1.0,
                beyond_mm2: 1.0,
            })
            .collect();
        let scene = measured.scene(Some(&border), Some(&frame), &[]);
        assert!(scene.draw(&open, |_| 0.0).is_err(), "the border passes through samples");
        let found = cover(points, &triangles, &[], Some(&aperture), &target, |_, _| None).unwrap();
        assert_eq!(found.patches.len(), 1);
        assert_eq!(found.patches[0].polygons.len(), 1);
    }
}
