//! One request and its reply.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use tmcl_link::{Link, LinkError};
use tmcl_tables::{Command, ModuleSpec, Status};
use tmcl_wire::serial::{DATAGRAM_LENGTH, encode_request};
use tmcl_wire::{Reply, Request};

use crate::answer::{Answer, Question};
use crate::exchange::Exchange;
use crate::finder::{Finder, Verdict};
use crate::repeat::is_repeat_safe;
use crate::version;
use crate::{ClientError, Heard};

/// Bytes that may come before a reply. A line that never falls silent must not keep us for ever.
const NOISE_LIMIT: usize = 1024;

/// Who talks to whom, and how patiently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The module's address, global parameter 66; 1 from the factory.
    pub module_address: u8,
    /// The address that the module sends its replies to, global parameter 76; 2 from the factory.
    pub host_address: u8,
    /// How long the line may be silent before a reply is given up. More than 100 ms, so that a module that missed a byte
    /// forgets the rest of the datagram (decision).
    pub timeout: Duration,
    /// How often a request is sent again when no reply came and the tables say that doing it twice does no harm.
    pub retries: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { module_address: 1, host_address: 2, timeout: Duration::from_secs(1), retries: 2 }
    }
}

/// A host that talks to one module at a time: [`Client::settings_mut`] turns it to another on the same bus.
///
/// A reply does not say which of two like requests it answers. So when a reply failed to come in time, the next request
/// waits until it is certain that it will not come any more: the module is asked something else, and answers in order. Where
/// nobody answers at all, that costs three timeouts before each request.
#[derive(Debug)]
pub struct Client<L> {
    link: L,
    settings: Settings,
    /// Which module is at an address, where that is known.
    modules: BTreeMap<u8, &'static ModuleSpec>,
    /// Replies that may still come: the address of the module, and the command.
    owed: BTreeSet<(u8, u8)>,
    /// The addresses of modules that may be in download mode.
    downloading: BTreeSet<u8>,
    last: Option<Exchange>,
}

impl<L: Link> Client<L> {
    /// A host with the factory's addresses, a timeout of one second and two retries.
    #[must_use]
    pub fn new(link: L) -> Self {
        Self::with_settings(link, Settings::default())
    }

    /// A host with other settings.
    #[must_use]
    pub fn with_settings(link: L, settings: Settings) -> Self {
        Self {
            link,
            settings,
            modules: BTreeMap::new(),
            owed: BTreeSet::new(),
            downloading: BTreeSet::new(),
            last: None,
        }
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Changes settings, as after giving the module another address.
    pub fn settings_mut(&mut self) -> &mut Settings {
        &mut self.settings
    }

    /// The tables of the module at the address at hand, once [`Client::firmware_version`] or [`Client::set_module`] told which
    /// it is.
    #[must_use]
    pub fn module(&self) -> Option<&'static ModuleSpec> {
        self.modules.get(&self.settings.module_address).copied()
    }

    /// Says which module is at the address at hand: its tables then say which requests may be sent again there.
    pub fn set_module(&mut self, module: Option<&'static ModuleSpec>) {
        let address = self.settings.module_address;
        match module {
            Some(module) => self.modules.insert(address, module),
            None => self.modules.remove(&address),
        };
    }

    /// What went over the line for the last request; nothing before the first. A client that makes certain of what is owed
    /// to it asks on its own account, and does not tell.
    #[must_use]
    pub fn last_exchange(&self) -> Option<&Exchange> {
        self.last.as_ref()
    }

    /// The link, to look at.
    #[must_use]
    pub fn link(&self) -> &L {
        &self.link
    }

    /// The link.
    pub fn link_mut(&mut self) -> &mut L {
        &mut self.link
    }

    /// The link, for something else.
    #[must_use]
    pub fn into_link(self) -> L {
        self.link
    }

    /// Sends a request and returns its reply, which has status 100, or 101 in download mode.
    ///
    /// Not for requests whose replies have another form or do not come: 134 ([`Client::read_program_instruction`]), 136
    /// type 0 ([`Client::version_string`]), 137 and 255 ([`Client::send`]).
    ///
    /// # Errors
    /// [`ClientError::Status`] when the module refuses, [`ClientError::NoReply`] when nothing came that could be read; then
    /// it is not known whether the module executed the command. [`ClientError::Link`] when the link is broken.
    pub fn request(&mut self, request: Request) -> Result<Reply, ClientError> {
        self.exchange(request, Question::reply)
    }

    /// Sends a request and does not wait for a reply.
    ///
    /// # Errors
    /// [`ClientError::Link`] when the link is broken.
    pub fn send(&mut self, request: Request) -> Result<(), ClientError> {
        self.owe(request.command);
        self.begin(Exchange::new(request, encode_request(self.settings.module_address, request)));
        Ok(self.write_begun()?)
    }

    /// Sends a request that must be executed, not stored, and returns the reply's value.
    pub(crate) fn execute(
        &mut self,
        command: Command,
        kind: u8,
        motor: u8,
        value: i32,
    ) -> Result<i32, ClientError> {
        let request = Request::new(command, kind, motor, value);
        match self.request(request)? {
            Reply { status: Status::Loaded, .. } => Err(ClientError::Stored { request }),
            reply => Ok(reply.value),
        }
    }

    /// Sends a request, as often as it takes and is safe, and returns what `judge` makes of the reply.
    pub(crate) fn exchange<T>(
        &mut self,
        request: Request,
        judge: impl Fn(Question, [u8; DATAGRAM_LENGTH]) -> Verdict<Answer<T>>,
    ) -> Result<T, ClientError> {
        self.settle()?;
        self.begin(Exchange::new(request, encode_request(self.settings.module_address, request)));
        let module = self.settings.module_address;
        let was_downloading = self.downloading.contains(&module);
        if request.command == Command::DownloadStart.number() {
            self.downloading.insert(module);
        }
        let attempts = self.attempts(request);
        let mut attempt = 1;
        let outcome = loop {
            let outcome = self.attempt(request, &judge)?;
            let spoiled = matches!(outcome, Err(_) | Ok(Answer::Refused(Status::WrongChecksum)));
            if !spoiled || attempt >= attempts {
                break outcome;
            }
            attempt += 1;
        };
        match outcome {
            Ok(Answer::Done(done)) => {
                if request.command == Command::DownloadEnd.number() {
                    self.downloading.remove(&module);
                }
                Ok(done)
            }
            Ok(Answer::Refused(status)) => {
                if !was_downloading {
                    self.downloading.remove(&module);
                }
                Err(ClientError::Status { request, status })
            }
            Ok(Answer::Unknown(status)) => Err(ClientError::UnknownStatus { request, status }),
            Err(heard) => {
                let timeout = self.settings.timeout;
                Err(ClientError::NoReply { request, timeout, attempts: attempt, heard })
            }
        }
    }

    fn attempts(&self, request: Request) -> u32 {
        if is_repeat_safe(self.module(), request, self.downloading.contains(&self.settings.module_address)) {
            self.settings.retries.saturating_add(1)
        } else {
            1
        }
    }

    /// Sends a request once. What came in place of an answer is an error that may be mended, a broken link is not.
    fn attempt<T>(
        &mut self,
        request: Request,
        judge: impl Fn(Question, [u8; DATAGRAM_LENGTH]) -> Verdict<Answer<T>>,
    ) -> Result<Result<Answer<T>, Heard>, LinkError> {
        let Settings { host_address: host, module_address: module, .. } = self.settings;
        let question = Question { host, module, request };
        let timeout = self.settings.timeout;
        let answer = self.write_begun().and_then(|()| self.receive(timeout, |bytes| judge(question, bytes)));
        if !matches!(answer, Ok(Ok(_))) {
            self.owe(request.command);
        }
        answer
    }

    /// Remembers that the module's reply to this command may still come.
    fn owe(&mut self, command: u8) {
        self.owe_from(self.settings.module_address, command);
    }

    /// The same of a module at some address.
    pub(crate) fn owe_from(&mut self, address: u8, command: u8) {
        self.owed.insert((address, command));
    }

    /// Whether the module at hand owes a reply to any command; others on the bus are known by their address.
    pub(crate) fn is_owed(&self) -> bool {
        self.owed.iter().any(|(module, _)| *module == self.settings.module_address)
    }

    fn forgive(&mut self) {
        let ours = self.settings.module_address;
        self.owed.retain(|(module, _)| *module != ours);
    }

    /// Makes a request the one that goes over the line from now on.
    pub(crate) fn begin(&mut self, exchange: Exchange) {
        self.last = Some(exchange);
    }

    /// Sends the request that was begun, once more.
    pub(crate) fn write_begun(&mut self) -> Result<(), LinkError> {
        self.link.discard_input()?;
        let Some(exchange) = &mut self.last else { return Ok(()) };
        exchange.attempts += 1;
        self.link.write(&exchange.sent)
    }

    /// Waits for an answer while the line is not silent for `timeout`.
    pub(crate) fn receive<T>(
        &mut self,
        timeout: Duration,
        judge: impl Fn([u8; DATAGRAM_LENGTH]) -> Verdict<T>,
    ) -> Result<Result<T, Heard>, LinkError> {
        let mut finder = Finder::default();
        while finder.count() < NOISE_LIMIT {
            let mut buffer = [0; DATAGRAM_LENGTH];
            let (room, _) = buffer.split_at_mut(finder.missing());
            let length = self.link.read(room, timeout)?;
            if length == 0 {
                break;
            }
            let bytes = room.get(..length).unwrap_or(room);
            if let Some(exchange) = &mut self.last {
                exchange.received.extend_from_slice(bytes);
            }
            if let Some(found) = bytes.iter().find_map(|byte| finder.push(*byte, &judge)) {
                if let Some(exchange) = &mut self.last {
                    exchange.answered = true;
                }
                return Ok(Ok(found));
            }
        }
        Ok(Err(finder.heard()))
    }

    /// Makes certain that no reply to an earlier request will be taken for one to the next.
    ///
    /// Modules answer in order. So a reply to a question that nobody has open says that all earlier ones are through. When
    /// there is no such reply either, the line has been silent for several timeouts, and what was owed is given up.
    pub(crate) fn settle(&mut self) -> Result<(), LinkError> {
        for probe in [version::binary(), Request::new(Command::ApplicationStatus, 0, 0, 0)] {
            if !self.is_owed() {
                return Ok(());
            }
            if self.owed.contains(&(self.settings.module_address, probe.command)) {
                continue;
            }
            self.begin(Exchange::new(probe, encode_request(self.settings.module_address, probe)));
            if self.attempt(probe, Question::reply_to_probe)?.is_ok() {
                self.forgive();
            }
        }
        if self.is_owed() {
            let _ = self.receive(self.settings.timeout, |_| Verdict::<()>::Noise)?;
            self.forgive();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
