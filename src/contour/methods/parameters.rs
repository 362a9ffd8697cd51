//! Parameters of methods: names, ranges, values.

use super::{Method, MethodError};

/// A parameter of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its key.
    pub name: &'static str,
    /// Its value where none is given.
    pub default: f64,
    /// The least value allowed.
    pub low: f64,
    /// The largest.
    pub high: f64,
    /// Its meaning, in a few words.
    pub meaning: &'static str,
}

/// Values given for parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters {
    given: Vec<(String, f64)>,
}

impl Parameters {
    /// No values: every parameter has its default.
    pub fn new() -> Parameters {
        Parameters::default()
    }

    /// These, with one more value; of values for one key the last counts.
    #[must_use]
    pub fn with(mut self, name: &str, value: f64) -> Parameters {
        self.given.push((name.to_owned(), value));
        self
    }

    /// Values as `key=value,key=value`; `true` is 1 and `false` 0.
    ///
    /// # Errors
    ///
    /// A word without `=`, or a value that is no number.
    pub fn parse(text: &str) -> Result<Parameters, MethodError> {
        let mut parameters = Parameters::new();
        for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            let Some((name, value)) = word.split_once('=') else {
                return Err(MethodError::NoValue { found: word.to_owned() });
            };
            let (name, value) = (name.trim(), value.trim());
            let number = match value {
                "true" => 1.0,
                "false" => 0.0,
                _ => value.parse().map_err(|_| MethodError::NotANumber {
                    name: name.to_owned(),
                    found: value.to_owned(),
                })?,
            };
            parameters = parameters.with(name, number);
        }
        Ok(parameters)
    }

    /// Fails where a method does not have one of the parameters, or its value is out of range.
    ///
    /// # Errors
    ///
    /// The first such parameter.
    pub fn check(&self, method: &Method) -> Result<(), MethodError> {
        for (name, found) in &self.given {
            let has = method.parameters();
            let Some(parameter) = has.iter().find(|parameter| parameter.name == name) else {
                let names: Vec<&str> = has.iter().map(|parameter| parameter.name).collect();
                let expected = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                return Err(MethodError::NoParameter {
                    method: method.name(),
                    name: name.clone(),
                    expected,
                });
            };
            let &Parameter { name, low, high, .. } = parameter;
            if !(low..=high).contains(found) {
                let method = method.name();
                return Err(MethodError::OutOfRange { method, name, low, high, found: *found });
            }
        }
        Ok(())
    }

    /// The value of a method's parameter: the last one given, or the default.
    pub fn value(&self, method: &Method, name: &str) -> f64 {
        let given = self.given.iter().rev().find(|(given, _)| given == name);
        let default = || {
            let parameter = method.parameters().iter().find(|parameter| parameter.name == name);
            parameter.map_or(f64::NAN, |parameter| parameter.default)
        };
        given.map_or_else(default, |&(_, value)| value)
    }
}
