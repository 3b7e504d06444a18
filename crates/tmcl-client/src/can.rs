//! The CAN form of TMCL behind the calls of a stream of bytes (TMCM-1311 §4.1, §4.2).
//!
//! The client speaks the nine bytes of the serial form. On CAN the receiver's address is the frame's identifier, and there is
//! no checksum: a request is seven bytes, and so is its reply, whose identifier is the host's. The reply to command 136 type
//! 0 is eight characters.

use std::collections::VecDeque;
use std::time::Duration;

use tmcl_link::can::{CanFrame, CanLink, MAX_ID};
use tmcl_link::{Link, LinkError};
use tmcl_wire::serial::{DATAGRAM_LENGTH, checksum};

/// Who is who on the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CanIds {
    /// The identifier that the module listens to, global parameter 71, 0 to 0x7FF; when `None`, what the client takes for the
    /// module's address, so that modules can be told apart by addresses up to 255.
    pub module: Option<u16>,
    /// The identifier of its replies, global parameter 70, 0 to 0x7FF; when `None`, the client's host address.
    pub host: Option<u16>,
}

/// Nine-byte datagrams on a CAN bus.
///
/// - **Out.** Nine bytes become a frame with the module's identifier and the seven bytes between address and checksum.
/// - **In.** A frame with the host's identifier becomes nine bytes: the host address, its data, and a checksum where it has
///   seven bytes. Frames of eight bytes are the characters of command 136; they fill the nine as they are. Others are passed
///   over.
///
/// The first byte of a reply is the module's. Modules fill it in different ways: with the low byte of their identifier on the
/// bus (ours), or with the address of their serial port. The low byte of the identifier is replaced by the address that the
/// client used, so that a client with an identifier beyond 255 finds its reply; everything else is left to the client, which
/// reports who answered. (decision)
#[derive(Debug)]
pub struct CanStream<C> {
    can: C,
    ids: CanIds,
    host_address: u8,
    /// What was written of a datagram.
    out: Vec<u8>,
    /// Address and command of the last request, and the identifier it went to.
    asked: Option<Asked>,
    arrived: VecDeque<u8>,
}

#[derive(Clone, Copy, Debug)]
struct Asked {
    address: u8,
    command: u8,
    id: u16,
}

impl<C: CanLink> CanStream<C> {
    /// A stream to a client with this host address. Identifiers beyond 0x7FF are taken for that.
    ///
    /// # Errors
    /// [`LinkError`] when the bus is broken.
    pub fn new(mut can: C, ids: CanIds, host_address: u8) -> Result<Self, LinkError> {
        can.accept_only(ids.host.unwrap_or(host_address.into()).min(MAX_ID))?;
        Ok(Self { can, ids, host_address, out: Vec::new(), asked: None, arrived: VecDeque::new() })
    }

    /// Turns to another module or host on the same bus; as [`CanStream::new`], but that what has come is thrown away.
    ///
    /// # Errors
    /// [`LinkError`] when the bus is broken.
    pub fn turn_to(&mut self, ids: CanIds, host_address: u8) -> Result<(), LinkError> {
        self.can.accept_only(ids.host.unwrap_or(host_address.into()).min(MAX_ID))?;
        self.ids = ids;
        self.host_address = host_address;
        self.asked = None;
        self.arrived.clear();
        Ok(())
    }

    /// The identifiers that were given.
    #[must_use]
    pub const fn ids(&self) -> CanIds {
        self.ids
    }

    fn send(&mut self, datagram: [u8; DATAGRAM_LENGTH]) -> Result<(), LinkError> {
        let [address, request @ .., _] = datagram;
        let id = self.ids.module.unwrap_or(address.into()).min(MAX_ID);
        self.asked = Some(Asked { address, command: request[0], id });
        // Seven bytes fit, and so does an identifier that was limited.
        CanFrame::new(id, &request).map_or(Ok(()), |frame| self.can.send(frame))
    }

    fn take(&mut self, frame: CanFrame) {
        let mut bytes = vec![self.host_address];
        match frame.data() {
            data @ &[first, _, command, ..] if data.len() == 7 => {
                bytes.extend(data);
                bytes[1] = self.sender(first, command);
                bytes.push(checksum(&bytes));
            }
            data if data.len() == 8 => bytes.extend(data),
            _ => return,
        }
        self.arrived.extend(bytes);
    }

    /// Who sent a reply with this first byte to this command. Program memory, which comes in the same form, has no such
    /// command in its place, and stays as it is.
    fn sender(&self, first: u8, command: u8) -> u8 {
        let is_it = |asked: &Asked| asked.command == command && asked.id.to_le_bytes()[0] == first;
        self.asked.filter(is_it).map_or(first, |asked| asked.address)
    }
}

impl<C: CanLink> Link for CanStream<C> {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.out.extend(bytes);
        while let Some((datagram, rest)) = self.out.split_first_chunk() {
            let (datagram, rest) = (*datagram, rest.to_vec());
            self.out = rest;
            self.send(datagram)?;
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        if buffer.is_empty() {
            return Ok(0);
        }
        while self.arrived.is_empty() {
            match self.can.receive(timeout)? {
                Some(frame) => self.take(frame),
                None => return Ok(0),
            }
        }
        let length = buffer.len().min(self.arrived.len());
        for (slot, byte) in buffer.iter_mut().zip(self.arrived.drain(..length)) {
            *slot = byte;
        }
        Ok(length)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        self.arrived.clear();
        self.can.discard()
    }

    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        self.can.wait(duration)
    }
}

#[cfg(test)]
mod tests;
