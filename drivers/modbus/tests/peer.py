"""A Baumer OM20 as pymodbus holds it: `peer.py tcp PORT` or `peer.py rtu PATH`. Says "ready" once it listens."""

import asyncio
import sys

from pymodbus import FramerType
from pymodbus.server import ModbusSerialServer, ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

# Input registers 200 to 212 (OM20 operating manual, Modbus): quality ok, switching output on, no
# alarm, 202 = 7C37h and 203 = 428Bh (69.743 mm), 500 Hz, exposure reserve 87, response delay
# 2000 us, device time 12 s 345678 us; of two registers the less significant one first.
MEASUREMENT = [0, 1, 0x7C37, 0x428B, 0, 0x43FA, 87, 2000, 0, 12, 0, 0x464E, 5]


def registers(address, values):
    return [SimData(address, values=values, datatype=DataType.REGISTERS)]


async def main(kind, where):
    bits = [SimData(0, values=[True] * 16, datatype=DataType.BITS)]
    # Coils, discrete inputs, holding registers, input registers.
    device = SimDevice(1, (bits, bits, registers(101, [1, 2, 3]), registers(200, MEASUREMENT)))
    if kind == "tcp":
        server = ModbusTcpServer(device, address=("127.0.0.1", int(where)))
    else:
        server = ModbusSerialServer(
            device, framer=FramerType.RTU, port=where, baudrate=57600, parity="N"
        )
    await server.serve_forever(background=True)
    print("ready", flush=True)
    await asyncio.Event().wait()


asyncio.run(main(*sys.argv[1:]))
