//! Pauses between attempts at the same request.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::Duration;

/// Attempts at one request, the first included.
const ATTEMPTS: u32 = 8;
/// Longest pause before the second attempt; each later one may be twice as long as the one before.
const FIRST: Duration = Duration::from_millis(100);
/// Longest pause of all.
const LONGEST: Duration = Duration::from_secs(5);
/// Longest pause that a server may ask for.
const LONGEST_ASKED: Duration = Duration::from_secs(30);
/// Longest that all pauses of a request take together.
const TOTAL: Duration = Duration::from_secs(60);

/// Pauses of one request so far.
#[derive(Debug, Default)]
pub(crate) struct Backoff {
    attempts: u32,
    paused: Duration,
}

impl Backoff {
    /// Returns the pause before the next attempt, after one that failed; `None`: it is given up. `asked` is what the server asked for.
    pub fn next(&mut self, asked: Option<Duration>) -> Option<Duration> {
        self.attempts += 1;
        if self.attempts >= ATTEMPTS || asked.is_some_and(|asked| asked > LONGEST_ASKED) {
            return None;
        }

        let longest = (FIRST * 2_u32.pow(self.attempts - 1)).min(LONGEST);
        // Connections that failed together do not come back together.
        let pause = asked.unwrap_or_default().max(longest.mul_f64(0.5 + 0.5 * share()));
        self.paused += pause;
        (self.paused <= TOTAL).then_some(pause)
    }

    /// Counts the attempts so far.
    pub fn attempts(&self) -> u32 {
        self.attempts
    }
}

/// Draws a number from 0 to 1 that nobody foresees.
fn share() -> f64 {
    RandomState::new().build_hasher().finish() as f64 / u64::MAX as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_and_end() {
        let mut backoff = Backoff::default();
        let pauses: Vec<_> = std::iter::from_fn(|| backoff.next(None)).collect();
        assert_eq!((pauses.len(), backoff.attempts()), (7, 8));
        assert!(pauses[0] >= FIRST / 2 && pauses[0] <= FIRST && pauses[6] >= LONGEST / 2, "{pauses:?}");
        assert!(pauses.iter().sum::<Duration>() < TOTAL);
    }

    #[test]
    fn servers_are_obeyed_within_bounds() {
        let asked = Duration::from_secs(25);
        let mut backoff = Backoff::default();
        assert_eq!(backoff.next(Some(asked)), Some(asked));
        assert_eq!(backoff.next(Some(asked)), Some(asked));
        assert_eq!(backoff.next(Some(asked)), None);
        assert_eq!(Backoff::default().next(Some(Duration::from_secs(3600))), None);
    }
}
