//! Frames that others published, byte for byte.

mod bench;

use asphera_link::{Event, FaultKind, Unit};
use asphera_modbus::{Field, Function, Kind, Map, MapSource, Settings, Transport};
use bench::Bench;

fn settings(transport: Transport, unit_id: u8, map: impl Into<MapSource>) -> Settings {
    let map = map.into();
    Settings { transport, unit_id, map, max_gap_words: 124, ..Settings::default() }
}

fn map(function: Function, kind: Kind, addresses: &[u16]) -> Map {
    let field =
        |address: &u16| Field::channel(format!("at{address}"), function, *address, kind, Unit::One);
    let fields = addresses.iter().map(field).collect();
    Map { name: "golden".to_owned(), fields, blocks: Vec::new() }
}

/// The PDU of the specification in a Modbus TCP frame: transaction, protocol 0, length, unit FFh
/// (MODBUS Messaging on TCP/IP Implementation Guide V1.0b, section 3.1.3).
fn tcp(transaction: u8, pdu: &[u8]) -> Vec<u8> {
    let mut frame = vec![0, transaction, 0, 0, 0, pdu.len() as u8 + 1, 0xFF];
    frame.extend(pdu);
    frame
}

fn tcp_example(map: Map, request: &[u8], answer: &[u8]) -> Bench {
    let mut bench = Bench::new(settings(Transport::Tcp, 255, map));
    assert_eq!(bench.sent, [tcp(0, request)]);
    bench.receive(&tcp(0, answer));
    bench
}

/// MODBUS Application Protocol Specification V1.1b3, section 6.1: coils 20 to 38, of which 27 to 20
/// are CDh and 38 to 36 are 05h.
#[test]
fn read_coils() {
    let addresses = [19, 20, 21, 22, 23, 24, 25, 26, 35, 36, 37];
    let map = map(Function::ReadCoils, Kind::Bit(0), &addresses);
    let bench = tcp_example(map, &[1, 0, 0x13, 0, 0x13], &[1, 3, 0xCD, 0x6B, 5]);
    let expected = [1, 0, 1, 1, 0, 0, 1, 1, 1, 0, 1].map(|bit| Some(f64::from(bit)));
    assert_eq!(bench.values(), expected);
}

/// V1.1b3, section 6.2: discrete inputs 197 to 218, of which 204 to 197 are ACh and 218 to 213 are 35h.
#[test]
fn read_discrete_inputs() {
    let addresses = [196, 197, 198, 199, 200, 212, 213, 214, 215, 216, 217];
    let map = map(Function::ReadDiscrete, Kind::Bit(0), &addresses);
    let bench = tcp_example(map, &[2, 0, 0xC4, 0, 0x16], &[2, 3, 0xAC, 0xDB, 0x35]);
    let expected = [0, 0, 1, 1, 0, 1, 0, 1, 0, 1, 1].map(|bit| Some(f64::from(bit)));
    assert_eq!(bench.values(), expected);
}

/// V1.1b3, section 6.3: holding registers 108 to 110 hold 022Bh (555), 0 and 64h (100).
#[test]
fn read_holding_registers() {
    let map = map(Function::ReadHolding, Kind::U16, &[107, 108, 109]);
    let answer = [3, 6, 2, 0x2B, 0, 0, 0, 0x64];
    let bench = tcp_example(map, &[3, 0, 0x6B, 0, 3], &answer);
    assert_eq!(bench.values(), [Some(555.0), Some(0.0), Some(100.0)]);
    assert!(matches!(bench.events[..], [Event::Online, Event::Reading(_), Event::Ready]));
}

/// V1.1b3, section 6.4: input register 9 holds 0Ah (10).
#[test]
fn read_input_registers() {
    let map = map(Function::ReadInput, Kind::U16, &[8]);
    let bench = tcp_example(map, &[4, 0, 8, 0, 1], &[4, 2, 0, 0x0A]);
    assert_eq!(bench.values(), [Some(10.0)]);
}

/// V1.1b3, section 7: reading one coil at 04A1h is answered by 81h 02h, "illegal data address".
#[test]
fn exception() {
    let map = map(Function::ReadCoils, Kind::Bit(0), &[0x04A1]);
    let bench = tcp_example(map, &[1, 0x04, 0xA1, 0, 1], &[0x81, 2]);
    assert_eq!(bench.events[0], Event::Online, "an exception is a valid answer");
    let text = "unit 255 refused to read coils 1185: illegal data address (exception 2); check unit_id and the map of registers";
    assert_eq!(bench.faults(), [(FaultKind::Refused, text.to_owned())]);
    assert_eq!(bench.readings(), []);
}

/// UFACTORY, xArm Modbus TCP manual (docs.ufactory.cc/modbustcp_cn): transaction 1, unit 1, two
/// registers from 3 are 5 and 6; the first transaction is ours.
#[test]
fn tcp_frame_of_a_manual() {
    let map = map(Function::ReadHolding, Kind::U16, &[3, 4]);
    let mut bench = Bench::new(settings(Transport::Tcp, 1, map));
    bench.receive(&[0, 0, 0, 0, 0, 7, 1, 3, 4, 0, 1, 0, 2]);
    assert_eq!(bench.next_request(), [0, 1, 0, 0, 0, 6, 1, 3, 0, 3, 0, 2]);
    bench.receive(&[0, 1, 0, 0, 0, 7, 1, 3, 4, 0, 5, 0, 6]);
    assert_eq!(bench.values(), [Some(5.0), Some(6.0)]);
}

/// A captured refusal of an input register, transaction 0, unit 1 (forum of OWEN, thread 34814).
#[test]
fn captured_tcp_exception() {
    let map = map(Function::ReadInput, Kind::U16, &[0]);
    let mut bench = Bench::new(settings(Transport::Tcp, 1, map));
    bench.receive(&[0, 0, 0, 0, 0, 3, 1, 0x84, 2]);
    let text = "unit 1 refused to read input registers 0: illegal data address (exception 2); check unit_id and the map of registers";
    assert_eq!(bench.faults(), [(FaultKind::Refused, text.to_owned())]);
}

/// Kinco JD series manual, page 98: reading two registers from 3200h of station 1, CRC B3CAh.
#[test]
fn rtu_request_of_a_manual() {
    let map = map(Function::ReadHolding, Kind::U32, &[0x3200]);
    let bench = Bench::new(settings(Transport::Rtu, 1, map));
    assert_eq!(bench.sent, [[1, 3, 0x32, 0, 0, 2, 0xCA, 0xB3]]);
}

/// The same request twice: on a serial line the first answer only proves the device is there.
fn rtu_example(map: Map, unit_id: u8, request: &[u8], answer: &[u8]) -> Bench {
    let mut bench = Bench::new(settings(Transport::Rtu, unit_id, map));
    assert_eq!(bench.sent, [request]);
    bench.receive(answer);
    assert_eq!(bench.events[0], Event::Online);
    assert_eq!(bench.next_request(), request);
    bench.receive(answer);
    bench
}

/// Simply Modbus (simplymodbus.ca), FC 03: slave 11h holds AE41h, 5652h, 4340h in 006Bh to 006Dh.
#[test]
fn rtu_holding_registers() {
    let map = map(Function::ReadHolding, Kind::U16, &[0x6B, 0x6C, 0x6D]);
    let request = [0x11, 3, 0, 0x6B, 0, 3, 0x76, 0x87];
    let answer = [0x11, 3, 6, 0xAE, 0x41, 0x56, 0x52, 0x43, 0x40, 0x49, 0xAD];
    let bench = rtu_example(map, 0x11, &request, &answer);
    assert_eq!(bench.values(), [0xAE41, 0x5652, 0x4340].map(|word| Some(f64::from(word))));
}

/// Simply Modbus, FC 04: slave 11h holds 000Ah in input register 0008h.
#[test]
fn rtu_input_registers() {
    let map = map(Function::ReadInput, Kind::U16, &[8]);
    let request = [0x11, 4, 0, 8, 0, 1, 0xB2, 0x98];
    let bench = rtu_example(map, 0x11, &request, &[0x11, 4, 2, 0, 0x0A, 0xF8, 0xF4]);
    assert_eq!(bench.values(), [Some(10.0)]);
}

/// Simply Modbus, exceptions: slave 0Ah refuses to read the coil 04A1h.
#[test]
fn rtu_exception() {
    let map = map(Function::ReadCoils, Kind::Bit(0), &[0x04A1]);
    let request = [0x0A, 1, 0x04, 0xA1, 0, 1, 0xAC, 0x63];
    let bench = rtu_example(map, 0x0A, &request, &[0x0A, 0x81, 2, 0xB0, 0x53]);
    let kinds: Vec<_> = bench.faults().into_iter().map(|(kind, _)| kind).collect();
    assert_eq!(kinds, [FaultKind::Refused, FaultKind::Refused]);
    assert_eq!(bench.readings(), []);
}
