//! Links that carry CAN frames as text.

use super::*;
use crate::station::Framing;

/// A station with two encoders on links of their own.
fn station(x: &str, z: &str, settings: &str) -> Result<Config, Problems> {
    let text = format!(
        "[station]\nname = \"can\"\n[link.a]\n{x}\n[link.b]\n{z}\n\
         [device.x]\ndriver = \"cia406\"\nlink = \"a\"\nsettings = {{ {settings} }}\n\
         [device.z]\ndriver = \"cia406\"\nlink = \"b\"\nsettings = {{ {settings} }}\n\
         [sync]\ndevices = [\"x\", \"z\"]\n\
         [kinematics]\nkind = \"cartesian\"\nx = {{ device = \"x\", channel = \"position\" }}\n\
         y = {{ constant_mm = 0 }}\nz = {{ device = \"z\", channel = \"position\" }}\n\
         [nominal.surface]\nkind = \"plane\"\n"
    );
    Config::parse("bench/station.toml", &text)
}

fn keys(config: Result<Config, Problems>) -> Vec<String> {
    config.unwrap_err().0.into_iter().map(|problem| problem.key).collect()
}

const LISTENER: &str = "node_id = 5, listen_only = true, step_nm = 100";

#[test]
fn two_buses_of_a_server_are_two_links() {
    let link = |bus: &str| format!("kind = \"socketcand\"\naddress = \"h:29536\"\nbus = \"{bus}\"");
    let config = station(&link("can0"), &link("can1"), "node_id = 5").unwrap();
    assert_eq!(config.links[1].framing, Framing::Socketcand { bus: "can1".to_owned() });
    assert_eq!(config.links[1].endpoint, Endpoint::Tcp { address: "h:29536".to_owned() });
    assert_eq!(keys(station(&link("can0"), &link("can0"), "node_id = 5")), ["link.b.kind"]);
    for bus in ["", "can 0", "can>", "a-name-of-17-sign"] {
        assert_eq!(
            keys(station(&link("can0"), &link(bus), "node_id = 5")),
            ["link.b.bus"],
            "{bus}"
        );
    }
}

/// An adapter that listens only cannot ask a node.
#[test]
fn an_adapter_that_listens_only_has_listeners_alone() {
    let link = |port: u16| {
        format!(
            "kind = \"slcan-tcp\"\naddress = \"h:{port}\"\nbit_rate_bps = 500000\nlisten_only = true"
        )
    };
    let config = station(&link(1), &link(2), LISTENER).unwrap();
    let framing = &config.links[0].framing;
    assert!(matches!(framing, Framing::Slcan { listen_only: true, .. }), "{framing:?}");
    let problems = station(&link(1), &link(2), "node_id = 5").unwrap_err();
    let words = "expected a link that can send, or settings that only listen: for cia406 listen_only = true";
    assert!(problems.to_string().contains(words), "{problems}");
    assert!(problems.to_string().contains("a, an adapter with listen_only = true"), "{problems}");
    assert_eq!(keys(Err(problems)), ["device.x.link", "device.z.link"]);
}

#[test]
fn a_log_is_found_from_the_folder_of_the_file_and_has_listeners_alone() {
    let link = |more: &str| format!("kind = \"candump\"\nfile = \"bus.log\"\n{more}");
    let config =
        station(&link("interface = \"can0\""), &link("interface = \"can1\"\nspeed = 10"), LISTENER);
    let config = config.unwrap();
    assert_eq!(config.links[0].framing, Framing::Candump { interface: Some("can0".to_owned()) });
    let path = PathBuf::from("bench/bus.log");
    assert_eq!(config.links[1].endpoint, Endpoint::CanLog { path, speed: 10.0 });
    let (a, b) = (link(""), link("interface = \"can1\""));
    let asking = station(&a, &b, "node_id = 5");
    assert_eq!(keys(asking), ["device.x.link", "device.z.link"]);
    assert_eq!(
        keys(station(&a, &link("speed = 0\ninterface = \"can1\""), LISTENER)),
        ["link.b.speed"]
    );
    assert_eq!(keys(station(&a, "kind = \"candump\"", LISTENER)), ["link.b.file"]);
}

/// CANopen reads classic frames, at whatever rate the data of others go.
#[test]
fn an_adapter_of_can_fd_has_a_data_bit_rate() {
    let link = |port: u16, rate: &str| {
        format!("kind = \"slcan-tcp\"\naddress = \"h:{port}\"\nbit_rate_bps = 500000\n{rate}")
    };
    let fast = link(1, "data_bit_rate_bps = 2000000");
    let config = station(&fast, &link(2, ""), "node_id = 5").unwrap();
    let rates = config.links.iter().map(|link| match link.framing {
        Framing::Slcan { data_bit_rate, .. } => data_bit_rate,
        _ => panic!("{:?}", link.framing),
    });
    assert_eq!(rates.collect::<Vec<_>>(), [Some(asphera_slcan::DataBitRate::Mbps2), None]);
    let wrong = station(&fast, &link(2, "data_bit_rate_bps = 3000000"), "node_id = 5").unwrap_err();
    assert!(wrong.to_string().contains("it has 1, 2, 4 and 5 Mbit/s"), "{wrong}");
    assert_eq!(keys(Err(wrong)), ["link.b.data_bit_rate_bps"]);
}

/// A device of CAN FD needs a link that carries it, and one that is asked needs one that sends.
#[test]
fn a_described_device_is_on_a_bus_that_carries_its_frames() {
    let text = read(&project("examples/can-transducers.toml")).unwrap();
    let text = text.replace("file = \"flat.toml\"", "surface = { kind = \"plane\" }");
    let with = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        Config::parse("bench/station.toml", &text.replace(from, to))
    };
    let config = with("data_bit_rate_bps = 2000000\n", "data_bit_rate_bps = 5000000\n").unwrap();
    assert_eq!(config.devices[0].carries, Carries::CanFrames);
    let classic = with("data_bit_rate_bps = 2000000\n", "").unwrap_err();
    let words =
        "expected a link that carries CAN FD: socketcan, candump, or slcan with data_bit_rate_bps";
    assert!(classic.to_string().contains(words), "{classic}");
    assert_eq!(keys(Err(classic)), ["device.gauge.link"]);
    let silent =
        with("data_bit_rate_bps = 2000000\n", "data_bit_rate_bps = 2000000\nlisten_only = true\n");
    assert_eq!(keys(silent), ["device.gauge.link"], "it is started by a frame");
    let wrong = with("start_bit = 31", "start_bit = 60").unwrap_err();
    assert_eq!(keys(Err(wrong)), ["device.scale.settings.field[1].start_bit"]);
    let bytes = with(
        "frame = \"can\"\nid = 0x00FF1200\nextended = true\nmask = 0x03FFFF00\n",
        "columns = 3\n",
    );
    let bytes = bytes.unwrap_err().to_string();
    assert!(bytes.contains("device.scale.settings"), "{bytes}");
}
