//! How much of a cell each reconstruction fills, by code: tables exact to 1e-11.

use crate::cell::{EDGES, FACES};
use crate::codes::facts;
use crate::majority::{Majority, SplitCell};
use crate::quadrature::{gauss, integral};
use crate::surface::area_and_volume;
use crate::table::{Ambiguity, Table};

/// A table over the codes: the share of a cell that is inside, 0 to 1.
pub type Fractions = [f64; 256];

/// A table made class by class.
fn by_class(fraction: impl Fn(u8) -> f64) -> Fractions {
    let mut of_class: [Option<f64>; 256] = [None; 256];
    std::array::from_fn(|code| {
        let class = facts()[code].class;
        *of_class[usize::from(class)].get_or_insert_with(|| fraction(class))
    })
}

/// Voxels: an eighth a foreground corner.
pub fn voxel_fractions() -> Fractions {
    std::array::from_fn(|code| f64::from((code as u8).count_ones()) / 8.0)
}

/// Majority interpolation: whole numbers of 64ths.
pub fn majority_fractions(which: Majority) -> Fractions {
    std::array::from_fn(|code| SplitCell::of(code as u8, which).share())
}

/// Marching cubes with vertices at the middles of the edges.
///
/// ```text
/// 3V = Σ over the cell's faces of ½ · foreground area + Σ over triangles of x · n · area, from the centre of the cell
/// ```
pub fn marching_fractions(rule: Ambiguity) -> Fractions {
    let table = Table::of(rule);
    std::array::from_fn(|code| {
        let code = code as u8;
        let faces = FACES.iter().enumerate().map(|(index, corners)| {
            let inside = corners.iter().filter(|&&corner| code >> corner & 1 == 1).count();
            let is_c1 = facts()[usize::from(code)].c1_faces >> index & 1 == 1;
            match (inside, is_c1, table.joins(code)) {
                (2, true, false) => 0.25,
                (2, true, true) => 0.75,
                (inside, ..) => [0.0, 0.125, 0.5, 0.875, 1.0][inside],
            }
        });
        let area: f64 = faces.sum();
        let triangles = table.cut(code).triangles.iter().map(|edges| {
            let [a, b, c] = edges.map(|edge| middle(usize::from(edge)));
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        });
        area / 6.0 + triangles.sum::<f64>() / 6.0
    })
}

/// The area of the triangles of modified marching cubes in a cell of each code, in squares of the spacing.
pub(crate) fn marching_areas() -> Fractions {
    let table = Table::of(Ambiguity::Paired);
    std::array::from_fn(|code| {
        let triangles = table.cut(code as u8).triangles.iter().map(|edges| {
            let corners = edges.map(|edge| middle(usize::from(edge)));
            area_and_volume(corners[0], corners).0
        });
        triangles.sum()
    })
}

/// The middle of an edge, from the centre of the cell.
fn middle(edge: usize) -> [f64; 3] {
    let [a, b] = EDGES[edge];
    std::array::from_fn(|axis| ((a >> axis & 1) + (b >> axis & 1)) as f64 / 2.0 - 0.5)
}

/// Trilinear interpolation of ±1.
pub fn trilinear_fractions() -> Fractions {
    by_class(|code| {
        let corner = |at: usize| if code >> at & 1 == 1 { 1.0 } else { -1.0 };
        let slice = |z: f64| {
            let along = |at: usize| corner(at) + (corner(at + 4) - corner(at)) * z;
            bilinear_share([along(0), along(1), along(2), along(3)])
        };
        // Values of corners change sign in the middle of their edges only.
        integral(&slice, 0.0, 0.5, TOLERANCE) + integral(&slice, 0.5, 1.0, TOLERANCE)
    })
}

const TOLERANCE: f64 = 1e-14;

/// The share of a square in which the bilinear function with these corner values (x fastest) is above 0.
fn bilinear_share([a, b, c, d]: [f64; 4]) -> f64 {
    let (lower, upper) = ((a, b - a), (c, d - c));
    let at = |(start, slope): (f64, f64), x: f64| start + slope * x;
    let mut breaks = vec![0.0, 1.0];
    for (start, slope) in [lower, upper] {
        let root = -start / slope;
        if root > 0.0 && root < 1.0 {
            breaks.push(root);
        }
    }
    breaks.sort_by(f64::total_cmp);
    let pieces = breaks.windows(2).map(|ends| {
        let [from, to] = [ends[0], ends[1]];
        let middle = f64::midpoint(from, to);
        let (p, q) = match (at(lower, middle) > 0.0, at(upper, middle) > 0.0) {
            (true, true) => return to - from,
            (false, false) => return 0.0,
            (true, false) => (lower, upper),
            (false, true) => (upper, lower),
        };
        ratio_integral(p, (p.0 - q.0, p.1 - q.1), from, to)
    });
    pieces.sum()
}

/// ∫ (p₀ + p₁x) / (d₀ + d₁x) dx; the denominator is above 0.
fn ratio_integral(p: (f64, f64), d: (f64, f64), from: f64, to: f64) -> f64 {
    let [at_from, at_to] = [d.0 + d.1 * from, d.0 + d.1 * to];
    // A denominator that hardly changes would cancel in the closed form; then the integrand is nearly linear.
    if (at_to - at_from).abs() < 0.05 * at_from.max(at_to) {
        return gauss(&|x: f64| (p.0 + p.1 * x) / (d.0 + d.1 * x), from, to);
    }
    let slope = p.1 / d.1;
    // Where the denominator vanishes both lines do, and their ratio is the same all along.
    if at_from <= 0.0 || at_to <= 0.0 {
        return slope * (to - from);
    }
    slope * (to - from) + (p.0 - slope * d.0) / d.1 * (at_to / at_from).ln()
}

/// Balls of a radius from ½ to 1 about the foreground corners.
pub fn ball_fractions(radius: f64) -> Fractions {
    by_class(|code| {
        let is_inside = |at: usize| code >> at & 1 == 1;
        let slice = |z: f64| {
            let square_at = |corner: usize, height: f64| {
                if is_inside(corner) { (radius * radius - height * height).max(0.0) } else { 0.0 }
            };
            // At every corner of the slice the larger of the two discs counts.
            let squares = std::array::from_fn(|corner| {
                square_at(corner, z).max(square_at(corner + 4, 1.0 - z))
            });
            disc_share(squares)
        };
        // Discs of the two sides are equal in the middle, begin at their poles, and touch neighbours at these heights.
        let mut breaks = vec![0.0, 0.5, 1.0, radius, 1.0 - radius];
        for least in [0.25, 0.5] {
            let height = (radius * radius - least).max(0.0).sqrt();
            breaks.extend([height, 1.0 - height]);
        }
        breaks.retain(|&height| (0.0..=1.0).contains(&height));
        breaks.sort_by(f64::total_cmp);
        breaks.windows(2).map(|ends| integral(&slice, ends[0], ends[1], TOLERANCE)).sum()
    })
}

/// The share of a unit square that discs about its corners cover; the squares of their radii are below 1, x fastest.
///
/// Over x the two sides' heights add up, to 1 at most. Between the x at which another disc becomes the higher one, or the
/// sum reaches 1, the integral has a closed form.
fn disc_share(squares: [f64; 4]) -> f64 {
    let centre = |corner: usize| (corner & 1) as f64;
    let height =
        |corner: usize, x: f64| (squares[corner] - (x - centre(corner)).powi(2)).max(0.0).sqrt();
    let mut breaks = vec![0.0, 1.0];
    for (corner, square) in squares.iter().enumerate() {
        let radius = square.sqrt();
        breaks.push(if corner & 1 == 0 { radius } else { 1.0 - radius });
    }
    for side in [0, 2] {
        // Where two circles about (0, y) and (1, y) meet.
        breaks.push((squares[side] - squares[side + 1] + 1.0) / 2.0);
    }
    for lower in 0..2 {
        for upper in 2..4 {
            breaks.extend(meetings(squares[lower], squares[upper], centre(lower), centre(upper)));
        }
    }
    breaks.retain(|x| (0.0..=1.0).contains(x));
    breaks.sort_by(f64::total_cmp);
    let pieces = breaks.windows(2).map(|ends| {
        let middle = f64::midpoint(ends[0], ends[1]);
        let higher =
            |a: usize, b: usize| if height(a, middle) >= height(b, middle) { a } else { b };
        let (lower, upper) = (higher(0, 1), higher(2, 3));
        if height(lower, middle) + height(upper, middle) >= 1.0 {
            return ends[1] - ends[0];
        }
        let area = |corner: usize| {
            if height(corner, middle) == 0.0 {
                return 0.0;
            }
            let of = |x: f64| circle_integral(squares[corner], x - centre(corner));
            of(ends[1]) - of(ends[0])
        };
        area(lower) + area(upper)
    });
    pieces.sum()
}

/// ∫ √(r² − u²) du from 0 to u.
fn circle_integral(square: f64, u: f64) -> f64 {
    let radius = square.sqrt();
    let u = u.clamp(-radius, radius);
    // An error of the height cancels between both terms; that of an arc sine would not.
    let height = ((radius - u) * (radius + u)).sqrt();
    (u * height + square * u.atan2(height)) / 2.0
}

/// The x at which circles about (x₁, 0) and (x₂, 1) meet.
fn meetings(square_1: f64, square_2: f64, x_1: f64, x_2: f64) -> Vec<f64> {
    let (dx, dy) = (x_2 - x_1, 1.0);
    let distance_square = dx * dx + dy * dy;
    let along = (square_1 - square_2 + distance_square) / (2.0 * distance_square);
    let across_square = square_1 / distance_square - along * along;
    if across_square < 0.0 {
        return Vec::new();
    }
    let across = across_square.sqrt();
    vec![x_1 + along * dx - across * dy, x_1 + along * dx + across * dy]
}

/// Cubes of a side from ½ to 1 in the foreground corners of a cell.
pub(crate) fn cube_fractions(side: f64) -> Fractions {
    // Each axis is cut where a cube ends: only the lower one, both, only the upper one.
    let widths = [1.0 - side, 2.0 * side - 1.0, 1.0 - side];
    let reaches = |at: usize, bit: usize| at == 1 || at == 2 * bit;
    std::array::from_fn(|code| {
        let mut sum = 0.0;
        for part in 0..27 {
            let at = [part % 3, part / 3 % 3, part / 9];
            let is_covered = (0..8_usize).any(|corner| {
                code >> corner & 1 == 1 && (0..3).all(|axis| reaches(at[axis], corner >> axis & 1))
            });
            if is_covered {
                sum += at.iter().map(|&at| widths[at]).product::<f64>();
            }
        }
        sum
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconstruct::BALL_RADIUS;

    /// The guide's figures, made by sampling (± 0.002) or exact.
    #[test]
    fn tables_hold_known_figures() {
        let (mi, cmi) =
            (majority_fractions(Majority::Foreground), majority_fractions(Majority::Complement));
        let (ti, balls) = (trilinear_fractions(), ball_fractions(BALL_RADIUS));
        for (code, of_mi, of_cmi, of_ti, of_balls) in [
            (0b0000_0001, 0.015_625, 0.109_375, 0.0333, 0.4253),
            (0b0000_0011, 0.0625, 0.3125, 0.1535, 0.6183),
            (0b0000_0111, 0.171_875, 0.453_125, 0.3152, 0.7748),
            (0b0000_1111, 0.25, 0.75, 0.5, 0.8365),
            (0b0001_0111, 0.34375, 0.65625, 0.5, 0.8952),
            (0b0001_1011, 0.28125, 0.71875, 0.5, 0.9258),
            (0b0000_0110, 0.03125, 0.28125, 0.0888, 0.7131),
        ] {
            assert_eq!((mi[code], cmi[code]), (of_mi, of_cmi), "{code:08b}");
            assert!((ti[code] - of_ti).abs() < 0.002, "{code:08b} {}", ti[code]);
            assert!((balls[code] - of_balls).abs() < 0.002, "{code:08b} {}", balls[code]);
        }
        assert_eq!((ti[0], balls[0], mi[0]), (0.0, 0.0, 0.0));
        assert!([ti[255], balls[255], mi[255]].iter().all(|full| (full - 1.0).abs() < 1e-12));
    }

    /// One corner: an eighth of a ball; and the volume of {u > 0} in closed form.
    #[test]
    fn one_corner_has_a_closed_form() {
        for radius in [0.6, 0.866, 0.999] {
            let eighth = std::f64::consts::PI / 6.0 * f64::powi(radius, 3);
            assert!((ball_fractions(radius)[1] - eighth).abs() < 1e-11);
            // Two corners: less the lens of two balls one spacing apart, a quarter of which lies in the cell.
            let lens =
                std::f64::consts::PI * (4.0 * radius + 1.0) * (2.0 * radius - 1.0).powi(2) / 12.0;
            let two = ball_fractions(radius)[3];
            assert!((two - (2.0 * eighth - lens / 4.0)).abs() < 1e-11, "{radius} {two}");
        }
        // xyz > ½ within the unit cube: 1 − ½ (1 + ln 2 + ½ ln² 2).
        let ln_2 = std::f64::consts::LN_2;
        let exact = 1.0 - 0.5 * (1.0 + ln_2 + ln_2 * ln_2 / 2.0);
        assert!((trilinear_fractions()[1] - exact).abs() < 1e-11);
    }

    #[test]
    fn complements_add_up() {
        let (mi, cmi) =
            (majority_fractions(Majority::Foreground), majority_fractions(Majority::Complement));
        let ti = trilinear_fractions();
        let (apart, joined) =
            (marching_fractions(Ambiguity::Apart), marching_fractions(Ambiguity::Joined));
        for code in 0..256 {
            assert!((mi[code] + cmi[255 - code] - 1.0).abs() < 1e-15);
            let sum = ti[code] + ti[255 - code];
            assert!((sum - 1.0).abs() < 1e-11, "{code:08b} {sum}");
            assert!((apart[code] + joined[255 - code] - 1.0).abs() < 1e-12, "{code:08b}");
        }
        let cubes = cube_fractions(0.5);
        assert!((0..256).all(|code| (cubes[code] - voxel_fractions()[code]).abs() < 1e-15));
    }
}
