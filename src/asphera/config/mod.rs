//! Configuration: TOML text in, checked types out. The only reader of configuration files.
//!
//! `config/asphera.toml` is the reference: every key with its unit and consequence.

mod attached;
mod calibration;
mod contour;
mod devices;
mod error_table;
mod line;
mod links;
mod motion;
mod output;
mod parts;
mod projection;
mod scan;
mod thermal;
mod time;
mod tip;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::str::FromStr as _;
use std::time::Duration;

use asphera_link::{BusNumber, Carries};
use asphera_measure::{Along, Part, Tip, Weights};
use asphera_settings::Section;
use asphera_transport::Endpoint;
use thiserror::Error;
use toml_edit::{DocumentMut, Item};

pub use asphera_settings::{Problem, Problems};
pub use devices::DeviceConfig;
pub(crate) use devices::proposals;
use error_table::ErrorTables;
pub use links::LinkConfig;
pub use motion::SyncConfig;
pub use output::OutputConfig;
pub use time::TimeConfig;

use crate::calibration::CalibrationFile;
use crate::contour::ContourPlan;
use crate::parts::PartsPlan;
use crate::session;
use crate::station::{EndSettings, Framing, Kinematics, ScanPlan, ThermalSettings};

/// The kind of file that configurations and nominals are.
pub(crate) const TOML: &str = "a TOML file in UTF-8";

/// Everything a station needs to know.
#[derive(Clone, Debug)]
pub struct Config {
    /// Name of the station, as pages and reports show it.
    pub name: String,
    /// Links, in the order of the file.
    pub links: Vec<LinkConfig>,
    /// Devices, in the order of the file.
    pub devices: Vec<DeviceConfig>,
    /// Which devices share the trigger.
    pub sync: SyncConfig,
    /// How their readings make a point.
    pub kinematics: Kinematics,
    /// Errors of the machine, which are taken out of its points.
    pub calibration: Option<CalibrationFile>,
    /// Thermal expansion of the part and of the scales, which is taken out after that.
    pub thermal: Option<ThermalSettings>,
    /// The ball at the end of its stylus, whose contacts are measured; `None` for another probe.
    pub tip: Option<Tip>,
    /// Along which direction the points are projected for their mesh.
    pub along: Along,
    /// Design of the part.
    pub part: Part,
    /// When a scan is over.
    pub end: EndSettings,
    /// Plan by which the station drives the scan.
    pub scan: Option<ScanPlan>,
    /// Device whose program the station runs, as its place among the devices of `sync`.
    pub program: Option<usize>,
    /// Whether a session starts with the daemon.
    pub autostart: bool,
    /// Folder of the recordings.
    pub recordings: PathBuf,
    /// How recordings are written.
    pub recording: session::Settings,
    /// Whether points are recorded beside the bytes they were made of.
    pub records_points: bool,
    /// Files beside a recording.
    pub output: OutputConfig,
    /// The contour that is formed of the points of a session; `None` for none.
    pub contour: Option<ContourPlan>,
    /// The parts that are found in the points of a session; `None` for none.
    pub parts: Option<PartsPlan>,
    /// Where the page and the API are.
    pub listen: SocketAddr,
    /// Names, beside those of the loopback interface, a browser may ask for.
    pub allowed_hosts: Vec<String>,
    /// The text these settings were read from, with the nominal in it: what a recording keeps.
    pub text: String,
}

/// Why there is no configuration.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is no text of the kind that is read here.
    #[error("{}: expected {expected}, found {found}", path.display(), expected = TOML)]
    Text {
        /// Which.
        path: PathBuf,
        /// Kind of the content, and the cure.
        found: String,
    },
    /// Its content cannot be used.
    #[error("{} of the configuration cannot be used:\n{problems}", count(.problems))]
    Problems {
        /// All that is wrong.
        problems: Problems,
    },
}

impl From<Problems> for ConfigError {
    fn from(problems: Problems) -> ConfigError {
        ConfigError::Problems { problems }
    }
}

impl Config {
    /// Reads a configuration file and the nominal file it names.
    ///
    /// # Errors
    ///
    /// Every problem of both files at once, each with file, line and key.
    pub fn load(path: &Path) -> Result<Config, ConfigError> {
        let text = read(path)?;
        let file = asphera_nominal::parse_text(&path.display().to_string(), &text)?;
        let root = file.root();
        let nominal = root.section("nominal");
        let Some(nominal_file) =
            nominal.has("file").then(|| nominal.get::<String>("file")).flatten()
        else {
            return Ok(Config::parse(&path.display().to_string(), &text)?);
        };
        let nominal_path = path.parent().unwrap_or(Path::new(".")).join(nominal_file);
        let nominal_text = read(&nominal_path).unwrap_or_else(|error| {
            let name = nominal_path.display();
            match error {
                ConfigError::Read { source, .. } => {
                    nominal.problem("file", "a file that can be read", format!("{name}: {source}"));
                }
                ConfigError::Text { found, .. } => {
                    nominal.problem("file", TOML, format!("{name}: {found}"));
                }
                ConfigError::Problems { .. } => {}
            }
            String::new()
        });
        let part = asphera_nominal::parse(&nominal_path.display().to_string(), &nominal_text);
        let folder = nominal_path.parent().unwrap_or(Path::new(""));
        let text = pinned(inline(&text, &nominal_text), folder);
        let here = path.parent().unwrap_or(Path::new(""));
        let folders = Folders { nominal: folder, station: here };
        let config = read_root(&root, &text, folders, Some(part.as_ref().ok()));
        root.finish();
        drop((root, nominal));
        match (file.conclude(config), part) {
            (Ok(config), Ok(_)) => Ok(config),
            (config, part) => {
                // Of a file that could not be read there is nothing more to say.
                let part = part.err().filter(|_| !nominal_text.is_empty());
                let problems = [part, config.err()].into_iter().flatten();
                Err(Problems(problems.flat_map(|problems| problems.0).collect()).into())
            }
        }
    }

    /// Whether its points have errors together: those of a calibration, of tables of axes, of temperatures.
    pub fn has_systematic(&self) -> bool {
        let has_table = || self.kinematics.axes().iter().any(|axis| axis.errors.is_some());
        self.calibration.is_some() || self.thermal.is_some() || has_table()
    }

    /// Noise of the heights of its points, mm, where they are joined by time and it is stated.
    pub fn noise_mm(&self) -> Option<f64> {
        self.sync.time.as_ref()?.noise_mm
    }

    /// How many points a scan has, where that follows from its triggers.
    pub fn expected_points(&self) -> Option<u64> {
        self.end.points.filter(|_| self.kinematics.is_point_by_point())
    }

    /// Reads a configuration with its nominal in it; `name` stands in every problem.
    ///
    /// # Errors
    ///
    /// Every problem at once.
    pub fn parse(name: &str, text: &str) -> Result<Config, Problems> {
        let file = asphera_nominal::parse_text(name, text)?;
        let root = file.root();
        let folder = asphera_nominal::folder(name);
        let folders = Folders { nominal: folder, station: folder };
        let config = read_root(&root, &pinned(text.to_owned(), folder), folders, None);
        root.finish();
        drop(root);
        file.conclude(config)
    }
}

/// How many problems, in words.
fn count(problems: &Problems) -> String {
    match problems.0.len() {
        1 => "1 setting".to_owned(),
        count => format!("{count} settings"),
    }
}

fn read(path: &Path) -> Result<String, ConfigError> {
    let at = || path.to_owned();
    let bytes = asphera_nominal::bytes_of(path)
        .map_err(|source| ConfigError::Read { path: at(), source })?;
    asphera_nominal::text_of(&path.display().to_string(), bytes)
        .map_err(|found| ConfigError::Text { path: at(), found })
}

/// The configuration with the nominal file's tables in the place of its name. Both texts parse.
fn inline(text: &str, nominal: &str) -> String {
    let (Ok(mut document), Ok(nominal)) =
        (DocumentMut::from_str(text), DocumentMut::from_str(nominal))
    else {
        return text.to_owned();
    };
    let mut table = nominal.as_table().clone();
    table.set_implicit(true);
    document.insert("nominal", Item::Table(table));
    document.to_string()
}

/// The configuration with the whole path of the file its nominal surface names, so that a recording of it can
/// be replayed from another folder.
fn pinned(text: String, folder: &Path) -> String {
    let Ok(mut document) = DocumentMut::from_str(&text) else { return text };
    let file = document
        .get_mut("nominal")
        .and_then(|nominal| nominal.get_mut("surface"))
        .and_then(|surface| surface.get_mut("file"));
    let Some(file) = file else { return text };
    let whole = file.as_str().and_then(|name| std::path::absolute(folder.join(name)).ok());
    let Some(whole) = whole.as_deref().and_then(Path::to_str) else { return text };
    *file = toml_edit::value(whole);
    document.to_string()
}

/// Folders from which files are found.
#[derive(Clone, Copy)]
struct Folders<'a> {
    /// Files that a nominal names.
    nominal: &'a Path,
    /// Files that the configuration itself names.
    station: &'a Path,
}

/// Reads the whole file. `outside` is the nominal that was read from a file of its own, if it was named
/// and could be read.
fn read_root(
    root: &Section<'_>,
    text: &str,
    folders: Folders<'_>,
    outside: Option<Option<&Part>>,
) -> Option<Config> {
    let station = root.section("station");
    let name = station.required("name");
    let autostart = station.or("autostart", true);
    station.finish();

    let links: Vec<Option<LinkConfig>> = root
        .sections("link")
        .into_iter()
        .enumerate()
        .map(|(index, (name, table))| links::read(name, index, &table, folders.station))
        .collect();
    let link_names: Vec<String> = root.sections("link").into_iter().map(|(name, _)| name).collect();
    let device_tables = root.sections("device");
    let devices: Vec<Option<DeviceConfig>> = device_tables
        .iter()
        .map(|(name, table)| devices::read(name.clone(), table, &link_names))
        .collect();
    if link_names.is_empty() {
        root.problem("link", "at least one table [link.NAME]", "none");
    }
    if devices.is_empty() {
        root.problem("device", "at least one table [device.NAME]", "none");
    }
    check_links(&device_tables, &devices, &links);
    check_numbers(root, &device_tables, &devices);
    check_addresses(root, &link_names, &links);
    // A device that cannot be used would make every mention of it a problem of its own.
    let usable = devices.iter().all(Option::is_some);
    let devices: Vec<DeviceConfig> = devices.into_iter().flatten().collect();
    let tables = ErrorTables::new(folders.station);
    let (sync, kinematics) = points(root, usable.then_some(&devices), &tables);
    let text = &tables.embedded(text);
    let thermal = thermal::read(&root.section("thermal"), usable.then_some(&devices));

    let along = projection::read(&root.section("projection"));
    let others = [&root.section("contour"), &root.section("parts")];
    let tip = tip::read(&root.section("tip"), kinematics.as_ref(), along, others);

    let time = sync.as_ref().and_then(|sync| sync.time.as_ref());
    let noise_mm = time.and_then(|time| time.noise_mm);
    let part = part(&root.section("nominal"), folders.nominal, outside, noise_mm);
    let text = match &part {
        Some(part) => &attached::with_outline(text, part),
        None => text,
    };

    let known = sync.as_ref().zip(kinematics.as_ref()).zip(part.as_ref());
    let (end, scan, program) = scan(&root.section("scan"), known, &devices);

    let (recordings, recording, records_points) = session(&root.section("session"));
    let output = output::read(&root.section("output"));
    let (contour, text) = contour::read(&root.section("contour"), folders.station, text);
    let (parts, text) = parts::read(&root.section("parts"), folders.station, &text);
    let parts = parts.zip(part.as_ref()).map(|(plan, whole)| plan.with_whole(whole));
    let (calibration, text) = calibration::read(
        &root.section("calibration"),
        folders.station,
        kinematics.as_ref(),
        &text,
    );

    let (listen, allowed_hosts) = publish(&root.section("publish"));

    Some(Config {
        name: name?,
        links: links.into_iter().collect::<Option<_>>()?,
        devices,
        sync: sync?,
        kinematics: kinematics?,
        calibration,
        thermal,
        tip,
        along: along?,
        part: part?,
        end,
        scan,
        program,
        autostart,
        recordings,
        recording,
        records_points,
        output,
        listen: listen?,
        allowed_hosts,
        contour,
        parts,
        text,
    })
}

/// How readings are joined, and how they make points; nothing of both without devices.
fn points(
    root: &Section<'_>,
    devices: Option<&Vec<DeviceConfig>>,
    tables: &ErrorTables<'_>,
) -> (Option<SyncConfig>, Option<Kinematics>) {
    let (sync, kinematics) = (root.section("sync"), root.section("kinematics"));
    let Some(devices) = devices else { return (None, None) };
    let mut sync = motion::sync(&sync, devices);
    let kinematics = motion::kinematics(&kinematics, sync.as_ref(), devices, tables);
    if let Some(time) = sync.as_mut().and_then(|sync| sync.time.as_mut()) {
        time.turning = kinematics.as_ref().and_then(Kinematics::turning);
    }
    (sync, kinematics)
}

/// The part of the table `nominal`, or of the file it names.
/// Weights need points that carry an uncertainty: there is one where the noise of their heights is known.
fn part(
    nominal: &Section<'_>,
    folder: &Path,
    outside: Option<Option<&Part>>,
    noise_mm: Option<f64>,
) -> Option<Part> {
    let part = match outside {
        Some(part) => {
            nominal.has("file");
            part.cloned()
        }
        None => asphera_nominal::read(nominal, folder),
    };
    let is_weighted =
        part.as_ref().is_some_and(|part| part.criterion.weights == Weights::Uncertainty);
    if is_weighted && noise_mm.is_none() {
        let expected = "\"none\": points of a station carry no uncertainties, unless [sync] joins them by time and has noise_nm \
                        (those of a file may)";
        nominal.section("fit").problem("weights", expected, "\"uncertainty\"");
    }
    nominal.finish();
    part
}

/// Every device on a link of its kind, and alone on one that is no CAN bus.
fn check_links(
    device_tables: &[(String, Section<'_>)],
    devices: &[Option<DeviceConfig>],
    links: &[Option<LinkConfig>],
) {
    let mut on_link = vec![0_usize; links.len()];
    devices.iter().flatten().for_each(|device| on_link[device.link] += 1);
    for ((_, table), device) in device_tables.iter().zip(devices) {
        let Some(device) = device else { continue };
        let Some(link) = links.get(device.link).and_then(Option::as_ref) else { continue };
        if !link.framing.suits(device.carries) {
            let expected = match device.carries {
                Carries::CanFrames => "a CAN link",
                Carries::Bytes if link.framing.suits(Carries::CanFrames) => {
                    "a serial, tcp, udp or file link; or described with frame = \"can\""
                }
                Carries::Bytes => "a serial, tcp, udp or file link",
                Carries::Datagrams => "a udp link",
                Carries::TwoStreams => "a tcp-pair link",
            };
            table.problem("link", expected, format!("{} of kind {}", link.name, link.kind));
        }
        let others = on_link[device.link];
        if device.carries != Carries::CanFrames && others > 1 {
            table.problem("link", "one device on a link that is no CAN bus", others);
        }
        if device.settings.needs_fd()
            && link.framing.suits(device.carries)
            && !link.framing.carries_fd()
        {
            let expected = "a link that carries CAN FD: socketcan, candump, or slcan with data_bit_rate_bps; or fd = false";
            table.problem("link", expected, format!("{} of kind {}", link.name, link.kind));
        }
        if !link.framing.can_send() && device.is_sent_to() {
            let expected =
                "a link that can send, or settings that only listen: for cia406 listen_only = true";
            let found = match link.framing {
                Framing::File => "a file or pipe that answers nothing",
                Framing::Slcan { .. } => "an adapter with listen_only = true",
                _ => "a log that answers nothing",
            };
            let found = format!("{}, {found}", link.name);
            table.problem("link", expected, found);
        }
        if matches!(link.endpoint, Endpoint::Udp { peer: None, .. }) && device.is_sent_to() {
            let expected = format!(
                "a link that can send: set link.{}.peer to the address and port of the device",
                link.name
            );
            table.problem(
                "link",
                expected,
                "a udp link without peer, and settings with questions or commands",
            );
        }
    }
}

/// No two devices on a bus have one number.
fn check_numbers(
    root: &Section<'_>,
    device_tables: &[(String, Section<'_>)],
    devices: &[Option<DeviceConfig>],
) {
    let mut by_number = BTreeMap::new();
    for ((name, table), device) in device_tables.iter().zip(devices) {
        check_name("device", name, root);
        let Some(device) = device else { continue };
        let Some(BusNumber { key, number }) = device.settings.bus_number() else { continue };
        let earlier = *by_number.entry((device.link, number)).or_insert(device);
        if !std::ptr::eq(earlier, device) {
            let found = format!("{number}, which {} has", earlier.name);
            table.section("settings").problem(key, "a number of its own on this bus", found);
        }
    }
}

/// No two links lead to one address.
fn check_addresses(root: &Section<'_>, link_names: &[String], links: &[Option<LinkConfig>]) {
    let mut by_address = BTreeMap::new();
    for (name, link) in link_names.iter().zip(links) {
        check_name("link", name, root);
        let Some(link) = link else { continue };
        let address = link.place();
        let earlier = *by_address.entry(address.clone()).or_insert(link);
        if !std::ptr::eq(earlier, link) {
            let found = format!("{address}, where link {} leads", earlier.name);
            root.section("link").section(name).problem(
                "kind",
                "a port or address of its own",
                found,
            );
        }
    }
}

/// When a scan ends, and the plan or the program by which the station drives it. `known` are joining, kinematics and part, where all can be used.
fn scan(
    table: &Section<'_>,
    known: Option<((&SyncConfig, &Kinematics), &Part)>,
    devices: &[DeviceConfig],
) -> (EndSettings, Option<ScanPlan>, Option<usize>) {
    let station =
        known.map(|((sync, kinematics), part)| scan::Station { sync, kinematics, devices, part });
    let plan = scan::read(table, station.as_ref());
    let program = station.as_ref().and_then(|station| scan::program(table, station));
    (end(table), plan, program)
}

/// When a scan ends.
fn end(scan: &Section<'_>) -> EndSettings {
    let idle_s = scan.within("idle_s", 10.0, 0.01..=86_400.0);
    let end = EndSettings {
        points: scan.has("points").then(|| scan.within("points", 1, 1..=10_000_000_000)),
        idle: Some(Duration::from_secs_f64(idle_s)),
        first: Some(Duration::from_secs_f64(scan.within("first_s", idle_s, 0.01..=86_400.0))),
        open: scan
            .has("open_s")
            .then(|| Duration::from_secs_f64(scan.within("open_s", 10.0, 0.01..=86_400.0))),
    };
    scan.finish();
    end
}

/// Where the page is, and the names under which it answers beside its own.
fn publish(table: &Section<'_>) -> (Option<SocketAddr>, Vec<String>) {
    let listen: String = table.or("listen", "127.0.0.1:7717".to_owned());
    let address = listen
        .parse()
        .inspect_err(|_| table.problem("listen", "address:port", format!("{listen:?}")))
        .ok();
    let allowed_hosts = table.or("allowed_hosts", Vec::new());
    table.finish();
    (address, allowed_hosts)
}

/// Names stand in recordings and on the page.
fn check_name(kind: &str, name: &str, root: &Section<'_>) {
    if name.is_empty() || name.chars().any(char::is_control) {
        root.section(kind).problem(name, "a name of printable characters", format!("{name:?}"));
    }
}

/// Folder of the recordings, how they are written, and whether points stand in them.
fn session(table: &Section<'_>) -> (PathBuf, session::Settings, bool) {
    let recordings = PathBuf::from(table.or("dir", "recordings".to_owned()));
    let settings = recording(table);
    let records_points = table.or("points", true);
    table.finish();
    (recordings, settings, records_points)
}

fn recording(table: &Section<'_>) -> session::Settings {
    let default = session::Settings::default();
    session::Settings {
        segment_bytes: table.within("segment_mib", 64, 1..=4096u64) << 20,
        segment_s: table.within("segment_s", 60, 1..=86_400u32),
        sync_ms: table.within("sync_ms", 1000, 0..=60_000u32),
        reserve_bytes: table.within("reserve_mib", 256, 0..=1_000_000u64) << 20,
        ..default
    }
}

#[cfg(test)]
mod tests;
