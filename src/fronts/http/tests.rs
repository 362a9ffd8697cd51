//! The server over real loopback sockets: every route, every refusal, streams fast and slow.

mod client;
mod connections;
mod controls;
mod page;
mod routes;
mod sites;
mod streams;
