//! A module in memory, behind a line that may do anything to what it says. Time is what the reader waits.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use tmcl_link::{Link, LinkError};
use tmcl_tables::{Command, Status};
use tmcl_wire::serial::{checksum, decode_request, encode_reply, encode_version_string};
use tmcl_wire::{Reply, Request};

/// What happens to one request or to its reply.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Nothing.
    None,
    /// The request does not arrive.
    LoseRequest,
    /// The request arrives with a wrong checksum, and the module complains after this time.
    SpoilRequest(Duration),
    /// The reply does not arrive.
    LoseReply,
    /// One bit of the reply is wrong.
    FlipBit(usize),
    /// One byte of the reply is missing.
    DropByte(usize),
    /// The reply comes later, and so do those that follow.
    Delay(Duration),
    /// Bytes come before the reply.
    Noise(Vec<u8>),
    /// A reply from another module, or to another host, comes before.
    Foreign(u8, u8),
    /// The second reply to command 138 comes before.
    Event,
}

/// A TMCM-1311 as far as a host can tell.
#[derive(Debug)]
pub(crate) struct FakeModule {
    pub address: u8,
    pub host: u8,
    pub faults: VecDeque<Fault>,
    /// Everything that was executed, in order.
    pub executed: Vec<Request>,
    pub parameters: BTreeMap<u8, i32>,
    pub memory: Vec<[u8; 7]>,
    pub download: Option<usize>,
    pub protected: bool,
    pub mode: u8,
    pub counter: u32,
    /// How long readers have waited.
    pub now: Duration,
    /// What is on the line, with when it arrives.
    pub line: VecDeque<(Duration, u8)>,
}

impl Default for FakeModule {
    /// Every axis parameter holds a value of its own.
    fn default() -> Self {
        Self {
            address: 1,
            host: 2,
            faults: VecDeque::new(),
            executed: Vec::new(),
            parameters: (0..=254).map(|number| (number, value_of(number))).collect(),
            memory: vec![[Command::Stop.number(), 0, 0, 0, 0, 0, 0]; 64],
            download: None,
            protected: false,
            mode: 0,
            counter: 0,
            now: Duration::ZERO,
            line: VecDeque::new(),
        }
    }
}

/// What an axis parameter of the fake module holds at first.
pub(crate) fn value_of(number: u8) -> i32 {
    0x0102_0600 + i32::from(number)
}

impl FakeModule {
    /// The default module; the first requests meet these faults, one each.
    pub(crate) fn with_faults(faults: impl IntoIterator<Item = Fault>) -> Self {
        Self { faults: faults.into_iter().collect(), ..Self::default() }
    }

    /// How often a command was executed.
    pub(crate) fn count(&self, command: Command) -> usize {
        self.executed.iter().filter(|request| request.command == command.number()).count()
    }

    fn say(&mut self, bytes: &[u8], delay: Duration) {
        let last = self.line.back().map_or(Duration::ZERO, |(time, _)| *time);
        let time = last.max(self.now + delay);
        self.line.extend(bytes.iter().map(|byte| (time, *byte)));
    }

    fn answer(&mut self, request: Request) -> Vec<u8> {
        let memory_command = request.command == Command::ReadProgramMemory.number();
        match self.execute(request) {
            Ok(_) if request == Request::new(Command::FirmwareVersion, 0, 0, 0) => {
                encode_version_string(self.host, *b"1311V111").to_vec()
            }
            Ok(_) if memory_command => self.memory_reply(request),
            Ok((status, value)) => self.reply(status, request.command, value),
            Err(status) => self.reply(status, request.command, 0),
        }
    }

    fn reply(&self, status: Status, command: u8, value: i32) -> Vec<u8> {
        encode_reply(self.host, self.address, Reply { status, command, value }).to_vec()
    }

    fn memory_reply(&self, request: Request) -> Vec<u8> {
        let instruction = self.memory[usize::try_from(request.value).expect("it was looked up")];
        let mut bytes = vec![self.host];
        bytes.extend(instruction);
        bytes.push(checksum(&bytes));
        bytes
    }

    fn execute(&mut self, request: Request) -> Result<(Status, i32), Status> {
        if let Some(address) = self.download.filter(|_| !(128..=139).contains(&request.command)) {
            *self.memory.get_mut(address).ok_or(Status::InvalidValue)? = request.to_bytes();
            self.download = Some(address + 1);
            return Ok((Status::Loaded, request.value));
        }
        self.executed.push(request);
        let command = Command::try_from(request.command).map_err(|_| Status::InvalidCommand)?;
        Ok((Status::Ok, self.value(command, request)?))
    }

    fn value(&mut self, command: Command, request: Request) -> Result<i32, Status> {
        let Request { kind, value, .. } = request;
        let address = usize::try_from(value).ok().filter(|address| *address < self.memory.len());
        match command {
            Command::GetAxisParameter => return self.parameters.get(&kind).copied().ok_or(Status::WrongType),
            Command::SetAxisParameter => *self.parameters.get_mut(&kind).ok_or(Status::WrongType)? = value,
            Command::DownloadStart if self.protected => return Err(Status::NotAvailable),
            Command::DownloadStart => self.download = Some(address.ok_or(Status::InvalidValue)?),
            Command::DownloadEnd => self.download = None,
            Command::ReadProgramMemory => drop(address.ok_or(Status::InvalidValue)?),
            Command::FirmwareVersion => return Ok(0x051F_010B),
            Command::ApplicationStatus => {
                return Ok(i32::from(self.mode) << 24 | self.counter.cast_signed());
            }
            _ => self.control(command, request),
        }
        Ok(value)
    }

    fn control(&mut self, command: Command, request: Request) {
        match command {
            Command::ApplicationRun => {
                self.mode = 1;
                if request.kind == 1 {
                    self.counter = request.value.cast_unsigned();
                }
            }
            Command::ApplicationStop => self.mode = 0,
            Command::ApplicationStep => (self.mode, self.counter) = (2, self.counter + 1),
            Command::ApplicationReset => (self.mode, self.counter) = (3, 0),
            _ => {}
        }
    }

    fn say_with_fault(&mut self, mut reply: Vec<u8>, fault: Fault) {
        let mut delay = Duration::ZERO;
        match fault {
            Fault::None | Fault::LoseRequest => {}
            Fault::LoseReply => reply.clear(),
            Fault::FlipBit(bit) => reply[bit / 8 % 9] ^= 1 << (bit % 8),
            Fault::DropByte(index) => drop(reply.remove(index % 9)),
            Fault::Delay(duration) | Fault::SpoilRequest(duration) => delay = duration,
            Fault::Noise(noise) => self.say(&noise, delay),
            Fault::Foreign(host, module) => {
                let foreign = Reply { status: Status::Ok, command: 6, value: 77 };
                self.say(&encode_reply(host, module, foreign), delay);
            }
            Fault::Event => {
                let event = self.reply(Status::Delayed, Command::RequestPositionReachedEvent.number(), 1);
                self.say(&event, delay);
            }
        }
        self.say(&reply, delay);
    }
}

impl Link for FakeModule {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let datagram = bytes.try_into().expect("a host writes whole datagrams");
        let (address, request) = decode_request(datagram).expect("a host knows how to add");
        let fault = self.faults.pop_front().unwrap_or(Fault::None);
        if address != self.address || fault == Fault::LoseRequest {
            return Ok(());
        }
        let reply = match fault {
            Fault::SpoilRequest(_) => self.reply(Status::WrongChecksum, 0, 0),
            _ => self.answer(request),
        };
        self.say_with_fault(reply, fault);
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        match self.line.front() {
            Some((time, _)) if *time <= self.now + timeout => self.now = self.now.max(*time),
            _ => {
                self.now += timeout;
                return Ok(0);
            }
        }
        let arrived = self.line.iter().take_while(|(time, _)| *time <= self.now).count();
        let length = arrived.min(buffer.len());
        for (slot, (_, byte)) in buffer.iter_mut().zip(self.line.drain(..length)) {
            *slot = byte;
        }
        Ok(length)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        self.line.retain(|(time, _)| *time > self.now);
        Ok(())
    }
}
