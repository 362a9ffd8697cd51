//! The answers of one poll as a reading.

use asphera_link::{Channel, Count, Flags, Nanos, Reading, Values};

use crate::map::{Block, Field, Map, Role};
use crate::wire;

/// What the blocks of one poll held, in the order of the requests; `None` where the device refused.
pub(crate) type Image = Vec<Option<Vec<u16>>>;

/// Knows where in an [`Image`] each field stands.
#[derive(Debug)]
pub(crate) struct Assembler {
    slots: Vec<Slot>,
    channels: Vec<Channel>,
}

#[derive(Debug)]
struct Slot {
    field: Field,
    block: usize,
    offset: usize,
}

impl Assembler {
    /// `requests` must hold every field of the map.
    pub(crate) fn new(map: &Map, requests: &[Block]) -> Assembler {
        let place = |field: &Field| {
            let wanted = field.block();
            let block = requests.iter().position(|block| block.contains(&wanted))?;
            let offset = usize::from(field.address - requests[block].address);
            Some(Slot { field: field.clone(), block, offset })
        };
        let slots: Vec<Slot> = map.fields.iter().filter_map(place).collect();
        debug_assert_eq!(slots.len(), map.fields.len());
        Assembler { slots, channels: map.channels() }
    }

    pub(crate) fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The reading, or `None` when the device refused every block with a channel.
    pub(crate) fn reading(&self, host: Nanos, image: &Image) -> Option<Reading> {
        let of_role = |role: Role| self.slots.iter().filter(move |slot| slot.field.role == role);
        if of_role(Role::Channel).all(|slot| slot.words(image).is_none()) {
            return None;
        }
        let mut flags = Flags::empty();
        if image.iter().any(Option::is_none) {
            flags |= Flags::DEVICE_ERROR;
        }
        if self.alarm(image).is_some() {
            flags |= Flags::DEVICE_ERROR;
        }
        let (judged, quality) = self.quality(image);
        flags |= quality;
        let mut values = Values::new();
        for slot in of_role(Role::Channel) {
            let value = slot.value(image, &mut flags);
            let is_judged = judged.contains(&slot.field.name.as_str());
            values.push(value.filter(|_| !is_judged));
        }
        let count = self.count(image, &mut flags);
        let device_time_ns = self.device_time_ns(image, &mut flags);
        Some(Reading { host, device_time_ns, count, values, flags })
    }

    /// The name of the first alarm that is set.
    pub(crate) fn alarm(&self, image: &Image) -> Option<&str> {
        let alarms = self.slots.iter().filter(|slot| slot.field.role == Role::Alarm);
        let is_set = |slot: &&Slot| slot.raw(image).is_some_and(|raw| raw != 0.0);
        alarms.into_iter().find(is_set).map(|slot| slot.field.name.as_str())
    }

    /// The channels that are missing because the device judges them bad, and the flags of all
    /// judgements.
    fn quality(&self, image: &Image) -> (Vec<&str>, Flags) {
        let (mut judged, mut flags) = (Vec::new(), Flags::empty());
        for slot in &self.slots {
            let Role::Quality { good, weak, bad, judges } = &slot.field.role else { continue };
            let Some(raw) = slot.whole(image) else { continue };
            if bad.contains(&raw) {
                flags |= Flags::NO_SIGNAL;
                if judges.is_empty() {
                    judged.extend(self.channels.iter().map(|channel| channel.name.as_str()));
                } else {
                    judged.extend(judges.iter().map(String::as_str));
                }
            } else if weak.contains(&raw) {
                flags |= Flags::WEAK;
            } else if !good.contains(&raw) {
                flags |= Flags::SUSPECT;
            }
        }
        (judged, flags)
    }

    fn count(&self, image: &Image, flags: &mut Flags) -> Option<Count> {
        self.slots.iter().find_map(|slot| {
            let Role::Count { first, modulus } = slot.field.role else { return None };
            let raw = slot.whole(image)?;
            if raw.checked_sub(first).is_some_and(|above| above < modulus) {
                Some(Count { raw, first, modulus })
            } else {
                *flags |= Flags::SUSPECT;
                None
            }
        })
    }

    /// Device time in ns. Microseconds of a second and more beside whole seconds cannot be: the two
    /// were not read at one instant, or are not what the map says.
    fn device_time_ns(&self, image: &Image, flags: &mut Flags) -> Option<u64> {
        let slot = |role: &Role| self.slots.iter().find(|slot| slot.field.role == *role);
        let time = |slot: &Slot| slot.whole(image).map(u64::from);
        match (slot(&Role::DeviceTimeSeconds), slot(&Role::DeviceTimeMicros)) {
            (None, None) => None,
            (Some(seconds), None) => Some(time(seconds)? * 1_000_000_000),
            (None, Some(micros)) => Some(time(micros)? * 1000),
            (Some(seconds), Some(micros)) => {
                let (seconds, micros) = (time(seconds)?, time(micros)?);
                if micros < 1_000_000 {
                    Some(seconds * 1_000_000_000 + micros * 1000)
                } else {
                    *flags |= Flags::SUSPECT;
                    None
                }
            }
        }
    }
}

impl Slot {
    fn words<'a>(&self, image: &'a Image) -> Option<&'a [u16]> {
        let words = image.get(self.block)?.as_ref()?;
        words.get(self.offset..self.offset + usize::from(self.field.kind.words()))
    }

    fn raw(&self, image: &Image) -> Option<f64> {
        self.words(image).map(|words| wire::decode(self.field.kind, self.field.word_order, words))
    }

    /// The raw value of an unsigned kind, which is exact in an `f64`.
    fn whole(&self, image: &Image) -> Option<u32> {
        self.raw(image).map(|raw| raw as u32)
    }

    /// The value, if it is a measurement; else the flag says why not.
    fn value(&self, image: &Image, flags: &mut Flags) -> Option<f64> {
        let value = wire::decode_field(&self.field, self.words(image)?);
        if !value.is_finite() {
            *flags |= Flags::NOT_FINITE;
            return None;
        }
        match self.field.valid_range {
            Some((low, high)) if !(low..=high).contains(&value) => {
                *flags |= Flags::OUT_OF_RANGE;
                None
            }
            _ => Some(value),
        }
    }
}

#[cfg(test)]
mod tests {
    use asphera_link::Unit;

    use super::*;
    use crate::map::{Function, Kind, WordOrder};

    /// Input registers 200 to 212 of an OM20: quality, outputs, distance 69.743 mm, rate 500 Hz,
    /// exposure reserve 87, response delay 2000 µs, 12 s, 345 678 µs.
    const OM20: [u16; 13] = [0, 1, 0x7C37, 0x428B, 0, 0x43FA, 87, 2000, 0, 12, 0, 0x464E, 5];

    fn om20(change: impl FnOnce(&mut [u16; 13])) -> Reading {
        let map = Map::built_in("baumer-om20").unwrap();
        let assembler = Assembler::new(&map, &map.blocks);
        let mut words = OM20;
        change(&mut words);
        assembler.reading(Nanos::from_millis(7), &vec![Some(words.to_vec())]).unwrap()
    }

    #[test]
    fn om20_is_read_as_its_manual_says() {
        let reading = om20(|_| {});
        assert!((reading.values.get(0).unwrap() - 69.742_607).abs() < 1e-6);
        let rest: Vec<_> = reading.values.iter().skip(1).collect();
        assert_eq!(rest, [Some(500.0), Some(87.0), Some(2000.0 * 1e-6), Some(1.0)]);
        assert_eq!(reading.device_time_ns, Some(12_345_678_000));
        assert_eq!((reading.flags, reading.count), (Flags::empty(), None));
        assert_eq!(reading.host, Nanos::from_millis(7));
    }

    #[test]
    fn the_devices_judgement_becomes_flags() {
        assert_eq!(om20(|words| words[0] = 1).flags, Flags::WEAK);
        let bad = om20(|words| words[0] = 2);
        assert_eq!((bad.flags, bad.values.get(0)), (Flags::NO_SIGNAL, None));
        assert_eq!(bad.values.get(1), Some(500.0), "only the distance is judged");
        assert_eq!(om20(|words| words[0] = 3).flags, Flags::SUSPECT);
        assert_eq!(om20(|words| words[1] = 2).flags, Flags::DEVICE_ERROR);
    }

    #[test]
    fn what_is_no_number_is_missing() {
        let reading = om20(|words| words[2..4].copy_from_slice(&[0, 0x7FC0]));
        assert_eq!((reading.flags, reading.values.get(0)), (Flags::NOT_FINITE, None));
        let torn = om20(|words| words[11..13].copy_from_slice(&[0x4240, 0x000F]));
        assert_eq!((torn.flags, torn.device_time_ns), (Flags::SUSPECT, None));
    }

    #[test]
    fn ranges_counts_and_refused_blocks() {
        let input = Function::ReadInput;
        let a = Field {
            valid_range: Some((-1.0, 1.0)),
            scale: 0.5,
            offset: -1.0,
            word_order: WordOrder::Badc,
            ..Field::channel("a", input, 0, Kind::U16, Unit::Millimetre)
        };
        let b = Field::channel("b", input, 9, Kind::I16, Unit::Millimetre);
        let n = Field {
            role: Role::Count { first: 1, modulus: 240 },
            ..Field::channel("n", input, 1, Kind::U16, Unit::Count)
        };
        let map = Map { name: String::new(), fields: vec![a, b, n], blocks: Vec::new() };
        let requests = crate::plan::requests(&map, 0, 125);
        let assembler = Assembler::new(&map, &requests);
        let read = |image: Image| assembler.reading(Nanos::ZERO, &image);

        let good = read(vec![Some(vec![0x0400, 240]), Some(vec![0xFFFF])]).unwrap();
        assert_eq!(good.values.iter().collect::<Vec<_>>(), [Some(1.0), Some(-1.0)]);
        assert_eq!(good.count, Some(Count { raw: 240, first: 1, modulus: 240 }));
        let far = read(vec![Some(vec![0x0500, 0]), Some(vec![0])]).unwrap();
        assert_eq!((far.values.get(0), far.count), (None, None));
        assert_eq!(far.flags, Flags::OUT_OF_RANGE | Flags::SUSPECT);
        let half = read(vec![None, Some(vec![3])]).unwrap();
        assert_eq!(half.values.iter().collect::<Vec<_>>(), [None, Some(3.0)]);
        assert_eq!(half.flags, Flags::DEVICE_ERROR);
        assert_eq!(read(vec![None, None]), None);
    }
}
