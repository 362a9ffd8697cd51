//! From joined readings to points in the part frame.

use std::sync::Arc;

use asphera_calibrate::{Axes, AxisErrors, Correction, Machine};
use asphera_clocks::Spread;
use asphera_link::{Flags, Nanos};

use super::profiler::{Carriage, Profiler};
use super::synchronizer::Record;
use super::systematic::Sides;
use super::tilting::Tilting;

/// One measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Which trigger it belongs to, where that is known.
    pub count: Option<u64>,
    /// When its first reading reached the host.
    pub host: Nanos,
    /// x, y, z in mm in the part frame; meaningless where a flag forbids its use.
    pub position_mm: [f64; 3],
    /// What is wrong with it.
    pub flags: Flags,
    /// Standard uncertainty along x, y and z that comes of joining by time, mm; 0 where its axes were read at one trigger.
    pub u_mm: [f64; 3],
}

impl Point {
    /// A point of a record where its axes stand, corrected where there is a correction; a place that the correction does
    /// not reach is flagged.
    pub(super) fn corrected(
        record: &Record,
        axes: Axes,
        correction: Option<&Correction>,
        flags: Flags,
    ) -> Point {
        let corrected = correction.map(|correction| correction.apply(axes));
        match corrected {
            Some(Some(position_mm)) => Point::new(record, position_mm, flags),
            Some(None) => Point::new(record, axes.place_mm(), flags | Flags::OUT_OF_RANGE),
            None => Point::new(record, axes.place_mm(), flags),
        }
    }

    /// A point of a record; a place that is no number is flagged.
    pub(super) fn new(record: &Record, position_mm: [f64; 3], flags: Flags) -> Point {
        let is_finite = position_mm.iter().all(|coordinate| coordinate.is_finite());
        let flags = if is_finite { flags } else { flags | Flags::NOT_FINITE };
        Point { count: record.count, host: record.host, position_mm, flags, u_mm: [0.0; 3] }
    }

    /// Whether the point may be used.
    pub fn is_good(&self) -> bool {
        !self.flags.intersects(UNUSABLE)
    }

    /// Names of its flags, where one of them forbids its use; none of a good point.
    pub fn reasons(&self) -> impl Iterator<Item = &'static str> {
        let flags = if self.is_good() { Flags::empty() } else { self.flags };
        flags.names()
    }
}

/// Flags that forbid the use of a point. A delayed or preceded-by-a-loss reading is noted, and good.
const UNUSABLE: Flags = Flags::all().difference(Flags::TRIGGER_LOST.union(Flags::DELAYED));

/// One axis: which channel moves it and what the channel's value is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Channel that moves it; `None` for one that stands still at its offset.
    pub source: Option<Source>,
    /// mm (or rad, for a rotary axis) per unit of the channel; negative where the axis runs the other way.
    pub scale: f64,
    /// mm (or rad) added after scaling.
    pub offset: f64,
    /// Errors along the axis, which are taken out after that.
    pub errors: Option<Arc<ErrorTable>>,
}

/// Errors of an axis, from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorTable {
    /// Name of the file, as the configuration gives it.
    pub file: String,
    /// What it holds.
    pub errors: AxisErrors,
}

/// A channel of a synchronized device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// Which stream of the synchronizer.
    pub stream: usize,
    /// Which channel of that stream's device.
    pub channel: usize,
}

/// How axes make a position.
#[derive(Clone, Debug, PartialEq)]
pub enum Kinematics {
    /// x, y and z each from an axis: an XY stage under a probe.
    Cartesian {
        /// Along x, mm.
        x: Axis,
        /// Along y, mm.
        y: Axis,
        /// Along z, mm.
        z: Axis,
    },
    /// A turning part, a radial stage, and a probe along the axis of rotation: spirals and rings.
    ///
    /// x = ρ·cos θ, y = ρ·sin θ, z = probe. ρ may be negative: the stage has passed the centre.
    Polar {
        /// θ, rad, counter-clockwise seen from +z.
        rotary: Axis,
        /// ρ, mm.
        radial: Axis,
        /// z, mm.
        probe: Axis,
    },
    /// A line scanner: each record is a profile of many points.
    Line(Profiler),
    /// A probe that tilts about a pivot.
    Tilting(Box<Tilting>),
}

impl Kinematics {
    /// The measured axis that may have stood still where all points lie on a straight line of this direction against x, and the
    /// key that states it. `None` where the line says that it moved, or the station that it does not.
    pub fn stood_still(&self, direction_deg: f64) -> Option<(&'static str, &'static str)> {
        let along = |axis_deg: f64| {
            let off_deg = (direction_deg - axis_deg).rem_euclid(180.0);
            off_deg.min(180.0 - off_deg) < ALONG_DEG
        };
        let measured = |axis: &Axis| axis.source.is_some();
        match self {
            Kinematics::Cartesian { y, .. } if along(0.0) && measured(y) => {
                Some(("y", "constant_mm"))
            }
            Kinematics::Cartesian { x, .. } if along(90.0) && measured(x) => {
                Some(("x", "constant_mm"))
            }
            // A line through the axis of rotation: the part did not turn.
            Kinematics::Polar { rotary, .. } if measured(rotary) => {
                Some(("rotary", "constant_rad"))
            }
            Kinematics::Line(profiler) => match &profiler.carriage {
                Carriage::Linear(axis) if along(profiler.skew_deg()) && measured(axis) => {
                    Some(("along", "constant_mm"))
                }
                Carriage::Turning { rotary, .. } if measured(rotary) => {
                    Some(("rotary", "constant_rad"))
                }
                Carriage::Linear(_) | Carriage::Turning { .. } => None,
            },
            Kinematics::Tilting(tilting) => match &tilting.rotary {
                Some(rotary) => measured(rotary).then_some(("rotary", "constant_rad")),
                None if along(0.0) && measured(&tilting.y) => Some(("y", "constant_mm")),
                None if along(90.0) && measured(&tilting.x) => Some(("x", "constant_mm")),
                None => None,
            },
            Kinematics::Cartesian { .. } | Kinematics::Polar { .. } => None,
        }
    }

    /// The axes, in no particular order.
    pub fn axes(&self) -> Vec<Axis> {
        let axes = match self {
            Kinematics::Cartesian { x, y, z } => vec![x, y, z],
            Kinematics::Polar { rotary, radial, probe } => vec![rotary, radial, probe],
            Kinematics::Line(profiler) => vec![profiler.carriage.axis()],
            Kinematics::Tilting(tilting) => tilting.axes(),
        };
        axes.into_iter().cloned().collect()
    }

    /// Whether a record is one point, so that points are counted by triggers.
    pub fn is_point_by_point(&self) -> bool {
        !matches!(self, Kinematics::Line(_))
    }

    /// Adds the points of a record: at least one, good or flagged. Missing values and flags of any reading involved
    /// become flags of the points. `correction` takes out errors of the machine.
    pub fn points(&self, record: &Record, correction: Option<&Correction>, out: &mut Vec<Point>) {
        let mut flags = record.flags;
        let mut value = |axis: &Axis| axis.value(record, &mut flags);
        let axes = match self {
            Kinematics::Cartesian { x, y, z } => Axes::Cartesian([value(x), value(y), value(z)]),
            Kinematics::Polar { rotary, radial, probe } => Axes::Polar {
                angle_rad: value(rotary),
                radius_mm: value(radial),
                z_mm: value(probe),
            },
            Kinematics::Line(profiler) => return profiler.points(record, correction, out),
            Kinematics::Tilting(tilting) => {
                let (axes, u_mm) = tilting.point(record, &mut flags);
                out.push(Point { u_mm, ..Point::corrected(record, axes, correction, flags) });
                return;
            }
        };
        let u_mm = if record.spreads.is_empty() { [0.0; 3] } else { self.spread_mm(record, &axes) };
        out.push(Point { u_mm, ..Point::corrected(record, axes, correction, flags) });
    }

    /// Notes on which side of the centre the radial axis of a polar machine stands at a record.
    pub(super) fn note_side(&self, record: &Record, sides: &mut Sides) {
        let Kinematics::Polar { radial, .. } = self else { return };
        let mut flags = record.flags;
        let radius_mm = radial.value(record, &mut flags);
        if flags.is_empty() {
            sides.before |= radius_mm > 0.0;
            sides.beyond |= radius_mm < 0.0;
        }
    }

    /// Unit vector along the probe at a record, away from the part, in the part frame.
    pub(super) fn up(&self, record: &Record) -> [f64; 3] {
        match self {
            Kinematics::Tilting(tilting) => tilting.up(record),
            Kinematics::Cartesian { .. } | Kinematics::Polar { .. } | Kinematics::Line(_) => {
                [0.0, 0.0, 1.0]
            }
        }
    }

    /// Standard uncertainties along x, y and z of a record that was joined by time. Those of a turn and a radius come of one
    /// error of time, so they add up.
    fn spread_mm(&self, record: &Record, axes: &Axes) -> [f64; 3] {
        let u = |axis: &Axis| axis.spread(record);
        match (self, *axes) {
            (
                Kinematics::Polar { rotary, radial, probe },
                Axes::Polar { angle_rad, radius_mm, .. },
            ) => {
                let (along_mm, out_mm) = (radius_mm.abs() * u(rotary), u(radial));
                let (sin, cos) = angle_rad.sin_cos();
                let sum = |of_turn: f64, of_radius: f64| {
                    of_turn.abs() * along_mm + of_radius.abs() * out_mm
                };
                [sum(sin, cos), sum(cos, sin), u(probe)]
            }
            (Kinematics::Cartesian { x, y, z }, _) => [u(x), u(y), u(z)],
            (Kinematics::Polar { .. } | Kinematics::Line(_) | Kinematics::Tilting(_), _) => {
                [0.0; 3]
            }
        }
    }

    /// The axis that turns, if there is one.
    pub(crate) fn turning(&self) -> Option<Axis> {
        match self {
            Kinematics::Polar { rotary, .. }
            | Kinematics::Line(Profiler { carriage: Carriage::Turning { rotary, .. }, .. }) => {
                Some(rotary.clone())
            }
            Kinematics::Tilting(tilting) => tilting.rotary.clone(),
            Kinematics::Cartesian { .. } | Kinematics::Line(_) => None,
        }
    }

    /// The machine whose errors a calibration of these axes holds.
    pub fn machine(&self) -> Machine {
        if self.turning().is_some() { Machine::Polar } else { Machine::Cartesian }
    }

    /// The same axes with their bare readings as x, y and z: of a polar machine angle in rad, radius and height. `None` where
    /// three numbers do not hold them: of a line scanner or a tilting probe over a part that turns.
    pub fn bare(self) -> Option<Kinematics> {
        match self {
            Kinematics::Polar { rotary, radial, probe } => {
                Some(Kinematics::Cartesian { x: rotary, y: radial, z: probe })
            }
            other => (other.machine() == Machine::Cartesian).then_some(other),
        }
    }

    /// Whether heights that the probe measures lie along z, so that a map of their errors fits.
    pub fn measures_along_z(&self) -> bool {
        match self {
            Kinematics::Cartesian { .. } | Kinematics::Polar { .. } => true,
            Kinematics::Line(profiler) => profiler.carriage.measures_along_z(),
            Kinematics::Tilting(_) => false,
        }
    }
}

impl Axis {
    /// Where the axis stands at a record; what is wrong with that is added to `flags`.
    pub(super) fn value(&self, record: &Record, flags: &mut Flags) -> f64 {
        let Some(Source { stream, channel }) = self.source else { return self.offset };
        let Some(reading) = record.readings.get(stream).and_then(Option::as_ref) else {
            *flags |= Flags::UNJOINED;
            return 0.0;
        };
        *flags |= reading.flags;
        match reading.values.get(channel) {
            Some(value) => self.corrected(value * self.scale + self.offset, flags),
            None => {
                *flags |= Flags::NO_SIGNAL;
                0.0
            }
        }
    }

    /// The place without the error of the axis; one that its table does not reach is flagged.
    fn corrected(&self, place: f64, flags: &mut Flags) -> f64 {
        let Some(table) = &self.errors else { return place };
        table.errors.corrected(place).unwrap_or_else(|| {
            *flags |= Flags::OUT_OF_RANGE;
            place
        })
    }
}

impl Axis {
    /// Standard uncertainty of where the axis stands, mm or rad; 0 where its channel was measured.
    pub(super) fn spread(&self, record: &Record) -> f64 {
        let Some(Source { stream, channel }) = self.source else { return 0.0 };
        let own = |spread: &&Spread| spread.stream == stream && spread.channel == channel;
        record.spreads.iter().find(own).map_or(0.0, |spread| spread.u * self.scale.abs())
    }
}

/// A line nearer to the direction of an axis may be along it: the other one has moved by less than two thousandths of that.
const ALONG_DEG: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_calibrate::{HeightMap, Parameter};
    use asphera_link::{Reading, Values};
    use std::f64::consts::TAU;

    fn reading(values: &[Option<f64>], flags: Flags) -> Option<Reading> {
        let values: Values = values.iter().copied().collect();
        Some(Reading { host: Nanos::ZERO, device_time_ns: None, count: None, values, flags })
    }

    fn axis(stream: usize, channel: usize, scale: f64, offset: f64) -> Axis {
        Axis { source: Some(Source { stream, channel }), scale, offset, errors: None }
    }

    fn record(readings: Vec<Option<Reading>>) -> Record {
        let (host, flags) = (Nanos::ZERO, Flags::empty());
        Record { count: Some(7), host, readings, flags, spreads: Vec::new() }
    }

    fn polar() -> Kinematics {
        Kinematics::Polar {
            rotary: axis(0, 0, TAU / 3600.0, 0.0),
            radial: axis(1, 0, -1.0, 10.0),
            probe: axis(0, 1, -1.0, 5.0),
        }
    }

    fn point(kinematics: &Kinematics, record: &Record) -> Point {
        let mut points = Vec::new();
        kinematics.points(record, None, &mut points);
        let [point] = points[..] else { panic!("{} points", points.len()) };
        point
    }

    #[test]
    fn quarter_turn_points_along_y() {
        let record = record(vec![
            reading(&[Some(900.0), Some(4.0)], Flags::empty()),
            reading(&[Some(7.0)], Flags::empty()),
        ]);
        let point = point(&polar(), &record);
        let [x, y, z] = point.position_mm;
        assert!(x.abs() < 1e-15 && (y - 3.0).abs() < 1e-15 && z == 1.0, "{point:?}");
        assert!(point.is_good());
    }

    #[test]
    fn what_is_missing_is_flagged_never_zero() {
        let lonely = record(vec![reading(&[Some(0.0), Some(1.0)], Flags::empty()), None]);
        assert_eq!(point(&polar(), &lonely).flags, Flags::UNJOINED);
        let blind = record(vec![
            reading(&[Some(0.0), None], Flags::WEAK),
            reading(&[Some(1.0)], Flags::empty()),
        ]);
        let point = point(&polar(), &blind);
        assert_eq!(point.flags, Flags::NO_SIGNAL | Flags::WEAK);
        assert!(!point.is_good());
    }

    #[test]
    fn an_axis_that_stands_still_needs_no_reading() {
        let profile = Kinematics::Cartesian {
            x: axis(0, 0, 1.0, 0.0),
            y: Axis { source: None, ..axis(0, 0, 1.0, 4.0) },
            z: axis(0, 1, 1.0, 0.0),
        };
        let point =
            point(&profile, &record(vec![reading(&[Some(1.0), Some(2.0)], Flags::empty())]));
        assert_eq!((point.position_mm, point.is_good()), ([1.0, 4.0, 2.0], true));
    }

    #[test]
    fn a_delayed_reading_is_noted_and_used() {
        let cartesian = Kinematics::Cartesian {
            x: axis(0, 0, 1.0, 0.0),
            y: axis(0, 1, 1e-3, 0.0),
            z: axis(0, 2, 1.0, -1.0),
        };
        let late = record(vec![reading(&[Some(1.0), Some(2000.0), Some(1.5)], Flags::DELAYED)]);
        let point = point(&cartesian, &late);
        assert_eq!(point.position_mm, [1.0, 2.0, 0.5]);
        assert!(point.is_good() && point.flags == Flags::DELAYED);
    }

    #[test]
    fn a_line_tells_which_axis_may_have_stood_still() {
        let moved = |channel| axis(0, channel, 1.0, 0.0);
        let still = || Axis { source: None, ..moved(0) };
        let stage = |x, y| Kinematics::Cartesian { x, y, z: moved(2) };
        let both = stage(moved(0), moved(1));
        assert_eq!(both.stood_still(179.99), Some(("y", "constant_mm")));
        assert_eq!(both.stood_still(-90.0), Some(("x", "constant_mm")));
        assert_eq!(both.stood_still(30.0), None);
        assert_eq!(stage(moved(0), still()).stood_still(0.0), None);
        assert_eq!(stage(still(), moved(0)).stood_still(90.0), None);
        let polar = |rotary| Kinematics::Polar { rotary, radial: moved(1), probe: moved(2) };
        assert_eq!(polar(moved(0)).stood_still(30.0), Some(("rotary", "constant_rad")));
        assert_eq!(polar(still()).stood_still(30.0), None);
    }

    /// An axis that indicates 10 µm too much at 2 mm is 1.99 mm along; what its table does not reach is flagged.
    #[test]
    fn errors_of_an_axis_are_taken_out_and_places_off_its_table_flagged() {
        let errors = AxisErrors::linear(vec![[0.0, 0.0], [4.0, 0.02]]).unwrap();
        let named = |errors| Some(Arc::new(ErrorTable { file: "axis.csv".to_owned(), errors }));
        let x = Axis { errors: named(errors), ..axis(0, 0, 1e-3, 1.0) };
        let table = AxisErrors::rotary(vec![[0.0, 0.0], [1.0, 1e-4]]).unwrap();
        let rotary = Axis { errors: named(table), ..axis(0, 0, 1e-3, 1.0) };
        let cartesian =
            Kinematics::Cartesian { x, y: axis(0, 1, 1.0, 0.0), z: axis(0, 2, 1.0, 0.0) };
        let at = |kinematics: &Kinematics, channel: f64| {
            let values = [Some(channel), Some(5.0), Some(6.0)];
            point(kinematics, &record(vec![reading(&values, Flags::empty())]))
        };
        assert_eq!(at(&cartesian, 1000.0).position_mm, [1.99, 5.0, 6.0]);
        assert!(at(&cartesian, 1000.0).is_good());
        assert_eq!(at(&cartesian, 3500.0).flags, Flags::OUT_OF_RANGE);
        assert_eq!(at(&cartesian, 3500.0).position_mm, [4.5, 5.0, 6.0]);
        let polar =
            Kinematics::Polar { rotary, radial: axis(0, 1, 1.0, 0.0), probe: axis(0, 2, 1.0, 0.0) };
        let [x, y, _] = at(&polar, -500.0).position_mm;
        assert!((x - 5.0 * (0.5_f64 - 5e-5).cos()).abs() < 1e-15);
        assert!((y - 5.0 * (0.5_f64 - 5e-5).sin()).abs() < 1e-15);
        assert_eq!(at(&polar, 500.0).flags, Flags::OUT_OF_RANGE);
    }

    #[test]
    fn errors_of_the_machine_are_taken_out_and_places_off_its_map_flagged() {
        let values = vec![(Parameter::OffsetRadial, 0.5), (Parameter::ScaleZ, 0.1)];
        let map = HeightMap::new(4.0, vec![(2, 0, 0.0)]);
        let correction = Correction::new(Machine::Polar, values, map).unwrap();
        let at = |radius: f64| {
            let record = record(vec![
                reading(&[Some(900.0), Some(4.0)], Flags::empty()),
                reading(&[Some(10.0 - radius)], Flags::empty()),
            ]);
            let mut points = Vec::new();
            polar().points(&record, Some(&correction), &mut points);
            points[0]
        };
        // A quarter turn: outwards is along y.
        let [x, y, z] = at(3.0).position_mm;
        assert!(x.abs() < 1e-15 && (y - 3.5).abs() < 1e-15 && (z - 1.1).abs() < 1e-15);
        assert!(at(3.0).is_good());
        assert_eq!(at(-3.0).position_mm[1], -2.5, "beyond the centre");
        assert_eq!(at(5.0).flags, Flags::OUT_OF_RANGE);
        assert!(!at(5.0).is_good());
    }

    #[test]
    fn uncertainties_of_the_axes_become_those_of_the_place() {
        let spread = |channel: usize, u: f64| Spread { stream: 1, channel, u };
        // An eighth of a turn, 7 mm out; a count of the angle is 2π/3600.
        let polar = Kinematics::Polar {
            rotary: axis(1, 0, TAU / 3600.0, 0.0),
            radial: axis(1, 1, -1.0, 10.0),
            probe: axis(0, 0, -1.0, 5.0),
        };
        let readings = vec![
            reading(&[Some(4.0)], Flags::empty()),
            reading(&[Some(450.0), Some(3.0)], Flags::empty()),
        ];
        let spreads = vec![spread(0, 2.0), spread(1, 0.001)];
        let record = Record { spreads, ..record(readings) };
        let [x, y, z] = point(&polar, &record).u_mm;
        let expected = (7.0 * 2.0 * TAU / 3600.0 + 0.001) * 0.5_f64.sqrt();
        assert!((x - expected).abs() < 1e-12 && (y - expected).abs() < 1e-12 && z == 0.0);
        let stage = Kinematics::Cartesian {
            x: axis(1, 0, 1e-3, 0.0),
            y: axis(1, 1, -1.0, 0.0),
            z: axis(0, 0, 1.0, 0.0),
        };
        assert_eq!(point(&stage, &record).u_mm, [0.002, 0.001, 0.0]);
    }
}
