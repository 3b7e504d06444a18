//! Bare firmware with a storage in memory, and hosts at its ports.
#![allow(dead_code, reason = "no test needs all of it")]

use std::collections::BTreeMap;

use module_firmware::{
    Axis, ERASED, Firmware, Instruction, Line, PortId, RecordKey, Storage, StorageError, TICKS_PER_MS,
};
use tmcl_tables::{Command, Status};
use tmcl_wire::{Reply, Request, can, serial};

/// A storage in memory, which fails when told to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    pub(crate) records: BTreeMap<u16, Vec<u8>>,
    pub(crate) program: BTreeMap<u16, Instruction>,
    pub(crate) erasing_fails: bool,
    pub(crate) writing_fails: bool,
}

impl Storage for Memory {
    fn read(&mut self, key: RecordKey, out: &mut [u8]) -> Result<usize, StorageError> {
        let Some(record) = self.records.get(&key.to_u16()) else { return Ok(0) };
        out[..record.len()].copy_from_slice(record);
        Ok(record.len())
    }

    fn write(&mut self, key: RecordKey, value: &[u8]) -> Result<(), StorageError> {
        if self.writing_fails {
            return Err(StorageError::Full);
        }
        self.records.insert(key.to_u16(), value.to_vec());
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.records.clear();
        Ok(())
    }

    fn read_program(&mut self, out: &mut [Instruction]) -> Result<(), StorageError> {
        out.fill(ERASED);
        for (address, instruction) in &self.program {
            out[usize::from(*address)] = *instruction;
        }
        Ok(())
    }

    fn write_instruction(&mut self, address: u16, instruction: Instruction) -> Result<(), StorageError> {
        self.program.insert(address, instruction);
        Ok(())
    }

    fn erase_program(&mut self) -> Result<(), StorageError> {
        if self.erasing_fails {
            return Err(StorageError::Medium);
        }
        self.program.clear();
        Ok(())
    }
}

/// Ports that the tests give their kinds of lines.
pub(crate) const USB: PortId = PortId::ALL[0];
pub(crate) const RS485: PortId = PortId::ALL[1];
pub(crate) const CAN: PortId = PortId::ALL[2];

/// A module with its storage and a line of each kind.
#[derive(Clone, Debug)]
pub(crate) struct Node<A: Axis> {
    pub(crate) firmware: Firmware<A>,
    pub(crate) storage: Memory,
}

impl<A: Axis<Sensed: Default>> Node<A> {
    pub(crate) fn new() -> Self {
        Self::with(Memory::default())
    }

    /// A module as it is after power-on with this storage.
    pub(crate) fn with(mut storage: Memory) -> Self {
        let mut firmware = Firmware::power_on(&mut storage);
        firmware.set_line(RS485, Line::Rs485);
        firmware.set_line(CAN, Line::Can);
        Self { firmware, storage }
    }

    pub(crate) fn power_cycle(&mut self) {
        *self = Self::with(self.storage.clone());
    }

    pub(crate) fn work(&mut self) {
        while self.firmware.has_background_work() {
            self.firmware.background(&mut self.storage);
        }
        // Room in an outbox lets what waits in the inbox go ahead.
        self.firmware.background(&mut self.storage);
    }

    /// Lets control periods pass.
    pub(crate) fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            let _ = self.firmware.tick(&A::Sensed::default());
            self.work();
        }
    }

    pub(crate) fn run_ms(&mut self, ms: u64) {
        self.run(ms * TICKS_PER_MS);
    }

    /// Bytes arrive at a port; all of them find room.
    #[track_caller]
    pub(crate) fn feed(&mut self, port: PortId, bytes: &[u8]) {
        for byte in bytes {
            assert!(self.firmware.receive(port, *byte), "no room for {bytes:02x?}");
            self.work();
        }
    }

    /// What leaves a port.
    pub(crate) fn heard(&mut self, port: PortId) -> Vec<u8> {
        let mut heard = Vec::new();
        loop {
            let before = heard.len();
            while let Some(byte) = self.firmware.transmit(port) {
                heard.push(byte);
            }
            self.work();
            if heard.len() == before {
                return heard;
            }
        }
    }

    /// Bytes arrive, and what leaves thereupon.
    #[track_caller]
    pub(crate) fn exchange(&mut self, port: PortId, bytes: &[u8]) -> Vec<u8> {
        self.feed(port, bytes);
        self.heard(port)
    }

    /// A frame arrives, and those that leave thereupon.
    #[track_caller]
    pub(crate) fn exchange_frame(&mut self, id: u16, data: &[u8]) -> Vec<(u16, Vec<u8>)> {
        let frame = can::Frame::new(id, data).expect("eight bytes at most");
        assert!(self.firmware.receive_frame(CAN, &frame), "no room for {frame:?}");
        self.work();
        self.frames()
    }

    /// The frames that leave.
    pub(crate) fn frames(&mut self) -> Vec<(u16, Vec<u8>)> {
        let mut frames = Vec::new();
        while let Some(frame) = self.firmware.transmit_frame(CAN) {
            frames.push((frame.id, frame.data.as_slice().to_vec()));
            self.work();
        }
        frames
    }

    /// The one reply to a request over USB, from the module at `address` to host 2.
    #[track_caller]
    pub(crate) fn ask(&mut self, address: u8, request: Request) -> Reply {
        let datagram = self.exchange(USB, &serial::encode_request(address, request));
        let datagram =
            datagram.try_into().unwrap_or_else(|datagram| panic!("{datagram:02x?} to {request:?}"));
        let (host, module, reply) = serial::decode_reply(datagram).expect("a reply");
        assert_eq!((host, module), (2, address));
        reply
    }

    /// The value that an allowed command answers over USB.
    #[track_caller]
    pub(crate) fn ok(&mut self, command: Command, kind: u8, motor: u8, value: i32) -> i32 {
        let request = Request::new(command, kind, motor, value);
        let reply = self.ask(1, request);
        assert_eq!(reply.status, Status::Ok, "{request:?}");
        reply.value
    }

    #[track_caller]
    pub(crate) fn sgp(&mut self, number: u8, value: i32) {
        self.ok(Command::SetGlobalParameter, number, 0, value);
    }

    #[track_caller]
    pub(crate) fn gap(&mut self, number: u8) -> i32 {
        self.ok(Command::GetAxisParameter, number, 0, 0)
    }
}

/// A request as a datagram.
pub(crate) fn datagram(address: u8, command: Command, kind: u8, motor: u8, value: i32) -> [u8; 9] {
    serial::encode_request(address, Request::new(command, kind, motor, value))
}

/// A reply with status 100 as a datagram to host 2.
pub(crate) fn answer(module: u8, command: Command, value: i32) -> [u8; 9] {
    serial::encode_reply(2, module, Reply { status: Status::Ok, command: command.number(), value })
}
