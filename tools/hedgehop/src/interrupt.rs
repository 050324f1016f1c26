//! Ctrl-C and termination requests: the first asks the work to stop, the second ends the program.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use hedgehop::Error;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::exit;

/// Says whether the user asked to stop. Clones share the answer.
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Starts listening. A hang-up is left as it is, so that `nohup` works.
    pub fn install() -> hedgehop::Result<Self> {
        let interrupt = Self::default();
        for signal in [SIGINT, SIGTERM] {
            // Handlers run in the order of registration: the shutdown sees the flag of an earlier signal only.
            flag::register_conditional_shutdown(signal, i32::from(exit::INTERRUPTED), interrupt.0.clone())
                .and_then(|_| flag::register(signal, interrupt.0.clone()))
                .map_err(|error| Error::Configuration(format!("cannot listen for Ctrl-C: {error}")))?;
        }
        // A file that may grow no further (`ulimit -f`) is an error of the write then, and not the end of the process.
        #[cfg(unix)]
        flag::register(libc::SIGXFSZ, Arc::default())
            .map_err(|error| Error::Configuration(format!("cannot listen for limits of files: {error}")))?;
        Ok(interrupt)
    }

    /// True once the user asked to stop.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
