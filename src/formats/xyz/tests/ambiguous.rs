//! Heads that name places otherwise than by x, y, z, or state the unit of one column.

use super::*;

fn refused(text: &str) -> String {
    match read(text.as_bytes()) {
        Ok(topography) => panic!("{text:?} was read as {topography:?}"),
        Err(error) => error.to_string(),
    }
}

/// The angle was dropped in silence, and places all over a disc were a profile.
#[test]
fn places_by_radius_and_angle_are_no_profile() {
    for head in [
        "r_mm,theta_deg,z_mm",
        "r,phi,z",
        "r [mm];theta [rad];z [mm]",
        "radius,angle_deg,height_mm",
        "# r_mm theta_deg z_mm",
        "r φ z",
        "C_deg,r_mm,z_mm",
    ] {
        let error = refused(&format!("{head}\n1 20 3\n2 40 3\n"));
        assert!(error.contains("r·cos(angle)") && error.contains("--columns"), "{head}: {error}");
    }
    // What is no angle does not hinder a profile, and the user may take one at one angle.
    for (head, columns) in [("r_mm,quality,z_mm", vec![]), ("r_mm,theta_deg,z_mm", vec![1, 3])] {
        let columns = columns.into_iter().map(Column::Number).collect();
        let options = TextOptions { columns, ..TextOptions::default() };
        let text = format!("{head}\n1,20,3\n2,40,3\n");
        let found = read_with(text.as_bytes(), &options).unwrap();
        assert_eq!(found.points().collect::<Vec<_>>(), [[1.0, 0.0, 3.0], [2.0, 0.0, 3.0]]);
    }
}

/// A unit behind the last name of a table with marks was taken for that of all columns: places were a thousand times too large.
#[test]
fn a_unit_in_a_head_with_marks_is_of_its_own_column() {
    for head in ["x,y,z (m)", "x;y;z [um]", "x\ty\tz (nm)", "X,Y (um),Z"] {
        let error = refused(&format!("{head}\n1,2,3\n4,5,6\n"));
        assert!(error.contains("the unit of ") && error.contains("--unit"), "{head}: {error}");
    }
    // Of words alone it is that of all; of a comment too.
    for head in ["x y z (um)", "# x, y, z (um)"] {
        let found = read(format!("{head}\n1000 2000 3000\n4 5 6\n").as_bytes()).unwrap();
        assert_eq!(found.points().next(), Some([1.0, 2.0, 3.0]), "{head}");
    }
    let units = vec![Unit::Mm, Unit::Mm, Unit::M];
    let options = TextOptions { units, ..TextOptions::default() };
    let found = read_with(b"x,y,z (m)\n1,2,0.003\n4,5,6\n", &options).unwrap();
    assert_eq!(found.points().next(), Some([1.0, 2.0, 3.0]));
}

/// A line of text that begins like a number was taken for the first point, and nothing said how to go on.
#[test]
fn a_line_before_the_points_says_how_to_pass_over_it() {
    let text = "1360\n0 1 2\n3 4 5\n";
    assert!(refused(text).contains("`--skip-lines`"));
    let options = TextOptions { skip_lines: 1, ..TextOptions::default() };
    assert_eq!(read_with(text.as_bytes(), &options).unwrap().points().count(), 2);
}
