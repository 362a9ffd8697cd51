//! Precitec CHRocodile 2, dollar protocol.
