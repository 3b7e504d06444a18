//! What the modules say on its way to a bus outside, which may have no room for it.
//!
//! A system's queue fills up when nobody acknowledges, or when frames come faster than the bus takes them. Then a frame is tried
//! again for a while, and lost if that does not help; the bus goes on.

use std::time::Duration;

use tmcl_link::LinkError;
use tmcl_link::can::{CanFrame, CanLink};

/// How long to wait before a frame is tried again.
const PAUSE: Duration = Duration::from_millis(1);

/// How often a frame is tried: for as long as a bus of 10 kbit/s needs for several.
const TRIES: u32 = 100;

/// Sends frames, with patience.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    /// Whether the last frame was lost. Then the next one is tried once only: the modules have to listen, too.
    failing: bool,
}

impl Outbox {
    /// Sends a frame, or gives it up, after many tries or when `is_enough`.
    ///
    /// # Errors
    /// Why frames are lost, with the first of them; the others are lost without a word until one gets through.
    pub(super) fn send(
        &mut self,
        link: &mut impl CanLink,
        frame: CanFrame,
        is_enough: impl Fn() -> bool,
    ) -> Result<(), LinkError> {
        let mut left = if self.failing { 1 } else { TRIES };
        loop {
            let Err(error) = link.send(frame) else {
                self.failing = false;
                return Ok(());
            };
            left -= 1;
            if left == 0 || is_enough() || link.wait(PAUSE).is_err() {
                let is_new = !std::mem::replace(&mut self.failing, true);
                return if is_new { Err(error) } else { Ok(()) };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    /// A bus whose queue is full for so many sendings, and what was sent and waited since.
    #[derive(Default)]
    struct Queue {
        full_for: u32,
        tries: u32,
        sent: Vec<CanFrame>,
        waited: Duration,
    }

    impl CanLink for Queue {
        fn accept_only(&mut self, _: u16) -> Result<(), LinkError> {
            Ok(())
        }

        fn send(&mut self, frame: CanFrame) -> Result<(), LinkError> {
            self.tries += 1;
            if self.full_for > 0 {
                self.full_for -= 1;
                let source = io::Error::other("no buffer space available");
                return Err(LinkError::Write { address: "can:can0".to_owned(), source });
            }
            self.sent.push(frame);
            Ok(())
        }

        fn receive(&mut self, _: Duration) -> Result<Option<CanFrame>, LinkError> {
            Ok(None)
        }

        fn discard(&mut self) -> Result<(), LinkError> {
            Ok(())
        }

        fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
            self.waited += duration;
            Ok(())
        }
    }

    fn frame(byte: u8) -> CanFrame {
        CanFrame::new(2, &[byte]).expect("it fits")
    }

    #[test]
    fn a_full_queue_is_waited_for() {
        let mut queue = Queue { full_for: TRIES - 1, ..Queue::default() };
        Outbox::default().send(&mut queue, frame(1), || false).expect("there is room in the end");
        assert_eq!((queue.tries, queue.waited), (TRIES, PAUSE * (TRIES - 1)));
        assert_eq!(queue.sent, [frame(1)]);
    }

    #[test]
    fn a_queue_that_stays_full_loses_frames_and_says_so_once() {
        let mut queue = Queue { full_for: TRIES + 1, ..Queue::default() };
        let mut outbox = Outbox::default();
        let error = outbox.send(&mut queue, frame(1), || false).expect_err("it is full").to_string();
        assert!(error.contains("can:can0") && error.contains("no buffer space available"), "{error}");
        assert_eq!(queue.tries, TRIES);
        outbox.send(&mut queue, frame(2), || false).expect("it has been said");
        assert_eq!(queue.tries, TRIES + 1, "nobody waits for long while it stays full");
        outbox.send(&mut queue, frame(3), || false).expect("there is room");
        assert_eq!(queue.sent, [frame(3)]);
        // Then all begins anew.
        queue.full_for = u32::MAX;
        outbox.send(&mut queue, frame(4), || false).expect_err("it is full");
        assert_eq!(queue.tries, 2 * TRIES + 2);
    }

    #[test]
    fn whoever_has_enough_is_not_kept() {
        let mut queue = Queue { full_for: u32::MAX, ..Queue::default() };
        Outbox::default().send(&mut queue, frame(1), || true).expect_err("it is full");
        assert_eq!((queue.tries, queue.waited), (1, Duration::ZERO));
    }
}
