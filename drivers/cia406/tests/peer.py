"""A CiA 406 transducer made of canopen (LocalNode) and python-can (slcan over TCP).

usage: peer.py PORT EDS NODE CYCLES OVERFLOW

Connects to 127.0.0.1:PORT, boots, and once the master has set up and started the node sends CYCLES
SYNCs with their counter, each followed by TPDO1 as the master has mapped it. At cycle 20 it has an
error, at cycle 30 no more. What it sends at cycle k is known to peer.rs:

    position = 37 k^2 - 50000, velocity = k - 30, work area = 1 at every seventh cycle
"""

import sys
import time

import canopen


def main():
    port, eds, node_id, cycles, overflow = (
        sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), int(sys.argv[5]))
    network = canopen.Network()
    network.connect(
        interface="slcan", channel=f"socket://127.0.0.1:{port}", bitrate=500000, sleep_after_open=0)
    node = network.create_node(node_id, eds)
    # A device that boots is deaf. This one would answer from another thread between the two states, and
    # then go back to pre-operational, or beat with two hearts. What is lost meanwhile the master repeats.
    for listener in network.listeners:
        network.notifier.remove_listener(listener)
    node.nmt.send_command(129)
    node.nmt.send_command(128)
    for listener in network.listeners:
        network.notifier.add_listener(listener)

    while node.nmt.state != "OPERATIONAL":
        time.sleep(0.005)
    node.tpdo.read()
    tpdo = node.tpdo[1]
    # What CiA 406 and 301 ask of the master, as an independent stack reads it.
    assert tpdo.enabled, "TPDO1 is off"
    assert tpdo.cob_id == 0x180 + node_id, f"TPDO1 at {tpdo.cob_id:#x}"
    assert tpdo.trans_type == 1, f"transmission type {tpdo.trans_type}"
    assert node.sdo[0x1019].raw == overflow, "1019h not set"
    mapped = [(entry.index, entry.subindex, entry.length) for entry in tpdo]
    assert mapped == [(0x6020, 1, 32), (0x6030, 1, 16), (0x6400, 1, 8)], f"mapping {mapped}"

    for k in range(cycles):
        if k == 20:
            node.emcy.send(0x5000, 0x01, bytes([1, 2, 3, 4, 5]))
        if k == 30:
            node.emcy.reset()
        network.send_message(0x80, [1 + k % overflow])
        tpdo[0].raw = 37 * k * k - 50000
        tpdo[1].raw = k - 30
        tpdo[2].raw = 1 if k % 7 == 0 else 0
        tpdo.transmit()
        time.sleep(0.002)

    # The heartbeat goes on until whoever started this ends it.
    sys.stdin.read()


main()
