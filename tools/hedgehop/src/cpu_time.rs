//! Processor time of this process.

use std::time::Duration;

/// Returns the time that all threads of the process have computed so far; `None` where the system does not say.
#[cfg(unix)]
pub fn of_process() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(Duration::new(u64::try_from(time.tv_sec).ok()?, u32::try_from(time.tv_nsec).ok()?))
}

/// Returns `None`: nobody asks this system.
#[cfg(not(unix))]
pub fn of_process() -> Option<Duration> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn computing_takes_time() {
        let begun = of_process().unwrap();
        while of_process().unwrap() - begun < Duration::from_millis(20) {
            std::hint::spin_loop();
        }
    }
}
