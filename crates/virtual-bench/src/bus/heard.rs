//! What a host has yet to take.

use std::collections::VecDeque;

/// How much of it waits; what comes while so much does is lost, as it is when nobody empties the buffer of a port (decision).
/// Nothing else ends the talk of two modules that answer each other.
const LIMIT: usize = 1 << 16;

/// Bytes or frames, the first first.
#[derive(Clone, Debug)]
pub(super) struct Heard<T> {
    waiting: VecDeque<T>,
}

impl<T> Heard<T> {
    pub(super) fn new() -> Self {
        Self { waiting: VecDeque::new() }
    }

    pub(super) fn push(&mut self, item: T) {
        if self.waiting.len() < LIMIT {
            self.waiting.push_back(item);
        }
    }

    pub(super) fn pop(&mut self) -> Option<T> {
        self.waiting.pop_front()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Everything.
    pub(super) fn drain(&mut self) -> impl Iterator<Item = T> {
        self.waiting.drain(..)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nobody_takes_takes_no_more_than_so_much_room() {
        let mut heard = Heard::new();
        (0..=LIMIT).for_each(|item| heard.push(item));
        assert_eq!(heard.pop(), Some(0));
        heard.push(7);
        assert!(heard.drain().eq((1..LIMIT).chain([7])));
        assert!(heard.is_empty());
    }
}
