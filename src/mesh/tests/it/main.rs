//! Tests of the mesh through its public interface.

mod batches;
mod changes;
mod lattice;
mod natural;
mod oracle;
mod paged;
mod patterns;
mod queries;
mod random;
mod scans;
mod stream;
mod threads;
mod withdrawn;
