//! What the options say, over what a recording asks for.

use std::path::Path;

use asphera_contour::strokes::{Hint, hints_of};
use asphera_contour::{Kind, Method, Parameters};
use asphera_nominal::bytes_of;

use super::{ContourArgs, places};
use crate::cli::output::Failure;
use crate::cli::progress::Progress;
use crate::cli::text::TextArgs;
use crate::cli::usage::misused;
use crate::contour::{ContourPlan, ContourSettings, Nominal, Slab};

/// Options that were checked.
pub(super) struct Given<'a> {
    args: &'a ContourArgs,
    method: Option<Method>,
    parameters: Option<Parameters>,
    hints: Vec<Hint>,
}

impl Given<'_> {
    /// Checks the options, each for itself.
    pub(super) fn new(args: &ContourArgs) -> Result<Given<'_>, Failure> {
        let method = method(args)?;
        let parameters = args.set.as_deref().map(Parameters::parse).transpose().map_err(misused)?;
        let hints = args.hints.as_deref().map(hints_of).transpose()?.unwrap_or_default();
        if let Some(tolerance) = args.tolerance.filter(|mm| !(*mm >= 0.0 && mm.is_finite())) {
            return Err(misused(format!("--tolerance {tolerance}: expected 0 mm or more")));
        }
        for (flag, value) in [("--gaps", args.gaps), ("--within", args.within)] {
            if let Some(value) = value.filter(|mm| !(*mm > 0.0 && mm.is_finite())) {
                return Err(misused(format!("{flag} {value}: expected more than 0 mm")));
            }
        }
        Ok(Given { args, method, parameters, hints })
    }

    /// The plane on which points are laid, and how near they must lie.
    pub(super) fn slab(&self, recorded: Option<&ContourPlan>) -> Option<Slab> {
        let given = self.args.plane.zip(self.args.within);
        let given = given.map(|(plane, within_mm)| plane.slab(within_mm));
        given.or_else(|| recorded.and_then(|plan| plan.slab))
    }

    /// The settings of the recording, but for what the options say. Parameters and hints belong to their method: with another method none is taken over.
    pub(super) fn settings(
        &self,
        recorded: Option<&ContourSettings>,
    ) -> Result<ContourSettings, Failure> {
        let method = self.method.or(recorded.map(|it| it.method)).unwrap_or(Method::HnnCrust);
        if self.args.hints.is_some() && !method.takes_hints() {
            let names = Method::ALL.iter().filter(|method| method.takes_hints());
            let names = names.map(Method::name).collect::<Vec<_>>().join(" or ");
            let found = method.name();
            return Err(misused(format!(
                "--hints: expected --method {names} beside it, found {found}"
            )));
        }
        let same = recorded.filter(|it| it.method == method);
        let parameters = self.parameters.clone().or_else(|| same.map(|it| it.parameters.clone()));
        if let Some(parameters) = &self.parameters {
            parameters.check(&method).map_err(misused)?;
        }
        let hints = match self.args.hints {
            Some(_) => self.hints.clone(),
            None => same.map(|it| it.hints.clone()).unwrap_or_default(),
        };
        // A graph has none of what curves and regions have.
        let recorded = recorded.filter(|_| method.kind() != Kind::Graph);
        let nominal = match self.args.outline.as_deref() {
            Some(path) => Some(nominal(path)?),
            None => recorded.and_then(|it| it.nominal.clone()),
        };
        Ok(ContourSettings {
            method,
            parameters: parameters.unwrap_or_default(),
            tolerance_mm: self.args.tolerance.or(recorded.map(|it| it.tolerance_mm)).unwrap_or(0.0),
            is_airfoil: self.args.airfoil || recorded.is_some_and(|it| it.is_airfoil),
            gap_mm: self.args.gaps.or(recorded.and_then(|it| it.gap_mm)),
            nominal,
            hints,
        })
    }
}

/// The method or graph that is named; none without a name.
fn method(args: &ContourArgs) -> Result<Option<Method>, Failure> {
    let Some(name) = args.graph.as_deref().or(args.method.as_deref()) else { return Ok(None) };
    let method = Method::from_name(name).map_err(misused)?;
    let is_graph = |method: &Method| method.kind() == Kind::Graph;
    if is_graph(&method) != args.graph.is_some() {
        let (flag, other) = match args.graph {
            Some(_) => ("--graph", "--method"),
            None => ("--method", "--graph"),
        };
        let names = Method::ALL.iter().filter(|named| is_graph(named) != is_graph(&method));
        let names = names.map(Method::name).collect::<Vec<_>>().join(", ");
        let name = method.name();
        return Err(misused(format!(
            "{flag} {name}: expected one of {names}; give {other} {name}"
        )));
    }
    Ok(Some(method))
}

/// The nominal outline of a file: a drawing, what `contour --json` wrote, or the corners of a polygon in order.
fn nominal(path: &Path) -> Result<Nominal, Failure> {
    Ok(match Nominal::of_drawing(path, bytes_of) {
        Some(nominal) => nominal?,
        None => {
            let corners = places(path, &TextArgs::default(), &Progress::start("outline"))?;
            Nominal::of_polygon(path.display().to_string(), &corners)?
        }
    })
}
