//! Figures of airfoils: a NACA 4-digit section and a lens with round ends, whose figures are known.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use asphera_contour::PlaceMm;
use asphera_contour::features::{Airfoil, Course, Estimate, Profile};
use asphera_geometry::Numbers;

use crate::places::distance;
use crate::profiles::{Drawn, drawn};

const CHORD: f64 = 40.0;

/// NACA 2412 of 40 mm, its trailing edge closed (E. N. Jacobs, K. E. Ward, R. M. Pinkerton, NACA report 460, 1933): at an angle from 0 at the
/// trailing edge over the upper side, π at the nose, to 2π.
fn naca(angle: f64) -> PlaceMm {
    let (m, p, t) = (0.02, 0.4, 0.12);
    let x = 0.5 * (1.0 + angle.cos());
    let thick = 5.0
        * t
        * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
            - 0.1036 * x.powi(4));
    let (camber, slope) = if x < p {
        (m / (p * p) * (2.0 * p * x - x * x), 2.0 * m / (p * p) * (p - x))
    } else {
        let q = (1.0 - p) * (1.0 - p);
        (m / q * (1.0 - 2.0 * p + 2.0 * p * x - x * x), 2.0 * m / q * (p - x))
    };
    let side = if angle <= PI { 1.0 } else { -1.0 };
    let (sin, cos) = slope.atan().sin_cos();
    [CHORD * (x - side * thick * sin), CHORD * (camber + side * thick * cos)]
}

/// Angles of places along the section at equal lengths, by a polygon of 400,000 sides.
pub(crate) struct Lengths(Vec<f64>);

impl Lengths {
    pub(crate) fn new() -> Lengths {
        let count = 400_000;
        let mut sums = vec![0.0];
        let mut before = naca(0.0);
        for index in 1..=count {
            let at = naca(TAU * f64::from(index) / f64::from(count));
            sums.push(sums[sums.len() - 1] + distance(before, at));
            before = at;
        }
        Lengths(sums)
    }

    fn angle(&self, share: f64) -> f64 {
        let wanted = share * self.0[self.0.len() - 1];
        let next = self.0.partition_point(|sum| *sum < wanted).clamp(1, self.0.len() - 1);
        let part = (wanted - self.0[next - 1]) / (self.0[next] - self.0[next - 1]);
        TAU * (next as f64 - 1.0 + part) / (self.0.len() - 1) as f64
    }
}

pub(crate) fn section(lengths: &Lengths, count: usize, sigma: f64, draw: u32) -> Vec<PlaceMm> {
    let (noise, shift) = (Numbers::new(91, draw, 0), Numbers::new(91, draw, 1));
    (0..count)
        .map(|index| {
            let share = (index as f64 + 0.25 + 0.5 * shift.uniform(index)) / count as f64;
            let angle = lengths.angle(share);
            let [p, q] = [naca(angle - 1e-6), naca(angle + 1e-6)];
            let length = distance(p, q);
            let off = sigma * noise.normal(index) / length;
            let [x, y] = naca(angle);
            [x + off * (q[1] - p[1]), y - off * (q[0] - p[0])]
        })
        .collect()
}

/// The largest value of a function within a range, by thirds.
fn largest(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let [p, q] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if of(p) < of(q) {
            low = p;
        } else {
            high = q;
        }
    }
    of(0.5 * (low + high))
}

/// Chord, thickness and leading radius of the section itself, as the figures are defined.
fn truth(lengths: &Lengths) -> [f64; 3] {
    let tail = naca(0.0);
    let chord = largest(PI - 0.5, PI + 0.5, |angle| distance(naca(angle), tail));
    let thickness = largest(1.6, 2.4, |upper| {
        -largest(TAU - 2.6, TAU - 1.4, |lower| -distance(naca(upper), naca(lower)))
    });
    // Gauss and Newton over a fine polygon of the nose, by lengths.
    let nose = (0..=20_000).map(|index| lengths.angle(0.48 + 0.04 * f64::from(index) / 20_000.0));
    let nose: Vec<PlaceMm> = nose.map(naca).collect();
    let tip = *nose
        .iter()
        .reduce(|p, q| if distance(*q, tail) > distance(*p, tail) { q } else { p })
        .unwrap();
    let along = [0, 1].map(|axis| (tip[axis] - tail[axis]) / distance(tip, tail));
    let (mut centre, mut radius) = ([tip[0] - along[0], tip[1] - along[1]], 1.0);
    for _ in 0..200 {
        let mut rows = [[0.0; 4]; 3];
        for place in &nose {
            let way = distance(*place, centre);
            let unit = [(place[0] - centre[0]) / way, (place[1] - centre[1]) / way];
            let depth = [0, 1].map(|axis| (tip[axis] - place[axis]) * along[axis]);
            let weight = (1.0 - 20.0 * (depth[0] + depth[1]) / thickness).max(0.0);
            let row = [unit[0], unit[1], 1.0, way - radius];
            for i in 0..3 {
                for j in 0..4 {
                    rows[i][j] += weight * row[i] * row[j];
                }
            }
        }
        for i in 0..3 {
            for k in (0..3).filter(|k| *k != i) {
                let lead = rows[i];
                let share = rows[k][i] / lead[i];
                rows[k].iter_mut().zip(lead).for_each(|(value, lead)| *value -= share * lead);
            }
        }
        let step = [0, 1, 2].map(|i| rows[i][3] / rows[i][i]);
        centre = [centre[0] + step[0], centre[1] + step[1]];
        radius += step[2];
    }
    [chord, thickness, radius]
}

/// A lens of two arcs of 75.54 mm, 6 mm thick, that go over into ends of radius 0.8 mm, 36 mm apart.
fn lens() -> (Vec<Drawn>, f64) {
    let radius: f64 = 332.36 / 4.4;
    let down = radius - 3.0;
    let angle = down.atan2(18.0);
    let long = PI - 2.0 * angle;
    let outline = vec![
        Drawn::Arc([18.0, 0.0], 0.8, -angle, 2.0 * angle),
        Drawn::Arc([0.0, -down], radius, angle, long),
        Drawn::Arc([-18.0, 0.0], 0.8, PI - angle, 2.0 * angle),
        Drawn::Arc([0.0, down], radius, PI + angle, long),
    ];
    // Sectors of the ends and the arcs, and the triangles between the four centres taken twice.
    let area = 2.0 * (0.64 * angle) + radius * radius * long - 36.0 * down;
    (outline, area)
}

fn of(points: Vec<PlaceMm>) -> Airfoil {
    Airfoil::new(&Course::new(points, true)).unwrap()
}

#[test]
fn sections_without_noise_have_their_figures() {
    let lengths = Lengths::new();
    let [chord, thickness, radius] = truth(&lengths);
    assert!((chord / CHORD - 1.0).abs() < 1e-3 && (thickness / CHORD - 0.12).abs() < 1e-3);
    // 1.1019·t²·c at the very nose, and more beside it.
    assert!(radius > 1.1019 * 0.0144 * CHORD && radius < 1.3 * 1.1019 * 0.0144 * CHORD, "{radius}");
    let found = of(section(&lengths, 2000, 0.0, 0));
    println!("{found:#?} {chord} {thickness} {radius}");
    assert!((found.chord_mm.value - chord).abs() < 2e-4);
    assert!((found.thickness_mm.value - thickness).abs() < 2e-5);
    assert!((found.leading_radius_mm.unwrap().value - radius).abs() < 1e-3);
    assert!(found.trailing_radius_mm.is_none());
    assert_eq!(found.unknown, ["trailing radius: the edge is a corner"]);
    assert!(distance(found.ends_mm[1], [CHORD, 0.0]) < 1e-3 && found.ends_mm[0][0].abs() < 0.01);
    let found = of(drawn(&lens().0, 2000, 0.0, 0));
    // The polynomial is no circle: a tenth of the noise of the draws below at most.
    assert!((found.chord_mm.value - 37.6).abs() < 1e-4, "{found:#?}");
    assert!((found.thickness_mm.value - 6.0).abs() < 1e-6);
    for radius in [found.leading_radius_mm, found.trailing_radius_mm] {
        assert!((radius.unwrap().value - 0.8).abs() < 1e-8, "{found:#?}");
    }
}

#[test]
fn uncertainties_of_airfoils_hold_the_truth() {
    let draws = if std::env::var_os("ASPHERA_LONG").is_some() { 2000 } else { 100 };
    let lengths = Lengths::new();
    let [chord, thickness, radius] = truth(&lengths);
    let mut held = [0_u32; 9];
    let mut off = [[0.0; 2]; 8];
    let (outline, area) = lens();
    for draw in 0..draws {
        let naca = of(section(&lengths, 2000, 1e-3, draw));
        let points = drawn(&outline, 2000, 1e-3, draw);
        let round = of(points.clone());
        // Both ends are alike: which of them leads is chance.
        let [leading, trailing] = [round.leading_radius_mm, round.trailing_radius_mm];
        let leads = round.ends_mm[0][0] > 0.0;
        let [right, left] = if leads { [leading, trailing] } else { [trailing, leading] };
        let [right, left] = [right.unwrap(), left.unwrap()];
        let enclosed = Profile::new(&Course::new(points, true), 0.0).area_mm2.unwrap();
        let free = Profile::new(&Course::new(section(&lengths, 2000, 1e-3, draw), true), 0.0);
        let rows: [(f64, Estimate); 8] = [
            (chord, naca.chord_mm),
            (thickness, naca.thickness_mm),
            (radius, naca.leading_radius_mm.unwrap()),
            (37.6, round.chord_mm),
            (6.0, round.thickness_mm),
            (0.8, right),
            (area, enclosed),
            (naca_area(), free.area_mm2.unwrap()),
        ];
        for (off, (truth, found)) in off.iter_mut().zip(rows) {
            let ratio = (found.value - truth) / found.u;
            off[0] += ratio / f64::from(draws);
            off[1] += ratio * ratio / f64::from(draws);
        }
        for (held, (truth, found)) in held.iter_mut().zip(rows) {
            *held += u32::from((found.value - truth).abs() <= 1.96 * found.u);
        }
        held[8] += u32::from((left.value - 0.8).abs() <= 1.96 * left.u);
    }
    let percent = held.map(|held| 100.0 * f64::from(held) / f64::from(draws));
    let names =
        "chord, thickness, radius of NACA 2412; of the lens; area of the lens, of NACA; other end";
    println!("{names}: {percent:?} %, mean and mean square over u: {off:?}");
    let bar = if draws == 2000 { 2.0 } else { 300.0 * (0.95 * 0.05 / f64::from(draws)).sqrt() };
    assert!(percent.iter().all(|percent| (percent - 95.0).abs() <= bar), "{percent:?}");
}

/// A closed curve at even steps of its angle, with noise across it.
fn traced(of: impl Fn(f64) -> PlaceMm, count: usize, sigma: f64, draw: u32) -> Vec<PlaceMm> {
    let noise = Numbers::new(92, draw, 0);
    let place = |index: usize| {
        let angle = TAU * (index as f64 + 0.5) / count as f64;
        let [[x, y], [p, q]] = [of(angle), of(angle + 1e-6)];
        let off = sigma * noise.normal(index) / (p - x).hypot(q - y);
        [x + off * (q - y), y - off * (p - x)]
    };
    (0..count).map(place).collect()
}

/// Where a section is thicker than its sides are bent, the places nearest to one of a side are no more those opposite.
#[test]
fn thick_sections_have_the_diameter_of_their_largest_circle() {
    let ellipse = |[a, b]: PlaceMm| move |angle: f64| [a * angle.cos(), b * angle.sin()];
    // NACA 0040 of 20 mm.
    let naca = |angle: f64| {
        let x = 0.5 * (1.0 + f64::cos(angle));
        let terms = 0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3);
        let thick = 2.0 * (terms - 0.1036 * x.powi(4));
        [20.0 * x, 20.0 * if angle <= PI { thick } else { -thick }]
    };
    let naca_mm = 2.0 * largest(1.0, 2.5, |angle| naca(angle)[1]);
    let found = |truth: f64, name: &str, points: Vec<PlaceMm>| {
        let thickness = Airfoil::new(&Course::new(points, true)).unwrap().thickness_mm;
        println!("{name}: {thickness:?} of {truth}");
        ((thickness.value - truth).abs(), thickness.u)
    };
    for (truth, name, of) in [
        (20.0, "circle", &ellipse([10.0, 10.0]) as &dyn Fn(f64) -> PlaceMm),
        (19.0, "thick ellipse", &ellipse([10.0, 9.5])),
        (10.0, "ellipse", &ellipse([10.0, 5.0])),
        (naca_mm, "NACA 0040", &naca),
    ] {
        // Sides are polynomials of degree 4, and no ellipses.
        assert!(found(truth, name, traced(of, 1440, 0.0, 0)).0 < 2e-5);
        for draw in 0..10 {
            let (off_mm, u_mm) = found(truth, name, traced(of, 1440, 1e-3, draw));
            assert!(off_mm < 4.0 * u_mm && u_mm < 5e-4, "{name}, draw {draw}: {off_mm} {u_mm}");
        }
    }
    // Sides that are parallel stand farthest apart all along: what is given is right.
    let stadium = [
        Drawn::Line([-15.0, -5.0], [15.0, -5.0]),
        Drawn::Arc([15.0, 0.0], 5.0, -FRAC_PI_2, PI),
        Drawn::Line([15.0, 5.0], [-15.0, 5.0]),
        Drawn::Arc([-15.0, 0.0], 5.0, FRAC_PI_2, PI),
    ];
    for draw in 0..10 {
        match Airfoil::new(&Course::new(drawn(&stadium, 1500, 1e-3, draw), true)) {
            Ok(Airfoil { thickness_mm, .. }) => {
                assert!(
                    (thickness_mm.value - 10.0).abs() < 4.0 * thickness_mm.u,
                    "{thickness_mm:?}"
                );
            }
            Err(why) => assert!(why.contains("do not stand farthest apart at one place"), "{why}"),
        }
    }
}

/// Area within the section by the trapezoidal rule over the angle, which is exact to 1e-10 of it.
fn naca_area() -> f64 {
    let count = 400_000;
    let at = |index: usize| naca(TAU * (index % count) as f64 / count as f64);
    let crossed = (0..count).map(|index| {
        let [p, q] = [at(index), at(index + 1)];
        p[0] * q[1] - q[0] * p[1]
    });
    0.5 * crossed.sum::<f64>()
}

#[test]
fn sections_that_cannot_be_told_say_why() {
    let circle = |count: usize| -> Vec<PlaceMm> {
        let angles = (0..count).map(|index| TAU * index as f64 / count as f64);
        angles.map(|angle| [angle.cos(), angle.sin()]).collect()
    };
    let few = Airfoil::new(&Course::new(circle(40), true)).unwrap_err();
    assert!(
        few.contains("a closed curve of 100 points or more, found a closed one of 40"),
        "{few}"
    );
    let open = Airfoil::new(&Course::new(circle(400)[..300].to_vec(), false)).unwrap_err();
    assert!(open.contains("found an open one of 300"), "{open}");
    // Ends of six points.
    let thin = Airfoil::new(&Course::new(drawn(&lens().0, 250, 1e-4, 0), true)).unwrap_err();
    assert!(thin.contains("points lie within 0.3000 mm of the end of the chord near"), "{thin}");
    // A plate cut off square is neither round nor a corner.
    let plate = [
        Drawn::Line([0.0, -0.5], [30.0, -2.0]),
        Drawn::Line([30.0, -2.0], [60.0, -0.5]),
        Drawn::Line([60.0, -0.5], [60.0, 0.5]),
        Drawn::Line([60.0, 0.5], [30.0, 2.0]),
        Drawn::Line([30.0, 2.0], [0.0, 0.5]),
        Drawn::Line([0.0, 0.5], [0.0, -0.5]),
    ];
    let cut = Airfoil::new(&Course::new(drawn(&plate, 3000, 1e-4, 0), true)).unwrap_err();
    assert!(cut.contains("airfoil: "), "{cut}");
}
