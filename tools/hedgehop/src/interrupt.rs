//! Ctrl-C and termination requests: the first asks the work to stop, the second ends the program.
//!
//! Work asks now and then whether to go on, and one frame may take minutes. So that the first request is answered at once, handlers also write a
//! byte to a pipe, where a thread waits for it.

#[cfg(unix)]
use std::io::Read;
#[cfg(unix)]
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
#[cfg(unix)]
use std::sync::{Mutex, PoisonError};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::exit;
use hedgehop::Error;

/// Says whether the user asked to stop. Clones share the answer.
#[derive(Debug, Clone, Default)]
pub struct Interrupt {
    is_requested: Arc<AtomicBool>,
    /// Stream that handlers write to, until somebody listens.
    #[cfg(unix)]
    bytes: Arc<Mutex<Option<UnixStream>>>,
}

impl Interrupt {
    /// Starts listening. A hang-up is left as it is, so that `nohup` works.
    pub fn install() -> hedgehop::Result<Self> {
        #[cfg_attr(not(unix), expect(unused_mut, reason = "only handlers of Unix write to it"))]
        let mut interrupt = Self::default();
        let requested = interrupt.is_requested.clone();
        let refused = |error| Error::Configuration(format!("cannot listen for Ctrl-C: {error}"));

        for signal in [SIGINT, SIGTERM] {
            // Handlers run in the order of registration: the shutdown sees the flag of an earlier signal only.
            flag::register_conditional_shutdown(signal, i32::from(exit::INTERRUPTED), requested.clone())
                .and_then(|_| flag::register(signal, requested.clone()))
                .map_err(refused)?;
        }

        #[cfg(unix)]
        {
            let (reader, writer) = UnixStream::pair().map_err(refused)?;
            for signal in [SIGINT, SIGTERM] {
                let writer = writer.try_clone().map_err(refused)?;
                signal_hook::low_level::pipe::register(signal, writer).map_err(refused)?;
            }
            interrupt.bytes = Arc::new(Mutex::new(Some(reader)));
        }
        // A file that may grow no further (`ulimit -f`) is an error of the write then, and not the end of the process.
        #[cfg(unix)]
        flag::register(libc::SIGXFSZ, Arc::default())
            .map_err(|error| Error::Configuration(format!("cannot listen for limits of files: {error}")))?;

        Ok(interrupt)
    }

    /// True once the user asked to stop.
    pub fn requested(&self) -> bool {
        self.is_requested.load(Ordering::Relaxed)
    }

    /// Has a thread of its own call `tell` as soon as the user asks to stop. Only the first caller is heard, and none where the system has no such
    /// pipes: what asks [`Self::requested`] has to tell then.
    pub fn tell_at_once(&self, tell: impl FnOnce() + Send + 'static) {
        #[cfg(unix)]
        if let Some(mut bytes) = self.bytes.lock().unwrap_or_else(PoisonError::into_inner).take() {
            let wait = move || {
                if bytes.read_exact(&mut [0]).is_ok() {
                    tell();
                }
            };
            // Without the thread the work tells, later.
            drop(std::thread::Builder::new().name("interrupt".into()).spawn(wait));
        }
        #[cfg(not(unix))]
        drop(tell);
    }
}
