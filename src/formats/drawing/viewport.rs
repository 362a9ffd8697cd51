//! Viewports of SVG within others.

use super::affine::Affine;

/// The map of the content of a viewport, which has a place and a size, to what is about it: a view box fills it as `ratio`, the attribute
/// `preserveAspectRatio`, says (SVG 2, 8.2, "equivalent transform of an SVG viewport"). `None` where that is not understood.
pub(super) fn map(
    [x, y]: [f64; 2],
    size: [f64; 2],
    [left, top, width, height]: [f64; 4],
    ratio: &str,
) -> Option<Affine> {
    let mut words = ratio.split_whitespace();
    let (align, way) = (words.next().unwrap_or("xMidYMid"), words.next().unwrap_or("meet"));
    let mut scale = [size[0] / width, size[1] / height];
    let mut shares = [0.0; 2];
    if align != "none" {
        let both = match way {
            "meet" => scale[0].min(scale[1]),
            "slice" => scale[0].max(scale[1]),
            _ => return None,
        };
        scale = [both; 2];
        shares = [share(align.get(..4)?, "x")?, share(align.get(4..)?, "Y")?];
    }
    let room = [size[0] - width * scale[0], size[1] - height * scale[1]];
    Some(Affine([
        scale[0],
        0.0,
        0.0,
        scale[1],
        x - left * scale[0] + shares[0] * room[0],
        y - top * scale[1] + shares[1] * room[1],
    ]))
}

/// The share of the room that lies before the view box along an axis.
fn share(word: &str, axis: &str) -> Option<f64> {
    match word.strip_prefix(axis)? {
        "Min" => Some(0.0),
        "Mid" => Some(0.5),
        "Max" => Some(1.0),
        _ => None,
    }
}
