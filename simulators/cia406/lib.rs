//! Simulated CANopen CiA 406 encoders on one bus.
