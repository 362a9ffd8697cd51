//! The option `--threads` of commands that compute.

use clap::Args;

use super::output::Failure;

/// Threads of a command.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct ThreadArgs {
    /// Threads to use; results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl ThreadArgs {
    /// Does work on as many threads as are asked for.
    pub(super) fn run<T: Send>(
        self,
        work: impl FnOnce() -> Result<T, Failure> + Send,
    ) -> Result<T, Failure> {
        match self.threads {
            None => work(),
            Some(threads) => {
                rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build()?.install(work)
            }
        }
    }

    /// Makes all work of the process use as many threads.
    pub(super) fn limit_process(self) -> Result<(), Failure> {
        if let Some(threads) = self.threads {
            rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
        }
        Ok(())
    }
}
