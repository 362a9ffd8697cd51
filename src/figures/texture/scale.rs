//! Scale-limited surfaces.

use super::{Datum, Filtered, Gaussian, Grid, Mesh, TextureError};

/// The nesting indices of a scale-limited surface, as the filters that set them (ISO 25178-2:2021, 3.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    pub(super) s: Option<Gaussian>,
    pub(super) l: Option<Gaussian>,
}

/// Kind of a scale-limited surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScaleKind {
    /// Neither filter: all wavelengths that were measured.
    Unlimited,
    /// The S-F surface: without the short waves and without form.
    SF,
    /// The S-L surface: besides without the long waves. Without an S-filter the spacing of the nodes is
    /// the limit below.
    SL,
}

/// A surface between two scales.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaleLimited<T> {
    /// What remains.
    pub surface: T,
    /// Kind of surface.
    pub kind: ScaleKind,
    /// Form removed before the filters.
    pub f_operation: Datum,
    /// Result of the S-filter, which removes short waves.
    pub s: Option<Filtered<T>>,
    /// Result of the L-filter: the long waves that were subtracted.
    pub l: Option<Filtered<T>>,
}

impl Scale {
    /// An S-filter against short waves, an L-filter against long ones, or either. Fails unless the cut-off
    /// of the first is below that of the second.
    pub fn new(s: Option<Gaussian>, l: Option<Gaussian>) -> Result<Scale, TextureError> {
        if let (Some(s), Some(l)) = (s, l) {
            let (s_mm, l_mm) = (s.cutoff_mm(), l.cutoff_mm());
            if s_mm >= l_mm {
                return Err(TextureError::Scale { s_mm, l_mm });
            }
        }
        Ok(Scale { s, l })
    }

    /// Nesting index of the S-filter in mm.
    pub fn s_mm(&self) -> Option<f64> {
        self.s.map(|filter| filter.cutoff_mm())
    }

    /// Nesting index of the L-filter in mm.
    pub fn l_mm(&self) -> Option<f64> {
        self.l.map(|filter| filter.cutoff_mm())
    }

    /// The surface between the scales: `f_operation`, then the S-filter, then less the long waves of that.
    /// If the form was removed before, `f_operation` is [`Datum::AsGiven`]. Cost of the filters.
    pub fn of_grid(&self, grid: &Grid, f_operation: Datum) -> ScaleLimited<Grid> {
        let formless = grid.levelled(f_operation);
        let s = self.s.map(|filter| filter.of_grid(&formless));
        let smooth = s.as_ref().map_or(&formless, |filtered| &filtered.surface);
        let l = self.l.map(|filter| filter.of_grid(smooth));
        let surface = l.as_ref().map_or_else(|| smooth.clone(), |l| smooth.less(&l.surface));
        ScaleLimited { surface, kind: self.kind(), f_operation, s, l }
    }

    /// Counterpart for a mesh.
    pub fn of_mesh(&self, mesh: &Mesh, f_operation: Datum) -> ScaleLimited<Mesh> {
        self.of(mesh, f_operation, Gaussian::of_mesh)
    }

    /// Counterpart by [`Gaussian::of_dense_mesh`].
    pub fn of_dense_mesh(&self, mesh: &Mesh, f_operation: Datum) -> ScaleLimited<Mesh> {
        self.of(mesh, f_operation, Gaussian::of_dense_mesh)
    }

    fn of(
        &self,
        mesh: &Mesh,
        f_operation: Datum,
        run: fn(&Gaussian, &Mesh) -> Filtered<Mesh>,
    ) -> ScaleLimited<Mesh> {
        let formless = mesh.levelled(f_operation);
        let s = self.s.map(|filter| run(&filter, &formless));
        let smooth = s.as_ref().map_or(&formless, |filtered| &filtered.surface);
        let l = self.l.map(|filter| run(&filter, smooth));
        let surface = l.as_ref().map_or_else(|| smooth.clone(), |l| smooth.less(&l.surface));
        ScaleLimited { surface, kind: self.kind(), f_operation, s, l }
    }

    fn kind(&self) -> ScaleKind {
        match (self.s, self.l) {
            (None, None) => ScaleKind::Unlimited,
            (Some(_), None) => ScaleKind::SF,
            (_, Some(_)) => ScaleKind::SL,
        }
    }
}
