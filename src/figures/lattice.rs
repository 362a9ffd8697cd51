//! A regular raster recognised among places.
//!
//! Spectra and correlations need heights at even distances. Interpolating them lowers all short waves; where the
//! places already lie on a raster there is no need for that.

/// A rectangular raster of nodes, turned by any angle, with the place that lies at each node.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    columns: usize,
    rows: usize,
    spacing_mm: [f64; 2],
    origin_mm: [f64; 2],
    turn_rad: f64,
    /// Index of the place at each node, row after row; [`EMPTY`] at a gap.
    places: Vec<u32>,
    strays: usize,
}

impl Lattice {
    /// The raster on which the places lie, each within a fiftieth of a step of a node of its own; `None` if there is
    /// none. Nodes may be empty, and the raster may be turned. Up to one place in a hundred may be a stray: farther from its
    /// node, or the farther of two at one node. Strays are left out and counted.
    ///
    /// `triangles` are those of the Delaunay triangulation of the places, or some of them. On a raster most of them are
    /// halves of its cells, and one of these is the start. From there the raster is followed outwards, and fitted anew
    /// each time its reach has doubled. Takes time in proportion to the places and the logarithm of the nodes along a
    /// side; places on no raster cost a thousand triangles.
    ///
    /// A place off its node by a fiftieth of a step puts a wave of two steps off its phase by 4°, which takes 0.2 % off
    /// its height.
    pub fn find(places_mm: &[[f64; 2]], triangles: &[[u32; 3]]) -> Option<Lattice> {
        let start = Frame::of_a_cell(places_mm, triangles)?;
        let frame = start.followed(places_mm)?.rectangular()?;
        frame.occupied(places_mm)
    }

    /// Nodes along a row.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Rows of nodes.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Distance of columns and of rows in mm.
    pub fn spacing_mm(&self) -> [f64; 2] {
        self.spacing_mm
    }

    /// Place in mm of the node in the first column of the first row.
    pub fn origin_mm(&self) -> [f64; 2] {
        self.origin_mm
    }

    /// Angle from +x towards +y of the rows, above −π/4 and at most π/4; 0 where no node is a thousandth of a step off
    /// without it.
    pub fn turn_rad(&self) -> f64 {
        self.turn_rad
    }

    /// Places at no node of the raster, which it leaves out.
    pub fn strays(&self) -> usize {
        self.strays
    }

    /// Index of the place at each node, row after row, along the rows fastest; `None` at a gap.
    pub fn places(&self) -> impl Iterator<Item = Option<usize>> + '_ {
        self.places.iter().map(|&place| (place != EMPTY).then_some(place as usize))
    }
}

/// Steps of a raster from a node of it: place = origin + i·along + j·across.
#[derive(Clone, Copy, Debug)]
struct Frame {
    origin_mm: [f64; 2],
    along_mm: [f64; 2],
    across_mm: [f64; 2],
}

impl Frame {
    /// The cell that most triangles are halves of.
    fn of_a_cell(places_mm: &[[f64; 2]], triangles: &[[u32; 3]]) -> Option<Frame> {
        let some = triangles.len().min(SOME_TRIANGLES);
        let halves: Vec<Frame> = (0..some)
            .filter_map(|index| {
                Frame::of_half(places_mm, triangles[index * triangles.len() / some])
            })
            .collect();
        let alike =
            |frame: &&Frame| 2 * halves.iter().filter(|other| frame.is_like(other)).count() >= some;
        let tried = halves.len().min(SOME_STARTS);
        (0..tried).map(|index| &halves[index * halves.len() / tried]).find(alike).copied()
    }

    /// The cell that a triangle with a right angle is half of. Its steps lead nearest to +x and +y.
    fn of_half(places_mm: &[[f64; 2]], corners: [u32; 3]) -> Option<Frame> {
        let [a, b, c] = corners.map(|corner| places_mm[corner as usize]);
        let legs = |at: [f64; 2], p: [f64; 2], q: [f64; 2]| (at, minus(p, at), minus(q, at));
        let (origin_mm, p, q) = [legs(a, b, c), legs(b, c, a), legs(c, a, b)]
            .into_iter()
            .min_by(|one, other| dot(one.1, one.2).abs().total_cmp(&dot(other.1, other.2).abs()))?;
        let is_right = dot(p, q).abs() <= SHEAR * length(p) * length(q);
        let (along, across) =
            if p[0].abs() * length(q) >= q[0].abs() * length(p) { (p, q) } else { (q, p) };
        let upwards = |step: [f64; 2], axis: usize| {
            if step[axis] < 0.0 { step.map(|part| -part) } else { step }
        };
        let (along_mm, across_mm) = (upwards(along, 0), upwards(across, 1));
        (is_right && cross(along_mm, across_mm) > 0.0).then_some(Frame {
            origin_mm,
            along_mm,
            across_mm,
        })
    }

    fn is_like(&self, other: &Frame) -> bool {
        let near =
            |own: [f64; 2], others: [f64; 2]| length(minus(own, others)) <= NEAR * length(own);
        near(self.along_mm, other.along_mm) && near(self.across_mm, other.across_mm)
    }

    /// The node nearest to a place, and how far off it the place is, in steps.
    fn node(&self, place: [f64; 2]) -> ([f64; 2], f64) {
        let off = minus(place, self.origin_mm);
        let cell = cross(self.along_mm, self.across_mm);
        let at = [cross(off, self.across_mm) / cell, cross(self.along_mm, off) / cell];
        let node = at.map(f64::round);
        (node, (at[0] - node[0]).abs().max((at[1] - node[1]).abs()))
    }

    /// Fitted to all places, from near ones outwards; `None` once more than a few are far from every node.
    fn followed(self, places_mm: &[[f64; 2]]) -> Option<Frame> {
        let (mut frame, mut reach) = (self, FIRST_REACH);
        loop {
            let (mut sums, mut astray, mut beyond) = (Sums::default(), 0, 0);
            for place in places_mm {
                let (node, off) = frame.node(*place);
                if node[0].abs().max(node[1].abs()) > reach {
                    beyond += 1;
                } else if off > ASTRAY {
                    astray += 1;
                } else {
                    sums.add(node, minus(*place, frame.origin_mm));
                }
            }
            if (MOST_ASTRAY * astray) as f64 > sums.count || reach > MOST_STEPS {
                return None;
            }
            frame = sums.frame(frame.origin_mm)?;
            if beyond == 0 {
                return Some(frame);
            }
            reach *= 2.0;
        }
    }

    /// With steps at right angles; `None` where they are far from it.
    fn rectangular(self) -> Option<Frame> {
        let Frame { along_mm, across_mm, .. } = self;
        let sizes = [length(along_mm), length(across_mm)];
        let is_right = dot(along_mm, across_mm).abs() <= SHEAR * sizes[0] * sizes[1];
        is_right.then_some(self)
    }

    /// The raster, if enough places have a node of their own.
    fn occupied(self, places_mm: &[[f64; 2]]) -> Option<Lattice> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut strays = 0;
        for place in places_mm {
            let (node, off) = self.node(*place);
            if off > TOLERANCE {
                strays += 1;
                continue;
            }
            for axis in 0..2 {
                low[axis] = low[axis].min(node[axis]);
                high[axis] = high[axis].max(node[axis]);
            }
        }
        let size = [high[0] - low[0] + 1.0, high[1] - low[1] + 1.0];
        let most_nodes = MOST_NODES_A_PLACE * places_mm.len() as f64;
        // No place at a node makes a size of −∞.
        if size[0].min(size[1]) < 2.0 || size[0] * size[1] > most_nodes {
            return None;
        }
        let [columns, rows] = size.map(|nodes| nodes as usize);
        let mut places = vec![EMPTY; columns * rows];
        for (index, place) in places_mm.iter().enumerate() {
            let (node, off) = self.node(*place);
            if off > TOLERANCE {
                continue;
            }
            let [column, row] = [0, 1].map(|axis| (node[axis] - low[axis]) as usize);
            let own = &mut places[row * columns + column];
            let index = u32::try_from(index).ok().filter(|index| *index != EMPTY)?;
            if *own == EMPTY {
                *own = index;
                continue;
            }
            strays += 1;
            if off < self.node(places_mm[*own as usize]).1 {
                *own = index;
            }
        }
        if strays * MOST_STRAYS > places_mm.len() {
            return None;
        }
        let spacing_mm = [length(self.along_mm), length(self.across_mm)];
        let origin_mm = [0, 1].map(|axis| {
            self.origin_mm[axis] + low[0] * self.along_mm[axis] + low[1] * self.across_mm[axis]
        });
        // Half of what turns the columns, half of what turns the rows.
        let turn_rad = 0.5
            * (self.along_mm[1].atan2(self.along_mm[0])
                + (-self.across_mm[0]).atan2(self.across_mm[1]));
        let farthest_mm = turn_rad.abs() * (size[0] * spacing_mm[0]).max(size[1] * spacing_mm[1]);
        let turn_rad =
            if farthest_mm <= UPRIGHT * spacing_mm[0].min(spacing_mm[1]) { 0.0 } else { turn_rad };
        Some(Lattice { columns, rows, spacing_mm, origin_mm, turn_rad, places, strays })
    }
}

/// Moments of nodes and their places, for the frame of least squares.
#[derive(Default)]
struct Sums {
    count: f64,
    node: [f64; 2],
    place: [f64; 2],
    nodes: [f64; 3],
    products: [[f64; 2]; 2],
}

impl Sums {
    fn add(&mut self, node: [f64; 2], place: [f64; 2]) {
        self.count += 1.0;
        for axis in 0..2 {
            self.node[axis] += node[axis];
            self.place[axis] += place[axis];
            let products = self.products[axis].iter_mut().zip(place);
            products.for_each(|(sum, place)| *sum += node[axis] * place);
        }
        self.nodes[0] += node[0] * node[0];
        self.nodes[1] += node[0] * node[1];
        self.nodes[2] += node[1] * node[1];
    }

    /// Places were given from `about_mm`.
    fn frame(&self, about_mm: [f64; 2]) -> Option<Frame> {
        let mean = |sums: [f64; 2]| sums.map(|sum| sum / self.count);
        let (node, place) = (mean(self.node), mean(self.place));
        let xx = self.nodes[0] / self.count - node[0] * node[0];
        let xy = self.nodes[1] / self.count - node[0] * node[1];
        let yy = self.nodes[2] / self.count - node[1] * node[1];
        let determinant = xx * yy - xy * xy;
        let products = |axis: usize, other: usize| {
            self.products[axis][other] / self.count - node[axis] * place[other]
        };
        let along_mm =
            [0, 1].map(|other| (yy * products(0, other) - xy * products(1, other)) / determinant);
        let across_mm =
            [0, 1].map(|other| (xx * products(1, other) - xy * products(0, other)) / determinant);
        let origin_mm = [0, 1].map(|axis| {
            about_mm[axis] + place[axis] - node[0] * along_mm[axis] - node[1] * across_mm[axis]
        });
        let usable = determinant > 0.0 && cross(along_mm, across_mm) > 0.0;
        usable.then_some(Frame { origin_mm, along_mm, across_mm })
    }
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn length(a: [f64; 2]) -> f64 {
    a[0].hypot(a[1])
}

/// No place is at a node.
const EMPTY: u32 = u32::MAX;
/// Farthest a place may be from its node, in steps.
const TOLERANCE: f64 = 0.02;
/// At most one place in so many may lie at no node.
const MOST_STRAYS: usize = 100;
/// Largest cosine of the angle between rows and columns: a raster seen along a tilted axis is sheared a little, and that
/// puts frequencies off by half as much.
const SHEAR: f64 = 0.04;
/// Largest difference of the steps of two cells, as a share.
const NEAR: f64 = 0.05;
/// Triangles that are looked at for a cell, and cells that are tried.
const SOME_TRIANGLES: usize = 1000;
const SOME_STARTS: usize = 16;
/// Reach of the first fit, in steps: the start is off by less than a quarter of a step there.
const FIRST_REACH: f64 = 4.0;
/// So far from every node, in steps, a place counts as astray; at most one in so many may be.
const ASTRAY: f64 = 0.25;
const MOST_ASTRAY: usize = 20;
/// Places farther from the start, in steps, lie on no raster that fits in memory.
const MOST_STEPS: f64 = 1e7;
/// Places so sparse that their nodes outnumber them more are rounded coordinates rather than a raster.
const MOST_NODES_A_PLACE: f64 = 16.0;
/// A raster is upright if no node is off by more than this, in steps, when it is taken to be.
const UPRIGHT: f64 = 1e-3;
