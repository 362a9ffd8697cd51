//! How the distances of points lie about their scale: counted in classes, block of cells by block.

use crate::Loss;
use crate::live::Grid;

/// What a robust loss must know of points beyond their sums, to weigh them anew at another pose: how many lie how far
/// off, and where. Blocks are squares of cells of the map, [`BLOCKS`] along either side at most, and one for points
/// beyond the map. Classes are [`FINE`] for each octave of 1 + |distance| in scales: a sixteenth of a scale wide near
/// none, a quarter from 3 scales on, and so on.
#[derive(Clone, Debug)]
pub(crate) struct Classes {
    layout: Layout,
    /// `None` where no point has landed.
    blocks: Vec<Option<Box<[Class]>>>,
}

/// Which cells make a block, and how many classes there are.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layout {
    nx: usize,
    cells: usize,
    side: usize,
    columns: usize,
    blocks: usize,
    /// Classes of either sign.
    reach: usize,
}

/// Points of one block whose distances are alike.
#[derive(Clone, Copy, Debug, Default)]
struct Class {
    count: f64,
    /// Sums of the roots of the weights by uncertainty, of these weights, and of root times distance in scales.
    root: f64,
    weight: f64,
    moment: f64,
}

/// An occupied class with its mean distance at the reference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Occupied {
    pub(crate) block: usize,
    pub(crate) count: f64,
    /// Sum of the roots of the weights by uncertainty.
    pub(crate) root: f64,
    /// Their sum of squares over their sum: what a motion of the surface counts.
    pub(crate) mean_root: f64,
    /// In scales.
    pub(crate) distance: f64,
    /// Half the width of the class in scales: its points are taken to lie evenly about their mean. 0 in the outermost.
    pub(crate) half: f64,
}

impl Classes {
    /// Without points; `loss` says how far out distances matter.
    pub(crate) fn new(grid: &Grid, loss: Loss) -> Classes {
        let side = grid.nx.max(grid.ny).div_ceil(BLOCKS);
        let columns = grid.nx.div_ceil(side);
        let blocks = columns * grid.ny.div_ceil(side) + 1;
        let reach_scales = match loss {
            Loss::Huber { k } | Loss::Tukey { k } => (8.0 * k).max(LEAST_REACH),
            Loss::Squares => LEAST_REACH,
        };
        let reach = octave_class(reach_scales) + 1;
        let layout = Layout { nx: grid.nx, cells: grid.cells(), side, columns, blocks, reach };
        Classes { layout, blocks: vec![None; blocks] }
    }

    /// Takes a point of a cell, of the given root of its weight by uncertainty and distance in scales.
    pub(crate) fn add(&mut self, cell: usize, root: f64, distance: f64) {
        let Layout { reach, .. } = self.layout;
        let class = octave_class(distance.abs()).min(reach - 1);
        let class = if distance < 0.0 { reach - 1 - class } else { reach + class };
        let empty = || vec![Class::default(); 2 * reach].into();
        let block = self.layout.block(cell);
        let class = &mut self.blocks[block].get_or_insert_with(empty)[class];
        class.count += 1.0;
        class.root += root;
        class.weight += root * root;
        class.moment += root * distance;
    }

    /// Everything of another with the same layout.
    pub(crate) fn merge(&mut self, other: Classes) {
        for (block, other) in self.blocks.iter_mut().zip(other.blocks) {
            match (block.as_mut(), other) {
                (Some(block), Some(other)) => block.iter_mut().zip(&other).for_each(|(own, one)| {
                    own.count += one.count;
                    own.root += one.root;
                    own.weight += one.weight;
                    own.moment += one.moment;
                }),
                (None, other) => *block = other,
                (Some(_), None) => {}
            }
        }
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.layout.blocks
    }

    /// The block of a cell of the map; of one past the last cell, that of all points beyond the map.
    pub(crate) fn block(&self, cell: usize) -> usize {
        self.layout.block(cell)
    }

    /// The classes with points, block after block.
    pub(crate) fn occupied(&self) -> Vec<Occupied> {
        let reach = self.layout.reach;
        let halves: Vec<f64> = (0..reach).map(|class| half(class, reach)).collect();
        let mut all = Vec::new();
        for (block, classes) in self.blocks.iter().enumerate() {
            let Some(classes) = classes else { continue };
            for (index, class) in classes.iter().enumerate().filter(|(_, class)| class.root > 0.0) {
                let class_of_sign = if index < reach { reach - 1 - index } else { index - reach };
                all.push(Occupied {
                    block,
                    count: class.count,
                    root: class.root,
                    mean_root: class.weight / class.root,
                    distance: class.moment / class.root,
                    half: halves[class_of_sign],
                });
            }
        }
        all
    }
}

impl Layout {
    fn block(&self, cell: usize) -> usize {
        if cell >= self.cells {
            return self.blocks - 1;
        }
        cell / self.nx / self.side * self.columns + cell % self.nx / self.side
    }
}

/// The class of a distance of so many scales, 0 or more: the leading bits of 1 + distance.
fn octave_class(distance: f64) -> usize {
    (((1.0 + distance).to_bits() - 1.0_f64.to_bits()) >> CUT) as usize
}

/// Half the width of a class.
fn half(class: usize, reach: usize) -> f64 {
    if class + 1 >= reach {
        return 0.0;
    }
    let edge = |class: usize| f64::from_bits(1.0_f64.to_bits() + ((class as u64) << CUT));
    (edge(class + 1) - edge(class)) / 2.0
}

/// Largest number of blocks along one side of the map.
const BLOCKS: usize = 24;
/// Classes an octave: a power of two.
const FINE: u32 = 16;
/// Bits of a number that do not tell its class.
const CUT: u32 = f64::MANTISSA_DIGITS - 1 - FINE.ilog2();
/// Distances in scales that have a class of their own, at least.
const LEAST_REACH: f64 = 1e3;

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid =
        Grid { x_min_mm: 0.0, x_max_mm: 1.0, y_min_mm: 0.0, y_max_mm: 1.0, nx: 96, ny: 50 };

    #[test]
    fn classes_grow_with_the_distance() {
        for (distance, class, width) in [
            (0.0, 0, 1.0 / 16.0),
            (0.99, 15, 1.0 / 16.0),
            (1.0, 16, 0.125),
            (2.9, 31, 0.125),
            (3.0, 32, 0.25),
            (1e9, 478, 2.0_f64.powi(25)),
        ] {
            assert_eq!((octave_class(distance), 2.0 * half(class, 1000)), (class, width));
        }
        assert_eq!(half(999, 1000), 0.0);
    }

    #[test]
    fn blocks_are_squares_of_cells() {
        let classes = Classes::new(&GRID, Loss::HUBER);
        // 24 columns of 4 cells, 13 rows of which the last has 2 cells, and one block beyond the map.
        assert_eq!(classes.blocks(), 24 * 13 + 1);
        for (cell, block) in [(0, 0), (3, 0), (4, 1), (96 * 3 + 3, 0), (96 * 4, 24), (96 * 50, 312)] {
            assert_eq!(classes.block(cell), block);
        }
    }

    #[test]
    fn points_are_counted_by_sign_and_size() {
        let mut classes = Classes::new(&GRID, Loss::TUKEY);
        for (distance, root) in [(-0.01, 1.0), (0.01, 1.0), (0.05, 3.0), (f64::INFINITY, 0.0), (-4e7, 2.0)] {
            classes.add(7, root, distance);
        }
        let mut other = Classes::new(&GRID, Loss::TUKEY);
        other.add(7, 1.0, 0.03);
        classes.merge(other);
        let occupied = classes.occupied();
        let told: Vec<(f64, f64, f64)> =
            occupied.iter().map(|class| (class.count, class.root, class.mean_root)).collect();
        // The one without a weight counts nowhere.
        assert_eq!(told, [(1.0, 2.0, 2.0), (1.0, 1.0, 1.0), (3.0, 5.0, 2.2)]);
        assert_eq!((occupied[0].distance, occupied[0].half), (-4e7, 0.0));
        assert!((occupied[2].distance - 0.19 / 5.0).abs() < 1e-15);
        assert!(occupied.iter().all(|class| class.block == 1));
    }
}
