//! The graph method: its figures, the times of its stages, and the table of its choices.

use std::fmt::Write as _;

use asphera_geometry::PointMm;
use asphera_link::Nanos;
use asphera_reconstruct::{
    FaceRule, GraphChoices, GraphMap, GraphSurface, LandmarkOrder, LiveGraph, PointGraph, Stage,
    TileError, TileShelf, TiledGraph,
};
use clap::{Args, ValueEnum};
use serde::Serialize;

use crate::cli::output::Failure;
use crate::cli::usage::misused;
use crate::clock::Clock;

#[derive(Args)]
pub(super) struct GraphArgs {
    /// Of --method graph: neighbours of each point in the graph (κ).
    #[arg(long, value_name = "N", default_value_t = KAPPA, value_parser = clap::value_parser!(u8).range(1..=64))]
    kappa: u8,
    /// Of --method graph: hops between landmarks (k). More hops, coarser surface.
    #[arg(long, value_name = "K", default_value_t = 5, value_parser = clap::value_parser!(u8).range(1..=100))]
    hops: u8,
    /// Of --method graph: landmarks are joined whose cells touch at more points than this (a).
    #[arg(long, value_name = "A", default_value_t = 7)]
    threshold: u32,
    /// Of --method graph: which cycles are faces.
    #[arg(long, value_enum, default_value = "filled")]
    faces: Faces,
    /// Of --method graph: which points become landmarks first.
    #[arg(long, value_enum, default_value = "sweep")]
    order: Order,
    /// Of --method graph: put the points back that landmarks stand for, with the same topology.
    #[arg(long, conflicts_with = "sweep")]
    put_back: bool,
    /// Of --method graph: points wait in a file of TMPDIR, cut into tiles for so many megabytes of memory. The map of landmarks is in memory,
    /// too. A binary PLY file is read piece by piece. -o writes the landmarks only.
    #[arg(long, value_name = "MB", conflicts_with_all = ["put_back", "sweep", "compare"], value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    tiles: Option<u32>,
    /// Of --method graph with --order priority: take points so many at a time, in the order of the file. The map of landmarks is current after
    /// each batch, and the same at the end. Stages tell how long a batch takes.
    #[arg(long, value_name = "N", conflicts_with_all = ["put_back", "sweep", "compare", "tiles"], value_parser = clap::value_parser!(u32).range(1..))]
    batch: Option<u32>,
    /// Of --method graph: print a table of surfaces for several --hops and --threshold.
    #[arg(long)]
    sweep: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Faces {
    /// Those with points within: holes stay open.
    Filled,
    /// All with at most ten landmarks, as in the paper: small holes get lids.
    Any,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Order {
    /// By z, then x, then y: landmarks lie close together.
    Sweep,
    /// By a fixed number drawn from the coordinates: a further point changes landmarks near it only, but they lie less close.
    Priority,
}

impl GraphArgs {
    pub(super) fn sweeps(&self) -> bool {
        self.sweep
    }

    /// Whether anything of the graph method was asked for.
    pub(super) fn is_asked(&self) -> bool {
        self.sweep
            || self.put_back
            || self.tiles.is_some()
            || self.batch.is_some()
            || self.kappa != KAPPA
            || self.choices() != GraphChoices::default()
    }

    /// Megabytes for tiles, if they are asked for.
    pub(super) fn tiles(&self) -> Option<u32> {
        self.tiles
    }

    /// A graph in tiles that need so much memory.
    pub(super) fn by_tiles<S: TileShelf>(
        &self,
        shelf: S,
        megabytes: u32,
    ) -> Result<TiledGraph<S>, TileError> {
        let tile_points = megabytes as usize * 1_000_000 / BYTES_OF_TILE_POINT;
        TiledGraph::new(shelf, self.kappa.into(), tile_points)
    }

    pub(super) fn choices(&self) -> GraphChoices {
        let faces = match self.faces {
            Faces::Filled => FaceRule::Filled,
            Faces::Any => FaceRule::Any,
        };
        let order = match self.order {
            Order::Sweep => LandmarkOrder::Sweep,
            Order::Priority => LandmarkOrder::Priority,
        };
        GraphChoices { hops: self.hops, threshold: self.threshold, order, faces }
    }

    pub(super) fn surface(
        &self,
        points_mm: &[PointMm],
        clock: &Clock,
    ) -> Result<(GraphSurface, GraphStages), Failure> {
        if let Some(size) = self.batch {
            return self.in_batches(points_mm, size as usize, clock);
        }
        let mut stages = Stages::new(clock);
        let graph =
            PointGraph::new(points_mm, self.kappa.into(), &mut |stage| stages.enter(stage))?;
        let mut found = graph.surface(&self.choices(), &mut |stage| stages.enter(stage))?;
        if self.put_back {
            found.reconstruction = graph.put_back(&found, &mut |stage| stages.enter(stage));
        }
        Ok((found, stages.end()))
    }

    /// The surface of points that are taken in batches.
    fn in_batches(
        &self,
        points_mm: &[PointMm],
        size: usize,
        clock: &Clock,
    ) -> Result<(GraphSurface, GraphStages), Failure> {
        let GraphChoices { hops, threshold, order, faces } = self.choices();
        if order != LandmarkOrder::Priority {
            return Err(misused(
                "landmarks along the sweep change all over with a further point: --batch needs --order priority",
            ));
        }
        let mut graph = LiveGraph::new(self.kappa.into(), hops)?;
        let mut batches_s = Vec::with_capacity(points_mm.len().div_ceil(size));
        for batch in points_mm.chunks(size) {
            let since = clock.now();
            graph.insert(batch)?;
            batches_s.push(clock.now().since(since).as_secs_f64());
        }
        let mut stages = Stages::new(clock);
        stages.enter(Stage::Faces);
        let found = graph.surface(threshold, faces);
        let batches = Some(BatchStages::of(batches_s));
        Ok((found, GraphStages { batches, ..stages.end() }))
    }

    /// Surfaces of one graph: hops with the threshold asked for, thresholds with the hops asked for.
    pub(super) fn table(&self, points_mm: &[PointMm]) -> Result<SweepReport, Failure> {
        let graph = PointGraph::new(points_mm, self.kappa.into(), &mut |_| {})?;
        let asked = self.choices();
        let hops = HOPS.map(|hops| GraphChoices { hops, ..asked });
        let thresholds = THRESHOLDS.map(|threshold| GraphChoices { threshold, ..asked });
        let rows = hops.into_iter().chain(thresholds).map(|choices| {
            let found = graph.surface(&choices, &mut |_| {})?;
            Ok(Row::new(&choices, &found.map))
        });
        let rows = rows.collect::<Result<Vec<Row>, Failure>>()?;
        Ok(SweepReport { format: "asphera.reconstruct.sweep/1", kappa: self.kappa, rows })
    }
}

/// Memory for a point of a tile while it is at work.
const BYTES_OF_TILE_POINT: usize = 500;
/// Neighbours of the paper.
const KAPPA: u8 = 15;
/// The choices of the paper's Table 2.
const HOPS: [u8; 7] = [2, 3, 4, 5, 7, 14, 15];
const THRESHOLDS: [u32; 7] = [2, 3, 6, 7, 11, 15, 20];

/// Seconds of each stage.
#[derive(Debug, Default, Serialize)]
pub(super) struct GraphStages {
    tree: f64,
    neighbours: f64,
    landmarks: f64,
    cells: f64,
    map: f64,
    faces: f64,
    triangles: f64,
    /// With --batch only: what comes before faces.
    #[serde(skip_serializing_if = "Option::is_none")]
    batches: Option<BatchStages>,
    /// With --put-back only.
    #[serde(skip_serializing_if = "Option::is_none")]
    put_back: Option<f64>,
}

/// Seconds of batches, the map current after each.
#[derive(Debug, Serialize)]
struct BatchStages {
    count: usize,
    total: f64,
    median: f64,
    p99: f64,
    longest: f64,
}

impl BatchStages {
    fn of(mut batches_s: Vec<f64>) -> BatchStages {
        batches_s.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| {
            let place = (share * batches_s.len() as f64).ceil() as usize;
            batches_s.get(place.saturating_sub(1)).copied().unwrap_or_default()
        };
        BatchStages {
            count: batches_s.len(),
            total: batches_s.iter().sum(),
            median: at(0.5),
            p99: at(0.99),
            longest: at(1.0),
        }
    }
}

impl GraphStages {
    /// A line of milliseconds.
    pub(super) fn line(&self) -> String {
        let GraphStages { tree, neighbours, landmarks, cells, map, faces, triangles, .. } = self;
        let GraphStages { batches, put_back, .. } = self;
        let ms = |seconds: &f64| format!("{:.1}", 1e3 * seconds);
        if let Some(BatchStages { count, total, median, p99, longest }) = batches {
            return format!(
                "{count} batches {}, each {} (p99 {}, longest {}), surface {} ms",
                ms(total),
                ms(median),
                ms(p99),
                ms(longest),
                ms(faces)
            );
        }
        let put_back = put_back.as_ref().map(|seconds| format!(", put back {}", ms(seconds)));
        format!(
            "tree {}, neighbours {}, landmarks {}, cells {}, map {}, faces {}, triangles {}{} ms",
            ms(tree),
            ms(neighbours),
            ms(landmarks),
            ms(cells),
            ms(map),
            ms(faces),
            ms(triangles),
            put_back.unwrap_or_default()
        )
    }
}

/// Stages as they begin and end.
pub(super) struct Stages<'a> {
    clock: &'a Clock,
    running: Option<(Stage, Nanos)>,
    stages_s: GraphStages,
}

impl<'a> Stages<'a> {
    pub(super) fn new(clock: &'a Clock) -> Stages<'a> {
        Stages { clock, running: None, stages_s: GraphStages::default() }
    }

    pub(super) fn enter(&mut self, stage: Stage) {
        let now = self.clock.now();
        self.leave(now);
        self.running = Some((stage, now));
    }

    fn leave(&mut self, now: Nanos) {
        let Some((stage, since)) = self.running.take() else { return };
        let stages_s = &mut self.stages_s;
        *match stage {
            Stage::Tree => &mut stages_s.tree,
            Stage::Neighbours => &mut stages_s.neighbours,
            Stage::Landmarks => &mut stages_s.landmarks,
            Stage::Cells => &mut stages_s.cells,
            Stage::Map => &mut stages_s.map,
            Stage::Faces => &mut stages_s.faces,
            Stage::Triangles => &mut stages_s.triangles,
            Stage::PutBack => stages_s.put_back.get_or_insert(0.0),
        } += now.since(since).as_secs_f64();
    }

    pub(super) fn end(mut self) -> GraphStages {
        self.leave(self.clock.now());
        self.stages_s
    }
}

/// Surfaces for several choices: `asphera.reconstruct.sweep/1`.
#[derive(Debug, Serialize)]
pub(super) struct SweepReport {
    format: &'static str,
    kappa: u8,
    pub(super) rows: Vec<Row>,
}

#[derive(Debug, Serialize)]
pub(super) struct Row {
    hops: u8,
    threshold: u32,
    landmarks: usize,
    edges: usize,
    pub(super) faces: usize,
    triangles_percent: f64,
    /// By vertices − edges + faces. A half means that the map is no closed surface.
    pub(super) genus: f64,
}

impl Row {
    fn new(choices: &GraphChoices, map: &GraphMap) -> Row {
        let faces = map.faces.len();
        Row {
            hops: choices.hops,
            threshold: choices.threshold,
            landmarks: map.landmarks.len(),
            edges: map.edges,
            faces,
            triangles_percent: 100.0 * map.triangles() as f64 / faces.max(1) as f64,
            genus: map.genus(),
        }
    }
}

impl SweepReport {
    pub(super) fn summary(&self) -> String {
        let mut text = format!(
            "{:>5} {:>10} {:>10} {:>8} {:>8} {:>12} {:>8}\n",
            "hops", "threshold", "landmarks", "edges", "faces", "triangles %", "genus"
        );
        for row in &self.rows {
            // Writing into a String cannot fail.
            let _ = writeln!(
                text,
                "{:>5} {:>10} {:>10} {:>8} {:>8} {:>12.1} {:>8}",
                row.hops,
                row.threshold,
                row.landmarks,
                row.edges,
                row.faces,
                row.triangles_percent,
                row.genus
            );
        }
        text
    }
}
