"""`tmcl get`, `set`, `store`, `watch`, `dump`, `diff` and `apply` against a module behind a TCP port, checked with PyTrinamic."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from harness import PATIENCE_S, Port, Server, binary, datagram, wait_for

#: Virtual time runs this much faster.
SPEED = "20"

#: What 137 and 255 want.
MAGIC = 1234

Serve = Callable[..., Server]


@pytest.fixture
def tcp(serve: Serve) -> Port:
    """A TMCM-1311 on a TCP port."""
    return serve("--tcp", "127.0.0.1:0", "--speed", SPEED).port("tcp")


def command(port: Port, name: str, *arguments: str, address: int = 1) -> list[str]:
    """The command line."""
    return [str(binary()), name, "--port", port.place, "--address", str(address), *arguments]


def tmcl(port: Port, name: str, *arguments: str, code: int = 0, address: int = 1) -> str:
    """Runs a command, which ends with this code, and returns what it prints; of one that fails, what it complains about."""
    done = subprocess.run(
        command(port, name, *arguments, address=address), capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert done.returncode == code, done.stderr
    return done.stdout if code == 0 else done.stderr


def reset(port: Port, number: int) -> None:
    """Resets the module, to the factory settings (137) or not (255); neither has a reply."""
    with port.open_raw() as line:
        line.write(datagram(number, value=MAGIC))
    wait_for(lambda: tmcl(port, "get", "--raw", "axis.4"), "the module answers again")


CHANGES = {
    "tmcm-1311": ("max_velocity=40000", "encoder_mode.null_active_high=1", "chopper_off_time=3", "variable.7=-3",
                  "timer_1_period=500", "coordinate.2=77", "end_switch_polarity=reversed", "baud_rate=baud_115200"),
    "tmcm-1640": ("max_velocity=3000", "stop_switch_enable.left=1", "motor_poles=14", "variable.7=-3", "velocity_p=900",
                  "hall_interpolation=on", "auto_start=on"),
}  # fmt: skip


@pytest.mark.parametrize("module", CHANGES)
def test_a_configuration_survives_a_factory_reset(serve: Serve, tmp_path: Path, module: str) -> None:
    """Dump, factory reset, apply, dump: the same bytes."""
    port = serve("--tcp", "127.0.0.1:0", "--speed", SPEED, module=module).port("tcp")
    factory = tmcl(port, "dump")
    tmcl(port, "set", *CHANGES[module])
    before, after = tmp_path / "before.toml", tmp_path / "after.toml"
    tmcl(port, "dump", "-o", str(before))
    reset(port, 137)
    assert tmcl(port, "dump") == factory
    tmcl(port, "diff", str(before), code=1)
    tmcl(port, "apply", str(before), "--connection")
    tmcl(port, "diff", str(before))
    tmcl(port, "dump", "-o", str(after))
    assert after.read_bytes() == before.read_bytes() != factory.encode()


def test_what_is_set_is_what_other_clients_read(tcp: Port) -> None:
    """Numbers, units, names and bits."""
    tmcl(tcp, "set", "max_velocity=0x10000 pps", "auto_start=on", "encoder_mode=4", "encoder_mode.null_active_high=1")
    with tcp.connect() as connection:
        assert connection.get_axis_parameter(4, 0) == 0x10000
        assert connection.get_global_parameter(77, 0) == 1
        assert connection.get_axis_parameter(201, 0) == 4 + 16
        connection.set_axis_parameter(5, 0, 123)
    (row,) = json.loads(tmcl(tcp, "get", "--json", "5"))
    assert row == {"name": "max_acceleration", "number": "axis.5", "value": 123, "unit": "pps/s"}


def test_what_is_wrong_is_not_written(tcp: Port, tmp_path: Path) -> None:
    """One wrong assignment, or one wrong line of a file, and nothing at all is written."""
    assert "allowed is 0…255" in tmcl(tcp, "set", "max_velocity=7", "max_current=256", code=2)
    file = tmp_path / "wrong.toml"
    file.write_text('module = "tmcm-1311"\n[axis]\nmax_velocity = 7\nactual_position = 3\n')
    assert f"{file}:4:1" in tmcl(tcp, "apply", str(file), code=2)
    assert tmcl(tcp, "get", "--raw", "max_velocity") == "51200\n"


def test_a_locked_module_keeps_what_it_has(tcp: Port, tmp_path: Path) -> None:
    """What the lock refuses is said with what helps; the rest of the file is applied."""
    file = tmp_path / "lift.toml"
    file.write_text('module = "tmcm-1311"\n[axis]\nmax_velocity = 7\n[global]\nauto_start = "on"\n')
    tmcl(tcp, "set", "eeprom_lock=locked")
    assert "eeprom_lock=unlocked" in tmcl(tcp, "store", "max_velocity", code=4)
    assert "`auto_start`" in tmcl(tcp, "apply", str(file), code=1)
    assert tmcl(tcp, "get", "--raw", "max_velocity", "auto_start", "eeprom_lock") == "7\n0\n1\n"
    tmcl(tcp, "set", "eeprom_lock=unlocked")
    tmcl(tcp, "apply", str(file), "--store")
    reset(tcp, 255)
    assert tmcl(tcp, "get", "--raw", "max_velocity", "auto_start") == "7\n1\n"


def test_stored_values_come_back(tcp: Port) -> None:
    """`store`, and `restore` after another write."""
    tmcl(tcp, "set", "--store", "max_velocity=7", "variable.1=8")
    tmcl(tcp, "set", "max_velocity=9", "variable.1=10")
    tmcl(tcp, "restore", "max_velocity", "variable.1")
    assert tmcl(tcp, "get", "--raw", "max_velocity", "variable.1") == "7\n8\n"


def test_apply_follows_a_new_address(tcp: Port, tmp_path: Path) -> None:
    """Addresses are written only on demand, after the rest, and read back at the new address."""
    file = tmp_path / "seven.toml"
    file.write_text('module = "tmcm-1311"\n[connection]\nserial_address = 7\n[variable]\n1 = 5\n')
    tmcl(tcp, "apply", str(file))
    assert tmcl(tcp, "get", "--raw", "serial_address", "variable.1") == "1\n5\n"
    tmcl(tcp, "apply", str(file), "--connection")
    assert tmcl(tcp, "get", "--raw", "serial_address", address=7) == "7\n"


def test_watch_is_csv_in_a_pipe_and_ends_with_ctrl_c(tcp: Port) -> None:
    """Each line is a sample, later than the one before."""
    watch = subprocess.Popen(command(tcp, "watch", "tick_timer", "--every", "5ms"), stdout=subprocess.PIPE, text=True)
    assert watch.stdout is not None
    assert watch.stdout.readline() == "time_s,tick_timer\n"
    samples = [watch.stdout.readline().strip().split(",") for _ in range(5)]
    times, ticks = [float(time) for time, _ in samples], [int(tick) for _, tick in samples]
    assert times == sorted(set(times)) and ticks == sorted(ticks)
    watch.send_signal(signal.SIGINT)
    watch.communicate(timeout=PATIENCE_S)
    assert watch.returncode == 0
    assert len(tmcl(tcp, "watch", "tick_timer", "--every", "1ms", "--count", "3").splitlines()) == 4
