//! Connected parts of foreground and background: union-find over runs of samples, slice by slice.

use std::ops::Range;

use crate::Samples;

/// A run of samples of one row, and the part it belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Run {
    /// Columns of the padded volume.
    columns: Range<u32>,
    /// Row and slice of the padded volume.
    row: [u32; 2],
}

/// The connected parts of a volume's foreground (neighbours share a face of their voxels).
#[derive(Clone, Debug)]
pub struct Parts {
    size: [usize; 3],
    runs: Vec<Run>,
    /// The part of each run; parts count from 0, the largest first.
    part_of_run: Vec<u32>,
    samples: Vec<u64>,
}

impl Parts {
    /// Finds the parts of the foreground.
    pub fn label(samples: &Samples) -> Parts {
        let (runs, mut forest) = runs_joined(samples, Phase::Foreground);
        let mut roots: Vec<(u64, u32)> = Vec::new();
        let mut number = vec![u32::MAX; runs.len()];
        for (index, run) in runs.iter().enumerate() {
            let root = forest.root(index as u32) as usize;
            if number[root] == u32::MAX {
                number[root] = roots.len() as u32;
                roots.push((0, root as u32));
            }
            roots[number[root] as usize].0 += u64::from(run.columns.end - run.columns.start);
        }
        // The largest first; of equal ones the one whose first sample comes first, which is its smallest run.
        roots.sort_by_key(|&(samples, root)| (std::cmp::Reverse(samples), root));
        for (index, &(_, root)) in roots.iter().enumerate() {
            number[root as usize] = index as u32;
        }
        let part_of_run =
            (0..runs.len() as u32).map(|run| number[forest.root(run) as usize]).collect();
        let counts = roots.iter().map(|&(samples, _)| samples).collect();
        Parts { size: samples.size(), runs, part_of_run, samples: counts }
    }

    /// The number of parts.
    pub fn count(&self) -> usize {
        self.samples.len()
    }

    /// The samples of each part, the largest first.
    pub fn samples(&self) -> &[u64] {
        &self.samples
    }

    /// One part alone, counted from 0, the largest first; `None` where there are not as many.
    pub fn volume_of(&self, part: usize) -> Option<Samples> {
        if part >= self.count() {
            return None;
        }
        let mut alone = Samples::background(self.size).ok()?;
        for (run, &of) in self.runs.iter().zip(&self.part_of_run) {
            if of as usize == part {
                let row = alone.row_mut(run.row[0] as usize, run.row[1] as usize);
                for x in run.columns.clone() {
                    row[x as usize / 64] |= 1 << (x % 64);
                }
            }
        }
        Some(alone)
    }
}

/// The number of parts of the foreground, as [`Parts`] has them; the memory is that of two slices of runs.
pub fn components(samples: &Samples) -> u64 {
    count(samples, Phase::Foreground)
}

/// The number of parts of the background that the foreground encloses (neighbours share at least a corner of their voxels).
pub fn cavities(samples: &Samples) -> u64 {
    // One of them is the outside, for the layer around the volume is connected.
    count(samples, Phase::Background) - 1
}

/// The number of parts of a phase, slice by slice: a part that no run of the newest slice belongs to is finished.
fn count(samples: &Samples, phase: Phase) -> u64 {
    let mut sweep = Sweep::new(samples, phase);
    let mut finished = 0;
    for z in 0..samples.size()[2] + 2 {
        sweep.slice(z);
        finished += sweep.forget();
    }
    finished + sweep.forest.roots() as u64
}

#[derive(Clone, Copy, PartialEq)]
enum Phase {
    Foreground,
    Background,
}

/// The runs of one phase, those of neighbouring rows joined. The root of a part is its first run.
fn runs_joined(samples: &Samples, phase: Phase) -> (Vec<Run>, Forest) {
    let mut sweep = Sweep::new(samples, phase);
    for z in 0..samples.size()[2] + 2 {
        sweep.slice(z);
    }
    (sweep.runs, sweep.forest)
}

/// Runs of one phase, found slice by slice.
struct Sweep<'a> {
    samples: &'a Samples,
    phase: Phase,
    runs: Vec<Run>,
    forest: Forest,
    /// The first run of every row of the newest slice, and the end of the last.
    rows: Vec<usize>,
}

impl Sweep<'_> {
    fn new(samples: &Samples, phase: Phase) -> Sweep<'_> {
        Sweep { samples, phase, runs: Vec::new(), forest: Forest::default(), rows: Vec::new() }
    }

    /// Adds the next slice, counted in the padded volume.
    fn slice(&mut self, z: usize) {
        let Sweep { samples, phase, runs, forest, rows: before } = self;
        let [nx, ny, _] = samples.size();
        let reach = u32::from(*phase == Phase::Background);
        let mut here = Vec::with_capacity(ny + 3);
        for y in 0..ny + 2 {
            let start = runs.len();
            here.push(start);
            push_runs(samples.row(y, z), (nx + 2) as u32, *phase, |columns| {
                runs.push(Run { columns, row: [y as u32, z as u32] });
                forest.push();
            });
            let own = start..runs.len();
            let mut join = |range: Range<usize>| join(runs, forest, own.clone(), range, reach);
            if y > 0 {
                join(here[y - 1]..start);
            }
            if z > 0 {
                join(before[y]..before[y + 1]);
                // Background meets across edges and corners too.
                if *phase == Phase::Background {
                    if y > 0 {
                        join(before[y - 1]..before[y]);
                    }
                    if y + 1 < ny + 2 {
                        join(before[y + 1]..before[y + 2]);
                    }
                }
            }
        }
        here.push(runs.len());
        *before = here;
    }

    /// Forgets all runs but those of the newest slice, and gives the number of parts that have none there.
    fn forget(&mut self) -> u64 {
        let first = self.rows[0];
        // Its first run in the newest slice stands for a part from here on.
        let mut number = vec![u32::MAX; self.runs.len()];
        let mut parents = Vec::with_capacity(self.runs.len() - first);
        for run in first..self.runs.len() {
            let root = self.forest.root(run as u32) as usize;
            if number[root] == u32::MAX {
                number[root] = (run - first) as u32;
            }
            parents.push(number[root]);
        }
        let roots = self.forest.roots();
        self.forest.parents = parents;
        self.runs.drain(..first);
        self.rows.iter_mut().for_each(|start| *start -= first);
        (roots - self.forest.roots()) as u64
    }
}

/// Joins the runs of two rows that overlap, or lie within `reach` columns of each other.
fn join(runs: &[Run], forest: &mut Forest, a: Range<usize>, b: Range<usize>, reach: u32) {
    let (mut i, mut j) = (a.start, b.start);
    while i < a.end && j < b.end {
        let (one, other) = (&runs[i].columns, &runs[j].columns);
        if one.start < other.end + reach && other.start < one.end + reach {
            forest.join(i as u32, j as u32);
        }
        if one.end <= other.end {
            i += 1;
        } else {
            j += 1;
        }
    }
}

/// Calls `push` for every run of one phase among the first `columns` bits of a row.
fn push_runs(row: &[u64], columns: u32, phase: Phase, mut push: impl FnMut(Range<u32>)) {
    let mut start = None;
    for (index, &word) in row.iter().enumerate() {
        let mut word = if phase == Phase::Foreground { word } else { !word };
        let base = index as u32 * 64;
        if columns - base < 64 {
            word &= (1 << (columns - base)) - 1;
        }
        let mut at = 0;
        while at < 64 {
            let rest = word >> at;
            match start {
                None if rest == 0 => break,
                None => {
                    at += rest.trailing_zeros();
                    start = Some(base + at);
                }
                Some(from) => {
                    let length = rest.trailing_ones().min(64 - at);
                    at += length;
                    if at < 64 {
                        push(from..base + at);
                        start = None;
                    }
                }
            }
        }
    }
    if let Some(from) = start {
        push(from..columns);
    }
}

/// A union-find forest whose roots are the smallest of their sets.
#[derive(Debug, Default)]
pub(crate) struct Forest {
    parents: Vec<u32>,
}

impl Forest {
    /// A forest of items that are all apart.
    pub(crate) fn of(count: u32) -> Forest {
        Forest { parents: (0..count).collect() }
    }

    /// The number of sets.
    pub(crate) fn roots(&self) -> usize {
        (0_u32..).zip(&self.parents).filter(|(item, parent)| item == *parent).count()
    }

    fn push(&mut self) {
        self.parents.push(self.parents.len() as u32);
    }

    pub(crate) fn root(&mut self, mut item: u32) -> u32 {
        while self.parents[item as usize] != item {
            let parent = self.parents[item as usize];
            self.parents[item as usize] = self.parents[parent as usize];
            item = parent;
        }
        item
    }

    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}
