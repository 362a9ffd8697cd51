//! Two devices without a shared count, each with a clock of its own, joined by time.

use std::io::Write as _;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use asphera_tests::{Running, asphera, count, json, json_file, now, number, recording, run};

/// Radius of the sphere under the gauge, mm.
const RADIUS_MM: f64 = 50.0;
/// A stage that goes to and fro, at most at 25 mm/s.
fn place_mm(t_s: f64) -> [f64; 2] {
    [8.0 * (3.1 * t_s).sin(), 8.0 * (0.43 * t_s).sin()]
}

fn height_mm([x_mm, y_mm]: [f64; 2]) -> f64 {
    let s2 = x_mm * x_mm + y_mm * y_mm;
    s2 / (RADIUS_MM + (RADIUS_MM * RADIUS_MM - s2).sqrt())
}

/// A device that sends a line every so often for some seconds: its own time, and what it shows at that instant. It gathers lines, as
/// an adapter does, for up to `gathers_ms`.
struct Sender {
    period_s: f64,
    seconds: f64,
    gathers_ms: u64,
    /// Its clock at the start, s, and how much it gains.
    clock_s: f64,
    gains_ppm: f64,
    shows: fn(f64) -> String,
}

impl Sender {
    /// Its address, once it listens.
    fn start(self, began: Instant) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        std::thread::spawn(move || {
            let Ok((mut stream, _)) = listener.accept() else { return };
            stream.set_nodelay(true).unwrap();
            let first = (began.elapsed().as_secs_f64() / self.period_s).ceil() as u64;
            let numbers = (self.seconds / self.period_s) as u64;
            let (mut n, mut turn) = (first, 0_u64);
            while n < first + numbers {
                turn += 1;
                std::thread::park_timeout(Duration::from_millis(1 + turn * 7919 % self.gathers_ms));
                let mut lines = String::new();
                while n < first + numbers
                    && n as f64 * self.period_s <= began.elapsed().as_secs_f64()
                {
                    let t_s = n as f64 * self.period_s;
                    let own_s = self.clock_s + t_s * (1.0 + self.gains_ppm * 1e-6);
                    lines += &format!("{own_s:.7},{}\r\n", (self.shows)(t_s));
                    n += 1;
                }
                // A client that went away ends the device's thread.
                if stream.write_all(lines.as_bytes()).is_err() {
                    return;
                }
            }
            // The link stays open: it is the device that is silent.
            std::thread::park_timeout(Duration::from_secs(60));
        });
        address
    }
}

fn station(folder: &Path, gauge: &str, stage: &str) -> PathBuf {
    let nominal = format!(
        "[surface]\nkind = \"sphere\"\nradius_mm = {RADIUS_MM}\n[fit]\nfree = [\"tz\"]\nweights = \"uncertainty\"\n"
    );
    std::fs::write(folder.join("sphere.toml"), nominal).unwrap();
    let device = |name: &str, address: &str, columns: &[&str]| {
        let mut text = format!(
            "[link.{name}]\nkind = \"tcp\"\naddress = \"{address}\"\n[device.{name}]\ndriver = \"described\"\n\
             link = \"{name}\"\n[device.{name}.settings]\nseparator = \",\"\ncolumns = {}\n\
             [[device.{name}.settings.field]]\nname = \"t\"\ncolumn = 1\nrole = \"device-time\"\nunit = \"s\"\n",
            columns.len() + 1
        );
        for (index, column) in columns.iter().enumerate() {
            text += &format!(
                "[[device.{name}.settings.field]]\nname = \"{column}\"\ncolumn = {}\nunit = \"mm\"\n",
                index + 2
            );
        }
        text
    };
    let text = format!(
        "[station]\nname = \"gauge and stage\"\n{}{}[sync]\ndevices = [\"gauge\", \"stage\"]\nby = \"time\"\n\
         gap_limit_ms = 150\nu_limit_um = 200\nnoise_nm = 50\n\
         clock = {{ gauge = {{ u_ms = 0.05 }}, stage = {{ u_ms = 0.05 }} }}\n\
         [kinematics]\nkind = \"cartesian\"\nx = {{ device = \"stage\", channel = \"x\" }}\n\
         y = {{ device = \"stage\", channel = \"y\" }}\nz = {{ device = \"gauge\", channel = \"z\" }}\n\
         [nominal]\nfile = \"sphere.toml\"\n[scan]\nidle_s = 2\n[session]\ndir = {:?}\n\
         [publish]\nlisten = \"127.0.0.1:0\"\n[output]\nfiles = [\"report.json\"]\n",
        device("gauge", gauge, &["z"]),
        device("stage", stage, &["x", "y"]),
        folder.join("recordings").display().to_string(),
    );
    let path = folder.join("station.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// The gauge measures 7 s, the stage falls silent after 5.
#[test]
fn a_gauge_and_a_stage_with_clocks_of_their_own_measure_a_sphere() {
    // The daemon may have to be built first.
    let binary = asphera();
    let began = now();
    let gauge = Sender {
        period_s: 0.002,
        seconds: 7.0,
        gathers_ms: 9,
        clock_s: 4000.0,
        gains_ppm: 80.0,
        shows: |t_s| format!("{:.7}", height_mm(place_mm(t_s))),
    };
    let stage = Sender {
        period_s: 0.02,
        seconds: 5.0,
        gathers_ms: 13,
        clock_s: 17.5,
        gains_ppm: -150.0,
        shows: |t_s| {
            let [x_mm, y_mm] = place_mm(t_s);
            format!("{x_mm:.7},{y_mm:.7}")
        },
    };
    let folder = tempfile::tempdir().unwrap();
    let config = station(folder.path(), &gauge.start(began), &stage.start(began));
    let running =
        Running::start(Command::new(binary).args(["run", "--once", "--config"]).arg(config));
    let output = running.wait(Duration::from_secs(120));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let session = recording(&folder.path().join("recordings"));
    assert!(session.join("report.json").exists(), "{words}");
    let report = json_file(&session.join("report.json"));

    let (received, used) = (count(&report, "/points/received"), count(&report, "/points/used"));
    assert!(received > 3000 && used > 1500, "{report:#}");
    // Nearly two seconds of the gauge have no place, and none is made up.
    let unjoined = count(&report, "/points/flagged/unjoined");
    assert!(unjoined >= 900, "{report:#}");
    let uncertain = report["points"]["flagged"]["uncertain_place"].as_u64().unwrap_or(0);
    assert!(used + unjoined + uncertain >= received, "{report:#}");

    // One period of the stage at its speed would be 0.5 mm, which its slope makes 80 µm of height.
    let [rms_um, largest_um] =
        ["rms_um", "largest_um"].map(|of| number(&report, &format!("/session/places/{of}")));
    assert!(rms_um < 30.0 && largest_um <= 200.0, "{report:#}");
    let steepest = 0.25;
    let rms_nm = number(&report, "/form/deviation/rms_nm");
    assert!(rms_nm < 2000.0 * steepest * rms_um, "{rms_nm} nm of places known to {rms_um} µm");
    assert!(rms_nm < 3000.0, "{report:#}");

    // Points count by what is known of them: 50 nm of noise, and what the joining adds on each slope.
    let [u_min_nm, u_max_nm, chi_square] = ["u_min_nm", "u_max_nm", "reduced_chi_square"]
        .map(|of| number(&report, &format!("/form/fit/weights/{of}")));
    assert!(u_min_nm >= 50.0 && u_max_nm > 4.0 * u_min_nm, "{report:#}");
    assert!(chi_square < 2.0, "errors are no larger than their uncertainties say: {chi_square}");

    for (link, gains_ppm) in [(0, 80.0), (1, -150.0)] {
        let clock = |of: &str| number(&report, &format!("/links/{link}/devices/0/clock/{of}"));
        let off_ppm = (clock("drift_ppm") - gains_ppm).abs();
        assert!(off_ppm <= 3.0 * clock("u_drift_ppm") + 1.0, "{report:#}");
        assert_eq!(clock("jumps"), 0.0);
    }
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    for of in ["form", "points", "links", "session"] {
        assert_eq!(replayed[of], report[of], "a replay gives the same figures");
    }
}
