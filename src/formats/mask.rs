//! PNG images as black and white: which pixels belong to a shape.
//!
//! Source: W3C Portable Network Graphics, third edition. Any colour type and depth, interlaced or not.

use std::io::Cursor;

use crate::{Format, Place, ReadError};

/// Which pixels of an image are set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// How many columns it has.
    pub columns: usize,
    /// How many rows.
    pub rows: usize,
    /// Whether each pixel is set, row by row from the top.
    pub set: Vec<bool>,
    /// How many pixels have a colour: red, green and blue differ.
    pub coloured: usize,
    /// How many pixels are less than half opaque.
    pub transparent: usize,
}

/// Most pixels of an image that is read.
const MOST_PIXELS: u64 = 100_000_000;

/// Reads the pixels of an image that are darker than half way from black to white; with `is_light` those that are not.
///
/// The grey of a colour is the mean of red, green and blue, and a pixel less than half opaque is never set.
///
/// # Errors
///
/// No PNG image, a damaged one, or one of more than 10⁸ pixels.
pub fn read(bytes: &[u8], is_light: bool) -> Result<Mask, ReadError> {
    let malformed = |error: png::DecodingError| ReadError::Malformed {
        format: Format::Png,
        place: Place::Byte(0),
        expected: "a PNG image".to_owned(),
        found: error.to_string(),
    };
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(malformed)?;
    let (columns, rows) = (reader.info().width, reader.info().height);
    let pixels = u64::from(columns) * u64::from(rows);
    let size = reader.output_buffer_size().filter(|_| pixels <= MOST_PIXELS);
    let Some(size) = size else {
        return Err(ReadError::TooLarge {
            format: Format::Png,
            place: Place::Byte(0),
            unit: "pixels",
            limit: MOST_PIXELS,
            found: pixels,
        });
    };
    let mut bytes = vec![0; size];
    let info = reader.next_frame(&mut bytes).map_err(malformed)?;
    let (colours, has_alpha) = match info.color_type {
        png::ColorType::Grayscale | png::ColorType::Indexed => (1, false),
        png::ColorType::GrayscaleAlpha => (1, true),
        png::ColorType::Rgb => (3, false),
        png::ColorType::Rgba => (3, true),
    };
    let width = colours + usize::from(has_alpha);
    let (columns, rows) = (columns as usize, rows as usize);
    let is_opaque = |pixel: &[u8]| !has_alpha || pixel[colours] >= 128;
    let is_set = |pixel: &[u8]| {
        let grey: usize = pixel[..colours].iter().map(|&value| usize::from(value)).sum();
        is_opaque(pixel) && ((grey < 128 * colours) != is_light)
    };
    let lines = || bytes.chunks_exact(info.line_size).take(rows);
    let pixels = || lines().flat_map(|line| line[..columns * width].chunks_exact(width));
    let is_coloured = |pixel: &[u8]| pixel[..colours].iter().any(|&value| value != pixel[0]);
    Ok(Mask {
        columns,
        rows,
        set: pixels().map(is_set).collect(),
        coloured: pixels().filter(|pixel| is_coloured(pixel)).count(),
        transparent: pixels().filter(|pixel| !is_opaque(pixel)).count(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(
        colour: png::ColorType,
        depth: png::BitDepth,
        size: [u32; 2],
        data: &[u8],
    ) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    #[test]
    fn grey_colour_and_single_bits() {
        let grey = encoded(
            png::ColorType::Grayscale,
            png::BitDepth::Eight,
            [3, 2],
            &[0, 127, 128, 255, 10, 200],
        );
        let mask = read(&grey, false).unwrap();
        assert_eq!((mask.columns, mask.rows), (3, 2));
        assert_eq!(mask.set, [true, true, false, false, true, false]);
        let light = read(&grey, true).unwrap();
        assert!(light.set.iter().zip(&mask.set).all(|(light, dark)| light != dark));
        let bits = encoded(
            png::ColorType::Grayscale,
            png::BitDepth::One,
            [3, 2],
            &[0b1010_0000, 0b0100_0000],
        );
        assert_eq!(read(&bits, true).unwrap().set, [true, false, true, false, true, false]);
        let rgba = encoded(
            png::ColorType::Rgba,
            png::BitDepth::Eight,
            [2, 1],
            &[0, 0, 0, 255, 0, 0, 0, 0],
        );
        let mask = read(&rgba, false).unwrap();
        assert_eq!((mask.set, mask.coloured, mask.transparent), (vec![true, false], 0, 1));
        let rgb = encoded(
            png::ColorType::Rgb,
            png::BitDepth::Eight,
            [3, 1],
            &[255, 0, 0, 255, 255, 0, 7, 7, 7],
        );
        let mask = read(&rgb, false).unwrap();
        assert_eq!((mask.set, mask.coloured), (vec![true, false, true], 2));
        let wide = encoded(png::ColorType::Rgb, png::BitDepth::Sixteen, [1, 1], &[255; 6]);
        assert_eq!(read(&wide, true).unwrap().set, [true]);
    }

    #[test]
    fn what_is_no_image_is_refused() {
        for bytes in [&b""[..], b"GIF89a", b"\x89PNG\r\n\x1a\n", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"] {
            assert!(matches!(read(bytes, false), Err(ReadError::Malformed { .. })), "{bytes:?}");
        }
        let mut cut =
            encoded(png::ColorType::Grayscale, png::BitDepth::Eight, [64, 64], &[7; 4096]);
        cut.truncate(cut.len() - 30);
        assert!(read(&cut, false).is_err());
    }
}
