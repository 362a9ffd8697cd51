//! Points as other programs read them: messages of the type `sensor_msgs/PointCloud2` of ROS 1.
//!
//! A replay makes its points of the bytes that were received and passes these over. They are for viewers (Foxglove, rviz)
//! and scripts: MCAP names the type, and its definition ([`SCHEMA`]) stands in every segment.

use asphera_link::{Flags, Nanos};

/// One point as it was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedPoint {
    /// When its first reading reached the host.
    pub at: Nanos,
    /// Which trigger it belongs to, where that is known.
    pub count: Option<u64>,
    /// x, y, z in mm in the part frame; `None` where a flag forbids its use.
    pub position_mm: Option<[f64; 3]>,
    /// What is wrong with it.
    pub flags: Flags,
}

/// Points of one message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PointCloud(Vec<u8>);

impl PointCloud {
    /// A message with the time `at`. O(points).
    pub fn new(at: Nanos, points: &[RecordedPoint]) -> PointCloud {
        let mut bytes = Vec::with_capacity(300 + POINT_BYTES * points.len());
        let number = |value: usize| u32::try_from(value).unwrap_or(u32::MAX).to_le_bytes();
        let word = |bytes: &mut Vec<u8>, word: &str| {
            bytes.extend(number(word.len()));
            bytes.extend(word.as_bytes());
        };
        // std_msgs/Header: seq, stamp, frame_id.
        bytes.extend(number(0));
        bytes.extend(((at.as_nanos() / 1_000_000_000) as u32).to_le_bytes());
        bytes.extend(((at.as_nanos() % 1_000_000_000) as u32).to_le_bytes());
        word(&mut bytes, FRAME);
        // One row of points.
        bytes.extend(number(1));
        bytes.extend(number(points.len()));
        bytes.extend(number(FIELDS.len()));
        for (name, offset, datatype) in FIELDS {
            word(&mut bytes, name);
            bytes.extend(number(offset));
            bytes.push(datatype);
            bytes.extend(number(1));
        }
        bytes.push(0);
        bytes.extend(number(POINT_BYTES));
        bytes.extend(number(POINT_BYTES * points.len()));
        bytes.extend(number(POINT_BYTES * points.len()));
        for point in points {
            let place = point.position_mm.unwrap_or([f64::NAN; 3]);
            let count = point.count.map_or(f64::NAN, |count| count as f64);
            for value in place.into_iter().chain([point.at.as_secs_f64(), count]) {
                bytes.extend(value.to_le_bytes());
            }
            bytes.extend(point.flags.bits().to_le_bytes());
        }
        bytes.push(u8::from(points.iter().all(|point| point.position_mm.is_some())));
        PointCloud(bytes)
    }

    /// The message of these bytes; `None` where they are none of ours.
    pub(super) fn read(bytes: &[u8]) -> Option<PointCloud> {
        let cloud = PointCloud(bytes.to_vec());
        let data = cloud.data()?;
        data.len().is_multiple_of(POINT_BYTES).then_some(cloud)
    }

    /// The message.
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }

    /// Places in mm of the points that have one, in order.
    #[cfg(test)]
    fn positions_mm(&self) -> Vec<[f64; 3]> {
        let float = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap_or([0; 8]));
        let data = self.data().unwrap_or_default();
        let places = data
            .chunks_exact(POINT_BYTES)
            .map(|point| [float(&point[..8]), float(&point[8..16]), float(&point[16..24])]);
        places.filter(|place| !place[0].is_nan()).collect()
    }

    /// The points' bytes: what comes before them has always the same length.
    fn data(&self) -> Option<&[u8]> {
        let start = PointCloud::new(Nanos::ZERO, &[]).0.len() - 1;
        let length = self.0.get(start - 4..start)?;
        let length = u32::from_le_bytes(length.try_into().ok()?) as usize;
        (self.0.len() == start + length + 1).then(|| &self.0[start..start + length])
    }
}

/// Name of the frame that the places refer to; they are mm, not m as those of a robot.
const FRAME: &str = "part_mm";
/// Bytes of a point.
const POINT_BYTES: usize = 44;
/// Name, offset and type of what a point has; types are numbered as in `sensor_msgs/PointField`.
const FIELDS: [(&str, usize, u8); 6] = [
    ("x", 0, FLOAT64),
    ("y", 8, FLOAT64),
    ("z", 16, FLOAT64),
    ("time_s", 24, FLOAT64),
    ("count", 32, FLOAT64),
    ("flags", 40, UINT32),
];
const UINT32: u8 = 6;
const FLOAT64: u8 = 8;

/// Name of the type.
pub(super) const SCHEMA_NAME: &str = "sensor_msgs/PointCloud2";
/// Its definition and those it needs, as the format `ros1msg` of MCAP wants them.
pub(super) const SCHEMA: &str = "\
std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: sensor_msgs/PointField
uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_come_back_to_the_bit() {
        let point = |x: f64, good: bool| RecordedPoint {
            at: Nanos::from_millis(1500),
            count: Some(7),
            position_mm: good.then_some([x, -2.5, 1e-9]),
            flags: if good { Flags::empty() } else { Flags::WEAK },
        };
        let points = [point(0.1, true), point(0.2, false), point(-0.0, true)];
        let cloud = PointCloud::new(Nanos::from_millis(2000), &points);
        let places = cloud.positions_mm();
        assert_eq!(places, [[0.1, -2.5, 1e-9], [0.0, -2.5, 1e-9]]);
        assert!(places[1][0].is_sign_negative());
        assert_eq!(PointCloud::read(cloud.as_bytes()), Some(cloud.clone()));
        for length in 0..cloud.as_bytes().len() {
            assert_eq!(PointCloud::read(&cloud.as_bytes()[..length]), None, "{length}");
        }
        assert!(PointCloud::new(Nanos::ZERO, &[]).positions_mm().is_empty());
    }
}
