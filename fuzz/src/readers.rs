//! Files of points as a fuzzer can write them, and what must hold for whatever a reader makes of them.
//!
//! The first byte of an input chooses the name of the file, the second the options of the command line.
//! What follows is the file. One name stands for an X3P file whose archive is made here: a fuzzer finds
//! neither checksums nor packed data by chance.

use std::io::{Cursor, Write as _};

use asphera_formats::xyz::{Column, TextOptions, Unit};
use asphera_formats::{Cloud, HeightMap, Topography, read_triangles, read_with, zemax};
use zip::write::SimpleFileOptions;

/// Reads an input and checks what came out of it.
///
/// # Panics
///
/// Where a law is broken.
pub fn hold(input: &[u8]) {
    let [name, options, file @ ..] = input else { return };
    if let Some(lens) = Some(file).filter(|file| zemax::is_zemax(file)).map(zemax::read) {
        lens_is_sound(lens);
    }
    let index = usize::from(*name) % NAMES.len();
    let packed = (index == 0).then(|| archive(file));
    let file = packed.as_deref().unwrap_or(file);
    match read_triangles(NAMES[index], file, &text_options(*options)) {
        Ok(None) => {}
        Ok(Some(mesh)) => {
            let has = |&corner: &u32| mesh.points_mm[corner as usize].iter().all(|v| v.is_finite());
            assert!(mesh.triangles.iter().flatten().all(has), "a triangle without its corners");
        }
        Err(error) => is_readable(&error.to_string()),
    }
    match read_with(NAMES[index], file, &text_options(*options)) {
        Ok(topography) => is_sound(&topography, file.len()),
        Err(error) => is_readable(&error.to_string()),
    }
}

/// Names of files: every extension that decides, and some that do not.
pub const NAMES: [&str; 17] = [
    "packed.x3p",
    "a",
    "a.xyz",
    "a.csv",
    "a.dat",
    "a.x3p",
    "a.sdf",
    "a.ply",
    "a.stl",
    "a.obj",
    "a.las",
    "a.laz",
    "a.npy",
    "a.zmx",
    "a.grd",
    "a.step",
    "a.off",
];

/// What a person may say of a file on the command line; 0 says nothing.
fn text_options(choice: u8) -> TextOptions {
    let column = |number| Column::Number(number);
    let columns = match choice & 7 {
        1 => vec![column(1), column(2), column(3)],
        2 => vec![column(2), column(1), column(4), column(3)],
        3 => vec![column(1), column(2)],
        4 => vec![Column::Name("x".to_owned()), Column::Name("slope".to_owned())],
        5 => vec![column(usize::MAX), column(0), column(1)],
        6 => vec![Column::Name("z".to_owned())],
        _ => Vec::new(),
    };
    let units = match choice >> 3 & 7 {
        1 => vec![Unit::Um],
        2 => vec![Unit::M, Unit::In, Unit::Nm],
        3 => vec![Unit::Mm, Unit::Urad],
        4 => vec![Unit::Cm; 9],
        _ => Vec::new(),
    };
    let (skip_lines, pitch_mm) = match choice >> 6 {
        1 => (1, None),
        2 => (0, Some([0.1, 0.2])),
        3 => (usize::MAX, Some([1e-300, 1e300])),
        _ => (0, None),
    };
    let keeps_marks = choice >> 3 & 1 == 1;
    let in_plane = choice >> 4 & 1 == 1;
    TextOptions { columns, units, skip_lines, pitch_mm, keeps_marks, in_plane }
}

/// An X3P archive of an input: its XML, and behind the first byte 0xFF, which no XML has, its points.
fn archive(input: &[u8]) -> Vec<u8> {
    let (xml, points) = match input.iter().position(|byte| *byte == 0xFF) {
        Some(at) => (&input[..at], &input[at + 1..]),
        None => (input, &[][..]),
    };
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, bytes) in [("main.xml", xml), ("bindata/data.bin", points)] {
        zip.start_file(name, stored).expect("a file of a name of its own can be begun");
        zip.write_all(bytes).expect("a Vec takes all");
    }
    zip.finish().expect("a Vec takes all").into_inner()
}

/// Sizes agree, and every number is finite but the gaps.
fn is_sound(topography: &Topography, bytes: usize) {
    let held = match topography {
        Topography::Map(map, _) => map_is_sound(map),
        Topography::Cloud(cloud, _) => cloud_is_sound(cloud),
    };
    // The most a byte can stand for is what DEFLATE makes of one, 1032.
    assert!(held <= bytes.saturating_mul(1032), "{held} points of {bytes} bytes");
    let points = topography.points().inspect(|point| {
        assert!(point.iter().all(|mm| mm.is_finite()), "a point at {point:?}");
    });
    assert_eq!(points.count() + topography.missing(), held);
    let source = topography.source();
    for text in [&source.instrument, &source.date, &source.comment].into_iter().flatten() {
        assert!(!text.trim().is_empty(), "a text that says nothing");
    }
}

fn map_is_sound(map: &HeightMap) -> usize {
    assert!(map.nx >= 1 && map.ny >= 1, "{} × {}", map.nx, map.ny);
    assert_eq!(map.nx.checked_mul(map.ny), Some(map.z_mm.len()));
    for mm in [map.dx_mm, map.dy_mm] {
        assert!(mm.is_finite() && mm > 0.0, "an increment of {mm} mm");
    }
    assert!(map.x0_mm.is_finite() && map.y0_mm.is_finite(), "{} {}", map.x0_mm, map.y0_mm);
    assert!(map.z_mm.iter().all(|z_mm| !z_mm.is_infinite()), "an infinite height");
    map.z_mm.len()
}

fn cloud_is_sound(cloud: &Cloud) -> usize {
    for count in [cloud.uncertainties_mm.len(), cloud.slopes.len()] {
        assert!(count == 0 || count == cloud.points_mm.len(), "{count}");
    }
    assert!(cloud.slopes.iter().all(|slope| slope.is_finite()), "a slope that is not finite");
    assert!(cloud.uncertainties_mm.iter().all(|u_mm| !u_mm.is_infinite()), "an infinite u");
    cloud.points_mm.len() + cloud.missing
}

fn lens_is_sound(lens: Result<zemax::Lens, zemax::LensError>) {
    match lens {
        Ok(lens) => {
            assert!(lens.unit_mm.is_finite() && lens.unit_mm > 0.0, "{}", lens.unit_mm);
            for surface in &lens.surfaces {
                let numbers = [surface.curvature, surface.conic, surface.semi_diameter];
                assert!(numbers.iter().all(|number| number.is_finite()), "{surface:?}");
            }
        }
        Err(error) => is_readable(&error.to_string()),
    }
}

/// A message of at most some lines, without signs that move a terminal.
fn is_readable(message: &str) {
    assert!(!message.trim().is_empty(), "an error without words");
    assert!(message.len() <= 4096, "an error of {} bytes", message.len());
    let moves = |sign: char| sign.is_control() && sign != '\n';
    assert!(!message.contains(moves), "{message:?}");
}
