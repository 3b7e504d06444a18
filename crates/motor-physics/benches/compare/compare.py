"""The same motor, the same voltages, the same time: motor-physics beside gym-electric-motor and motulator.

A QBL4208-61-04-013 with 1e-5 kgm² and 2e-5 Nms/rad on its shaft starts up under 8 V across its magnets, held for steps of
50 µs. Only the machine's own simulation is timed: no environment, no rewards, no plots. The last line is not a bare motor but
a whole virtual TMCM-1640, with firmware, power stage, sensors and supply. Not part of CI; to run it:

    python3 -m venv /tmp/compare && /tmp/compare/bin/pip install -r crates/motor-physics/benches/compare/requirements.txt
    /tmp/compare/bin/python crates/motor-physics/benches/compare/compare.py

The trajectories must agree, or it says so and fails: velocity within 0.1 % and current within 0.01 A, after 5 ms and at the end.
(gym-electric-motor holds the voltage in the rotor's frame, the others in the stator's, hence not closer. Its Euler solver is
listed for its speed only: a step of 50 µs is coarse for it.)
"""

import math
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from gym_electric_motor import physical_systems as gem
from gym_electric_motor.physical_systems.voltage_supplies import IdealVoltageSupply
from motulator.common.utils import complex2abc
from motulator.drive import model
from motulator.drive.utils import SynchronousMachinePars

DT_S, STEPS, EARLY, ROUNDS = 50e-6, 10_000, 100, 5
VOLTAGE_Q_V, BUS_V = 8.0, 24.0
POLE_PAIRS, RESISTANCE_OHM, INDUCTANCE_H = 4, 0.36, 0.6e-3
FLUX_WB = 0.036 / (math.sqrt(3) * POLE_PAIRS)
ROTOR_KGM2, LOAD_KGM2, VISCOUS = 4.8e-6, 1e-5, 2e-5


def motor_physics():
    """Runs the release build of examples/pmsm_speed.rs."""
    crate = Path(__file__).parents[2]
    command = ["cargo", "run", "--quiet", "--release", "--example", "pmsm_speed"]
    output = subprocess.run(command, cwd=crate, check=True, capture_output=True, text=True).stdout
    speed, *states = map(float, output.split())
    return speed, states


def whole_module():
    """Runs the release build of virtual-bench's examples/bldc_module_speed.rs: firmware, power stage, sensors and all."""
    crate = Path(__file__).parents[3] / "virtual-bench"
    command = ["cargo", "run", "--quiet", "--release", "--example", "bldc_module_speed"]
    return float(subprocess.run(command, cwd=crate, check=True, capture_output=True, text=True).stdout)


def gym_electric_motor(solver):
    """The physical system alone, its voltages given in the rotor's frame."""
    system = gem.SynchronousMotorSystem(
        control_space="dq",
        converter=gem.ContB6BridgeConverter(tau=DT_S),
        motor=gem.PermanentMagnetSynchronousMotor(
            motor_parameter={
                "p": POLE_PAIRS, "l_d": INDUCTANCE_H, "l_q": INDUCTANCE_H, "j_rotor": ROTOR_KGM2,
                "r_s": RESISTANCE_OHM, "psi_p": FLUX_WB,
            },
            limit_values={"omega": 1000.0, "i": 100.0, "u": BUS_V},
        ),
        load=gem.PolynomialStaticLoad(load_parameter={"a": 0.0, "b": VISCOUS, "c": 0.0, "j_load": LOAD_KGM2}),
        supply=IdealVoltageSupply(u_nominal=BUS_V),
        ode_solver=solver,
        tau=DT_S,
    )
    system.reset()
    at = system.state_names.index
    action = np.array([0.0, VOLTAGE_Q_V / (BUS_V / 2)])
    states = []
    begin = time.perf_counter()
    for step in range(1, STEPS + 1):
        state = system.simulate(action)
        if step in (EARLY, STEPS):
            states += [state[i] * system.limits[i] for i in (at("omega"), at("i_sq"))]
    return STEPS * DT_S / (time.perf_counter() - begin), states


class Commutation:
    """A motulator controller that puts the voltage across the magnets, on average over the step."""

    def __init__(self):
        self.steps, self.states = 0, []

    def __call__(self, drive):
        if self.steps in (EARLY, STEPS):
            self.states += [drive.mechanics.meas_speed(), drive.machine.i_s.imag]
        self.steps += 1
        speed = drive.mechanics.meas_speed()
        angle = np.angle(drive.machine.state.exp_j_theta_m) + 0.5 * POLE_PAIRS * speed * DT_S
        return DT_S, complex2abc(1j * VOLTAGE_Q_V * np.exp(1j * angle)) / BUS_V

    def post_process(self):
        """Nothing is kept."""


def motulator():
    """Its drive model without computational delay, solved by solve_ivp with its defaults."""
    drive = model.Drive(
        model.VoltageSourceConverter(u_dc=BUS_V),
        model.SynchronousMachine(
            SynchronousMachinePars(
                n_p=POLE_PAIRS, R_s=RESISTANCE_OHM, L_d=INDUCTANCE_H, L_q=INDUCTANCE_H, psi_f=FLUX_WB
            )
        ),
        model.StiffMechanicalSystem(J=ROTOR_KGM2 + LOAD_KGM2, B_L=VISCOUS),
    )
    drive.delay = lambda duty_ratios: duty_ratios
    commutation = Commutation()
    simulation = model.Simulation(drive, commutation)
    begin = time.perf_counter()
    simulation.simulate(t_stop=(STEPS + 0.5) * DT_S)
    return commutation.steps * DT_S / (time.perf_counter() - begin), commutation.states


def main():
    """Runs all, prints the table, and fails where trajectories differ."""
    simulations = {
        "motor-physics": motor_physics,
        "gym-electric-motor, dopri5": lambda: gym_electric_motor(gem.ScipyOdeSolver()),
        "gym-electric-motor, Euler": lambda: gym_electric_motor(gem.EulerSolver()),
        "motulator": motulator,
    }
    rounds = [{name: simulate() for name, simulate in simulations.items()} for _ in range(ROUNDS)]
    # A busy machine slows each down by turns: the fastest of each counts, for all alike.
    runs = {name: max((round_[name] for round_ in rounds), key=lambda run: run[0]) for name in simulations}
    ours, expected = runs["motor-physics"]
    print(f"{'':28}{'virtual s / s':>14}{'ratio':>8}{'5 ms: rad/s':>13}{'A':>8}{'end: rad/s':>12}{'A':>8}")
    differing = []
    for name, (speed, states) in runs.items():
        early_w, early_i, last_w, last_i = states
        print(f"{name:28}{speed:14.4g}{ours / speed:8.0f}{early_w:13.3f}{early_i:8.3f}{last_w:12.3f}{last_i:8.3f}")
        velocities = all(math.isclose(states[i], expected[i], rel_tol=1e-3) for i in (0, 2))
        currents = all(abs(states[i] - expected[i]) < 0.01 for i in (1, 3))
        if not (velocities and currents) and "Euler" not in name:
            differing.append(name)
    print(f"{'a whole virtual TMCM-1640':28}{max(whole_module() for _ in range(ROUNDS)):14.4g}")
    if differing:
        sys.exit(f"trajectories differ: {', '.join(differing)}")


if __name__ == "__main__":
    main()
