//! Zygo MetroPro `.dat` maps: the phase data as heights.
//!
//! Layout, all numbers big-endian, as the readers of Gwyddion (`metropro.c`), prysm (`io.py`) and
//! SurfaceTopography (`MetroPro.py`) have it from Zygo's MetroPro Reference Guide OMP-0347:
//!
//! ```text
//! header │ intensity, u16: buckets × height × width │ phase, i32: height × width
//! ```
//!
//! A height is `phase · S · W · O / R` with the interferometric scale factor S, the wavelength W in
//! metres, the obliquity factor O, and R = 4096, 32768 or 131072 for the phase resolution 0, 1 or
//! 2. It is negated where the header says that the sign of the data is inverted, as Gwyddion and
//! SurfaceTopography do. A phase of 2147483640 or more is no measurement.
//!
//! The rows of the file go down the camera image, as Gwyddion draws them. They are turned over, so
//! that y goes up and the frame is right-handed; the origin is the lower left pixel of the phase
//! data.

use crate::error::quoted;
use crate::scan::grid_len;
use crate::topography::joined;
use crate::{Format, HeightMap, Place, ReadError, Source, Topography};

/// Reads a MetroPro file of header format 1, 2 or 3.
///
/// # Errors
///
/// Where the header contradicts itself or the length of the file, where it names no lateral scale
/// (an uncalibrated camera), or where the scale of the heights is zero or not finite.
///
/// # Example
///
/// ```
/// let error = asphera_formats::metropro::read(b"\x88\x1B\x03\x6F").unwrap_err();
/// assert_eq!(error.to_string(), "MetroPro file, byte 4: expected 2 bytes, found 0");
/// ```
pub fn read(bytes: &[u8]) -> Result<Topography, ReadError> {
    let header = Header::parse(bytes)?;
    let width = usize::from(header.width);
    let phase = &bytes[header.phase_start..];
    let mut z_mm = Vec::with_capacity(header.samples);
    for row in phase.chunks_exact(4 * width).rev() {
        z_mm.extend(row.as_chunks::<4>().0.iter().map(|&sample| {
            let phase = i32::from_be_bytes(sample);
            if phase >= INVALID_PHASE {
                f64::NAN
            } else {
                f64::from(phase) * header.scale_m * MM_PER_M
            }
        }));
    }
    let map = HeightMap {
        nx: width,
        ny: usize::from(header.height),
        dx_mm: header.pixel_mm,
        dy_mm: header.pixel_mm,
        x0_mm: 0.0,
        y0_mm: 0.0,
        z_mm,
    };
    Ok(Topography::Map(map, header.source))
}

/// Whether a file starts as a MetroPro file does.
pub(crate) fn is_metropro(bytes: &[u8]) -> bool {
    bytes.first_chunk().is_some_and(|magic| MAGICS.contains(magic))
}

/// Part of the header that is used.
struct Header {
    width: u16,
    height: u16,
    samples: usize,
    phase_start: usize,
    pixel_mm: f64,
    scale_m: f64,
    source: Source,
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Header, ReadError> {
        let magic = field::<4>(bytes, 0)?;
        let Some(version) = MAGICS.iter().position(|known| *known == magic) else {
            return Err(malformed(0, "a magic number 881B036F, 881B0370 or 881B0371", &magic));
        };
        let version = version as u16 + 1;
        let header_format = u16_at(bytes, HEADER_FORMAT)?;
        if header_format != version {
            let expected = format!("header format {version} after this magic number");
            return Err(malformed_text(HEADER_FORMAT, expected, header_format));
        }
        let header_len = u32_at(bytes, HEADER_LEN)?;
        if header_len < MIN_HEADER_LEN {
            let expected = format!("a header of at least {MIN_HEADER_LEN} bytes");
            return Err(malformed_text(HEADER_LEN, expected, header_len));
        }

        let intensity_len = 2
            * u64::from(u16_at(bytes, INTENSITY_WIDTH)?)
            * u64::from(u16_at(bytes, INTENSITY_WIDTH + 2)?)
            * u64::from(u16_at(bytes, INTENSITY_WIDTH + 4)?);
        let (width, height) = (u16_at(bytes, PHASE_WIDTH)?, u16_at(bytes, PHASE_WIDTH + 2)?);
        let place = Place::Byte(PHASE_WIDTH as u64);
        let samples = grid_len(Format::MetroPro, place, width.into(), height.into())?;
        let phase_len = 4 * samples as u64;
        let stated_len = u32_at(bytes, PHASE_BYTES)?;
        if u64::from(stated_len) != phase_len {
            let expected = format!("{phase_len} bytes of phase for {width} × {height} samples");
            return Err(malformed_text(PHASE_BYTES, expected, stated_len));
        }
        let phase_start = u64::from(header_len) + intensity_len;
        let file_len = phase_start + phase_len;
        if bytes.len() as u64 != file_len {
            let expected = format!(
                "a file of {file_len} bytes (header {header_len}, intensity {intensity_len}, phase {phase_len})"
            );
            return Err(malformed_text(bytes.len().min(file_len as usize), expected, bytes.len()));
        }

        let resolution = u16_at(bytes, PHASE_RESOLUTION)?;
        let divisor = match resolution {
            0 => 4096.0,
            1 => 32768.0,
            2 => 131_072.0,
            _ => {
                let expected = "a phase resolution of 0, 1 or 2".into();
                return Err(malformed_text(PHASE_RESOLUTION, expected, resolution));
            }
        };
        let sign = if u16_at(bytes, SIGN)? == 0 { 1.0 } else { -1.0 };
        let scale_m = sign
            * scale_at(bytes, SCALE_FACTOR, "an interferometric scale factor above zero")?
            * scale_at(bytes, WAVELENGTH, "a wavelength in metres above zero")?
            * scale_at(bytes, OBLIQUITY, "an obliquity factor above zero")?
            / divisor;
        let pixel_m =
            scale_at(bytes, LATERAL, "a lateral resolution in metres above zero, as calibrated")?;

        let mut source = Source::new(Format::MetroPro);
        let serial = u16_at(bytes, SYSTEM_SERIAL)?;
        source.instrument = joined(&[
            "Zygo",
            system_name(u16_at(bytes, SYSTEM_TYPE)?),
            &if serial == 0 { String::new() } else { serial.to_string() },
        ]);
        let seconds = u32_at(bytes, TIME_STAMP)?;
        // Zero is what software writes that does not know the time.
        source.date = (seconds != 0).then(|| iso_date(seconds));
        source.comment =
            joined(&[&text_at::<82>(bytes, COMMENT)?, &text_at::<40>(bytes, PART_NAME)?]);
        Ok(Header {
            width,
            height,
            samples,
            phase_start: phase_start as usize,
            pixel_mm: pixel_m * MM_PER_M,
            scale_m,
            source,
        })
    }
}

fn field<const N: usize>(bytes: &[u8], offset: usize) -> Result<[u8; N], ReadError> {
    let rest = bytes.get(offset..).unwrap_or_default();
    rest.first_chunk()
        .copied()
        .ok_or_else(|| malformed_text(offset, format!("{N} bytes"), rest.len()))
}

fn u16_at(bytes: &[u8], offset: usize) -> Result<u16, ReadError> {
    field(bytes, offset).map(u16::from_be_bytes)
}

fn u32_at(bytes: &[u8], offset: usize) -> Result<u32, ReadError> {
    field(bytes, offset).map(u32::from_be_bytes)
}

/// A factor, which must be finite and above zero: a zero would flatten the map without a word.
fn scale_at(bytes: &[u8], offset: usize, expected: &str) -> Result<f64, ReadError> {
    let value = f64::from(f32::from_be_bytes(field(bytes, offset)?));
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(malformed_text(offset, expected.into(), value))
    }
}

/// A text of at most `N` bytes, ended by a zero byte.
fn text_at<const N: usize>(bytes: &[u8], offset: usize) -> Result<String, ReadError> {
    let text: [u8; N] = field(bytes, offset)?;
    let text = text.split(|&byte| byte == 0).next().unwrap_or_default();
    Ok(String::from_utf8_lossy(text).trim().to_owned())
}

fn malformed(offset: usize, expected: &str, found: &[u8]) -> ReadError {
    malformed_text(offset, expected.into(), quoted(found))
}

fn malformed_text(offset: usize, expected: String, found: impl ToString) -> ReadError {
    ReadError::Malformed {
        format: Format::MetroPro,
        place: Place::Byte(offset as u64),
        expected,
        found: found.to_string(),
    }
}

/// Names of the system types as Gwyddion lists them.
fn system_name(system_type: u16) -> &'static str {
    match system_type {
        1 => "Mark IVxp",
        2 => "Maxim 3D",
        3 => "Maxim NT",
        4 => "GPI-XP",
        5 => "NewView",
        6 => "Maxim GP",
        7 => "NewView/GP",
        8 => "Mark to GPI conversion",
        _ => "",
    }
}

/// Seconds since 1970-01-01 as an ISO 8601 time, in the time zone in which the file counts them.
///
/// The day is found by counting from 0000-03-01, so that the leap day is the last of its year, in
/// eras of 400 years = 146 097 days.
fn iso_date(seconds: u32) -> String {
    let (days, second) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let leap_corrected =
        day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096;
    let year_of_era = leap_corrected / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = 400 * era + year_of_era + u32::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}")
}

const MM_PER_M: f64 = 1e3;

/// First bytes of header formats 1, 2 and 3, in this order.
const MAGICS: [[u8; 4]; 3] =
    [[0x88, 0x1B, 0x03, 0x6F], [0x88, 0x1B, 0x03, 0x70], [0x88, 0x1B, 0x03, 0x71]];

/// Phases from here on mean that nothing was measured.
const INVALID_PHASE: i32 = 2_147_483_640;

/// Shortest header in circulation, per Gwyddion; formats 1 and 2 have 834 bytes, format 3 has 4096.
const MIN_HEADER_LEN: u32 = 570;

// Offsets from the start of the file in bytes.
const HEADER_FORMAT: usize = 4;
const HEADER_LEN: usize = 6;
/// Width, height and number of intensity images, three numbers.
const INTENSITY_WIDTH: usize = 52;
/// Width and height of the phase image, two numbers.
const PHASE_WIDTH: usize = 68;
const PHASE_BYTES: usize = 72;
const TIME_STAMP: usize = 76;
const COMMENT: usize = 80;
const SCALE_FACTOR: usize = 164;
const WAVELENGTH: usize = 168;
const OBLIQUITY: usize = 176;
const LATERAL: usize = 184;
const PHASE_RESOLUTION: usize = 218;
const SIGN: usize = 232;
const SYSTEM_TYPE: usize = 238;
const SYSTEM_SERIAL: usize = 242;
const PART_NAME: usize = 258;

#[cfg(test)]
mod tests;
