//! Serial ports, TCP and CAN: opening, reconnecting, tracing.
