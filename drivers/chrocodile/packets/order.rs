//! Commands that the driver sends, and their answers.

use crate::packets::PacketSettings;
use crate::settings::Trigger;
use crate::wire::packet::{Argument, Message, Name};
use crate::words::{is_full_scale, shortened};

/// A command of the driver.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Order {
    /// `STO`: no data on this connection.
    Stop,
    /// `STA`: data on this connection.
    Start,
    /// `SHZ`: exposures per second in Hz.
    SampleRate(f64),
    /// `AVD`: exposures averaged into one sample.
    Averaging(u16),
    /// `CTN`: exposures by the device's clock.
    FreeRun,
    /// `TRE`: one exposure for each trigger.
    TriggerEach,
    /// `SCA`: the full scale in µm is asked for.
    AskFullScale,
    /// `SODX`: the signals of a sample. The format follows the answer.
    Output(Vec<u16>),
}

impl Order {
    /// The set-up, in order. The signals come last, so that their format is that of all that was set.
    pub(super) fn setup(settings: &PacketSettings) -> Vec<Order> {
        let mut orders = vec![
            Order::Stop,
            Order::SampleRate(settings.sample_rate_hz),
            Order::Averaging(settings.averaging),
            match settings.trigger {
                Trigger::Free => Order::FreeRun,
                Trigger::Each => Order::TriggerEach,
            },
        ];
        if settings.scale_um.is_none() {
            orders.push(Order::AskFullScale);
        }
        orders.push(Order::Output(settings.signals.clone()));
        orders
    }

    /// The name of the command.
    pub(super) fn name(&self) -> Name {
        match self {
            Order::Stop => Name::new("STO"),
            Order::Start => Name::new("STA"),
            Order::SampleRate(_) => Name::new("SHZ"),
            Order::Averaging(_) => Name::new("AVD"),
            Order::FreeRun => Name::new("CTN"),
            Order::TriggerEach => Name::new("TRE"),
            Order::AskFullScale => FULL_SCALE,
            Order::Output(_) => Name::new("SODX"),
        }
    }

    /// The packet to send.
    pub(super) fn encode(&self, ticket: u16) -> Vec<u8> {
        let name = self.name();
        let message = match self {
            Order::AskFullScale => Message::query(name, ticket),
            Order::SampleRate(rate_hz) => {
                Message::command(name, ticket, vec![Argument::Float(*rate_hz as f32)])
            }
            Order::Averaging(exposures) => {
                Message::command(name, ticket, vec![Argument::Int(i32::from(*exposures))])
            }
            Order::Output(signals) => {
                let argument = |&id: &u16| Argument::Int(i32::from(id));
                Message::command(name, ticket, signals.iter().map(argument).collect())
            }
            Order::Stop | Order::Start | Order::FreeRun | Order::TriggerEach => {
                Message::command(name, ticket, Vec::new())
            }
        };
        let mut bytes = Vec::new();
        message.encode(&mut bytes);
        bytes
    }
}

/// Name of the command whose answer is the full scale.
pub(super) const FULL_SCALE: Name = Name::new("SCA");

/// The full scale in µm of a message of `SCA`.
pub(super) fn full_scale_um(message: &Message) -> Option<f64> {
    message.arguments.first()?.number().filter(is_full_scale)
}

/// The arguments of a message in words.
pub(super) fn words(message: &Message) -> String {
    if message.arguments.is_empty() {
        return "nothing".into();
    }
    let arguments: Vec<String> = message.arguments.iter().map(ToString::to_string).collect();
    shortened(&arguments.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::MESSAGE_LEN;

    #[test]
    fn the_full_scale_is_a_positive_number() {
        let message = |argument| Message::command(FULL_SCALE, 1, vec![argument]);
        assert_eq!(full_scale_um(&message(Argument::Int(3320))), Some(3320.0));
        assert_eq!(full_scale_um(&message(Argument::Float(0.5))), Some(0.5));
        for wrong in [Argument::Int(0), Argument::Float(f32::NAN), Argument::Text(b"1".to_vec())] {
            assert_eq!(full_scale_um(&message(wrong)), None);
        }
        assert_eq!(full_scale_um(&Message::command(FULL_SCALE, 1, Vec::new())), None);
    }

    #[test]
    fn words_of_a_device_are_short_and_without_control_signs() {
        let text = Argument::Text(b"\x1B[2J".repeat(100));
        let said = words(&Message::command(FULL_SCALE, 1, vec![Argument::Int(3), text]));
        assert!(said.starts_with("3 \"\\u{1b}[2J") && said.chars().count() == MESSAGE_LEN + 1);
        assert!(!said.contains(char::is_control), "{said}");
    }
}
