"""pymodbus as the client: `peer.py tcp PORT` or `peer.py rtu PATH`. Prints registers 200 to 212, the distance alone, and the exception to another part."""

import sys

from pymodbus import FramerType
from pymodbus.client import ModbusSerialClient, ModbusTcpClient

kind, where = sys.argv[1:]
if kind == "tcp":
    client = ModbusTcpClient("127.0.0.1", port=int(where))
else:
    client = ModbusSerialClient(where, framer=FramerType.RTU, baudrate=57600, parity="N")
assert client.connect()
print(*client.read_input_registers(200, count=13, device_id=1).registers)
print(*client.read_input_registers(202, count=2, device_id=1).registers)
print(client.read_input_registers(203, count=2, device_id=1).exception_code)
client.close()
