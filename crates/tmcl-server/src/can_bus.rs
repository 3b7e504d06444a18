//! A CAN bus outside: the modules take part in it through a link of this computer.

use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::Duration;

use tmcl_link::LinkError;
use tmcl_link::can::{CanFrame, CanLink, SocketCan};
use virtual_bench::can::Frame;
use virtual_bench::{Bench, PortId, Wiring};

use crate::shared::{Notice, Shared};

/// How long to listen before looking whether the modules have something to say unasked.
const PATIENCE: Duration = Duration::from_millis(1);

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
        if let Err(error) = take_part(&shared, line, link) {
            shared.notify(Notice::ClientFailed(format!("{name}: {error}")));
        }
        shared.disconnect(line);
    });
    Ok(())
}

fn take_part(shared: &Shared, line: PortId, mut link: impl CanLink) -> Result<(), LinkError> {
    while !shared.is_stopping() {
        let heard = link.receive(PATIENCE)?;
        for frame in shared.exchange(|bench| pass(bench, line, heard)) {
            link.send(frame)?;
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
