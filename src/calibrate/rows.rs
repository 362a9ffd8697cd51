//! Rows of the linear problem: distances of corrected points from the artefact, and what each unknown does to them.

use asphera_form::linear::{CHUNK, Triangle};
use asphera_geometry::vector::{Vector, dot, length, minus, plus};
use rayon::prelude::*;

use crate::artefact::{Artefact, Pose};
use crate::columns::Columns;
use crate::correction::Axes;
use crate::map::Series;

/// The problem but for the values of the unknowns.
pub(crate) struct Problem<'a> {
    pub(crate) artefact: Artefact,
    pub(crate) poses: &'a [Pose],
    pub(crate) columns: Columns,
    /// Radius of the disc of the machine's heights, mm.
    pub(crate) map_radius_mm: f64,
    /// Radius of the disc of the artefact's form, mm.
    pub(crate) form_radius_mm: f64,
    /// 1 where the sphere's outside is seen from +z, −1 for its inside.
    pub(crate) side: f64,
    map: Option<Series>,
    form: Option<Series>,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(artefact: Artefact, poses: &'a [Pose], columns: Columns) -> Problem<'a> {
        let [map, form] = [&columns.map, &columns.form].map(|orders| Series::new(orders));
        Problem {
            artefact,
            poses,
            columns,
            map_radius_mm: 1.0,
            form_radius_mm: 1.0,
            side: 1.0,
            map,
            form,
        }
    }

    /// The factor of all rows, and of `radius`: weight and excess of the certified radius, if that is an unknown.
    /// Each row is multiplied by its distance where `by_distance`. It does not depend on the number of threads.
    pub(crate) fn triangle(
        &self,
        state: &[f64],
        radius: Option<[f64; 2]>,
        by_distance: bool,
    ) -> Triangle {
        let count = self.columns.count();
        let mut all = Triangle::new(count + 1);
        for (index, pose) in self.poses.iter().enumerate() {
            let of_chunk = |chunk: &[Axes]| {
                let mut triangle = Triangle::new(count + 1);
                let mut row = vec![0.0; count + 1];
                for &axes in chunk {
                    self.row(state, index, axes, &mut row);
                    if by_distance {
                        let distance = row[count];
                        row.iter_mut().for_each(|entry| *entry *= distance);
                    }
                    triangle.push(&row);
                }
                triangle.flush();
                triangle
            };
            let chunks: Vec<Triangle> = pose.axes.par_chunks(CHUNK).map(of_chunk).collect();
            chunks.iter().for_each(|chunk| all.join(chunk));
        }
        if let Some([weight, excess_mm]) = radius {
            let mut row = vec![0.0; count + 1];
            row[self.columns.radius()] = weight;
            row[count] = weight * excess_mm;
            all.push(&row);
        }
        all.flush();
        all
    }

    /// Distances of the points of each pose from the artefact, mm, in the order of measurement.
    pub(crate) fn residuals(&self, state: &[f64]) -> Vec<Vec<f64>> {
        let of_pose = |(index, pose): (usize, &Pose)| {
            let count = self.columns.count();
            let distance = |row: &mut Vec<f64>, &axes: &Axes| {
                self.row(state, index, axes, row);
                row[count]
            };
            pose.axes.par_iter().map_init(|| vec![0.0; count + 1], distance).collect()
        };
        self.poses.iter().enumerate().map(of_pose).collect()
    }

    /// The corrected place of a point.
    pub(crate) fn corrected(&self, state: &[f64], axes: Axes) -> Vector {
        let (place, outward) = axes.place();
        let mut corrected = place;
        for (at, parameter) in self.columns.parameters().zip(&self.columns.parameters) {
            corrected = plus(corrected, state[at], parameter.effect(place, outward));
        }
        if let Some(map) = &self.map {
            let [u, v] = [place[0] / self.map_radius_mm, place[1] / self.map_radius_mm];
            let start = self.columns.map().start;
            map.each(u, v, |term, value| corrected[2] -= state[start + term] * value);
        }
        corrected
    }

    /// The distance of a point in the last entry, and its change with each unknown in the others.
    fn row(&self, state: &[f64], pose: usize, axes: Axes, row: &mut [f64]) {
        row.fill(0.0);
        let corrected = self.corrected(state, axes);
        let at_place = self.columns.place(pose);
        let place: [f64; 3] = [0, 1, 2].map(|axis| state[at_place.start + axis]);
        let (normal, distance, across) = match self.artefact {
            Artefact::Sphere { .. } => {
                let from_centre = minus(corrected, place);
                let far = length(from_centre);
                let normal = from_centre.map(|entry| self.side * entry / far);
                (0..3).for_each(|axis| row[at_place.start + axis] = -normal[axis]);
                row[self.columns.radius()] = -self.side;
                let distance = self.side * (far - state[self.columns.radius()]);
                (normal, distance, [from_centre[0], from_centre[1]])
            }
            Artefact::Flat => {
                let [x, y, z] = corrected;
                let [height, along_x, along_y] = place;
                let size = (1.0 + along_x * along_x + along_y * along_y).sqrt();
                let normal = [-along_x / size, -along_y / size, 1.0 / size];
                let distance = (z - height - along_x * x - along_y * y) / size;
                row[at_place.start] = -1.0 / size;
                row[at_place.start + 1] = -x / size - distance * along_x / (size * size);
                row[at_place.start + 2] = -y / size - distance * along_y / (size * size);
                let shift = self.poses[pose].shift_mm;
                (normal, distance, [x - shift[0], y - shift[1]])
            }
        };
        let mut distance = distance;
        let (measured, outward) = axes.place();
        for (at, parameter) in self.columns.parameters().zip(&self.columns.parameters) {
            row[at] = dot(normal, parameter.effect(measured, outward));
        }
        if let Some(map) = &self.map {
            let [u, v] = [measured[0] / self.map_radius_mm, measured[1] / self.map_radius_mm];
            let start = self.columns.map().start;
            map.each(u, v, |term, value| row[start + term] = -normal[2] * value);
        }
        if let Some(form) = &self.form {
            let [u, v] = self.on_artefact(pose, across).map(|entry| entry / self.form_radius_mm);
            let start = self.columns.form().start;
            form.each(u, v, |term, value| {
                row[start + term] = -value;
                distance -= state[start + term] * value;
            });
        }
        row[self.columns.count()] = distance;
    }

    /// A place across the axis z in the frame of the artefact, which its turn has left.
    pub(crate) fn on_artefact(&self, pose: usize, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.poses[pose].turn_rad.sin_cos();
        [x * cos + y * sin, y * cos - x * sin]
    }
}
