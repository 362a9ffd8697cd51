//! Modbus devices described by a register map.
