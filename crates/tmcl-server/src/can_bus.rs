//! A CAN bus outside: the modules take part in it through a link of this computer.

mod outbox;

use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use tmcl_link::LinkError;
use tmcl_link::can::{CanFrame, CanLink, SocketCan};
use virtual_bench::can::Frame;
use virtual_bench::{Bench, PortId, Wiring};

use crate::shared::{Notice, Shared};
use outbox::Outbox;

/// How long to listen before looking whether the modules have something to say unasked.
const PATIENCE: Duration = Duration::from_millis(1);

/// How long a frame may take to get out, however long the system thinks about it.
const LONGEST: Duration = Duration::from_secs(1);

/// Why the modules take no part in a CAN bus.
#[derive(Debug, thiserror::Error)]
pub enum CanError {
    /// The bus cannot be joined.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// Every line is taken.
    #[error("all ports of the module are in use")]
    NoPort,
}

/// Joins the bus at an interface of the system, and lets the modules take part until the server stops.
pub(crate) fn join(shared: &Arc<Shared>, interface: &str) -> Result<(), CanError> {
    let link = SocketCan::open(interface)?;
    let name = interface.to_owned();
    // Nobody has to be woken: the thread looks often enough.
    let (wake, _) = sync_channel(1);
    let line = shared.connect(wake, Wiring::CAN).ok_or(CanError::NoPort)?;
    let shared = Arc::clone(shared);
    std::thread::spawn(move || {
        if let Err(error) = take_part(&shared, line, &name, link) {
            shared.notify(Notice::ClientFailed(format!("{name}: {error}")));
        }
        shared.disconnect(line);
    });
    Ok(())
}

/// Ends when nothing can be heard any more. That something cannot be said is no end: it may be possible later.
fn take_part(shared: &Shared, line: PortId, name: &str, mut link: impl CanLink) -> Result<(), LinkError> {
    let mut outbox = Outbox::default();
    while !shared.is_stopping() {
        let heard = link.receive(PATIENCE)?;
        for frame in shared.exchange(|bench| pass(bench, line, heard)) {
            let start = Instant::now();
            let is_enough = || shared.is_stopping() || start.elapsed() > LONGEST;
            if let Err(error) = outbox.send(&mut link, frame, is_enough) {
                shared.notify(Notice::NotSent(format!("{name}: {error}")));
            }
        }
    }
    Ok(())
}

/// A frame goes to the modules, and what they have to say comes back.
fn pass(bench: &mut Bench, line: PortId, heard: Option<CanFrame>) -> Vec<CanFrame> {
    if let Some(frame) = heard.and_then(|frame| Frame::new(frame.id(), frame.data())) {
        bench.send_frame(line, &frame);
    }
    let said = std::iter::from_fn(|| bench.take_frame(line));
    said.filter_map(|frame| CanFrame::new(frame.id, frame.data.as_slice()).ok()).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::mpsc::{Receiver, Sender, channel};

    use virtual_bench::BenchConfig;
    use virtual_bench::ModuleKind::Tmcm1311;

    use super::*;

    /// A bus with somebody else on it.
    struct Wire {
        to_us: Receiver<CanFrame>,
        from_us: Sender<CanFrame>,
    }

    impl CanLink for Wire {
        fn accept_only(&mut self, _: u16) -> Result<(), LinkError> {
            Ok(())
        }

        fn send(&mut self, frame: CanFrame) -> Result<(), LinkError> {
            // Somebody who has gone hears nothing.
            let _ = self.from_us.send(frame);
            Ok(())
        }

        fn receive(&mut self, timeout: Duration) -> Result<Option<CanFrame>, LinkError> {
            Ok(self.to_us.recv_timeout(timeout).ok())
        }

        fn discard(&mut self) -> Result<(), LinkError> {
            Ok(())
        }
    }

    #[test]
    fn modules_take_part_in_a_bus_outside() {
        const PATIENCE: Duration = Duration::from_secs(20);
        let mut config = BenchConfig::default_of(&[Tmcm1311, Tmcm1311]);
        config.modules[1].address = Some(3);
        let notices = Arc::new(Mutex::new(Vec::new()));
        let heard = Arc::clone(&notices);
        let notify = move |notice| heard.lock().expect("nobody panics").push(notice);
        let advance = Box::new(Bench::advance_to);
        let shared = Arc::new(Shared::new(Bench::new(&config), 1.0, 0, advance, Box::new(notify)));
        let (wake, _) = sync_channel(1);
        let line = shared.connect(wake, Wiring::CAN).expect("a free line");
        let ((there, to_us), (from_us, here)) = (channel(), channel());
        let part = std::thread::spawn({
            let shared = Arc::clone(&shared);
            move || take_part(&shared, line, "can0", Wire { to_us, from_us })
        });
        let frame = |id, bytes: &[u8]| CanFrame::new(id, bytes).expect("it fits");
        for (id, module) in [(1, 1), (3, 3)] {
            there.send(frame(id, &[10, 71, 0, 0, 0, 0, 0])).expect("it is there");
            let reply = frame(2, &[module, 100, 10, 0, 0, 0, module]);
            assert_eq!(here.recv_timeout(PATIENCE), Ok(reply));
        }
        // 138 to a module that stands still at its target: the event comes unasked.
        there.send(frame(3, &[138, 0, 0, 0, 0, 0, 0])).expect("it is there");
        assert_eq!(here.recv_timeout(PATIENCE), Ok(frame(2, &[3, 100, 138, 0, 0, 0, 1])));
        assert_eq!(here.recv_timeout(PATIENCE), Ok(frame(2, &[3, 128, 138, 0, 0, 0, 1])));
        shared.stop();
        assert!(part.join().expect("it does not panic").is_ok());
        // On a busy machine virtual time may slip, and nothing else is to be said.
        let notices = notices.lock().expect("nobody panics");
        assert!(notices.iter().all(|notice| matches!(notice, Notice::Slipped(_))), "{notices:?}");
    }
}
