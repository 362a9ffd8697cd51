"""Peer of the test: python-can as the host of an slcan adapter at a TCP port."""

import sys

import can

LENGTHS = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64]


def messages():
    """Frames of every kind and length."""
    for length in LENGTHS:
        data = bytes((31 * k + length) & 0xFF for k in range(length))
        for extended in (False, True):
            name = 0x1ABCDE00 + length if extended else 0x185 + length
            kinds = [dict(is_fd=True), dict(is_fd=True, bitrate_switch=True)]
            if length <= 8:
                kinds.append(dict())
            for kind in kinds:
                yield can.Message(arbitration_id=name, is_extended_id=extended, data=data, **kind)


def main():
    channel = "socket://127.0.0.1:" + sys.argv[1]
    bus = can.Bus(interface="slcan", channel=channel, bitrate=500000, listen_only=True, sleep_after_open=0)
    for message in messages():
        bus.send(message)
    bus.shutdown()


main()
