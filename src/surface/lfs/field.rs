//! Local feature size everywhere from its bounds at a few places.
//!
//! A distance changes by no more than the way gone, and lfs is the distance to the medial axis
//! (N. Amenta, M. Bern, Discrete & Computational Geometry 22 (1999) 481-504,
//! doi:10.1007/PL00009475). So bounds l ≤ lfs ≤ u at places xᵢ bound it at every place x:
//!
//! ```text
//! max (lᵢ - |x - xᵢ|)  ≤  lfs(x)  ≤  min (uᵢ + |x - xᵢ|)
//! ```
//!
//! no matter how they were had; those of a nominal and those of curvature go together. Places that lie
//! a fraction f of lfs apart add at most f·lfs to what is left open.

use asphera_geometry::{PointMm, WeightedTree, admit};

use super::error::LfsError;
use super::octree::{Cube, Octree};
use super::value::Lfs;

/// Data known of the local feature size at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LfsNode {
    /// The place in mm.
    pub at_mm: PointMm,
    /// It is not below this, in mm; zero if nothing is known.
    pub lower_mm: f64,
    /// It is not above this, in mm; infinite if nothing is known.
    pub upper_mm: f64,
}

/// Bounds of the local feature size at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LfsBounds {
    /// It is not below this, in mm; zero if nothing is known.
    pub lower_mm: f64,
    /// It is not above this, in mm; infinite if nothing is known.
    pub upper_mm: f64,
}

impl LfsBounds {
    /// How far the middle between the bounds may be off, relative to the lower one; infinite if one is
    /// missing.
    pub fn error(&self) -> f64 {
        if self.lower_mm > 0.0 && self.upper_mm.is_finite() {
            0.5 * (self.upper_mm - self.lower_mm) / self.lower_mm
        } else if self.lower_mm == f64::INFINITY {
            0.0
        } else {
            f64::INFINITY
        }
    }
}

/// Bounds of the local feature size everywhere.
#[derive(Clone, Debug, Default)]
pub struct LfsField {
    nodes: Vec<LfsNode>,
    uppers: WeightedTree,
    lowers: WeightedTree,
}

impl LfsField {
    /// The field of some nodes.
    ///
    /// # Errors
    ///
    /// When a place is not finite, a lower bound is negative or not a number, or above the upper one.
    pub fn new(nodes: impl IntoIterator<Item = LfsNode>) -> Result<LfsField, LfsError> {
        let mut field = LfsField::default();
        field.extend(nodes)?;
        Ok(field)
    }

    /// The field from a thinned set of `points`, so dense that at every one of them the way to a node adds at most
    /// `fraction` of the lower bound to what `lfs` leaves open. Where `lfs` knows no lower bound
    /// every cube of `smallest_mm` has a node; where it knows no upper one, so has it.
    ///
    /// n·log n time, and `lfs` is asked for about (2/f)² times the area over lfs².
    ///
    /// # Errors
    ///
    /// When the fraction is not between 0 and 1, the smallest side is not above zero, a point is
    /// not finite, or there are too many.
    pub fn thinned(
        points: &[PointMm],
        fraction: f64,
        smallest_mm: f64,
        mut lfs: impl FnMut(PointMm) -> Lfs,
    ) -> Result<LfsField, LfsError> {
        if !(fraction > 0.0 && fraction < 1.0) {
            let allowed = "above 0 and below 1";
            return Err(LfsError::Argument { name: "fraction", found: fraction, allowed });
        }
        super::error::positive("smallest_mm", smallest_mm)?;
        if points.len() >= u32::MAX as usize {
            return Err(LfsError::TooMany { found: points.len() });
        }
        let mut tree = Octree::new(smallest_mm);
        for (index, &point) in points.iter().enumerate() {
            checked(index, point)?;
            tree.insert(points, index as u32);
        }
        let mut nodes = Vec::new();
        let mut open: Vec<(Cube, Option<LfsNode>)> =
            tree.root().map(|root| (root, None)).into_iter().collect();
        while let Some((cube, above)) = open.pop() {
            let at_mm = points[cube.point as usize];
            let node = above.filter(|above| above.at_mm == at_mm).unwrap_or_else(|| {
                let found = lfs(at_mm);
                LfsNode { at_mm, lower_mm: found.lower_mm(), upper_mm: found.upper_mm() }
            });
            let children = tree.children(cube).map(|child| (child, Some(node)));
            let before = open.len();
            if cube.farthest_mm(at_mm) > fraction * node.lower_mm {
                open.extend(children);
            }
            if open.len() == before {
                nodes.push(node);
            }
        }
        LfsField::new(nodes)
    }

    /// Adds nodes. Bounds only get tighter; nodes must hold for the same surface. m·log m time for all
    /// m nodes there are then, so they are best added many at a time.
    ///
    /// When a surface grows, lower bounds had from less of it may no longer hold: then make
    /// the field anew. Upper bounds of a medial ball's own point still do.
    ///
    /// # Errors
    ///
    /// As [`LfsField::new`]; then none is added.
    pub fn extend(&mut self, nodes: impl IntoIterator<Item = LfsNode>) -> Result<(), LfsError> {
        let before = self.nodes.len();
        for (index, node) in nodes.into_iter().enumerate() {
            if let Err(error) = sound(index, &node) {
                self.nodes.truncate(before);
                return Err(error);
            }
            self.nodes.push(node);
        }
        let tree = |weight: &dyn Fn(&LfsNode) -> f64| {
            let entries = self.nodes.iter().map(|node| (node.at_mm, weight(node)));
            WeightedTree::new(entries.filter(|&(_, weight)| weight < f64::INFINITY))
        };
        self.uppers = tree(&|node| node.upper_mm);
        self.lowers = tree(&|node| -node.lower_mm);
        Ok(())
    }

    /// The nodes.
    pub fn nodes(&self) -> &[LfsNode] {
        &self.nodes
    }

    /// The bounds at a place; nothing is known where the place is not finite. Should the nodes contradict each
    /// other, both bounds are the upper one: too large a feature size is the dangerous mistake. log m time.
    pub fn at(&self, place_mm: PointMm) -> LfsBounds {
        if !place_mm.iter().all(|coordinate| coordinate.is_finite()) {
            return LfsBounds { lower_mm: 0.0, upper_mm: f64::INFINITY };
        }
        let upper_mm = self.uppers.least(place_mm).unwrap_or(f64::INFINITY);
        let lower_mm = self.lowers.least(place_mm).map_or(0.0, |least| (-least).max(0.0));
        LfsBounds { lower_mm: lower_mm.min(upper_mm), upper_mm }
    }
}

fn checked(index: usize, point: PointMm) -> Result<(), LfsError> {
    let [x, y, z] = point;
    admit(point).map(|_| ()).map_err(|_| LfsError::Point { index, x, y, z })
}

fn sound(index: usize, node: &LfsNode) -> Result<(), LfsError> {
    checked(index, node.at_mm)?;
    let LfsNode { lower_mm, upper_mm, .. } = *node;
    if lower_mm >= 0.0 && lower_mm <= upper_mm {
        Ok(())
    } else {
        Err(LfsError::Bounds { lower_mm, upper_mm })
    }
}
