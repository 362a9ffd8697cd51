//! Simulated line sensors, each with a thread that sends profiles on time and notes when their last byte went.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use asphera::clock::Clock;
use asphera_link::Nanos;
use asphera_sim_chrocodile::{Exposure, PacketDevice, Sample};
use asphera_sim_keyence::{Controller, Scan as KeyenceScan, ScanSettings, Surface};
use asphera_sim_rf627::{Departure, Optics, Part, Scan, Scanner};

/// Kind of the line sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Device {
    /// RIFTEK RF627: datagrams of 640 points.
    Rf627,
    /// Keyence LJ-X8000: profiles of 800 points over TCP.
    Keyence,
    /// CHRocodile on packets: lines of 192 points over TCP.
    Chrocodile,
}

impl Device {
    /// The device that a command line names.
    pub(crate) fn named(name: &str) -> Option<Device> {
        Some(match name {
            "rf627" => Device::Rf627,
            "keyence" => Device::Keyence,
            "chrocodile" => Device::Chrocodile,
            _ => return None,
        })
    }
}

/// Profiles that are sent.
#[derive(Clone, Debug)]
pub(crate) struct Load {
    device: Device,
    /// Points of a profile.
    pub(crate) points: usize,
    /// Number of profiles.
    pub(crate) profiles: u32,
    /// Profiles a second.
    rate_hz: f64,
}

impl Load {
    /// So many points a second from a device, for so long.
    pub(crate) fn new(device: Device, points_per_s: f64, seconds: f64) -> Load {
        let points = match device {
            Device::Rf627 => 640,
            Device::Keyence => 800,
            Device::Chrocodile => 192,
        };
        let rate_hz = points_per_s / points as f64;
        Load { device, points, profiles: (rate_hz * seconds) as u32, rate_hz }
    }

    /// Distance of profiles in mm: that of the points.
    fn step_mm(&self) -> f64 {
        LINE_MM / self.points as f64
    }

    fn length_mm(&self) -> f64 {
        self.step_mm() * f64::from(self.profiles)
    }
}

/// A device that waits for its host.
pub(crate) enum Sender {
    /// Datagrams, and where they go.
    Datagrams(Load, Vec<Departure>, UdpSocket),
    /// Ports of commands and profiles.
    Pair(Load, TcpListener, TcpListener),
    /// Port of a device on packets.
    Packets(Load, TcpListener),
}

/// A device and the configuration of its station, which records into `folder`.
pub(crate) fn start(load: &Load, folder: &Path) -> (Sender, String) {
    let bind = || TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = |listener: &TcpListener| listener.local_addr().expect("an address").port();
    let load = load.clone();
    match load.device {
        Device::Rf627 => {
            let free = UdpSocket::bind("127.0.0.1:0").expect("a port");
            let host = free.local_addr().expect("an address");
            drop(free);
            let link = format!("kind = \"udp\"\nlisten = \"{host}\"");
            let text = text(
                &load,
                folder,
                (&link, "rf627", ""),
                ("step", "reverse = true, offset_mm = 5"),
            );
            let socket = UdpSocket::bind("127.0.0.1:0").expect("a port");
            socket.connect(host).expect("the host's address");
            (Sender::Datagrams(load.clone(), datagrams(&load), socket), text)
        }
        Device::Keyence => {
            let (commands, profiles) = (bind(), bind());
            let link = format!(
                "kind = \"tcp-pair\"\naddress = \"127.0.0.1:{}\"\nsecond_port = {}",
                port(&commands),
                port(&profiles)
            );
            let text = text(
                &load,
                folder,
                (&link, "keyence-lj", "series = \"lj-x8000\""),
                ("encoder", ""),
            );
            (Sender::Pair(load, commands, profiles), text)
        }
        Device::Chrocodile => {
            let listener = bind();
            let link = format!("kind = \"tcp\"\naddress = \"127.0.0.1:{}\"", port(&listener));
            let settings = format!(
                "protocol = \"packets\"\nsignals = [75, 76, 65, 16640, 16641]\nsample_rate_hz = {}\ntrigger = \"each\"\n\
                 pitch_um = {}\nscale_um = 3000",
                load.rate_hz.round(),
                1e3 * load.step_mm(),
            );
            let text = text(
                &load,
                folder,
                (&link, "chrocodile2", &settings),
                ("encoder_x", "offset_mm = 1.5, reverse = true"),
            );
            (Sender::Packets(load, listener), text)
        }
    }
}

/// A plane on a stage: what it is scanned with, and how places follow.
fn text(
    load: &Load,
    folder: &Path,
    (link, driver, settings): (&str, &str, &str),
    (along, height): (&str, &str),
) -> String {
    let (step_mm, length_mm) = (load.step_mm(), load.length_mm());
    // The line of the CHRocodile begins at x = 0.
    let across_mm = if matches!(load.device, Device::Chrocodile) { -0.5 * LINE_MM } else { 0.0 };
    format!(
        "[station]\nname = \"bench\"\n[link.scanner]\n{link}\n[device.scanner]\ndriver = \"{driver}\"\nlink = \"scanner\"\n\
         [device.scanner.settings]\n{settings}\n[sync]\ndevices = [\"scanner\"]\n[kinematics]\nkind = \"line\"\n\
         across = {{ device = \"scanner\", offset_mm = {across_mm:?} }}\n\
         along = {{ device = \"scanner\", channel = \"{along}\", mm_per_count = {step_mm:?}, offset_mm = {:?} }}\n\
         height = {{ {height} }}\n\
         [nominal.surface]\nkind = \"plane\"\n\
         [nominal.aperture]\nshape = \"rectangle\"\nwidth_mm = {:?}\nheight_mm = {length_mm:?}\n\
         [nominal.fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n[nominal.tolerance]\npv_nm = 30000\nrms_nm = 9000\n\
         [scan]\npoints = {}\nidle_s = 3\n[session]\ndir = {:?}\n",
        -0.5 * length_mm,
        0.95 * LINE_MM,
        load.profiles,
        folder.display().to_string()
    )
}

impl Sender {
    /// Sends all profiles on time from when the host is ready; gives the times at which they went.
    pub(crate) fn send(self, clock: Clock) -> JoinHandle<Vec<Nanos>> {
        std::thread::spawn(move || match self {
            Sender::Datagrams(load, departures, socket) => {
                // The port is open some ms after the session began.
                std::thread::park_timeout(Duration::from_millis(500));
                let mut departures = departures.into_iter();
                paced(&load, &clock, |_| {
                    // A scanner does not notice that nobody listens.
                    departures
                        .next()
                        .map(|departure| drop(socket.send(&departure.datagram)))
                        .is_some()
                })
            }
            Sender::Pair(load, commands, profiles) => keyence(&load, &clock, &commands, &profiles),
            Sender::Packets(load, listener) => chrocodile(&load, &clock, &listener),
        })
    }
}

/// Sends profile after profile on time until there is none; late ones at once.
fn paced(load: &Load, clock: &Clock, mut send: impl FnMut(u32) -> bool) -> Vec<Nanos> {
    let start = clock.now();
    let mut sent = Vec::new();
    for profile in 0..load.profiles {
        let due = start + Duration::from_secs_f64(f64::from(profile) / load.rate_hz);
        let early = due.since(clock.now());
        if !early.is_zero() {
            std::thread::park_timeout(early);
        }
        if !send(profile) {
            break;
        }
        sent.push(clock.now());
    }
    sent
}

fn datagrams(load: &Load) -> Vec<Departure> {
    let optics =
        Optics { points: load.points, rate_hz: load.rate_hz, noise_um: 1.0, ..Optics::default() };
    let scan = Scan {
        part: Part { radius_mm: None, wave_um: 5.0, wave_length_mm: 4.0, half_width_mm: LINE_MM },
        first_y_mm: -0.5 * load.length_mm(),
        steps: 1,
        step_mm: load.step_mm(),
        profiles: load.profiles,
    };
    scan.departures(&mut Scanner::new(optics, 1), &[], 1).expect("profiles that fit")
}

fn keyence(
    load: &Load,
    clock: &Clock,
    commands: &TcpListener,
    profiles: &TcpListener,
) -> Vec<Nanos> {
    let optics = asphera_sim_keyence::Optics {
        points: load.points as u16,
        pitch_10nm: (1e5 * load.step_mm()).round() as i32,
        noise_um: 0.5,
        ..Default::default()
    };
    let mut scan = KeyenceScan::new(
        ScanSettings {
            surface: Surface::new(|[x, y]| Some(5e-3 * (1.5 * x).sin() * (1.5 * y).sin())),
            first_y_mm: -0.5 * load.length_mm(),
            steps: 1,
            step_mm: load.step_mm(),
            profiles: load.profiles,
            rate_hz: load.rate_hz,
        },
        &[],
    );
    let controller = Arc::new(Mutex::new(Controller::new(optics, 1)));
    let (mut asked, _) = commands.accept().expect("a host");
    let (mut stream, _) = profiles.accept().expect("a host");
    stream.set_nodelay(true).expect("a socket");
    let answering = controller.clone();
    std::thread::spawn(move || {
        let mut bytes = [0; 1024];
        while let Ok(len @ 1..) = asked.read(&mut bytes) {
            let answers = answering.lock().expect("a controller").receive(&bytes[..len]);
            if asked.write_all(&answers).is_err() {
                break;
            }
        }
    });
    wait_until(|| controller.lock().expect("a controller").is_streaming());
    paced(load, clock, |_| {
        let bytes = scan.advance(&mut controller.lock().expect("a controller"));
        bytes.is_some_and(|bytes| stream.write_all(&bytes).is_ok())
    })
}

fn chrocodile(load: &Load, clock: &Clock, listener: &TcpListener) -> Vec<Nanos> {
    let device = Arc::new(Mutex::new(PacketDevice::new(3000.0, load.points as u16)));
    let (stream, _) = listener.accept().expect("a host");
    stream.set_nodelay(true).expect("a socket");
    let mut host = stream.try_clone().expect("a socket");
    let answering = device.clone();
    let transmit = |device: &Mutex<PacketDevice>, mut stream: &TcpStream| {
        // Under the lock: packets keep their order.
        let mut device = device.lock().expect("a device");
        let bytes = device.transmit();
        stream.write_all(&bytes).is_ok()
    };
    let answers = stream.try_clone().expect("a socket");
    std::thread::spawn(move || {
        let mut bytes = [0; 1024];
        while let Ok(len @ 1..) = host.read(&mut bytes) {
            answering.lock().expect("a device").receive(&bytes[..len]);
            if !transmit(&answering, &answers) {
                break;
            }
        }
    });
    wait_until(|| device.lock().expect("a device").armed());
    paced(load, clock, |profile| {
        let wave_um = 5.0 * (f64::from(profile) * load.step_mm() * 1.5).sin();
        let line_um = (0..load.points)
            .map(|point| Some(1500.0 + wave_um * (point as f64 * load.step_mm() * 1.5).sin()))
            .collect();
        let sample = Sample {
            exposure_count: profile.into(),
            start_ns: (1e9 * f64::from(profile) / load.rate_hz) as u64,
            encoder: [profile.cast_signed(), 0, 0, 0, 0],
            ..Sample::default()
        };
        device.lock().expect("a device").expose(&Exposure { sample, line_um: Some(line_um) });
        transmit(&device, &stream)
    })
}

fn wait_until(is_ready: impl Fn() -> bool) {
    while !is_ready() {
        std::thread::park_timeout(Duration::from_millis(10));
    }
}

/// Length of the line.
const LINE_MM: f64 = 10.0;
