//! A shape that is the sum of others: a base and what departs from it.

use std::sync::Arc;

use super::argument::{count, refused};
use super::taylor::{defined, number};
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// The sum of the heights of its parts, defined where all of them are.
///
/// Parameters are those of the parts, one part after the other. Their names stay as they are if no two are
/// equal; else every name is preceded by the number of its part, from 1 on: `1.radius`, `2.radius`.
#[derive(Clone, Debug)]
pub struct Sum {
    parts: Vec<Arc<dyn Shape>>,
    /// How many parameters each part has.
    counts: Vec<usize>,
}

impl Sum {
    /// From its parts, in the order in which their heights are added. Fails if there are none.
    pub fn new(parts: Vec<Arc<dyn Shape>>) -> Result<Sum, ShapeError> {
        if parts.is_empty() {
            return Err(refused(KIND, "number of parts", 0.0, "at least 1"));
        }
        let counts = parts.iter().map(|part| part.parameters().len()).collect();
        Ok(Sum { parts, counts })
    }

    /// Its parts.
    pub fn parts(&self) -> &[Arc<dyn Shape>] {
        &self.parts
    }
}

impl Shape for Sum {
    /// That of its last part, which is what departs from the others: `Fringe Zernike series`.
    fn kind(&self) -> &'static str {
        self.parts.last().map_or(KIND, |part| part.kind())
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let mut sum = Jet::default();
        for part in &self.parts {
            let jet = part.jet(x_mm, y_mm)?;
            sum.z_mm += jet.z_mm;
            sum.gradient.iter_mut().zip(jet.gradient).for_each(|(sum, own)| *sum += own);
            let hessian = sum.hessian_per_mm.iter_mut().zip(jet.hessian_per_mm);
            hessian.for_each(|(sum, own)| *sum += own);
        }
        defined(sum)
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let mut sum = 0.0;
        for part in &self.parts {
            sum += part.sag_mm(x_mm, y_mm)?;
        }
        number(sum)
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let of_parts: Vec<_> = self.parts.iter().map(|part| part.parameters()).collect();
        let mut names: Vec<_> = of_parts.iter().flatten().map(|own| own.name.as_str()).collect();
        names.sort_unstable();
        let repeated = names.windows(2).any(|pair| pair[0] == pair[1]);
        let numbered = of_parts.into_iter().enumerate().flat_map(|(part, parameters)| {
            parameters.into_iter().map(move |own| match repeated {
                true => ShapeParameter { name: format!("{}.{}", part + 1, own.name), ..own },
                false => own,
            })
        });
        numbered.collect()
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let mut rest = derivatives;
        for (part, &count) in self.parts.iter().zip(&self.counts) {
            let (own, others) = rest.split_at_mut(count);
            part.by_parameters(x_mm, y_mm, own)?;
            rest = others;
        }
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        count(KIND, values, self.counts.iter().sum())?;
        let mut rest = values;
        let mut parts = Vec::with_capacity(self.parts.len());
        for (part, &count) in self.parts.iter().zip(&self.counts) {
            let (own, others) = rest.split_at(count);
            parts.push(part.with_parameters(own)?);
            rest = others;
        }
        Ok(Arc::new(Sum { parts, counts: self.counts.clone() }))
    }

    fn domain_mm(&self) -> f64 {
        self.parts.iter().map(|part| part.domain_mm()).fold(f64::INFINITY, f64::min)
    }
}

const KIND: &str = "sum";
