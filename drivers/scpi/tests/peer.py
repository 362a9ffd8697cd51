"""The instrument of peer.yaml, played by pyvisa-sim: `peer.py YAML PORT`. Says "ready" once it listens."""

import socket
import sys

import pyvisa

description, port = sys.argv[1:]
manager = pyvisa.ResourceManager(f"{description}@sim")
instrument = manager.open_resource("TCPIP::localhost::10001::SOCKET")
instrument.timeout = 20
with socket.create_server(("127.0.0.1", int(port))) as server:
    print("ready", flush=True)
    connection, _ = server.accept()
    connection.settimeout(0.01)
    while True:
        try:
            sent = connection.recv(300)
            if not sent:
                break
            instrument.write_raw(sent)
        except TimeoutError:
            pass
        try:
            connection.sendall(instrument.read_bytes(1, break_on_termchar=False))
            while True:
                connection.sendall(instrument.read_bytes(1, break_on_termchar=False))
        except pyvisa.errors.VisaIOError:
            pass
