//! Unknowns of the fit, in the order of their columns.

use std::ops::Range;

use crate::map::orders_to;
use crate::parameter::Parameter;

/// Order of the unknowns: parameters, heights, places of the poses, the radius, the form.
#[derive(Clone, Debug)]
pub(crate) struct Columns {
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) map: Vec<(u32, i32)>,
    pub(crate) form: Vec<(u32, i32)>,
    poses: usize,
}

/// Unknowns of one pose: centre of the sphere, or height and slopes of the flat.
pub(crate) const PLACE: usize = 3;

impl Columns {
    pub(crate) fn new(parameters: Vec<Parameter>, [map, form]: [u32; 2], poses: usize) -> Columns {
        Columns { parameters, map: orders_to(map), form: orders_to(form), poses }
    }

    pub(crate) fn parameters(&self) -> Range<usize> {
        0..self.parameters.len()
    }

    pub(crate) fn map(&self) -> Range<usize> {
        let start = self.parameters.len();
        start..start + self.map.len()
    }

    pub(crate) fn place(&self, pose: usize) -> Range<usize> {
        let start = self.map().end + PLACE * pose;
        start..start + PLACE
    }

    pub(crate) fn places(&self) -> Range<usize> {
        self.place(0).start..self.radius()
    }

    /// The one column of the sphere's radius.
    pub(crate) fn radius(&self) -> usize {
        self.map().end + PLACE * self.poses
    }

    pub(crate) fn form(&self) -> Range<usize> {
        let start = self.radius() + 1;
        start..start + self.form.len()
    }

    /// How many unknowns there are.
    pub(crate) fn count(&self) -> usize {
        self.form().end
    }

    /// Unknowns that may be given up, the last group first: what turns with the machine is asked before the form, and
    /// terms of the form that are of revolution come last, as no turn tells them from the machine.
    pub(crate) fn groups(&self) -> Vec<Vec<usize>> {
        let form = |of_revolution: bool| -> Vec<usize> {
            let terms = self.form().zip(&self.form);
            terms.filter(|(_, (_, m))| (*m == 0) == of_revolution).map(|(at, _)| at).collect()
        };
        vec![
            self.places().collect(),
            vec![self.radius()],
            self.parameters().collect(),
            form(false),
            self.map().collect(),
            form(true),
        ]
    }
}
