//! The page's files, embedded in the binary.

use axum::http::header;
use axum::response::{IntoResponse, Response};

/// One file of the page.
pub(super) struct Asset {
    /// Path below `/assets/`.
    path: &'static str,
    media_type: &'static str,
    bytes: &'static [u8],
}

/// The page itself.
pub(super) fn index() -> Asset {
    Asset { path: "index.html", media_type: HTML, bytes: include_bytes!("page/index.html") }
}

/// The file at `path` below `/assets/`.
pub(super) fn find(path: &str) -> Option<&'static Asset> {
    ASSETS.iter().find(|asset| asset.path == path)
}

impl IntoResponse for &Asset {
    fn into_response(self) -> Response {
        ([(header::CONTENT_TYPE, self.media_type)], self.bytes).into_response()
    }
}

impl IntoResponse for Asset {
    fn into_response(self) -> Response {
        (&self).into_response()
    }
}

macro_rules! assets {
    ($($media_type:ident $path:literal),* $(,)?) => {
        &[$(Asset {
            path: $path,
            media_type: $media_type,
            bytes: include_bytes!(concat!("page/", $path)),
        }),*]
    };
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml";

const ASSETS: &[Asset] = assets![
    CSS "app.css",
    JS "axes.js",
    JS "bars.js",
    JS "chapters.js",
    JS "colours.js",
    JS "contour.js",
    JS "parts.js",
    JS "control.js",
    JS "defects.js",
    JS "dom.js",
    SVG "favicon.svg",
    JS "files.js",
    JS "format.js",
    JS "frames.js",
    JS "histogram.js",
    JS "knots.js",
    JS "lattice.js",
    JS "layers.js",
    JS "light.js",
    JS "links.js",
    JS "main.js",
    JS "map.js",
    JS "maps.js",
    JS "overlay.js",
    JS "pieces.js",
    JS "plots.js",
    JS "profile.js",
    JS "progress.js",
    JS "regions.js",
    JS "removal.js",
    JS "scan.js",
    JS "section.js",
    JS "series.js",
    JS "sessions.js",
    JS "slice.js",
    JS "solid.js",
    JS "spectrum.js",
    JS "stream.js",
    JS "token.js",
    JS "verdict.js",
    JS "volume.js",
    JS "zernike.js",
    JS "vendor/uplot-1.6.32/uPlot.iife.min.js",
    CSS "vendor/uplot-1.6.32/uPlot.min.css",
];
