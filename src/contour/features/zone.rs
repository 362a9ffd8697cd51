//! The minimum zone of points round a circle.

use crate::PlaceMm;

/// Two circles about one centre that hold all points between them, as near to each other as can be (ISO 12181-1, MZCI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MinimumZone {
    /// Their centre, mm.
    pub centre_mm: PlaceMm,
    /// The mean of their radii, mm.
    pub radius_mm: f64,
    /// The difference of their radii: the roundness, mm.
    pub width_mm: f64,
}

/// The minimum zone of points, from a circle near them; none of fewer than four points, or where the search does not end.
///
/// About a centre, the deviations are d - a·cos θ - b·sin θ - c, with d the distance less the radius. The largest is made least by
/// exchange (E. Ya. Remez 1934): any three such functions have a solution with four extremes of alternating sign in the order of θ. Then the
/// centre is moved by (a, b), and so on until that no longer changes anything. Time n for every exchange.
pub fn minimum_zone(
    points_mm: &[PlaceMm],
    centre_mm: PlaceMm,
    radius_mm: f64,
) -> Option<MinimumZone> {
    if points_mm.len() < 4 {
        return None;
    }
    let (mut centre, mut radius) = (centre_mm, radius_mm);
    let mut best: Option<MinimumZone> = None;
    for _ in 0..MOST_STEPS {
        let polar: Vec<[f64; 3]> = points_mm
            .iter()
            .map(|place| {
                let [x, y] = [place[0] - centre[0], place[1] - centre[1]];
                let distance = x.hypot(y);
                [x / distance, y / distance, distance - radius]
            })
            .collect();
        let [a, b, c] = exchanged(&polar)?;
        centre = [centre[0] + a, centre[1] + b];
        radius += c;
        let width_mm = width(points_mm, centre);
        let is_better = best.is_none_or(|best| width_mm < best.width_mm);
        if is_better {
            best = Some(MinimumZone { centre_mm: centre, radius_mm: radius, width_mm });
        }
        if a.abs().max(b.abs()) <= 1e-13 * radius || !is_better {
            break;
        }
    }
    best
}

fn width(points_mm: &[PlaceMm], centre: PlaceMm) -> f64 {
    let (low, high) = points_mm.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), place| {
        let distance = (place[0] - centre[0]).hypot(place[1] - centre[1]);
        (low.min(distance), high.max(distance))
    });
    high - low
}

/// The terms of cosine, sine and one that make the largest deviation least; points are their cosine, sine and deviation.
fn exchanged(polar: &[[f64; 3]]) -> Option<[f64; 3]> {
    let mut order: Vec<usize> = (0..polar.len()).collect();
    let angle = |index: usize| polar[index][1].atan2(polar[index][0]);
    order.sort_by(|&p, &q| angle(p).total_cmp(&angle(q)).then(p.cmp(&q)));
    let quarter = |part: usize| part * (order.len() - 1) / 3;
    // Places in `order` of the four extremes.
    let mut chosen = [0, 1, 2, 3].map(quarter);
    for _ in 0..MOST_EXCHANGES {
        let rows = chosen.map(|place| polar[order[place]]);
        let [a, b, c, level] = levelled(rows)?;
        let left = |place: usize| {
            let [cosine, sine, deviation] = polar[order[place]];
            deviation - a * cosine - b * sine - c
        };
        let worst = (0..order.len()).fold(0, |worst, place| {
            if left(place).abs() > left(worst).abs() { place } else { worst }
        });
        let scale = polar.iter().fold(0.0_f64, |most, row| most.max(row[2].abs()));
        if left(worst).abs() <= level.abs() * (1.0 + 1e-12) + 1e-16 * scale {
            return Some([a, b, c]);
        }
        chosen = replaced(chosen, worst, |place| left(place) > 0.0)?;
    }
    None
}

/// Four places with one exchanged for another so that signs still alternate.
fn replaced(
    chosen: [usize; 4],
    new: usize,
    is_above: impl Fn(usize) -> bool,
) -> Option<[usize; 4]> {
    if chosen.contains(&new) {
        return None;
    }
    let mut four = chosen;
    let after = chosen.iter().position(|&place| place > new);
    let same = |place: usize| is_above(place) == is_above(new);
    match after {
        // Between two, one of them has its sign.
        Some(index) if index > 0 => {
            let index = if same(chosen[index]) { index } else { index - 1 };
            four[index] = new;
        }
        Some(_) if same(chosen[0]) => four[0] = new,
        Some(_) => four = [new, chosen[0], chosen[1], chosen[2]],
        None if same(chosen[3]) => four[3] = new,
        None => four = [chosen[1], chosen[2], chosen[3], new],
    }
    Some(four)
}

/// The terms with which four deviations are equal with alternating signs, and their size.
fn levelled(rows: [[f64; 3]; 4]) -> Option<[f64; 4]> {
    let mut m = [[0.0; 5]; 4];
    for (index, ([cosine, sine, deviation], row)) in rows.into_iter().zip(&mut m).enumerate() {
        let sign = if index % 2 == 0 { 1.0 } else { -1.0 };
        *row = [cosine, sine, 1.0, sign, deviation];
    }
    for column in 0..4 {
        let pivot = (column..4).fold(column, |best, row| {
            if m[row][column].abs() > m[best][column].abs() { row } else { best }
        });
        m.swap(column, pivot);
        let lead = m[column];
        if lead[column].abs() < 1e-14 {
            return None;
        }
        for row in (0..4).filter(|&row| row != column) {
            let share = m[row][column] / lead[column];
            for (value, lead) in m[row].iter_mut().zip(lead) {
                *value -= share * lead;
            }
        }
    }
    Some([0, 1, 2, 3].map(|index| m[index][4] / m[index][index]))
}

/// Most moves of the centre; each squares what is missing.
const MOST_STEPS: usize = 20;
/// Most exchanges about one centre.
const MOST_EXCHANGES: usize = 200;
