//! Settings of the driver.

use std::time::Duration;

use asphera_link::{Channel, MAX_CHANNELS, Problem, check_range, millis};

use crate::wire::{MAX_SIGNALS, Part, Quantity, SYNC, Signal};

/// What starts an exposure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trigger {
    /// The device's own clock (`$CTN`).
    Free,
    /// Each trigger at its sync input or encoder (`$TRE`).
    #[default]
    Each,
}

/// What the driver tells the device, and how it judges what comes back.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Identifiers of the signals of a telegram, in this order (`$SODX`). 1 to 32, each once, at least
    /// one that becomes a channel.
    ///
    /// With the exposure count (75) among them, resynchronization is far safer.
    pub signals: Vec<u16>,
    /// Exposures per second in Hz (`$SHZ`); the device refuses what it cannot do. 1 to 100000.
    pub sample_rate_hz: f64,
    /// Exposures averaged into one telegram (`$AVD`), at least 1.
    pub averaging: u16,
    /// What starts an exposure.
    pub trigger: Trigger,
    /// Full scale of the probe in µm. `None`: the device is asked (`$SCA ?`).
    pub scale_um: Option<f64>,
    /// Intensity of the first peak below which a reading is weak, in the unit the device sends.
    /// 0: never. Needs the intensity of the peak among the signals.
    pub intensity_min: f64,
    /// The two sync bytes, as the device is set up (`$SSQ`); they are not sent to it.
    pub sync: [u8; 2],
    /// How long the device may take to echo and answer a command, in ms. It is asked twice.
    pub ready_timeout_ms: u32,
    /// After this many ms without a byte, a complete telegram counts as the last of its burst. Longer
    /// than any pause within a telegram, shorter than what a step of the scan may wait.
    pub silence_ms: u32,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            signals: vec![75, 76, 65, 256, 257],
            sample_rate_hz: 1000.0,
            averaging: 1,
            trigger: Trigger::Each,
            scale_um: None,
            intensity_min: 0.0,
            sync: SYNC,
            ready_timeout_ms: 1000,
            silence_ms: 50,
        }
    }
}

/// How often a command is sent before it counts as unanswered or refused.
pub(crate) const ATTEMPTS: u8 = 2;

/// Samples a free-running device may leave out before the link counts as dead.
const FREE_RUN_GAP: f64 = 20.0;

impl Settings {
    /// Everything that is wrong with them; empty when a driver can be made.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        check_signals(&mut problems, &self.signals, self.intensity_min);
        let exposures = (self.sample_rate_hz, self.averaging);
        check_exposures(&mut problems, exposures, self.scale_um, self.intensity_min);
        check_range(&mut problems, "ready_timeout_ms", self.ready_timeout_ms, 10, 60_000);
        check_range(&mut problems, "silence_ms", self.silence_ms, 1, 10_000);
        if self.sync.contains(&b'$') {
            let found = format!("{:02X} {:02X}", self.sync[0], self.sync[1]);
            problems.push(Problem::new("sync", "bytes other than 24, which starts an echo", found));
        }
        problems
    }

    /// The channels of the readings, in the order of the signals that become channels. Unknown
    /// identifiers are left out.
    pub fn channels(&self) -> Vec<Channel> {
        channels(&self.signals)
    }

    pub(crate) fn longest_gap(&self) -> Duration {
        longest_gap(self.sample_rate_hz, self.averaging, self.ready_timeout_ms)
    }
}

/// Channels of these signals, in their order; of those that become channels.
pub(crate) fn channels(signals: &[u16]) -> Vec<Channel> {
    signals
        .iter()
        .filter_map(|&id| Signal::from_id(id).ok())
        .filter_map(|signal| signal.channel())
        .collect()
}

/// Longest silence of a free-running device that sends samples of so many exposures.
pub(crate) fn longest_gap(sample_rate_hz: f64, averaging: u16, answer_ms: u32) -> Duration {
    let sample_s = f64::from(averaging) / sample_rate_hz;
    millis(answer_ms).max(Duration::from_secs_f64(FREE_RUN_GAP * sample_s))
}

/// Adds problems of rate and averaging, full scale and least intensity, in either protocol.
pub(crate) fn check_exposures(
    problems: &mut Vec<Problem>,
    (sample_rate_hz, averaging): (f64, u16),
    scale_um: Option<f64>,
    intensity_min: f64,
) {
    check_range(problems, "sample_rate_hz", sample_rate_hz, 1.0, 100_000.0);
    check_range(problems, "averaging", averaging, 1, 10_000);
    if let Some(scale_um) = scale_um {
        check_range(problems, "scale_um", scale_um, 1.0, 1e6);
    }
    check_range(problems, "intensity_min", intensity_min, 0.0, 1e9);
}

/// Adds what is wrong with the signals of either protocol, and with the least intensity.
pub(crate) fn check_signals(problems: &mut Vec<Problem>, signals: &[u16], intensity_min: f64) {
    let count = signals.len();
    if !(1..=MAX_SIGNALS).contains(&count) {
        let expected = format!("1 to {MAX_SIGNALS} identifiers");
        problems.push(Problem::new("signals", expected, count));
    }
    let mut quantities = Vec::new();
    for (index, &id) in signals.iter().enumerate() {
        let key = format!("signals[{index}]");
        match Signal::from_id(id) {
            Err(error) => problems.push(Problem::new(key, "a supported signal", error)),
            Ok(signal) if quantities.contains(&signal.quantity) => {
                problems.push(Problem::new(key, "each quantity once", id));
            }
            Ok(signal) => quantities.push(signal.quantity),
        }
    }
    let channels = channels(signals).len();
    if !(1..=MAX_CHANNELS).contains(&channels) {
        let expected = format!("1 to {MAX_CHANNELS} signals that become channels");
        problems.push(Problem::new("signals", expected, channels));
    }
    let has_intensity = quantities
        .iter()
        .any(|quantity| matches!(quantity, Quantity::Peak { part: Part::Intensity, .. }));
    if intensity_min > 0.0 && !has_intensity {
        let expected = "0, or an intensity such as 257 among the signals";
        problems.push(Problem::new("intensity_min", expected, intensity_min));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_usable() {
        assert_eq!(Settings::default().problems(), []);
        let names: Vec<String> =
            Settings::default().channels().into_iter().map(|channel| channel.name).collect();
        assert_eq!(names, ["encoder_x", "distance1", "intensity1"]);
    }

    #[test]
    fn each_problem_names_its_key() {
        let keys = |settings: Settings| -> Vec<String> {
            settings.problems().into_iter().map(|problem| problem.key).collect()
        };
        let defaults = Settings::default;
        assert_eq!(keys(Settings { signals: vec![], ..defaults() }), ["signals", "signals"]);
        assert_eq!(keys(Settings { signals: vec![75, 76], ..defaults() }), ["signals"]);
        assert_eq!(keys(Settings { signals: vec![256, 79], ..defaults() }), ["signals[1]"]);
        assert_eq!(keys(Settings { signals: vec![256, 16640], ..defaults() }), ["signals[1]"]);
        assert_eq!(keys(Settings { sample_rate_hz: f64::NAN, ..defaults() }), ["sample_rate_hz"]);
        assert_eq!(keys(Settings { averaging: 0, ..defaults() }), ["averaging"]);
        assert_eq!(keys(Settings { scale_um: Some(0.0), ..defaults() }), ["scale_um"]);
        assert_eq!(keys(Settings { sync: *b"$$", ..defaults() }), ["sync"]);
        assert_eq!(keys(Settings { silence_ms: 0, ..defaults() }), ["silence_ms"]);
        let weak = Settings { signals: vec![75, 256], intensity_min: 5.0, ..defaults() };
        assert_eq!(keys(weak), ["intensity_min"]);
        let many: Vec<u16> = (0..17).map(|peak| 256 + 8 * peak).collect();
        assert_eq!(keys(Settings { signals: many, ..defaults() }), ["signals"]);
    }
}
