//! The CT-shape and the region of the petal ratio, step by step over all edges.

use asphera_contour::regions::{Sampling, petals};
use asphera_contour::{Graph, Method, PlaceMm, SampleId, Triangulation};

use super::region;
use crate::places::{circle, distance, scattered, triangulation};

/// The steps of the CT-shape on all triangles, with angles and centres in doubles.
#[test]
fn ct_shapes_follow_their_steps() {
    let mut kept = 0;
    for seed in 0..30 {
        let ring = circle(20).into_iter().zip(scattered(20, seed + 700));
        // A rough ring gives closed borders, scattered points mostly none.
        let ring: Vec<PlaceMm> =
            ring.map(|([x, y], [u, v])| [x + 0.06 * (u - 5.0), y + 0.06 * (v - 5.0)]).collect();
        for points in [ring, scattered(60, seed + 460)] {
            let set = triangulation(&points);
            let expected = ct_by_hand(&set);
            assert_eq!(region(Method::Ct, &set, "").border(), &expected, "seed {seed}");
            kept += expected.edges().len();
        }
    }
    assert!(kept > 300, "{kept}");
}

fn ct_by_hand(set: &Triangulation) -> Graph {
    let side = |p: SampleId, q: SampleId| [p.min(q), p.max(q)];
    let sides = |[a, b, c]: [SampleId; 3]| [(side(a, b), c), (side(b, c), a), (side(c, a), b)];
    let long = |[p, q]: [SampleId; 2]| distance(set.place(p), set.place(q));
    let cosine = |apex: SampleId, ends: [SampleId; 2]| {
        let [a, p, q] = [apex, ends[0], ends[1]].map(|sample| set.place(sample));
        (p[0] - a[0]) * (q[0] - a[0]) + (p[1] - a[1]) * (q[1] - a[1])
    };
    let all = set.triangles();
    let beside = |ends: [SampleId; 2]| {
        all.iter().copied().filter(move |corners| ends.iter().all(|end| corners.contains(end)))
    };
    let mut marks: Vec<[SampleId; 2]> = Vec::new();
    for &corners in all {
        let around = sides(corners);
        marks.extend(around.iter().filter(|(ends, apex)| cosine(*apex, *ends) < 0.0).map(|s| s.0));
        let mut by_length = around.map(|(ends, _)| ends);
        by_length.sort_by(|a, b| long(*a).total_cmp(&long(*b)));
        let [x, y, z] = by_length.map(long);
        let [a, b, c] = corners.map(|corner| set.place(corner));
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        // The centre of the incircle: corners weighted by the sides opposite.
        let weights = around.map(|(ends, apex)| (long(ends), set.place(apex)));
        let inner = [0, 1].map(|axis| {
            weights.iter().map(|(w, place)| w * place[axis]).sum::<f64>() / (x + y + z)
        });
        let radius = x * y * z / (4.0 * area);
        let lift = |p: PlaceMm| (p[0] - a[0]).powi(2) + (p[1] - a[1]).powi(2);
        let centre = [
            a[0] + ((c[1] - a[1]) * lift(b) - (b[1] - a[1]) * lift(c)) / (4.0 * area),
            a[1] + ((b[0] - a[0]) * lift(c) - (c[0] - a[0]) * lift(b)) / (4.0 * area),
        ];
        assert!(
            [a, b, c].iter().all(|corner| (distance(*corner, centre) / radius - 1.0).abs() < 1e-6)
        );
        if around.iter().all(|(ends, apex)| cosine(*apex, *ends) >= 0.0)
            && x < distance(centre, inner)
        {
            marks.extend([by_length[1], by_length[2]]);
        }
    }
    let marked = |corners: [SampleId; 3], marks: &[[SampleId; 2]]| -> Vec<[SampleId; 2]> {
        sides(corners)
            .map(|(ends, _)| ends)
            .into_iter()
            .filter(|ends| marks.contains(ends))
            .collect()
    };
    let mut left = marks.clone();
    for &corners in all {
        let own = marked(corners, &marks);
        let is_lonely = |ends: &[SampleId; 2]| {
            let mut others = beside(*ends).filter(|other| *other != corners);
            others.next().is_some_and(|other| marked(other, &marks).len() == 1)
        };
        if own.iter().all(is_lonely) {
            left.retain(|ends| !own.contains(ends));
        }
    }
    let border = set.edges().iter().map(|edge| edge.ends).filter(|ends| {
        let of: Vec<[SampleId; 3]> = beside(*ends).collect();
        let is_open = of.len() == 1 || of.iter().any(|corners| !marked(*corners, &left).is_empty());
        is_open && !left.contains(ends)
    });
    on_closed_ways(border.collect(), long)
}

/// The last step: no ends, two sides a sample, closed ways.
fn on_closed_ways(mut border: Vec<[SampleId; 2]>, long: impl Fn([SampleId; 2]) -> f64) -> Graph {
    loop {
        let degree = |end: SampleId| border.iter().filter(|ends| ends.contains(&end)).count();
        let lead_on = |ends: &&[SampleId; 2]| ends.iter().all(|&end| degree(end) > 1);
        let next: Vec<[SampleId; 2]> = border.iter().filter(lead_on).copied().collect();
        if next.len() == border.len() {
            break;
        }
        border = next;
    }
    let keeps = |ends: [SampleId; 2], by: SampleId| {
        let others = border.iter().filter(|other| other.contains(&by));
        others.filter(|other| long(**other) < long(ends)).count() < 2
    };
    // The walks p to q by sides that p keeps, and for each all walks that can follow.
    let both = border.iter().flat_map(|&[p, q]| [[p, q], [q, p]]);
    let walks: Vec<[SampleId; 2]> = both.filter(|&[p, q]| keeps([p.min(q), p.max(q)], p)).collect();
    let comes_back = |walk: &&[SampleId; 2]| {
        let (mut reached, mut new) = (Vec::new(), vec![**walk]);
        while let Some([p, q]) = new.pop() {
            for &next in walks.iter().filter(|next| next[0] == q && next[1] != p) {
                if !reached.contains(&next) {
                    reached.push(next);
                    new.push(next);
                }
            }
        }
        reached.contains(walk)
    };
    Graph::new(walks.iter().filter(comes_back).copied())
}

/// The steps of the petal ratio's region on all edges.
#[test]
fn discern_follows_its_steps() {
    let mut dropped = 0;
    for seed in 0..20 {
        // A jittered raster with strays: points of an area.
        let mut points: Vec<PlaceMm> = scattered(49, seed + 800)
            .into_iter()
            .zip(0..)
            .map(|([u, v], index)| {
                [f64::from(index % 7) + 0.05 * (u - 5.0), f64::from(index / 7) + 0.05 * (v - 5.0)]
            })
            .collect();
        points
            .extend(scattered(4, seed + 820).iter().map(|[x, y]| [3.0 * x - 12.0, 3.0 * y - 12.0]));
        let set = triangulation(&points);
        if petals(&set) == Sampling::Border {
            continue;
        }
        let gone = gone_by_hand(&set);
        let kept = set.triangles().iter().filter(|&&[a, b, c]| {
            let sides = [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)]);
            !sides.iter().any(|side| gone.contains(side))
        });
        let mut border = Vec::new();
        for &[a, b, c] in kept {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                match border.iter().position(|&side| side == [q, p]) {
                    Some(index) => drop(border.swap_remove(index)),
                    None => border.push([p, q]),
                }
            }
        }
        dropped += gone.len();
        assert_eq!(region(Method::Discern, &set, "").border(), &Graph::new(border), "seed {seed}");
    }
    assert!(dropped > 100, "{dropped}");
}

fn gone_by_hand(set: &Triangulation) -> Vec<[SampleId; 2]> {
    let edges: Vec<[SampleId; 2]> = set.edges().iter().map(|edge| edge.ends).collect();
    let long = |[p, q]: [SampleId; 2]| distance(set.place(p), set.place(q));
    let shortest = |sample: SampleId| {
        let own = edges.iter().filter(|ends| ends.contains(&sample));
        own.map(|ends| long(*ends)).fold(f64::INFINITY, f64::min)
    };
    let is_long = |ends: [SampleId; 2], end: SampleId| long(ends) > 2.0 * shortest(end);
    let mut sorted: Vec<f64> = edges.iter().map(|ends| long(*ends)).collect();
    sorted.sort_by(f64::total_cmp);
    let [first, third] = [1, 3].map(|quarters| sorted[quarters * sorted.len() / 4]);
    let mut gone: Vec<[SampleId; 2]> =
        edges.iter().copied().filter(|&[p, q]| is_long([p, q], p) && is_long([p, q], q)).collect();
    for sample in 0..set.len() as SampleId {
        let own: Vec<[SampleId; 2]> =
            edges.iter().copied().filter(|ends| ends.contains(&sample)).collect();
        let there = |ends: &[SampleId; 2]| if ends[0] == sample { ends[1] } else { ends[0] };
        let none = own.iter().filter(|e| !is_long(**e, sample) && !is_long(**e, there(e))).count();
        let other: Vec<f64> = own
            .iter()
            .filter(|e| !is_long(**e, sample) && is_long(**e, there(e)))
            .map(|e| long(*e))
            .collect();
        let are_far = other.iter().all(|length| *length > third + 1.5 * (third - first));
        if none == 0 || (other.len() > none && are_far) {
            gone.extend(own);
        }
    }
    gone.sort_unstable();
    gone.dedup();
    let hull: Vec<[SampleId; 2]> = set
        .edges()
        .iter()
        .filter(|edge| edge.triangles().contains(&None))
        .map(|edge| edge.ends)
        .collect();
    let alone = |ends: &&[SampleId; 2]| {
        let is_only = ends.iter().all(|end| gone.iter().filter(|e| e.contains(end)).count() == 1);
        let is_on_hull = ends.iter().all(|end| hull.iter().any(|e| e.contains(end)));
        !is_only || is_on_hull
    };
    gone.iter().filter(alone).copied().collect()
}
