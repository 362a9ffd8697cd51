//! Lines of python-can: how it opens an adapter that listens only, classic frames, and CAN FD frames of every length.
//!
//! Needs an interpreter with python-can and pyserial (tried: 4.6.1, 3.5), named by the environment variable `ASPHERA_PYTHON`
//! or found as `python3`; skipped without.

use std::io::Read as _;
use std::net::TcpListener;
use std::process::{Command as Process, Stdio};

use asphera_link::{CanFrame, CanId, FdFlags};
use asphera_slcan::{BitRate, Command, Decoder, Item};

#[expect(clippy::print_stderr, reason = "what is skipped must be seen")]
fn python() -> Option<String> {
    let python = std::env::var("ASPHERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let found = Process::new(&python)
        .args(["-c", "import can, serial"])
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if !found {
        eprintln!("skipped: {python} cannot import can and serial");
    }
    found.then_some(python)
}

#[test]
fn lines_of_python_can_are_understood() {
    let Some(python) = python() else { return };
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = listener.local_addr().expect("it is bound").port().to_string();
    let mut host = Process::new(python)
        .args([concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py"), &port])
        .stderr(Stdio::null())
        .spawn()
        .expect("it just ran");
    let mut bytes = Vec::new();
    let (mut stream, _) = listener.accept().expect("the host connects");
    stream.read_to_end(&mut bytes).expect("the host sends");
    assert!(host.wait().expect("it ends").success());

    let (mut decoder, mut input, mut items) = (Decoder::new(), &bytes[..], Vec::new());
    while !input.is_empty() {
        items.extend(decoder.decode(&mut input));
    }
    let is_command = |item: &Item| matches!(item, Item::Command(_));
    let commands: Vec<Item> = items.iter().copied().filter(is_command).collect();
    let rate = BitRate::from_bits_per_s(500_000).expect("a bit rate of adapters");
    let [close, listen] = [Command::Close, Command::Listen].map(Item::Command);
    // It opens the channel with the bit rate, and once more by itself.
    assert_eq!(commands, [close, Item::Command(Command::BitRate(rate)), listen, listen, close]);

    let mut expected = Vec::new();
    for len in [0_u16, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64] {
        for id in [CanId::Standard(0x185 + len), CanId::Extended(0x1ABC_DE00 + u32::from(len))] {
            let data: Vec<u8> = (0..len).map(|k| (31 * k + len) as u8).collect();
            for bit_rate_switch in [false, true] {
                let flags = FdFlags { bit_rate_switch, error_passive: false };
                let frame = CanFrame::fd_frame(id, &data, flags).expect("a length of CAN FD");
                expected.push(Item::Frame(frame, None));
            }
            if len <= 8 {
                expected.push(Item::Frame(CanFrame::data_frame(id, &data).expect("8 bytes"), None));
            }
        }
    }
    // It ends a line that has no data bit rate in it.
    let is_frame = |item: &Item| !is_command(item) && *item != Item::Ok;
    let frames: Vec<Item> = items.into_iter().filter(is_frame).collect();
    assert_eq!(frames, expected);
}
