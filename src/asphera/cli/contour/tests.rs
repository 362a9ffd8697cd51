//! Contours of small files, through the command line's own parser.

use clap::Parser as _;

use super::super::{Cli, Command};
use super::summary::summary as summary_of;
use super::*;

pub(in crate::cli) fn arguments(words: &[&str]) -> ContourArgs {
    let words = ["asphera", "contour"].iter().chain(words);
    match Cli::try_parse_from(words).map(|cli| cli.command) {
        Ok(Command::Contour(args)) => args,
        Ok(_) => panic!("another command"),
        Err(error) => panic!("{error}"),
    }
}

/// A circle of 24 points and, apart from it, an arc of four.
fn points() -> String {
    let circle = (0..24).map(|index| (f64::from(index) * 0.261_799_387_799_149_4).sin_cos());
    let circle = circle.map(|(sin, cos)| format!("{} {}\n", 5.0 * cos, 5.0 * sin));
    let arc = [[20.0, 0.0], [21.0, 0.2], [22.0, 0.25], [23.0, 0.2]];
    circle.chain(arc.map(|[x, y]| format!("{x} {y}\n"))).collect()
}

fn contour_of(text: &str, words: &[&str]) -> Result<ContourReport, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("edge.xyz");
    std::fs::write(&path, text).unwrap();
    let name = path.display().to_string();
    let args = arguments(&[&[name.as_str()], words].concat());
    found(&args, &path).map_err(|failure| failure.to_string().replace(&name, "edge.xyz"))
}

#[test]
fn two_columns_and_three_give_the_same_curve() {
    let report = contour_of(&points(), &[]).unwrap();
    assert_eq!((report.input.points, report.input.distinct), (28, 28));
    let circle_then_arc: Vec<(bool, usize)> =
        report.chains.iter().map(|chain| (chain.closed, chain.points_mm.len())).collect();
    assert_eq!(circle_then_arc, [(false, 4), (true, 24)]);
    assert_eq!(
        (report.ends.clone(), report.junctions.len(), report.left_out.len()),
        (vec![24, 27], 0, 0)
    );
    assert!((report.chains[1].length_mm - 240.0 * 0.130_526_192_220_051_6).abs() < 1e-9);
    let three = points().replace('\n', " 7.5\n");
    assert_eq!(contour_of(&three, &[]).unwrap(), report);
    let named = format!("# x y z in mm\n{three}");
    assert_eq!(contour_of(&named, &[]).unwrap(), report);
    let csv = format!("x,y\n{}", points().replace(' ', ","));
    assert_eq!(contour_of(&csv, &[]).unwrap(), report);
    let in_micrometres = contour_of(&csv, &["--unit", "um"]).unwrap();
    let length_mm = in_micrometres.chains[1].length_mm;
    assert!((1e3 * length_mm / report.chains[1].length_mm - 1.0).abs() < 1e-12, "{length_mm}");
    let summary = summary_of(&report);
    assert!(summary.contains("curves     1 closed, 1 open"), "{summary}");
    assert!(summary.contains("unjoined   2 ends, 0 junctions, 0 points left out"), "{summary}");
}

#[test]
fn a_curve_says_whether_its_points_suffice() {
    let circle: String = points().lines().take(24).map(|line| format!("{line}\n")).collect();
    let report = contour_of(&circle, &[]).unwrap();
    let sampling = report.sampling.as_ref().unwrap();
    assert_eq!((sampling.condition.as_deref(), sampling.holds), (Some("ρ < 0.9"), Some(true)));
    // Twice the sine of a quarter of the angle between two points.
    assert!((sampling.epsilon.unwrap() - 2.0 * 3.75_f64.to_radians().sin()).abs() < 1e-9);
    assert!((sampling.lfs_least_mm.unwrap() - 5.0).abs() < 0.1);
    let summary = summary_of(&report);
    assert!(
        summary.contains("sampling   ε 0.1308, ρ 0.1311, u 1.000: ρ < 0.9 holds, closest at"),
        "{summary}"
    );
    // With an arc beside it that ends: what is proven is proven of closed curves.
    let open = contour_of(&points(), &[]).unwrap();
    let sampling = open.sampling.as_ref().unwrap();
    assert_eq!((sampling.holds, sampling.failing), (Some(false), 0));
    assert!(summary_of(&open).contains("this one has ends"), "{}", summary_of(&open));
    let square = "0 0\n1 0\n2 0\n3 0\n3 1\n3 2\n3 3\n2 3\n1 3\n0 3\n0 2\n0 1\n";
    let report = contour_of(square, &[]).unwrap();
    let sampling = report.sampling.as_ref().unwrap();
    assert_eq!((sampling.holds, sampling.failing, sampling.failures.len()), (Some(false), 8, 8));
    assert!(
        summary_of(&report).contains("ρ < 0.9 fails at 8 places, most at"),
        "{}",
        summary_of(&report)
    );
    // No condition is known of it; of an area and a graph there is no curve.
    let crawl = contour_of(square, &["--method", "crawl"]).unwrap();
    assert_eq!(crawl.sampling.as_ref().map(|it| (it.holds, it.rho.is_some())), Some((None, true)));
    assert!(contour_of(square, &["--method", "alpha"]).unwrap().sampling.is_none());
    assert!(contour_of(square, &["--graph", "rng"]).unwrap().sampling.is_none());
}

#[test]
fn methods_graphs_and_parameters() {
    let report = contour_of(&points(), &["--method", "peel", "--set", "delta=1.5"]).unwrap();
    assert_eq!(report.parameters.get("delta"), Some(&1.5));
    let report = contour_of(&points(), &["--graph", "emst"]).unwrap();
    assert_eq!((report.edges.len(), report.chains.len()), (27, 0));
    let refused = |words: &[&str]| contour_of(&points(), words).unwrap_err();
    assert!(refused(&["--method", "emst"]).starts_with("--method emst: expected one of crust"));
    assert!(refused(&["--method", "emst"]).ends_with("give --graph emst"));
    assert!(refused(&["--method", "x"]).starts_with("no method is called `x`: expected one of"));
    assert_eq!(
        refused(&["--set", "rho=1"]),
        "hnn-crust has no parameter `rho`: expected one_sided"
    );
    let listed = listed();
    assert!(Method::ALL.iter().all(|method| listed.contains(&format!("  {}\n", method.name()))));
    assert!(listed.contains("guarantee  smooth closed curves, ε < 1/3"));
}

/// Two circles about the origin, of 3 and 5 mm, with a gap of five points each.
fn broken_ring() -> String {
    let circle = |radius: f64, count: u32| {
        (0..count - 5).map(move |index| {
            let turn = (f64::from(index) + 0.5) / f64::from(count) * std::f64::consts::TAU;
            format!("{} {}\n", radius * turn.cos(), radius * turn.sin())
        })
    };
    circle(3.0, 200).chain(circle(5.0, 300)).collect()
}

#[test]
fn hints_name_regions_and_close_gaps() {
    let hints = ["--method", "delaunay-painting", "--hints", "0.01,0.02=hole; -4,0.01=ring"];
    let report = contour_of(&broken_ring(), &hints).unwrap();
    let regions = report.regions.as_ref().unwrap();
    let of = |label: &str| regions.iter().find(|it| it.label.as_deref() == Some(label)).unwrap();
    assert_eq!((regions.len(), of("ring").holes_mm.len(), of("hole").holes_mm.len()), (2, 1, 0));
    assert!((of("hole").area_mm2 + of("ring").area_mm2 - 25.0 * std::f64::consts::PI).abs() < 0.1);
    assert_eq!((report.gaps.len(), report.gaps[0].kind.as_str()), (2, "straight"));
    assert!(report.chains.len() == 2 && report.chains.iter().all(|chain| chain.closed));
    assert_eq!(report.beziers_mm.len(), 2);
    let summary = summary_of(&report);
    assert!(summary.contains("region     ring: 50."), "{summary}");
    assert!(summary.contains("gap        straight, "), "{summary}");
    // Without hints, and where they do not belong.
    let refused = |words: &[&str]| contour_of(&broken_ring(), words).unwrap_err();
    assert_eq!(
        refused(&["--method", "colour-by-numbers"]),
        "expected hints, found none; name a place within each region, as 1.5,2=hole;8,2=plate"
    );
    assert_eq!(
        refused(&["--method", "alpha", "--hints", "0,0=a"]),
        "--hints: expected --method delaunay-painting or colour-by-numbers beside it, found alpha"
    );
    assert!(refused(&["--method", "colour-by-numbers", "--hints", "0,0"]).starts_with("hint 1: "));
    // Growing finds the same two regions by itself.
    let growing = ["--method", "triangle-growing", "--set", "gap_mm=0.7"];
    let grown = contour_of(&broken_ring(), &growing).unwrap();
    // At the outer gap a thin triangle lies within the stroke, so no side there is one between two regions.
    assert_eq!((grown.parts, grown.gaps.len(), grown.holes), (Some(2), 1, Some(1)));
}

/// A square of 9 by 9 points, 1 mm apart, without those nearer than 2.1 mm to its middle.
fn plate() -> String {
    let raster = (0..81).map(|index| [f64::from(index % 9) - 4.0, f64::from(index / 9) - 4.0]);
    raster.filter(|[x, y]| x.hypot(*y) > 2.1).map(|[x, y]| format!("{x} {y}\n")).collect()
}

#[test]
fn regions_have_parts_holes_and_areas() {
    let report = contour_of(&plate(), &["--method", "alpha", "--set", "alpha_mm=0.8"]).unwrap();
    assert_eq!((report.parts, report.holes), (Some(1), Some(1)));
    let regions = report.regions.as_ref().unwrap();
    assert_eq!((regions[0].outline_mm.len(), regions[0].holes_mm.len()), (32, 1));
    let hole: f64 = report.chains[1].length_mm;
    assert_eq!((report.chains.len(), report.chains[0].length_mm), (2, 32.0));
    assert!((regions[0].perimeter_mm - 32.0 - hole).abs() < 1e-12);
    assert_eq!(report.area_mm2, Some(regions[0].area_mm2));
    assert!(report.left_out.is_empty() && report.ends.is_empty() && report.junctions.is_empty());
    let summary = summary_of(&report);
    assert!(summary.contains("mm², 1 parts, 1 holes"), "{summary}");
    let svg = drawing_text("a.svg", &report);
    assert_eq!((svg.matches("<path d=").count(), svg.matches("evenodd").count()), (2, 1));
    assert_eq!(
        drawing_text("a.csv", &report).lines().count(),
        1 + 32 + regions[0].holes_mm[0].len()
    );
    // The keys of regions are there for regions only.
    let json = serde_json::to_value(&report).unwrap();
    let keys = ["area_mm2", "parts", "holes", "regions"];
    assert!(keys.iter().all(|key| json.get(key).is_some()));
    assert!(json["regions"][0]["outline_mm"][0].is_array());
    let curve = serde_json::to_value(contour_of(&points(), &[]).unwrap()).unwrap();
    assert!(keys.iter().all(|key| curve.get(key).is_none()));
    // What was chosen is shown, and gives the same again.
    let chosen = contour_of(&plate(), &["--method", "alpha"]).unwrap();
    let alpha = chosen.parameters["alpha_mm"];
    let again = contour_of(&plate(), &["--method", "alpha", "--set", &format!("alpha_mm={alpha}")]);
    assert_eq!(again.unwrap(), chosen);
    assert!(alpha > 0.5);
}

#[test]
fn the_points_choose_a_method_and_say_why() {
    let circle = |noise: f64| -> String {
        let at = |index: u32| {
            let (sin, cos) = (f64::from(index) * 0.010_471_975_511_965_978).sin_cos();
            // No random numbers: far from periodic along the circle.
            let radius = 5.0 + noise * (f64::from(index * index) * 1.7).sin();
            format!("{} {}\n", radius * cos, radius * sin)
        };
        (0..600).map(at).collect()
    };
    let clean = contour_of(&format!("{}9 9\n", circle(0.0)), &["--method", "auto"]).unwrap();
    assert_eq!((clean.method.as_str(), clean.input.kind.as_deref()), ("hnn-crust", Some("border")));
    assert_eq!((clean.input.outliers, clean.input.noise_sigma_mm), (Some(1), None));
    assert!(clean.reason.as_ref().unwrap().contains("1 outliers left out; no noise"));
    let noisy = contour_of(&circle(0.2), &["--method", "auto"]).unwrap();
    assert_eq!(noisy.method, "lee");
    // The standard deviation of a sine is 0.707 of its height.
    assert!((noisy.input.noise_sigma_mm.unwrap() - 0.141).abs() < 0.03, "{}", summary_of(&noisy));
    assert!((noisy.chains[0].length_mm - 31.4).abs() < 0.3 && noisy.chains[0].closed);
    assert!(summary_of(&noisy).contains("chosen     border: "), "{}", summary_of(&noisy));
    let named = contour_of(&circle(0.2), &["--method", "lee"]).unwrap();
    assert_eq!((named.chains[0].closed, named.reason), (true, None));
    let raster: String = (0..900).map(|it| format!("{} {}\n", it % 30, it / 30)).collect();
    let area = contour_of(&raster, &["--method", "auto"]).unwrap();
    assert_eq!((area.method.as_str(), area.parts), ("auto", Some(1)));
    assert!(area.reason.unwrap().starts_with("area: "));
}

#[test]
fn circles_and_deviations_are_told() {
    let circle: String = (0..360)
        .map(|index| {
            let (sin, cos) = f64::from(index).to_radians().sin_cos();
            let radius = 5.0 + if index % 2 == 0 { 0.001 } else { -0.001 };
            format!("{} {}\n", 2.0 + radius * cos, radius * sin)
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nominal.svg");
    std::fs::write(&path, "<svg><circle cx='2' r='4.9'/></svg>").unwrap();
    let name = path.display().to_string();
    let report = contour_of(&circle, &["--outline", &name]).unwrap();
    let found = report.circle.as_ref().unwrap();
    assert!((found.diameter_mm - 10.0).abs() < 1e-9 && (found.roundness_mm - 0.002).abs() < 1e-9);
    assert!((found.roundness_zone_mm.unwrap() - 0.002).abs() < 1e-9);
    let deviation = report.deviation.as_ref().unwrap();
    assert!(
        (deviation.largest_mm - 0.101).abs() < 1e-7 && (deviation.least_mm - 0.099).abs() < 1e-7
    );
    assert_eq!((deviation.points, deviation.deviations_mm.len()), (360, 360));
    let summary = summary_of(&report);
    assert!(summary.contains("circle     diameter 10.000000 mm, u "), "{summary}");
    assert!(summary.contains("mm, RMS 0.1000 mm, from"), "{summary}");
    // A square is no circle; its corners as text are an outline.
    let square = "0 0\n1 0\n2 0\n3 0\n3 1\n3 2\n3 3\n2 3\n1 3\n0 3\n0 2\n0 1\n";
    let path = folder.path().join("nominal.xyz");
    std::fs::write(&path, "0 0\n3 0\n3 3\n0 3\n").unwrap();
    let report = contour_of(square, &["--outline", &path.display().to_string()]).unwrap();
    assert!(report.circle.is_none());
    let deviation = report.deviation.unwrap();
    assert!(deviation.largest_mm < 1e-14 && deviation.least_mm > -1e-14);
    assert!(deviation.u_mm.is_none());
    let wrong = folder.path().join("wrong.svg");
    std::fs::write(&wrong, "<svg/>").unwrap();
    let refused = contour_of(square, &["--outline", &wrong.display().to_string()]).unwrap_err();
    assert!(refused.ends_with("expected an outline, found no line"), "{refused}");
}

/// Three sides of a square as the outline of a square: its fourth side lies in front of the others' ends, or beyond them.
#[test]
fn points_beyond_the_ends_of_the_outline_are_counted() {
    let sides = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let square: String = (0..40)
        .map(|index| {
            let (p, q) = (sides[index / 10], sides[(index / 10 + 1) % 4]);
            let at = |axis: usize| p[axis] + 0.1 * (index % 10) as f64 * (q[axis] - p[axis]);
            format!("{} {}\n", 1.002 * at(0) - 0.001, 1.002 * at(1) - 0.001)
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nominal.svg");
    let report_of = |data: &str| {
        std::fs::write(&path, format!("<svg><path d='{data}'/></svg>")).unwrap();
        contour_of(&square, &["--outline", &path.display().to_string()]).unwrap()
    };
    let report = report_of("M0 0L1 0L1 -1L0 -1");
    let deviation = report.deviation.as_ref().unwrap();
    assert_eq!((deviation.points, deviation.beyond_ends), (29, 11));
    assert_eq!(deviation.deviations_mm.len(), 29);
    let mean_mm = deviation.deviations_mm.iter().map(|it| it[2]).sum::<f64>() / 29.0;
    assert!((deviation.mean_mm - mean_mm).abs() < 1e-12);
    let said = "deviation: 11 of 40 points lie beyond the ends of an open line of the outline, as at -0.0010, ";
    assert!(report.unknown.iter().any(|unknown| unknown.starts_with(said)), "{:?}", report.unknown);
    let report = report_of("M5 0L6 0");
    assert!(report.deviation.is_none());
    assert!(report.unknown.iter().any(|unknown| unknown.contains("40 of 40 points")));
}

/// The corners of a rectangle lie on a circle exactly, and say nothing of how well it is known.
#[test]
fn few_points_near_a_circle_get_none_and_the_reason() {
    let square = |parts: u32| -> String {
        let step = 10.0 / f64::from(parts);
        let side = |[x, y]: [f64; 2], [dx, dy]: [f64; 2]| {
            let along = (0..parts).map(move |part| step * f64::from(part));
            along.map(move |along| format!("{} {}\n", x + dx * along, y + dy * along))
        };
        let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let ways = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        corners.into_iter().zip(ways).flat_map(|(corner, way)| side(corner, way)).collect()
    };
    for parts in [1, 2, 10] {
        let report = contour_of(&square(parts), &[]).unwrap();
        assert!(report.circle.is_none(), "{report:?}");
        let said = report.unknown.iter().any(|why| {
            why.starts_with("circle: 4 points lie near one, too few to tell their noise")
        });
        assert_eq!(said, parts == 1, "{:?}", report.unknown);
    }
}

/// A closed circle goes all round, in whichever line it is told.
#[test]
fn the_circle_and_the_arc_of_a_closed_curve_span_the_same() {
    let circle = (0..200).map(|index| (f64::from(index) * std::f64::consts::TAU / 200.0).sin_cos());
    let circle: String = circle.map(|(sin, cos)| format!("{cos} {sin}\n")).collect();
    let summary = summary_of(&contour_of(&circle, &[]).unwrap());
    assert!(summary.contains(" mm, over 360°\n"), "{summary}");
    assert!(summary.contains("over 360.0 deg"), "{summary}");
}

#[test]
fn points_that_no_curve_can_be_found_of_are_refused() {
    assert_eq!(
        contour_of("1 2\n1 2\n3 4\n", &[]).unwrap_err(),
        "edge.xyz: expected three different places or more, found 2 in 3 points; measure more of the curve"
    );
    let line = contour_of("0 0\n1 1\n2 2\n5 5\n", &[]).unwrap_err();
    assert!(
        line.starts_with(
            "edge.xyz: expected points round a curve, found all 4 on one straight line"
        )
    );
    assert!(contour_of("a b\nc d\n", &[]).is_err());
    let four = contour_of("1 2 3 4\n5 6 7 8\n", &[]).unwrap_err();
    assert!(four.contains("--columns"), "{four}");
}

#[test]
fn files_hold_the_chains() {
    let report = contour_of("0 0\n2 0\n2 1\n0 1\n", &["--method", "connect2d"]).unwrap();
    let text = |name: &str| drawing_text(name, &report);
    assert_eq!(text("a.csv"), "chain,closed,x[mm],y[mm]\n0,1,0,0\n0,1,0,1\n0,1,2,1\n0,1,2,0\n");
    assert!(text("a.svg").contains("<path d=\"M 0 0 L 0 -1 L 2 -1 L 2 0 Z\"/>"));
    let dxf = text("a.DXF");
    assert_eq!(dxf.matches("0\nVERTEX\n").count(), 4);
    assert!(
        dxf.contains("66\n1\n10\n0.0\n20\n0.0\n30\n0.0\n70\n1\n")
            && dxf.ends_with("0\nENDSEC\n0\nEOF\n")
    );
    assert!(draw::drawing_of(Path::new("a.txt")).is_err());
}

/// A circle of 5 mm without the arcs from 150° to 170° and from 344° to 360°.
#[test]
fn gaps_are_closed_on_request_and_listed_in_every_drawing() {
    let kept = (0..150).chain(170..345).step_by(2).map(f64::from).map(f64::to_radians);
    let text: String =
        kept.map(|angle| format!("{} {}\n", 5.0 * angle.cos(), 5.0 * angle.sin())).collect();
    let open = contour_of(&text, &["--method", "vicur"]).unwrap();
    assert_eq!((open.gaps.len(), open.ends.len()), (0, 4));
    let closed = contour_of(&text, &["--method", "vicur", "--gaps", "2"]).unwrap();
    let [first, second] = &closed.gaps[..] else { panic!("{:?}", closed.gaps) };
    assert!(first.width_mm < second.width_mm && second.width_mm < 2.0);
    for gap in &closed.gaps {
        let off = gap.points_mm.iter().map(|[x, y]| (x.hypot(*y) - 5.0).abs());
        assert!(gap.kind == "smooth" && off.fold(0.0, f64::max) < 5e-3, "{gap:?}");
        assert!(gap.ends.iter().all(|end| closed.ends.contains(end)));
    }
    // No figure is with them.
    assert_eq!((&closed.chains, &closed.ends), (&open.chains, &open.ends));
    for (name, mark) in [("a.csv", "gap1,0,"), ("a.svg", "stroke-dasharray"), ("a.dxf", "GAPS")] {
        assert!(drawing_text(name, &closed).contains(mark), "{name}");
        assert!(!drawing_text(name, &open).contains(mark), "{name}");
    }
    let region = contour_of(&text, &["--method", "chi", "--gaps", "2"]).unwrap();
    let why = "gaps: expected a method of curves, found chi, which makes a region";
    assert!(region.gaps.is_empty() && region.unknown.iter().any(|word| word == why));
    assert!(contour_of(&text, &["--gaps", "0"]).unwrap_err().contains("expected more than 0 mm"));
}

fn drawing_text(name: &str, report: &ContourReport) -> String {
    draw::drawing_of(Path::new(name)).unwrap()(report)
}

/// A plate of 40 x 24 mm with a chamfer of 3 mm, points 0.1 mm apart.
fn plate_with_chamfer() -> String {
    let corners: [PlaceMm; 6] =
        [[0.0, 0.0], [40.0, 0.0], [40.0, 21.0], [37.0, 24.0], [0.0, 24.0], [0.0, 0.0]];
    let mut text = String::new();
    for side in corners.windows(2) {
        let [way_x, way_y] = [side[1][0] - side[0][0], side[1][1] - side[0][1]];
        let count = (way_x.hypot(way_y) / 0.1) as u32;
        for index in 0..count {
            let share = f64::from(index) / f64::from(count);
            // No random numbers: far from periodic.
            let off = 1e-3 * (f64::from(index * index) * 1.7).sin();
            let [x, y] = [side[0][0] + share * way_x, side[0][1] + share * way_y];
            text += &format!("{} {}\n", x - off, y + off);
        }
    }
    text
}

#[test]
fn features_are_told_with_their_uncertainty() {
    let report = contour_of(&plate_with_chamfer(), &[]).unwrap();
    let json = serde_json::to_value(&report).unwrap();
    let features = json["features"].as_array().unwrap();
    let of = |kind: &str| features.iter().filter(|it| it["kind"] == kind).collect::<Vec<_>>();
    assert_eq!((of("line").len(), of("corner").len(), of("chamfer").len()), (5, 5, 1), "{json:#}");
    let chamfer = of("chamfer")[0];
    let value = |key: &str| chamfer[key].as_f64().unwrap();
    assert!((value("width_mm") - 18.0_f64.sqrt()).abs() < 4.0 * value("u_width_mm") + 1e-3);
    assert!(value("u_width_mm") > 1e-5 && value("u_width_mm") < 1e-2);
    let area = of("enclosed")[0]["area_mm2"].as_f64().unwrap();
    assert!((area - 955.5).abs() < 0.01, "{area}");
    let summary = summary_of(&report);
    assert!(summary.contains("chamfer    38.50, 22.50 mm: width 4.24"), "{summary}");
    assert!(summary.contains("mm², u "), "{summary}");
    // What was written is read again; older files have no features.
    let text = serde_json::to_string(&report).unwrap();
    let again: ContourReport = serde_json::from_str(&text).unwrap();
    assert_eq!((again.features.len(), summary_of(&again)), (report.features.len(), summary));
    // An airfoil it is not, and a graph and a region have no features.
    let foil = contour_of(&plate_with_chamfer(), &["--airfoil"]).unwrap();
    assert!(foil.unknown.iter().any(|why| why.starts_with("airfoil: ")), "{:?}", foil.unknown);
    let graph = contour_of(&plate_with_chamfer(), &["--graph", "emst"]).unwrap();
    assert!(graph.features.is_empty());
    let region = contour_of(&plate(), &["--method", "alpha", "--airfoil"]).unwrap();
    assert!(region.features.is_empty());
    assert!(region.unknown.iter().any(|why| why.contains("give a method of curves")));
    let refused = contour_of(&points(), &["--tolerance=-1"]).unwrap_err();
    assert_eq!(refused, "--tolerance -1: expected 0 mm or more");
}

#[test]
fn a_slab_of_a_body_is_its_section() {
    // Rings of a cone of 45° about z, 0.5 mm apart, and its section at z = 2 mm: a circle of 3 mm about 1, -2 mm.
    let cone: String = (0..20)
        .flat_map(|ring| (0..90).map(move |step| (0.5 * f64::from(ring), f64::from(4 * step))))
        .map(|(z, angle)| {
            let (sin, cos) = angle.to_radians().sin_cos();
            format!("{} {} {z}\n", 1.0 + (5.0 - z) * cos, -2.0 + (5.0 - z) * sin)
        })
        .collect();
    let cut = contour_of(&cone, &["--plane", "0,0,2,4", "--within", "0.2"]).unwrap();
    let circle = cut.circle.as_ref().unwrap();
    assert_eq!((cut.input.points, cut.chains.len(), cut.chains[0].closed), (90, 1, true));
    assert!((circle.diameter_mm - 6.0).abs() < 1e-9 && (circle.centre_mm[0] - 1.0).abs() < 1e-9);
    // A plane along the axis cuts both sides of it; its first coordinate lies along x.
    let along = contour_of(&cone, &["--plane=0,-1,0,2", "--within", "0.01"]).unwrap();
    assert_eq!(along.input.distinct, 2 * 20 - 1);
    let none = contour_of(&cone, &["--plane", "0,0,1,2.25", "--within", "0.2"]).unwrap_err();
    assert_eq!(
        none,
        "edge.xyz: expected points within 0.2 mm of the plane, found the nearest 0.2500 mm off; give another --plane or a larger --within"
    );
    let wrong = contour_of(&cone, &["--plane", "0,0,1,2", "--within", "0"]).unwrap_err();
    assert_eq!(wrong, "--within 0: expected more than 0 mm");
    for word in ["0,0,0,1", "1,2,3", "a,b,c,d", "0,0,inf,1"] {
        assert!(word.parse::<Cutting>().unwrap_err().contains("as 0,0,1,5; found"), "{word}");
    }
}

#[test]
fn a_list_of_thousands_is_cut_in_the_summary_alone() {
    let mut report = contour_of(&points(), &[]).unwrap();
    report.unknown = (0..250).map(|index| format!("curve {index}")).collect();
    let summary = summary_of(&report);
    assert_eq!(summary.lines().filter(|line| line.starts_with("unknown    curve")).count(), 100);
    assert!(summary.ends_with("unknown    150 more; --json lists all\n"), "{summary}");
}

#[test]
fn faults_of_a_file_in_the_plane_are_told_at_their_place() {
    let of = |text: &str, words: &[&str]| contour_of(text, words).unwrap_err();
    let short = of("x,y\n1,2\n3,4\n5\n6,7\n", &[]);
    assert!(short.contains("line 4: expected 2 columns as in line 2, found 1"), "{short}");
    let word = of("x,y\n1,2\n3,abc\n5,1\n", &[]);
    assert!(word.contains("line 3, column 2: expected y in mm"), "{word}");
    let unit = of("x [mm],y [mm]\n1,2\n3,4\n5,1\n", &["--unit", "um"]);
    assert!(unit.contains("the file says that x is in mm, and `--unit` says um"), "{unit}");
    let bare = of("1 2\n3 4\n5 x\n", &[]);
    assert!(bare.contains("line 3, column 2: expected y in mm"), "{bare}");
}

/// A pipe can be read but once.
#[cfg(unix)]
#[test]
fn points_in_the_plane_come_through_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    for text in [points(), format!("x,y\n{}", points().replace(' ', ","))] {
        let pipe = folder.path().join(if text.contains(',') { "a.csv" } else { "a.xy" });
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let writer = {
            let pipe = pipe.clone();
            std::thread::spawn(move || std::fs::write(pipe, text).unwrap())
        };
        let args = arguments(&["--method", "hnn-crust", pipe.to_str().unwrap()]);
        let found = found(&args, &pipe).unwrap();
        writer.join().unwrap();
        assert!(!found.edges.is_empty());
    }
}

#[test]
fn a_nominal_drawing_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let [file, nominal] = ["a.xy", "c.svg"].map(|name| folder.path().join(name));
    std::fs::write(&file, points()).unwrap();
    std::fs::write(&nominal, "<svg><circle r='5'/></svg>").unwrap();
    let [file, out] = [&file, &nominal].map(|path| path.to_str().unwrap());
    let args = arguments(&[file, "--outline", out, "-o", out, "--force"]);
    let error = run(&args).unwrap_err().to_string();
    assert!(error.ends_with("c.svg is the file that is read; expected another"), "{error}");
    assert!(std::fs::read_to_string(&nominal).unwrap().contains("circle"));
}
