//! Command lines that work, for the end of each help text.

pub(super) const DEMO: &str = "Examples:
  asphera demo --exit --points 20000 --speed max --out results
  asphera demo --scene ct --out results
  asphera demo --scene tray --out results";

pub(super) const RUN: &str = "Examples:
  asphera run --config config/asphera.toml
  asphera run --config config/asphera.toml --once
  asphera run --config config/examples/closed-loop.toml --once --arm";

pub(super) const CHECK: &str = "Example:
  asphera check --config config/asphera.toml";

pub(super) const MEASURE: &str = "Examples:
  asphera measure session-20261121T004006Z-0badcafe --out results
  asphera measure part.csv --columns 2,3,4 --unit um --nominal sphere.toml --json
  asphera measure lens.nrrd --nominal front.toml --second back.toml --listen 127.0.0.1:7717";

pub(super) const REDUCE: &str = "Examples:
  asphera reduce part.xyz --epsilon 0.05 -o fewer.xyz
  asphera reduce part.xyz --epsilon 0.05 --average --nominal sphere.toml -o fewer.csv
  asphera reduce body.ply --along none --epsilon 0.1 -o fewer.xyz";

pub(super) const SECTION: &str = "Examples:
  asphera section part.xyz --line -5,0,5,0 -o section.csv
  asphera section part.xyz --radius 45 --nominal sphere.toml --json
  asphera section ball.xyz --along none --plane 0,0,1,2.5 --nominal sphere.toml -o section.csv";

pub(super) const CALIBRATE: &str = "Examples:
  asphera calibrate session-20261121T004006Z-0badcafe --sphere 10 --u-radius 30 -o calibration.toml
  asphera calibrate ball.xyz --machine cartesian --sphere 12.5 --parameters squareness,tilt_x,tilt_y -o calibration.toml
  asphera calibrate a.xyz b.xyz c.xyz --machine cartesian --sphere 10 --turn 0,90,180 --form 4 -o calibration.toml";

pub(super) const CONTOUR: &str = "Examples:
  asphera contour edge.xyz -o edge.svg
  asphera contour edge.csv --columns 1,2 --method peel --set delta=2.5 --json
  asphera contour edge.xyz --method auto --outline nominal.svg";

pub(super) const SAMPLE: &str = "Examples:
  asphera sample blade.svg --rho 0.9 -o blade.xy
  asphera sample blade.svg --epsilon 0.2 --noise 0.003 --outliers 5 --seed 7 -o blade.xy --truth blade.json
  asphera sample mask.png --pixel 0.01 -o edge.xy";

pub(super) const BENCHMARK: &str = "Examples:
  asphera benchmark curves
  asphera benchmark curves --category open --methods auto,hnn-crust,vicur --trials 50 --json
  asphera benchmark regions --category ring";

pub(super) const COMPARE: &str = "Examples:
  asphera compare found.json truth.json --json
  asphera compare --shapes a.ply b.ply c.xyz --scale-free
  asphera compare --evaluate shapes --method seed --function pca:1 --function pca:2";

pub(super) const GRAPH: &str = "Examples:
  asphera graph part.ply
  asphera graph part.xyz --function height:z --strips 50 --out results
  asphera graph part.stl --sample 50000 --function geodesic --json";

pub(super) const PARTS: &str = "Examples:
  asphera parts tray.xyz
  asphera parts tray.xyz --library nominals --measure --out results
  asphera parts tray.ply --tau 0.5 --out parts --json";

pub(super) const SAMPLING: &str = "Examples:
  asphera sampling part.xyz --epsilon 0.05
  asphera sampling part.xyz --nominal sphere.toml --waypoints next.csv";

pub(super) const PLAN: &str = "Examples:
  asphera plan sphere.toml --path raster --spacing 0.5 -o plan.csv
  asphera plan asphere.toml --path spiral --from-epsilon 0.05 --machine polar --axis r=-1,60,10,100 -o plan.csv
  asphera plan part.xyz --nominal sphere.toml --from 0,-20 --dwell 0.1 -o next.csv";

pub(super) const RECONSTRUCT: &str = "Examples:
  asphera reconstruct blade.ply -o blade-mesh.ply
  asphera reconstruct scan.xyz --unit um --method alpha --alpha 0.8 --json
  asphera reconstruct mount.ply --method robust-cocone -o mount.stl";

pub(super) const VOLUME: &str = "Examples:
  asphera volume part.nrrd --regular 0.5 --mesh part.ply
  asphera volume scan.mha --threshold iso50 --part largest --check --json
  asphera volume sphere.vol --spacing 0.02 --method balls --out results";

pub(super) const NOMINAL: &str = "Examples:
  asphera nominal sphere.toml --sag 0,2.5,5
  asphera nominal lens.zmx --surface 2 -o sphere.toml";

pub(super) const EXPORT: &str = "Examples:
  asphera export session-20261121T004006Z-0badcafe -o points.csv
  asphera export part.x3p -o part.ply";

pub(super) const REPLAY: &str = "Examples:
  asphera replay session-20261121T004006Z-0badcafe
  asphera replay session-20261121T004006Z-0badcafe --nominal sphere.toml --json";

pub(super) const REPORT: &str = "Examples:
  asphera report session-20261121T004006Z-0badcafe -o report.html
  asphera report part.xyz --nominal sphere.toml --part \"Lens 7\" -o report.html --qif report.xml";

pub(super) const SIMULATE: &str = "Examples:
  asphera simulate simulators/rig/scenes/asphere.toml
  asphera simulate station.toml --station try.toml
  asphera simulate --session session-20261121T004006Z-0badcafe --station again.toml";

pub(super) const DESCRIBE: &str = "Examples:
  asphera describe --serial /dev/ttyUSB0 --baud-bd 38400
  asphera describe --tcp 192.168.1.7:8500 --ask \"MAIN,1\\r\" --keep gauge.bin
  asphera describe gauge.bin";

pub(super) const PORTS: &str = "Example:
  asphera ports";

pub(super) const COMPLETIONS: &str = "Examples:
  asphera completions bash > /etc/bash_completion.d/asphera
  asphera completions fish > ~/.config/fish/completions/asphera.fish";

pub(super) const MAN: &str = "Examples:
  asphera man | man -l -
  asphera man /usr/local/share/man/man1";

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use clap::{CommandFactory as _, Parser as _};

    use crate::cli::Cli;

    /// Words as a shell parts them; what is redirected or piped is not the command's.
    fn words(line: &str) -> Vec<String> {
        let command = line.split(['|', '>']).next().unwrap_or_default();
        // Within quotes spaces part nothing.
        let pieces = command.split('"').enumerate();
        let parted = pieces.flat_map(|(index, piece)| match index % 2 {
            0 => piece.split_whitespace().map(str::to_owned).collect(),
            _ => vec![piece.to_owned()],
        });
        parted.collect()
    }

    #[test]
    fn every_command_has_an_example_that_its_own_parser_takes() {
        let mut cli = Cli::command();
        cli.build();
        let commands = cli.get_subcommands().filter(|command| command.get_name() != "help");
        let mut seen = 0;
        for command in commands {
            let name = command.get_name().to_owned();
            for help in [command.clone().render_help(), command.clone().render_long_help()] {
                assert!(help.to_string().contains("Example"), "{name}: {help}");
            }
            let after = command.get_after_help().unwrap().to_string();
            let lines: Vec<&str> = after.lines().skip(1).collect();
            assert!((1..=3).contains(&lines.len()), "{name}");
            for line in lines {
                let words = words(line);
                assert_eq!(words[..2], ["asphera", &name], "{line}");
                if let Err(error) = Cli::try_parse_from(&words) {
                    panic!("{line}\n{error}");
                }
            }
            seen += 1;
        }
        assert!(seen >= 15, "{seen}");
        assert!(cli.render_help().to_string().contains("Example"));
    }

    #[test]
    fn every_command_line_of_the_documents_is_taken_by_its_parser() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let pages = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
        let pages = pages.filter(|path| path.extension().is_some_and(|ending| ending == "md"));
        let mut seen = 0;
        for path in pages.chain([root.join("README.md"), root.join("systemd/README.md")]) {
            let text = fs::read_to_string(&path).unwrap();
            for line in text.lines().filter_map(|line| line.strip_prefix("    ")) {
                let line = line.trim_start_matches("$ ").trim_start_matches("target/release/");
                let line = line.split(" #").next().unwrap_or_default();
                if line.starts_with("asphera ") {
                    let taken = Cli::try_parse_from(words(line));
                    assert!(taken.is_ok(), "{}: {line}", path.display());
                    seen += 1;
                }
            }
        }
        assert!(seen >= 20, "{seen}");
    }
}
