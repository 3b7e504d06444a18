"""Starts `tmcl serve` or a module on an emulated chip and names its ports; what the fixtures and the tests share."""

from __future__ import annotations

import importlib.metadata
import os
import queue
import re
import signal
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import serial
from pytrinamic.connections import ConnectionManager
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.tmcl import TMCLCommand, TMCLReplyStatusError, TMCLRequest

REPOSITORY = Path(__file__).resolve().parents[2]

#: Long enough for a busy machine. No test waits for it unless something is broken.
PATIENCE_S = 20.0

#: Command 136, type 1: module number, major and minor version (decisions §1.5).
VERSION_NUMBER = 0x051F_010B

INTERFACES = {"tcp": "socket_serial_tmcl", "pty": "serial_tmcl", "slcan": "slcan_tmcl"}

LISTENING = re.compile(r"listening (tcp|pty|slcan) (\S+)")


def binary() -> Path:
    """The program under test: environment variable TMCL, or the release build."""
    path = Path(os.environ.get("TMCL", REPOSITORY / "target/release/tmcl"))
    if not path.is_file():
        pytest.exit(f"{path} does not exist: `cargo build --release`, or set TMCL to the binary", returncode=3)
    return path.resolve()


def stock_files(beginning: str) -> list[importlib.metadata.PackagePath]:
    """The Python files of PyTrinamic's wheel whose path in it begins like this."""
    files = importlib.metadata.files("pytrinamic") or []
    return [file for file in files if file.suffix == ".py" and file.as_posix().startswith(beginning)]


@dataclass(frozen=True)
class Port:
    """One port of a running server, as its `listening` line names it."""

    transport: str
    place: str

    def arguments(self) -> str:
        """What a user of PyTrinamic passes to a script."""
        return f"--interface {INTERFACES[self.transport]} --port {self.place}"

    def connect(self, more: str = "") -> TmclInterface:
        """Connects the stock client."""
        return ConnectionManager(f"{self.arguments()} {more}").connect()

    def address(self) -> tuple[str, int]:
        """Host and port of a TCP port."""
        host, _, number = self.place.rpartition(":")
        return host, int(number)

    def open_raw(self) -> Raw:
        """Opens the port without a client, for bytes that no client would send."""
        return Raw(self)


class Raw:
    """Bytes to and from a port, without PyTrinamic."""

    def __init__(self, port: Port) -> None:
        self._line: socket.socket | serial.Serial
        if port.transport == "tcp":
            self._line = socket.create_connection(port.address(), timeout=PATIENCE_S)
            self._line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        else:
            self._line = serial.Serial(port.place, timeout=PATIENCE_S)

    def __enter__(self) -> Raw:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def write(self, data: bytes) -> None:
        """Sends all of it and, on a pseudo terminal, waits until it has left."""
        if isinstance(self._line, socket.socket):
            self._line.sendall(data)
        else:
            self._line.write(data)
            self._line.flush()

    def read(self, count: int) -> bytes:
        """Reads exactly so many bytes; fewer when they do not come."""
        if isinstance(self._line, serial.Serial):
            return self._line.read(count)
        data = b""
        while len(data) < count and (more := self._line.recv(count - len(data))):
            data += more
        return data

    def fill(self, data: bytes, at_most: int) -> int:
        """Writes `data` again and again without ever reading, until the line takes no more or `at_most` bytes went."""
        descriptor = self._line.fileno()
        os.set_blocking(descriptor, False)
        written = refusals = 0
        # A line that refuses for a while is full for good: its other end waits for us to read.
        while written < at_most and refusals < 20:
            try:
                written += os.write(descriptor, data[written % len(data) :])
                refusals = 0
            except BlockingIOError:
                refusals += 1
                time.sleep(0.005)
        return written

    def close(self, *, reset: bool = False) -> None:
        """Hangs up; with `reset` as a program does that crashes with replies unread (TCP only)."""
        if reset and isinstance(self._line, socket.socket):
            linger_not = b"\x01\x00\x00\x00\x00\x00\x00\x00"
            self._line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger_not)
        self._line.close()


class Server:
    """A running `tmcl serve`, with one module or several, `tmcm-1311@1 tmcm-1640@2`."""

    def __init__(self, *arguments: str, module: str = "tmcm-1311") -> None:
        self._stderr = tempfile.TemporaryFile()
        self._process = subprocess.Popen(
            self._command(module, arguments), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self._stderr, text=True
        )
        self._lines: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=self._read_lines, daemon=True).start()
        self.ports: list[Port] = []
        try:
            for _ in range(sum(argument in ("--tcp", "--pty", "--slcan") for argument in arguments)):
                self.ports.append(self._next_port())
        except BaseException:
            self.kill()
            raise

    def _command(self, module: str, arguments: tuple[str, ...]) -> list[str]:
        return [str(binary()), "serve", *module.split(), *arguments]

    def port(self, transport: str, index: int = 0) -> Port:
        """The port of this kind that was announced as number `index` among its kind."""
        return [port for port in self.ports if port.transport == transport][index]

    def is_running(self) -> bool:
        """Whether the process is still there."""
        return self._process.poll() is None

    def stop(self, how: signal.Signals = signal.SIGTERM) -> int:
        """Asks the server to end and returns its exit code."""
        self._process.send_signal(how)
        try:
            return self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.kill()
            pytest.fail(f"the server ignores {how.name}\n{self.stderr()}")

    def kill(self) -> None:
        """Ends the server without asking."""
        self._process.kill()
        self._process.wait(PATIENCE_S)

    def stderr(self) -> str:
        """What the server printed on stderr so far."""
        return os.pread(self._stderr.fileno(), 1 << 20, 0).decode(errors="replace")

    def rest_of_stdout(self) -> list[str]:
        """What an ended server printed on stdout after its `listening` lines."""
        return list(iter(lambda: self._lines.get(timeout=PATIENCE_S), None))

    def _read_lines(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.put(line.rstrip("\n"))
        self._lines.put(None)

    def _next_port(self) -> Port:
        try:
            line = self._lines.get(timeout=PATIENCE_S)
        except queue.Empty:
            pytest.fail(f"no `listening` line (is stdout flushed?)\n{self.stderr()}")
        match = LISTENING.fullmatch(line or "")
        if match is None:
            pytest.fail(f"expected a `listening` line, got {line!r}\n{self.stderr()}")
        return Port(*match.groups())


class EmulatedChip(Server):
    """A module on an emulated chip, which is announced as a server is."""

    def _command(self, module: str, arguments: tuple[str, ...]) -> list[str]:
        path = Path(os.environ.get("EMULATED_MODULE", REPOSITORY / "target/system-tests/emulated-module"))
        if not path.is_file():
            pytest.fail(f"{path} does not exist: `cargo xtask firmware`, and build it or set EMULATED_MODULE")
        return [str(path.resolve()), module, *arguments]


def wait_for(condition: Callable[[], Any], what: str) -> Any:
    """Polls, as clients do, until `condition` returns something true, and returns it."""
    deadline = time.monotonic() + PATIENCE_S
    while not (value := condition()):
        if time.monotonic() > deadline:
            pytest.fail(f"waited {PATIENCE_S:.0f} s in vain: {what}")
        time.sleep(0.002)
    return value


def status_of(call: Callable[..., Any], *arguments: Any) -> int:
    """The status with which the module refuses what the client is asked to send."""
    with pytest.raises(TMCLReplyStatusError) as refusal:
        call(*arguments)
    reply = refusal.value.reply
    assert reply.value == 0, "a refusal has the value 0 (decisions §1.4)"
    return reply.status


def assert_in_step(connection: TmclInterface) -> None:
    """The next request gets its own reply: nothing is left over and nothing is missing."""
    reply = connection.send(TMCLCommand.GET_FIRMWARE_VERSION, 1, 0, 0)
    assert (reply.status, reply.command, reply.value) == (100, 136, VERSION_NUMBER)
    assert (reply.reply_address, reply.module_address) == (2, 1)


def datagram(command: int, kind: int = 0, motor: int = 0, value: int = 0, *, address: int = 1) -> bytes:
    """The bytes that the client would send."""
    return bytes(TMCLRequest(address, command, kind, motor, value).to_buffer())
