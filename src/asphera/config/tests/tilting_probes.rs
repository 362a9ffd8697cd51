//! Stations with a probe that tilts about a pivot.

use super::*;

fn example() -> String {
    read(&project("examples/tilting-probe.toml")).unwrap()
}

#[test]
fn a_tilting_probe_needs_a_tilt_and_may_have_a_part_that_turns() {
    let text = example();
    let config = Config::parse("t.toml", &text).unwrap();
    let Kinematics::Tilting(tilting) = &config.kinematics else {
        panic!("{:?}", config.kinematics)
    };
    assert!(tilting.rotary.is_some() && tilting.y.source.is_none());
    assert_eq!((tilting.y.offset, tilting.pivot_offset_mm), (0.0, [0.0; 2]));
    assert_eq!(config.kinematics.axes().len(), 6);
    let line = |key: &str| text.lines().find(|line| line.starts_with(key)).unwrap();
    let fixed = text.replace(line("rotary = "), "y = { constant_mm = -2.5 }");
    let config = Config::parse("t.toml", &fixed).unwrap();
    let Kinematics::Tilting(tilting) = &config.kinematics else {
        panic!("{:?}", config.kinematics)
    };
    assert_eq!((tilting.rotary.is_none(), tilting.y.offset), (true, -2.5));
}

#[test]
fn mistakes_of_a_tilting_probe_are_named() {
    let text = example();
    let line = |key: &str| text.lines().find(|line| line.starts_with(key)).unwrap();
    for (from, to, keys) in [
        (line("tilt = "), "", &["kinematics.tilt"][..]),
        (line("probe = "), "", &["kinematics.probe"]),
        (line("x = "), "radial = { constant_mm = 0 }", &["kinematics.radial", "kinematics.x"]),
        ("pivot_offset_mm = [0, 0]", "pivot_offset_mm = [0]", &["kinematics.pivot_offset_mm"]),
        (
            "channel = \"encoder_u\", counts_per_turn",
            "channel = \"encoder_u\", mm_per_count",
            &["kinematics.tilt.counts_per_turn", "kinematics.tilt.mm_per_count"],
        ),
        ("encoder_u\"", "encoder_x\"", &["kinematics.kind"]),
        ("[scan]\n", "[scan.plan]\npath = \"raster\"\n[scan]\n", &["scan.plan.path"]),
    ] {
        assert!(text.contains(from), "{from}");
        let problems = Config::parse("t.toml", &text.replacen(from, to, 1)).unwrap_err();
        for key in keys {
            assert!(problems.0.iter().any(|problem| problem.key == *key), "{to}: {problems}");
        }
    }
}
