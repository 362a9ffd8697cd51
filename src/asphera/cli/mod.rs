//! The command line: one file a subcommand.

mod benchmark;
mod calibrate;
mod check;
mod columns;
mod compare;
mod contour;
mod demo;
mod describe;
mod examples;
mod exit;
mod export;
mod face;
mod files;
mod graph;
mod manual;
mod measure;
mod nominal;
mod notify;
mod outlet;
mod output;
mod parts;
mod plan;
mod ports;
mod progress;
mod reconstruct;
mod reduce;
mod replay;
mod report;
mod run;
mod sample;
mod sampled;
mod sampling;
mod section;
mod serve;
mod simulate;
mod source;
mod summary;
mod text;
mod threads;
mod tip;
mod token;
mod unit_doubt;
mod usage;
mod volume;

use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;

use clap::{Args, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use tracing_subscriber::EnvFilter;

use exit::Exit;

/// Measures optical surfaces on line: points in, form deviation out.
#[derive(Parser)]
#[command(name = "asphera", version, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// What is logged to stderr: error, warn, info, debug, trace, or a filter like asphera_transport=trace.
    #[arg(
        long,
        global = true,
        env = "ASPHERA_LOG",
        hide_env_values = true,
        default_value = "warn",
        value_parser = filter
    )]
    log: String,
}

const AFTER_HELP: &str = "Example:
  asphera measure part.xyz --nominal sphere.toml

Exit codes: 0 done (the part passed, or no limits are given); \
1 a file, a port or a configuration cannot be used; 2 the command line is wrong; \
10 the part is outside a limit; 11 the measurement ended but a verdict could not be given, or `volume --check` found the grid too coarse.";

#[derive(Subcommand)]
enum Command {
    /// Measures a simulated part on a simulated bench, over real protocols.
    #[command(after_help = examples::DEMO)]
    Demo(demo::DemoArgs),
    /// Runs a station.
    #[command(after_help = examples::RUN)]
    Run(run::RunArgs),
    /// Checks a configuration without opening anything: all errors at once, each with file, line and key.
    #[command(after_help = examples::CHECK)]
    Check(ConfigArgs),
    /// Measures the points of a file (text, height maps, meshes, scans, arrays) or of a recorded session.
    #[command(after_help = examples::MEASURE)]
    Measure(measure::MeasureArgs),
    /// Reduces the points of a file or a session to as few as ε needs, no denser than their noise allows.
    #[command(after_help = examples::REDUCE)]
    Reduce(reduce::ReduceArgs),
    /// Cuts a measured surface along a line, a circle, a radius or in a plane: the profile as CSV, and its figures.
    #[command(after_help = examples::SECTION)]
    Section(section::SectionArgs),
    /// Finds the errors of a machine from a measured ball or flat, for `[calibration]` of a station.
    #[command(after_help = examples::CALIBRATE)]
    Calibrate(calibrate::CalibrateArgs),
    /// Finds the curve that points in the plane are samples of: outlines, edges, closed sections.
    #[command(after_help = examples::CONTOUR)]
    Contour(contour::ContourArgs),
    /// Makes samples of a known curve, a drawing or an image, with noise and outliers, to try `contour` without data.
    #[command(after_help = examples::SAMPLE)]
    Sample(sample::SampleArgs),
    /// Compares the methods of `contour` on curves made for it: which is best for which points. No data are needed.
    #[command(after_help = examples::BENCHMARK)]
    Benchmark(benchmark::BenchmarkArgs),
    /// Compares two contours: distances, areas, edges; with --shapes, how alike clouds are.
    #[command(after_help = examples::COMPARE)]
    Compare(compare::CompareArgs),
    /// Makes the graph of points: how parts hang together, where they have holes and branches, without a mesh.
    #[command(after_help = examples::GRAPH)]
    Graph(graph::GraphArgs),
    /// Lists the parts of a scene: points, place, size and holes of each; islands apart.
    #[command(after_help = examples::PARTS)]
    Parts(parts::PartsArgs),
    /// Says how densely points sample their surface, and what to measure next.
    #[command(after_help = examples::SAMPLING)]
    Sampling(sampling::SamplingArgs),
    /// Plans the path of a probe over a nominal, or through the places to measure next, with its time.
    #[command(after_help = examples::PLAN)]
    Plan(plan::PlanArgs),
    /// Makes a surface of a volume (CT, OCT, confocal), says whether its grid was fine enough, and measures volume and area.
    #[command(after_help = examples::VOLUME)]
    Volume(volume::VolumeArgs),
    /// Makes a surface in space of points that no plane shows whole, and proves what it is.
    #[command(after_help = examples::RECONSTRUCT)]
    Reconstruct(reconstruct::ReconstructArgs),
    /// Checks a nominal file and tells what it says, or makes one of a surface of a Zemax lens file.
    #[command(after_help = examples::NOMINAL)]
    Nominal(nominal::NominalArgs),
    /// Writes the points of a recorded session, or of any file that is read, as .xyz, .csv or .ply.
    #[command(after_help = examples::EXPORT)]
    Export(export::ExportArgs),
    /// Replays a recorded session.
    #[command(after_help = examples::REPLAY)]
    Replay(replay::ReplayArgs),
    /// Writes the report of a recorded session or of a file: one HTML file to read and to print, and QIF 3.
    #[command(after_help = examples::REPORT)]
    Report(report::ReportArgs),
    /// Runs the simulators of a bench, or of all devices of a station, or plays a recorded session back from the devices' side.
    #[command(after_help = examples::SIMULATE)]
    Simulate(simulate::SimulateArgs),
    /// Listens to a device that sends lines or records, and proposes its settings.
    #[command(after_help = examples::DESCRIBE)]
    Describe(describe::DescribeArgs),
    /// Lists serial ports and CAN interfaces by their stable names.
    #[command(after_help = examples::PORTS)]
    Ports,
    /// Prints the completions of a shell.
    #[command(after_help = examples::COMPLETIONS)]
    Completions(manual::CompletionsArgs),
    /// Prints the page of the manual, or writes one for each command into a folder.
    #[command(after_help = examples::MAN)]
    Man(manual::ManArgs),
}

#[derive(Args)]
struct ConfigArgs {
    /// The configuration file; config/asphera.toml is the reference.
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

/// What is done with the figures.
#[derive(Args, Clone, Default)]
struct OutputArgs {
    /// Print the report as one JSON object on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
    /// Print all figures, not only the summary.
    #[arg(long)]
    details: bool,
    /// Write report.json, mesh.ply, deviation.ply and deviation.x3p into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite such files if they are there.
    #[arg(long)]
    force: bool,
}

/// A filter of log lines, as it was given.
fn filter(text: &str) -> Result<String, String> {
    let known = EnvFilter::try_new(text).map(|_| text.to_owned());
    known.map_err(|_| "expected a level, or MODULE=LEVEL with commas between".to_owned())
}

/// How fast simulated or recorded time passes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Speed {
    Times(f64),
    Max,
}

impl FromStr for Speed {
    type Err = String;

    fn from_str(word: &str) -> Result<Speed, String> {
        if word == "max" {
            return Ok(Speed::Max);
        }
        match word.parse::<f64>() {
            Ok(times) if times.is_finite() && times > 0.0 => Ok(Speed::Times(times)),
            _ => Err(format!("expected a number above 0 or `max`, found `{word}`")),
        }
    }
}

/// The command line. A negative number after an option is its value: its parser says what it expects instead.
fn command() -> clap::Command {
    Cli::command().mut_subcommands(|command| {
        command.mut_args(|arg| {
            let takes_number = arg.get_action().takes_values() && !arg.is_positional();
            arg.allow_negative_numbers(takes_number)
        })
    })
}

/// Says what is wrong with the command line, or what it asked to be said.
fn refused(error: &clap::Error) -> ExitCode {
    if error.kind() != clap::error::ErrorKind::ValueValidation {
        error.exit();
    }
    let text = match output::has_colours() {
        true => error.render().ansi().to_string(),
        false => error.render().to_string(),
    };
    output::say(in_plain_words(&text).trim_end());
    Exit::Misused.into()
}

/// An error of the parser without the words of its programming language.
fn in_plain_words(text: &str) -> String {
    let words = [
        ("invalid float literal", "expected a number"),
        ("cannot parse float from empty string", "expected a number, found nothing"),
        ("invalid digit found in string", "expected a whole number"),
        ("cannot parse integer from empty string", "expected a whole number, found nothing"),
        ("number too large to fit in target type", "expected a smaller number"),
    ];
    words.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// Reads the command line and does what it says.
pub fn main() -> ExitCode {
    let matches = command().try_get_matches();
    let cli = match matches.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) => return refused(&error),
    };
    tracing_subscriber::fmt()
        .with_writer(output::log_writer)
        .with_ansi(output::has_colours())
        .with_env_filter(EnvFilter::try_new(&cli.log).unwrap_or_else(|_| EnvFilter::new("warn")))
        .init();
    let done = match cli.command {
        Command::Demo(args) => demo::run(args),
        Command::Run(args) => run::run(&args),
        Command::Check(args) => check::run(&args.config),
        Command::Measure(args) => measure::run(&args),
        Command::Reduce(args) => reduce::run(&args),
        Command::Section(args) => section::run(&args),
        Command::Calibrate(args) => calibrate::run(&args),
        Command::Contour(args) => contour::run(&args),
        Command::Sample(args) => sample::run(&args),
        Command::Benchmark(args) => benchmark::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Sampling(args) => sampling::run(&args),
        Command::Plan(args) => plan::run(&args),
        Command::Graph(args) => graph::run(&args),
        Command::Parts(args) => parts::run(&args),
        Command::Volume(args) => volume::run(&args),
        Command::Reconstruct(args) => reconstruct::run(&args),
        Command::Nominal(args) => nominal::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Describe(args) => describe::run(&args),
        Command::Ports => ports::run(),
        Command::Completions(args) => manual::completions(&args, Cli::command()),
        Command::Man(args) => manual::pages(&args, Cli::command()),
    };
    match done.and_then(|exit| output::stdout_failure().map_or(Ok(exit), Err)) {
        Ok(exit) => exit.into(),
        Err(failure) => {
            output::complain(&failure);
            if usage::is_misuse(&failure) { Exit::Misused.into() } else { Exit::Failed.into() }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn filters_of_log_lines_are_levels_or_modules_with_levels() {
        for text in ["warn", "info,asphera_transport=trace", "off"] {
            assert_eq!(filter(text), Ok(text.to_owned()));
        }
        for text in ["asphera=loud", "info,a=b=c"] {
            assert!(filter(text).is_err(), "{text}");
        }
    }

    #[test]
    fn speeds_are_numbers_or_max() {
        assert_eq!("max".parse(), Ok(Speed::Max));
        assert_eq!("2.5".parse(), Ok(Speed::Times(2.5)));
        for word in ["0", "-1", "fast", "inf", "NaN", ""] {
            assert!(word.parse::<Speed>().is_err(), "{word}");
        }
    }
}
