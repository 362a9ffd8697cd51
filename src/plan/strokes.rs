//! Places of a lattice as lines that are run at one speed, in a short order.

use crate::piece::distance_mm;
use crate::{Piece, Spacing};

/// Lines along x through places that follow each other by a step, from where the probe stands.
///
/// Each group has a step of its own in mm and its places. A place alone is a stop. From one line the probe goes to the nearest end of another;
/// of equally near ones to that with the lower y, then x. It begins there. Takes time by the square of the lines.
pub fn strokes(from_mm: [f64; 2], groups: &[(f64, Vec<[f64; 2]>)]) -> Vec<(Piece, Spacing)> {
    let mut lines: Vec<Line> = Vec::new();
    for (step_mm, places) in groups {
        let mut places = places.clone();
        places.sort_by(|p, q| p[1].total_cmp(&q[1]).then(p[0].total_cmp(&q[0])));
        for place in places {
            let slack = 1e-6 * step_mm;
            match lines.last_mut() {
                Some(line) if line.step_mm == *step_mm && line.continues(place, slack) => {
                    line.to = place;
                }
                _ => lines.push(Line { from: place, to: place, step_mm: *step_mm }),
            }
        }
    }
    lines.sort_by(|p, q| p.from[1].total_cmp(&q.from[1]).then(p.from[0].total_cmp(&q.from[0])));
    let mut at = from_mm;
    let mut found = Vec::with_capacity(lines.len());
    while !lines.is_empty() {
        let ends = |line: &Line| [line.from, line.to].map(|end| distance_mm(at, end));
        let near = |line: &Line| ends(line)[0].min(ends(line)[1]);
        let Some(index) =
            (0..lines.len()).min_by(|&i, &j| near(&lines[i]).total_cmp(&near(&lines[j])))
        else {
            break;
        };
        let line = lines.remove(index);
        let [first, last] = ends(&line);
        let [from, to] = if last < first { [line.to, line.from] } else { [line.from, line.to] };
        let piece = match from == to {
            true => Piece::Stop { at_mm: from },
            false => Piece::Line { from_mm: from, to_mm: to },
        };
        found.push((piece, Spacing::AtMost { mm: line.step_mm * (1.0 + 1e-6) }));
        at = to;
    }
    found
}

struct Line {
    from: [f64; 2],
    to: [f64; 2],
    step_mm: f64,
}

impl Line {
    /// Whether a place is one step farther along x.
    fn continues(&self, [x, y]: [f64; 2], slack: f64) -> bool {
        (y - self.to[1]).abs() <= slack && (x - self.to[0] - self.step_mm).abs() <= slack
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_lines_there_and_back() {
        let places: Vec<[f64; 2]> =
            (0..12).map(|k| [f64::from(k % 4), f64::from(k / 4)]).chain([[9.0, 0.0]]).collect();
        let found = strokes([0.0, -1.0], &[(1.0, places)]);
        let line = |a: [f64; 2], b: [f64; 2]| Piece::Line { from_mm: a, to_mm: b };
        let pieces: Vec<Piece> = found.iter().map(|&(piece, _)| piece).collect();
        assert_eq!(
            pieces,
            [
                line([0.0, 0.0], [3.0, 0.0]),
                line([3.0, 1.0], [0.0, 1.0]),
                line([0.0, 2.0], [3.0, 2.0]),
                Piece::Stop { at_mm: [9.0, 0.0] },
            ]
        );
        assert!(strokes([0.0, 0.0], &[]).is_empty());
    }
}
