//! The simulated device, shared by its connections and by whoever tells it to misbehave.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use asphera_link::Nanos;
use asphera_modbus::{Block, Function, Map};

use crate::fault::Fault;
use crate::image::Image;
use crate::pdu;

/// A handle to a simulated device; clones are the same device.
#[derive(Clone)]
pub struct Device(Arc<Mutex<State>>);

struct State {
    unit_id: u8,
    image: Image,
    motion: Option<Motion>,
    faults: VecDeque<Fault>,
    delay: Duration,
    silence: Silence,
    requests: u64,
}

type Motion = Box<dyn FnMut(Nanos, &mut Image) + Send>;

enum Silence {
    None,
    FromNextRequest(Duration),
    Until(Nanos),
}

/// What a session must send for a request.
pub(crate) struct Reply {
    pub(crate) unit_id: u8,
    pub(crate) pdu: Vec<u8>,
    pub(crate) delay: Duration,
    pub(crate) fault: Option<Fault>,
}

impl Device {
    /// A device of the map with all registers zero, answering at once.
    pub fn new(unit_id: u8, map: Map) -> Device {
        Device(Arc::new(Mutex::new(State {
            unit_id,
            image: Image::new(map),
            motion: None,
            faults: VecDeque::new(),
            delay: Duration::ZERO,
            silence: Silence::None,
            requests: 0,
        })))
    }

    /// A Baumer OM20 at good signal, 500 Hz, that shows a distance in mm and its clock as functions
    /// of the time of the request. As the operating manual says, the measurement is read whole,
    /// or the distance alone.
    pub fn om20(unit_id: u8, mut distance_mm: impl FnMut(Nanos) -> f64 + Send + 'static) -> Device {
        let map = Map::built_in("baumer-om20").expect("the driver has a map of the OM20");
        let device = Device::new(unit_id, map);
        let distance = Block { function: Function::ReadInput, address: 202, len: 2 };
        device.change(|image| image.allow_part(distance));
        device.animate(move |now, image| {
            let micros = now.as_nanos() / 1000;
            let fields = [
                ("distance", distance_mm(now)),
                ("rate", 500.0),
                ("exposure_reserve", 87.0),
                ("response_delay", 0.002),
                ("time_s", (micros / 1_000_000 % (1 << 32)) as f64),
                ("time_us", (micros % 1_000_000) as f64 * 1e-6),
            ];
            for (name, value) in fields {
                image.set(name, value).expect("the OM20 has the field and the value fits");
            }
        });
        device
    }

    /// Lets this change the registers before each request is answered; replaces what did so before.
    pub fn animate(&self, motion: impl FnMut(Nanos, &mut Image) + Send + 'static) {
        self.lock().motion = Some(Box::new(motion));
    }

    /// Changes the registers now.
    pub fn change<T>(&self, change: impl FnOnce(&mut Image) -> T) -> T {
        change(&mut self.lock().image)
    }

    /// Lets the next request that is not yet spoken for meet this fault. Each fault is met once.
    pub fn fail_next(&self, fault: Fault) {
        self.lock().faults.push_back(fault);
    }

    /// Answers each request so much later from now on.
    pub fn set_delay(&self, delay: Duration) {
        self.lock().delay = delay;
    }

    /// Answers nothing for this time, which begins with the next request.
    pub fn fall_silent(&self, time: Duration) {
        self.lock().silence = Silence::FromNextRequest(time);
    }

    /// How many requests were addressed to it.
    pub fn requests(&self) -> u64 {
        self.lock().requests
    }

    /// What to do about a request, or `None` when it is not for this device or it is silent.
    pub(crate) fn reply(&self, now: Nanos, unit_id: u8, request: &[u8]) -> Option<Reply> {
        let state = &mut *self.lock();
        if unit_id != state.unit_id {
            return None;
        }
        state.requests += 1;
        if let Silence::FromNextRequest(time) = state.silence {
            state.silence = Silence::Until(now + time);
        }
        if let Silence::Until(end) = state.silence {
            if now < end {
                return None;
            }
            state.silence = Silence::None;
        }
        if let Some(motion) = &mut state.motion {
            motion(now, &mut state.image);
        }
        let pdu = pdu::answer(&state.image, request);
        let fault = state.faults.pop_front();
        Some(Reply { unit_id, pdu, delay: state.delay, fault })
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // A motion that panicked leaves registers, each whole: the device goes on.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
