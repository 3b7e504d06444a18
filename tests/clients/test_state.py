"""`tmcl serve --state`: what is stored outlives the process, however it ends."""

from __future__ import annotations

import json
import random
import subprocess
import termios
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from harness import PATIENCE_S, Port, Server, binary, datagram, wait_for
from pytrinamic.modules import TMCM1311, TMCM1640
from pytrinamic.tmcl import TMCLCommand

VARIABLES = 2

#: Kills of one server after the other, each within so many seconds of its first store.
KILLS = 30
LONGEST_LIFE_S = 0.03

#: `tmcl --help`, "Exit codes".
EXIT_USAGE, EXIT_CONNECTION = 2, 3


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder for --state that is not there yet."""
    return tmp_path / "state"


def kept(folder: Path) -> dict[str, int]:
    """What `tmcl state` says is stored."""
    command = [str(binary()), "state", str(folder), "--json"]
    output = subprocess.run(command, capture_output=True, text=True, check=True, timeout=PATIENCE_S).stdout
    [image] = json.loads(output)
    return {record["id"]: record["value"] for record in image["records"]}


def refused(*arguments: str) -> tuple[int, str]:
    """Exit code and message of a server that does not start."""
    command = [str(binary()), "serve", *arguments, "--tcp", "127.0.0.1:0"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)
    assert ended.stdout == ""
    return ended.returncode, ended.stderr


class Counter:
    """Stores ever larger values in some variables, and knows which were sent and which acknowledged."""

    def __init__(self) -> None:
        self.sent = dict.fromkeys(range(4), 0)
        self.acknowledged = dict(self.sent)

    def count_until_killed(self, server: Server, port: Port, life_s: float) -> None:
        """Counts until the line breaks, since the server is killed then."""
        killer = threading.Timer(life_s, server.kill)
        with port.open_raw() as line:
            killer.start()
            try:
                while all(self._count(line, number) for number in self.sent):
                    pass
            except (OSError, termios.error):
                pass
            killer.join()

    def _count(self, line: object, number: int) -> bool:
        self.sent[number] += 1
        line.write(datagram(TMCLCommand.SGP, number, VARIABLES, self.sent[number]))
        line.write(datagram(TMCLCommand.STGP, number, VARIABLES))
        replies = line.read(18)
        if len(replies) < 18:
            return False
        assert (replies[2], replies[11]) == (100, 100)
        self.acknowledged[number] = self.sent[number]
        return True

    def check(self, port: Port) -> None:
        """Every variable has the value that was acknowledged last, or the one that was under way."""
        with port.connect() as connection:
            for number, acknowledged in self.acknowledged.items():
                found = connection.get_global_parameter(number, VARIABLES)
                assert found in (acknowledged, self.sent[number]), f"variable {number}"
                self.sent[number] = self.acknowledged[number] = found


@pytest.mark.parametrize("transport", ["tcp", "pty"])
def test_a_kill_at_any_moment(
    serve: Callable[..., Server], folder: Path, link: str, transport: str
) -> None:
    """What was acknowledged is there, what was under way is old or new, and nothing else is disturbed."""
    rng = random.Random(7)
    counter = Counter()
    place = {"tcp": "127.0.0.1:0", "pty": link}[transport]

    def start() -> Server:
        return serve(f"--{transport}", place, "--state", str(folder))

    server = start()
    with server.port(transport).connect() as connection:
        TMCM1311(connection).motors[0].set_axis_parameter(4, 1234)
        connection.store_axis_parameter(4, 0)
    server.kill()
    for _ in range(KILLS):
        server = start()
        port = server.port(transport)
        counter.check(port)
        counter.count_until_killed(server, port, rng.uniform(0, LONGEST_LIFE_S))
        assert "damaged" not in server.stderr()
    server = start()
    counter.check(server.port(transport))
    with server.port(transport).connect() as connection:
        assert connection.get_axis_parameter(4, 0) == 1234
    assert sum(counter.acknowledged.values()) > KILLS
    stored = kept(folder)
    assert {stored[f"variable.{number}"] for number in counter.sent} == set(counter.acknowledged.values())


@pytest.mark.parametrize(("name", "module"), [("tmcm-1311", TMCM1311), ("tmcm-1640", TMCM1640)])
def test_stored_is_there_again(serve: Callable[..., Server], folder: Path, name: str, module: type) -> None:
    """By STAP with the stock client; and what was only set is not."""
    arguments = ("--tcp", "127.0.0.1:0", "--state", str(folder))
    server = serve(*arguments, module=name)
    with server.port("tcp").connect() as connection:
        motor = module(connection).motors[0]
        for value in (1111, 2222):
            motor.set_axis_parameter(motor.AP.MaxVelocity, value)
            if value == 1111:
                connection.store_axis_parameter(motor.AP.MaxVelocity, 0)
        # The file has it before anybody is told.
        assert 1111 in kept(folder).values()
    assert server.stop() == 0
    assert f"note: m1 is kept in {folder}: 8 bytes written, 8 since its EEPROM was new" in server.stderr()
    server = serve(*arguments, module=name)
    with server.port("tcp").connect() as connection:
        motor = module(connection).motors[0]
        assert motor.get_axis_parameter(motor.AP.MaxVelocity) == 1111


def test_one_server_at_a_time(serve: Callable[..., Server], folder: Path) -> None:
    """The lock goes with the process, however it ends."""
    server = serve("--tcp", "127.0.0.1:0", "--state", str(folder))
    file = folder / "m1.eeprom"
    code, message = refused("tmcm-1311", "--state", str(folder))
    assert (code, message) == (
        EXIT_CONNECTION,
        f"error: {file} is in use by another process; end that, or name another folder\n",
    )
    server.kill()
    image = file.read_bytes()
    code, message = refused("tmcm-1640", "--state", str(folder))
    assert code == EXIT_USAGE
    assert f'{file} is the EEPROM of a tmcm-1311, and "m1" is a tmcm-1640' in message
    assert file.read_bytes() == image
    serve("--tcp", "127.0.0.1:0", "--state", str(folder))


def test_a_damaged_image_is_kept_aside(serve: Callable[..., Server], folder: Path) -> None:
    """The module starts with factory settings, and says why."""
    folder.mkdir()
    file = folder / "m1.eeprom"
    for aside in ("m1.eeprom.corrupt", "m1.eeprom.corrupt.1", "m1.eeprom.corrupt.2"):
        file.write_text(f"not an image, and not the same as before {aside}")
        server = serve("--tcp", "127.0.0.1:0", "--state", str(folder))
        message = f'{file} is damaged: at byte 0: it does not begin with "OpenTMCL"; it is {folder / aside} now'
        wait_for(lambda: message in server.stderr(), "what is wrong with it")
        server.kill()
        assert aside in (folder / aside).read_text()
        assert len(file.read_bytes()) == 67584
    assert sorted(path.name for path in folder.iterdir())[0] == "m1.eeprom", "no temporary file is left"
