//! Triangle meshes of files: corners, and which three of them make a triangle.

use crate::detect::{check, format};
use crate::lengths::{Lengths, check_count};
use crate::xyz::TextOptions;
use crate::{Format, Place, ReadError, obj, off, ply, stl};

/// A triangle mesh as a file holds it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Corners, x y z in mm, in the order of the file. One that no triangle uses may be NaN.
    pub points_mm: Vec<[f64; 3]>,
    /// Three corners a triangle, counted from 0, in the order of the file. Their sense is that of the file.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads the faces of a mesh whose format is not known beforehand; `None` where the file holds points and no faces. `O(bytes)`.
///
/// Faces with more than three corners are cut in fans from their first corner, which is right for convex ones. Faces with fewer have no
/// area and are passed over. Arguments as of [`read_with`](crate::read_with).
///
/// # Errors
///
/// As [`read_with`](crate::read_with); a face with a corner that the file does not have, or that is a gap, with its place.
///
/// # Example
///
/// ```
/// let file = b"OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
/// let mesh = asphera_formats::read_triangles("square.off", file, &Default::default())?;
/// assert_eq!(mesh.unwrap().triangles, [[0, 1, 2], [0, 2, 3]]);
/// # Ok::<(), asphera_formats::ReadError>(())
/// ```
pub fn read_triangles(
    name: &str,
    bytes: &[u8],
    options: &TextOptions,
) -> Result<Option<Triangles>, ReadError> {
    let format = format(name, bytes)?;
    check(format, options)?;
    match format {
        Format::Ply => ply::read_triangles(bytes, options),
        Format::Stl => stl::read_triangles(bytes, options).map(Some),
        Format::Obj => obj::read_triangles(bytes, options),
        Format::Off => off::read_triangles(bytes, options),
        _ => Ok(None),
    }
}

/// A mesh as it is read.
pub(crate) struct Gathered {
    lengths: Lengths,
    mesh: Triangles,
}

/// A face names a corner that there is not.
#[derive(Debug)]
pub(crate) struct TooFar {
    /// Which of its corners, from 0.
    pub(crate) corner: usize,
    /// Corners that would do, in words.
    pub(crate) expected: String,
}

impl Gathered {
    pub(crate) fn new(lengths: Lengths) -> Gathered {
        Gathered { lengths, mesh: Triangles::default() }
    }

    /// Takes a corner in the units of the file.
    ///
    /// # Errors
    ///
    /// A coordinate that is infinite; more than [`MAX_POINTS`](crate::MAX_POINTS) corners.
    pub(crate) fn corner(
        &mut self,
        point: [f64; 3],
        place: impl Fn() -> Place,
    ) -> Result<(), ReadError> {
        let count = self.mesh.points_mm.len() as u64;
        check_count(self.lengths.format(), count + 1, &place)?;
        let point_mm = self.lengths.scaled(point, place)?;
        self.mesh.points_mm.push(point_mm.unwrap_or([f64::NAN; 3]));
        Ok(())
    }

    /// How many corners were taken.
    pub(crate) fn corners(&self) -> usize {
        self.mesh.points_mm.len()
    }

    /// Takes a face, whose corners are counted from 0, as a fan from its first one.
    ///
    /// # Errors
    ///
    /// A corner that was not taken, or is a gap.
    pub(crate) fn polygon(&mut self, indices: &[i64]) -> Result<(), TooFar> {
        let count = self.mesh.points_mm.len();
        let mut corners = Vec::with_capacity(indices.len());
        for (corner, &index) in indices.iter().enumerate() {
            // Not above MAX_POINTS, which an u32 counts.
            match usize::try_from(index).ok().filter(|&index| index < count) {
                None => {
                    let expected = format!("a face with corners of the {count} there are");
                    return Err(TooFar { corner, expected });
                }
                Some(index) if self.mesh.points_mm[index].iter().any(|side| side.is_nan()) => {
                    let expected = "a face with corners that have coordinates".to_owned();
                    return Err(TooFar { corner, expected });
                }
                Some(index) => corners.push(index as u32),
            }
        }
        if let [first, others @ ..] = &corners[..] {
            let fan = others.windows(2).map(|pair| [*first, pair[0], pair[1]]);
            self.mesh.triangles.extend(fan);
        }
        Ok(())
    }

    /// The mesh; `None` without a triangle.
    pub(crate) fn finish(self) -> Option<Triangles> {
        (!self.mesh.triangles.is_empty()).then_some(self.mesh)
    }
}

#[cfg(test)]
mod tests;
