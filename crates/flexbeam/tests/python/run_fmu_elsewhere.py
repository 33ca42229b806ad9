"""What two more importers make of a functional mock-up unit: the kernel's vectors, bit for bit, through Ecos and through libcosim.

run_fmu_elsewhere.py unit.fmu test_vectors.c PERIOD_S ecos|libcosim

Both know numbers, no enumerations: so the law stays that of the unit, and a fault shows by its zeros.
"""

import ctypes
import os
import sys

from vectors import bits, parsed

OUTPUTS = "voltage_v u_v smoothed_rad y_rad y_model_rad error_rad".split()
INPUTS = "reference_rad theta_rad alpha_rad".split()
CHANNEL = ("scale", "offset_rad", "low_pass")
SETTINGS = [f"settings.{channel}.{name}" for channel in ("theta", "alpha") for name in CHANNEL]
SETTINGS += [f"settings.{name}" for name in (
    "smooth_ticks smooth_step_rad u_p_plus_v u_p_minus_v eps_u_v eps_e_rad hysteresis_u hysteresis_e breakaway_plus_v "
    "breakaway_minus_v voltage_limit_v deflection_limit_rad theta_limit_rad theta_step_limit_rad").split()]

unit, vectors, period_s, importer = sys.argv[1], sys.argv[2], float(sys.argv[3]), sys.argv[4]


class Ecos:
    """Ecos by L. I. Hatledal, which reads units with fmi4c; FMI 2.0 and 3.0."""

    def __init__(self):
        # Its library wants oneTBB, which the wheel does not hold; another wheel does.
        ctypes.CDLL(os.path.join(sys.prefix, "lib", "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)
        from ecospy import EcosSimulation, EcosSimulationStructure
        self.structure = EcosSimulationStructure()
        self.structure.add_model("one", unit)
        self.simulation = EcosSimulation(period_s, structure=self.structure)
        self.simulation.init()

    def step(self, values):
        for name, value in values.items():
            self.simulation.set_real(f"one::{name}", value)
        self.simulation.step()
        return [self.simulation.get_real(f"one::{name}") for name in OUTPUTS]

    def end(self):
        self.simulation.terminate()
        self.simulation.free()
        self.structure.free()


class Libcosim:
    """libcosim of the Open Simulation Platform, which reads units with Modelon's FMI Library; FMI 2.0."""

    def __init__(self):
        from libcosimpy.CosimExecution import CosimExecution
        from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
        from libcosimpy.CosimManipulator import CosimManipulator
        from libcosimpy.CosimObserver import CosimObserver
        from libcosimpy.CosimSlave import CosimLocalSlave
        log_output_level(CosimLogLevel.WARNING)
        self.execution = CosimExecution.from_step_size(step_size=round(period_s * 1e9))
        self.slave = CosimLocalSlave(fmu_path=unit, instance_name="one")
        self.index = self.execution.add_local_slave(self.slave)
        found = self.execution.slave_variables(self.index)
        self.references = {variable.name.decode(): variable.reference for variable in found}
        self.manipulator, self.observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
        self.execution.add_manipulator(self.manipulator)
        self.execution.add_observer(self.observer)

    def step(self, values):
        references = [self.references[name] for name in values]
        assert self.manipulator.slave_real_values(self.index, references, list(values.values()))
        assert self.execution.step()
        return list(self.observer.last_real_values(self.index, [self.references[name] for name in OUTPUTS]))

    def end(self):
        del self.execution


choices, ticks = parsed(vectors)
starts = [k for k, tick in enumerate(ticks) if tick[1]] + [len(ticks)]
law = choices[0][1]
runs = compared = 0
for first, behind in zip(starts, starts[1:]):
    if any(choices[tick[0]][1] != law for tick in ticks[first:behind]):
        continue
    instance = Ecos() if importer == "ecos" else Libcosim()
    for k in range(first, behind):
        changed = k == first or ticks[k][0] != ticks[k - 1][0]
        values = dict(zip(SETTINGS, choices[ticks[k][0]][0])) if changed else {}
        found = instance.step(values | dict(zip(INPUTS, ticks[k][3])))
        assert bits(found) == bits(ticks[k][4]), (k, found, ticks[k])
        compared += 1
    instance.end()
    runs += 1
print(f"{importer}: {compared} ticks of {runs} runs")
