"""That the client is the vendor's own, and that the vendor's own programs run."""

from __future__ import annotations

import base64
import hashlib
import importlib.metadata
import re
import subprocess
import sys
from pathlib import Path

from harness import Port, stock_files


def test_the_client_is_unmodified() -> None:
    """Every file is what its wheel says, so that what passes here passes for everybody who installs it."""
    assert importlib.metadata.version("pytrinamic") == "0.2.26"
    files = stock_files("")
    assert len(files) > 100
    for file in files:
        assert file.hash is not None
        digest = hashlib.new(file.hash.mode, Path(file.locate()).read_bytes()).digest()
        assert base64.urlsafe_b64encode(digest).rstrip(b"=").decode() == file.hash.value, file


def test_tmclinfo(port: Port) -> None:
    """The wheel's console program asks for what this firmware does not have; it says so instead of hanging."""
    command = [sys.executable, "-m", "pytrinamic.cli.tmclinfo", *port.arguments().split()]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 1
    assert "GetInfo request failed" in result.stderr
    assert "Invalid Command" in result.stderr


def test_rotate_demo(rotate_demo: subprocess.Popen[str]) -> None:
    """The vendor's example for this module, unmodified, from its first line to its last."""
    output, _ = rotate_demo.communicate(timeout=90)
    assert rotate_demo.returncode == 0, output
    lines = iter(output.splitlines())
    # Each is looked for after the one before it.
    for expected in (
        "pytrinamic - TRINAMIC's Python Technology Access Package",
        "Preparing parameters...",
        "LinearRamp {'max_velocity': 20000, 'max_acceleration': 40000, 'enable': None}",
        "Rotating...",
        "Stopping...",
        "Doubling moved distance.",
        "Furthest point reached.",
        "Moving back to 0...",
        "Reached position 0.",
        "Ready.",
    ):
        assert expected in lines, f"{expected!r} is missing or out of order in\n{output}"
    assert "'max_current': 50, 'standby_current': 0, 'boost_current': 0, 'microstep_resolution': 8" in output

    braking, furthest = (int(position) for position in re.findall(r"^ActualPosition = (-?\d+)$", output, re.MULTILINE))
    assert 0 < 2 * braking <= furthest
    seen = [
        (int(target), int(actual))
        for target, actual in re.findall(r"^target position: (-?\d+) actual position: (-?\d+)$", output, re.MULTILINE)
    ]
    out = [actual for target, actual in seen if target == furthest]
    back = [actual for target, actual in seen if target == 0]
    assert len(out) + len(back) == len(seen)
    assert len(out) > 10
    assert len(back) > 10
    assert out == sorted(out)
    assert out[-1] <= furthest
    assert back == sorted(back, reverse=True)
    assert back[-1] >= 0
