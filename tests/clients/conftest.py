"""Real clients against the real binary: unmodified PyTrinamic over TCP and over a pseudo terminal.

    cargo build --release
    python3 -m venv target/venv && target/venv/bin/pip install -r tests/clients/requirements.txt
    target/venv/bin/python -m pytest tests/clients

Environment variable TMCL names another binary. Each test gets a freshly started module with both kinds of port, and each test
that takes `port`, `connection`, `module` or `motor` runs twice, once over each.
"""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from harness import Port, Server, stock_files
from pytrinamic.connections.tmcl_interface import TmclInterface
from pytrinamic.modules import TMCM1311

#: Virtual time runs this much faster, so that moves of seconds take fractions of one.
SPEED = "20"

# PyTrinamic sets no timeout on its socket and would wait for ever for a reply that does not come. This is Python's own default
# for new sockets; the client stays as it is.
socket.setdefaulttimeout(10.0)


@pytest.fixture
def serve() -> Iterator[Callable[..., Server]]:
    """Starts servers. Whatever a test did to one, it ends on SIGTERM with exit code 0 and without a panic."""
    servers: list[Server] = []

    def start(*arguments: str, module: str = "tmcm-1311", kind: type[Server] = Server) -> Server:
        servers.append(kind(*arguments, module=module))
        return servers[-1]

    yield start
    codes = [server.stop() for server in servers if server.is_running()]
    for server in servers:
        print(server.stderr())
        assert "panicked" not in server.stderr()
    assert not any(codes)


@pytest.fixture
def link(tmp_path: Path) -> str:
    """A path for a pseudo terminal."""
    return str(tmp_path / "ttyTMCL")


@pytest.fixture
def server(serve: Callable[..., Server], link: str) -> Server:
    """A module fresh from the factory, on one TCP port and one pseudo terminal."""
    return serve("--tcp", "127.0.0.1:0", "--pty", link, "--speed", SPEED)


@pytest.fixture(params=["tcp", "pty"])
def transport(request: pytest.FixtureRequest) -> str:
    """What the client connects over."""
    return request.param


@pytest.fixture
def port(server: Server, transport: str) -> Port:
    """The port that the client connects to."""
    return server.port(transport)


@pytest.fixture
def connection(port: Port) -> Iterator[TmclInterface]:
    """A connected client."""
    with port.connect() as connection:
        yield connection


@pytest.fixture
def module(connection: TmclInterface) -> TMCM1311:
    """The client's idea of the module."""
    return TMCM1311(connection)


@pytest.fixture
def motor(module: TMCM1311) -> TMCM1311._MotorTypeA:
    """The client's idea of its motor."""
    return module.motors[0]


@pytest.fixture(scope="session")
def rotate_demo() -> Iterator[subprocess.Popen[str]]:
    """The vendor's rotate_demo.py for the TMCM-1311, running as a program of its own against a server of its own.

    It sleeps for 11 s and moves for 20 s at any speed, because the faster virtual time is, the further it rotates in its 5 s.
    """
    server = Server("--tcp", "127.0.0.1:0", "--speed", "1")
    # The wheel installs the examples as a package called `examples`, a name too common to import.
    script = stock_files("examples/modules/TMCM1311/TMCL/rotate_demo.py")[0].locate()
    command = [sys.executable, str(script), *server.port("tcp").arguments().split()]
    demo = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    yield demo
    demo.kill()
    demo.wait()
    print(server.stderr())
    assert server.stop() == 0


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Looks at the demo last; `start_demo_early` lets it run meanwhile, which saves most of its half minute."""
    items.sort(key=lambda item: "rotate_demo" in getattr(item, "fixturenames", ()))


@pytest.fixture(scope="session", autouse=True)
def start_demo_early(request: pytest.FixtureRequest) -> None:
    """Starts the demo before the first test, if a test wants it."""
    if any("rotate_demo" in getattr(item, "fixturenames", ()) for item in request.session.items):
        request.getfixturevalue("rotate_demo")
