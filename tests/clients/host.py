"""Runs the host commands of `tmcl`, in a pipe and on a terminal."""

from __future__ import annotations

import os
import pty
import select
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path

import pytest
from harness import PATIENCE_S, Port, binary

#: `tmcl --help`, "Exit codes".
FINDINGS, USAGE, CONNECTION, TMCL_STATUS = 1, 2, 3, 4


def environment(more: Mapping[str, str] | None = None) -> dict[str, str]:
    """The environment without settings of whoever runs the tests."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("TMCL_")}
    return {**kept, "NO_COLOR": "1", **(more or {})}


def notation(port: Port) -> str:
    """What `--port` takes for a port of the server."""
    return f"tcp://{port.place}" if port.transport == "tcp" else port.place


def run(
    *arguments: str, text: str = "", folder: Path | None = None, more: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Runs `tmcl`, whatever comes of it."""
    return subprocess.run(
        [str(binary()), *arguments],
        input=text,
        capture_output=True,
        text=True,
        cwd=folder,
        env=environment(more),
        timeout=PATIENCE_S * 3,
        check=False,
    )


def tmcl(*arguments: str, code: int = 0, **options: object) -> subprocess.CompletedProcess[str]:
    """Runs `tmcl` and holds it to its exit code."""
    done = run(*arguments, **options)  # type: ignore[arg-type]
    assert done.returncode == code, f"{arguments}\n{done.stdout}\n{done.stderr}"
    return done


class Terminal:
    """`tmcl` on a pseudo terminal, typed at."""

    def __init__(self, *arguments: str, more: Mapping[str, str]) -> None:
        self._ours, theirs = pty.openpty()
        self._process = subprocess.Popen(
            [str(binary()), *arguments],
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            env=environment({"TERM": "xterm", **more}),
            start_new_session=True,
        )
        os.close(theirs)
        self.seen = ""

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *_: object) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        os.close(self._ours)

    def type(self, keys: str) -> None:
        """Types."""
        os.write(self._ours, keys.encode())

    def wait_for(self, text: str) -> str:
        """Reads until the screen showed `text`, and returns everything up to there."""
        deadline = time.monotonic() + PATIENCE_S
        while text not in self.seen:
            ready, _, _ = select.select([self._ours], [], [], max(0.0, deadline - time.monotonic()))
            if not ready:
                pytest.fail(f"waited in vain for {text!r} in {self.seen!r}")
            try:
                self.seen += os.read(self._ours, 4096).decode(errors="replace")
            except OSError:
                pytest.fail(f"the program ended before it said {text!r}: {self.seen!r}")
        before, _, self.seen = self.seen.partition(text)
        return before + text

    def end(self) -> int:
        """Waits for the end and returns the exit code."""
        deadline = time.monotonic() + PATIENCE_S
        while self._process.poll() is None and time.monotonic() < deadline:
            ready, _, _ = select.select([self._ours], [], [], 0.05)
            if ready:
                try:
                    self.seen += os.read(self._ours, 4096).decode(errors="replace")
                except OSError:
                    break
        return self._process.wait(PATIENCE_S)
