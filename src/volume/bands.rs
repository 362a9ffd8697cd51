//! Marching cubes band by band: a surface that need not fit into memory.

use std::ops::Range;

use rayon::prelude::*;

use crate::cell::EDGES;
use crate::cells::mixed_codes;
use crate::cuts::{CellMesh, Cuts};
use crate::marching::{Cutter, Room};
use crate::numbering::{Numbers, Starts, starts};
use crate::scan::{Gaps, Scan};
use crate::surface::area_and_volume;
use crate::table::{Ambiguity, Table};
use crate::{Crossings, Samples};

/// The surface of [`marching_cubes`](crate::marching_cubes), some slices at a time.
#[derive(Debug)]
pub struct Bands<'a> {
    scan: Scan<'a>,
    rule: Ambiguity,
    starts: Vec<Starts>,
}

/// The vertices of some slices, and the triangles that lie between each of these slices and the next one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceBand {
    /// The number of the first vertex.
    pub first: u32,
    /// Vertices in samples, numbered from `first`.
    pub vertices: Vec<[f64; 3]>,
    /// Corners of the triangles by number; the highest may be vertices of the band after this one.
    pub triangles: Vec<[u32; 3]>,
}

impl Bands<'_> {
    /// Counts the vertices, by slices in the caller's pool.
    ///
    /// # Panics
    ///
    /// Where there are more than 2³² vertices.
    pub fn new(samples: &Samples, rule: Ambiguity) -> Bands<'_> {
        Bands::of(Scan::new(samples, Gaps::default()), rule)
    }

    /// The same of a volume with gaps: no cell with a corner in one has surface. The bands are those of
    /// [`Surface::without_gaps`](crate::Surface::without_gaps).
    ///
    /// # Panics
    ///
    /// As [`Bands::new`], and where the sizes differ.
    pub fn with_gaps<'a>(samples: &'a Samples, gaps: Gaps<'a>, rule: Ambiguity) -> Bands<'a> {
        Bands::of(Scan::new(samples, gaps), rule)
    }

    fn of(scan: Scan<'_>, rule: Ambiguity) -> Bands<'_> {
        let starts = starts(scan, Table::of(rule));
        Bands { scan, rule, starts }
    }

    /// The number of all vertices.
    pub fn vertices(&self) -> u32 {
        self.starts[self.slices()].of_slice
    }

    /// The number of slices that bands are cut from: all of the volume, and the layer on one side.
    pub fn slices(&self) -> usize {
        self.scan.samples.size()[2] + 1
    }

    /// The band of some slices. `crossings` is asked about the samples of the slices `start - 1` to `end - 1` only.
    ///
    /// The bands of all slices in turn are the surface: its vertices and triangles in the same order, to the bit.
    ///
    /// # Panics
    ///
    /// Where there are no such slices.
    pub fn band(&self, slices: Range<usize>, crossings: &impl Crossings) -> SurfaceBand {
        assert!(slices.start < slices.end && slices.end <= self.slices(), "no such slices");
        let [from, to] = [slices.start, slices.end].map(|at| self.starts[at].numbers());
        // A table has no vertices within cells.
        let mut vertices = vec![[0.0; 3]; to[0] - from[0]];
        let mut triangles = vec![[0; 3]; to[2] - from[2]];
        let first = self.starts[slices.start].of_slice;
        let room = Room::new(&mut vertices, to[0] - from[0], &mut triangles);
        let Bands { scan, rule, starts } = self;
        let cutter = Cutter { scan: *scan, cuts: Table::of(*rule), crossings, starts };
        cutter.band(slices, room, &mut Numbers::new(scan.samples));
        SurfaceBand { first, vertices, triangles }
    }

    /// The areas of the triangles between slices and the next ones, by slices in the caller's pool; no mesh is made.
    ///
    /// `crossings` is asked about the samples of the slices `start - 1` to `end - 1` only. `place` gives vertices in samples the unit of
    /// the areas.
    ///
    /// # Panics
    ///
    /// As [`Bands::band`].
    pub fn areas(
        &self,
        slices: Range<usize>,
        crossings: &impl Crossings,
        place: impl Fn([f64; 3]) -> [f64; 3] + Sync,
    ) -> Vec<f64> {
        assert!(slices.start < slices.end && slices.end <= self.slices(), "no such slices");
        let of_slice = |z: usize| self.area(z, crossings, &place);
        slices.into_par_iter().map(of_slice).collect()
    }

    fn area(
        &self,
        z: usize,
        crossings: &impl Crossings,
        place: &impl Fn([f64; 3]) -> [f64; 3],
    ) -> f64 {
        let table = Table::of(self.rule);
        let mut mesh = CellMesh::default();
        let mut area = 0.0;
        self.scan.mixed_words(z, |y, word, corners, mixed| {
            mixed_codes(word, corners, mixed, |x, code| {
                let vertex = |edge: u8| {
                    let (edge, direction) = (EDGES[usize::from(edge)], usize::from(edge) / 4);
                    let from = [x + (edge[0] & 1), y + (edge[0] >> 1 & 1), z + (edge[0] >> 2)]
                        .map(|at| at as i64 - 1);
                    let mut vertex = from.map(|at| at as f64);
                    vertex[direction] += crossings.share(from, direction);
                    place(vertex)
                };
                let mut add = |triangle: &[u8; 3]| {
                    let corners = triangle.map(vertex);
                    area += area_and_volume(corners[0], corners).0;
                };
                if let Some(plain) = table.plain(code) {
                    plain.iter().for_each(&mut add);
                    return;
                }
                mesh.triangles.clear();
                Cuts::cut(table, self.scan, [x, y, z], code, &mut mesh);
                mesh.triangles.iter().for_each(&mut add);
            });
        });
        area
    }
}

/// Crossings by the grey values of some slices of a volume.
#[derive(Clone, Copy, Debug)]
pub struct GreySlices<'a> {
    /// The values of these slices alone.
    pub grey: crate::Grey<'a>,
    /// The first of them in the volume.
    pub first_slice: usize,
}

impl Crossings for GreySlices<'_> {
    fn share(&self, mut from: [i64; 3], axis: usize) -> f64 {
        from[2] -= self.first_slice as i64;
        self.grey.share(from, axis)
    }
}
