//! A CAN bus behind an interface of Linux: SocketCAN.
//!
//! The interface has been set up by the system, bit rate and all: `ip link set can0 up type can bitrate 1000000`.

pub use system::SocketCan;

#[cfg(target_os = "linux")]
mod system {
    use std::io;
    use std::time::Duration;

    use socketcan::{
        CanDataFrame, CanFrame as SystemFrame, CanSocket, EmbeddedFrame, Id, Socket, SocketOptions,
        StandardId,
    };

    use crate::can::{CanFrame, CanLink, MAX_ID};
    use crate::error::{Errors, is_timeout};
    use crate::{LinkAddress, LinkError};

    /// How long the interface may take nothing.
    const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

    /// The shortest wait; a socket takes zero for "forever".
    const SHORTEST_WAIT: Duration = Duration::from_micros(1);

    /// A filter compares all bits of an 11-bit identifier, and that it is one, and that there is data.
    const ALL_BITS: u32 = MAX_ID as u32 | EXTENDED | REMOTE;
    const EXTENDED: u32 = 0x8000_0000;
    const REMOTE: u32 = 0x4000_0000;

    /// Frames are thrown away as many at a time at most: a busy bus must not keep us.
    const DISCARD_LIMIT: usize = 4096;

    /// A CAN bus behind an interface of Linux.
    #[derive(Debug)]
    pub struct SocketCan {
        socket: CanSocket,
        errors: Errors,
    }

    impl SocketCan {
        /// Joins the bus at an interface such as `can0`, which is up and has its bit rate.
        ///
        /// # Errors
        /// [`LinkError`] when there is no such interface, or it is not for this user.
        pub fn open(interface: &str) -> Result<Self, LinkError> {
            let errors = Errors::of(LinkAddress::Can { interface: interface.to_owned() });
            let open = || -> io::Result<CanSocket> {
                let socket = CanSocket::open(interface)?;
                socket.set_write_timeout(WRITE_TIMEOUT)?;
                // Data frames with 11 bits, whatever the bits.
                socket.set_filters(&[(0_u32, EXTENDED | REMOTE)])?;
                Ok(socket)
            };
            let socket = open().map_err(|error| errors.open(error))?;
            Ok(Self { socket, errors })
        }

        /// The next data frame with 11 bits, within the socket's timeout.
        fn receive_once(&self) -> io::Result<Option<CanFrame>> {
            loop {
                match self.socket.read_frame() {
                    Ok(frame) => return Ok(from_system(&frame)),
                    Err(error) if is_timeout(&error) => return Ok(None),
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(error) => return Err(error),
                }
            }
        }

        fn discard_some(&self) -> io::Result<()> {
            for _ in 0..DISCARD_LIMIT {
                if self.receive_once()?.is_none() {
                    break;
                }
            }
            Ok(())
        }
    }

    impl CanLink for SocketCan {
        fn accept_only(&mut self, id: u16) -> Result<(), LinkError> {
            let filters = [(u32::from(id), ALL_BITS)];
            self.socket.set_filters(&filters).map_err(|error| self.errors.read(error))
        }

        fn send(&mut self, frame: CanFrame) -> Result<(), LinkError> {
            self.socket.write_frame(&to_system(frame)).map_err(|error| self.errors.write(error))
        }

        fn receive(&mut self, timeout: Duration) -> Result<Option<CanFrame>, LinkError> {
            let timeout = timeout.max(SHORTEST_WAIT);
            let received = self.socket.set_read_timeout(timeout).and_then(|()| self.receive_once());
            received.map_err(|error| self.errors.read(error))
        }

        fn discard(&mut self) -> Result<(), LinkError> {
            let set = |on| self.socket.set_nonblocking(on).map_err(|error| self.errors.read(error));
            set(true)?;
            let discarded = self.discard_some().map_err(|error| self.errors.read(error));
            set(false)?;
            discarded
        }
    }

    fn to_system(frame: CanFrame) -> SystemFrame {
        // `CanFrame` holds 11 bits and eight bytes at most, so there always is such a frame.
        let id = StandardId::new(frame.id()).unwrap_or(StandardId::ZERO);
        SystemFrame::Data(CanDataFrame::new(id, frame.data()).unwrap_or_default())
    }

    /// `None` for frames of other kinds.
    fn from_system(frame: &SystemFrame) -> Option<CanFrame> {
        match (frame, frame.id()) {
            (SystemFrame::Data(data), Id::Standard(id)) => CanFrame::new(id.as_raw(), data.data()).ok(),
            _ => None,
        }
    }

    #[cfg(test)]
    mod tests {
        use proptest::prelude::*;
        use socketcan::ExtendedId;

        use super::*;

        proptest! {
            #[test]
            fn frames_are_the_systems_frames(id in 0..=MAX_ID, data in proptest::collection::vec(any::<u8>(), 0..=8)) {
                let frame = CanFrame::new(id, &data).expect("it fits");
                let system = to_system(frame);
                prop_assert_eq!(system.id(), Id::Standard(StandardId::new(id).expect("11 bits")));
                prop_assert_eq!(system.data(), &data[..]);
                prop_assert_eq!(from_system(&system), Some(frame));
            }
        }

        #[test]
        fn other_kinds_of_frames_are_not_ours() {
            let id = ExtendedId::new(5).expect("29 bits");
            let extended = CanDataFrame::new(id, &[1]).expect("it fits");
            assert_eq!(from_system(&SystemFrame::Data(extended)), None);
            let remote = SystemFrame::new_remote(StandardId::ZERO, 3).expect("it fits");
            assert_eq!(from_system(&remote), None);
        }

        #[test]
        fn an_interface_that_is_not_there_is_reported_with_what_was_tried() {
            let error = SocketCan::open("nosuchcan").expect_err("there is none").to_string();
            assert!(error.starts_with("cannot open can:nosuchcan: "), "{error}");
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use std::time::Duration;

    use crate::can::{CanFrame, CanLink};
    use crate::error::Errors;
    use crate::{LinkAddress, LinkError};

    /// A CAN bus behind an interface of Linux, which this system has none of.
    #[derive(Debug)]
    pub enum SocketCan {}

    impl SocketCan {
        /// Says that this needs Linux.
        ///
        /// # Errors
        /// [`LinkError::Unsupported`].
        pub fn open(interface: &str) -> Result<Self, LinkError> {
            let errors = Errors::of(LinkAddress::Can { interface: interface.to_owned() });
            Err(errors.unsupported("CAN interfaces are a part of Linux; here use an adapter: slcan:COM3"))
        }
    }

    impl CanLink for SocketCan {
        fn accept_only(&mut self, _: u16) -> Result<(), LinkError> {
            match *self {}
        }

        fn send(&mut self, _: CanFrame) -> Result<(), LinkError> {
            match *self {}
        }

        fn receive(&mut self, _: Duration) -> Result<Option<CanFrame>, LinkError> {
            match *self {}
        }

        fn discard(&mut self) -> Result<(), LinkError> {
            match *self {}
        }
    }
}
