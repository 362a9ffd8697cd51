//! How fast bytes become points, and points figures. Prints sizes and rates; nothing is asserted about time.

use asphera::config::Config;
use asphera::station::{Action, Bench, Happening, Point, assemble};
use asphera_link::{CanFrame, Command, Flags, Nanos};
use asphera_measure::{Along, Part, Pipeline};
use asphera_sim_chrocodile::Sample;
use asphera_sim_cia406::{Bus, NodeConfig};
use asphera_surface::Plane;
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    println!(
        "points of an asphere R 11.65 mm on a spiral of 9 mm, without noise; {TRIGGERS} triggers a run, chunks of 4096 bytes"
    );
    divan::main();
}

const TRIGGERS: u64 = 20_000;
const CHUNK: usize = 4096;

const PROBE: &str = "[link.probe]\nkind = \"tcp\"\naddress = \"127.0.0.1:7890\"\n\
    [device.probe]\ndriver = \"chrocodile2\"\nlink = \"probe\"\n\
    [device.probe.settings]\nsignals = [75, 76, 65, 66, 256, 257]\nscale_um = 10000\n";
const STAGE: &str = "[link.stage]\nkind = \"slcan-tcp\"\naddress = \"127.0.0.1:7891\"\nbit_rate_bps = 1000000\n\
    [device.stage]\ndriver = \"cia406\"\nlink = \"stage\"\n[device.stage.settings]\nnode_id = 5\nstep_nm = 1\n";
const NOMINAL: &str = "[nominal.surface]\nkind = \"asphere\"\nradius_mm = 11.65\nconic = -1.1\n\
    [nominal.aperture]\nshape = \"circle\"\nradius_mm = 9.1\n";

/// CHRocodile alone, with its encoders: telegrams to points.
#[divan::bench]
fn chrocodile_to_points(bencher: Bencher<'_, '_>) {
    let kinematics = "[sync]\ndevices = [\"probe\"]\n[kinematics]\nkind = \"cartesian\"\n\
        x = { device = \"probe\", channel = \"encoder_x\", mm_per_count = 1e-6 }\n\
        y = { device = \"probe\", channel = \"encoder_y\", mm_per_count = 1e-6 }\n\
        z = { device = \"probe\", channel = \"distance1\" }\n";
    let config = config(&[PROBE, kinematics, NOMINAL]);
    run(bencher, || {
        let mut lab = Lab::new(&config, &["probe"]);
        lab.trigger_all();
        lab
    });
}

/// CHRocodile and a transducer on slcan, joined by the trigger count: two links to points.
#[divan::bench]
fn chrocodile_and_cia406_to_points(bencher: Bencher<'_, '_>) {
    let kinematics = "[sync]\ndevices = [\"probe\", \"stage\"]\n[kinematics]\nkind = \"polar\"\n\
        rotary = { device = \"probe\", channel = \"encoder_x\", counts_per_turn = 3600000 }\n\
        radial = { device = \"stage\", channel = \"position\" }\n\
        probe = { device = \"probe\", channel = \"distance1\" }\n";
    let config = config(&[PROBE, STAGE, kinematics, NOMINAL]);
    run(bencher, || {
        let mut lab = Lab::new(&config, &["probe", "stage"]);
        lab.trigger_all();
        lab
    });
}

/// The transducer alone: slcan lines to points.
#[divan::bench]
fn cia406_to_points(bencher: Bencher<'_, '_>) {
    let kinematics = "[sync]\ndevices = [\"stage\"]\n[kinematics]\nkind = \"cartesian\"\n\
        x = { device = \"stage\", channel = \"position\" }\ny = { constant_mm = 0 }\n\
        z = { constant_mm = 0 }\n";
    let config = config(&[STAGE, kinematics, NOMINAL]);
    run(bencher, || {
        let mut lab = Lab::new(&config, &["stage"]);
        lab.trigger_all();
        lab
    });
}

/// A pipeline takes points: mesh and running fit.
#[divan::bench(args = [10_000, 100_000, 1_000_000], sample_count = 3)]
fn points_into_pipeline(bencher: Bencher<'_, '_>, count: u64) {
    let part = part();
    let points: Vec<Point> = spiral(count).collect();
    bencher
        .counter(ItemsCount::new(count))
        .with_inputs(|| Pipeline::new(part.clone()))
        .bench_values(|mut pipeline| {
            points.iter().for_each(|point| pipeline.take(point.position_mm, point.reasons()));
            pipeline
        });
}

/// The same of a part that faces another direction than z.
#[divan::bench(args = [1_000_000], sample_count = 3)]
fn points_into_tilted_pipeline(bencher: Bencher<'_, '_>, count: u64) {
    let part = part();
    let normal = [0.5, -0.7, 0.5];
    let along = Along::direction(normal).expect("a direction");
    let plane = Plane::new([0.0; 3], normal).expect("a direction");
    let turned = |point: Point| Point { position_mm: plane.from_plane(point.position_mm), ..point };
    let points: Vec<Point> = spiral(count).map(turned).collect();
    bencher
        .counter(ItemsCount::new(count))
        .with_inputs(|| Pipeline::along(part.clone(), along))
        .bench_values(|mut pipeline| {
            points.iter().for_each(|point| pipeline.take(point.position_mm, point.reasons()));
            pipeline
        });
}

/// One snapshot's figures, with so many points behind it.
#[divan::bench(args = [10_000, 100_000, 1_000_000], sample_count = 20)]
fn figures_of_a_snapshot(bencher: Bencher<'_, '_>, count: u64) {
    let mut pipeline = Pipeline::new(part());
    spiral(count).for_each(|point| pipeline.take(point.position_mm, point.reasons()));
    // The first call looks at the sampling, as one call in many does.
    pipeline.figures();
    bencher.bench_local(|| pipeline.figures());
}

/// The same of a part whose PV is beyond its limit, but not for certain: then the most is looked at.
#[divan::bench(args = [100_000, 1_000_000], sample_count = 20)]
fn figures_of_a_snapshot_of_a_doubtful_part(bencher: Bencher<'_, '_>, count: u64) {
    let nominal = format!("{NOMINAL}[nominal.tolerance]\npv_nm = 199\nrms_nm = 50\n");
    let part = asphera_nominal::parse("part", &nominal.replace("nominal.", ""));
    let mut pipeline = Pipeline::new(part.expect("a nominal made for the benchmark"));
    for mut point in spiral(count) {
        let [x, y, z] = point.position_mm;
        point.position_mm[2] = z + 1e-4 * (2.0 * x).sin() * (2.0 * y).cos();
        pipeline.take(point.position_mm, point.reasons());
    }
    pipeline.figures();
    bencher.bench_local(|| pipeline.figures());
}

/// The final figures: fit, deviations, sampling, map.
#[divan::bench(args = [10_000, 100_000, 1_000_000], sample_count = 3)]
fn final_figures(bencher: Bencher<'_, '_>, count: u64) {
    let part = part();
    let points: Vec<Point> = spiral(count).collect();
    bencher
        .counter(ItemsCount::new(count))
        .with_inputs(|| {
            let mut pipeline = Pipeline::new(part.clone());
            points.iter().for_each(|point| pipeline.take(point.position_mm, point.reasons()));
            pipeline
        })
        .bench_values(Pipeline::finish);
}

fn config(parts: &[&str]) -> Config {
    let mut text = String::from("[station]\nname = \"bench\"\n");
    parts.iter().for_each(|part| text.push_str(part));
    Config::parse("bench", &text).expect("a configuration made for the benchmark")
}

fn part() -> Part {
    asphera_nominal::parse("part", &NOMINAL.replace("nominal.", ""))
        .expect("a nominal made for the benchmark")
}

fn run(bencher: Bencher<'_, '_>, prepare: impl Fn() -> Lab + Sync) {
    let bytes: usize = prepare().chunks.iter().map(|(_, chunk)| chunk.len()).sum();
    bencher
        .counter(BytesCount::new(bytes))
        .counter(ItemsCount::new(TRIGGERS))
        .with_inputs(prepare)
        .bench_values(|mut lab| {
            for (line, chunk) in &lab.chunks {
                lab.now += 1000;
                lab.bench.happened(Nanos::from_nanos(lab.now), *line, Happening::Received(chunk));
            }
            lab.bench.take_points()
        });
}

/// A station and its simulated devices in virtual time.
struct Lab {
    bench: Bench,
    lines: Vec<&'static str>,
    probe: asphera_sim_chrocodile::Device,
    bus: Bus,
    bus_in: asphera_slcan::Decoder,
    now: u64,
    chunks: Vec<(usize, Vec<u8>)>,
}

impl Lab {
    /// Sets the devices up until each would answer a trigger.
    fn new(config: &Config, lines: &[&'static str]) -> Lab {
        let mut lab = Lab {
            bench: assemble(config).expect("a configuration made for the benchmark"),
            lines: lines.to_vec(),
            probe: asphera_sim_chrocodile::Device::new(10_000.0),
            bus: Bus::new(vec![NodeConfig { node_id: 5, ..NodeConfig::default() }])
                .expect("one node"),
            bus_in: asphera_slcan::Decoder::new(),
            now: 0,
            chunks: Vec::new(),
        };
        lab.bench.command(Nanos::ZERO, Command::Start);
        for line in 0..lab.lines.len() {
            lab.bench.happened(Nanos::ZERO, line, Happening::Opened { epoch: 1 });
        }
        while !lab.bench.is_ready() {
            lab.now += 1_000_000;
            assert!(lab.now < 60_000_000_000, "the devices are not set up after a minute");
            lab.bench.advance(Nanos::from_nanos(lab.now));
            while let Some(action) = lab.bench.poll_action() {
                if let Action::Send { line, bytes, .. } = action {
                    lab.send(line, &bytes);
                }
            }
            let said = lab.probe.transmit();
            if let Some(line) = lab.line("probe").filter(|_| !said.is_empty()) {
                lab.bench.happened(Nanos::from_nanos(lab.now), line, Happening::Received(&said));
            }
            let frames = lab.bus.timeout(Nanos::from_nanos(lab.now));
            lab.frames(&frames);
        }
        lab
    }

    fn line(&self, name: &str) -> Option<usize> {
        self.lines.iter().position(|line| *line == name)
    }

    fn send(&mut self, line: usize, bytes: &[u8]) {
        if self.lines[line] == "probe" {
            self.probe.receive(bytes);
            return;
        }
        let mut rest = bytes;
        while let Some(item) = self.bus_in.decode(&mut rest) {
            if let asphera_slcan::Item::Frame(frame, _) = item {
                let answers = self.bus.receive(Nanos::from_nanos(self.now), &frame);
                self.frames(&answers);
            }
        }
    }

    fn frames(&mut self, frames: &[CanFrame]) {
        let mut bytes = Vec::new();
        frames.iter().for_each(|frame| asphera_slcan::encode(frame, &mut bytes));
        if let Some(line) = self.line("stage").filter(|_| !bytes.is_empty()) {
            self.bench.happened(Nanos::from_nanos(self.now), line, Happening::Received(&bytes));
        }
    }

    /// What all devices say to all triggers, cut into chunks.
    fn trigger_all(&mut self) {
        let (mut probe, mut stage) = (Vec::new(), Vec::new());
        for trigger in 0..TRIGGERS {
            self.probe.trigger(Sample {
                exposure_count: trigger,
                encoder: [trigger as i32, trigger as i32, 0, 0, 0],
                distance_um: Some(1000.0),
                intensity: 50.0,
                start_ns: 0,
                temperature_c: 20.0,
                flags: 0,
            });
            if trigger % 64 == 0 {
                probe.extend(self.probe.transmit());
            }
            let counter = (trigger % 240 + 1) as u8;
            for frame in self.bus.sync(Some(counter), &[trigger as i32]) {
                asphera_slcan::encode(&frame, &mut stage);
            }
        }
        probe.extend(self.probe.transmit());
        let streams: Vec<_> = [("probe", probe), ("stage", stage)]
            .into_iter()
            .filter_map(|(name, bytes)| Some((self.line(name)?, bytes)))
            .collect();
        // The links take turns, each with its share, as if both devices were read at the same pace.
        let rounds =
            streams.iter().map(|(_, bytes)| bytes.len().div_ceil(CHUNK)).max().unwrap_or(0);
        for round in 0..rounds {
            for (line, bytes) in &streams {
                let (from, to) = (bytes.len() * round / rounds, bytes.len() * (round + 1) / rounds);
                self.chunks.push((*line, bytes[from..to].to_vec()));
            }
        }
    }
}

/// Points of the nominal on a spiral of equal area a point.
fn spiral(count: u64) -> impl Iterator<Item = Point> {
    let pitch = (std::f64::consts::PI * 81.0 / count as f64).sqrt();
    (0..count).map(move |index| {
        let rho = 9.0 * ((index as f64 + 0.5) / count as f64).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * rho / pitch).sin_cos();
        let c = 1.0 / 11.65;
        let z = c * rho * rho / (1.0 + (1.0 + 0.1 * c * c * rho * rho).sqrt());
        Point {
            count: Some(index),
            host: Nanos::from_nanos(index),
            position_mm: [rho * cos, rho * sin, z],
            flags: Flags::empty(),
            u_mm: [0.0; 3],
        }
    })
}
