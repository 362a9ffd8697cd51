//! A simulated Modbus device serving a register map.
