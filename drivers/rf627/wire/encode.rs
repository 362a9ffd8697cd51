//! A datagram with a profile, written.

use thiserror::Error;

use super::{DEVICE, HAS_INTENSITY, HEADER_LEN, Header, POINT, RawPoint};

/// Why a profile fits into no datagram.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum EncodeError {
    /// Bytes of the points are counted by 16 bits.
    #[error("{0} points, expected at most {MOST}")]
    Points(usize),
    /// An intensity belongs to each point.
    #[error("{found} intensities of {points} points")]
    Intensities {
        /// Points.
        points: usize,
        /// Intensities.
        found: usize,
    },
}

/// Appends the datagram of a profile, as a scanner sends it.
///
/// # Errors
///
/// When there are too many points, or not as many intensities as points. Nothing is appended then.
pub fn encode(
    header: &Header,
    points: &[RawPoint],
    intensities: Option<&[u8]>,
    out: &mut Vec<u8>,
) -> Result<(), EncodeError> {
    let bytes = u16::try_from(points.len() * POINT).ok();
    let bytes = bytes.ok_or(EncodeError::Points(points.len()))?;
    if let Some(found) = intensities.map(<[u8]>::len).filter(|len| *len != points.len()) {
        return Err(EncodeError::Intensities { points: points.len(), found });
    }
    let mut fixed = [0; HEADER_LEN];
    let mut put = |at: usize, bytes: &[u8]| fixed[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &[header.format.code(), if intensities.is_some() { HAS_INTENSITY } else { 0 }]);
    put(2, &DEVICE.to_le_bytes());
    put(4, &header.serial.to_le_bytes());
    put(8, &header.time_ns.to_le_bytes());
    put(16, &[header.version.0, header.version.1, 48, HEADER_LEN as u8]);
    put(20, &header.packet_count.to_le_bytes());
    put(24, &header.measure_count.to_le_bytes());
    put(28, &header.z_range_mm.to_le_bytes());
    put(30, &header.x_range_mm.to_le_bytes());
    put(32, &header.range_steps.to_le_bytes());
    put(44, &header.licence_hash.to_le_bytes());
    put(48, &header.exposure_ns.to_le_bytes());
    put(52, &header.laser.to_le_bytes());
    put(56, &header.step_count.to_le_bytes());
    put(60, &[header.direction]);
    put(61, &bytes.to_le_bytes());
    put(63, &[POINT as u8]);
    out.reserve(HEADER_LEN + points.len() * (POINT + 1));
    out.extend(fixed);
    for point in points {
        out.extend(point.x.to_le_bytes());
        out.extend(point.z.to_le_bytes());
    }
    out.extend(intensities.unwrap_or_default());
    Ok(())
}

/// Most points whose bytes 16 bits count.
const MOST: usize = u16::MAX as usize / POINT;
