//! A bench of simulators measuring a simulated part, started from one TOML file.
