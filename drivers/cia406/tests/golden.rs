//! Frames from manuals and from other people's logs.

use asphera_cia406::WireError;
use asphera_cia406::wire::object::{self, Address};
use asphera_cia406::wire::{
    AbortCode, AreaState, Cob, Emergency, Expedited, MappedObject, NmtCommand, NmtRequest,
    NmtState, NodeId, Position, SdoRequest, SdoResponse, TpdoLayout, heartbeat_frame, sync_frame,
};
use asphera_cia406::{Cia406, Settings};
use asphera_link::{CanFrame, CanId, Command, Driver, Event, Input, Nanos, Output};

fn node(number: u8) -> NodeId {
    NodeId::new(number).expect("1 to 127")
}

fn frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(CanId::Standard(id), data).expect("a good frame")
}

/// Log of a CANopen master, gist floweisshardt/13ec36be: node 33h is asked for 1800.01h.
#[test]
fn sdo_upload_of_a_public_log() {
    let id = node(0x33);
    let address = Address::new(0x1800, 1);
    let asked = SdoRequest::Upload(address).encode(id);
    assert_eq!(asked, frame(0x633, &[0x40, 0x00, 0x18, 0x01, 0, 0, 0, 0]));
    let said = [0x43, 0x00, 0x18, 0x01, 0xB3, 0x01, 0x00, 0x00];
    let value = Expedited::u32(0x1B3);
    assert_eq!(SdoResponse::decode(id, &said), Ok(SdoResponse::Uploaded(address, value)));
    assert_eq!(SdoResponse::Uploaded(address, value).encode(id), frame(0x5B3, &said));
}

/// Temposonics T-Series manual, p.38: "save" and "load" to node 7Fh, without the size (22h).
#[test]
fn sdo_download_without_a_size() {
    let id = node(0x7F);
    let asked = [0x22, 0x10, 0x10, 0x01, 0x73, 0x61, 0x76, 0x65];
    let SdoRequest::Download(address, value) = SdoRequest::decode(id, &asked).unwrap() else {
        panic!("a download")
    };
    assert_eq!((address, value.byte_len()), (Address::new(0x1010, 1), None));
    assert_eq!(value.number().to_le_bytes(), *b"save");
    assert_eq!(SdoRequest::Download(address, value).encode(id), frame(0x67F, &asked));
    let said = [0x60, 0x10, 0x10, 0x01, 0, 0, 0, 0];
    assert_eq!(SdoResponse::decode(id, &said), Ok(SdoResponse::Downloaded(address)));
    assert_eq!(SdoResponse::Downloaded(address).encode(id), frame(0x5FF, &said));
}

/// Log of a master at CoDeSys, csdn wojiuguowei/127568371: node 2, 1016.01h.
#[test]
fn sdo_download_of_four_bytes_of_a_public_log() {
    let id = node(2);
    let value = Expedited::u32(0x007F_012C);
    let asked = SdoRequest::Download(Address::new(0x1016, 1), value).encode(id);
    assert_eq!(asked, frame(0x602, &[0x23, 0x16, 0x10, 0x01, 0x2C, 0x01, 0x7F, 0x00]));
}

/// CiA 301: sizes in the command specifier; an answer may carry rubbish behind its size.
#[test]
fn sdo_sizes() {
    let id = node(1);
    let address = object::HEARTBEAT_TIME;
    let byte = |request: SdoRequest| request.encode(id).data()[0];
    assert_eq!(byte(SdoRequest::Download(address, Expedited::u8(1))), 0x2F);
    assert_eq!(byte(SdoRequest::Download(address, Expedited::u16(1))), 0x2B);
    assert_eq!(byte(SdoRequest::Download(address, Expedited::u32(1))), 0x23);
    let said = [0x4B, 0x17, 0x10, 0x00, 0xE8, 0x03, 0xAA, 0xBB];
    let expected = SdoResponse::Uploaded(address, Expedited::u16(1000));
    assert_eq!(SdoResponse::decode(id, &said), Ok(expected));
    let longer = [0x41, 0x08, 0x10, 0x00, 0x04, 0, 0, 0];
    let expected = SdoResponse::Segmented(Address::new(0x1008, 0));
    assert_eq!(SdoResponse::decode(id, &longer), Ok(expected));
}

/// Abort codes as python canopen 2.4.1 and the CoDeSys slave stack list them.
#[test]
fn sdo_abort() {
    let said = [0x80, 0x18, 0x10, 0x01, 0x11, 0x00, 0x09, 0x06];
    let expected = SdoResponse::Aborted(object::VENDOR, AbortCode::NO_SUB_INDEX);
    assert_eq!(SdoResponse::decode(node(1), &said), Ok(expected));
    assert_eq!(AbortCode(0x0602_0000).to_string(), "no such object (abort 06020000h)");
    assert_eq!(AbortCode(1).meaning(), "a code CiA 301 does not define");
}

/// MTS p.27: network management and heartbeat.
#[test]
fn network_management() {
    let start = NmtRequest::to(node(5), NmtCommand::Start);
    assert_eq!(start.encode(), frame(0x000, &[0x01, 0x05]));
    let all = NmtRequest { command: NmtCommand::ResetNode, node: None };
    assert_eq!(NmtRequest::decode(&[0x81, 0x00]), Ok(all));
    for (byte, state) in [
        (0x00, NmtState::BootUp),
        (0x04, NmtState::Stopped),
        (0x05, NmtState::Operational),
        (0x7F, NmtState::PreOperational),
    ] {
        assert_eq!(heartbeat_frame(node(5), state), frame(0x705, &[byte]));
        assert_eq!(NmtState::decode(node(5), &[byte]), Ok(state));
    }
    let cob = Cob::Heartbeat(node(5));
    assert_eq!(NmtState::decode(node(5), &[9]), Err(WireError::Value { cob, found: 9 }));
    assert_eq!(NodeId::new(128), Err(WireError::Node(128)));
}

/// MTS p.36 (no data), esd p.71 (counter).
#[test]
fn sync() {
    assert_eq!(sync_frame(None), frame(0x080, &[]));
    assert_eq!(sync_frame(Some(240)), frame(0x080, &[240]));
}

/// MTS p.32: the default mapping of TPDO1.
#[test]
fn default_mapping_of_the_e_series() {
    let layout = TpdoLayout { position: object::POSITION_1, velocity: true, area_state: true };
    let entries: Vec<_> = layout.objects().map(MappedObject::entry).collect();
    assert_eq!(entries, [0x6020_0120, 0x6030_0110, 0x6400_0108]);
    assert_eq!((layout.byte_len(), layout.count()), (7, 3));
    assert_eq!(MappedObject::from_entry(entries[1]), layout.object(1).unwrap());
}

/// MTS p.36: position, velocity, status, low bytes first; the manual says six bytes and lists seven.
#[test]
fn tpdo_of_six_and_of_seven_bytes() {
    let layout = TpdoLayout { position: object::POSITION_1, velocity: true, area_state: true };
    let data = [0x40, 0xE2, 0x01, 0x00, 0xFD, 0xFF, 0x03];
    let full = Position { position: 123_456, velocity: Some(-3), area_state: Some(AreaState(3)) };
    assert_eq!(layout.decode(&data), Some(full));
    assert_eq!(layout.decode(&data[..6]), Some(Position { area_state: None, ..full }));
    let short = Position { velocity: None, area_state: None, ..full };
    assert_eq!(layout.decode(&data[..5]), Some(short));
    assert_eq!(layout.decode(&data[..3]), None);
    // BEI p.51: only the lowest three bits say that the position is outside.
    assert!(AreaState(0b100).is_outside() && !AreaState(0b1111_1000).is_outside());
}

/// Layout: Faulhaber MC 5010 communications manual p.24; codes: table of CiA 301.
#[test]
fn emergency() {
    let said = [0x10, 0x43, 0x08, 0x20, 0x00, 0, 0, 0];
    let emergency = Emergency::decode(node(5), &said).unwrap();
    assert_eq!((emergency.code, emergency.register), (0x4310, 0x08));
    assert_eq!(emergency.encode(node(5)), frame(0x085, &said));
    assert!(!emergency.is_reset());
    let reset = Emergency::decode(node(5), &[0, 0, 0, 0, 0, 0, 0, 0]).unwrap();
    assert!(reset.is_all_clear());
}

#[test]
fn identifiers_name_their_object() {
    for (id, cob) in [
        (0x000, Some(Cob::Nmt)),
        (0x080, Some(Cob::Sync)),
        (0x0FF, Some(Cob::Emergency(node(127)))),
        (0x185, Some(Cob::Tpdo1(node(5)))),
        (0x180, None),
        (0x205, None),
        (0x5FF, Some(Cob::SdoResponse(node(127)))),
        (0x633, Some(Cob::SdoRequest(node(0x33)))),
        (0x701, Some(Cob::Heartbeat(node(1)))),
        (0x77F, Some(Cob::Heartbeat(node(127)))),
        (0x7FF, None),
    ] {
        assert_eq!(Cob::from_frame(&frame(id, &[])), cob, "{id:03X}");
        assert!(cob.is_none_or(|cob| cob.id() == id));
    }
    let long = CanFrame::data_frame(CanId::Extended(0x185), &[]).unwrap();
    let remote = CanFrame::remote_frame(CanId::Standard(0x185), 4).unwrap();
    assert_eq!((Cob::from_frame(&long), Cob::from_frame(&remote)), (None, None));
}

/// The first words of the driver to node 5, and the position 123456 of the E-Series at its end, all
/// as literal bytes.
#[test]
fn a_node_is_set_up_word_by_word() {
    let settings = Settings { node_id: 5, ..Settings::default() };
    let mut driver = Cia406::new(settings).expect("good settings");
    let now = Nanos::ZERO;
    driver.command(now, Command::Start);
    driver.connected(now);
    let dialogue: [(&[u8], &[u8]); 13] = [
        // Device type: absolute linear encoder, profile 406 (TR p.152).
        (&[0x40, 0x00, 0x10, 0x00], &[0x43, 0x00, 0x10, 0x00, 0x96, 0x01, 0x08, 0x00]),
        // Error register: no error.
        (&[0x40, 0x01, 0x10, 0x00], &[0x4F, 0x01, 0x10, 0x00, 0, 0, 0, 0]),
        // TPDO1 is at 40000185h; switch it off; every SYNC.
        (&[0x40, 0x00, 0x18, 0x01], &[0x43, 0x00, 0x18, 0x01, 0x85, 0x01, 0x00, 0x40]),
        (&[0x23, 0x00, 0x18, 0x01, 0x85, 0x01, 0x00, 0xC0], &[0x60, 0x00, 0x18, 0x01, 0, 0, 0, 0]),
        (&[0x2F, 0x00, 0x18, 0x02, 0x01], &[0x60, 0x00, 0x18, 0x02, 0, 0, 0, 0]),
        // Three objects are mapped; one is wanted.
        (&[0x40, 0x00, 0x1A, 0x00], &[0x4F, 0x00, 0x1A, 0x00, 0x03, 0, 0, 0]),
        (&[0x2F, 0x00, 0x1A, 0x00, 0x00], &[0x60, 0x00, 0x1A, 0x00, 0, 0, 0, 0]),
        (&[0x23, 0x00, 0x1A, 0x01, 0x20, 0x01, 0x20, 0x60], &[0x60, 0x00, 0x1A, 0x01, 0, 0, 0, 0]),
        (&[0x2F, 0x00, 0x1A, 0x00, 0x01], &[0x60, 0x00, 0x1A, 0x00, 0, 0, 0, 0]),
        // Step: 1000 nm. SYNC counts to 240. Heartbeat every 500 ms. TPDO1 on.
        (&[0x40, 0x05, 0x60, 0x01], &[0x43, 0x05, 0x60, 0x01, 0xE8, 0x03, 0x00, 0x00]),
        (&[0x2F, 0x19, 0x10, 0x00, 0xF0], &[0x60, 0x19, 0x10, 0x00, 0, 0, 0, 0]),
        (&[0x2B, 0x17, 0x10, 0x00, 0xF4, 0x01], &[0x60, 0x17, 0x10, 0x00, 0, 0, 0, 0]),
        (&[0x23, 0x00, 0x18, 0x01, 0x85, 0x01, 0x00, 0x40], &[0x60, 0x00, 0x18, 0x01, 0, 0, 0, 0]),
    ];
    let sent = |driver: &mut Cia406| match driver.poll_transmit() {
        Some(Output::Frame(frame)) => frame,
        other => panic!("{other:?}"),
    };
    assert_eq!(sent(&mut driver), frame(0x000, &[0x80, 0x05]));
    for (asked, said) in dialogue {
        let mut padded = asked.to_vec();
        padded.resize(8, 0);
        assert_eq!(sent(&mut driver), frame(0x605, &padded));
        driver.receive(now, Input::Frame(&frame(0x585, said)));
    }
    // Started, and asked for its error register: the answer shows that it has been.
    assert_eq!(sent(&mut driver), frame(0x000, &[0x01, 0x05]));
    assert_eq!(sent(&mut driver), frame(0x605, &[0x40, 0x01, 0x10, 0x00, 0, 0, 0, 0]));
    assert_eq!(driver.poll_transmit(), None);
    driver.receive(now, Input::Frame(&frame(0x585, &[0x4F, 0x01, 0x10, 0x00, 0, 0, 0, 0])));
    driver.receive(now, Input::Frame(&frame(0x080, &[0x11])));
    driver.receive(now, Input::Frame(&frame(0x185, &[0x40, 0xE2, 0x01, 0x00])));
    assert_eq!(driver.poll_event(), Some(Event::Online));
    assert_eq!(driver.poll_event(), Some(Event::Ready));
    let Some(Event::Reading(reading)) = driver.poll_event() else { panic!("a reading") };
    assert_eq!(reading.values.get(0), Some(123.456));
    assert_eq!(reading.count.map(|count| count.raw), Some(0x11));
}
