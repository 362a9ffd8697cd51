//! Seven classes of bodies in random poses and proportions, as a benchmark of shapes has them: humans, cups, tables, glasses,
//! octopuses, pliers, birds.

use crate::bodies::{Body, Place, Random, norm};

/// The names of the classes.
pub(crate) const CLASSES: [&str; 7] =
    ["human", "cup", "table", "glass", "octopus", "plier", "bird"];

/// A body of a class; its genus is not looked at.
pub(crate) fn member(class: usize, random: &mut Random) -> Body {
    let limbs = match class {
        0 => human(random),
        1 => cup(random),
        2 => table(random),
        3 => glass(random),
        4 => octopus(random),
        5 => plier(random),
        _ => bird(random),
    };
    Body::of(CLASSES[class], 0, [3.0; 3], move |p| {
        limbs.iter().map(|limb| limb.distance(p)).fold(f64::INFINITY, f64::min)
    })
}

/// A piece of a body.
enum Limb {
    /// All within a radius of a line from end to end.
    Rod([Place; 2], f64),
    /// A box about the origin of a place: half its sides, rounded by a radius.
    Block(Place, Place, f64),
    /// A vessel about the z axis: radius, wall, and heights of bottom and rim.
    Vessel { radius: f64, wall: f64, bottom: f64, rim: f64 },
    /// A bowl: the lower part of a hollow sphere about a place on the z axis.
    Bowl { height: f64, radius: f64, wall: f64, rim: f64 },
}

impl Limb {
    fn distance(&self, p: Place) -> f64 {
        match *self {
            Limb::Rod([a, b], radius) => {
                let along = minus(b, a);
                let square = dot(along, along).max(1e-12);
                let share = (dot(minus(p, a), along) / square).clamp(0.0, 1.0);
                norm(minus(minus(p, a), along.map(|side| share * side))) - radius
            }
            Limb::Block(middle, half, radius) => {
                let from = minus(p, middle);
                let sides: Place = std::array::from_fn(|axis| from[axis].abs() - half[axis]);
                let inside = sides.into_iter().fold(f64::NEG_INFINITY, f64::max).min(0.0);
                norm(sides.map(|side| side.max(0.0))) + inside - radius
            }
            Limb::Vessel { radius, wall, bottom, rim } => {
                let from_axis = p[0].hypot(p[1]);
                let solid = (from_axis - radius).max(bottom - p[2]).max(p[2] - rim);
                let hollow = (from_axis - radius + wall).max(bottom + wall - p[2]);
                solid.max(-hollow)
            }
            Limb::Bowl { height, radius, wall, rim } => {
                let from = norm([p[0], p[1], p[2] - height]);
                ((from - radius).abs() - wall / 2.0).max(p[2] - rim)
            }
        }
    }
}

fn human(random: &mut Random) -> Vec<Limb> {
    let size = random.between(0.9, 1.1);
    let hip = [0.0, 0.0, 0.0];
    let neck = [0.0, 0.0, 1.0 * size];
    let mut limbs = vec![
        Limb::Rod([hip, neck], 0.24 * random.between(0.85, 1.2)),
        Limb::Rod([[0.0, 0.0, 1.35 * size], [0.0, 0.0, 1.4 * size]], 0.2),
    ];
    for side in [-1.0, 1.0] {
        let shoulder = [0.0, 0.3 * side, 0.95 * size];
        let arm = random.between(0.2, 1.6);
        let reach = [0.0, side * arm.sin(), -arm.cos()];
        limbs.extend(jointed(shoulder, reach, [0.5 * size, 0.5 * size], 0.09, random));
        let leg = random.between(0.05, 0.45);
        let reach = [random.between(-0.4, 0.4), side * leg.sin(), -leg.cos()];
        limbs.extend(jointed(
            [0.0, 0.15 * side, -0.1],
            reach,
            [0.75 * size, 0.7 * size],
            0.12,
            random,
        ));
    }
    limbs
}

/// Two rods with a bent joint.
fn jointed(
    from: Place,
    reach: Place,
    lengths: [f64; 2],
    radius: f64,
    random: &mut Random,
) -> Vec<Limb> {
    let joint = plus(from, lengths[0], unit(reach));
    let bent = std::array::from_fn(|axis| reach[axis] + random.between(-0.35, 0.35));
    let end = plus(joint, lengths[1], unit(bent));
    vec![Limb::Rod([from, joint], radius), Limb::Rod([joint, end], 0.9 * radius)]
}

fn cup(random: &mut Random) -> Vec<Limb> {
    let (radius, half) = (random.between(0.7, 0.95), random.between(0.7, 1.0));
    let mut limbs = vec![Limb::Vessel { radius, wall: 0.14, bottom: -half, rim: half }];
    let (out, up) = (random.between(0.5, 0.75), random.between(0.4, 0.6) * half);
    let at = |angle: f64| [radius - 0.05 + out * angle.sin(), 0.0, up * angle.cos()];
    for step in 0..8 {
        let ends = [step, step + 1].map(|step| at(f64::from(step) * std::f64::consts::PI / 8.0));
        limbs.push(Limb::Rod(ends, 0.1));
    }
    limbs
}

fn table(random: &mut Random) -> Vec<Limb> {
    let half = [random.between(1.0, 1.5), random.between(0.7, 1.1), 0.05];
    let height = random.between(0.9, 1.4);
    let mut limbs = vec![Limb::Block([0.0, 0.0, height / 2.0], half, 0.03)];
    for (x, y) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let [x, y] = [x * (half[0] - 0.12), y * (half[1] - 0.12)];
        limbs.push(Limb::Rod([[x, y, height / 2.0], [x, y, -height / 2.0]], 0.09));
    }
    limbs
}

fn glass(random: &mut Random) -> Vec<Limb> {
    let (radius, stem) = (random.between(0.55, 0.75), random.between(0.8, 1.2));
    let foot = random.between(0.45, 0.6);
    let height = stem + radius - 0.05;
    vec![
        Limb::Vessel { radius: foot, wall: 0.12, bottom: -0.12, rim: 0.0 },
        Limb::Rod([[0.0; 3], [0.0, 0.0, stem]], 0.09),
        Limb::Bowl { height, radius, wall: 0.12, rim: height + random.between(0.3, 0.5) * radius },
    ]
}

fn octopus(random: &mut Random) -> Vec<Limb> {
    let mut limbs = vec![Limb::Rod([[0.0, 0.0, 0.1], [0.0, 0.0, 0.5]], random.between(0.4, 0.5))];
    for arm in 0..8 {
        let angle = f64::from(arm) * std::f64::consts::TAU / 8.0;
        let (mut at, mut heading) = ([0.3 * angle.cos(), 0.3 * angle.sin(), -0.1], angle);
        for _ in 0..3 {
            heading += random.between(-0.45, 0.45);
            let fall = random.between(-0.5, 0.1);
            let step = unit([heading.cos(), heading.sin(), fall]);
            let next = plus(at, 0.55, step);
            limbs.push(Limb::Rod([at, next], 0.1));
            at = next;
        }
    }
    limbs
}

fn plier(random: &mut Random) -> Vec<Limb> {
    let open = random.between(0.12, 0.6);
    let (handle, jaw) = (random.between(1.5, 1.8), random.between(0.6, 0.8));
    let mut limbs = vec![Limb::Rod([[0.0, 0.0, -0.1], [0.0, 0.0, 0.1]], 0.2)];
    for side in [-1.0, 1.0] {
        let knee = [-0.5 * handle, 0.6 * side * (open + 0.25), 0.0];
        let end = [-handle, side * (open + 0.25), 0.0];
        limbs.push(Limb::Rod([[0.0; 3], knee], 0.1));
        limbs.push(Limb::Rod([knee, end], 0.11));
        limbs.push(Limb::Rod([[0.0; 3], [jaw, side * 0.5 * open * jaw, 0.0]], 0.12));
    }
    limbs
}

fn bird(random: &mut Random) -> Vec<Limb> {
    let length = random.between(0.8, 1.0);
    let mut limbs = vec![
        Limb::Rod([[-length / 2.0, 0.0, 0.0], [length / 2.0, 0.0, 0.0]], random.between(0.2, 0.26)),
        Limb::Rod([[length / 2.0, 0.0, 0.0], [length * 0.9, 0.0, 0.25]], 0.15),
        Limb::Block([-length, 0.0, 0.05], [0.35, 0.2, 0.02], 0.04),
    ];
    let (span, raise) = (random.between(0.75, 1.0), random.between(-0.25, 0.45));
    for side in [-1.0, 1.0] {
        for strip in 0..5 {
            let x = 0.22 - 0.11 * f64::from(strip);
            let end = [x - 0.15, side * (0.2 + span), raise * span];
            limbs.push(Limb::Rod([[x, 0.1 * side, 0.05], end], 0.07));
        }
    }
    limbs
}

fn minus(p: Place, q: Place) -> Place {
    std::array::from_fn(|axis| p[axis] - q[axis])
}

fn plus(p: Place, share: f64, q: Place) -> Place {
    std::array::from_fn(|axis| p[axis] + share * q[axis])
}

fn dot(p: Place, q: Place) -> f64 {
    (0..3).map(|axis| p[axis] * q[axis]).sum()
}

fn unit(p: Place) -> Place {
    let length = norm(p);
    p.map(|side| side / length)
}
