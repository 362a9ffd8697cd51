//! The rules of the house that a machine can check: which crate may use which, and what the code does not do.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use cargo_metadata::{DependencyKind, MetadataCommand};

/// Who may use whom, in code that is shipped. What is not here is forbidden; ARCHITECTURE.md draws it.
const ALLOWED: [(&str, &[&str]); 21] = [
    (
        "asphera",
        &[
            "asphera-chrocodile",
            "asphera-cia406",
            "asphera-contour",
            "asphera-form",
            "asphera-formats",
            "asphera-geometry",
            "asphera-graph",
            "asphera-link",
            "asphera-mesh",
            "asphera-modbus",
            "asphera-reconstruct",
            "asphera-rig",
            "asphera-slcan",
            "asphera-surface",
            "asphera-transport",
            "asphera-volume",
        ],
    ),
    ("asphera-geometry", &[]),
    ("asphera-mesh", &["asphera-geometry"]),
    ("asphera-surface", &["asphera-geometry", "asphera-mesh"]),
    ("asphera-contour", &["asphera-geometry", "asphera-mesh"]),
    ("asphera-reconstruct", &["asphera-geometry"]),
    ("asphera-volume", &[]),
    ("asphera-graph", &["asphera-geometry"]),
    ("asphera-form", &[]),
    ("asphera-formats", &[]),
    ("asphera-link", &[]),
    ("asphera-slcan", &["asphera-link"]),
    ("asphera-transport", &["asphera-link"]),
    ("asphera-chrocodile", &["asphera-link"]),
    ("asphera-cia406", &["asphera-link"]),
    ("asphera-modbus", &["asphera-link"]),
    ("asphera-sim-chrocodile", &["asphera-chrocodile", "asphera-link"]),
    ("asphera-sim-cia406", &["asphera-cia406", "asphera-link", "asphera-slcan"]),
    ("asphera-sim-modbus", &["asphera-link", "asphera-modbus"]),
    (
        "asphera-rig",
        &[
            "asphera-chrocodile",
            "asphera-cia406",
            "asphera-form",
            "asphera-link",
            "asphera-modbus",
            "asphera-sim-chrocodile",
            "asphera-sim-cia406",
            "asphera-sim-modbus",
        ],
    ),
    ("asphera-tests", &["asphera", "asphera-rig"]),
];

/// Crates that do no input or output and read no clock may not even link what does.
const PURE: [&str; 13] = [
    "asphera-geometry",
    "asphera-mesh",
    "asphera-surface",
    "asphera-contour",
    "asphera-reconstruct",
    "asphera-volume",
    "asphera-graph",
    "asphera-form",
    "asphera-formats",
    "asphera-link",
    "asphera-slcan",
    "asphera-chrocodile",
    "asphera-cia406",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[test]
fn dependencies_point_one_way() {
    let metadata = MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .no_deps()
        .exec()
        .expect("cargo metadata");
    let allowed: BTreeMap<_, BTreeSet<_>> =
        ALLOWED.iter().map(|(name, uses)| (*name, uses.iter().copied().collect())).collect();
    let ours: BTreeSet<&str> =
        metadata.packages.iter().map(|package| package.name.as_str()).collect();
    let mut wrong = Vec::new();
    for package in &metadata.packages {
        let Some(allowed) = allowed.get(package.name.as_str()) else {
            wrong.push(format!("{} is not in the list of crates", package.name));
            continue;
        };
        for dependency in &package.dependencies {
            let name = dependency.name.as_str();
            if dependency.kind != DependencyKind::Normal {
                continue;
            }
            if ours.contains(name) && !allowed.contains(name) {
                wrong.push(format!("{} may not use {name}", package.name));
            }
            if PURE.contains(&package.name.as_str())
                && ["tokio", "serialport", "mcap", "axum"].contains(&name)
            {
                wrong.push(format!("{} is pure and may not use {name}", package.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Every crate lies in the folder its name says, and has its sources at its root.
#[test]
fn crates_live_where_their_names_say() {
    let metadata = MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .no_deps()
        .exec()
        .expect("cargo metadata");
    for package in &metadata.packages {
        let folder = package.manifest_path.parent().expect("a manifest lies in a folder");
        let name = package.name.strip_prefix("asphera-").unwrap_or("asphera");
        let name = name.strip_prefix("sim-").unwrap_or(name);
        assert_eq!(folder.file_name(), Some(name), "{}", package.name);
        assert!(folder.join("lib.rs").exists() || folder.join("main.rs").exists(), "{folder}");
    }
}

#[test]
fn drivers_name_no_transport_and_the_page_no_driver() {
    let drivers = ["chrocodile", "cia406", "modbus"];
    let mut wrong = Vec::new();
    for file in sources(&root().join("drivers/transport")) {
        let text = std::fs::read_to_string(&file).unwrap().to_lowercase();
        for driver in drivers {
            if text.contains(driver) {
                wrong.push(format!("{} names {driver}", file.display()));
            }
        }
    }
    for file in sources(&root().join("src/asphera/publish")) {
        let text = std::fs::read_to_string(&file).unwrap();
        if text.contains("asphera_") {
            wrong.push(format!("{} names a crate behind the snapshot", file.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Files stay small enough to be read in one sitting.
#[test]
fn no_source_file_is_above_700_lines() {
    let mut long = Vec::new();
    for folder in ["src", "drivers", "simulators", "tests"] {
        for file in sources(&root().join(folder)) {
            let lines = std::fs::read_to_string(&file).unwrap().lines().count();
            if lines > 700 {
                long.push(format!("{}: {lines} lines", file.display()));
            }
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}

/// Rust sources below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.ends_with("node_modules") {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found
}
