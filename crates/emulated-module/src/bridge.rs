//! The one line of a chip, and clients at TCP ports and pseudo terminals that take turns at it.
//!
//! What a client sends goes to the chip, and what the chip says goes to the client that sent last. Another client waits until
//! the line was silent for [`TURN`]: so each gets the replies to its own requests and none to another's, as with lines of their
//! own. A client that is gone, or does not read, holds up nobody.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tmcl_server::{Pty, PtyError};

/// How long the line is silent before another client has it.
const TURN: Duration = Duration::from_millis(50);

/// Bytes that are read at once.
const READ_SIZE: usize = 512;

/// Readings that wait for a client that does not read. More are too many.
const QUEUE: usize = 4096;

/// How long a listener waits after a failure.
const RETRY: Duration = Duration::from_millis(100);

/// Clients at the line of a chip. Dropping it hangs up.
pub struct Bridge {
    line: Arc<Line>,
    listeners: Vec<SocketAddr>,
    ptys: Vec<Pty>,
}

impl Bridge {
    /// The chip's end of the line is the other one of `chip`. `ended` is called when the chip has gone.
    ///
    /// # Errors
    /// The system's, when it has no further handle.
    pub fn start(chip: UnixStream, ended: impl FnOnce() + Send + 'static) -> io::Result<Self> {
        let mut reader = chip.try_clone()?;
        let line = Arc::new(Line {
            chip,
            turns: Mutex::default(),
            silent: Condvar::new(),
            stopping: AtomicBool::new(false),
        });
        let heard = Arc::clone(&line);
        std::thread::spawn(move || {
            let mut buffer = [0; READ_SIZE];
            while let Some(bytes) = read(&mut reader, &mut buffer) {
                heard.tell(bytes);
            }
            ended();
        });
        Ok(Self { line, listeners: Vec::new(), ptys: Vec::new() })
    }

    /// Listens at `address`, `host:port`; port 0 picks a free one. Returns where it really listens.
    ///
    /// # Errors
    /// The system's, when the address cannot be resolved or bound.
    pub fn listen_tcp(&mut self, address: &str) -> io::Result<SocketAddr> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let line = Arc::clone(&self.line);
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                if line.is_stopping() {
                    return;
                }
                if stream.and_then(|stream| welcome(&line, stream)).is_err() {
                    // Too many open files, say, are still too many a microsecond later.
                    std::thread::sleep(RETRY);
                }
            }
        });
        self.listeners.push(address);
        Ok(address)
    }

    /// Opens a pseudo terminal and links `path` to it.
    ///
    /// # Errors
    /// [`PtyError`] when the path is taken or there is no terminal to be had.
    pub fn listen_pty(&mut self, path: &Path) -> Result<(), PtyError> {
        let (pty, mut reader) = Pty::open(path)?;
        let client = self.line.join(reader.try_clone()?, None);
        let line = Arc::clone(&self.line);
        // The terminal is held open on our side, so this ends when the bridge does.
        std::thread::spawn(move || line.listen_to(client, &mut reader));
        self.ptys.push(pty);
        Ok(())
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.line.stopping.store(true, Ordering::Release);
        // Whoever reads or waits is woken, and sees that it stops.
        let _ = self.line.chip.shutdown(Shutdown::Both);
        for address in &self.listeners {
            let _ = TcpStream::connect(address);
        }
        for (_, client) in std::mem::take(&mut self.line.turns().clients) {
            client.hang_up();
        }
    }
}

/// What the threads share.
struct Line {
    chip: UnixStream,
    turns: Mutex<Turns>,
    /// Told when a client has sent all it had.
    silent: Condvar,
    stopping: AtomicBool,
}

/// Who is there, and whose turn it is.
#[derive(Default)]
struct Turns {
    clients: BTreeMap<u64, Client>,
    joined: u64,
    /// Who sent last; it may have gone, and replies are for nobody then.
    holder: Option<u64>,
    /// It sends.
    sending: bool,
    /// When the line was last used.
    used: Option<Instant>,
}

/// Where what the chip says goes.
struct Client {
    queue: SyncSender<Vec<u8>>,
    /// Hung up where there is somebody to hang up on; a pseudo terminal is for whoever comes.
    stream: Option<TcpStream>,
}

impl Client {
    fn hang_up(self) {
        let _ = self.stream.map(|stream| stream.shutdown(Shutdown::Both));
    }
}

impl Turns {
    /// How long a client has to wait for its turn, if it has to.
    fn wait(&self, client: u64) -> Option<Duration> {
        if self.holder == Some(client) {
            return None;
        }
        if self.sending {
            return Some(TURN);
        }
        TURN.checked_sub(self.used?.elapsed()).filter(|left| !left.is_zero())
    }
}

impl Line {
    fn turns(&self) -> MutexGuard<'_, Turns> {
        // A thread that panicked left plain data behind, which is as good as any.
        self.turns.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_stopping(&self) -> bool {
        self.stopping.load(Ordering::Acquire)
    }

    /// Takes a client in, and starts the thread that writes to it. Returns its number.
    fn join(&self, writer: impl Write + Send + 'static, stream: Option<TcpStream>) -> u64 {
        let (queue, queued) = sync_channel(QUEUE);
        std::thread::spawn(move || write_all(writer, &queued));
        let mut turns = self.turns();
        turns.joined += 1;
        let number = turns.joined;
        turns.clients.insert(number, Client { queue, stream });
        number
    }

    /// What a client sends goes to the chip, until either goes.
    fn listen_to(&self, client: u64, reader: &mut impl Read) {
        let mut buffer = [0; READ_SIZE];
        while let Some(bytes) = read(reader, &mut buffer) {
            self.take_turn(client);
            if self.is_stopping() {
                break;
            }
            // While the chip does not read, this waits; what it says meanwhile goes out.
            let sent = (&self.chip).write_all(bytes);
            let mut turns = self.turns();
            turns.sending = false;
            turns.used = Some(Instant::now());
            drop(turns);
            self.silent.notify_all();
            if sent.is_err() {
                break;
            }
        }
        if let Some(client) = self.turns().clients.remove(&client) {
            client.hang_up();
        }
    }

    fn take_turn(&self, client: u64) {
        let mut turns = self.turns();
        while let Some(left) = turns.wait(client)
            && !self.is_stopping()
        {
            let woken = self.silent.wait_timeout(turns, left);
            turns = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        turns.holder = Some(client);
        turns.sending = true;
    }

    /// What the chip says goes to the client whose turn it is.
    fn tell(&self, bytes: &[u8]) {
        let mut turns = self.turns();
        turns.used = Some(Instant::now());
        let Some(holder) = turns.holder else { return };
        let Some(client) = turns.clients.get(&holder) else { return };
        if client.queue.try_send(bytes.to_vec()).is_err() && client.stream.is_some() {
            // It does not read, and would miss something: better that it knows. At a pseudo terminal nobody may be listening.
            if let Some(client) = turns.clients.remove(&holder) {
                client.hang_up();
            }
        }
    }
}

fn welcome(line: &Arc<Line>, mut stream: TcpStream) -> io::Result<()> {
    // A reply is nine bytes, and the client waits for it.
    stream.set_nodelay(true)?;
    let client = line.join(stream.try_clone()?, Some(stream.try_clone()?));
    let line = Arc::clone(line);
    std::thread::spawn(move || line.listen_to(client, &mut stream));
    Ok(())
}

/// Ends when the client is let go, or cannot be written to; whoever reads from it notices too.
fn write_all(mut writer: impl Write, queued: &Receiver<Vec<u8>>) {
    for bytes in queued {
        if writer.write_all(&bytes).is_err() {
            return;
        }
    }
}

/// What there is to read, and nothing at the end.
fn read<'a>(reader: &mut impl Read, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
    loop {
        match reader.read(buffer) {
            Ok(0) => return None,
            Ok(length) => return buffer.get(..length),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(_) => return None,
        }
    }
}
