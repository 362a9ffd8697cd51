//! Tests of the `.xyz` reader.

mod ambiguous;
mod heads;

use proptest::prelude::*;

use super::*;
use crate::Cloud;

fn cloud(text: &str) -> Cloud {
    match read(text.as_bytes()) {
        Ok(Topography::Cloud(cloud, _)) => cloud,
        other => panic!("{text:?} gave {other:?}"),
    }
}

fn message(text: &str) -> String {
    read(text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn every_separator_gives_the_same_points() {
    for text in [
        "1 2.5 -3e-3\n0 0 7\n",
        "1\t2.5\t-3e-3\r\n0\t0\t7",
        "  1,2.5,-3e-3\r0,0,7\r",
        "1, 2.5, -3e-3\n\n0 ,0 , 7\n",
        "1.0,2.5, -3.0e-3\n0.0 ,0.0,7.0\n",
        "1;2.5;-3e-3\n0 ; 0 ; 7\n",
        "\u{FEFF}1 2.5 -3e-3\n0 0 7",
        "x y z q note\n1 2.5 -3e-3 0.9 ok\n0 0 7 0.1 -\n",
        "# x\n% y\n// z\nX [mm],Y [mm],Z [mm]\n1 2.5 -3e-3 # weak\n0 0 7// last",
    ] {
        assert_eq!(
            cloud(text),
            Cloud { points_mm: vec![[1.0, 2.5, -3e-3], [0.0, 0.0, 7.0]], ..Cloud::default() },
            "{text:?}"
        );
    }
}

#[test]
fn a_column_beside_the_points_is_read_as_it_stands() {
    let values = |text: &str, column: usize| {
        read_with_column(text.as_bytes(), &TextOptions::default(), column)
            .map(|(_, values)| values)
            .map_err(|error| error.to_string())
    };
    let text = "x[um] y[um] z[um] T\n0 0 1 20.5\n1 0 nan 21\n\n2 0 1 -3e2 # cold\n";
    assert_eq!(values(text, 4), Ok(vec![20.5, -300.0]));
    // A column of places keeps the unit of the file.
    assert_eq!(values(text, 1), Ok(vec![0.0, 2.0]));
    assert_eq!(values("0;0;1,5\n1;0;2,5\n", 3), Ok(vec![1.5, 2.5]));
    for (text, column, expected) in [
        (text, 5, "line 2: expected column 5, counted from 1, found 4 columns"),
        (text, 0, "line 2: expected column 0, counted from 1, found 4 columns"),
        ("x y z T\n0 0 1 2\n1 0 1 nan\n", 4, "line 3, column 4: expected a number beside every"),
        ("x y z T\n0 0 1 2\n1 0 1 warm\n", 4, "line 3, column 4: expected a number beside every"),
    ] {
        let said = values(text, column).unwrap_err();
        assert!(said.contains(expected), "{said}");
    }
    let options = TextOptions { pitch_mm: Some([1.0; 2]), ..TextOptions::default() };
    let said = read_with_column(b"1 2 3\n4 5 6\n", &options, 1).unwrap_err().to_string();
    assert!(said.contains("no column 1 beside its points: leave `--pitch` out"), "{said}");
}

#[test]
fn missing_heights_are_counted_and_never_zero() {
    let text = "0 0 nan\n1 0 NaN\n2 0 ***\n3 0 BAD\n4 0 *\n5 0 1\n";
    assert_eq!(
        cloud(text),
        Cloud { points_mm: vec![[5.0, 0.0, 1.0]], missing: 5, ..Cloud::default() }
    );
    assert_eq!(cloud("1;2;\n3;4;5\n").missing, 1);
    assert_eq!(cloud("x,y,z,q\n3,4,,7\n").missing, 1);
}

#[test]
fn decimal_commas_are_refused_with_a_hint() {
    for text in ["1,5, 2,5, 3,5", "1,5, 2.0, 3.0", "1.5,2 3.5", "1,5,2 3,5"] {
        let message = message(text);
        assert!(message.starts_with("XYZ file, line 1: expected one kind"), "{text}: {message}");
        assert!(message.contains("write 1.5 where a decimal comma says 1,5"), "{message}");
    }
}

#[test]
fn errors_name_line_and_column() {
    assert_eq!(
        message("# no names here\n0 0 1\n0 zwei 1\n"),
        "XYZ file, line 3, column 2: expected y in mm, found \"zwei\""
    );
    assert_eq!(message("0 NaN 1"), "XYZ file, line 1, column 2: expected y in mm, found \"NaN\"");
    assert!(message("0\n").contains("line 1: expected at least 2 columns: x, y, z"));
    assert_eq!(
        message(""),
        "XYZ file, line 1: expected at least one line with x, y and z, found none"
    );
    assert_eq!(
        message("0 0 1e999"),
        "XYZ file, line 1, column 3: expected z in mm, or NaN, BAD or *** where nothing was \
         measured, found \"1e999\""
    );
    assert!(message("x y z\n1 2 3\nx y z\n").contains("line 3, column 1"));
    assert!(message("3\n0 0 1\n").contains("line 1: expected at least 2 columns"));
}

#[test]
fn other_formats_are_refused() {
    assert!(message("Zygo ASCII Data File - Format 2\n0 0 0 0\n").contains("not supported"));
}

#[test]
fn measured_mirror_is_read_whole() {
    let Some(bytes) = crate::test_data::shared("mirrors/xmf_02_hyperbolic_cylinder.xyz") else {
        return;
    };
    let Ok(Topography::Cloud(cloud, _)) = read(&bytes) else { panic!("not a cloud") };
    assert_eq!((cloud.points_mm.len(), cloud.missing), (106_048, 0));
    // The first line as the file prints it.
    assert_eq!(cloud.points_mm[0], [2.016, 4.32, 0.00261657814]);
}

proptest! {
    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = read(&bytes);
    }

    #[test]
    fn random_text_never_panics_or_loses_a_line(text in "([0-9,.;eE*#%/ \t-]{0,20}\n){0,20}") {
        if let Ok(topography) = read(text.as_bytes()) {
            let lines = text.lines().map(|line| parted(line.as_bytes()).0);
            let lines = lines.filter(|line| !line.trim_ascii().is_empty());
            // Text before the points is no line of them.
            let kept = lines.skip_while(|line| is_text(line)).count();
            prop_assert_eq!(topography.points().count() + topography.missing(), kept);
        }
    }

    #[test]
    fn written_points_come_back_bit_for_bit(
        points in prop::collection::vec(prop::array::uniform3(prop::num::f64::NORMAL), 1..50),
        separator in prop::sample::select(vec![" ", "\t", ", ", ",", ";"]),
    ) {
        let text: String = points.iter().map(|[x, y, z]| {
            format!("{x:e}{separator}{y:e}{separator}{z:e}\n")
        }).collect();
        prop_assert_eq!(cloud(&text).points_mm, points);
    }
}

#[test]
fn a_column_named_u_z_holds_uncertainties() {
    for name in ["u_z[mm]", "u_z", "U_Z(mm)"] {
        let text = format!(
            "x[mm] y[mm] z[mm] quality {name}\n0 0 1 7 1e-5\n1 0 NaN 7 1\n0 1 2 7 0\n1 1 3 7 -\n"
        );
        let cloud = cloud(&text);
        assert_eq!((cloud.points_mm.len(), cloud.missing), (3, 1));
        assert_eq!(cloud.uncertainties_mm[..2], [1e-5, 0.0]);
        assert!(cloud.uncertainties_mm[2].is_nan() && cloud.uncertainties_mm.len() == 3);
    }
    assert!(cloud("x y z q\n0 0 1 7\n").uncertainties_mm.is_empty());
    assert!(message("0 0 1 1e-5\n").contains("4 columns without names"));
}

#[test]
fn text_of_16_bits_is_read_as_any_other() {
    let text = "x y z u_z\r\n0 0 1.5 1e-5\r\n1 0 NaN 1\r\n";
    let units: Vec<u16> = std::iter::once(0xFEFF).chain(text.encode_utf16()).collect();
    let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
    for bytes in [little, big] {
        let topography = crate::read("scan.txt", &bytes).unwrap();
        assert_eq!(topography.points().collect::<Vec<_>>(), [[0.0, 0.0, 1.5]]);
        assert_eq!((topography.missing(), topography.uncertainties_mm()), (1, &[1e-5][..]));
    }
}
