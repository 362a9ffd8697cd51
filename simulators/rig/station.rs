//! The daemon's configuration for a bench.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use asphera_form::Nominal;
use toml::Value;

use crate::bench::{ProbeAddress, SYNC_OVERFLOW};
use crate::motion::Motion;
use crate::scene::Protocol;
use crate::{Scene, Speed, thermal};

/// What a configuration says that the bench does not know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationOptions {
    /// Folder of the recordings.
    pub recordings: PathBuf,
    /// Address and port of the page and the API; port 0: any.
    pub listen: SocketAddr,
}

/// Where the devices are.
pub(crate) struct Ports<'a> {
    pub(crate) probe: ProbeAddress<'a>,
    pub(crate) stage: &'a Path,
    pub(crate) thermal: Option<SocketAddr>,
}

/// The whole configuration.
pub(crate) fn toml(scene: &Scene, ports: &Ports<'_>, options: &StationOptions) -> String {
    let mut text = format!(
        "# Station of the simulated scene {}. The links lead to simulators.\n\n",
        scene.name
    );
    let mut section = |lines: String| {
        text.push_str(&lines);
        text.push('\n');
    };
    section(format!("[station]\nname = {}\n", quoted(&scene.title)));
    section(links(ports));
    section(devices(scene));
    if ports.thermal.is_some()
        && let Some(thermal) = scene.thermal
    {
        section(thermometer(thermal.unit_id));
    }
    section(kinematics(scene));
    section(nominal(scene));
    section(format!("[scan]\npoints = {}\nidle_s = {}\n", scene.points, float(idle_s(scene))));
    if matches!(scene.motion, Motion::Ball { .. }) {
        section("[projection]\nalong = \"none\"\n".to_owned());
    }
    if matches!(scene.motion, Motion::Section { .. }) {
        section(
            "[contour]\n# It joins the corner behind.\nmethod = \"connect2d\"\nairfoil = true\n"
                .to_owned(),
        );
    }
    section(format!("[session]\ndir = {}\n", quoted(&options.recordings.display().to_string())));
    text + &format!("[publish]\nlisten = {}\n", quoted(&options.listen.to_string()))
}

fn links(ports: &Ports<'_>) -> String {
    let path = |path: &Path| quoted(&path.display().to_string());
    let probe = match ports.probe {
        ProbeAddress::Serial(port) => {
            format!("kind = \"serial\"\npath = {}\nbaud_bd = 921600\n", path(port))
        }
        ProbeAddress::Tcp(address) => {
            format!("kind = \"tcp\"\naddress = {}\n", quoted(&address.to_string()))
        }
    };
    let mut text = format!(
        "[link.probe]\n{probe}\n\
         [link.stage]\nkind = \"slcan-serial\"\npath = {}\nbit_rate_bps = 1000000\n",
        path(ports.stage),
    );
    if let Some(address) = ports.thermal {
        text += &format!(
            "\n[link.thermal]\nkind = \"tcp\"\naddress = {}\n",
            quoted(&address.to_string())
        );
    }
    text
}

fn devices(scene: &Scene) -> String {
    let signals = match scene.motion {
        Motion::Spiral { .. } => "[75, 76, 65, 256, 257]",
        Motion::Raster { .. } | Motion::Section { .. } | Motion::Ball { .. } => {
            "[75, 76, 256, 257]"
        }
    };
    let protocol = match scene.protocol {
        Protocol::Dollar => format!(
            "# A simulator shares its processors with others and may pause within a telegram.\n\
             silence_ms = {SILENCE_MS}\n"
        ),
        Protocol::Packets => "protocol = \"packets\"\n".to_owned(),
    };
    let mut text = format!(
        "[device.probe]\ndriver = \"chrocodile2\"\nlink = \"probe\"\n\n\
         # Exposure count, exposure flags, rotary encoder on a polar machine, distance, intensity.\n\
         [device.probe.settings]\nsignals = {signals}\nsample_rate_hz = {}\ntrigger = \"each\"\n{protocol}",
        float(sample_rate_hz(scene)),
    );
    for (name, node_id) in stage_names(scene).iter().zip(&scene.node_ids) {
        text += &format!(
            "\n[device.{name}]\ndriver = \"cia406\"\nlink = \"stage\"\n\n\
             [device.{name}.settings]\nnode_id = {node_id}\nkind = \"linear\"\nstep_nm = {}\n\
             sync_counter_overflow = {SYNC_OVERFLOW}\n",
            float(scene.motion.step_nm().into()),
        );
    }
    text
}

/// Longer than a loaded machine holds a simulator up.
const SILENCE_MS: u32 = 250;

fn thermometer(unit_id: u8) -> String {
    let mut text = format!(
        "[device.thermal]\ndriver = \"modbus\"\nlink = \"thermal\"\n\n\
         [device.thermal.settings]\nframing = \"tcp\"\nunit_id = {unit_id}\npoll_interval_ms = 500\n"
    );
    for (address, name) in thermal::FIELDS.iter().enumerate() {
        text += &format!(
            "\n[[device.thermal.settings.field]]\nname = \"{name}\"\nfunction = \"input\"\n\
             address = {address}\nkind = \"i16\"\nscale = {}\nunit = \"degC\"\n",
            thermal::STEP_DEGC,
        );
    }
    text
}

fn kinematics(scene: &Scene) -> String {
    let stages = stage_names(scene);
    let devices = std::iter::once(&"probe").chain(stages).map(|name| format!("\"{name}\""));
    let devices: Vec<String> = devices.collect();
    let probe = format!(
        "{{ device = \"probe\", channel = \"distance1\", offset_mm = {} }}",
        float(-scene.standoff_mm)
    );
    let axis = |device: &str| format!("{{ device = \"{device}\", channel = \"position\" }}");
    let axes = match scene.motion {
        Motion::Spiral { counts_per_turn, .. } => format!(
            "kind = \"polar\"\n\
             rotary = {{ device = \"probe\", channel = \"encoder_x\", counts_per_turn = {} }}\n\
             radial = {}\nprobe = {probe}\n",
            float(counts_per_turn.into()),
            axis(stages[0]),
        ),
        Motion::Raster { .. } | Motion::Section { .. } | Motion::Ball { .. } => format!(
            "kind = \"cartesian\"\nx = {}\ny = {}\nz = {probe}\n",
            axis(stages[0]),
            axis(stages[1])
        ),
    };
    let pace = match scene.speed {
        Speed::Times(_) => "wait_ms = 1000\n".to_owned(),
        Speed::Max => format!(
            "# The bench goes as fast as this host lets it: when a reading arrives tells nothing of its trigger.\n\
             paced = false\nwait_ms = {FREE_WAIT_MS}\n"
        ),
    };
    let devices = devices.join(", ");
    format!("[sync]\ndevices = [{devices}]\n{pace}\n[kinematics]\n{axes}")
}

fn nominal(scene: &Scene) -> String {
    let surface = match &scene.nominal {
        Nominal::Plane => "kind = \"plane\"\n".to_owned(),
        Nominal::Sphere { radius_mm } => {
            format!("kind = \"sphere\"\nradius_mm = {}\n", float(*radius_mm))
        }
        Nominal::Asphere(asphere) => {
            let mut text = format!(
                "kind = \"asphere\"\nradius_mm = {}\nconic = {}\n",
                float(asphere.radius_mm),
                float(asphere.conic)
            );
            for order in (4..=20).step_by(2) {
                if let Some(value) = asphere.coefficient(order).filter(|&value| value != 0.0) {
                    text += &format!("A{order} = {}\n", float(value));
                }
            }
            text
        }
        // No scene that can be played has one.
        Nominal::Freeform(shape) => format!("kind = \"{}\"\n", shape.kind()),
    };
    let free: Vec<String> = scene.free.iter().map(|parameter| format!("\"{parameter}\"")).collect();
    let limit = |name: &str, limit_nm: Option<f64>| {
        limit_nm.map_or(String::new(), |limit_nm| format!("{name} = {}\n", float(limit_nm)))
    };
    // What is not scanned cannot be judged: a raster's aperture is its square, wide enough for a part that
    // does not sit in the middle.
    let aperture = match scene.motion {
        Motion::Spiral { .. } => {
            let radius = float(scene.semi_diameter_mm);
            format!("[nominal.aperture]\nshape = \"circle\"\nradius_mm = {radius}\n\n")
        }
        Motion::Raster { half_width_mm, .. } => {
            let side = float(2.0 * half_width_mm + 0.2);
            format!(
                "[nominal.aperture]\nshape = \"rectangle\"\nwidth_mm = {side}\nheight_mm = {side}\n\n"
            )
        }
        // Of an edge there is no area to be covered, and of a ball all of it is.
        Motion::Section { .. } | Motion::Ball { .. } => String::new(),
    };
    format!(
        "[nominal.surface]\n{surface}\n{aperture}[nominal.fit]\nfree = [{}]\n\n[nominal.tolerance]\n{}{}",
        free.join(", "),
        limit("pv_nm", scene.tolerance.pv_nm),
        limit("rms_nm", scene.tolerance.rms_nm),
    )
}

/// Devices of the stage, in the order of the nodes.
fn stage_names(scene: &Scene) -> &'static [&'static str] {
    match scene.motion {
        Motion::Spiral { .. } => &["stage"],
        Motion::Raster { .. } | Motion::Section { .. } | Motion::Ball { .. } => {
            &["stage_x", "stage_y"]
        }
    }
}

/// The probe's own rate must not be below that of the triggers, or it would lose some.
fn sample_rate_hz(scene: &Scene) -> f64 {
    match scene.speed {
        Speed::Times(times) => (scene.rate_hz * times).clamp(1000.0, FASTEST_HZ).ceil(),
        Speed::Max => FASTEST_HZ,
    }
}

/// How long nothing may come before the scan counts as over: longer than any outage of the scene.
fn idle_s(scene: &Scene) -> f64 {
    let outages = scene.faults.iter().map(|scheduled| scheduled.fault.outage().as_secs_f64());
    3.0 + outages.fold(0.0, f64::max)
}

/// As TOML has it: the shortest digits that are this number, never an integer.
fn float(value: f64) -> String {
    Value::Float(value).to_string()
}

fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}

/// A bench without a clock is not late; only what never comes is given up. The end of the scan does so, too.
const FREE_WAIT_MS: u32 = 60_000;

/// Highest rate of a CHRocodile 2, Hz.
const FASTEST_HZ: f64 = 66_000.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn station(name: &str, thermal: bool) -> toml::Table {
        station_of(&Scene::built_in(name).unwrap(), thermal)
    }

    fn station_of(scene: &Scene, thermal: bool) -> toml::Table {
        let ports = Ports {
            probe: match scene.protocol {
                Protocol::Dollar => ProbeAddress::Serial(Path::new("/run/a \"b\"/probe")),
                Protocol::Packets => ProbeAddress::Tcp("127.0.0.1:7891".parse().unwrap()),
            },
            stage: Path::new("/run/stage"),
            thermal: thermal.then(|| "127.0.0.1:1502".parse().unwrap()),
        };
        let options = StationOptions {
            recordings: "/tmp/recordings".into(),
            listen: "127.0.0.1:0".parse().unwrap(),
        };
        toml(scene, &ports, &options).parse().unwrap()
    }

    fn at<'a>(table: &'a toml::Table, path: &str) -> &'a Value {
        let mut keys = path.split('.');
        let first = &table[keys.next().unwrap()];
        keys.fold(first, |value, key| &value[key])
    }

    #[test]
    fn a_polar_station_has_every_table_the_daemon_needs() {
        let table = station("asphere", true);
        for (path, expected) in [
            ("link.probe.path", Value::from("/run/a \"b\"/probe")),
            ("link.stage.kind", Value::from("slcan-serial")),
            ("link.thermal.address", Value::from("127.0.0.1:1502")),
            ("device.probe.driver", Value::from("chrocodile2")),
            ("device.probe.settings.sample_rate_hz", Value::from(4000.0)),
            ("device.stage.settings.node_id", Value::from(5)),
            ("device.thermal.settings.framing", Value::from("tcp")),
            ("kinematics.kind", Value::from("polar")),
            ("kinematics.rotary.counts_per_turn", Value::from(3.6e6)),
            ("kinematics.probe.offset_mm", Value::from(-1.0)),
            ("nominal.surface.A8", Value::from(-1.400167659754e-10)),
            ("nominal.aperture.radius_mm", Value::from(9.0)),
            ("nominal.tolerance.rms_nm", Value::from(150.0)),
            ("scan.points", Value::from(100_000)),
            ("scan.idle_s", Value::from(3.0)),
            ("session.dir", Value::from("/tmp/recordings")),
            ("publish.listen", Value::from("127.0.0.1:0")),
        ] {
            assert_eq!(*at(&table, path), expected, "{path}");
        }
        let fields = at(&table, "device.thermal.settings.field").as_array().unwrap();
        assert_eq!(fields.len(), 2);
        let devices = at(&table, "sync.devices").as_array().unwrap();
        assert_eq!(devices, &[Value::from("probe"), Value::from("stage")]);
    }

    #[test]
    fn a_probe_on_packets_is_reached_over_tcp() {
        let text = Scene::built_in_toml("asphere").unwrap();
        let text = text.replace("# protocol = \"packets\"", "protocol = \"packets\"");
        let table = station_of(&Scene::parse("packets", &text).unwrap(), false);
        for (path, expected) in [
            ("link.probe.kind", "tcp"),
            ("link.probe.address", "127.0.0.1:7891"),
            ("device.probe.settings.protocol", "packets"),
        ] {
            assert_eq!(at(&table, path), &Value::from(expected), "{path}");
        }
        let settings = at(&table, "device.probe.settings").as_table().unwrap();
        assert!(!settings.contains_key("silence_ms"));
    }

    #[test]
    fn a_cartesian_station_has_both_nodes_on_one_link() {
        let table = station("sphere", false);
        assert_eq!(*at(&table, "kinematics.y.device"), Value::from("stage_y"));
        assert_eq!(*at(&table, "device.stage_y.settings.node_id"), Value::from(6));
        assert_eq!(*at(&table, "device.stage_x.link"), Value::from("stage"));
        assert!(!table["link"].as_table().unwrap().contains_key("thermal"));
        assert!(!table["device"].as_table().unwrap().contains_key("thermal"));
    }

    #[test]
    fn a_bench_at_full_speed_has_no_pace_of_its_own() {
        let scene = Scene::built_in("asphere").unwrap();
        let free = station_of(&scene.clone().with_speed(Speed::Max), true);
        assert_eq!(*at(&free, "sync.paced"), Value::from(false));
        let paced = station_of(&scene.with_speed(Speed::Times(2.0)), true);
        assert!(!paced["sync"].as_table().unwrap().contains_key("paced"));
    }

    #[test]
    fn an_outage_of_the_scene_is_no_end_of_the_scan() {
        let table = station("asphere-unplugged", true);
        assert_eq!(*at(&table, "scan.idle_s"), Value::from(6.0));
    }
}
