//! The vertices of a binary PLY file, some at a time, for files that do not fit into memory.

use super::body::{Body, Numbers, Wanted, fixed_size, goes_on};
use super::header::{Element, Encoding, Header};
use super::read::vertices;
use crate::lengths::Lengths;
use crate::xyz::TextOptions;
use crate::{Format, Place, ReadError};

/// Where the vertices of a file lie, all records of one length.
pub struct VertexRecords {
    lengths: Lengths,
    element: Element,
    slots: [usize; 3],
    is_big: bool,
    first_byte: usize,
    record_bytes: usize,
    /// The last element, and the bytes of all behind the vertices; none where lists have any length.
    tail: Option<(Element, u64)>,
}

impl VertexRecords {
    /// Finds the vertices by the start of a file, which has its whole header. `None` of files that are no PLY, are text or
    /// have no records of one length right behind the header: [`read`](super::read()) takes them whole.
    ///
    /// # Errors
    ///
    /// Those of [`read`](super::read()) that a header can have.
    pub fn found_in(
        start: &[u8],
        options: &TextOptions,
    ) -> Result<Option<VertexRecords>, ReadError> {
        let has_end = start.windows(END.len()).any(|window| window == END);
        if !super::is_ply(start) || !has_end {
            return Ok(None);
        }
        let header = Header::read(start)?;
        let (at, slots) = vertices(&header)?;
        let element = header.elements[at].clone();
        let record_bytes = fixed_size(&element).filter(|_| at == 0 && element.count > 0);
        let (Some(record_bytes), Encoding::Little | Encoding::Big) =
            (record_bytes, header.encoding)
        else {
            return Ok(None);
        };
        let lengths = Lengths::of(Format::Ply, header.unit, options)?;
        let is_big = header.encoding == Encoding::Big;
        let first_byte = header.bytes;
        let bytes = |it: &Element| match it.count {
            0 => Some(0),
            count => count.checked_mul(fixed_size(it)? as u64),
        };
        let behind: Option<u64> = header.elements[1..].iter().map(bytes).sum();
        let tail = header.elements.last().cloned().zip(behind);
        Ok(Some(VertexRecords { lengths, element, slots, is_big, first_byte, record_bytes, tail }))
    }

    /// Checks that a file of so many bytes ends with its last element, where the header tells how long all are.
    ///
    /// # Errors
    ///
    /// A file that goes on.
    pub fn check_length(&self, bytes: u64) -> Result<(), ReadError> {
        let Some((last, behind)) = &self.tail else { return Ok(()) };
        let vertices = self.element.count.saturating_mul(self.record_bytes as u64);
        let end = (self.first_byte as u64).saturating_add(vertices).saturating_add(*behind);
        match bytes.checked_sub(end) {
            None | Some(0) => Ok(()),
            Some(more) => Err(goes_on(last, Place::Byte(end), &format!("{more} more bytes"))),
        }
    }

    /// Bytes before the first vertex.
    pub fn first_byte(&self) -> usize {
        self.first_byte
    }

    /// Bytes of a vertex.
    pub fn record_bytes(&self) -> usize {
        self.record_bytes
    }

    /// Vertices of the file.
    pub fn count(&self) -> u64 {
        self.element.count
    }

    /// The points of some vertices, in mm, from number `first` on; those with a coordinate that is NaN are gaps, and left out.
    ///
    /// # Errors
    ///
    /// A coordinate that is infinite; bytes that end within a vertex.
    pub fn points_mm(&self, bytes: &[u8], first: u64) -> Result<Vec<[f64; 3]>, ReadError> {
        let mut body = Body::Bytes(Numbers::new(bytes, self.is_big));
        let mut points = Vec::with_capacity(bytes.len() / self.record_bytes);
        for index in first..first + bytes.len().div_ceil(self.record_bytes) as u64 {
            let at = self.first_byte as u64 + index * self.record_bytes as u64;
            let mut point = [0.0; 3];
            let wanted = Wanted::Numbers(self.slots, &mut point);
            if body.record(&self.element, index, wanted).is_err() {
                return Err(self.ended(index));
            }
            points.extend(self.lengths.scaled(point, || Place::Byte(at))?);
        }
        Ok(points)
    }

    /// The error of a file that ends within a vertex.
    pub fn ended(&self, index: u64) -> ReadError {
        let at = self.first_byte as u64 + index * self.record_bytes as u64;
        ReadError::Malformed {
            format: Format::Ply,
            place: Place::Byte(at),
            expected: format!("{} of element vertex", self.element.count),
            found: format!("the end of the file in number {}", index + 1),
        }
    }
}

/// The word that ends a header.
const END: &[u8] = b"end_header";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ply::read;

    fn file(order: &str, numbers: &[[f64; 3]]) -> Vec<u8> {
        let count = numbers.len();
        let mut bytes = format!(
            "ply\nformat binary_{order}_endian 1.0\ncomment lengths in um\nelement vertex {count}\nproperty uchar flag\n\
             property double x\nproperty float y\nproperty double z\nelement face 0\n\
             property list uchar int vertex_indices\nend_header\n"
        )
        .into_bytes();
        for &[x, y, z] in numbers {
            bytes.push(7);
            if order == "little" {
                bytes.extend(x.to_le_bytes());
                bytes.extend((y as f32).to_le_bytes());
                bytes.extend(z.to_le_bytes());
            } else {
                bytes.extend(x.to_be_bytes());
                bytes.extend((y as f32).to_be_bytes());
                bytes.extend(z.to_be_bytes());
            }
        }
        bytes
    }

    #[test]
    fn vertices_some_at_a_time_are_those_of_the_whole_file() {
        let mut numbers: Vec<[f64; 3]> =
            (0..100).map(|at| [f64::from(at), 0.25 * f64::from(at), 0.1]).collect();
        numbers[7][1] = f64::NAN;
        for order in ["little", "big"] {
            let bytes = file(order, &numbers);
            let whole: Vec<_> = read(&bytes, &TextOptions::default()).unwrap().points().collect();
            let records = VertexRecords::found_in(&bytes[..400], &TextOptions::default());
            let records = records.unwrap().unwrap();
            assert_eq!((records.count(), records.record_bytes()), (100, 21));
            let body = &bytes[records.first_byte()..];
            for size in [1, 7, 100] {
                let mut found = Vec::new();
                for (part, first) in body.chunks(21 * size).zip((0..).step_by(size)) {
                    found.extend(records.points_mm(part, first).unwrap());
                }
                assert_eq!((found.len(), &found), (99, &whole));
            }
            let said = records.points_mm(&body[..30], 5).unwrap_err().to_string();
            assert!(said.contains("expected 100 of element vertex"), "{said}");
            assert!(said.contains("the end of the file in number 7"), "{said}");
            numbers[3][0] = f64::INFINITY;
            let bytes = file(order, &numbers);
            numbers[3][0] = 3.0;
            let said = records.points_mm(&bytes[records.first_byte()..], 0).unwrap_err();
            assert!(said.to_string().contains("expected finite coordinates"), "{said}");
        }
    }

    #[test]
    fn files_that_go_on_are_refused_by_their_length() {
        let records = |bytes: &[u8]| {
            VertexRecords::found_in(bytes, &TextOptions::default()).unwrap().unwrap()
        };
        let bytes = file("little", &[[1.0; 3]; 2]);
        let length = bytes.len() as u64;
        assert!((0..=length).all(|length| records(&bytes).check_length(length).is_ok()));
        let said = records(&bytes).check_length(length + 21).unwrap_err().to_string();
        let place = format!("PLY file, byte {length}: expected the end of the file after 0 of");
        assert!(
            said.starts_with(&place) && said.contains("found 21 more bytes: a count"),
            "{said}"
        );
        // The bytes of lists stand in the lists alone.
        let text = String::from_utf8_lossy(&bytes).replace("face 0", "face 1");
        assert!(records(text.as_bytes()).check_length(1 << 40).is_ok());
        let fixed = text.replace("list uchar int vertex_indices", "int a");
        let end = fixed.find("end_header").unwrap() as u64 + 11 + 2 * 21 + 4;
        assert!(records(fixed.as_bytes()).check_length(end).is_ok());
        assert!(records(fixed.as_bytes()).check_length(end + 1).is_err());
    }

    #[test]
    fn other_files_are_taken_whole() {
        let none = |bytes: &[u8]| {
            VertexRecords::found_in(bytes, &TextOptions::default())
                .is_ok_and(|found| found.is_none())
        };
        assert!(none(b"1 2 3\n") && none(b"ply\nformat ascii 1.0\n"));
        let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                    property float z\nend_header\n0 0 0\n";
        assert!(none(text.as_bytes()));
        let binary = text.replace("ascii", "binary_little_endian");
        assert!(!none(binary.as_bytes()));
        assert!(none(binary.replace("float z", "float z\nproperty list uchar int a").as_bytes()));
        assert!(none(binary.replace("vertex 1", "other 0\nelement vertex 1").as_bytes()));
        let header = binary.replace("float z", "float w");
        assert!(VertexRecords::found_in(header.as_bytes(), &TextOptions::default()).is_err());
    }
}
