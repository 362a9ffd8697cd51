//! The pieces of a curve with what is fitted to them, and the features that they make.

use std::f64::consts::PI;

use super::element::{Element, Shape, figure};
use super::joint::{Joint, area_and_length, between_lines, ends_mm, overlap_mm, sweep, turn};
use super::pieces::{Cut, Form, Piece};
use super::profile::{Estimate, Feature};
use crate::PlaceMm;
use crate::bridges::{SHOWN_TURN, far_edges, turn_over};
use crate::triangulation::distance_mm;

/// A piece and, if points suffice, what is fitted to them.
struct Fitted {
    piece: Piece,
    /// The points that count: from the first to before the end.
    counting: [usize; 2],
    element: Option<Element>,
}

/// The pieces of a curve with their joints.
pub(super) struct Joined {
    places_mm: Vec<PlaceMm>,
    closed: bool,
    fitted: Vec<Fitted>,
    /// Of each piece with the next; of a closed curve of the last with the first, too. None where one of both is not fitted.
    joints: Vec<Option<Joint>>,
}

impl Joined {
    /// The pieces of a cut, fitted; points within 3 σ of the piece beside theirs do not count.
    pub(super) fn new(cut: &Cut, sigma_mm: f64) -> Joined {
        let places_mm = cut.course.places_mm().to_vec();
        let whole = |&piece: &Piece| {
            let counting = [piece.first, piece.end];
            Fitted { piece, counting, element: element(&places_mm[piece.first..piece.end], piece) }
        };
        let fitted: Vec<Fitted> = cut.pieces.iter().map(whole).collect();
        let closed = cut.course.is_closed();
        let mut joined = Joined { places_mm, closed, fitted, joints: Vec::new() };
        for _ in 0..2 {
            joined.leave_out_ends(sigma_mm);
        }
        joined.weigh();
        joined.joints = (0..joined.sides()).map(|index| joined.joint(index)).collect();
        joined
    }

    /// How many pieces go over into another.
    fn sides(&self) -> usize {
        let count = self.fitted.len();
        if self.closed && count > 1 { count } else { count - 1 }
    }

    /// Fits each piece to those of its points that the pieces beside it do not claim.
    fn leave_out_ends(&mut self, sigma_mm: f64) {
        let count = self.fitted.len();
        let shape = |index: usize| self.fitted[index].element.map(|element| element.shape);
        let counting: Vec<[usize; 2]> = (0..count)
            .map(|index| {
                let Piece { first, end, .. } = self.fitted[index].piece;
                let Some(own) = shape(index) else { return [first, end] };
                let has = |side: bool| side || (self.closed && count > 1);
                let before = has(index > 0).then(|| shape((index + count - 1) % count)).flatten();
                let after = has(index + 1 < count).then(|| shape((index + 1) % count)).flatten();
                let is_claimed = |other: Option<Shape>, point: usize| {
                    let foot = own.foot_mm(self.places_mm[point]);
                    other.is_some_and(|other| other.distance_mm(foot) < APART * sigma_mm)
                };
                let from = (first..end).find(|&point| !is_claimed(before, point)).unwrap_or(end);
                let to = (from..end).rev().find(|&point| !is_claimed(after, point));
                [from, to.map_or(from, |point| point + 1)]
            })
            .collect();
        for (fitted, counting) in self.fitted.iter_mut().zip(counting) {
            fitted.counting = counting;
            fitted.element = element(&self.places_mm[counting[0]..counting[1]], fitted.piece);
        }
    }

    /// Gives every element its σ: by its own points where [`SPARE`] are to spare, else by those of all.
    fn weigh(&mut self) {
        let elements = || self.fitted.iter().filter_map(|fitted| fitted.element);
        let squares_mm2: f64 = elements().map(|element| element.squares_mm2).sum();
        let spare: usize = elements().map(|element| element.spare()).sum();
        for element in self.fitted.iter_mut().filter_map(|fitted| fitted.element.as_mut()) {
            let own = (element.squares_mm2, element.spare());
            let (squares_mm2, spare) = if own.1 >= SPARE { own } else { (squares_mm2, spare) };
            element.sigma_mm = (squares_mm2 / spare as f64).sqrt();
        }
    }

    fn joint(&self, index: usize) -> Option<Joint> {
        let next = (index + 1) % self.fitted.len();
        let [p, q] = [
            self.places_mm[self.fitted[index].piece.end - 1],
            self.places_mm[self.fitted[next].piece.first],
        ];
        let near = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let length_mm = |index: usize| {
            let Piece { first, end, .. } = self.fitted[index].piece;
            distance_mm(self.places_mm[first], self.places_mm[end - 1])
        };
        let reach_mm = REACH * length_mm(index).min(length_mm(next)) + distance_mm(p, q);
        let elements = [self.fitted[index].element?, self.fitted[next].element?];
        let shapes = [&elements[0].shape, &elements[1].shape];
        let overlap = figure(&elements, |shapes| Some([overlap_mm([&shapes[0], &shapes[1]])?]));
        // Noise lets pieces that touch cross at a small angle, or miss each other.
        let may_touch =
            overlap.is_some_and(|([overlap_mm], [u_mm])| overlap_mm.abs() <= TOUCHING * u_mm);
        Some(Joint::new(shapes, near, reach_mm, may_touch))
    }

    fn shape(&self, index: usize) -> Option<Shape> {
        self.fitted[index].element.map(|element| element.shape)
    }

    /// The elements of pieces from one on, round a closed curve.
    fn elements<const N: usize>(&self, first: usize) -> Option<[Element; N]> {
        let count = self.fitted.len();
        let mut elements = [self.fitted[first % count].element?; N];
        for (step, element) in elements.iter_mut().enumerate() {
            *element = self.fitted[(first + step) % count].element?;
        }
        Some(elements)
    }

    /// Pieces in order, then corners, chamfers and edges.
    pub(super) fn features(&self) -> Vec<Feature> {
        let count = self.fitted.len();
        let pieces = (0..count).filter_map(|index| self.piece(index));
        let corners = (0..self.sides()).filter_map(|index| self.corner(index));
        // Pieces between two others, by the one before.
        let before = if self.closed && count > 2 { 0..count } else { 0..count.saturating_sub(2) };
        let chamfers = before.clone().filter_map(|index| self.chamfer(index));
        let edges = before.filter_map(|index| self.edge(index));
        pieces.chain(corners).chain(chamfers).chain(edges).collect()
    }

    /// Pieces of too few points.
    pub(super) fn unknown(&self) -> Vec<String> {
        let few = self
            .fitted
            .iter()
            .filter(|fitted| fitted.piece.form != Form::Free && fitted.element.is_none());
        few.map(|fitted| {
            let name = if fitted.piece.form == Form::Line { "line" } else { "arc" };
            let [x, y] = self.places_mm[(fitted.piece.first + fitted.piece.end) / 2];
            let [from, to] = fitted.counting;
            format!(
                "{name} near {x:.4}, {y:.4} mm: {LEAST_OF_ELEMENT} points or more are needed away from its ends, {} are there; measure more points there",
                to - from
            )
        })
        .collect()
    }

    /// The edges that bridge a stretch of which the points do not show the way, by the point where each begins.
    ///
    /// Such an edge is far longer than those about it. It stays part of a line up to [`SHOWN_SHARE`] of the line's length, and of an arc or a
    /// free piece where it turns by no more than [`SHOWN_TURN`]. Between two pieces it is always a gap.
    pub(super) fn gaps(&self) -> Vec<usize> {
        let mut gaps = far_edges(&self.places_mm, self.closed);
        gaps.retain(|&from| !self.is_shown(from));
        gaps
    }

    fn is_shown(&self, from: usize) -> bool {
        let to = (from + 1) % self.places_mm.len();
        let holds = |fitted: &&Fitted| (fitted.piece.first..fitted.piece.end).contains(&from);
        let Some(Fitted { piece, element, .. }) = self.fitted.iter().find(holds) else {
            return false;
        };
        let is_within = from < to && to < piece.end || to == 0 && self.fitted.len() == 1;
        let length_mm = distance_mm(self.places_mm[from], self.places_mm[to]);
        is_within
            && match element.map(|element| element.shape) {
                Some(Shape::Line { .. }) => {
                    let ends = [piece.first, piece.end - 1].map(|point| self.places_mm[point]);
                    length_mm <= SHOWN_SHARE * distance_mm(ends[0], ends[1])
                }
                Some(Shape::Circle { radius_mm, .. }) => length_mm <= SHOWN_TURN * radius_mm,
                None => turn_over(&self.places_mm, self.closed, from) <= SHOWN_TURN,
            }
    }

    /// The ends of a piece: its joints, or the feet of its first and last point.
    fn ends_mm(&self, index: usize, shape: Shape) -> [PlaceMm; 2] {
        let Piece { first, end, .. } = self.fitted[index].piece;
        let count = self.fitted.len();
        let joint_mm = |index: usize| {
            let joint = self.joints.get(index).copied().flatten()?;
            let shapes = [self.shape(index)?, self.shape((index + 1) % count)?];
            joint.place_mm([&shapes[0], &shapes[1]])
        };
        let foot = |point: usize| shape.foot_mm(self.places_mm[point]);
        [
            joint_mm((index + count - 1) % count).unwrap_or_else(|| foot(first)),
            joint_mm(index).unwrap_or_else(|| foot(end - 1)),
        ]
    }

    fn piece(&self, index: usize) -> Option<Feature> {
        let Fitted { piece, counting, element } = &self.fitted[index];
        let Some(element) = element else {
            let ends_mm = [piece.first, piece.end - 1].map(|point| self.places_mm[point]);
            let points = piece.end - piece.first;
            return (piece.form == Form::Free).then_some(Feature::Free { ends_mm, points });
        };
        let ends_mm = self.ends_mm(index, element.shape);
        let counting = &self.places_mm[counting[0]..counting[1]];
        let points = counting.len();
        let form_mm = element.shape.range_mm(counting);
        let one = [*element];
        Some(match element.shape {
            Shape::Line { through_mm, .. } => {
                let ([angle, _], [u, u_across_mm]) = figure(&one, |shapes| match shapes[0] {
                    Shape::Line { through_mm: [x, y], angle } => {
                        let across = (y - through_mm[1]) * angle.cos();
                        Some([angle, across - (x - through_mm[0]) * angle.sin()])
                    }
                    Shape::Circle { .. } => None,
                })?;
                let angle_deg =
                    Estimate { value: angle.to_degrees().rem_euclid(180.0), u: u.to_degrees() };
                Feature::Line {
                    ends_mm,
                    angle_deg,
                    middle_mm: through_mm,
                    u_across_mm,
                    straightness_mm: form_mm,
                    points,
                }
            }
            shape @ Shape::Circle { turn, .. } => {
                let (value, u) = figure(&one, |shapes| match shapes[0] {
                    Shape::Circle { centre_mm: [x, y], radius_mm, .. } => Some([x, y, radius_mm]),
                    Shape::Line { .. } => None,
                })?;
                let [x, y, radius_mm] = estimates((value, u));
                let is_whole = self.closed && self.fitted.len() == 1;
                let sweep = if is_whole { 2.0 * PI } else { sweep(&shape, ends_mm) };
                Feature::Arc {
                    ends_mm,
                    centre_mm: [x, y],
                    radius_mm,
                    sweep_deg: (turn * sweep).to_degrees(),
                    roundness_mm: form_mm,
                    points,
                }
            }
        })
    }

    fn corner(&self, index: usize) -> Option<Feature> {
        let joint @ Joint::Corner(_) = self.joints[index]? else { return None };
        let elements: [Element; 2] = self.elements(index)?;
        let found = figure(&elements, |shapes| {
            let shapes = [&shapes[0], &shapes[1]];
            let [x, y] = joint.place_mm(shapes)?;
            Some([x, y, 180.0 - turn(shapes, [x, y]).abs().to_degrees()])
        })?;
        let [x, y, angle_deg] = estimates(found);
        Some(Feature::Corner { at_mm: [x, y], angle_deg })
    }

    /// The chamfer after a piece: a line between corners with two lines, both more than twice as long as it, both turning the same way.
    fn chamfer(&self, index: usize) -> Option<Feature> {
        let count = self.fitted.len();
        let joints = [self.joints[index]?, self.joints[(index + 1) % count]?];
        let elements: [Element; 3] = self.elements(index)?;
        let all_lines = elements.iter().all(|element| matches!(element.shape, Shape::Line { .. }));
        if !all_lines || joints.iter().any(|joint| !matches!(joint, Joint::Corner(_))) {
            return None;
        }
        let places = |shapes: &[Shape]| {
            let [p, q] = [
                joints[0].place_mm([&shapes[0], &shapes[1]])?,
                joints[1].place_mm([&shapes[1], &shapes[2]])?,
            ];
            Some([p, q, shapes[0].meeting_mm(&shapes[2], p)?])
        };
        let shapes = elements.map(|element| element.shape);
        let [p, q, _] = places(&shapes)?;
        let width_mm = distance_mm(p, q);
        let longer = [index, index + 2].iter().all(|&at| {
            let [from, to] = self.ends_mm(at % count, shapes[at - index]);
            distance_mm(from, to) > LONGER * width_mm
        });
        let turns = [turn([&shapes[0], &shapes[1]], p), turn([&shapes[1], &shapes[2]], q)];
        let breaks = turns[0] * turns[1] > 0.0 && (turns[0] + turns[1]).abs() < MOST_BREAK;
        if !longer || !breaks {
            return None;
        }
        let [width_mm, first, second, before, after] = estimates(figure(&elements, |shapes| {
            let [p, q, sharp] = places(shapes)?;
            let angle = |other: &Shape| {
                between_lines(other.angle_at(p), shapes[1].angle_at(p)).to_degrees()
            };
            let legs = [distance_mm(p, sharp), distance_mm(q, sharp)];
            Some([distance_mm(p, q), legs[0], legs[1], angle(&shapes[0]), angle(&shapes[2])])
        })?);
        Some(Feature::Chamfer {
            at_mm: [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])],
            width_mm,
            legs_mm: [first, second],
            angles_deg: [before, after],
        })
    }

    /// The edge after a piece: an arc of less than half a turn between two lines that are not parallel.
    fn edge(&self, index: usize) -> Option<Feature> {
        let elements: [Element; 3] = self.elements(index)?;
        let count = self.fitted.len();
        let [before, arc, after] = elements.map(|element| element.shape);
        let lines = [before, after].iter().all(|shape| matches!(shape, Shape::Line { .. }));
        let Shape::Circle { centre_mm, radius_mm, turn: way } = arc else { return None };
        let [from, to] = self.ends_mm((index + 1) % count, arc);
        let sweep = sweep(&arc, [from, to]);
        let turned = turn([&before, &after], from).abs();
        if !lines || sweep >= PI || !(LEAST_EDGE..PI - LEAST_EDGE).contains(&turned) {
            return None;
        }
        let [radius, angle_deg] = estimates(figure(&elements, |shapes| {
            let Shape::Circle { radius_mm, .. } = shapes[1] else { return None };
            let turned = turn([&shapes[0], &shapes[2]], from).abs();
            Some([radius_mm, 180.0 - turned.to_degrees()])
        })?);
        let middle = (from[1] - centre_mm[1]).atan2(from[0] - centre_mm[0]) + 0.5 * way * sweep;
        Some(Feature::Edge {
            at_mm: [
                centre_mm[0] + radius_mm * middle.cos(),
                centre_mm[1] + radius_mm * middle.sin(),
            ],
            radius_mm: radius,
            angle_deg,
        })
    }

    /// Area in mm² and length in mm of a closed curve of which all pieces are fitted.
    pub(super) fn area_and_length(&self) -> Option<[Estimate; 2]> {
        let elements: Vec<Element> =
            self.fitted.iter().map(|fitted| fitted.element).collect::<Option<_>>()?;
        let joints: Vec<Joint> = self.joints.iter().copied().collect::<Option<_>>()?;
        let found = figure(&elements, |shapes| match *shapes {
            [Shape::Circle { radius_mm, .. }] => {
                Some([PI * radius_mm * radius_mm, 2.0 * PI * radius_mm])
            }
            _ => Some(area_and_length(shapes, &ends_mm(shapes, &joints)?)),
        });
        found.map(estimates)
    }
}

/// The line or circle of points; none of a free piece and of too few.
fn element(points_mm: &[PlaceMm], piece: Piece) -> Option<Element> {
    let found = match piece.form {
        _ if points_mm.len() < LEAST_OF_ELEMENT => None,
        Form::Line => Element::line(points_mm),
        Form::Arc => Element::circle(points_mm),
        Form::Free => None,
    };
    found.filter(|element| element.spare() > 0)
}

fn estimates<const N: usize>((value, u): ([f64; N], [f64; N])) -> [Estimate; N] {
    std::array::from_fn(|it| Estimate { value: value[it], u: u[it] })
}

/// Least points that count of a line or an arc.
const LEAST_OF_ELEMENT: usize = 8;
/// Distance of two pieces, in σ, from which a point counts for one of them.
const APART: f64 = 3.0;
/// Points to spare from which a piece has a σ of its own.
const SPARE: usize = 100;
/// Overlap of two pieces, in standard uncertainties of it, up to which they touch.
const TOUCHING: f64 = 4.0;
/// How far from their last points two pieces may meet, over the length of the shorter.
const REACH: f64 = 0.3;
/// Longest gap in a line over its length.
const SHOWN_SHARE: f64 = 0.2;
/// Length of the lines beside a chamfer over its own.
const LONGER: f64 = 2.0;
/// Largest turn of both corners of a chamfer, radians.
const MOST_BREAK: f64 = 0.85 * PI;
/// Least angle between the lines of an edge, radians.
const LEAST_EDGE: f64 = 0.05 * PI;
