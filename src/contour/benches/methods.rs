//! How the time of every method grows, and whether it depends on the order of the points.
//!
//!     cargo bench -p asphera-contour --bench methods -- [--points N] [--runs R] [--methods A,B] [--once] [--json]
//!
//! Each takes N points at once, 1,000,000 where it is not said, against ten times a tenth of them: the method alone, and with its
//! triangulation. Processor seconds of one thread, the least of R runs, 3 where it is not said, as other work only adds to it. Graphs, curves and strokes have samples of
//! a closed curve, regions have points at random in a square. The last column is triangulation and method of the points in the order in
//! which they are traced, over the same in no order. A method that takes fewer points says so. With `--once` each method runs
//! once, with the N points as traced, and only its seconds are printed.

mod common {
    #[path = "../../../reconstruct/benches/common/clock.rs"]
    pub(crate) mod clock;
    pub(crate) mod clouds;
}

use asphera_contour::strokes::Hint;
use asphera_contour::{
    Choice, CurveSampling, Kind, Method, Parameters, PlaceMm, Samples, Triangulation,
};
use rayon::ThreadPoolBuilder;

use self::common::clock::timed;
use self::common::clouds::{flower, shuffled, square};

const PARTS: usize = 10;

/// What is timed of a triangulation.
#[derive(Clone, Copy)]
enum Work {
    /// A method with its defaults.
    Method(Method),
    /// The choice by the points.
    Choice,
    /// ε, ρ and u of the curve found by HNN-Crust, which is not timed.
    Sampling,
}

/// Points of the work: many, a tenth of them, and the many in no order.
struct Clouds {
    large: Vec<PlaceMm>,
    small: Vec<PlaceMm>,
    shuffled: Vec<PlaceMm>,
}

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name)?;
        Some(arguments.get(at + 1).expect("a value after each word").clone())
    };
    let number = |name: &str, most: usize| {
        value(name).map_or(most, |word| word.replace('_', "").parse().expect("a number"))
    };
    let (count, runs) = (number("--points", 1_000_000), number("--runs", 3));
    let [is_json, is_once] =
        ["--json", "--once"].map(|word| arguments.iter().any(|argument| argument == word));
    let wanted = value("--methods");
    let is_wanted =
        |name: &str| wanted.as_ref().is_none_or(|names| names.split(',').any(|it| it == name));
    let curve = Clouds::new(flower, count);
    let area = Clouds::new(square, count);
    let works = Method::ALL.into_iter().map(|method| (method.name(), Work::Method(method)));
    let works = works.chain([("choice", Work::Choice), ("sampling", Work::Sampling)]);
    if !is_json && !is_once {
        println!("{count} points against {PARTS} x {}, {runs} runs", count / PARTS);
        println!(
            "{:<20}{:>10}{:>10}{:>11}{:>17}",
            "", "s", "growth", "with mesh", "traced / random"
        );
    }
    let one = ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
    one.install(|| {
        let meshes = [("triangulation", &curve), ("of the square", &area)];
        for (name, clouds) in meshes.into_iter().filter(|_| !is_once) {
            let time = |points: &[PlaceMm]| {
                least((0..runs).map(|_| timed(|| drop(meshed(points))).1).collect())
            };
            let (whole, part) = (time(&clouds.large), time(&clouds.small));
            let growth = whole / (PARTS as f64 * part);
            let order = whole / time(&clouds.shuffled);
            print(is_json, name, Ok([whole, growth, growth, order]));
        }
        for (name, work) in works.filter(|(name, _)| is_wanted(name)) {
            let is_region = matches!(work, Work::Method(method) if is_of_area(method));
            let clouds = if is_region { &area } else { &curve };
            if is_once {
                print_once(is_json, name, work.times(&clouds.large));
            } else {
                print(is_json, name, work.growth(clouds, runs));
            }
        }
    });
}

impl Clouds {
    fn new(cloud: impl Fn(usize) -> Vec<PlaceMm>, count: usize) -> Clouds {
        let large = cloud(count);
        Clouds { shuffled: shuffled(large.clone()), large, small: cloud(count / PARTS) }
    }
}

impl Work {
    /// Seconds of the work, its growth alone and with the triangulation, and traced over random; why it is refused.
    fn growth(self, clouds: &Clouds, runs: usize) -> Result<[f64; 4], String> {
        let time = |points: &[PlaceMm]| -> Result<[f64; 2], String> {
            let times: Vec<[f64; 2]> =
                (0..runs).map(|_| self.times(points)).collect::<Result<_, _>>()?;
            Ok([0, 1].map(|which| least(times.iter().map(|time| time[which]).collect())))
        };
        let [large, small, random] =
            [time(&clouds.large)?, time(&clouds.small)?, time(&clouds.shuffled)?];
        let sum = |time: [f64; 2]| time[0] + time[1];
        let growth = |large: f64, small: f64| large / (PARTS as f64 * small);
        let (alone, with_mesh) = (growth(large[1], small[1]), growth(sum(large), sum(small)));
        Ok([large[1], alone, with_mesh, sum(large) / sum(random)])
    }

    /// Seconds of the triangulation, and of the work; why it is refused. What a method shares with others is made anew: order of
    /// lengths, nearest samples, trees.
    fn times(self, points: &[PlaceMm]) -> Result<[f64; 2], String> {
        let (mesh, mesh_s) = timed(|| meshed(points));
        if let Work::Sampling = self {
            let curve = asphera_contour::curves::hnn_crust(mesh.samples());
            return Ok([mesh_s, timed(|| drop(CurveSampling::new(&mesh, &curve))).1]);
        }
        let (found, seconds) = timed(|| self.run(&mesh));
        found.map(|()| [mesh_s, seconds])
    }

    fn run(self, mesh: &Triangulation) -> Result<(), String> {
        let Work::Method(method) = self else {
            if let Work::Choice = self {
                drop(Choice::new(mesh).curve(mesh));
            }
            return Ok(());
        };
        let none = Parameters::new();
        // The flower lies round its middle.
        let hints = [Hint { at_mm: [0.123, 0.234], label: "within".to_owned() }];
        let done = if method.takes_hints() {
            method.strokes(mesh, &none, &hints).map(drop)
        } else if method.kind() == Kind::Curve {
            method.curve(mesh, &none).map(drop)
        } else {
            method.run(mesh, &none).map(drop)
        };
        done.map_err(|error| error.to_string())
    }
}

/// Whether a method asks for points all over an area.
fn is_of_area(method: Method) -> bool {
    let is_strokes = method.takes_hints() || method == Method::TriangleGrowing;
    method.kind() == Kind::Region && !is_strokes
}

fn meshed(points: &[PlaceMm]) -> Triangulation {
    Triangulation::new(Samples::new(points).expect("finite points"))
}

fn least(times: Vec<f64>) -> f64 {
    times.into_iter().fold(f64::INFINITY, f64::min)
}

/// Prints seconds, growth of the method alone and with its triangulation, and traced over random.
#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn print(is_json: bool, name: &str, found: Result<[f64; 4], String>) {
    match found {
        Ok([seconds, alone, with_mesh, order]) if is_json => println!(
            "{{\"of\": \"{name}\", \"seconds\": {seconds:.4}, \"growth\": {alone:.3}, \"growth_with_mesh\": {with_mesh:.3}, \
             \"traced_over_random\": {order:.3}}}"
        ),
        Ok([seconds, alone, with_mesh, order]) => {
            println!("{name:<20}{seconds:>10.3}{alone:>10.2}{with_mesh:>11.2}{order:>17.2}");
        }
        Err(refused) if is_json => println!("{{\"of\": \"{name}\", \"refused\": \"{refused}\"}}"),
        Err(refused) => println!("{name:<20}{refused}"),
    }
}

/// Prints seconds of one run, alone.
#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn print_once(is_json: bool, name: &str, found: Result<[f64; 2], String>) {
    match found {
        Ok([_, seconds]) if is_json => {
            println!("{{\"of\": \"{name}\", \"seconds\": {seconds:.4}}}");
        }
        Ok([_, seconds]) => println!("{name:<20}{seconds:>10.3}"),
        Err(refused) => print(is_json, name, Err(refused)),
    }
}
