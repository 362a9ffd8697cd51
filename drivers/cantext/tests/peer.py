"""Peers of the tests: python-can writes and reads logs of candump; a server that speaks as socketcand does."""

import socket
import sys

import can

LENGTHS = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64]


def messages():
    """Frames of every kind that python-can writes, 1 ms apart."""
    for k in range(200):
        kind = k % 8
        # 25 frames of CAN FD, in each length, with all flags.
        length = LENGTHS[k // 8 % 16] if kind == 7 else k % 9
        yield can.Message(
            timestamp=1436509052.249713 + k * 1e-3,
            arbitration_id=0x185 + k if kind != 3 else 0x1ABCDE00 + k,
            is_extended_id=kind == 3,
            is_remote_frame=kind == 5,
            is_error_frame=kind == 6,
            is_fd=kind == 7,
            bitrate_switch=kind == 7 and k // 8 % 2 == 1,
            error_state_indicator=kind == 7 and k // 8 % 4 > 1,
            data=None if kind in (5, 6) else bytes((k + j) & 0xFF for j in range(length)),
            channel="can1" if kind == 4 else "can0",
            is_rx=kind != 2,
        )


def write(path):
    with can.CanutilsLogWriter(path) as log:
        for message in messages():
            log.on_message_received(message)


def read(path):
    """One line a message: microseconds, channel, kind, identifier, data."""
    for one in can.CanutilsLogReader(path):
        fd = "fd" + "-brs" * one.bitrate_switch + "-esi" * one.error_state_indicator
        kind = "error" if one.is_error_frame else fd if one.is_fd else "remote" if one.is_remote_frame else "data"
        digits = 8 if one.is_extended_id else 3
        # What the reader does not give of an error frame is no part of the comparison.
        name = "" if kind == "error" else f"{one.arbitration_id:0{digits}X}"
        channel = "" if kind == "error" else one.channel
        length = one.dlc if kind == "remote" else len(one.data)
        print(round(one.timestamp * 1e6), channel, kind, name, length, bytes(one.data).hex().upper(), sep=",")


def serve(bus):
    """One client: greets it, opens `bus` alone, sends back each frame it sends as a frame of the bus."""
    server = socket.create_server(("127.0.0.1", 0))
    print(server.getsockname()[1], flush=True)
    connection, _ = server.accept()
    text = ""
    mode = "none"
    connection.sendall(b"< hi >")
    while True:
        got = connection.recv(1024).decode("ascii")
        if not got:
            return
        text += got
        while ">" in text:
            element, text = text.split(">", 1)
            words = element.strip().lstrip("<").split()
            if mode == "none" and words == ["open", bus]:
                mode = "bcm"
                connection.sendall(b"< ok >")
            elif mode == "bcm" and words == ["rawmode"]:
                mode = "raw"
                connection.sendall(b"< ok >")
            elif mode == "raw" and words[0] == "send":
                data = bytes(int(byte, 16) for byte in words[3:])
                assert len(data) == int(words[2]), element
                # Cut in the middle, as TCP may.
                answer = f"< frame {words[1]} 23.424242 {data.hex().upper()} >".encode()
                connection.sendall(answer[:9])
                connection.sendall(answer[9:])
            elif mode == "raw" and words[0] == "sendrtr":
                connection.sendall(f"< rtr {words[1]} 23.424242 {int(words[2])} >".encode())
            elif mode == "none":
                connection.sendall(b"< error could not open bus >")
                connection.close()
                return
            else:
                connection.sendall(b"< error unknown command >")


{"write": write, "read": read, "serve": serve}[sys.argv[1]](sys.argv[2])
