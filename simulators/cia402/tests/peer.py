"""A client of CiA 402 made of canopen (profiles.p402) and python-can (slcan over TCP): homes a drive and moves it.

usage: peer.py PORT NODE TARGET

Prints `homed POSITION` and `arrived POSITION`, and ends with 0 if all went as the client expects.
"""

import sys
import time

import canopen
from canopen.objectdictionary import ODArray, ODRecord, ODVariable, ObjectDictionary, datatypes
from canopen.profiles.p402 import BaseNode402

TYPES = {"u8": datatypes.UNSIGNED8, "u16": datatypes.UNSIGNED16, "u32": datatypes.UNSIGNED32,
         "i8": datatypes.INTEGER8, "i16": datatypes.INTEGER16, "i32": datatypes.INTEGER32}


def variable(name, index, sub, kind):
    one = ODVariable(name, index, sub)
    one.data_type = TYPES[kind]
    one.access_type = "rw"
    return one


def dictionary():
    known = ObjectDictionary()
    for index, kind in [(0x1000, "u32"), (0x1001, "u8"), (0x1017, "u16"), (0x603F, "u16"), (0x6040, "u16"),
                        (0x6041, "u16"), (0x605A, "i16"), (0x6060, "i8"), (0x6061, "i8"), (0x6064, "i32"),
                        (0x607A, "i32"), (0x607C, "i32"), (0x6081, "u32"), (0x6083, "u32"), (0x6084, "u32"),
                        (0x6098, "i8"), (0x609A, "u32"), (0x6502, "u32")]:
        known.add_object(variable(f"{index:X}", index, 0, kind))
    for index, subs in [(0x6099, ["u8", "u32", "u32"]), (0x1A00, ["u8"] + ["u32"] * 4)]:
        many = ODArray(f"{index:X}", index)
        for sub, kind in enumerate(subs):
            many.add_member(variable(f"{index:X}.{sub}", index, sub, kind))
        known.add_object(many)
    tpdo = ODRecord("1800", 0x1800)
    for sub, kind in [(0, "u8"), (1, "u32"), (2, "u8"), (5, "u16")]:
        tpdo.add_member(variable(f"1800.{sub}", 0x1800, sub, kind))
    known.add_object(tpdo)
    return known


def main():
    port, node_id, target = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    network = canopen.Network()
    network.connect(interface="slcan", channel=f"socket://127.0.0.1:{port}", bitrate=500000, sleep_after_open=0)
    node = BaseNode402(node_id, dictionary())
    network.add_node(node)
    assert node.sdo[0x1000].raw & 0xFFFF == 402
    node.sdo[0x1017].raw = 50
    node.nmt.wait_for_heartbeat(timeout=5)
    node.tpdo.read()
    tpdo = node.tpdo[1]
    tpdo.clear()
    tpdo.add_variable(0x6041)
    tpdo.add_variable(0x6064)
    tpdo.trans_type = 255
    tpdo.event_timer = 10
    tpdo.enabled = True
    tpdo.save()
    node.setup_402_state_machine()
    node.nmt.state = "OPERATIONAL"

    for state in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"):
        node.state = state
        assert node.state == state, node.state
    assert not node.is_homed()
    node.sdo[0x6098].raw = 17
    node.sdo[0x6099][1].raw = 40_000
    node.sdo[0x6099][2].raw = 4_000
    assert node.homing(timeout=20), "not homed"
    print("homed", node.sdo[0x6064].raw, flush=True)

    node.controlword = 0x0F
    node.op_mode = "PROFILED POSITION"
    node.sdo[0x6081].raw = 20_000
    node.sdo[0x607A].raw = target
    node.controlword = 0x1F
    while not node.sdo[0x6041].raw & 1 << 12:
        time.sleep(0.005)
    node.controlword = 0x0F
    while not node.sdo[0x6041].raw & 1 << 10:
        time.sleep(0.01)
    print("arrived", node.sdo[0x6064].raw, flush=True)
    node.state = "QUICK STOP ACTIVE"
    assert node.state == "QUICK STOP ACTIVE", node.state
    node.state = "SWITCH ON DISABLED"
    assert node.is_homed(), "it has forgotten its home"
    network.disconnect()


main()
