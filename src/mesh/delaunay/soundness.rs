//! What must hold between the cells whatever was done, for tests.

use super::Delaunay;
use super::cells::{Cells, GHOST, NEXT, Side, Slot};

impl<C: Cells> Delaunay<C> {
    /// Checks that every side and the one across it name each other and run between the same
    /// vertices, that the ghosts close one ring, and that no cell is lost.
    ///
    /// # Panics
    ///
    /// When they do not.
    pub(crate) fn assert_sound(&self) {
        if self.sheet.plane.is_none() {
            return;
        }
        let spare = &self.sheet.work.spare;
        let used: Vec<Slot> =
            (0..self.cells.len() as Slot).filter(|slot| !spare.contains(slot)).collect();
        assert_eq!(used.len(), 2 * self.sheet.vertices - 2, "two cells a vertex, but for two");
        for &slot in &used {
            let corners = self.cells.corners(slot);
            for index in 0..3 {
                let side = Side::new(slot, index);
                let across = self.cells.across(side);
                assert_eq!(self.cells.across(across), side, "{corners:?}");
                assert_eq!(self.cells.end(across), corners[NEXT[index]], "{corners:?}");
            }
        }
        let ghosts: Vec<Slot> =
            used.into_iter().filter(|&slot| self.cells.corner(slot, 2) == GHOST).collect();
        let mut ring = 1;
        let next = |ghost| self.cells.across(Side::new(ghost, 1)).slot();
        let mut ghost = next(ghosts[0]);
        while ghost != ghosts[0] {
            (ghost, ring) = (next(ghost), ring + 1);
        }
        assert_eq!((ring, ghosts.len()), (self.sheet.work.ghosts, self.sheet.work.ghosts));
    }
}

#[cfg(test)]
mod tests {
    use asphera_geometry::PointMm;
    use proptest::prelude::*;

    use crate::regressions::beside_source;
    use crate::{Mesh, check};

    fn assert_sound_in(batches: &[&[PointMm]]) {
        let mut mesh = Mesh::new();
        for batch in batches {
            mesh.insert(batch);
            mesh.assert_sound();
            assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));
        }
    }

    /// Rows of 64 points at a slant, of which each starts all but in line with those before.
    #[test]
    fn a_row_before_the_side_it_is_sewn_to_from_inside() {
        let points: Vec<PointMm> = (0..1024)
            .map(|i| {
                let (row, column) = (f64::from(i / 64), f64::from(i % 64));
                let x = -0.5898856527714471 + 0.05694054680515 * column - 0.0394669491668942 * row;
                let y = 6.417400499236216 - 0.2923581608976425 * column + 0.091537100441442 * row;
                [x, y, 0.0]
            })
            .collect();
        assert_sound_in(&[&points]);
        assert_sound_in(&points.chunks(194).collect::<Vec<_>>());
    }

    /// An ellipse of all but no height, to which the next row is sewn right through.
    #[test]
    fn a_row_that_takes_the_whole_hull() {
        let ring = |y: f64, radius: f64, height: f64| {
            (0..64).map(move |i| {
                let angle = std::f64::consts::TAU * (f64::from(i) + 0.5) / 64.0;
                [radius * angle.cos(), y + height * angle.sin(), 0.0]
            })
        };
        let points: Vec<PointMm> =
            ring(-9.84, 1.79, 1e-12).chain(ring(-9.52, 3.07, 1e-12)).collect();
        for first in [0, 10, 27, 40] {
            assert_sound_in(&[&points[first..66]]);
            assert_sound_in(&[&points[first..]]);
        }
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn runs_over_a_small_lattice(
            runs in prop::collection::vec(
                (0_i8..6, 0_i8..6, -1_i8..=1, -1_i8..=1, 1_usize..7, prop::bool::ANY),
                1..14,
            ),
        ) {
            let mut batches: Vec<Vec<PointMm>> = vec![Vec::new()];
            for (x, y, dx, dy, count, ends) in runs {
                let places = (0..count as i8).map(|i| [x + i * dx, y + i * dy]);
                let last = batches.last_mut().expect("there is always one");
                last.extend(places.map(|[x, y]| [f64::from(x) * 0.003, f64::from(y) * 0.003, 0.0]));
                if ends {
                    batches.push(Vec::new());
                }
            }
            assert_sound_in(&batches.iter().map(Vec::as_slice).collect::<Vec<_>>());
        }

        /// Lines that arrive by turns, that cross, lie on one another or go out and back.
        #[test]
        fn lines_by_turns_over_a_small_lattice(
            lines in prop::collection::vec((0_i8..9, 0_i8..9, -1_i8..=1, -1_i8..=1, 1_i8..30), 2..6),
            count in 16_usize..160,
            batch in 8_usize..90,
        ) {
            let points: Vec<PointMm> = (0..count)
                .map(|index| {
                    let (x, y, dx, dy, length) = lines[index % lines.len()];
                    let step = (index / lines.len()) as i32 % (2 * i32::from(length));
                    let step = step.min(2 * i32::from(length) - step);
                    [(x, dx), (y, dy)]
                        .map(|(from, by)| f64::from(i32::from(from) + step * i32::from(by)) * 0.003)
                })
                .map(|[x, y]| [x, y, 0.0])
                .collect();
            assert_sound_in(&points.chunks(batch).collect::<Vec<_>>());
        }

        /// Lines side by side and scattered points in small batches, of which all are shared.
        #[test]
        fn two_threads_make_the_same_mesh_of_small_batches(
            pieces in prop::collection::vec(
                (0_u8..8, 0_u8..8, 1_u8..12, 1_u8..9, any::<bool>(), any::<bool>()),
                1..6,
            ),
            batch in 1_usize..120,
            from in 0_usize..40,
            jitter in prop::sample::select(vec![0.0, 0.05, 0.4]),
        ) {
            let mut points: Vec<PointMm> = Vec::new();
            for (x, y, columns, rows, turning, in_order) in pieces {
                let count = usize::from(columns) * usize::from(rows);
                points.extend((0..count).map(|index| {
                    let index = if in_order { index } else { index * 7919 % count };
                    let (row, step) = (index / usize::from(columns), index % usize::from(columns));
                    let back = turning && row % 2 == 1;
                    let column = if back { usize::from(columns) - 1 - step } else { step };
                    let off = |salt: usize| jitter * ((index * 7 + salt) as f64 * 0.618).sin();
                    let [x, y] = [(x, column, 0), (y, row, 3)]
                        .map(|(from, step, salt)| f64::from(from) + step as f64 + off(salt));
                    [0.003 * x, 0.003 * y, 0.0]
                }));
            }
            let [one, two] = [1, 2].map(|threads| {
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start")
            });
            let (mut alone, mut shared) = (Mesh::new(), Mesh::shared_from(from));
            for batch in points.chunks(batch) {
                one.install(|| alone.insert(batch));
                two.install(|| shared.insert(batch));
                shared.assert_sound();
                prop_assert_eq!(shared.triangles(), alone.triangles());
                prop_assert_eq!(shared.points(), alone.points());
                prop_assert_eq!(shared.counts(), alone.counts());
            }
            prop_assert_eq!(check::delaunay(alone.points(), alone.triangles()), Ok(()));
        }
    }
}
