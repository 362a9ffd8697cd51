//! A datagram with a profile, read.

use thiserror::Error;

use super::{DEVICE, HAS_INTENSITY, HEADER_LEN, POINT, ServiceHeader};

/// Kinds of profiles with points in mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// One point a column of the detector, 0x11.
    Profile,
    /// Points between the columns too, 0x13.
    Interpolated,
}

impl Format {
    /// Byte that stands for it.
    pub const fn code(self) -> u8 {
        match self {
            Format::Profile => 0x11,
            Format::Interpolated => 0x13,
        }
    }
}

/// Fields before the points of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Kind of the points.
    pub format: Format,
    /// Serial number of the scanner.
    pub serial: u32,
    /// The scanner's clock in ns.
    pub time_ns: u64,
    /// Version of the protocol: major, minor.
    pub version: (u8, u8),
    /// Number of the datagram; it wraps.
    pub packet_count: u32,
    /// Number of the measurement; it wraps.
    pub measure_count: u32,
    /// Measuring range in z, mm.
    pub z_range_mm: u16,
    /// Width of the measuring range at its far end, mm.
    pub x_range_mm: u16,
    /// Steps into which both ranges are divided, at least 1.
    pub range_steps: u16,
    /// Check value of the licence.
    pub licence_hash: u32,
    /// Exposure time in ns.
    pub exposure_ns: u32,
    /// Setting of the laser.
    pub laser: u32,
    /// Count of the encoder or of the steps.
    pub step_count: u32,
    /// Direction of the encoder.
    pub direction: u8,
}

/// A point as the scanner sends it, in steps of the ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawPoint {
    /// Along the line, signed.
    pub x: i16,
    /// Distance.
    pub z: u16,
}

impl RawPoint {
    /// Whether it has a value: the maker's programs leave out points with z = 0 or x = 0.
    pub fn is_valid(self) -> bool {
        self.x != 0 && self.z != 0
    }
}

/// A profile in the bytes of its datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet<'a> {
    /// Fields before the points.
    pub header: Header,
    points: &'a [u8],
    intensities: Option<&'a [u8]>,
    trailing: usize,
}

/// Why a datagram is no profile in mm.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum PacketError {
    /// Not even the fields before the points are there.
    #[error(
        "a datagram of {0} bytes, expected at least {HEADER_LEN}, the fields before the points: check the network, and that the scanner alone sends to this port"
    )]
    Short(usize),
    /// A service message on the port of the profiles.
    #[error(
        "a service message (command {0:#06x}), expected a profile: check that the port is that of profiles, 50001, and not 50011"
    )]
    Service(u16),
    /// Another device, or no device at all.
    #[error(
        "a datagram of device type {0}, expected {DEVICE}: check that the scanner alone sends to this port"
    )]
    Device(u16),
    /// Data that are no points in mm.
    #[error("data of type {0:#04x}, {name}, expected profiles in mm (0x11 or 0x13): choose the format of the stream in the scanner's settings", name = name_of(*.0))]
    Format(u8),
    /// A protocol nobody described to us.
    #[error("protocol {0}.{1}, expected 1.0 to 1.2")]
    Version(u8, u8),
    /// Places of the parameters or points that cannot be.
    #[error("parameters at byte {parameters} and points at byte {points} of {len}")]
    Offsets {
        /// Place of the parameters.
        parameters: u8,
        /// Place of the points.
        points: u8,
        /// Bytes of the datagram.
        len: usize,
    },
    /// Points that do not fill the bytes said.
    #[error("{bytes} bytes of points with {each} bytes each, expected a multiple of {POINT}")]
    Points {
        /// Bytes of all points.
        bytes: u16,
        /// Bytes of a point, as sent.
        each: u8,
    },
    /// The datagram was cut, or lies.
    #[error("points and intensities of {claimed} bytes, and {found} are there: check the network")]
    Cut {
        /// Bytes that there should be.
        claimed: usize,
        /// Bytes behind the fields.
        found: usize,
    },
    /// A range without steps gives no length.
    #[error("measuring ranges divided into 0 steps")]
    Scale,
}

impl<'a> Packet<'a> {
    /// Reads a datagram; nothing is copied.
    ///
    /// # Errors
    ///
    /// Why it is no profile in mm.
    pub fn decode(datagram: &'a [u8]) -> Result<Packet<'a>, PacketError> {
        let device = u16_at(datagram, 2);
        if let Some(device) = device.filter(|device| *device != DEVICE) {
            let service = ServiceHeader::of_message(datagram);
            return Err(
                service.map_or(PacketError::Device(device), |it| PacketError::Service(it.command))
            );
        }
        let Some(fixed) = datagram.first_chunk::<HEADER_LEN>() else {
            return Err(PacketError::Short(datagram.len()));
        };
        let format = match fixed[0] {
            0x11 => Format::Profile,
            0x13 => Format::Interpolated,
            other => return Err(PacketError::Format(other)),
        };
        let version = (fixed[16], fixed[17]);
        if version.0 != 1 || version.1 > 2 {
            return Err(PacketError::Version(version.0, version.1));
        }
        let (parameters_at, points_at) = (fixed[18], fixed[19]);
        let (at, from) = (usize::from(parameters_at), usize::from(points_at));
        let parameters = datagram.get(at..).and_then(|tail| tail.first_chunk::<PARAMETERS>());
        let offsets = || PacketError::Offsets {
            parameters: parameters_at,
            points: points_at,
            len: datagram.len(),
        };
        let parameters = parameters
            .filter(|_| at >= BEFORE_PARAMETERS && from >= at + PARAMETERS)
            .ok_or_else(offsets)?;
        let body = datagram.get(from..).ok_or_else(offsets)?;
        let header = header(format, version, fixed, parameters);
        if header.range_steps == 0 {
            return Err(PacketError::Scale);
        }
        let bytes = u16::from_le_bytes([parameters[13], parameters[14]]);
        Packet::with_body(header, bytes, parameters[15], fixed[1] & HAS_INTENSITY != 0, body)
    }

    fn with_body(
        header: Header,
        bytes: u16,
        each: u8,
        has_intensity: bool,
        body: &'a [u8],
    ) -> Result<Packet<'a>, PacketError> {
        let points = usize::from(bytes);
        // With intensities nobody says whether a point counts for 4 or for 5 bytes.
        let is_size =
            usize::from(each) == POINT || (has_intensity && usize::from(each) == POINT + 1);
        if !points.is_multiple_of(POINT) || !is_size {
            return Err(PacketError::Points { bytes, each });
        }
        let claimed = points + if has_intensity { points / POINT } else { 0 };
        if claimed > body.len() {
            return Err(PacketError::Cut { claimed, found: body.len() });
        }
        let (points, intensities) = body[..claimed].split_at(points);
        Ok(Packet {
            header,
            points,
            intensities: has_intensity.then_some(intensities),
            trailing: body.len() - claimed,
        })
    }

    /// How many points there are, with and without a value.
    pub fn len(&self) -> usize {
        self.points.len() / POINT
    }

    /// Whether there is no point at all.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Points as sent.
    pub fn raw_points(&self) -> impl ExactSizeIterator<Item = RawPoint> + use<'a> {
        self.points.chunks_exact(POINT).map(|bytes| RawPoint {
            x: i16::from_le_bytes([bytes[0], bytes[1]]),
            z: u16::from_le_bytes([bytes[2], bytes[3]]),
        })
    }

    /// Points `[x, z]` in mm; `None` where the scanner saw nothing.
    ///
    /// x = raw x · x range / steps, z = raw z · z range / steps.
    pub fn points_mm(&self) -> impl ExactSizeIterator<Item = Option<[f64; 2]>> + use<'a> {
        let Header { x_range_mm, z_range_mm, range_steps, .. } = self.header;
        let [x_mm, z_mm, steps] = [x_range_mm, z_range_mm, range_steps].map(f64::from);
        self.raw_points().map(move |point| {
            let place = [f64::from(point.x) * x_mm / steps, f64::from(point.z) * z_mm / steps];
            point.is_valid().then_some(place)
        })
    }

    /// An intensity a point, where they are sent.
    pub fn intensities(&self) -> Option<&'a [u8]> {
        self.intensities
    }

    /// Bytes behind the points and intensities that nobody knows.
    pub fn trailing(&self) -> usize {
        self.trailing
    }
}

fn header(
    format: Format,
    version: (u8, u8),
    fixed: &[u8; HEADER_LEN],
    parameters: &[u8; PARAMETERS],
) -> Header {
    let u16_of = |at: usize| u16::from_le_bytes([fixed[at], fixed[at + 1]]);
    let u32_of = |bytes: &[u8], at: usize| {
        u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    };
    let low = u64::from(u32_of(fixed, 8));
    Header {
        format,
        serial: u32_of(fixed, 4),
        time_ns: low | u64::from(u32_of(fixed, 12)) << 32,
        version,
        packet_count: u32_of(fixed, 20),
        measure_count: u32_of(fixed, 24),
        z_range_mm: u16_of(28),
        x_range_mm: u16_of(30),
        range_steps: u16_of(32),
        licence_hash: u32_of(fixed, 44),
        exposure_ns: u32_of(parameters, 0),
        laser: u32_of(parameters, 4),
        step_count: u32_of(parameters, 8),
        direction: parameters[12],
    }
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..at + 2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
}

fn name_of(format: u8) -> &'static str {
    match format {
        0x10 => "columns of the detector",
        0x12 => "interpolated columns of the detector",
        0x20 => "a profile by polynomials",
        _ => "which we do not know",
    }
}

/// Bytes of the parameters before the points.
const PARAMETERS: usize = 16;

/// The parameters come after the licence hash.
const BEFORE_PARAMETERS: usize = 48;
