//! Commands that move the machine, and the points they give.

use std::collections::VecDeque;

use asphera_ippdme::wire::{Argument, Call, Severity};

use super::basics::TOOLS;
use super::{Column, Done, Failure, Machine, PARKED_MM};
use crate::motion::{Path, Place, distance};
use crate::noise::standard_normal;

const BAD_ARGUMENT: Failure = (Severity::Critical, 509, "Bad argument");
const NOT_FOUND: Failure = (Severity::Error, 1006, "Surface not found");

impl Machine {
    pub(super) fn move_by(&mut self, now_s: f64, call: &Call) -> Result<Done, Failure> {
        match call.name.as_str() {
            "Home" => return Ok(self.home(now_s)),
            "ChangeTool" => return self.change_tool(now_s, call),
            _ => {}
        }
        if !self.is_homed {
            return Err((Severity::Critical, 2501, "Axis not active"));
        }
        if call.name == "GoTo" {
            let mut path = Path::new(now_s, self.place);
            path.go(self.within(self.target(call)?)?, self.settings.speed_mm_s);
            return Ok(Done::Later(path, VecDeque::new(), None));
        }
        if self.tool.as_deref().is_none_or(|tool| tool == TOOLS[0]) {
            return Err((Severity::Critical, 1503, "Tool not defined"));
        }
        match call.name.as_str() {
            "PtMeas" => self.measure_point(now_s, call),
            "ScanOnLine" => {
                let places = line(call)?;
                self.scan(now_s, &places)
            }
            _ => {
                let places = circle(call)?;
                self.scan(now_s, &places)
            }
        }
    }

    fn home(&mut self, now_s: f64) -> Done {
        let mut path = Path::new(now_s, self.place);
        path.go(PARKED_MM, self.settings.speed_mm_s);
        self.is_homed = true;
        Done::Later(path, VecDeque::new(), None)
    }

    fn change_tool(&mut self, now_s: f64, call: &Call) -> Result<Done, Failure> {
        let [Argument::Text(tool)] = &call.arguments[..] else { return Err(BAD_ARGUMENT) };
        if !TOOLS.contains(&tool.as_str()) {
            return Err((Severity::Critical, 1502, "Tool not found"));
        }
        self.tool = Some(tool.clone());
        Ok(Done::Later(Path::new(now_s, self.place), VecDeque::new(), None))
    }

    /// The place of `X(..)`, `Y(..)`, `Z(..)`; an axis that is left out stays where it is.
    fn target(&self, call: &Call) -> Result<Place, Failure> {
        let mut place = self.place;
        for (name, coordinate) in ["X", "Y", "Z"].into_iter().zip(&mut place) {
            if let Some(group) = call.group(name) {
                match group.numbers().as_deref() {
                    Some([value]) => *coordinate = *value,
                    _ => return Err(BAD_ARGUMENT),
                }
            }
        }
        Ok(place)
    }

    fn within(&self, place: Place) -> Result<Place, Failure> {
        let reach_mm = self.settings.reach_mm;
        let is_within = place.iter().all(|coordinate| coordinate.abs() <= reach_mm);
        let beyond = (Severity::Critical, 1008, "Target position out of machine volume");
        is_within.then_some(place).ok_or(beyond)
    }

    /// Approaches a place from above, touches, and goes back.
    fn measure_point(&mut self, now_s: f64, call: &Call) -> Result<Done, Failure> {
        let target = self.within(self.target(call)?)?;
        if let Some(group) = call.group("IJK") {
            require_vertical(&group.numbers().ok_or(BAD_ARGUMENT)?)?;
        }
        let [x, y, z] = target;
        let above = [x, y, z + self.settings.probe.radius_mm + APPROACH_MM];
        let lowest = z + self.settings.probe.radius_mm - SEARCH_MM;
        let mut path = Path::new(now_s, self.place);
        path.go(above, self.settings.speed_mm_s);
        let is_missed = std::mem::take(&mut self.misses_next);
        let found = self.touch([x, y]).filter(|[_, _, z]| *z >= lowest && !is_missed);
        let Some(touched) = found else {
            path.go([x, y, lowest], self.settings.touch_mm_s);
            return Ok(Done::Later(path, VecDeque::new(), Some(NOT_FOUND)));
        };
        let touched_s = path.go(touched, self.settings.touch_mm_s);
        let columns = self.point_columns.clone();
        let items = columns.iter().map(|column| self.item(*column, touched, 0.0));
        let data = format!("# {}", items.collect::<Vec<_>>().join(", "));
        path.go(above, self.settings.speed_mm_s);
        Ok(Done::Later(path, VecDeque::from([(touched_s, data)]), None))
    }

    /// Follows the part over places, and sends points in lines.
    fn scan(&mut self, now_s: f64, places: &[[f64; 2]]) -> Result<Done, Failure> {
        let mut path = Path::new(now_s, self.place);
        let (mut answers, mut numbers) = (VecDeque::new(), Vec::new());
        for (index, &place) in places.iter().enumerate() {
            let Some(touched) = self.touch(place) else {
                return Ok(Done::Later(path, answers, Some(NOT_FOUND)));
            };
            self.within(touched)?;
            let speed = match index {
                0 => self.settings.speed_mm_s,
                _ => self.settings.scan_mm_s,
            };
            let at_s = path.go(touched, speed);
            let is_poor = self.poor_points > 0;
            self.poor_points = self.poor_points.saturating_sub(1);
            let quality = if is_poor { 80.0 } else { 0.0 };
            let columns = self.scan_columns.iter();
            numbers.extend(columns.map(|column| self.value(*column, touched, quality)));
            if (index + 1) % self.settings.points_a_line == 0 || index + 1 == places.len() {
                if std::mem::take(&mut self.is_next_line_odd) {
                    numbers.push(0.0);
                }
                let texts: Vec<String> =
                    numbers.drain(..).map(|number: f64| format!("{number:.5}")).collect();
                answers.push_back((at_s, format!("# {}", texts.join(","))));
            }
        }
        let (_, [x, y, z]) = path.end();
        path.go([x, y, z + APPROACH_MM], self.settings.speed_mm_s);
        Ok(Done::Later(path, answers, None))
    }

    /// Place of the ball where it touches the part over a place, with noise.
    fn touch(&mut self, place: [f64; 2]) -> Option<Place> {
        let centre_mm = self.settings.probe.centre_mm(place)?;
        let noise = standard_normal(self.settings.seed, self.points);
        self.points += 1;
        Some([place[0], place[1], centre_mm + self.settings.noise_nm * 1e-6 * noise])
    }

    fn value(&self, column: Column, [x, y, z]: Place, quality: f64) -> f64 {
        match column {
            Column::X => x,
            Column::Y => y,
            Column::Z => z,
            Column::Q => quality,
            Column::Er => self.settings.probe.radius_mm,
        }
    }

    pub(super) fn item(&self, column: Column, place: Place, quality: f64) -> String {
        let name = match column {
            Column::X => "X",
            Column::Y => "Y",
            Column::Z => "Z",
            Column::Q => "Q",
            Column::Er => "ER",
        };
        format!("{name}({:.5})", self.value(column, place, quality))
    }
}

/// The probe comes from above; other directions are not simulated.
fn require_vertical(direction: &[f64]) -> Result<(), Failure> {
    match *direction {
        [i, j, k] if k > 0.0 && i.hypot(j) <= 0.2 * k => Ok(()),
        [_, _, _] => Err((Severity::Critical, 506, "Argument not supported")),
        _ => Err(BAD_ARGUMENT),
    }
}

/// Places of `ScanOnLine(Sx,Sy,Sz,Ex,Ey,Ez,i,j,k,StepW)`.
fn line(call: &Call) -> Result<Vec<[f64; 2]>, Failure> {
    let numbers = call.numbers().ok_or(BAD_ARGUMENT)?;
    let [sx, sy, sz, ex, ey, ez, i, j, k, step] = numbers[..] else { return Err(BAD_ARGUMENT) };
    require_vertical(&[i, j, k])?;
    let count = steps(distance([sx, sy, sz], [ex, ey, ez]), step)?;
    let place = |at: usize| {
        let part = at as f64 / count as f64;
        [sx + part * (ex - sx), sy + part * (ey - sy)]
    };
    Ok((0..=count).map(place).collect())
}

/// Places of `ScanOnCircle(Cx,Cy,Cz,Sx,Sy,Sz,i,j,k,delta,sfa,StepW)`, on a plane: the surface angle is 90 or 270 degrees.
fn circle(call: &Call) -> Result<Vec<[f64; 2]>, Failure> {
    let numbers = call.numbers().ok_or(BAD_ARGUMENT)?;
    let [cx, cy, _, sx, sy, _, i, j, k, delta_deg, sfa_deg, step_deg] = numbers[..] else {
        return Err(BAD_ARGUMENT);
    };
    require_vertical(&[i, j, k])?;
    if ![90.0, 270.0].contains(&sfa_deg) {
        return Err((Severity::Critical, 506, "Argument not supported"));
    }
    let count = steps(delta_deg.abs(), step_deg)?;
    let place = |at: usize| {
        let (sin, cos) = (delta_deg * at as f64 / count as f64).to_radians().sin_cos();
        [cx + cos * (sx - cx) - sin * (sy - cy), cy + sin * (sx - cx) + cos * (sy - cy)]
    };
    Ok((0..=count).map(place).collect())
}

fn steps(length: f64, step: f64) -> Result<usize, Failure> {
    let count = (length / step).round();
    if step > 0.0 && (1.0..=MOST_POINTS).contains(&count) {
        Ok(count as usize)
    } else {
        Err((Severity::Critical, 504, "Argument out of range"))
    }
}

/// Way in mm before a touch, and back after it.
const APPROACH_MM: f64 = 2.0;
/// Way in mm below the place of the command.
const SEARCH_MM: f64 = 3.0;
/// Most points of a scan.
const MOST_POINTS: f64 = 1e6;
