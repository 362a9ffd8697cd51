//! CANopen encoders and linear transducers after CiA 406.
