//! HTTP, WebSocket and the live page: what the network sees of a station.
//!
//! | Route | Answer |
//! |---|---|
//! | `GET /`, `GET /assets/…` | the page, embedded in the binary |
//! | `GET /api/v1/snapshot` | the newest [`Snapshot`](asphera_report::Snapshot) as JSON |
//! | `GET /api/v1/stream` | WebSocket: every new snapshot as JSON text, the newest wins |
//! | `GET /api/v1/mesh.ply` | the mesh; 404 while there is none |
//! | `GET /api/v1/maps` | the [`SamplingMaps`](asphera_report::SamplingMaps) as JSON, with an `ETag`; 404 while there are none |
//! | `GET /api/v1/parts` | the [`SessionParts`](asphera_report::parts::SessionParts) as JSON; 404 while there are none |
//! | `GET /api/v1/contour` | the [`SessionContour`](asphera_report::contour::SessionContour) as JSON; 404 while there is none |
//! | `GET /api/v1/volume`, `…/volume/slice?axis=z&index=N` | the [`VolumeView`](asphera_report::VolumeView) and a [`VolumeSlice`](asphera_report::VolumeSlice) as JSON; 404 without a volume |
//! | `GET /api/v1/form?remove=tilt,power` | the [`FormView`](asphera_report::FormView) as JSON: the deviation without Zernike terms; 404 while there is none |
//! | `GET /api/v1/section?…` | the [`SectionReport`](asphera_report::SectionReport) of the mesh as it is now: see below |
//! | `GET /api/v1/waypoints.csv` | where to measure next: `region,x_mm,y_mm,z_mm`, measured frame; 404 while nothing is known |
//! | `GET /api/v1/report` | the [`Report`](asphera_report::Report) as JSON; 404 while there is none |
//! | `GET /api/v1/links` | the links of the newest snapshot |
//! | `GET /api/v1/health` | that the daemon answers, its version and state |
//! | a path of [`Server::with_text`] | the newest snapshot as the text of another front |
//! | `POST /api/v1/session/start`, `…/stop` | 204; 409 where the station's state forbids it |
//!
//! A section goes along exactly one of `line=X1,Y1,X2,Y2`, `circle=X,Y,R` and `radius=DEG`, the last from
//! `centre=X,Y` or else from the centre of the nominal as fitted. Lengths are mm in the measured frame; where
//! the projection is not along z, `u` and `v` of its plane stand for x and y, in the answer too.
//!
//! Who may do what:
//! - Every request names a trusted host (`localhost`, an IP literal or an allowed name), so that a
//!   foreign web site cannot reach the station by rebinding its own name to this address.
//! - A browser's `Origin` must be the host itself, on reads, controls and WebSockets alike.
//! - Controls need `Authorization: Bearer TOKEN`. Reads need it only from another machine. A browser
//!   cannot set that header on a WebSocket: there the token is the subprotocol `asphera.token.TOKEN`.
//!
//! Errors are JSON: `{"error", "expected", "found", "hint"}`, the last three null where empty.
//!
//! This module deliberately has no encryption: off loopback it belongs behind a TLS proxy. It sees a
//! station only through [`Station`](asphera_report::LiveStation), never a link or a driver.

mod api;
mod assets;
mod connections;
mod encoder;
mod files;
mod guard;
#[cfg(any(test, feature = "fuzzing"))]
mod in_process;
mod problem;
mod query;
mod server;
mod stream;
mod token;
mod turns;

#[cfg(test)]
mod tests;

#[cfg(any(test, feature = "fuzzing"))]
pub use in_process::InProcess;
pub use server::{BindError, Limits, Server, TextRoute};
pub use token::{Token, TokenError};
