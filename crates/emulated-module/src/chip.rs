//! QEMU with an image of the firmware, and its harness.

use std::ffi::OsString;
use std::fs;
use std::io::{self, Read, Write};
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::play::Target;
use crate::session::Act;

/// The emulator's program.
pub const QEMU: &str = "qemu-system-arm";

/// How long the chip may be silent before it is given up: it computes for long, but never so long.
const PATIENCE: Duration = Duration::from_secs(300);

/// Cycles of the 25 MHz clock are 40 ns.
const CYCLE_NS: u64 = 40;

/// What can go wrong with an emulated chip.
#[derive(Debug, thiserror::Error)]
pub enum EmulatorError {
    /// QEMU is not there.
    #[error(
        "cannot start {QEMU}: {0}; `apt-get install qemu-system-arm` (Debian, Ubuntu), `brew install qemu` (macOS)"
    )]
    Missing(io::Error),
    /// A file cannot be made or read.
    #[error("{path}: {error}", path = .0.display(), error = .1)]
    File(PathBuf, io::Error),
    /// It did not start, went away, or is silent.
    #[error("the emulated chip does not answer: {0}")]
    Silent(io::Error),
    /// It said what the harness does not know.
    #[error("the emulated chip answers {0:#04x}, which is no answer of its harness")]
    Answer(u8),
}

/// How QEMU counts time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counting {
    /// By the host's clock: fast.
    Clock,
    /// By instructions: exact, and the same on every run.
    Instructions,
}

impl Counting {
    /// With instructions counted, each takes 2¹⁰ ns of the emulated clock, so that none is shorter than a cycle.
    const SHIFT: u64 = 10;
}

/// Instructions that control periods and bytes took; cycles where they are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured {
    /// Control periods that were gone through one by one.
    pub periods: u32,
    /// The mean.
    pub mean: u64,
    /// The longest.
    pub longest: u64,
    /// The tick of the longest.
    pub longest_at: u32,
    /// The longest that a byte took, with the request that it completed.
    pub longest_byte: u64,
    /// The longest that a step of work in the background took: reading or writing the storage.
    pub longest_work: u64,
}

/// Bytes of stack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stack {
    /// Ever used.
    pub used: u32,
    /// There are.
    pub size: u32,
}

/// A module on an emulated chip. Dropping it pulls the plug, and so does the end of the thread that started it, where
/// `setpriv` is to be had.
pub struct EmulatedChip {
    qemu: Child,
    harness: UnixStream,
    socket: PathBuf,
    counting: Counting,
    tick: u64,
}

impl EmulatedChip {
    /// Starts an image whose flash and EEPROM are kept in a file, which is made if there is none.
    ///
    /// # Errors
    /// [`EmulatorError`] where QEMU is missing or the image does not start.
    pub fn start(image: &Path, memory: &Path, counting: Counting) -> Result<Self, EmulatorError> {
        let socket = memory.with_extension("harness");
        let _ = fs::remove_file(&socket);
        let failure = |error| EmulatorError::File(socket.clone(), error);
        let listener = UnixListener::bind(&socket).map_err(failure)?;
        listener.set_nonblocking(true).map_err(failure)?;
        let mut qemu = command(image, memory, counting)
            .args(["-serial", "null", "-serial"])
            .arg(option("unix:", &socket))
            .stdin(Stdio::null())
            .spawn()
            .map_err(EmulatorError::Missing)?;
        let harness = accept(&listener, &mut qemu).inspect_err(|_| drop(qemu.kill()))?;
        harness
            .set_nonblocking(false)
            .and_then(|()| harness.set_read_timeout(Some(PATIENCE)))
            .map_err(failure)?;
        Ok(Self { qemu, harness, socket, counting, tick: 0 })
    }

    /// What control periods took since this was last asked.
    ///
    /// # Errors
    /// [`EmulatorError`] where the chip does not answer.
    pub fn measure(&mut self) -> Result<Measured, EmulatorError> {
        let [periods, total, longest, longest_at, longest_byte, longest_work] = self.numbers(b'M')?;
        let count = |cycles: u32| match self.counting {
            Counting::Clock => cycles.into(),
            Counting::Instructions => {
                (u64::from(cycles) * CYCLE_NS + (1 << (Counting::SHIFT - 1))) >> Counting::SHIFT
            }
        };
        Ok(Measured {
            periods,
            mean: count(total) / u64::from(periods.max(1)),
            longest: count(longest),
            longest_at,
            longest_byte: count(longest_byte),
            longest_work: count(longest_work),
        })
    }

    /// How deep the stack has ever been.
    ///
    /// # Errors
    /// [`EmulatorError`] where the chip does not answer.
    pub fn stack(&mut self) -> Result<Stack, EmulatorError> {
        let [used, size] = self.numbers(b'K')?;
        Ok(Stack { used, size })
    }

    /// Lets bytes arrive and does not wait for what becomes of them: the plug may be pulled meanwhile.
    ///
    /// # Errors
    /// [`EmulatorError`] where the chip does not listen.
    pub fn send(&mut self, port: u8, bytes: &[u8]) -> Result<(), EmulatorError> {
        let mut command = vec![b'D', port, u8::try_from(bytes.len()).unwrap_or(u8::MAX)];
        command.extend(bytes.iter().take(usize::from(u8::MAX)));
        self.harness.write_all(&command).map_err(EmulatorError::Silent)
    }

    /// Waits for what becomes of [`EmulatedChip::send`].
    ///
    /// # Errors
    /// [`EmulatorError`] where the chip does not answer.
    pub fn answers(&mut self, left: &mut Vec<(u64, u8, Vec<u8>)>) -> Result<(), EmulatorError> {
        loop {
            let [letter] = self.read()?;
            match letter {
                b'O' => {
                    let tick = u64::from_le_bytes(self.read()?);
                    let [port, length] = self.read()?;
                    let mut bytes = vec![0; usize::from(length)];
                    self.harness.read_exact(&mut bytes).map_err(EmulatorError::Silent)?;
                    left.push((tick, port, bytes));
                }
                b'A' => {
                    self.tick = u64::from_le_bytes(self.read()?);
                    return Ok(());
                }
                other => return Err(EmulatorError::Answer(other)),
            }
        }
    }

    fn command(&mut self, command: &[u8], left: &mut Vec<(u64, u8, Vec<u8>)>) -> Result<(), EmulatorError> {
        self.harness.write_all(command).map_err(EmulatorError::Silent)?;
        self.answers(left)
    }

    fn numbers<const N: usize>(&mut self, letter: u8) -> Result<[u32; N], EmulatorError> {
        self.harness.write_all(&[letter]).map_err(EmulatorError::Silent)?;
        let [found] = self.read()?;
        if found != letter {
            return Err(EmulatorError::Answer(found));
        }
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = u32::from_le_bytes(self.read()?);
        }
        self.answers(&mut Vec::new())?;
        Ok(numbers)
    }

    fn read<const N: usize>(&mut self) -> Result<[u8; N], EmulatorError> {
        let mut bytes = [0; N];
        self.harness.read_exact(&mut bytes).map_err(EmulatorError::Silent)?;
        Ok(bytes)
    }
}

impl Drop for EmulatedChip {
    /// As a power cut: nothing is said to the module before.
    fn drop(&mut self) {
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
        let _ = fs::remove_file(&self.socket);
    }
}

/// QEMU with an image and its memory; its serial lines are for the caller to say.
pub(crate) fn command(image: &Path, memory: &Path, counting: Counting) -> Command {
    let mut command = emulator();
    command
        .args(["-machine", "mps2-an385,memory-backend=psram", "-object"])
        .arg(option("memory-backend-file,id=psram,size=16M,share=on,mem-path=", memory))
        .args(["-display", "none", "-monitor", "none", "-kernel"])
        .arg(image);
    if counting == Counting::Instructions {
        command.args(["-icount", &format!("shift={},sleep=off", Counting::SHIFT)]);
    }
    command
}

/// An option whose last value is a path. A comma ends a value, and two are one that belongs to it.
fn option(text: &str, path: &Path) -> OsString {
    let mut option = text.as_bytes().to_vec();
    for byte in path.as_os_str().as_bytes() {
        option.extend(std::iter::repeat_n(*byte, if *byte == b',' { 2 } else { 1 }));
    }
    OsString::from_vec(option)
}

/// QEMU, which ends with the thread that starts it, however that ends, where the system can do so.
///
/// `setpriv` asks the kernel for that and becomes QEMU: same process, same handles. A QEMU that is not there is started all
/// the same, so that it is the system which says that it is missing.
fn emulator() -> Command {
    static CAN_END_WITH_US: OnceLock<bool> = OnceLock::new();
    let Some(qemu) = found(QEMU) else { return Command::new(QEMU) };
    if !*CAN_END_WITH_US.get_or_init(can_end_with_us) {
        return Command::new(qemu);
    }
    let mut command = Command::new(SETPRIV[0]);
    command.args(&SETPRIV[1..]).arg(qemu);
    command
}

/// Of util-linux; others have the name, but not the option.
const SETPRIV: [&str; 3] = ["setpriv", "--pdeathsig", "KILL"];

fn can_end_with_us() -> bool {
    cfg!(target_os = "linux")
        && Command::new(SETPRIV[0])
            .args(&SETPRIV[1..])
            .arg("true")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .is_ok_and(|status| status.success())
}

/// A program on the PATH.
fn found(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(program)).find(|file| {
        file.metadata().is_ok_and(|file| file.is_file() && file.permissions().mode() & 0o111 != 0)
    })
}

/// QEMU connects once it has started; if it ends before, it has said why.
fn accept(listener: &UnixListener, qemu: &mut Child) -> Result<UnixStream, EmulatorError> {
    let started = Instant::now();
    loop {
        match listener.accept() {
            Ok((stream, _)) => return Ok(stream),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => return Err(EmulatorError::Silent(error)),
        }
        if let Ok(Some(status)) = qemu.try_wait() {
            return Err(EmulatorError::Silent(io::Error::other(format!("{QEMU} ended with {status}"))));
        }
        if started.elapsed() > PATIENCE {
            return Err(EmulatorError::Silent(io::ErrorKind::TimedOut.into()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

impl Target for EmulatedChip {
    type Error = EmulatorError;

    fn tick(&self) -> u64 {
        self.tick
    }

    fn run_to(&mut self, tick: u64, left: &mut Vec<(u64, u8, Vec<u8>)>) -> Result<(), EmulatorError> {
        while self.tick < tick {
            let ticks = u32::try_from(tick - self.tick).unwrap_or(u32::MAX);
            let [a, b, c, d] = ticks.to_le_bytes();
            self.command(&[b'T', a, b, c, d], left)?;
        }
        Ok(())
    }

    fn act(&mut self, act: &Act, left: &mut Vec<(u64, u8, Vec<u8>)>) -> Result<(), EmulatorError> {
        match act {
            Act::Arrive(port, bytes) => {
                self.send(*port, bytes)?;
                self.answers(left)
            }
            Act::PowerCycle => self.command(b"P", left),
            Act::Load(torque_nm) => {
                let mut command = vec![b'L'];
                command.extend(torque_nm.to_le_bytes());
                self.command(&command, left)
            }
            Act::Input(number, high) => self.command(&[b'I', *number, u8::from(*high)], left),
            Act::Leave(..) | Act::End => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::OsStr;

    use super::*;

    #[test]
    fn a_comma_of_a_path_ends_no_option() {
        let path = Path::new(OsStr::from_bytes(b"/a,b,,\xff.psram"));
        assert_eq!(option("mem-path=", path).as_bytes(), b"mem-path=/a,,b,,,,\xff.psram");
    }
}
