//! The rules of the house that a machine can check: which crate may use which, and what the code does not do.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use cargo_metadata::{DependencyKind, MetadataCommand};

/// Who may use whom, in code that is shipped. What is not here is forbidden; ARCHITECTURE.md draws it. Drivers and
/// simulators follow a rule of their own: see [`allowed`].
const ALLOWED: &[(&str, &[&str])] = &[
    (
        "asphera",
        &[
            "asphera-calibrate",
            "asphera-cantext",
            "asphera-clocks",
            "asphera-contour",
            "asphera-face",
            "asphera-form",
            "asphera-formats",
            "asphera-geometry",
            "asphera-graph",
            "asphera-http",
            "asphera-link",
            "asphera-measure",
            "asphera-mesh",
            "asphera-metrics",
            "asphera-nominal",
            "asphera-paper",
            "asphera-plan",
            "asphera-reconstruct",
            "asphera-report",
            "asphera-rig",
            "asphera-settings",
            "asphera-slcan",
            "asphera-stand",
            "asphera-surface",
            "asphera-transport",
            "asphera-volume",
        ],
    ),
    (
        "asphera-nominal",
        &[
            "asphera-figures",
            "asphera-form",
            "asphera-formats",
            "asphera-geometry",
            "asphera-measure",
            "asphera-report",
            "asphera-settings",
            "asphera-surface",
            "asphera-uncertainty",
        ],
    ),
    (
        "asphera-measure",
        &[
            "asphera-figures",
            "asphera-form",
            "asphera-geometry",
            "asphera-mesh",
            "asphera-reconstruct",
            "asphera-report",
            "asphera-surface",
            "asphera-uncertainty",
        ],
    ),
    (
        "asphera-face",
        &[
            "asphera-form",
            "asphera-geometry",
            "asphera-measure",
            "asphera-report",
            "asphera-surface",
            "asphera-uncertainty",
            "asphera-volume",
        ],
    ),
    ("asphera-uncertainty", &["asphera-figures", "asphera-form", "asphera-geometry"]),
    ("asphera-figures", &["asphera-form", "asphera-geometry"]),
    ("asphera-geometry", &[]),
    ("asphera-plan", &[]),
    ("asphera-mesh", &["asphera-geometry"]),
    ("asphera-surface", &["asphera-geometry", "asphera-mesh"]),
    ("asphera-contour", &["asphera-geometry", "asphera-mesh"]),
    ("asphera-reconstruct", &["asphera-geometry"]),
    ("asphera-volume", &[]),
    ("asphera-graph", &["asphera-geometry"]),
    ("asphera-calibrate", &["asphera-form", "asphera-geometry"]),
    ("asphera-clocks", &["asphera-link"]),
    ("asphera-form", &["asphera-geometry"]),
    ("asphera-http", &["asphera-report"]),
    ("asphera-metrics", &["asphera-report"]),
    ("asphera-paper", &["asphera-report"]),
    ("asphera-report", &[]),
    ("asphera-formats", &[]),
    ("asphera-settings", &[]),
    ("asphera-link", &["asphera-settings"]),
    ("asphera-canopen", &["asphera-link"]),
    ("asphera-cantext", &["asphera-link"]),
    ("asphera-slcan", &["asphera-link"]),
    ("asphera-faults", &["asphera-link"]),
    ("asphera-transport", &["asphera-cantext", "asphera-link"]),
    ("asphera-rig", &["asphera-form", "asphera-link", "asphera-settings", "asphera-stand"]),
    ("asphera-stand", &["asphera-link"]),
    ("asphera-tests", &["asphera", "asphera-rig"]),
];

/// Folders of `drivers` that hold no driver.
const NO_DRIVERS: &[&str] =
    &["canopen", "cantext", "faults", "link", "settings", "slcan", "transport"];

/// Drivers of device profiles of CANopen: they share its frames.
const TALK_CANOPEN: &[&str] = &["asphera-cia402", "asphera-cia406"];

/// Drivers of protocols whose answers are lines: they know the protocol, and the described device does the talking.
const TALK_IN_LINES: &[&str] = &["asphera-scpi", "asphera-zaber"];

/// Crates that do no input or output and read no clock may not even link what does. Drivers are among them.
const PURE: &[&str] = &[
    "asphera-geometry",
    "asphera-plan",
    "asphera-mesh",
    "asphera-surface",
    "asphera-contour",
    "asphera-reconstruct",
    "asphera-volume",
    "asphera-graph",
    "asphera-form",
    "asphera-figures",
    "asphera-uncertainty",
    "asphera-measure",
    "asphera-calibrate",
    "asphera-clocks",
    "asphera-face",
    "asphera-report",
    "asphera-formats",
    "asphera-settings",
    "asphera-link",
    "asphera-canopen",
    "asphera-cantext",
    "asphera-slcan",
    "asphera-faults",
];

/// The driver that polls tokio-modbus by hand over a pipe in memory; no runtime runs.
const POLLS_A_LIBRARY: &str = "asphera-modbus";

/// Simulators that also play a CAN adapter on a serial port.
const ON_A_SERIAL_CAN_ADAPTER: &[&str] = &["asphera-sim-cia402", "asphera-sim-cia406"];

/// Names of the drivers: those of their folders.
fn drivers() -> BTreeSet<String> {
    let folders = std::fs::read_dir(root().join("drivers")).unwrap();
    let folders = folders.map(|entry| entry.unwrap().path());
    folders
        .filter(|folder| folder.join("Cargo.toml").exists())
        .map(|folder| folder.file_name().unwrap().to_str().unwrap().to_owned())
        .filter(|name| !NO_DRIVERS.contains(&name.as_str()))
        .collect()
}

/// Whether the crate `user` may use the crate `used`, both of ours; `None` if no rule knows the user.
fn allowed(user: &str, used: &str, drivers: &BTreeSet<String>) -> Option<bool> {
    let is_driver = |name: &str| drivers.contains(name.trim_start_matches("asphera-"));
    let simulated =
        |name: &str| name.strip_prefix("asphera-sim-").map(|name| format!("asphera-{name}"));
    if is_driver(user) {
        let by_description = TALK_IN_LINES.contains(&user) && used == "asphera-described";
        let by_canopen = TALK_CANOPEN.contains(&user) && used == "asphera-canopen";
        let is_base = ["asphera-link", "asphera-settings"].contains(&used);
        return Some(is_base || by_description || by_canopen);
    }
    if let Some(driver) = simulated(user) {
        let on_an_adapter = ON_A_SERIAL_CAN_ADAPTER.contains(&user) && used == "asphera-slcan";
        return Some(["asphera-link", &driver].contains(&used) || on_an_adapter);
    }
    let (_, uses) = ALLOWED.iter().find(|(name, _)| *name == user)?;
    let reads_devices =
        ["asphera", "asphera-rig", "asphera-stand"].contains(&user) && is_driver(used);
    let simulates = ["asphera-rig", "asphera-stand"].contains(&user) && simulated(used).is_some();
    Some(uses.contains(&used) || reads_devices || simulates)
}

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
    let drivers = drivers();
    let ours: BTreeSet<&str> =
        metadata.packages.iter().map(|package| package.name.as_str()).collect();
    let mut wrong = Vec::new();
    for package in &metadata.packages {
        let name = package.name.as_str();
        let is_driver = drivers.contains(name.trim_start_matches("asphera-"));
        let is_pure = PURE.contains(&name) || (is_driver && name != POLLS_A_LIBRARY);
        if allowed(name, "", &drivers).is_none() {
            wrong.push(format!("{name} is not in the list of crates"));
            continue;
        }
        for dependency in &package.dependencies {
            if dependency.kind != DependencyKind::Normal {
                continue;
            }
            let used = dependency.name.as_str();
            if ours.contains(used) && allowed(name, used, &drivers) != Some(true) {
                wrong.push(format!("{name} may not use {used}"));
            }
            if is_pure && ["tokio", "serialport", "mcap", "axum"].contains(&used) {
                wrong.push(format!("{name} is pure and may not use {used}"));
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
fn the_transport_names_no_driver() {
    let drivers = drivers();
    let mut wrong = Vec::new();
    for file in sources(&root().join("drivers/transport")) {
        let text = std::fs::read_to_string(&file).unwrap().to_lowercase();
        for driver in &drivers {
            if text.contains(driver.as_str()) {
                wrong.push(format!("{} names {driver}", file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The daemon names a driver in one line, that of the list in `config/devices.rs`.
#[test]
fn a_driver_enters_the_daemon_by_one_line() {
    let folder = root().join("src/asphera");
    let product =
        sources(&folder).into_iter().filter(|file| !file.starts_with(folder.join("benches")));
    let mut named = Vec::new();
    for file in product {
        let text = std::fs::read_to_string(&file).unwrap();
        for driver in drivers() {
            let times = text.matches(&format!("asphera_{driver}")).count();
            named.extend((0..times).map(|_| (driver.clone(), file.ends_with("config/devices.rs"))));
        }
    }
    named.sort();
    let once: Vec<_> = drivers().into_iter().map(|driver| (driver, true)).collect();
    assert_eq!(named, once);
}

/// Files stay small enough to be read in one sitting.
#[test]
fn every_driver_is_in_the_fault_matrix() {
    let text = std::fs::read_to_string(root().join("drivers/faults/Cargo.toml")).unwrap();
    for driver in drivers() {
        let line = format!("asphera-{driver}.workspace = true");
        assert!(text.contains(&line), "drivers/faults/Cargo.toml lacks `{line}`: play its faults");
    }
}

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

/// Clippy counts lines and parameters of functions, in tests too; nothing in the tree is an exception.
#[test]
fn functions_have_at_most_80_lines_and_6_parameters() {
    let clippy = std::fs::read_to_string(root().join("clippy.toml")).unwrap();
    for line in ["too-many-lines-threshold = 80", "too-many-arguments-threshold = 6"] {
        assert!(clippy.lines().any(|found| found == line), "clippy.toml lacks {line}");
    }
    let workspace = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    assert!(workspace.contains("too_many_lines = \"warn\""), "the lint is off");
    let metadata = MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .no_deps()
        .exec()
        .expect("cargo metadata");
    let mut wrong = Vec::new();
    for package in &metadata.packages {
        let manifest = std::fs::read_to_string(&package.manifest_path).unwrap();
        if !manifest.contains("[lints]\nworkspace = true") {
            wrong.push(format!("{} has not the lints of the workspace", package.name));
        }
    }
    // In two pieces, so that this file is no exception itself.
    let exceptions = ["lines", "arguments"].map(|what| format!("clippy::too_many_{what}"));
    for folder in ["src", "drivers", "simulators", "tests"] {
        for file in sources(&root().join(folder)) {
            let text = std::fs::read_to_string(&file).unwrap();
            if exceptions.iter().any(|exception| text.contains(exception)) {
                wrong.push(format!("{} excepts itself", file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Names come from the field. These words say nothing of what a file holds or an item is.
const BANNED: [&str; 10] =
    ["told", "tell", "look", "seen", "kept", "made", "rest", "of", "hold", "beside"];

#[test]
fn no_file_and_no_public_item_has_a_name_without_meaning() {
    let mut wrong = Vec::new();
    for folder in ["src", "drivers", "simulators"] {
        for file in sources(&root().join(folder)) {
            let name = file.file_stem().unwrap().to_str().unwrap();
            if BANNED.contains(&name) {
                wrong.push(file.display().to_string());
            }
            let text = std::fs::read_to_string(&file).unwrap();
            for (number, line) in (1..).zip(text.lines()) {
                if public_name(line).is_some_and(|name| BANNED.contains(&name)) {
                    wrong.push(format!("{}:{number}: {}", file.display(), line.trim()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(public_name("    pub fn of(&self) -> u8 {"), Some("of"));
    assert_eq!(public_name("    pub kept: Vec<u32>,"), Some("kept"));
    assert_eq!(public_name("    pub(super) fn of() {"), None);
}

/// The name of the public item or field that a line begins.
fn public_name(line: &str) -> Option<&str> {
    let item = line.trim_start().strip_prefix("pub ")?;
    let kinds =
        ["const fn ", "async fn ", "fn ", "struct ", "enum ", "trait ", "mod ", "const ", "type "];
    let name = kinds.iter().find_map(|kind| item.strip_prefix(kind)).unwrap_or(item);
    name.split(|sign: char| !(sign.is_alphanumeric() || sign == '_')).next()
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
