//! Borders of black and white images.

use crate::PlaceMm;

/// The borders of the set pixels of an image, as lines round them: the middles of the sides between a set and an unset pixel, in order.
///
/// Pixels come row by row from the top; a pixel is `pixel_mm` wide, x goes to the right and y up from the lower left corner of the image.
/// Shapes lie on the left, so outlines run counter-clockwise and holes clockwise. Pixels that touch at a corner only are not joined.
/// Beyond the image nothing is set. Linear time.
///
/// # Panics
///
/// If there are fewer pixels than rows times columns.
pub fn borders(set: &[bool], columns: usize, rows: usize, pixel_mm: f64) -> Vec<Vec<PlaceMm>> {
    let is_set = |column: i64, row: i64| {
        let inside = (0..columns as i64).contains(&column) && (0..rows as i64).contains(&row);
        // Rows count from below.
        inside && set[(rows as i64 - 1 - row) as usize * columns + column as usize]
    };
    // A side from a corner in a direction (0 right, 1 up, 2 left, 3 down) has the pixel on its left set and that on its right not.
    let is_side = |[x, y]: [i64; 2], direction: usize| {
        let [left, right] = match direction {
            0 => [[x, y], [x, y - 1]],
            1 => [[x - 1, y], [x, y]],
            2 => [[x - 1, y - 1], [x - 1, y]],
            _ => [[x, y - 1], [x - 1, y - 1]],
        };
        is_set(left[0], left[1]) && !is_set(right[0], right[1])
    };
    let ahead = |[x, y]: [i64; 2], direction: usize| {
        let (dx, dy) = [(1, 0), (0, 1), (-1, 0), (0, -1)][direction];
        [x + dx, y + dy]
    };
    let width = columns + 1;
    // Every line has a side that goes right: below its lowest pixel, or above a hole.
    let mut is_done = vec![false; width * (rows + 1)];
    let mut lines = Vec::new();
    for y in 0..=rows as i64 {
        for x in 0..columns as i64 {
            if is_done[y as usize * width + x as usize] || !is_side([x, y], 0) {
                continue;
            }
            let mut line = Vec::new();
            let (mut corner, mut direction) = ([x, y], 0);
            loop {
                if direction == 0 {
                    is_done[corner[1] as usize * width + corner[0] as usize] = true;
                }
                let next = ahead(corner, direction);
                let middle = [0, 1].map(|axis| 0.5 * (corner[axis] + next[axis]) as f64 * pixel_mm);
                line.push(middle);
                corner = next;
                // Left first: at a corner where two pixels touch the line stays with its own.
                let turns = [direction + 1, direction, direction + 3].map(|turn| turn % 4);
                direction =
                    turns.into_iter().find(|&turn| is_side(corner, turn)).unwrap_or(direction);
                if corner == [x, y] && direction == 0 {
                    break;
                }
            }
            lines.push(line);
        }
    }
    lines
}
