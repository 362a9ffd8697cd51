//! Bodies with a known radius r, Euler number, volume and area, digitized in any pose.
//!
//! A body is the set of points within `thickness` of a curve: then r is the smaller of the thickness and what the curve's own
//! reach leaves outside. Tori, links of two tori, tubes, knots and chains of balls are such bodies.

use std::f64::consts::{PI, TAU};

use asphera_volume::Samples;

use crate::knots::Knot;
use crate::noise::Random;

pub(crate) struct Body {
    pub(crate) name: &'static str,
    /// Distance to the boundary is `thickness` less the distance to these.
    rings: Vec<Ring>,
    segments: Vec<[[f64; 3]; 2]>,
    knot: Option<Knot>,
    thickness: f64,
    /// Two balls of this radius touch every boundary point, one inside, one outside.
    pub(crate) regular: f64,
    /// Euler number of the boundary.
    pub(crate) surface_euler: i64,
    pub(crate) components: u64,
    /// Volume and area of the boundary (Weyl: of a tube about a closed curve its section, or the girth of that, times its length).
    pub(crate) volume: f64,
    pub(crate) area: f64,
    extent: f64,
}

/// A circle in space.
struct Ring {
    centre: [f64; 3],
    /// Two directions at right angles.
    axes: [[f64; 3]; 2],
    radius: f64,
}

impl Body {
    fn of(name: &'static str, thickness: f64, regular: f64, surface_euler: i64) -> Body {
        Body {
            name,
            rings: Vec::new(),
            segments: Vec::new(),
            knot: None,
            thickness,
            regular,
            surface_euler,
            components: 1,
            volume: 0.0,
            area: 0.0,
            extent: 0.0,
        }
    }

    /// The volume and area of `balls` balls and tubes `length` long, all as thick as the body.
    fn with_size(mut self, balls: f64, length: f64) -> Body {
        let t = self.thickness;
        self.volume = balls * 4.0 / 3.0 * PI * t.powi(3) + PI * t * t * length;
        self.area = balls * 4.0 * PI * t * t + 2.0 * PI * t * length;
        self
    }

    pub(crate) fn ball(radius: f64) -> Body {
        let mut body = Body::of("ball", radius, radius, 2);
        body.segments.push([[0.0; 3]; 2]);
        body.extent = radius;
        body.with_size(1.0, 0.0)
    }

    /// A tube about a segment.
    pub(crate) fn capsule(radius: f64, length: f64) -> Body {
        let mut body = Body::of("capsule", radius, radius, 2);
        body.segments.push([[0.0, 0.0, -length / 2.0], [0.0, 0.0, length / 2.0]]);
        body.extent = radius + length / 2.0;
        body.with_size(1.0, length)
    }

    /// A torus: the outer reach is what is left of the hole.
    pub(crate) fn torus(ring: f64, tube: f64) -> Body {
        let mut body = Body::of("torus", tube, tube.min(ring - tube), 0);
        body.rings.push(Ring { centre: [0.0; 3], axes: XY, radius: ring });
        body.extent = ring + tube;
        body.with_size(0.0, TAU * ring)
    }

    /// Two linked tori: each passes through the middle of the other's hole.
    pub(crate) fn link(tube: f64) -> Body {
        // The circles are `ring` apart where they are nearest: the gap between the tubes is ring − 2·tube.
        let ring = 4.0 * tube;
        let mut body = Body::of("link", tube, tube, 0);
        body.rings.push(Ring { centre: [-ring / 2.0, 0.0, 0.0], axes: XY, radius: ring });
        body.rings.push(Ring { centre: [ring / 2.0, 0.0, 0.0], axes: XZ, radius: ring });
        body.components = 2;
        body.extent = 1.5 * ring + tube;
        body.with_size(0.0, 2.0 * TAU * ring)
    }

    /// Balls in a row that do not touch.
    pub(crate) fn chain(count: usize, radius: f64) -> Body {
        // The gaps are 2·radius, as r on the outside asks for.
        let mut body = Body::of("chain of balls", radius, radius, 2 * count as i64);
        for index in 0..count {
            let x = 4.0 * radius * (index as f64 - (count as f64 - 1.0) / 2.0);
            body.segments.push([[x, 0.0, 0.0]; 2]);
        }
        body.components = count as u64;
        body.extent = 2.0 * radius * count as f64;
        body.with_size(count as f64, 0.0)
    }

    /// A tube about a torus knot, half as thick as the reach of the knot: so much is left outside of it.
    pub(crate) fn knot(turns: [u32; 2], radii: [f64; 2]) -> Body {
        let knot = Knot::new(turns, radii);
        let tube = 0.499 * knot.reach();
        let mut body = Body::of("knot", tube, tube, 0);
        body.extent = radii[0] + radii[1] + tube;
        let length = knot.length();
        body.knot = Some(knot);
        body.with_size(0.0, length)
    }

    /// Any of the bodies above but a knot, of any proportions.
    pub(crate) fn random(random: &mut Random) -> Body {
        let r = random.between(1.0, 2.0);
        match random.word() % 5 {
            0 => Body::ball(random.between(1.0, 4.0)),
            1 => Body::capsule(r, random.between(0.0, 5.0) * r),
            2 => Body::torus(random.between(1.6, 4.0) * r, r),
            3 => Body::link(r),
            _ => Body::chain(2 + (random.word() % 3) as usize, r),
        }
    }

    /// How far a point lies inside (above 0) or outside.
    pub(crate) fn depth(&self, point: [f64; 3]) -> f64 {
        let to_rings = self.rings.iter().map(|ring| {
            let from: [f64; 3] = std::array::from_fn(|axis| point[axis] - ring.centre[axis]);
            let [a, b] = ring.axes.map(|axis| dot(axis, from));
            let in_plane = (a * a + b * b).sqrt() - ring.radius;
            let height_square = dot(from, from) - a * a - b * b;
            (in_plane * in_plane + height_square.max(0.0)).sqrt()
        });
        let to_segments = self.segments.iter().map(|&[from, to]| {
            let along: [f64; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
            let rest: [f64; 3] = std::array::from_fn(|axis| point[axis] - from[axis]);
            let square = dot(along, along);
            let share =
                if square > 0.0 { (dot(rest, along) / square).clamp(0.0, 1.0) } else { 0.0 };
            let foot: [f64; 3] = std::array::from_fn(|axis| rest[axis] - share * along[axis]);
            dot(foot, foot).sqrt()
        });
        let to_knot =
            self.knot.iter().filter_map(|knot| knot.distance(point, 2.0 * self.thickness));
        self.thickness - to_rings.chain(to_segments).chain(to_knot).fold(f64::INFINITY, f64::min)
    }

    /// The body sampled at a spacing, in a pose drawn at random.
    pub(crate) fn digitized(&self, spacing: f64, random: &mut Random) -> Samples {
        let half = (self.extent / spacing).ceil() + 1.0;
        let side = 2 * half as usize + 1;
        let turn = random.rotation();
        let shift: [f64; 3] = std::array::from_fn(|_| random.between(-0.5, 0.5));
        Samples::from_fn([side; 3], |x, y, z| {
            let place = [x, y, z];
            let from: [f64; 3] =
                std::array::from_fn(|axis| (place[axis] as f64 - half + shift[axis]) * spacing);
            self.depth(turn.map(|row| dot(row, from))) >= 0.0
        })
        .unwrap()
    }
}

const XY: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const XZ: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
