"""Writes can_signals.txt, values of cantools (tried: 40.2.3): python3 can_signals.py > can_signals.txt

A line is a signal as a DBC file writes it, `start|bits@order sign`, the data of the frame, and the number that cantools reads.
"""

import random

import cantools


def value(start, bits, order, sign, data):
    """The number of a message with this one signal; `None` where cantools refuses it."""
    text = f'VERSION ""\nBU_: N\nBO_ 1 M: {len(data)} N\n SG_ S : {start}|{bits}@{order}{sign} (1,0) [0|0] "" N\n'
    try:
        base = cantools.database.load_string(text, "dbc")
    except cantools.database.Error:
        return None
    return base.get_message_by_name("M").decode(data, scaling=False)["S"]


def main():
    draw = random.Random(2026)
    lines = 0
    while lines < 400:
        length = draw.choice([1, 2, 4, 6, 8, 8, 8, 12, 64])
        data = bytes(draw.randrange(256) for _ in range(length))
        start, bits = draw.randrange(8 * length), draw.randint(1, min(64, 8 * length))
        order, sign = draw.choice("01"), draw.choice("+-")
        found = value(start, bits, order, sign, data)
        if found is not None:
            print(f"{start}|{bits}@{order}{sign} {data.hex().upper()} {found}")
            lines += 1


main()
