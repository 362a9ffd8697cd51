//! What asphera says of a measurement: the types of every output, and what a front asks of a station.
//!
//! One set of types serves the report file, the snapshots of the page and `--json`: what is shown live and what is kept have
//! the same names, units and meaning. Nothing here computes a figure, and no kernel is named.
//!
//! - [`Report`]: the final figures of one part.
//! - [`Snapshot`]: the state of a station now, with [`SamplingMaps`] and [`FormView`] for those who look at them.
//! - [`SectionReport`]: a cut through the surface; [`contour`]: a curve or an area found from points.
//! - [`LiveStation`]: what a front may ask while a session runs; [`Measured`]: what a document may ask when it has ended.

mod chain;
pub mod contour;
mod deviation;
mod face;
mod features;
mod figure_name;
mod figures;
mod files;
mod fit;
mod fit_details;
mod form;
mod label;
mod links;
mod measured;
mod mesh;
pub mod parts;
mod pose;
mod profile;
mod prospect;
mod reading;
mod reconstruction;
mod refusal;
mod report;
mod sampling;
mod scan;
mod section;
mod snapshot;
pub mod standards;
mod station;
pub mod systematic;
mod tip;
mod unmeasured;
mod verdict;
mod view;
mod views;
mod volume;
mod weights;
pub mod words;

pub use chain::error_chain;
pub use deviation::{DeviationFigures, UncertaintyFigures};
pub use face::{FaceFigures, FacesFigures, SecondFigures};
pub use features::{DefectFigures, DefectSearchFigures, FeatureFigures, PartitionFigures};
pub use figure_name::FigureName;
pub use figures::{
    ExpandedFigures, FormFigure, HistogramFigures, OriginFigures, RingFigures, SimulatedFigures,
    Source, ZernikeFigures, ZernikeTerm,
};
pub use files::ResultFile;
pub use fit::{FitFigures, ParameterFigures};
pub use fit_details::{
    CautionFigures, CombinationFigures, CorrelationFigures, CovarianceFigures, FitDetails,
    ShareFigures, UndeterminedFigures,
};
pub use form::FormFigures;
pub use label::Label;
pub use links::{ChannelFigures, ClockFigures, DeviceFigures, LinkFigures, PlaceFigures};
pub use measured::{Measured, Picture};
pub use mesh::{
    MeshFigures, PlaneFigures, ProjectionFigures, RegionFigures, ReliefFigures, RepeatFigures,
};
pub use pose::PoseFigures;
pub use profile::ProfileFigures;
pub use prospect::{Outlook, ProspectFigures, ProspectState};
pub use reading::{ColumnFigures, ReadingFigures};
pub use reconstruction::{BorderFigures, ReconstructionFigures};
pub use refusal::Refusal;
pub use report::{
    CalibrationFigures, Points, REPORT_FORMAT, Report, SessionFigures, ThermalFigures, Timing,
};
pub use sampling::{CurrentFigures, NextFigures, PolygonFigures, SamplingFigures};
pub use scan::ScanFigures;
pub use section::{
    CircleFigures, Columns, Cut, DeviationProfile, HeightFigures, LineFigures, PathFigures,
    PieceFigures, SECTION_FORMAT, SectionReport, SectionRequest,
};
pub use snapshot::{
    Backlog, Connection, Convergence, LinkState, Outputs, Progress, SNAPSHOT_FORMAT, Snapshot,
    State, Waiting,
};
pub use standards::StandardFigures;
pub use station::{Answer, ControlError, LiveStation, SessionEntry, SessionFile, Waypoints};
pub use systematic::SystematicFigures;
pub use tip::TipFigures;
pub use unmeasured::UnmeasuredFigures;
pub use verdict::{Check, Status, Verdict};
pub use view::{Block, Chapter, ChapterId, Column, Fact, Layout, Table, View, columns};
pub use views::{
    FORM_VIEW_FORMAT, FormView, FormViewAnswer, MAPS_FORMAT, Map, MapLayer, MapsState, RemovedTerm,
    SamplingMaps, Term,
};
pub use volume::{
    CellKind, CellView, FaceView, GridView, SliceAnswer, SliceAxis, SliceRequest,
    VOLUME_SLICE_FORMAT, VOLUME_VIEW_FORMAT, VolumeSlice, VolumeState, VolumeView,
};
pub use weights::{LossFigures, ReferenceFigures, WeightFigures};
