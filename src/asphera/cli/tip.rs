//! The ball tip that measured the points of a file.

use clap::Args;

use super::output::Failure;
use super::source::{Content, Source};
use super::usage::misused;
use asphera_measure::{Along, Tip, TipReads};

#[derive(Args, Clone, Copy, Debug)]
pub(super) struct TipArgs {
    /// Radius of the ball tip that measured the points of a file, mm: its contacts with the surface are measured then. A
    /// session states it itself, in its table [tip].
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    tip_radius: Option<f64>,
    /// Standard uncertainty of that radius, mm.
    #[arg(
        long,
        value_name = "MM",
        requires = "tip_radius",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    tip_u_radius: f64,
    /// Heights are those of the centre of the ball, not of its lowest point.
    #[arg(long, requires = "tip_radius")]
    tip_centre: bool,
}

impl TipArgs {
    /// The tip, where there is one, for points that are projected along a direction.
    ///
    /// # Errors
    ///
    /// When it is none, or does not suit the points.
    pub(super) fn tip(&self, source: &Source, along: Along) -> Result<Option<Tip>, Failure> {
        let session_tip = match source.content() {
            Content::Session(session) => session.tip(),
            Content::File(_) => None,
        };
        let path = source.path().display();
        let Some(radius_mm) = self.tip_radius else {
            if session_tip.is_some() && !along.suits_tip() {
                return Err(refused_along(&format!("the table [tip] of {path}")));
            }
            return Ok(session_tip);
        };
        let reads = if self.tip_centre { TipReads::Centre } else { TipReads::Lowest };
        let tip = Tip::new(radius_mm, self.tip_u_radius, reads)
            .map_err(|error| misused(format!("--tip-radius: {error}")))?;
        match source.content() {
            Content::Session(_) => Err(misused(format!(
                "--tip-radius: {path} is a recording, which states its tip itself: leave out --tip-radius, or write its points \
                     to a file with asphera export"
            ))),
            Content::File(topography) if !topography.slopes().is_empty() => Err(misused(format!(
                "--tip-radius: {path} holds slopes, which no ball measures: leave out --tip-radius"
            ))),
            Content::File(_) if !along.suits_tip() => Err(refused_along("--tip-radius")),
            Content::File(_) => Ok(Some(tip)),
        }
    }

    /// Fails where a tip is given for points that no ball measured.
    pub(super) fn refuse(&self, what: &str) -> Result<(), Failure> {
        match self.tip_radius {
            Some(_) => {
                Err(misused(format!("--tip-radius: {what}, which no ball measures: leave it out")))
            }
            None => Ok(()),
        }
    }
}

fn refused_along(what: &str) -> Failure {
    misused(format!(
        "{what}: expected --along z, fitted or nx,ny,nz with nz above 0, for contacts of a ball need a plane seen from above; found \
         points that are meshed in space, or a plane seen from below"
    ))
}
