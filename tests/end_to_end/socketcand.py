"""A server that speaks as socketcand does, with two CiA 406 transducers of the package canopen on its bus.

usage: socketcand.py EDS BUS CYCLES OVERFLOW

Prints its port in five digits. The first connection it breaks off in the middle of an answer; the next one it serves.
Once the master has started nodes 5 and 6 it sends CYCLES SYNCs with their counter, each followed by both positions.
"""

import socket
import sys
import threading
import time

import can
import canopen


def greet(connection, bus):
    """The handshake of the document, step by step."""
    connection.sendall(b"< hi >")
    text = read_element(connection, "")
    assert text == f"< open {bus} >", text
    connection.sendall(b"< ok >")
    text = read_element(connection, "")
    assert text == "< rawmode >", text
    connection.sendall(b"< ok >")


def read_element(connection, text):
    while not text.endswith(">"):
        got = connection.recv(1)
        if not got:
            raise ConnectionError("closed")
        text += got.decode("ascii")
    return text


def to_bus(connection, bus):
    """`< send ID LENGTH BYTES >` of the client."""
    while True:
        try:
            words = read_element(connection, "").split()
        except (ConnectionError, OSError):
            return
        assert words[0] == "<" and words[1] == "send" and words[-1] == ">", words
        data = bytes(int(word, 16) for word in words[4:-1])
        assert len(data) == int(words[3]), words
        bus.send(can.Message(arbitration_id=int(words[2], 16), is_extended_id=len(words[2]) == 8, data=data))


def to_client(connection, bus):
    """Frames of the bus as the server prints them."""
    for message in bus:
        text = f"< frame {message.arbitration_id:03X} {message.timestamp:.6f} {message.data.hex().upper()} >"
        try:
            connection.sendall(text.encode("ascii"))
        except OSError:
            return


def boot(network, node_id, eds):
    node = network.create_node(node_id, eds)
    # A device that boots is deaf.
    for listener in network.listeners:
        network.notifier.remove_listener(listener)
    node.nmt.send_command(129)
    node.nmt.send_command(128)
    for listener in network.listeners:
        network.notifier.add_listener(listener)
    return node


def main():
    eds, bus_name, cycles, overflow = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    server = socket.create_server(("127.0.0.1", 0))
    print(f"{server.getsockname()[1]:05}", end="", flush=True)
    connection, _ = server.accept()
    connection.sendall(b"< hi >")
    read_element(connection, "")
    connection.sendall(b"< o")
    connection.close()

    connection, _ = server.accept()
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    bridge = can.Bus(interface="virtual", channel="bench")
    network = canopen.Network()
    network.connect(interface="virtual", channel="bench")
    nodes = [boot(network, node_id, eds) for node_id in (5, 6)]
    greet(connection, bus_name)
    connection.sendall(b"< frame 8FF 1 >")
    threading.Thread(target=to_bus, args=(connection, bridge), daemon=True).start()
    threading.Thread(target=to_client, args=(connection, bridge), daemon=True).start()

    while any(node.nmt.state != "OPERATIONAL" for node in nodes):
        time.sleep(0.005)
    time.sleep(0.3)
    for node in nodes:
        node.tpdo.read()
    for k in range(cycles):
        network.send_message(0x80, [1 + k % overflow])
        for node, position in zip(nodes, (10 * k - 1500, k % 7)):
            node.tpdo[1][0].raw = position
            node.tpdo[1].transmit()
        time.sleep(0.002)
    sys.stdin.read()


main()
