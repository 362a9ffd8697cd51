//! Tests of heads: names, units, comments, options, and what cannot be told.

use super::*;
use crate::HeightMap;

fn options(columns: &str, units: &[Unit]) -> TextOptions {
    let columns = columns
        .split(',')
        .filter(|word| !word.is_empty())
        .map(|word| word.parse().map_or_else(|_| Column::Name(word.to_owned()), Column::Number));
    TextOptions { columns: columns.collect(), units: units.to_vec(), ..TextOptions::default() }
}

fn points_with(text: &str, options: &TextOptions) -> Vec<[f64; 3]> {
    match read_with(text.as_bytes(), options) {
        Ok(topography) => topography.points().collect(),
        Err(error) => panic!("{text:?}: {error}"),
    }
}

fn refused(text: &str, options: &TextOptions) -> String {
    match read_with(text.as_bytes(), options) {
        Ok(topography) => panic!("{text:?} was read as {topography:?}"),
        Err(error) => error.to_string(),
    }
}

/// Three points, all of whose coordinates are 1000 times those in mm.
const MICROMETRES: &str = "1500 2250 0.1\n-3 0.5 1234.5\n7 8 9\n";

fn in_mm() -> Vec<[f64; 3]> {
    vec![[1.5, 2.25, 0.0001], [-0.003, 0.0005, 1.2345], [0.007, 0.008, 0.009]]
}

#[test]
fn heads_say_units() {
    for head in [
        "x_um y_um z_um",
        "x_um,y_um,z_um",
        "X [µm];Y [μm];Z [um]",
        "x(um)\ty(um)\tz(um)",
        "x/um y/um z/um",
        "\"x [um]\" \"y [um]\" \"z [um]\"",
        "# x_um y_um z_um",
        "# x y z in micrometres",
        "% X, Y, Z [um]",
        "// columns: x y z\n// units: um",
        "# unit of length = micron",
        "Serial 4711\nx y z\num um um",
        "x y z\n[um] [um] [um]",
        "# x, y in um, z in um",
    ] {
        let text = format!("{head}\n{MICROMETRES}");
        assert_eq!(points_with(&text, &TextOptions::default()), in_mm(), "{head}");
        let Ok(Topography::Cloud(_, source)) = read(text.as_bytes()) else { panic!("{head}") };
        assert_eq!(source.taken.unwrap().units_by, By::Head, "{head}");
    }
    // The same in Latin-1, where µ is one byte that is no UTF-8.
    let latin: Vec<u8> =
        format!("x [\u{b5}m],y [\u{b5}m],z [\u{b5}m]\n{}", MICROMETRES.replace(' ', ","))
            .chars()
            .map(|letter| letter as u8)
            .collect();
    assert_eq!(read(&latin).unwrap().points().collect::<Vec<_>>(), in_mm());
}

/// Labview and Origin write names, then units: a time or a quality among them hid the unit of z.
#[test]
fn a_line_of_units_may_hold_others_than_lengths() {
    for head in [
        "Time\tX\tY\tZ\tQuality\ns\tmm\tmm\tµm\t%",
        "Time\tX\tY\tZ\tQuality\ns\tmm\tmm\tµm\t",
        "Time\tX\tY\tZ\tN\n[s]\t[mm]\t[mm]\t[µm]\t[-]",
        "t X Y Z Q\ns mm mm um counts",
        "\tX\tY\tZ\t\n\tmm\tmm\tum\t",
    ] {
        let text = format!("{head}\n0.0\t1\t2\t3\t99\n0.1\t4\t5\t6\t99\n");
        let points = [[1.0, 2.0, 0.003], [4.0, 5.0, 0.006]];
        assert_eq!(points_with(&text, &TextOptions::default()), points, "{head}");
    }
    let text = "x,y,z\nmm,mm,V\n1,2,3\n";
    let error = refused(text, &TextOptions::default());
    assert!(error.contains("\"V\" of column 3 is no unit known here"), "{error}");
}

/// A comma at the end of each line was called a decimal one.
#[test]
fn a_comma_at_the_end_of_each_line_makes_no_column() {
    for head in ["X,Y,Z", "X,Y,Z,", "x,y,z,q"] {
        let text = format!("{head}\n-2.1,-8.7,0.8,\n1,2,3,\n");
        let points = [[-2.1, -8.7, 0.8], [1.0, 2.0, 3.0]];
        if head == "x,y,z,q" {
            let error = refused(&text, &TextOptions::default());
            assert!(error.contains("lines of 3 columns do not fit"), "{error}");
        } else {
            assert_eq!(points_with(&text, &TextOptions::default()), points, "{head}");
        }
    }
}

#[test]
fn every_unit_is_scaled_once() {
    for (unit, value, mm) in [
        ("nm", "1234567.5", 1.2345675),
        ("um", "1234.5675", 1.2345675),
        ("mm", "1.2345675", 1.2345675),
        ("cm", "12.5", 125.0),
        ("metres", "0.0125", 12.5),
        ("in", "2", 50.8),
    ] {
        let text = format!("x[{unit}] y[{unit}] z[{unit}]\n0 0 {value}\n");
        assert_eq!(points_with(&text, &TextOptions::default()), [[0.0, 0.0, mm]], "{unit}");
    }
    let text = "x[mm] y[mm] z[nm] u_z\n1 2 5 3\n";
    let Ok(Topography::Cloud(cloud, _)) = read(text.as_bytes()) else { panic!("{text}") };
    assert_eq!((cloud.points_mm, cloud.uncertainties_mm), (vec![[1.0, 2.0, 5e-6]], vec![3e-6]));
}

#[test]
fn names_say_columns() {
    let points = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
    for text in [
        "id,x,y,z\n0,1,2,3\n1,4,5,6\n",
        "\"ClusterId\",\"X\",\"Y\",\"Z\"\n0,1,2,3\n1,4,5,6\n",
        "region,x_mm,y_mm,z_mm\n1,1,2,3\n1,4,5,6\n",
        "piece,s_mm,x_mm,y_mm,z_mm,deviation_nm\n0,9,1,2,3,8\n0,9,4,5,6,8\n",
        "z y x\n3 2 1\n6 5 4\n",
        "# z y x\n3 2 1\n6 5 4\n",
        "# index x y z\n7 1 2 3\n8 4 5 6\n",
        ",x,y,z\n0,1,2,3\n1,4,5,6\n",
        "\"Elevation\",\"Points:0\",\"Points:1\",\"Points:2\"\n9,1,2,3\n9,4,5,6\n",
        "1;2;3;\n4;5;6;\n",
        "name x y z\nP1 1 2 3\nP2 4 5 6\n",
    ] {
        assert_eq!(points_with(text, &TextOptions::default()), points, "{text}");
    }
}

#[test]
fn what_cannot_be_told_is_refused_with_the_cure() {
    for (text, what) in [
        ("index, x_um, y_um\n0, 1, 2\n1, 2, 4\n", "index, x_um, y_um are neither"),
        ("a b c\n1 2 3\n", "a, b, c are neither"),
        ("lon lat alt\n1 2 3\n", "neither x, y, z"),
        ("x y z x\n1 2 3 4\n", "two of the columns"),
        ("x[um] y[um] z\n1 2 3\n", "the unit of z is not stated"),
        ("x[mm] y[mm] z[furlong]\n1 2 3\n", "\"furlong\" of column 3"),
        ("# lengths in metres\n1 2 3\n", "in m\", but not of what"),
        ("# x y z in um\n# x y z in mm\n1 2 3\n", "comments say"),
        ("0 1.5 2 3\n1 2.5 2 3\n", "4 columns without names"),
        ("1 2 3 4 5 6 7 8\n1 2 3 4 5 6 7 8\n", "may be a matrix of heights"),
        ("1 10 0.5\n2 20 0.25\n3 30 0.125\n", "counts the lines"),
        ("1 2\n2 3\n", "two columns without names"),
        ("\"x\" \"y\" \"z\"\n\"1\" 1 2 3\n", "do not fit the names"),
        ("x slope\n1 2\n", "unit of the slopes"),
        ("x y\n1 2\n", "neither"),
    ] {
        let found = refused(text, &TextOptions::default());
        assert!(found.contains(what), "{text}: {found}");
        assert!(found.contains("`--"), "no cure in: {found}");
    }
    for text in [
        "x y z\n1 2 3\n1 2\n",
        "x y z\n1 2 3\n1 2 3 4\n",
        "x,y,z\n1,2,3\n1,2,3,4\n",
        "1 2 3\n1\t2\n",
        "1;2.5;3\n1;2,5;3\n",
        "0 1e 3\n",
        "1 2 3\n4 5 6 7\n",
    ] {
        refused(text, &TextOptions::default());
    }
}

#[test]
fn options_name_columns_and_units() {
    let um = &[Unit::Um][..];
    assert_eq!(points_with(MICROMETRES, &options("", um)), in_mm());
    let indexed: String = (0..3)
        .zip(MICROMETRES.lines())
        .map(|(index, line)| format!("{index} {line} 99\n"))
        .collect();
    assert_eq!(points_with(&indexed, &options("2,3,4", um)), in_mm());
    let named = format!("n left up out q\n{indexed}");
    assert_eq!(points_with(&named, &options("left,up,out", um)), in_mm());
    let each = [Unit::Mm, Unit::Mm, Unit::Nm];
    assert_eq!(points_with("1 2 500\n", &options("", &each)), [[1.0, 2.0, 0.0005]]);
    // A unit that the file states need not be repeated, and must not be denied.
    assert_eq!(points_with("x_um y_um z_um\n1 2 3\n", &options("", um)), [[0.001, 0.002, 0.003]]);
    assert!(refused("x_um y_um z_um\n1 2 3\n", &options("", &[Unit::Mm])).contains("is in um"));
    assert_eq!(points_with("x y z[furlong]\n1 2 3\n", &options("", um))[0][2], 0.003);
    // One unit is that of the columns that state none.
    assert_eq!(points_with("x y z[nm]\n1 2 3\n", &options("", um)), [[0.001, 0.002, 3e-6]]);
    assert_eq!(
        points_with("P1 1 2 3\nP2 4 5 6\n", &options("2,3,4", um))[1],
        [0.004, 0.005, 0.006]
    );
    assert!(refused("1 2 3\n", &options("1,2,5", um)).contains("no column 5"));
    assert!(refused("x y z\n1 2 3\n", &options("x,y,w", um)).contains("called w"));
    assert!(refused("1 2 3\n", &options("", &[Unit::Mm, Unit::Um])).contains("2 units for 3"));
    let skipping = TextOptions { skip_lines: 2, ..options("", um) };
    assert_eq!(points_with(&format!("5x5\n3 4\n{MICROMETRES}"), &skipping), in_mm());
    // The first of three plain columns may count the lines if the user says so.
    let counted = "1 10 0.5\n2 20 0.25\n3 30 0.125\n";
    assert_eq!(points_with(counted, &options("1,2,3", &[Unit::Mm])).len(), 3);
}

#[test]
fn profiles_have_two_columns() {
    let expected = [[0.0, 0.0, 0.001], [0.5, 0.0, 0.0025]];
    for text in ["x[mm] z[um]\n0 1\n0.5 2.5\n", "x_mm,height_um,q\n0,1,7\n0.5,2.5,7\n"] {
        assert_eq!(points_with(text, &TextOptions::default()), expected, "{text}");
    }
    assert_eq!(points_with("0 1\n0.5 2.5\n", &options("", &[Unit::Mm, Unit::Um])), expected);
    // Slopes by the trapezoidal rule.
    let slopes = "x[mm] slope[urad]\n0 10\n1 30\n3 -10\n";
    let Ok(Topography::Cloud(cloud, _)) = read(slopes.as_bytes()) else { panic!("{slopes}") };
    assert_eq!(cloud.slopes, [1e-5, 3e-5, -1e-5]);
    let heights = [0.0, 0.5 * (1e-5 + 3e-5), 0.5 * (1e-5 + 3e-5) + 0.5 * (3e-5 - 1e-5) * 2.0];
    assert_eq!(cloud.points_mm.iter().map(|point| point[2]).collect::<Vec<_>>(), heights);
    let asked = options("", &[Unit::Mm, Unit::Urad]);
    assert_eq!(points_with("0 10\n1 30\n3 -10\n", &asked), cloud.points_mm);
    for text in ["x[mm] slope[urad]\n0 1\n1 NaN\n2 1\n", "x[mm] slope[urad]\n0 1\n2 1\n1 1\n"] {
        refused(text, &TextOptions::default());
    }
}

#[test]
fn heights_beyond_all_numbers_are_refused() {
    let options = TextOptions { pitch_mm: Some([1.0; 2]), ..options("", &[Unit::M]) };
    let error = read_with(b"1 2\n3 1e308\n", &options).unwrap_err().to_string();
    assert!(error.contains("line 2, column 2: expected a height in m"), "{error}");
}

/// Empty columns at the ends of lines, as some programs write them.
#[test]
fn a_column_without_any_value_is_no_column_of_points() {
    let text = "20\t17\t\t\r21\t18.5\t\t\r22\t17\t\t\r";
    let told = refused(text, &TextOptions::default());
    assert!(told.contains("no line has all of x, y and z; 3 lack"), "{told}");
    assert!(told.contains("`--columns`"), "{told}");
}

#[test]
fn matrices_of_heights_are_read_with_their_pitch() {
    let matrix = TextOptions { pitch_mm: Some([0.5, 2.0]), ..options("", &[Unit::Um]) };
    let text = "# heights\n1 2 3\n4 NaN 6\n";
    let Ok(Topography::Map(map, _)) = read_with(text.as_bytes(), &matrix) else { panic!("no map") };
    let HeightMap { nx, ny, dx_mm, dy_mm, z_mm, .. } = map;
    assert_eq!((nx, ny, dx_mm, dy_mm), (3, 2, 0.5, 2.0));
    // The first line is the top.
    assert_eq!((z_mm[0], z_mm[2], z_mm[3], z_mm[5]), (0.004, 0.006, 0.001, 0.003));
    assert!(z_mm[1].is_nan());
    assert!(refused("1 2 3\n4 5\n", &matrix).contains("3 heights as in line 1"));
    assert!(refused("h\n\"\"", &matrix).contains("expected a row of heights, found nothing"));
    let unitless = TextOptions { units: Vec::new(), ..matrix };
    assert!(refused(text, &unitless).contains("add `--unit`"));
}

#[test]
fn markers_of_programs_are_gaps_and_never_numbers() {
    for marker in ["1.#QNAN", "-1.#IND", "-nan", "NaN", "NA", "null", "nan(ind)"] {
        let cloud = cloud(&format!("0 0 {marker}\n1 0 2\n"));
        assert_eq!((cloud.points_mm, cloud.missing), (vec![[1.0, 0.0, 2.0]], 1), "{marker}");
    }
    assert_eq!(cloud("0 0 1\nNaN NaN NaN\n").missing, 1);
    assert_eq!(cloud("0\t0\t1\n1\t0\t\n").missing, 1);
}

proptest! {
    #[test]
    fn decimal_commas_come_back_bit_for_bit(
        points in prop::collection::vec(prop::array::uniform3(-1e6..1e6_f64), 1..30),
        separator in prop::sample::select(vec![" ", "\t", ";", " ; "]),
    ) {
        let text: String = points.iter().map(|[x, y, z]| {
            format!("{x}{separator}{y}{separator}{z}\n").replace('.', ",")
        }).collect();
        prop_assert_eq!(cloud(&text).points_mm, points);
    }
}

/// A row of -999 among heights of micrometres, and a matrix of three columns.
#[test]
fn heights_that_stand_for_none_are_left_out_and_said() {
    let mut text = String::from("x_mm y_mm z_um T\n");
    for row in 0..40 {
        let (x, y) = (row % 8, row / 8);
        let z = if row == 13 { "-999".to_owned() } else { format!("{}", 0.1 * f64::from(x * y)) };
        text.push_str(&format!("{x} {y} {z} {row}\n"));
    }
    let (topography, beside) =
        read_with_column(text.as_bytes(), &TextOptions::default(), 4).unwrap();
    assert_eq!((topography.points().count(), topography.missing()), (39, 1));
    assert_eq!(beside.len(), 39, "the numbers beside points go with them");
    assert!(beside.iter().all(|value| *value != 13.0));
    let taken = topography.source().taken.clone().unwrap();
    assert_eq!(
        taken.cautions,
        ["1 height of -999 um left out: a usual mark for no data, far from all other heights \
          (`--keep-marks` takes it as a height)"]
    );
    let with_marks = TextOptions { keeps_marks: true, ..TextOptions::default() };
    let (topography, beside) = read_with_column(text.as_bytes(), &with_marks, 4).unwrap();
    assert_eq!((topography.points().count(), topography.missing(), beside.len()), (40, 0, 40));
    // Another number so far away stays, and is said.
    let other = text.replace("-999", "-812345.5");
    let topography = read(other.as_bytes()).unwrap();
    assert_eq!(topography.points().count(), 40);
    let cautions = topography.source().taken.clone().unwrap().cautions;
    assert!(cautions[0].contains("1 height lies more than 70 mm"), "{cautions:?}");
    // In a matrix it is a gap.
    let matrix = TextOptions { pitch_mm: Some([0.5, 0.5]), ..options("", &[Unit::Um]) };
    let rows = "0.1 0.2 0.3 0.2\n0.2 -9999 0.1 0.4\n0.3 0.2 -9999 0.1\n";
    let topography = read_with(rows.as_bytes(), &matrix).unwrap();
    assert_eq!((topography.points().count(), topography.missing()), (10, 2));
    let taken = topography.source().taken.clone().unwrap();
    assert!(taken.cautions[0].starts_with("2 heights of -9999 um"), "{:?}", taken.cautions);
    // Slopes are not integrated over it.
    let slopes = "x_mm slope_urad\n0 1\n1 2\n2 -9999\n3 1\n";
    assert!(refused(slopes, &TextOptions::default()).contains("not integrated"));
}

#[test]
fn three_columns_of_heights_are_not_taken_for_points() {
    let sphere = |x: f64, y: f64| 1.25 + (x * x + y * y) / 60.0;
    let noise = |row: i32, column: i32| f64::from((row * 37 + column * 101) % 19 - 9) * 1e-6;
    let columns = |height: &dyn Fn(i32, i32) -> f64| {
        let rows = (0..40).map(|row| {
            let [a, b, c] = [0, 1, 2].map(|column| height(row, column));
            format!("{a} {b} {c}\n")
        });
        rows.collect::<String>()
    };
    let curved = columns(&|row, column| {
        sphere(f64::from(column - 1) * 0.1, f64::from(row - 20) * 0.1) + noise(row, column)
    });
    let flat = columns(&|row, column| 3.7 + noise(row, column));
    for text in [&curved, &flat] {
        let said = refused(text, &TextOptions::default());
        assert!(said.contains("may be a matrix of heights") && said.contains("`--pitch"), "{said}");
        assert_eq!(points_with(text, &options("1,2,3", &[])).len(), 40, "the cure");
    }
    // Points of a raster, of a spiral and of a scan along the diagonal are points.
    let raster = columns(&|row, column| match column {
        0 => f64::from(row % 8) * 0.1,
        1 => f64::from(row / 8) * 0.1,
        _ => sphere(f64::from(row % 8) * 0.1, f64::from(row / 8) * 0.1),
    });
    let turn = |row: i32| f64::from(row) * 0.7;
    let spiral = columns(&|row, column| match column {
        0 => 0.1 * turn(row) * turn(row).cos(),
        1 => 0.1 * turn(row) * turn(row).sin(),
        _ => sphere(0.0, 0.1 * turn(row)),
    });
    let diagonal = columns(&|row, column| match column {
        0 | 1 => f64::from(row) * 0.1,
        _ => sphere(0.1 * f64::from(row), 0.1 * f64::from(row)),
    });
    for text in [raster, spiral, diagonal] {
        assert_eq!(points_with(&text, &TextOptions::default()).len(), 40);
    }
}

#[test]
fn a_profile_over_the_radius_is_a_profile() {
    for head in [
        "# r [mm], z [um]",
        "% R [mm];Z [um]",
        "# profile: r_mm z_um",
        "r_mm,z_um",
        "R [mm],Z [um]",
        "radius/mm,height/um",
    ] {
        let text = format!("{head}\n0,0\n0.5,2.5\n");
        let expected = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0025]];
        assert_eq!(points_with(&text, &TextOptions::default()), expected, "{head}");
    }
    // Beside x a column r is another thing, as red.
    let colours = "x y z r g b\n1 2 3 255 0 0\n";
    assert_eq!(points_with(colours, &TextOptions::default()), [[1.0, 2.0, 3.0]]);
}

#[test]
fn lines_of_prose_before_the_points_are_counted() {
    let text = "Measured by hand\nWith a probe of 2 mm\n# a comment\nx y z\nmm mm um\n1 2 500\n";
    let taken = read(text.as_bytes()).unwrap().source().taken.clone().unwrap();
    assert_eq!((taken.passed_over, taken.named_by), (2, By::Head));
}
