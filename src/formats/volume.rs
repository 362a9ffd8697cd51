//! Volumes: samples on a grid in space, as CT, OCT and confocal microscopes leave them.
//!
//! | format | source | read |
//! |---|---|---|
//! | `.vol` | DGtal, `VolReader` and `LongvolReader`: versions 2 (bytes) and 3 (zlib) | one byte a sample |
//! | NRRD | teem, NRRD0001 to NRRD0005, attached and detached headers | raw, gzip, ascii |
//! | MetaImage | ITK MetaIO, `.mha` and `.mhd` | raw, zlib |
//! | NIfTI | NIfTI-1.1 and NIfTI-2, `.nii`, `.nii.gz`, `.hdr` with `.img` | one volume |
//! | TIFF stack | TIFF 6.0, BigTIFF: a page a slice, or a file a slice ([`read_slices`]) | 8 to 64 bits, LZW, deflate |
//! | `.vti` | VTK, XML ImageData | ascii, base64, appended, zlib |
//! | raw | `part.raw` with `part.toml` beside it: size, type, byte order, spacing | any type |
//! | `.vgi` | Volume Graphics, Nikon: header beside `.vol` or `.raw` | 8 to 32 bits |
//!
//! Samples come with x fastest, then y, then z. The frame is that of the file, in mm. A sample that is not finite is missing.

mod element;
mod header;
mod layout;
mod metaimage;
mod nifti;
mod nrrd;
mod raw;
mod slice_reader;
mod slices;
mod tiff;
mod unpack;
mod vgi;
mod vol;
mod vti;
mod write;

#[cfg(test)]
mod tests;

pub use slice_reader::{MAX_SLICED, OpenFile, SliceReader, Stored};
pub use write::write_nrrd;

use crate::{Format, Place, ReadError, zemax};

/// Most samples of a volume that are read, 2³¹.
pub const MAX_SAMPLES: u64 = 1 << 31;

/// A volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Columns, rows and slices.
    pub size: [usize; 3],
    /// The samples, x fastest.
    pub values: Values,
    /// Where they lie.
    pub frame: Frame,
    /// The format it was read from.
    pub format: Format,
}

/// The samples of a volume.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Bytes, as they were.
    Bytes(Vec<u8>),
    /// Any other type, as single precision: whole numbers above 2²⁴ are rounded.
    Floats(Vec<f32>),
}

impl Values {
    /// The number of samples.
    pub fn len(&self) -> usize {
        match self {
            Values::Bytes(values) => values.len(),
            Values::Floats(values) => values.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All samples in single precision.
    pub fn to_floats(&self) -> Vec<f32> {
        match self {
            Values::Bytes(values) => values.iter().copied().map(f32::from).collect(),
            Values::Floats(values) => values.clone(),
        }
    }
}

/// Where the samples of a volume lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The place of sample (0, 0, 0), mm.
    pub origin_mm: [f64; 3],
    /// The step from a sample to the next along x, y and z, mm.
    pub steps_mm: [[f64; 3]; 3],
    /// Whether the file states the length of the steps and their unit.
    pub unit: UnitKnown,
}

/// How a volume's spacing is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitKnown {
    /// The file states spacing and unit.
    Stated,
    /// The file states a spacing without a unit: mm is assumed.
    Assumed,
    /// The file states no spacing: samples are 1 apart, and the caller must say how far that is.
    Missing,
}

impl Frame {
    /// A frame along the axes, at the origin.
    pub fn aligned(spacing_mm: [f64; 3], unit: UnitKnown) -> Frame {
        let mut steps_mm = [[0.0; 3]; 3];
        (0..3).for_each(|axis| steps_mm[axis][axis] = spacing_mm[axis]);
        Frame { origin_mm: [0.0; 3], steps_mm, unit }
    }

    /// The lengths of the steps, mm.
    pub fn spacing_mm(&self) -> [f64; 3] {
        self.steps_mm.map(|step| step.iter().map(|v| v * v).sum::<f64>().sqrt())
    }

    /// Whether the steps are at right angles, to a thousandth of a degree or so.
    pub fn is_orthogonal(&self) -> bool {
        let spacing = self.spacing_mm();
        [(0, 1), (1, 2), (2, 0)].into_iter().all(|(a, b)| {
            let dot: f64 = (0..3).map(|i| self.steps_mm[a][i] * self.steps_mm[b][i]).sum();
            dot.abs() <= 2e-5 * spacing[a] * spacing[b]
        })
    }

    /// The place of a point given in samples, mm.
    pub fn place_mm(&self, at: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            self.origin_mm[i] + (0..3).map(|axis| at[axis] * self.steps_mm[axis][i]).sum::<f64>()
        })
    }

    /// Whether the frame turns right hands into left hands.
    pub fn is_mirror(&self) -> bool {
        self.volume_mm3() < 0.0
    }

    /// The volume that the steps span, mm³; below 0 where they turn right hands into left hands.
    fn volume_mm3(&self) -> f64 {
        let [a, b, c] = self.steps_mm;
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    }

    /// The frame, if all its figures are finite and its steps span space.
    fn checked(self, format: Format, place: Place) -> Result<Frame, ReadError> {
        let all = self.origin_mm.iter().chain(self.steps_mm.as_flattened());
        let is_finite = all.clone().all(|value| value.is_finite() && value.abs() < 1e12);
        let spacing_mm = self.spacing_mm();
        let is_step = spacing_mm.iter().all(|step| *step > 1e-12);
        let spans = self.volume_mm3().abs() > LEAST_SPAN * spacing_mm.iter().product::<f64>();
        if is_finite && is_step && spans {
            return Ok(self);
        }
        Err(ReadError::Malformed {
            format,
            place,
            expected: "steps between samples above 0 and finite, in three ways that span space"
                .into(),
            found: format!("{:?}", self.steps_mm),
        })
    }
}

/// Steps that span less of a box of their lengths lie in a plane, but for rounding.
const LEAST_SPAN: f64 = 1e-9;

/// Gives the bytes of a file that lies beside the header, by its name without a folder, or says why there are none.
pub type Beside<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, String>;

/// The format of a volume, if the file is one: by its content, or where that is packed by its name.
///
/// Raw samples are known by the files beside them only, so they are none here.
pub fn format_of(name: &str, bytes: &[u8]) -> Option<Format> {
    if nrrd::is_nrrd(bytes) {
        return Some(Format::Nrrd);
    }
    if nifti::is_nifti(bytes) || (unpack::is_gzip(bytes) && nifti::is_packed_name(name)) {
        return Some(Format::Nifti);
    }
    if metaimage::is_metaimage(bytes) {
        return Some(Format::MetaImage);
    }
    if tiff::is_tiff(bytes) {
        return Some(Format::Tiff);
    }
    if vti::is_vti(bytes) {
        return Some(Format::Vti);
    }
    if vgi::is_vgi(bytes) {
        return Some(Format::Vgi);
    }
    if raw::is_side_file(name, bytes) {
        return Some(Format::Raw);
    }
    vol::is_vol(bytes).then_some(Format::Vol)
}

/// Reads a volume.
///
/// `name` tells a packed NIfTI file, and raw samples (`.raw`, `.vol`) whose header lies beside them; nothing else. Headers whose samples
/// lie in another file ask `beside` for it.
///
/// # Errors
///
/// [`ReadError::NoVolume`] where the content is no volume; otherwise what is wrong, and where. Nothing is allocated for a size that is
/// only claimed.
pub fn read(name: &str, bytes: &[u8], beside: Beside<'_>) -> Result<Volume, ReadError> {
    match format_of(name, bytes) {
        Some(Format::Nrrd) => nrrd::read(bytes, beside),
        Some(Format::Nifti) => nifti::read(name, bytes, beside),
        Some(Format::MetaImage) => metaimage::layout(bytes)?.volume(bytes, beside),
        Some(Format::Tiff) => tiff::read(bytes),
        Some(Format::Vti) => vti::read(bytes),
        Some(Format::Vgi) => vgi::read(bytes, None, beside),
        Some(Format::Raw) => raw::layout(name, bytes)?.volume(bytes, beside),
        Some(Format::Vol) => vol::layout(bytes)?.volume(bytes, beside),
        _ => samples_without_header(name, bytes, beside),
    }
}

/// Reads a volume whose slices are files of one page each, TIFF.
///
/// `names` come in any order; their numbers say which slice follows which. `open` is asked for one at a time.
///
/// # Errors
///
/// Names that do not differ in one number alone, a slice that lacks, and whatever is wrong with a slice.
pub fn read_slices(names: &[String], open: Beside<'_>) -> Result<Volume, ReadError> {
    let ordered = slices::ordered(Format::Tiff, names)?;
    let mut stack = tiff::Stack::default();
    for name in &ordered {
        let malformed = |expected: &str, found: String| ReadError::Malformed {
            format: Format::Tiff,
            place: Place::Slice(name.clone()),
            expected: expected.into(),
            found,
        };
        let bytes = open(name).map_err(|why| malformed("a slice", why))?;
        let pages = stack.push(&bytes).map_err(|error| error.in_slice(name))?;
        if pages != 1 && ordered.len() > 1 {
            return Err(malformed("one page a file", pages.to_string()));
        }
        if ordered.len() == 1 {
            stack.check_images(pages)?;
        }
    }
    stack.finish()
}

/// Reads samples whose header lies beside them, by the name of the file: `part.raw` has `part.toml` or `part.vgi`.
fn samples_without_header(
    name: &str,
    bytes: &[u8],
    beside: Beside<'_>,
) -> Result<Volume, ReadError> {
    let extension =
        name.rsplit_once('.').map_or("", |(_, extension)| extension).to_ascii_lowercase();
    let none = || match zemax::is_zemax(bytes) {
        true => ReadError::Lens { name: name.into() },
        false => ReadError::NoVolume { name: name.into(), start: crate::error::quoted(bytes) },
    };
    if !["raw", "vol", "bin"].contains(&extension.as_str()) {
        return Err(none());
    }
    let side = format!("{}.toml", stem(name));
    if let Ok(header) = beside(&side) {
        return raw::layout(&side, &header)?.volume_in(bytes);
    }
    match beside(&format!("{}.vgi", stem(name))) {
        Ok(header) if vgi::is_vgi(&header) => vgi::read(&header, Some(bytes), beside),
        _ if extension == "vol" => Err(none()),
        _ => Err(ReadError::Malformed {
            format: Format::Raw,
            place: Place::Byte(0),
            expected: format!("{side} with size, type and byte_order, or a .vgi, beside it"),
            found: "neither".into(),
        }),
    }
}

/// The name of a file without folder and extension.
fn stem(name: &str) -> &str {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    file.rsplit_once('.').map_or(file, |(stem, _)| stem)
}

/// Whether a name that a header gives is that of a file in the same folder.
fn is_beside(file: &str) -> bool {
    !file.is_empty() && file != "." && file != ".." && !file.contains(['/', '\\', ':', '\0'])
}

/// How many samples a size asks for: at least one a side, at most [`MAX_SAMPLES`].
fn sample_count(format: Format, place: Place, size: [u64; 3]) -> Result<usize, ReadError> {
    sample_count_up_to(format, place, size, MAX_SAMPLES).map(|count| count as usize)
}

/// The same where another number is the most.
fn sample_count_up_to(
    format: Format,
    place: Place,
    size: [u64; 3],
    most: u64,
) -> Result<u64, ReadError> {
    if size.contains(&0) {
        return Err(ReadError::Malformed {
            format,
            place,
            expected: "at least one sample a side".into(),
            found: format!("{} × {} × {}", size[0], size[1], size[2]),
        });
    }
    let found = size.iter().fold(1_u64, |all, &side| all.saturating_mul(side));
    if found > most {
        return Err(ReadError::TooLarge { format, place, unit: "samples", limit: most, found });
    }
    Ok(found)
}
