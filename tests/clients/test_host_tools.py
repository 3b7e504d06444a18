"""The host commands of `tmcl` against `tmcl serve`, over TCP and over a pseudo terminal."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from harness import Port, Server, datagram, wait_for
from host import CONNECTION, TMCL_STATUS, USAGE, Terminal, notation, tmcl

#: Counts variable 0 up, slowly enough to be looked at.
COUNT = """//! module: tmcm-1311
Loop:
    GGP 0, 2
    CALC ADD, 1
    AGP 0, 2
    WAIT TICKS, 0, 1
    JA Loop
"""

#: Ends by itself; the assembler appends the STOP.
ONCE = "    SGP 1, 2, 4711\n"


@pytest.fixture
def at(port: Port) -> tuple[str, str]:
    """The option that names the port."""
    return "--port", notation(port)


def value(at: tuple[str, str], command: str) -> int:
    """The value of the reply to one command."""
    return json.loads(tmcl("exec", command, "--json", *at).stdout)[0]["value"]


def test_a_program_is_stored_compared_run_and_read_back(at: tuple[str, str], tmp_path: Path) -> None:
    """What comes back is what the assembler made."""
    (tmp_path / "count.tmc").write_text(COUNT)
    assembled = tmcl("asm", "count.tmc", "--symbols", "count.json", folder=tmp_path)
    assert assembled.stderr.startswith("note: 5 instructions")
    done = tmcl("download", "count.tmc", "--verify", "--run", *at, folder=tmp_path)
    assert done.stdout == "" and "5 instructions of 2048 stored, read back and the same" in done.stderr
    wait_for(lambda: value(at, "GGP 0, 2") > 3, "the program counts")
    assert json.loads(tmcl("status", "--json", *at).stdout)["mode"] == "running"
    stopped = tmcl("stop", "--symbols", "count.json", *at, folder=tmp_path).stdout
    assert stopped.startswith("stopped at ") and "count.tmc:" in stopped and "(Loop" in stopped
    tmcl("upload", "-o", "back.bin", *at, folder=tmp_path)
    assert (tmp_path / "back.bin").read_bytes() == (tmp_path / "count.bin").read_bytes()
    (tmp_path / "back.tmc").write_text(tmcl("upload", *at).stdout)
    tmcl("asm", "back.tmc", "-o", "again.bin", folder=tmp_path)
    assert (tmp_path / "again.bin").read_bytes() == (tmp_path / "count.bin").read_bytes()


def test_a_program_is_reset_stepped_and_started(at: tuple[str, str], tmp_path: Path) -> None:
    """Compiled files are taken as they are; the STOP at the end is read back too."""
    (tmp_path / "once.tmc").write_text(ONCE)
    tmcl("asm", "once.tmc", folder=tmp_path)
    tmcl("download", "once.bin", *at, folder=tmp_path)
    assert tmcl("reset", *at).stdout == "reset at 0\n"
    assert tmcl("step", *at).stdout == "stepping at 1\n"
    assert value(at, "GGP 1, 2") == 4711
    tmcl("exec", "SGP 1, 2, 0", *at)
    tmcl("start", "0", *at)
    wait_for(lambda: value(at, "GGP 1, 2") == 4711, "the program runs")
    wait_for(lambda: tmcl("status", *at).stdout.startswith("stopped"), "the program ends")
    back = tmcl("upload", *at).stdout.splitlines()[-2:]
    assert [line.split("  //")[0].strip() for line in back] == ["SGP 1, 2, 4711", "STOP"]


def test_a_protected_program(at: tuple[str, str], tmp_path: Path) -> None:
    """Global parameter 81: what is refused is explained."""
    (tmp_path / "once.tmc").write_text(ONCE)
    tmcl("download", "once.tmc", *at, folder=tmp_path)
    tmcl("exec", "SGP 81, 0, 1", *at)
    refused = tmcl("upload", *at, code=TMCL_STATUS)
    assert refused.stdout == "" and "protected against disassembly (global parameter 81 is 1)" in refused.stderr
    stored = tmcl("download", "once.tmc", "--verify", *at, folder=tmp_path, code=TMCL_STATUS)
    assert "protected against disassembly" in stored.stderr
    tmcl("exec", "SGP 81, 0, 2", *at)
    refused = tmcl("download", "once.tmc", *at, folder=tmp_path, code=TMCL_STATUS)
    assert "protected against overwriting (global parameter 81 is 2)" in refused.stderr


def test_a_factory_reset(at: tuple[str, str]) -> None:
    """It waits for the module, which has another address then. A locked module ignores the command, so it is not sent."""
    tmcl("exec", "SAP 4, 0, 1000", "STAP 4, 0", "SGP 66, 0, 7", *at)
    assert json.loads(tmcl("scan", "--addresses", "1-8", "--json", *at).stdout)[0]["address"] == 7
    seven = ("--address", "7", *at)
    tmcl("exec", "SGP 73, 0, 1234", *seven)
    locked = tmcl("factory-reset", "--yes", *seven, code=TMCL_STATUS)
    assert "the EEPROM is locked (global parameter 73 is 1)" in locked.stderr
    tmcl("exec", "SGP 73, 0, 4321", *seven)
    unasked = tmcl("factory-reset", *seven, code=USAGE)
    assert "say --yes if you mean it" in unasked.stderr
    assert value(seven, "GAP 4, 0") == 1000
    done = tmcl("factory-reset", "--yes", *seven)
    assert "is back with its factory settings, now at address 1" in done.stderr
    assert value(at, "GAP 4, 0") == 51200


def test_a_scan_finds_who_replies_to_somebody_else(at: tuple[str, str]) -> None:
    """The host address is the module's business (global parameter 76)."""
    tmcl("exec", "SGP 76, 0, 9", *at)
    (found,) = json.loads(tmcl("scan", "--addresses", "1-2", "--json", *at).stdout)
    assert (found["address"], found["module"], found["host_address"]) == (1, "TMCM-1311", 9)
    unheard = tmcl("info", "--timeout", "200ms", "--retries", "0", *at, code=CONNECTION)
    assert "a reply came from module 1 to host 9" in unheard.stderr
    assert "TMCM-1311" in tmcl("info", "--host-address", "9", *at).stdout


def test_identifiers_of_eleven_bits(serve: Callable[..., Server], link: str) -> None:
    """On a CAN bus they are the addresses, and a change of them is followed (global parameters 71 and 70)."""
    can = ("--port", f"slcan://{serve('--slcan', link).port('slcan').place}")
    done = tmcl("exec", "SGP 71, 0, 772", "SGP 70, 0, 2047", "GGP 71, 0", "--json", *can)
    assert [exchange["value"] for exchange in json.loads(done.stdout)] == [772, 2047, 772]
    tmcl("info", "--timeout", "200ms", "--retries", "0", *can, code=CONNECTION)
    there = ("--address", "0x304", "--host-address", "0x7FF", *can)
    (found,) = json.loads(tmcl("scan", "--addresses", "0x300-0x308", "--json", *there).stdout)
    assert (found["address"], found["module"], found["host_address"]) == (772, "TMCM-1311", 2047)
    text = "set can_id=1000\nset serial_address=9\nget can_id\n"
    assert tmcl("shell", *there, text=text).stdout.splitlines()[-1].endswith("1000  CAN ID")
    there = ("--address", "1000", "--host-address", "2047", *can)
    tmcl("set", "can_id=1001", "can_reply_id=3", *there)
    done = tmcl("factory-reset", "--yes", "--address", "1001", "--host-address", "3", *can)
    assert "is back with its factory settings, now at address 1" in done.stderr
    assert "TMCM-1311" in tmcl("info", *can).stdout


def test_a_shell_reads_from_a_pipe(at: tuple[str, str]) -> None:
    """Without a terminal there is no prompt, and the worst that happened is the exit code."""
    text = "set max_velocity=1000\nget max_velocity\n\nGAP 29, 0\nGAP APMaxVelocity, Motor0\n"
    done = tmcl("shell", *at, text=text, code=TMCL_STATUS)
    lines = done.stdout.splitlines()
    assert [line.split("  ")[0] for line in lines] == ["SAP 4, 0, 1000", "GAP 4, 0", "GAP 29, 0", "GAP 4, 0"]
    assert "01 06 04 00 00 00 00 00 0b  100 OK" in lines[1] and "1000 pps" in lines[1]
    assert "axis parameter 29" in done.stderr


def test_settings_come_from_the_command_line_the_environment_and_a_file(server: Server, tmp_path: Path) -> None:
    """In this order, each setting by itself; the file is looked for upwards."""
    port = notation(server.port("tcp"))
    below = tmp_path / "a" / "b"
    below.mkdir(parents=True)
    (tmp_path / "tmcl.toml").write_text(f'[connection]\nport = "{port}"\ntimeout = "300ms"\nretries = 0\n')
    assert "TMCM-1311" in tmcl("info", folder=below).stdout
    elsewhere = {"TMCL_PORT": "tcp://127.0.0.1:1"}
    failed = tmcl("info", folder=below, more=elsewhere, code=CONNECTION)
    assert "the environment variable TMCL_PORT names this port" in failed.stderr
    assert "TMCM-1311" in tmcl("info", "--port", port, folder=below, more=elsewhere).stdout
    failed = tmcl("info", folder=below, more={"TMCL_ADDRESS": "5"}, code=CONNECTION)
    assert "within 300 ms:" in failed.stderr
    assert "TMCM-1311" in tmcl("info", "--address", "1", folder=below, more={"TMCL_ADDRESS": "5"}).stdout
    (below / "tmcl.toml").write_text("[connection]\nprot = 1\n")
    failed = tmcl("info", folder=below, code=USAGE)
    assert f"{below / 'tmcl.toml'}:2:1: unknown key `prot`" in failed.stderr


@pytest.fixture
def tmcm_1076() -> Iterator[str]:
    """Something that answers command 136 as a TMCM-1076 does, and nothing else."""

    def answer(listener: socket.socket) -> None:
        connection, _ = listener.accept()
        with connection:
            while len(request := connection.recv(9)) == 9:
                assert request == datagram(136, 1)
                reply = bytes([2, 1, 100, 136, 0x04, 0x34, 0x01, 0x02])
                connection.sendall(reply + bytes([sum(reply) & 0xFF]))

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=answer, args=[listener], daemon=True)
        thread.start()
        yield f"tcp://127.0.0.1:{listener.getsockname()[1]}"
        thread.join(10)


def test_a_module_without_program_memory(tmcm_1076: str, tmp_path: Path) -> None:
    """TMCM-1076: direct mode only."""
    (tmp_path / "once.tmc").write_text(ONCE)
    refused = tmcl("download", "once.tmc", "--port", tmcm_1076, folder=tmp_path, code=TMCL_STATUS)
    assert "the TMCM-1076 has no program memory" in refused.stderr


def test_the_shell_completes_and_remembers(serve: Callable[..., Server], tmp_path: Path) -> None:
    """On a terminal: Tab, and what was typed in an earlier session."""
    port = notation(serve("--tcp", "127.0.0.1:0").port("tcp"))
    state = {"XDG_STATE_HOME": str(tmp_path)}
    with Terminal("shell", "--port", port, more=state) as terminal:
        terminal.wait_for("tmcm-1311> ")
        terminal.type("ga\tAPActualPos\tM\t\r")
        terminal.wait_for("GAP APActualPosition, Motor0")
        terminal.wait_for("01 06 01 00 00 00 00 00 08  100 OK")
        terminal.wait_for("tmcm-1311> ")
        terminal.type("set target_vel\t4711\r")
        terminal.wait_for("SAP 2, 0, 4711")
        terminal.wait_for("01 05 02 00 00 00 12 67 81  100 OK")
        terminal.wait_for("4711 pps")
        terminal.wait_for("tmcm-1311> ")
        terminal.type("get no_such\r")
        terminal.wait_for("nothing called `no_such`")
        terminal.wait_for("tmcm-1311> ")
        terminal.type("\x04")
        assert terminal.end() == 0
    assert (tmp_path / "tmcl" / "history").read_text().splitlines()[-2:] == ["set target_velocity=4711", "get no_such"]
    with Terminal("shell", "--port", port, more=state) as terminal:
        terminal.wait_for("tmcm-1311> ")
        terminal.type("\x1b[A\x1b[A\r")
        terminal.wait_for("01 05 02 00 00 00 12 67 81  100 OK")
        terminal.wait_for("tmcm-1311> ")
        terminal.type("exit\r")
        assert terminal.end() == 0


def test_a_factory_reset_asks_on_a_terminal(server: Server) -> None:
    """No is what Enter says."""
    port = notation(server.port("tcp"))
    for answer, code, said in [("", USAGE, "nothing was done"), ("yes", 0, "is back with its factory settings")]:
        with Terminal("factory-reset", "--port", port, more={}) as terminal:
            terminal.wait_for("[y/N] ")
            terminal.type(f"{answer}\r")
            terminal.wait_for(said)
            assert terminal.end() == code


def test_several_modules_on_one_bus(serve: Callable[..., Server]) -> None:
    """Each is found at its address, and talked to at that."""
    port = notation(serve("tmcm-1640@2", "--tcp", "127.0.0.1:0").port("tcp"))
    found = json.loads(tmcl("scan", "--addresses", "1-3", "--json", "--port", port).stdout)
    assert [(it["address"], it["module"]) for it in found] == [(1, "TMCM-1311"), (2, "TMCM-1640")]
    assert "TMCM-1640" in tmcl("info", "--port", port, "--address", "2").stdout
    assert value(("--port", port, "--address", "1"), "GAP 140, 0") == 8


def test_modules_on_a_can_bus(serve: Callable[..., Server], link: str, tmp_path: Path) -> None:
    """The same commands through an adapter that speaks slcan."""
    serve("tmcm-1311@5", "--slcan", link)
    wait_for(Path(link).exists, "the adapter is there")
    port = ("--port", f"slcan://{link}")
    found = json.loads(tmcl("scan", "--addresses", "4-6", "--json", *port).stdout)
    assert [(it["address"], it["module"]) for it in found] == [(5, "TMCM-1311")]
    five = (*port, "--address", "5")
    (tmp_path / "once.tmc").write_text(ONCE)
    done = tmcl("download", "once.tmc", "--verify", "--run", *five, folder=tmp_path)
    assert "2 instructions of 2048 stored, read back and the same" in done.stderr
    wait_for(lambda: value(five, "GGP 1, 2") == 4711, "the program runs")
    lost = tmcl("info", *port, "--address", "9", "--timeout", "150ms", "--retries", "0", code=CONNECTION)
    assert "received nothing" in lost.stderr
