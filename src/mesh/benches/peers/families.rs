//! Orders of arrival that may cost more than the same points shuffled, in families with parameters drawn at random.

use std::f64::consts::{PI, TAU};

use rand_core::Rng;
use rand_pcg::Pcg64;

pub(crate) type Place = [f64; 2];

/// A family: its name, and how one of it is drawn, with its parameters in words.
pub(crate) type Family = (&'static str, fn(&mut Draw, usize) -> (String, Vec<Place>));

pub(crate) const FAMILIES: &[Family] = &[
    ("curve", curve),
    ("curve by bits", curve_by_bits),
    ("star", star),
    ("comb", comb),
    ("parabola", parabola),
    ("facing chains", facing_chains),
    ("spiral in", |draw, count| spiral(draw, count, true)),
    ("spiral out", |draw, count| spiral(draw, count, false)),
    ("logarithmic spiral", logarithmic_spiral),
    ("rings in", |draw, count| rings(draw, count, true)),
    ("rings out", |draw, count| rings(draw, count, false)),
    ("clusters by turns", clusters),
    ("lines by turns", lines_by_turns),
    ("cross", cross),
    ("line, then circle", line_then_circle),
    ("rosette", rosette),
    ("wandering", wandering),
    ("raster from both ends", raster_from_both_ends),
    ("raster, rows by strides", raster_by_strides),
    ("random by x", |draw, count| sorted(draw, count, |[x, _]| x)),
    ("random by angle", |draw, count| sorted(draw, count, |[x, y]| y.atan2(x))),
    ("random from outside", |draw, count| sorted(draw, count, |[x, y]| -x.hypot(y))),
    ("random from inside", |draw, count| sorted(draw, count, |[x, y]| x.hypot(y))),
    ("random by Hilbert", |draw, count| sorted(draw, count, hilbert_key)),
    ("random by bits of Hilbert", |draw, count| by_bits(&sorted(draw, count, hilbert_key).1)),
];

/// Where parameters come from.
pub(crate) struct Draw(pub(crate) Pcg64);

impl Draw {
    /// Evenly from 0 to below 1.
    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// As many tenfold as not.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn whole(&mut self, low: usize, high: usize) -> usize {
        self.scale(low as f64, high as f64 + 1.0) as usize
    }

    fn coin(&mut self) -> bool {
        self.unit() < 0.5
    }

    /// In no order.
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, (self.unit() * (last + 1) as f64) as usize);
        }
    }
}

fn polar(radius: f64, angle: f64) -> Place {
    [radius * angle.cos(), radius * angle.sin()]
}

/// So many points, each at its share of the way.
fn along(count: usize, at: impl Fn(f64) -> Place) -> Vec<Place> {
    (0..count).map(|index| at(index as f64 / count as f64)).collect()
}

fn curve(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (k, m) = (draw.whole(1, 30), draw.whole(1, 60));
    let (a, b) = (draw.between(0.0, 0.5), draw.between(0.0, 0.2));
    let radius = |t: f64| 1.0 + a * (k as f64 * t).cos() + b * (m as f64 * t).sin();
    let places = along(count, |share| polar(radius(TAU * share), TAU * share));
    (format!("r = 1 + {a:.3} cos {k}t + {b:.3} sin {m}t"), places)
}

fn curve_by_bits(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (name, places) = curve(draw, count);
    (name, by_bits(&places).1)
}

fn star(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (spikes, inner) = (draw.whole(3, 300), draw.between(0.05, 0.98));
    let corners = (0..=2 * spikes)
        .map(|i| polar(if i % 2 == 0 { 1.0 } else { inner }, PI * i as f64 / spikes as f64));
    (format!("{spikes} spikes from {inner:.3}"), traced(count, &corners.collect::<Vec<_>>()))
}

fn comb(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (teeth, depth) = (draw.whole(3, 500), draw.scale(0.05, 20.0));
    let corners: Vec<Place> = (0..4 * teeth)
        .map(|i| [(i / 2) as f64 / teeth as f64, if matches!(i % 4, 1 | 2) { depth } else { 0.0 }])
        .collect();
    (format!("{teeth} teeth, depth {depth:.3}"), traced(count, &corners))
}

/// Points evenly along a line from corner to corner.
fn traced(count: usize, corners: &[Place]) -> Vec<Place> {
    let length = |pair: &[Place]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
    let total: f64 = corners.windows(2).map(length).sum();
    let (mut leg, mut passed) = (0, 0.0);
    (0..count)
        .map(|index| {
            let target = total * (index as f64 + 0.5) / count as f64;
            while leg + 2 < corners.len() && passed + length(&corners[leg..leg + 2]) < target {
                passed += length(&corners[leg..leg + 2]);
                leg += 1;
            }
            let share = (target - passed) / length(&corners[leg..leg + 2]);
            [0, 1].map(|axis| {
                corners[leg][axis] + share * (corners[leg + 1][axis] - corners[leg][axis])
            })
        })
        .collect()
}

fn parabola(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (steep, turn) = (draw.scale(0.01, 100.0), draw.between(0.0, TAU));
    let places = along(count, |share| {
        let x = 2.0 * share - 1.0;
        turned([x, steep * x * x], turn)
    });
    (format!("y = {steep:.3} x², turned by {turn:.2}"), places)
}

fn turned([x, y]: Place, angle: f64) -> Place {
    let (sin, cos) = angle.sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}

/// Two arcs that bulge towards each other: every point of one may be joined with each of the other.
fn facing_chains(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (bend, apart, by_turns) = (draw.scale(1e-4, 1.0), draw.scale(0.1, 10.0), draw.coin());
    let half = count / 2;
    let at = |index: usize| {
        let (first, step) = if by_turns {
            (index.is_multiple_of(2), index / 2)
        } else {
            (index < half, index % half.max(1))
        };
        let x = 2.0 * step as f64 / half as f64 - 1.0;
        let y = apart + bend * x * x;
        if first { [x, y] } else { [0.7 * x, -y] }
    };
    (format!("bend {bend:.4}, apart {apart:.2}, by turns {by_turns}"), (0..count).map(at).collect())
}

fn spiral(draw: &mut Draw, count: usize, inwards: bool) -> (String, Vec<Place>) {
    let turns = draw.scale(2.0, (count as f64).sqrt());
    let mut places = along(count, |share| polar(share.sqrt(), TAU * turns * share.sqrt()));
    if inwards {
        places.reverse();
    }
    (format!("{turns:.1} turns"), places)
}

fn logarithmic_spiral(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (turns, decades, inwards) = (draw.scale(0.5, 200.0), draw.between(1.0, 8.0), draw.coin());
    let mut places =
        along(count, |share| polar(10.0_f64.powf(decades * share), TAU * turns * share));
    if inwards {
        places.reverse();
    }
    (format!("{turns:.1} turns, {decades:.1} decades, inwards {inwards}"), places)
}

fn rings(draw: &mut Draw, count: usize, inwards: bool) -> (String, Vec<Place>) {
    let points = draw.whole(20, count / 5);
    let at = |index: usize| {
        let step = (index % points) as f64 / points as f64;
        polar((1 + index / points) as f64, TAU * step)
    };
    let mut places: Vec<Place> = (0..count).map(at).collect();
    if inwards {
        places.reverse();
    }
    (format!("{points} points a ring"), places)
}

fn clusters(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (many, apart, kind) = (draw.whole(2, 8), draw.scale(2.5, 1e4), draw.whole(1, 5));
    let each = count.div_ceil(many);
    let columns = each.isqrt().max(1);
    let of = |draw: &mut Draw, step: usize| {
        let share = step as f64 / each as f64;
        match kind {
            1 => polar(1.0, TAU * share),
            2 => [2.0 * share - 1.0, 0.0],
            3 => [draw.unit(), draw.unit()],
            4 => [step % columns, step / columns].map(|on| on as f64 / columns as f64),
            _ => polar(share.sqrt(), TAU * share * 20.0),
        }
    };
    let places = (0..count).map(|index| {
        let [x, y] = of(draw, index / many);
        let [dx, dy] = polar(apart, TAU * (index % many) as f64 / many as f64);
        [x + dx, y + dy]
    });
    let places = places.collect();
    let kind = ["circles", "lines", "random", "rasters", "spirals"][kind - 1];
    (format!("{many} {kind}, {apart:.1} apart"), places)
}

fn lines_by_turns(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (many, apart, turn) = (draw.whole(2, 30), draw.scale(1e-3, 10.0), draw.between(0.0, TAU));
    let at = |index: usize| {
        let x = (index / many) as f64 / (count / many) as f64;
        turned([x, (index % many) as f64 * apart], turn)
    };
    (format!("{many} lines, {apart:.4} apart, turned by {turn:.2}"), (0..count).map(at).collect())
}

fn cross(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (arms, order) = (draw.whole(2, 12), draw.whole(1, 4));
    let each = count.div_ceil(arms);
    let at = |index: usize| {
        let (arm, step) =
            if order <= 2 { (index % arms, index / arms) } else { (index / each, index % each) };
        let along = 2.0 * step as f64 / each as f64 - 1.0;
        let along = if order.is_multiple_of(2) && along < 0.0 { -1.0 - along } else { along };
        polar(along, PI * arm as f64 / arms as f64 + 0.1)
    };
    let by = if order <= 2 { "by turns" } else { "one after the other" };
    (format!("{arms} lines, {by}, kind {order}"), (0..count).map(at).collect())
}

fn line_then_circle(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (share, radius) = (draw.between(0.1, 0.9), draw.scale(0.2, 100.0));
    let on_line = (share * count as f64) as usize;
    let mut places = along(on_line, |share| [2.0 * share - 1.0, 0.001 * share]);
    places.extend(along(count - on_line, |share| polar(radius, TAU * share)));
    (format!("{share:.2} on the line, circle of {radius:.2}"), places)
}

fn rosette(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (petals, turns) = (draw.between(1.0, 12.0), draw.scale(1.0, 300.0));
    let places =
        along(count, |share| polar((petals * TAU * turns * share).sin(), TAU * turns * share));
    (format!("{petals:.3} petals, {turns:.1} turns"), places)
}

fn wandering(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let bend = draw.scale(1e-3, 3.0);
    let ([mut x, mut y], mut heading) = ([0.0, 0.0], 0.0_f64);
    let places = (0..count).map(|_| {
        heading += bend * draw.between(-1.0, 1.0);
        (x, y) = (x + heading.cos(), y + heading.sin());
        [x, y]
    });
    let places = places.collect();
    (format!("bends by {bend:.3}"), places)
}

/// Column and row of a raster that is as wide as told, moved a little.
fn raster(draw: &mut Draw, count: usize) -> (String, usize, Vec<Place>) {
    let (columns, jitter) = (draw.whole(10, count / 10), draw.between(-0.1, 0.1).max(0.0));
    let places = (0..count).map(|index| {
        let moved = [draw.between(-jitter, jitter), draw.between(-jitter, jitter)];
        [(index % columns) as f64 + moved[0], (index / columns) as f64 + moved[1]]
    });
    let places = places.collect();
    (format!("{columns} columns, jitter {jitter:.2}"), columns, places)
}

fn raster_from_both_ends(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (name, _, places) = raster(draw, count);
    let outwards = draw.coin();
    let mut order: Vec<Place> = (0..count)
        .map(|index| places[if index % 2 == 0 { index / 2 } else { count - 1 - index / 2 }])
        .collect();
    if outwards {
        order.reverse();
    }
    (format!("{name}, outwards {outwards}"), order)
}

fn raster_by_strides(draw: &mut Draw, count: usize) -> (String, Vec<Place>) {
    let (name, columns, places) = raster(draw, count);
    let stride = draw.whole(2, 16);
    let rows: Vec<&[Place]> = places.chunks(columns).collect();
    let order = (0..stride).flat_map(|first| rows.iter().skip(first).step_by(stride));
    (
        format!("{name}, every row {stride} first"),
        order.flat_map(|row| row.iter().copied()).collect(),
    )
}

/// Random points of a disc or a square by a key.
fn sorted(draw: &mut Draw, count: usize, key: fn(Place) -> f64) -> (String, Vec<Place>) {
    let disc = draw.coin();
    let mut places: Vec<Place> = (0..count)
        .map(|_| {
            let (u, v) = (draw.unit(), draw.unit());
            if disc { polar(0.5 * u.sqrt(), TAU * v) } else { [u - 0.5, v - 0.5] }
        })
        .collect();
    places.sort_by(|&a, &b| key(a).total_cmp(&key(b)));
    (if disc { "disc" } else { "square" }.to_owned(), places)
}

/// By the bits of the number backwards: first to be coarse all over, then finer and finer.
fn by_bits(places: &[Place]) -> (String, Vec<Place>) {
    let bits = usize::BITS - places.len().leading_zeros();
    let order = (0..1_usize << bits).map(|index| index.reverse_bits() >> (usize::BITS - bits));
    ("bits".to_owned(), order.filter_map(|index| places.get(index).copied()).collect())
}

fn hilbert_key(place: Place) -> f64 {
    hilbert(place) as f64
}

/// How far along Hilbert's curve over the unit square about the origin.
fn hilbert(place: Place) -> u64 {
    const BITS: u32 = 20;
    let [mut x, mut y] = place.map(|on| ((on + 0.5) * f64::from(1 << BITS)) as i64);
    let (mut along, mut step) = (0_u64, 1_i64 << (BITS - 1));
    while step > 0 {
        let (right, up) = (i64::from(x & step > 0), i64::from(y & step > 0));
        along += (step * step * ((3 * right) ^ up)) as u64;
        if up == 0 {
            if right == 1 {
                (x, y) = ((1 << BITS) - 1 - x, (1 << BITS) - 1 - y);
            }
            (x, y) = (y, x);
        }
        step /= 2;
    }
    along
}
