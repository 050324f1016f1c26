//! Memory that was used before.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// Pieces that wait to be used again, at most.
const MOST: usize = 16;

/// Memory that nobody uses any more, for the next: what is new must be cleared by the system page by page, grows bit by bit, and what
/// goes leaves holes among what stays.
#[derive(Debug, Default)]
pub struct Used<T>(Mutex<Vec<T>>);

impl<T: Default> Used<T> {
    /// Some that was used before, with what was left in it, or new.
    pub fn take(&self) -> T {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    /// Takes back memory that is not used any more.
    pub fn give_back(&self, memory: T) {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if waiting.len() < MOST {
            waiting.push(memory);
        }
    }

    /// Lends memory as [`Self::take`] does, until the loan is dropped.
    pub fn lend(&self) -> Lent<'_, T> {
        Lent { memory: self.take(), owner: self }
    }
}

/// Memory that goes back to its owner when this is dropped.
#[derive(Debug)]
pub struct Lent<'u, T: Default> {
    memory: T,
    owner: &'u Used<T>,
}

impl<T: Default> Deref for Lent<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.memory
    }
}

impl<T: Default> DerefMut for Lent<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.memory
    }
}

impl<T: Default> Drop for Lent<'_, T> {
    fn drop(&mut self) {
        self.owner.give_back(std::mem::take(&mut self.memory));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_back_is_taken_again_and_not_more_than_is_of_use() {
        let used = Used::<Vec<u8>>::default();
        let mut lent = used.lend();
        lent.push(7);
        assert!(used.take().is_empty(), "what is lent is nobody else's");
        drop(lent);
        assert_eq!(used.take(), [7]);
        (0..2 * MOST).for_each(|_| used.give_back(vec![1]));
        let again = std::iter::repeat_with(|| used.take()).take_while(|memory| !memory.is_empty());
        assert_eq!(again.count(), MOST);
    }
}
