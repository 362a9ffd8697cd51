//! Which figures a free parameter of the shape takes the subject of away, and what is done about it.
//!
//! A fit takes off the deviation whatever its free parameters can make. Motions of the part are none of its form. A radius,
//! a conic constant or a coefficient is: of a part whose radius is 0.2 % off, a fit with that radius free leaves nothing, and
//! an A formed of what it leaves is 0, while the sagitta is off by micrometres.
//!
//! | figures | a motion is free | a parameter of the shape is free |
//! |---|---|---|
//! | A, B, C, RMSt, RMSi, RMSa | as fitted | against the design: of a fit with the shape held at it |
//! | PV, RMS, PV99%, PVr, what terms leave of them, zones, rings | as fitted | as fitted, with a caution |
//! | slopes | as fitted | as fitted, with a caution |
//! | Zernike terms, Q spectrum | as fitted | as fitted, with a caution |
//! | figures of points ([`Definition::OF_POINTS`]) | as fitted | as fitted, with a caution |
//! | PSD, texture | as fitted | as fitted: power is removed, or filters take off what is as long as the part |
//!
//! ISO 10110-5 states the first line against the theoretical surface of the drawing, whatever the fit was free to do. The others
//! are asked for as figures of what the fit leaves, which a caution then says.

use super::Definition;
use asphera_form::Parameter;

/// Figures that have the same subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The parts of `3/A(B/C)` and their RMS.
    Indication,
    /// Ranges and means of the deviation, whole, over zones, or less terms.
    Deviation,
    /// Its slopes.
    Slope,
    /// Coefficients of polynomials in it.
    Terms,
    /// Points against the nominal: [`Definition::OF_POINTS`].
    Points,
    /// Surface that filters leave: texture and spectra.
    Filtered,
}

/// Treatment of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// It is formed of what the fit leaves: nothing of its subject is taken away.
    AsFitted,
    /// It is formed of the deviation from the design: of a fit whose shape is held there.
    FromDesign,
    /// It is formed of what the fit leaves, and a caution says that it does not judge what was free.
    Cautioned,
}

impl Subject {
    /// Every subject.
    pub const ALL: [Subject; 6] = [
        Subject::Indication,
        Subject::Deviation,
        Subject::Slope,
        Subject::Terms,
        Subject::Points,
        Subject::Filtered,
    ];

    /// What is done about its figures where these parameters were free: the table above.
    pub fn treatment(self, free: &[Parameter]) -> Treatment {
        if free.iter().all(|&parameter| is_motion(parameter)) {
            return Treatment::AsFitted;
        }
        match self {
            Subject::Indication => Treatment::FromDesign,
            Subject::Deviation | Subject::Slope | Subject::Terms | Subject::Points => {
                Treatment::Cautioned
            }
            Subject::Filtered => Treatment::AsFitted,
        }
    }

    /// Its figures in words.
    pub fn figures(self) -> String {
        let words = match self {
            Subject::Indication => "A, B, C, RMSt, RMSi and RMSa",
            Subject::Deviation => "PV, RMS and PVr",
            Subject::Slope => "slopes",
            Subject::Terms => "Zernike and Q terms",
            Subject::Points => {
                return Definition::OF_POINTS.map(|one| format!("the {}", one.symbol())).join(", ");
            }
            Subject::Filtered => "PSD and texture",
        };
        words.to_owned()
    }
}

impl Definition {
    /// Subject of the figure.
    pub fn subject(&self) -> Subject {
        self.row().subject
    }
}

/// Whether a parameter moves the part and leaves its shape.
pub fn is_motion(parameter: Parameter) -> bool {
    Parameter::POSE.contains(&parameter)
}

#[cfg(test)]
mod tests {
    use super::Treatment::{AsFitted, Cautioned, FromDesign};
    use super::*;

    #[test]
    fn motions_take_nothing_away_and_any_parameter_of_the_shape_does() {
        for subject in Subject::ALL {
            assert_eq!(subject.treatment(&Parameter::POSE), AsFitted);
        }
        let of_shape = [Parameter::Radius, Parameter::Conic, Parameter::A(4), Parameter::Shape(0)];
        for parameter in of_shape {
            let free = [Parameter::Tz, parameter];
            let found = Subject::ALL.map(|subject| subject.treatment(&free));
            let expected = [FromDesign, Cautioned, Cautioned, Cautioned, Cautioned, AsFitted];
            assert_eq!(found, expected, "{parameter}");
        }
    }
}
