//! Many small pieces of work on as many threads as cores.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::args::available_cores;
use hedgehop::progress::Observer;

/// Does pieces 0 to `count` and returns what each gave, in order; `None` if the user asked to stop. Each one advances the observer.
pub fn side_by_side<T: Send>(
    count: usize,
    observer: &dyn Observer,
    piece: &(dyn Fn(usize) -> T + Sync),
) -> Option<Vec<T>> {
    let mut done: Vec<Mutex<Option<T>>> = Vec::new();
    done.resize_with(count, Mutex::default);
    let next = AtomicUsize::new(0);
    let work = || {
        while !observer.cancelled() {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(place) = done.get(index) else { return };
            *place.lock().unwrap_or_else(PoisonError::into_inner) = Some(piece(index));
            observer.advance(1);
        }
    };

    std::thread::scope(|scope| {
        for _ in 0..available_cores().min(count) {
            scope.spawn(work);
        }
    });
    done.into_iter().map(|piece| piece.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop::progress::Silent;

    #[test]
    fn results_keep_their_order() {
        assert_eq!(side_by_side(1000, &Silent, &|index| index * 2).unwrap()[..4], [0, 2, 4, 6]);
        assert_eq!(side_by_side(0, &Silent, &|index| index), Some(Vec::new()));
    }
}
