"""Draws serve.svg: a real session of `tmcl serve` and PyTrinamic, rendered by rich.

    pip install rich pytrinamic && python docs/img/serve.py     (after cargo build --release)
"""

import re
import subprocess
import time
from pathlib import Path

from pytrinamic.connections import ConnectionManager
from pytrinamic.modules import TMCM1311
from rich.console import Console

HERE = Path(__file__).parent
TMCL = HERE / "../../target/release/tmcl"
ARGUMENTS = ["serve", "tmcm-1311", "--pty", "/tmp/ttyTMCL", "--tcp", "127.0.0.1:5311"]


def main() -> None:
    console = Console(record=True, width=100, force_terminal=True, file=open("/dev/null", "w"))
    console.print(f"[bold green]$[/] tmcl {' '.join(ARGUMENTS)} &", highlight=False)
    server = subprocess.Popen([TMCL, *ARGUMENTS], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    for _ in range(2):
        console.print(server.stdout.readline().strip(), highlight=False)
    console.print("[bold green]$[/] python")
    try:
        session(console)
    finally:
        server.terminate()
    svg = console.export_svg(title="a virtual TMCM-1311 and PyTrinamic, unmodified")
    # The drawing must not fetch fonts from anywhere.
    svg = re.sub(r"@font-face \{.*?\}", "", svg, flags=re.DOTALL)
    (HERE / "serve.svg").write_text(svg)


def session(console: Console) -> None:
    def say(line: str) -> None:
        console.print(f"[cyan]>>>[/] {line}", highlight=False)

    say("from pytrinamic.connections import ConnectionManager")
    say("from pytrinamic.modules import TMCM1311")
    say('module = ConnectionManager("--interface serial_tmcl --port /tmp/ttyTMCL").connect()')
    module = ConnectionManager("--interface serial_tmcl --port /tmp/ttyTMCL").connect()
    say("module.get_version_string()")
    console.print(repr(module.get_version_string()))
    say("motor = TMCM1311(module).motors\\[0]")
    motor = TMCM1311(module).motors[0]
    say("motor.linear_ramp")
    console.print(str(motor.linear_ramp), highlight=False)
    say("motor.move_to(51200)")
    motor.move_to(51200)
    say("while not motor.get_position_reached(): print(motor.actual_position); time.sleep(0.5)")
    while not motor.get_position_reached():
        console.print(str(motor.actual_position))
        time.sleep(0.5)
    say("motor.actual_position, module.get_axis_parameter(209, 0)  # ramp, encoder: 40000 a turn")
    console.print(str((motor.actual_position, module.get_axis_parameter(209, 0))))


if __name__ == "__main__":
    main()
