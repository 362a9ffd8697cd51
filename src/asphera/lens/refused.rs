//! The kinds of surfaces that are not converted, and what can be done instead.

/// Why a kind is not converted and what would do, in brackets.
pub(super) fn why(kind: &str) -> &'static str {
    match kind {
        "CHEBYSHV" => {
            " (the order of its coefficients is not documented. Write kind = \"chebyshev\" by hand, each term by the heading of its column; half_x_mm and half_y_mm are the Norm X Length and Norm Y Length)"
        }
        "COORDBRK" => {
            " (a coordinate break has no surface: choose the one after it; decentres and tilts are no part of a nominal, a fit finds \
             them)"
        }
        "BINARY_2" | "DGRATING" | "FZERNPHA" | "SZERNPHA" => {
            " (it adds a phase to a base, and the file has no heights of its relief. For the base alone change its TYPE to STANDARD or EVENASPH in a copy of the file)"
        }
        "PARAXIAL" => " (an ideal lens has no shape)",
        _ => " (if it has a shape, export its sag as heights on a grid and use kind = \"grid\")",
    }
}
