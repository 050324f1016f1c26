//! Eviction by second chance, over pages that nobody is known to need.

/// Reason to keep a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Claim {
    /// Frames in flight or ahead need it, or it is kept always.
    Needed,
    /// Used since the hand passed last.
    Used,
    /// Ahead of the eye, though no frame that is known needs it.
    Ahead,
    /// Nothing.
    None,
}

/// Pages in a circle, and a hand that passes them.
#[derive(Debug, Default)]
pub(super) struct Clock {
    ring: Vec<u32>,
    hand: usize,
}

impl Clock {
    /// A page is in memory from now on: the hand comes to it last.
    pub fn add(&mut self, page: u32) {
        self.ring.insert(self.hand, page);
        self.hand = (self.hand + 1) % self.ring.len();
    }

    /// All pages, in no order.
    pub fn pages(&self) -> impl Iterator<Item = u32> {
        self.ring.iter().copied()
    }

    /// Takes the next page out that may go. `claim` is asked once a round, and forgets that a page was used when it says so: two
    /// rounds look for one that nothing speaks for, which a page that was used may be in the second; the third takes any but needed
    /// ones.
    pub fn victim(&mut self, mut claim: impl FnMut(u32) -> Claim) -> Option<u32> {
        for round in 0..3 {
            for _ in 0..self.ring.len() {
                let page = self.ring[self.hand];
                let goes = match claim(page) {
                    Claim::Needed => false,
                    Claim::Used | Claim::Ahead => round == 2,
                    Claim::None => true,
                };
                if goes {
                    self.ring.remove(self.hand);
                    if self.hand >= self.ring.len() {
                        self.hand = 0;
                    }
                    return Some(page);
                }

                self.hand = (self.hand + 1) % self.ring.len();
            }
        }

        None
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn clock(count: u32) -> Clock {
        let mut clock = Clock::default();
        (0..count).for_each(|page| clock.add(page));
        clock
    }

    #[test]
    fn pages_go_in_the_order_of_their_coming_if_nothing_speaks_for_them() {
        let mut clock = clock(5);
        let order: Vec<_> = std::iter::from_fn(|| clock.victim(|_| Claim::None)).collect();
        assert_eq!(order, [0, 1, 2, 3, 4]);
    }

    #[test]
    fn used_pages_have_a_second_chance_and_needed_ones_stay() {
        let mut clock = clock(6);
        let mut used: BTreeSet<u32> = [0, 1, 4].into();
        let mut claim = |page: u32| match page {
            2 => Claim::Needed,
            5 => Claim::Ahead,
            _ if used.remove(&page) => Claim::Used,
            _ => Claim::None,
        };
        let order: Vec<_> = std::iter::from_fn(|| clock.victim(&mut claim)).collect();
        assert_eq!(order, [3, 0, 1, 4, 5]);
        assert_eq!(clock.victim(&mut claim), None);
    }
}
