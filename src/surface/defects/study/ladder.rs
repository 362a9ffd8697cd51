//! Real defects by kind, width and height, and how many of them are found.

use std::f64::consts::{PI, TAU};

use super::parts::{Kind, Part, RADIUS_MM, SIGMA_MM};
use super::wanted;
use crate::curvature::truth::Random;
use crate::defects::{Defect, DefectKind};

/// A kind of real defect; widths in spacings.
#[derive(Clone, Copy, Debug)]
enum Real {
    /// A Gaussian dimple of a full width at half of its depth.
    Pit(f64),
    /// A disc with steep flanks.
    Dust(f64),
    /// A straight groove of a width and a length.
    Scratch(f64, f64),
    /// A straight jump over the part.
    Step,
}

/// What was put where.
#[derive(Clone, Copy, Debug)]
struct Put {
    real: Real,
    at: [f64; 2],
    turn: f64,
    spacing_mm: f64,
}

impl Put {
    /// 1 where it is, in units of its height; negative where it goes down.
    fn height(&self, x: f64, y: f64) -> f64 {
        let [x, y] = [x - self.at[0], y - self.at[1]].map(|way| way / self.spacing_mm);
        let (sin, cos) = self.turn.sin_cos();
        let [along, across] = [x * cos + y * sin, y * cos - x * sin];
        match self.real {
            Real::Pit(width) => -(-4.0 * 2.0_f64.ln() * (x * x + y * y) / (width * width)).exp(),
            Real::Dust(width) => f64::from(u8::from(x.hypot(y) <= 0.5 * width)),
            Real::Scratch(width, length) => {
                -f64::from(u8::from(across.abs() <= 0.5 * width && along.abs() <= 0.5 * length))
            }
            Real::Step => f64::from(u8::from(across > 0.0)),
        }
    }

    /// Whether a defect is this one: it lies on it and has its sense.
    fn is(&self, defect: &Defect) -> bool {
        let [x, y, _] = defect.centre_mm;
        let [x, y] = [x - self.at[0], y - self.at[1]].map(|way| way / self.spacing_mm);
        let (sin, cos) = self.turn.sin_cos();
        let [along, across] = [x * cos + y * sin, y * cos - x * sin];
        match self.real {
            Real::Pit(width) => defect.height_mm < 0.0 && x.hypot(y) < 2.0 + 0.5 * width,
            Real::Dust(width) => defect.height_mm > 0.0 && x.hypot(y) < 2.0 + 0.5 * width,
            Real::Scratch(width, length) => {
                defect.height_mm < 0.0
                    && across.abs() < 2.0 + 0.5 * width
                    && along.abs() < 0.5 * length
            }
            Real::Step => defect.kind == DefectKind::Step && across.abs() < 3.0,
        }
    }
}

/// How many of the real ones of a height, in standard deviations of the noise, are found; how many others there are.
fn found(kind: Kind, size: usize, seeds: u64, real: Real, height: f64) -> [usize; 3] {
    let (mut all, mut found, mut others) = (0, 0, 0);
    for seed in 0..seeds {
        let mut part = Part::clean(kind, size, 5000 + seed);
        let spacing_mm = part.spacing_mm;
        let mut random = Random::new(31 * seed + 7);
        let count = match real {
            Real::Step => 1,
            Real::Scratch(..) => 4,
            _ => 8,
        };
        let put: Vec<Put> = (0..count)
            .map(|index| {
                let angle = TAU * (index as f64 / count as f64 + 0.02 * random.unit());
                let away = RADIUS_MM * (0.35 + 0.5 * (index % 2) as f64 + 0.03 * random.unit());
                let at = match real {
                    Real::Step => [0.0, 1.0],
                    _ => [away * angle.cos(), away * angle.sin()],
                };
                Put { real, at, turn: PI * random.unit(), spacing_mm }
            })
            .collect();
        part.add(|x, y| height * SIGMA_MM * put.iter().map(|put| put.height(x, y)).sum::<f64>());
        let search = part.search();
        let is_real = |defect: &&Defect| put.iter().any(|put| put.is(defect));
        all += put.len();
        found += put.iter().filter(|put| search.defects.iter().any(|one| put.is(one))).count();
        others += search.defects.iter().filter(|one| !is_real(one)).count();
    }
    [found, all, others]
}

/// Kinds of defects, their heights, and the share that was found of the second height before noise and windows went by
/// place.
const LADDER: [(Real, [f64; 3], f64); 8] = [
    (Real::Pit(3.0), [3.0, 4.0, 8.0], 1.0),
    (Real::Pit(5.0), [2.0, 3.0, 6.0], 1.0),
    (Real::Pit(8.0), [1.5, 2.0, 5.0], 0.9),
    (Real::Pit(12.0), [1.5, 2.0, 5.0], 0.69),
    (Real::Dust(3.0), [3.0, 4.0, 8.0], 1.0),
    (Real::Scratch(2.0, 30.0), [2.0, 3.0, 6.0], 1.0),
    (Real::Scratch(4.0, 60.0), [1.5, 2.0, 6.0], 0.92),
    (Real::Step, [1.0, 4.0, 8.0], 1.0),
];
/// What fewer than in the long run may be found of a few.
const CHANCE: f64 = 0.2;

/// None of the real ones on parts with white noise may be lost.
#[test]
fn real_defects_are_found() {
    let (size, parts) = wanted()[0];
    let long = parts > 2;
    let kinds = if long { vec![Kind::White, Kind::Rings] } else { vec![Kind::White] };
    let ladder = std::env::var("ASPHERA_DEFECT_LADDER");
    let most = ladder.map_or(6, |text| text.parse().unwrap());
    let mut lost = Vec::new();
    for kind in kinds {
        for (real, heights, least) in LADDER {
            let mut line = format!("{kind:?} {size} {real:?}:");
            for height in if long { &heights[..] } else { &heights[1..2] } {
                let [found, all, others] = found(kind, size, parts.min(most), real, *height);
                line += &format!("  {height} sigma {found}/{all} (+{others})");
                let share = found as f64 / all as f64;
                let judged = kind == Kind::White && *height == heights[1];
                if judged && share < least - CHANCE {
                    lost.push(format!("{real:?} {height} sigma {found}/{all}, {least} before"));
                }
            }
            eprintln!("{line}");
        }
    }
    assert!(lost.is_empty(), "{}", lost.join("\n"));
}
