//! How the distances of points lie about their scale: counted in classes, block of cells by block.

use crate::Loss;
use crate::live::Grid;

/// What a robust loss must know of points beyond their sums, to weigh them anew at another pose: how many lie how far
/// off, and where. Blocks are squares of cells of the map, [`BLOCKS`] along either side at most, and one for points
/// beyond the map. Classes are [`FINE`] for each octave of 1 + |distance| in scales: a sixteenth of a scale wide near
/// none, a quarter from 3 on, and so on. Weights of another octave have classes of their own, because the same shift moves
/// a point of four times the weight by twice as many scales. Each class knows the mean row of its points: so it is exact
/// for one point.
#[derive(Clone, Debug)]
pub(crate) struct Classes {
    layout: Layout,
    /// `None` where no point has landed.
    blocks: Vec<Option<Block>>,
}

/// Which cells make a block, and how many classes there are.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layout {
    nx: usize,
    cells: usize,
    side: usize,
    columns: usize,
    blocks: usize,
    /// Classes of either sign and one octave of weights.
    reach: usize,
    /// Derivatives of a row.
    parameters: usize,
}

/// The occupied classes of one block.
#[derive(Clone, Debug)]
struct Block {
    /// Which of the sums are those of a class; [`NOWHERE`] without points.
    places: Box<[u16]>,
    /// Of each occupied class the number of points, the sums of the roots of their weights by uncertainty, of these
    /// weights, of root times distance in scales, and of weight times derivatives.
    sums: Vec<f64>,
}

/// An occupied class with its mean distance at the reference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Occupied<'a> {
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
    /// Sum of the weights by uncertainty, and of the derivatives by these weights.
    pub(crate) weight: f64,
    pub(crate) row: &'a [f64],
}

impl Classes {
    /// Without points; `loss` says how far out distances matter. `side` is that of a block in cells, see [`side`].
    pub(crate) fn new(grid: &Grid, side: usize, parameters: usize, loss: Loss) -> Classes {
        let columns = grid.nx.div_ceil(side);
        let blocks = columns * grid.ny.div_ceil(side) + 1;
        let reach_scales = match loss {
            Loss::Huber { k } | Loss::Tukey { k } => (8.0 * k).max(LEAST_REACH),
            Loss::Squares => LEAST_REACH,
        };
        let reach = octave_class(reach_scales) + 1;
        let (nx, cells) = (grid.nx, grid.cells());
        let layout = Layout { nx, cells, side, columns, blocks, reach, parameters };
        Classes { layout, blocks: vec![None; blocks] }
    }

    /// Classes without points.
    pub(crate) fn emptied(&self) -> Classes {
        Classes { layout: self.layout, blocks: vec![None; self.layout.blocks] }
    }

    /// Takes a point of a cell, of the given root of its weight by uncertainty and distance in scales.
    pub(crate) fn add(&mut self, cell: usize, root: f64, distance: f64, derivatives: &[f64]) {
        let Layout { reach, parameters, .. } = self.layout;
        let class = octave_class(distance.abs()).min(reach - 1);
        let class = if distance < 0.0 { reach - 1 - class } else { reach + class };
        let class = 2 * reach * octave_of_weight(root) + class;
        let block = self.layout.block(cell);
        let block = self.blocks[block].get_or_insert_with(|| Block::new(reach));
        let sums = block.sums(class, FIRST_DERIVATIVE + parameters);
        let weight = root * root;
        sums[0] += 1.0;
        sums[1] += root;
        sums[2] += weight;
        sums[3] += root * distance;
        let rows = sums[FIRST_DERIVATIVE..].iter_mut().zip(derivatives);
        rows.for_each(|(sum, derivative)| *sum += weight * derivative);
    }

    /// Everything of another with the same layout.
    pub(crate) fn merge(&mut self, other: Classes) {
        let length = FIRST_DERIVATIVE + self.layout.parameters;
        for (block, other) in self.blocks.iter_mut().zip(other.blocks) {
            match (block.as_mut(), other) {
                (Some(block), Some(other)) => {
                    for (class, &place) in other.places.iter().enumerate() {
                        if place != NOWHERE {
                            let parts = &other.sums[usize::from(place) * length..][..length];
                            let own = block.sums(class, length);
                            own.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
                        }
                    }
                }
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

    /// The classes with points, block after block, from the lowest distances to the highest.
    pub(crate) fn occupied(&self) -> Vec<Occupied<'_>> {
        let Layout { reach, parameters, .. } = self.layout;
        let length = FIRST_DERIVATIVE + parameters;
        let halves: Vec<f64> = (0..reach).map(|class| half(class, reach)).collect();
        let mut all = Vec::new();
        for (index, block) in self.blocks.iter().enumerate() {
            let Some(block) = block else { continue };
            for (class, &place) in block.places.iter().enumerate() {
                if place == NOWHERE {
                    continue;
                }
                let sums = &block.sums[usize::from(place) * length..][..length];
                let class = class % (2 * reach);
                let class_of_sign = if class < reach { reach - 1 - class } else { class - reach };
                // Nothing is known of a point without any weight.
                if sums[1] > 0.0 {
                    all.push(Occupied {
                        block: index,
                        count: sums[0],
                        root: sums[1],
                        mean_root: sums[2] / sums[1],
                        distance: sums[3] / sums[1],
                        half: halves[class_of_sign],
                        weight: sums[2],
                        row: &sums[FIRST_DERIVATIVE..],
                    });
                }
            }
        }
        all
    }
}

impl Block {
    fn new(reach: usize) -> Block {
        Block { places: vec![NOWHERE; 2 * reach * WEIGHT_OCTAVES].into(), sums: Vec::new() }
    }

    /// The sums of a class, which are so many.
    fn sums(&mut self, class: usize, length: usize) -> &mut [f64] {
        let place = &mut self.places[class];
        if *place == NOWHERE {
            // There are some thousand classes.
            *place = (self.sums.len() / length) as u16;
            self.sums.resize(self.sums.len() + length, 0.0);
        }
        &mut self.sums[usize::from(*place) * length..][..length]
    }
}

/// The side of blocks that suits points over so many cells along the longer side.
pub(crate) fn side(cells: usize) -> usize {
    cells.div_ceil(BLOCKS).max(1)
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

/// The octave of the root of a weight. 1 lies in the middle of the middle one.
fn octave_of_weight(root: f64) -> usize {
    let furthest = (WEIGHT_OCTAVES / 2) as f64;
    (root.log2().round().clamp(-furthest, furthest) + furthest) as usize
}

/// Half the width of a class.
fn half(class: usize, reach: usize) -> f64 {
    if class + 1 >= reach {
        return 0.0;
    }
    let edge = |class: usize| f64::from_bits(1.0_f64.to_bits() + ((class as u64) << CUT));
    (edge(class + 1) - edge(class)) / 2.0
}

/// Blocks along the longer side of the points at the reference.
const BLOCKS: usize = 24;
/// Octaves of the roots of weights, an odd number.
const WEIGHT_OCTAVES: usize = 9;
/// Classes an octave: a power of two.
const FINE: u32 = 16;
/// Of a class without points.
const NOWHERE: u16 = u16::MAX;
/// Where the derivatives begin among the sums of a class.
const FIRST_DERIVATIVE: usize = 4;
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
            (0.0, 0, 0.0625),
            (0.99, 15, 0.0625),
            (1.0, 16, 0.125),
            (2.9, 31, 0.125),
            (3.0, 32, 0.25),
            (1e9, 477, 2.0_f64.powi(25)),
        ] {
            assert_eq!((octave_class(distance), 2.0 * half(class, 1000)), (class, width));
        }
        assert_eq!(half(999, 1000), 0.0);
    }

    #[test]
    fn blocks_are_squares_of_cells() {
        let classes = Classes::new(&GRID, side(96), 1, Loss::HUBER);
        // 24 columns of 4 cells, 13 rows of which the last has 2 cells, and one block beyond the map.
        assert_eq!(classes.blocks(), 24 * 13 + 1);
        for (cell, block) in [(0, 0), (3, 0), (4, 1), (96 * 3 + 3, 0), (96 * 4, 24), (96 * 50, 312)]
        {
            assert_eq!(classes.block(cell), block);
        }
    }

    #[test]
    fn points_are_counted_by_sign_and_size() {
        let mut classes = Classes::new(&GRID, side(96), 1, Loss::TUKEY);
        for (distance, root) in [
            (-0.01, 1.0),
            (0.01, 1.0),
            (0.05, 1.25),
            (f64::INFINITY, 0.0),
            (-4e7, 2.0),
            (0.05, 3.0),
        ] {
            classes.add(7, root, distance, &[distance]);
        }
        let mut other = Classes::new(&GRID, side(96), 1, Loss::TUKEY);
        other.add(7, 1.0, 0.03, &[1.0]);
        classes.merge(other);
        let occupied = classes.occupied();
        let told: Vec<(f64, f64, f64)> =
            occupied.iter().map(|class| (class.count, class.root, class.mean_root)).collect();
        // The one without a weight counts nowhere. Weights of another octave have classes of their own.
        let mean = 3.5625 / 3.25;
        assert_eq!(told, [(1.0, 1.0, 1.0), (3.0, 3.25, mean), (1.0, 2.0, 2.0), (1.0, 3.0, 3.0)]);
        assert_eq!((occupied[2].distance, occupied[2].half), (-4e7, 0.0));
        assert!((occupied[1].distance - 0.1025 / 3.25).abs() < 1e-15);
        // By the squares of the roots: 0.01 and 25/16 times 0.05, and 1 of the other.
        assert!((occupied[1].row[0] - 1.088_125).abs() < 1e-15 && occupied[1].weight == 3.5625);
        assert!(occupied.iter().all(|class| class.block == 1));
    }
}
