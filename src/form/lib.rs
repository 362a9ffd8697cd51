//! Nominal surfaces, orthogonal least-squares fits, and the form deviation.
