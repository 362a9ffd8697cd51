//! Volumes written as NRRD.

use std::io::{self, Write};

use super::Frame;
use crate::WriteError;

/// Writes whole numbers as a raw NRRD file, little-endian, its frame in mm. `values` come x fastest.
///
/// # Errors
///
/// When there are not as many values as the size says, and when the destination fails.
pub fn write_nrrd(
    mut out: impl Write,
    size: [usize; 3],
    values: &[u16],
    frame: &Frame,
) -> Result<(), WriteError> {
    let expected: usize = size.iter().product();
    if values.len() != expected {
        return Err(WriteError::Invalid {
            what: "a volume".into(),
            expected: format!("{expected} samples"),
            found: values.len().to_string(),
        });
    }
    let vector = |[x, y, z]: [f64; 3]| format!("({x:?},{y:?},{z:?})");
    let [x, y, z] = frame.steps_mm.map(vector);
    let header = format!(
        "NRRD0004\ntype: uint16\ndimension: 3\nsizes: {} {} {}\nspace dimension: 3\nspace directions: {x} {y} {z}\n\
         space origin: {}\nspace units: \"mm\" \"mm\" \"mm\"\nkinds: domain domain domain\nendian: little\nencoding: raw\n\n",
        size[0],
        size[1],
        size[2],
        vector(frame.origin_mm)
    );
    let failed = |source: io::Error| WriteError::Io { what: "a volume", source };
    out.write_all(header.as_bytes()).map_err(failed)?;
    for some in values.chunks(SOME) {
        let bytes: Vec<u8> = some.iter().flat_map(|value| value.to_le_bytes()).collect();
        out.write_all(&bytes).map_err(failed)?;
    }
    out.flush().map_err(failed)
}

/// Samples that are turned into bytes at a time.
const SOME: usize = 1 << 16;

#[cfg(test)]
mod tests {
    use super::super::{UnitKnown, Values, read};
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let steps_mm = [[0.02, 0.0, 0.0], [0.0, 0.0, 0.03], [0.0, -0.05, 1e-7]];
        let frame = Frame { origin_mm: [-1.5, 0.25, 1e-9], steps_mm, unit: UnitKnown::Stated };
        let values: Vec<u16> = (0..60).map(|i| i * 1091).collect();
        let mut bytes = Vec::new();
        write_nrrd(&mut bytes, [5, 4, 3], &values, &frame).unwrap();
        let found = read("a.nrrd", &bytes, &mut |_| Err("none".into())).unwrap();
        assert_eq!((found.size, found.frame), ([5, 4, 3], frame));
        let floats: Vec<f32> = values.iter().copied().map(f32::from).collect();
        assert_eq!(found.values, Values::Floats(floats));
        assert!(write_nrrd(Vec::new(), [5, 4, 4], &values, &frame).is_err());
    }
}
