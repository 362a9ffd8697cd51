//! A measured volume to be looked at: levels, the check of its grid, faces with their deviation, slices.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::{Serialize, Serializer};

use crate::{FaceFigures, Refusal};

/// Version of the layout of [`VolumeView`].
pub const VOLUME_VIEW_FORMAT: &str = "asphera.volume-view/1";
/// Version of the layout of [`VolumeSlice`].
pub const VOLUME_SLICE_FORMAT: &str = "asphera.volume-slice/1";

/// Volume that there is to be looked at; it is too large to come with every snapshot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeState {
    /// Columns, rows and slices.
    pub size: [u64; 3],
    /// Figures of the face, for the view.
    #[serde(skip)]
    pub face: Box<FaceFigures>,
}

/// A measured volume. Places in samples count from 0 along columns, rows and slices.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeView {
    /// [`VOLUME_VIEW_FORMAT`].
    pub format: &'static str,
    /// Columns, rows and slices.
    pub size: [u64; 3],
    /// Place of the first sample, mm.
    pub origin_mm: [f64; 3],
    /// Steps from a sample to the next along columns, rows and slices, mm.
    pub steps_mm: [[f64; 3]; 3],
    /// Standard deviation of the Gaussian by which the grey values were smoothed, mm; 0: not at all.
    pub smoothing_mm: f64,
    /// Grey values that slices show as black and as white.
    pub shown_range: [f64; 2],
    /// Grey value of the surface: that of the first face.
    pub threshold: f64,
    /// The check of the grid at that value.
    pub grid: GridView,
    /// The first face, and the second where it was measured.
    pub faces: Vec<FaceView>,
}

/// What the samples tell of the grid (theorems 12 to 14 of Stelldinger, Latecki, Siqueira 2007).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GridView {
    /// Whether a cell contradicts a grid that is fine enough.
    pub contradicted: bool,
    /// Reason in words.
    pub why: String,
    /// Cells of the cases 9 to 14.
    pub forbidden: u64,
    /// Cells of case 8 without a partner.
    pub case8_unpaired: u64,
    /// Faces between cells with diagonal foreground samples.
    pub c1: u64,
    /// Cells in which two samples on a space diagonal stand against six.
    pub c2: u64,
    /// Cells that would have surface but lie beside a sample without a value: the surface is open there.
    pub near_missing: u64,
    /// Places of those at fault, by slice, row and column; at most some hundred.
    pub cells: Vec<CellView>,
    /// How many are not among them.
    pub left_out: u64,
}

/// A cell, or a face between two cells, that is forbidden or critical.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellView {
    /// Kind.
    pub kind: CellKind,
    /// Its middle in samples.
    pub at: [f64; 3],
    /// Its middle, mm.
    pub at_mm: [f64; 3],
    /// Foreground corners as bits x + 2y + 4z; of a cell only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub code: Option<u8>,
}

/// Kind of a place where the grid is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CellKind {
    /// A cell of the cases 9 to 14.
    Forbidden,
    /// A cell of case 8 without its partner.
    Unpaired,
    /// Two foreground samples on the diagonal of a face between cells.
    C1,
    /// Two samples on a space diagonal of a cell against its six others.
    C2,
}

/// A face with its deviation, thinned to what a picture needs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaceView {
    /// Points measured.
    pub points: u64,
    /// Side of the cubes in which points are gathered, spacings; 1: hardly any.
    pub gathered: u64,
    /// Place in samples, and the mean deviation there in nm.
    pub places: Vec<[f64; 4]>,
}

/// Axis across which a volume is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SliceAxis {
    /// The slice holds rows and slices.
    X,
    /// The slice holds columns and slices.
    Y,
    /// The slice holds columns and rows.
    Z,
}

impl SliceAxis {
    /// Every one, in the order of columns, rows and slices.
    pub const ALL: [SliceAxis; 3] = [SliceAxis::X, SliceAxis::Y, SliceAxis::Z];

    /// Number of the axis, from 0.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The axes along the columns and the rows of a slice.
    pub const fn within(self) -> [usize; 2] {
        match self {
            SliceAxis::X => [1, 2],
            SliceAxis::Y => [0, 2],
            SliceAxis::Z => [0, 1],
        }
    }

    /// Its name: `x`, `y` or `z`.
    pub const fn name(self) -> &'static str {
        match self {
            SliceAxis::X => "x",
            SliceAxis::Y => "y",
            SliceAxis::Z => "z",
        }
    }
}

/// A slice that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SliceRequest {
    /// Axis across the slice.
    pub axis: SliceAxis,
    /// Sample along that axis, from 0.
    pub index: u64,
}

/// The answer to a request for a slice: the slice, or why there is none of that number; `None` without a volume.
pub type SliceAnswer = Option<Result<VolumeSlice, Refusal>>;

/// A slice of a volume. Places in it are samples along its columns and rows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeSlice {
    /// [`VOLUME_SLICE_FORMAT`].
    pub format: &'static str,
    /// Axis across the slice.
    pub axis: SliceAxis,
    /// Sample along that axis, from 0.
    pub index: u64,
    /// Columns of the picture.
    pub columns: u64,
    /// Rows of the picture.
    pub rows: u64,
    /// Samples from one pixel to the next: 1, unless the slice is larger than a picture may be.
    pub step: u64,
    /// Pixels row after row, base64: 1 is black, 255 white, 0 a sample without a value.
    #[serde(serialize_with = "as_base64")]
    pub pixels: Vec<u8>,
    /// Where the grey values cross the threshold: pieces of a line by the column and row of both ends.
    pub contour: Vec<[f64; 4]>,
    /// Pieces that are left out, for there are too many.
    pub contour_left_out: u64,
    /// Points of the faces within half a spacing: column, row, deviation in nm.
    pub points: Vec<[f64; 3]>,
    /// Points that are left out.
    pub points_left_out: u64,
}

fn as_base64<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&STANDARD.encode(bytes))
}
