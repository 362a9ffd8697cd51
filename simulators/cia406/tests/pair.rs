//! The driver against simulated nodes, in virtual time.

use std::f64::consts::TAU;
use std::time::Duration;

use asphera_cia406::wire::object;
use asphera_cia406::{Cia406, Kind, PositionObject, Settings, Transmission};
use asphera_link::{
    CanFrame, CanId, Command, Driver, Event, FaultKind, Flags, Input, Nanos, Output, Reading,
};
use asphera_sim_cia406::{Bus, NodeConfig};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// Drivers and nodes on one wire. `lost` says of each frame of the bus whether it gets lost.
struct Pair {
    bus: Bus,
    drivers: Vec<Cia406>,
    events: Vec<Vec<Event>>,
    now: Nanos,
    lost: Box<dyn FnMut(&CanFrame) -> bool>,
    /// Whether the nodes have power.
    powered: bool,
}

const OVERFLOW: u8 = 10;
const PERIOD: Duration = Duration::from_millis(10);

fn settings(node_id: u8) -> Settings {
    Settings {
        node_id,
        sync_counter_overflow: Some(OVERFLOW),
        sync_window_us: Some(5_000),
        ..Settings::default()
    }
}

fn node(node_id: u8) -> NodeConfig {
    NodeConfig { node_id, ..NodeConfig::default() }
}

impl Pair {
    fn new(nodes: Vec<NodeConfig>, settings: Vec<Settings>) -> Pair {
        let drivers: Vec<_> =
            settings.into_iter().map(|each| Cia406::new(each).expect("good settings")).collect();
        Pair {
            bus: Bus::new(nodes).expect("different nodes"),
            events: drivers.iter().map(|_| Vec::new()).collect(),
            drivers,
            now: Nanos::from_millis(1000),
            lost: Box::new(|_| false),
            powered: true,
        }
    }

    /// One node, started.
    fn started(node: NodeConfig, settings: Settings) -> Pair {
        let mut pair = Pair::new(vec![node], vec![settings]);
        pair.start();
        pair
    }

    fn start(&mut self) {
        let now = self.now;
        for driver in &mut self.drivers {
            driver.command(now, Command::Start);
            driver.connected(now);
        }
        self.settle(Vec::new());
        self.advance(Duration::from_millis(600));
    }

    /// Carries frames until nobody has anything more to say.
    fn settle(&mut self, mut from_bus: Vec<CanFrame>) {
        loop {
            for frame in std::mem::take(&mut from_bus) {
                if (self.lost)(&frame) {
                    continue;
                }
                for driver in &mut self.drivers {
                    driver.receive(self.now, Input::Frame(&frame));
                }
            }
            for (driver, events) in self.drivers.iter_mut().zip(&mut self.events) {
                while let Some(Output::Frame(frame)) = driver.poll_transmit() {
                    if self.powered {
                        from_bus.extend(self.bus.receive(self.now, &frame));
                    }
                }
                events.extend(std::iter::from_fn(|| driver.poll_event()));
            }
            if from_bus.is_empty() {
                return;
            }
        }
    }

    fn advance(&mut self, duration: Duration) {
        let end = self.now + duration;
        loop {
            let bus = if self.powered { self.bus.poll_timeout() } else { None };
            let due = self.drivers.iter().filter_map(Driver::poll_timeout).chain(bus).min();
            let Some(due) = due.filter(|&due| due <= end) else { break };
            self.now = self.now.max(due);
            let frames = if self.powered { self.bus.timeout(self.now) } else { Vec::new() };
            for driver in &mut self.drivers {
                if driver.poll_timeout().is_some_and(|at| at <= self.now) {
                    driver.timeout(self.now);
                }
            }
            self.settle(frames);
        }
        self.now = end;
    }

    /// One SYNC and what follows it.
    fn sync(&mut self, counter: u8, positions: &[i32]) {
        let frames = self.bus.sync(Some(counter), positions);
        self.settle(frames);
        self.advance(PERIOD);
    }

    fn readings(&self, driver: usize) -> Vec<Reading> {
        let reading = |event: &Event| match event {
            Event::Reading(reading) => Some(reading.clone()),
            _ => None,
        };
        self.events[driver].iter().filter_map(reading).collect()
    }

    /// Faults since the last time.
    fn faults(&mut self, driver: usize) -> Vec<(FaultKind, String)> {
        let mut faults = Vec::new();
        self.events[driver].retain(|event| match event {
            Event::Fault(fault) => {
                faults.push((fault.kind, fault.detail.clone()));
                false
            }
            _ => true,
        });
        faults
    }

    fn count(&self, driver: usize, event: &Event) -> usize {
        self.events[driver].iter().filter(|each| *each == event).count()
    }
}

fn counter(cycle: usize) -> u8 {
    1 + (cycle % usize::from(OVERFLOW)) as u8
}

#[test]
fn every_sync_gives_the_exact_position_with_its_count() {
    let mut pair = Pair::started(node(5), settings(5));
    assert_eq!(pair.events[0], [Event::Online, Event::Ready]);
    let positions = [123_456, -7, 0, i32::MAX, i32::MIN, 1];
    for cycle in 0..30 {
        pair.sync(counter(cycle), &[positions[cycle % positions.len()]]);
    }
    let readings = pair.readings(0);
    assert_eq!(readings.len(), 30);
    for (cycle, reading) in readings.iter().enumerate() {
        // Steps of 1 µm.
        let mm = f64::from(positions[cycle % positions.len()]) / 1000.0;
        assert_eq!(reading.values.iter().collect::<Vec<_>>(), [Some(mm)]);
        let count = reading.count.unwrap();
        assert_eq!((count.raw, count.first, count.modulus), (counter(cycle).into(), 1, 10));
        assert_eq!(reading.flags, Flags::empty());
        assert_eq!(reading.host, Nanos::from_millis(1600) + cycle as u32 * PERIOD);
    }
    assert_eq!(pair.faults(0), []);
}

#[test]
fn two_nodes_share_a_bus_and_its_syncs() {
    let rotary = NodeConfig { position: object::POSITION, device_type: 0x0002_0196, ..node(6) };
    let turning = Settings {
        position: PositionObject::SingleUnsigned,
        kind: Kind::Rotary { counts_per_turn: 8192 },
        ..settings(6)
    };
    let mut pair = Pair::new(vec![node(5), rotary], vec![settings(5), turning]);
    pair.start();
    assert!(pair.bus.armed());
    for cycle in 0..20 {
        pair.sync(counter(cycle), &[cycle as i32, 2048 * cycle as i32]);
    }
    // Node 6 loses power; node 5 must not notice.
    pair.lost = Box::new(|frame| matches!(frame.id(), CanId::Standard(id) if id & 0x7F == 6));
    for cycle in 20..320 {
        pair.sync(counter(cycle), &[cycle as i32, 0]);
    }
    let linear = pair.readings(0);
    assert_eq!(linear.len(), 320);
    for (cycle, reading) in linear.iter().enumerate() {
        assert_eq!(reading.values.get(0), Some(cycle as f64 / 1000.0));
        assert_eq!(reading.count.unwrap().raw, u32::from(counter(cycle)));
    }
    assert_eq!(pair.faults(0), []);
    let angles = pair.readings(1);
    assert_eq!(angles.len(), 20);
    assert_eq!(angles[7].values.get(0), Some(1.75 * TAU));
    let faults = pair.faults(1);
    assert!(faults.iter().any(|(kind, detail)| *kind == FaultKind::Timeout
        && detail.starts_with("no heartbeat of node 6 within 1000 ms: check")));
}

#[test]
fn a_lost_position_is_a_gap_in_the_counts_and_a_fault() {
    let mut pair = Pair::started(node(5), settings(5));
    for cycle in 0..10 {
        if cycle == 3 || cycle == 4 {
            pair.bus.drop_next_tpdo(0);
        }
        pair.sync(counter(cycle), &[cycle as i32]);
    }
    let counts: Vec<_> = pair.readings(0).iter().map(|each| each.count.unwrap().raw).collect();
    assert_eq!(counts, [1, 2, 3, 6, 7, 8, 9, 10]);
    let flagged: Vec<_> = pair.readings(0).iter().map(|each| each.flags).collect();
    assert_eq!(flagged[3], Flags::TRIGGER_LOST);
    assert!(flagged[4..].iter().all(Flags::is_empty));
    let faults: Vec<_> = pair.faults(0).into_iter().map(|(_, detail)| detail).collect();
    let cure = "check the load of the bus";
    let expected = [
        format!("node 5 sent no position for SYNC 4: {cure}"),
        format!("node 5: 2 positions missing in a row: {cure}"),
    ];
    assert_eq!(faults, expected);
}

#[test]
fn an_emergency_marks_readings_until_all_is_clear() {
    let mut pair = Pair::started(node(5), settings(5));
    let mut flags = Vec::new();
    for (cycle, said) in
        [None, Some((0x5000, 0x01)), Some((0, 0x01)), Some((0, 0))].into_iter().enumerate()
    {
        if let Some((code, register)) = said {
            let frame = pair.bus.emergency(0, code, register);
            pair.settle(vec![frame]);
        }
        pair.sync(counter(cycle), &[0]);
        flags.push(pair.readings(0)[cycle].flags);
    }
    let error = Flags::DEVICE_ERROR;
    assert_eq!(flags, [Flags::empty(), error, error, Flags::empty()]);
    let faults = pair.faults(0);
    assert_eq!(faults.len(), 2);
    assert_eq!(
        faults[0],
        (
            FaultKind::Device,
            "node 5: emergency 5000h (device hardware), error register 01h, 00 00 00 00 00; see its manual"
                .to_owned()
        )
    );
}

#[test]
fn an_error_from_before_the_connection_is_known() {
    let mut pair = Pair::new(vec![node(5)], vec![settings(5)]);
    pair.bus.emergency(0, 0x5000, 0x21);
    pair.start();
    pair.sync(1, &[0]);
    assert_eq!(pair.readings(0)[0].flags, Flags::DEVICE_ERROR);
    let expected = "node 5 has error register 21h: see its manual".to_owned();
    assert_eq!(pair.faults(0), [(FaultKind::Device, expected)]);
}

#[test]
fn a_node_that_restarts_is_set_up_anew() {
    let mut pair = Pair::started(node(5), settings(5));
    pair.sync(1, &[1]);
    let boot = pair.bus.reboot(0);
    pair.settle(vec![boot]);
    pair.advance(Duration::from_millis(600));
    pair.sync(2, &[2]);
    let expected = "node 5 restarted, and is set up anew: check its power".to_owned();
    assert_eq!(pair.faults(0), [(FaultKind::Device, expected)]);
    assert_eq!((pair.count(0, &Event::Online), pair.count(0, &Event::Ready)), (1, 2));
    assert_eq!(pair.readings(0).len(), 2);
}

#[test]
fn a_node_without_power_is_told_and_found_when_it_starts() {
    let mut pair = Pair::new(vec![node(5)], vec![settings(5)]);
    pair.powered = false;
    pair.start();
    pair.advance(Duration::from_secs(20));
    let faults = pair.faults(0);
    assert!(pair.events[0].is_empty(), "nothing proves that the node is there");
    let (kind, detail) = &faults[0];
    assert_eq!(*kind, FaultKind::Timeout);
    assert!(detail.starts_with("node 5 did not answer for 1000.00h within 3 times 200 ms: check"));
    // At 0.6 s, then after pauses of 1, 2, 4 and 8 s.
    assert_eq!(faults.len(), 5);
    pair.powered = true;
    let boot = pair.bus.reboot(0);
    pair.settle(vec![boot]);
    pair.advance(Duration::from_millis(600));
    assert_eq!(pair.events[0], [Event::Online, Event::Ready]);
}

#[test]
fn a_node_that_leaves_operational_is_brought_back() {
    let mut pair = Pair::started(node(5), settings(5));
    // Another master stops all nodes.
    let stop = CanFrame::data_frame(CanId::Standard(0), &[2, 0]).unwrap();
    let said = pair.bus.receive(pair.now, &stop);
    pair.settle(said);
    assert!(!pair.bus.armed());
    pair.advance(Duration::from_secs(2));
    assert!(pair.bus.armed());
    let expected =
        "node 5 is stopped, though it was started: check that no other master controls it"
            .to_owned();
    assert_eq!(pair.faults(0), [(FaultKind::Device, expected)]);
}

#[test]
fn a_heartbeat_from_before_the_start_is_no_fault_but_a_second_one_is() {
    let mut pair = Pair::new(vec![node(5)], vec![settings(5)]);
    let now = pair.now;
    pair.drivers[0].command(now, Command::Start);
    pair.drivers[0].connected(now);
    pair.settle(Vec::new());
    assert_eq!(pair.count(0, &Event::Ready), 1);
    // It waited on the bus while the answer to the start, of a higher priority, was sent.
    let late = CanFrame::data_frame(CanId::Standard(0x705), &[0x7F]).unwrap();
    pair.settle(vec![late]);
    pair.advance(Duration::from_secs(2));
    assert_eq!(pair.faults(0), []);
    pair.settle(vec![late]);
    let expected =
        "node 5 is pre-operational, though it was started: check that no other master controls it"
            .to_owned();
    assert_eq!(pair.faults(0), [(FaultKind::Device, expected)]);
    // And without one in between: not started at all.
    pair.advance(Duration::from_millis(1));
    pair.settle(vec![late]);
    assert_eq!(pair.faults(0), []);
    pair.settle(vec![late]);
    assert_eq!(pair.faults(0).len(), 1);
}

#[test]
fn another_profile_or_vendor_is_refused_by_name() {
    let drive = NodeConfig { device_type: 0x0002_0192, ..node(5) };
    let mut pair = Pair::started(drive, settings(5));
    assert!(pair.events[0].iter().all(|event| matches!(event, Event::Fault(_))));
    let expected = "node 5 follows profile 402 (device type 00020192h), expected 406: set node_id, or connect an encoder"
        .to_owned();
    assert_eq!(pair.faults(0)[0], (FaultKind::Refused, expected));

    let vendor = Settings { vendor_id: Some(0x2D), ..settings(5) };
    let mut pair = Pair::started(node(5), vendor);
    assert_eq!(pair.count(0, &Event::Online), 0);
    let expected =
        "node 5 has vendor 40h, expected 2Dh: set vendor_id, or connect the right node".to_owned();
    assert_eq!(pair.faults(0)[0], (FaultKind::Refused, expected));
}

#[test]
fn a_fixed_mapping_is_used_where_it_is_right_and_refused_where_it_is_not() {
    let fixed = NodeConfig { fixed_mapping: true, ..node(5) };
    let full = Settings { map_velocity: true, map_status: true, ..settings(5) };
    let pair = Pair::started(fixed.clone(), full);
    assert_eq!(pair.events[0], [Event::Online, Event::Ready]);

    let mut pair = Pair::started(fixed, settings(5));
    assert_eq!(pair.count(0, &Event::Ready), 0);
    let expected = "node 5 refused writing 0h to 1A00.00h: the object cannot be written (abort 06010002h); see its manual";
    assert_eq!(pair.faults(0)[0], (FaultKind::Refused, expected.to_owned()));
}

#[test]
fn the_measuring_step_stands_in_for_a_missing_position_step() {
    let old = NodeConfig { absent: vec![0x6005], position_step_nm: 500, ..node(5) };
    let mut pair = Pair::started(old, settings(5));
    pair.sync(1, &[3]);
    assert_eq!(pair.readings(0)[0].values.get(0), Some(0.0015));
    assert_eq!(pair.faults(0), []);
}

#[test]
fn a_node_that_cannot_count_syncs_is_told() {
    let old = NodeConfig { absent: vec![0x1019], ..node(5) };
    let mut pair = Pair::started(old, settings(5));
    assert_eq!(pair.count(0, &Event::Ready), 1);
    (1..=3).for_each(|counter| pair.sync(counter, &[0]));
    let faults: Vec<_> = pair.faults(0).into_iter().map(|(_, detail)| detail).collect();
    assert!(faults[0].starts_with("node 5 refused writing Ah to 1019.00h: no such object"));
    assert!(faults[1].contains("emergency 8240h (protocol error)"), "{faults:?}");
    assert_eq!(faults[2], "node 5 sent no position for SYNC 1: check the load of the bus");
}

#[test]
fn velocity_and_work_area_are_read_and_flagged() {
    let limited = NodeConfig { work_area: Some((0, 1000)), ..node(5) };
    let full = Settings { map_velocity: true, map_status: true, ..settings(5) };
    let mut pair = Pair::started(limited, full);
    let mut all = Vec::new();
    for (cycle, (position, velocity)) in [(10, -3), (1001, 0), (-1, 7)].into_iter().enumerate() {
        pair.bus.set_motion(0, position, velocity);
        pair.sync(counter(cycle), &[]);
        let reading = pair.readings(0)[cycle].clone();
        all.push((reading.values.iter().flatten().collect::<Vec<_>>(), reading.flags));
    }
    // Velocity steps of 1 mm/s; the bits of object 6400h.
    assert_eq!(
        all,
        [
            (vec![0.010, -3.0, 0.0], Flags::empty()),
            (vec![1.001, 0.0, 3.0], Flags::OUT_OF_RANGE),
            (vec![-0.001, 7.0, 5.0], Flags::OUT_OF_RANGE),
        ]
    );
}

/// MTS E-Series manual: seven bytes mapped (p.32), six said to be sent (p.36).
#[test]
fn the_length_received_decides_and_a_difference_is_told_once() {
    let full = Settings { map_velocity: true, map_status: true, ..settings(5) };
    let mut pair = Pair::started(node(5), full);
    let bytes = [0x40, 0xE2, 0x01, 0x00, 0xFD, 0xFF, 0x07, 0x00];
    for (cycle, len) in [7, 6, 8, 4, 3].into_iter().enumerate() {
        let sync = CanFrame::data_frame(CanId::Standard(0x080), &[counter(cycle)]).unwrap();
        let position = CanFrame::data_frame(CanId::Standard(0x185), &bytes[..len]).unwrap();
        pair.settle(vec![sync, position]);
    }
    let values: Vec<Vec<_>> =
        pair.readings(0).iter().map(|each| each.values.iter().collect()).collect();
    let (position, velocity, status) = (Some(123.456), Some(-3.0), Some(7.0));
    assert_eq!(
        values,
        [
            [position, velocity, status],
            [position, velocity, None],
            [position, velocity, status],
            [position, None, None],
        ]
    );
    assert_eq!(pair.count(0, &Event::Discarded { bytes: 3 }), 1);
    let expected =
        "TPDO1 of node 5 has 6 bytes, its mapping 7: see its manual, or start it anew".to_owned();
    assert_eq!(pair.faults(0), [(FaultKind::Protocol, expected)]);
}

#[test]
fn stop_and_start_are_obeyed() {
    let mut pair = Pair::started(node(5), settings(5));
    pair.sync(1, &[1]);
    let now = pair.now;
    pair.drivers[0].command(now, Command::Stop);
    pair.settle(Vec::new());
    assert!(!pair.bus.armed());
    pair.sync(2, &[2]);
    pair.drivers[0].command(now + PERIOD, Command::Start);
    pair.settle(Vec::new());
    assert!(pair.bus.armed());
    pair.sync(3, &[3]);
    let counts: Vec<_> = pair.readings(0).iter().map(|each| each.count.unwrap().raw).collect();
    assert_eq!(counts, [1, 3]);
    assert_eq!((pair.faults(0), pair.count(0, &Event::Ready)), (vec![], 2));
}

#[test]
fn an_event_timer_gives_readings_without_a_count() {
    let timed =
        Settings { transmission: Transmission::EventTimer { period_ms: 20 }, ..settings(5) };
    let mut pair = Pair::started(node(5), timed);
    let before = pair.readings(0).len();
    pair.bus.set_motion(0, 42, 0);
    pair.advance(Duration::from_millis(200));
    let readings = pair.readings(0);
    assert_eq!(readings.len() - before, 10);
    let last = readings.last().unwrap();
    assert_eq!((last.values.get(0), last.count, last.flags), (Some(0.042), None, Flags::empty()));
    assert_eq!(pair.faults(0), []);
}

#[test]
fn nothing_from_before_a_reconnect_is_used_after_it() {
    let mut pair = Pair::started(node(5), settings(5));
    pair.sync(1, &[1]);
    pair.drivers[0].disconnected(pair.now);
    pair.sync(2, &[2]);
    assert_eq!(pair.readings(0).len(), 1);
    pair.start();
    assert_eq!((pair.count(0, &Event::Online), pair.count(0, &Event::Ready)), (2, 2));
    pair.sync(3, &[3]);
    assert_eq!(pair.readings(0)[1].count.unwrap().raw, 3);
}

fn any_frame() -> impl Strategy<Value = CanFrame> {
    let id = prop_oneof![
        4 => prop::sample::select(vec![0x000_u16, 0x080, 0x085, 0x185, 0x585, 0x605, 0x705]),
        1 => 0..=0x7FF_u16,
    ];
    let lead = prop::sample::select(vec![0x00_u8, 0x05, 0x7F, 0x40, 0x41, 0x43, 0x4F, 0x60, 0x80]);
    let data = (lead, prop::collection::vec(any::<u8>(), 0..=7), any::<bool>());
    (id, data).prop_map(|(id, (lead, mut data, led))| {
        if led {
            data.insert(0, lead);
        }
        CanFrame::data_frame(CanId::Standard(id), &data).expect("at most eight bytes")
    })
}

/// Where a failing case is kept. The default would be a folder beside the crate, and there the
/// workspace takes every folder for a member.
fn beside_this_file() -> ProptestConfig {
    let place = FileFailurePersistence::WithSource("regressions");
    ProptestConfig { failure_persistence: Some(Box::new(place)), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(beside_this_file())]

    /// Whatever is on the bus, in whatever state, nothing panics, and the same calls give the same events.
    #[test]
    fn any_frames_are_survived_and_decide_everything(
        frames in prop::collection::vec((any_frame(), 0..300_u64), 0..80)
    ) {
        let run = || {
            let mut pair = Pair::started(node(5), settings(5));
            for (frame, pause_ms) in &frames {
                pair.settle(vec![*frame]);
                pair.advance(Duration::from_millis(*pause_ms));
            }
            pair.events.swap_remove(0)
        };
        let events = run();
        prop_assert_eq!(events.iter().filter(|event| **event == Event::Online).count(), 1);
        prop_assert_eq!(events, run());
    }

    /// Frames get lost anywhere, SDO and SYNC too: a position never gets a wrong count, what is
    /// missing is missing in the counts, and once all is well again the node answers.
    #[test]
    fn losses_never_give_a_position_a_wrong_count(seed in any::<u64>(), one_in in 2..12_u64) {
        let mut pair = Pair::new(vec![node(5)], vec![settings(5)]);
        let mut state = seed | 1;
        pair.lost = Box::new(move |_| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 20).is_multiple_of(one_in)
        });
        pair.start();
        for cycle in 0..100 {
            pair.sync(counter(cycle), &[cycle as i32]);
        }
        for reading in pair.readings(0) {
            if let Some(count) = reading.count {
                let cycle = (reading.values.get(0).unwrap() * 1000.0).round() as usize;
                prop_assert_eq!(count.raw, u32::from(counter(cycle)));
            } else {
                prop_assert_eq!(reading.flags & Flags::DELAYED, Flags::DELAYED);
            }
        }
        pair.lost = Box::new(|_| false);
        pair.advance(Duration::from_secs(20));
        let before = pair.readings(0).len();
        (0..10).for_each(|cycle| pair.sync(counter(cycle), &[cycle as i32]));
        prop_assert_eq!(pair.readings(0).len() - before, 10);
    }
}

/// A node whose positions, velocities and states are sent, and its listener.
fn overheard() -> (NodeConfig, Settings, Settings) {
    let master = Settings { map_velocity: true, map_status: true, ..settings(5) };
    let listener = Settings {
        listen_only: true,
        kind: Kind::Linear { step_nm: Some(1000.0) },
        velocity_step_mm_s: Some(0.01),
        ..master.clone()
    };
    (node(5), master, listener)
}

#[test]
fn a_listener_reads_what_the_master_reads_and_never_sends() {
    let (node, master, listener) = overheard();
    let mut pair = Pair::new(vec![node], vec![master, listener]);
    let now = pair.now;
    pair.drivers[1].command(now, Command::Start);
    pair.drivers[1].connected(now);
    assert_eq!(pair.drivers[1].poll_timeout(), None);
    assert_eq!(pair.drivers[1].poll_transmit(), None);
    pair.drivers[0].command(now, Command::Start);
    pair.drivers[0].connected(now);
    pair.settle(Vec::new());
    pair.advance(Duration::from_millis(600));
    assert_eq!(pair.count(1, &Event::Online), 1);
    assert_eq!(pair.count(1, &Event::Ready), 1);
    for cycle in 0..30 {
        pair.sync(counter(cycle), &[cycle as i32 - 7]);
        assert_eq!(pair.drivers[1].poll_transmit(), None);
        assert_eq!(pair.drivers[1].poll_timeout(), None, "silence is no fault");
    }
    assert_eq!(pair.readings(0).len(), 30);
    assert_eq!(pair.readings(0), pair.readings(1));
    assert_eq!(pair.faults(1), []);
    let now = pair.now;
    pair.drivers[1].command(now, Command::Stop);
    assert_eq!(pair.drivers[1].poll_transmit(), None);
    pair.sync(1, &[0]);
    assert_eq!(pair.readings(1).len(), 30, "none after the stop");
}

#[test]
fn a_listener_says_what_another_mapping_and_a_stopped_node_mean() {
    let (node, master, listener) = overheard();
    let plain = Settings { map_status: false, ..listener.clone() };
    let mut pair = Pair::new(vec![node], vec![master, listener, plain]);
    pair.start();
    for cycle in 0..5 {
        pair.sync(counter(cycle), &[cycle as i32]);
    }
    assert_eq!(pair.readings(2), []);
    let faults = pair.faults(2);
    let of_mapping = faults.iter().filter(|(kind, _)| *kind == FaultKind::Protocol).count();
    assert_eq!(of_mapping, 1, "said once: {faults:?}");
    assert!(faults[0].1.contains("7 bytes, expected 6") && faults[0].1.contains("map_status"));
    // The master stops the node.
    let now = pair.now;
    pair.drivers[0].command(now, Command::Stop);
    pair.settle(Vec::new());
    pair.advance(Duration::from_millis(1200));
    let faults = pair.faults(1);
    assert!(
        faults
            .iter()
            .any(|(kind, words)| *kind == FaultKind::Device && words.contains("pre-operational")),
        "{faults:?}"
    );
    let now = pair.now;
    pair.drivers[0].command(now, Command::Start);
    pair.settle(Vec::new());
    pair.advance(Duration::from_millis(600));
    assert_eq!(pair.count(1, &Event::Ready), 2);
    pair.sync(counter(5), &[77]);
    assert_eq!(pair.readings(0), pair.readings(1));
}

#[test]
fn a_listener_needs_what_it_cannot_ask() {
    let settings = Settings {
        listen_only: true,
        map_velocity: true,
        vendor_id: Some(0x40),
        ..Settings::default()
    };
    let keys: Vec<_> = settings.problems().into_iter().map(|problem| problem.key).collect();
    assert_eq!(keys, ["step_nm", "velocity_step_mm_s", "vendor_id"]);
}
