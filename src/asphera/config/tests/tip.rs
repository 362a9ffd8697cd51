//! Stations with a ball tip.

use super::*;

fn example() -> String {
    read(&project("examples/stylus.toml")).unwrap()
}

#[test]
fn a_ball_tip_has_a_radius() {
    let text = example();
    let tip = Config::parse("t.toml", &text).unwrap().tip.unwrap();
    assert_eq!(tip.centre_mm([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]), [1.0, 2.0, 3.5]);
    let centre = text.replace("[tip]\n", "[tip]\nreads = \"centre\"\n");
    let tip = Config::parse("t.toml", &centre).unwrap().tip.unwrap();
    assert_eq!(tip.centre_mm([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]), [1.0, 2.0, 3.0]);
}

#[test]
fn mistakes_of_a_ball_tip_are_named() {
    let text = example();
    let radius = "radius_mm = 0.5\n";
    for (found, expected) in [
        (
            text.replace(radius, "radius_mm = nan\n"),
            "tip.radius_mm: expected a finite number, found NaN",
        ),
        (text.replace(radius, "radius_mm = -0.5\n"), "0 to 50 mm"),
        (text.replace("u_radius_mm = 0.0001", "u_radius_mm = -1"), "u_radius_mm"),
        (text.replace("[tip]\n", "[tip]\nreads = \"top\"\n"), "lowest"),
        (format!("{text}\n[projection]\nalong = \"none\"\n"), "contacts of a ball need a plane"),
        (format!("{text}\n[projection]\nalong = [0, 0, -1]\n"), "a plane seen from below"),
    ] {
        let said = Config::parse("t.toml", &found).unwrap_err().to_string();
        assert!(said.contains("tip") && said.contains(expected), "{said}");
    }
}
