"""What FMPy makes of a functional mock-up unit: it validates it, then runs the kernel's vectors through it, bit for bit.

run_fmu.py unit.fmu test_vectors.c PERIOD_S
run_fmu.py unit.fmu test_vectors.c PERIOD_S --build   of a unit without a binary: FMPy compiles its sources
"""

import os
import shutil
import sys

from fmpy import extract, read_model_description, simulate_fmu
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu

from fmu_instance import Instance, refused
from vectors import bits, parsed

OUTPUTS = "voltage_v u_v smoothed_rad y_rad y_model_rad error_rad".split()
INPUTS = "reference_rad theta_rad alpha_rad".split()

unit, vectors, period_s = sys.argv[1], sys.argv[2], float(sys.argv[3])
description = read_model_description(unit)
references = {variable.name: variable.valueReference for variable in description.modelVariables}
settings_names = [name for name in references if name.startswith("settings.")]
numbers = [references[name] for name in settings_names if name != "settings.law"]
law, fault = references["settings.law"], references["fault"]
is_3 = description.fmiVersion.startswith("3")


class Unit(Instance):
    """One instance of the controller."""

    def __init__(self, folder, name):
        super().__init__(description, folder, name)

    def set_law(self, value, variable=law):
        self.set_whole(variable, value)

    def settings(self, chosen):
        self.set(numbers, chosen[0])
        self.set_law(chosen[1])

    def tuned(self, **changes):
        self.set([references[f"settings.{name}"] for name in changes], list(changes.values()))

    def outputs(self):
        return self.get([references[name] for name in OUTPUTS])

    def step(self, inputs, step_s=period_s):
        self.set([references[name] for name in INPUTS], inputs)
        self.do_step(step_s)
        return self.outputs(), self.get_whole(fault)


def same(found, tick, place):
    assert bits(found[0]) == bits(tick[4]) and found[1] == tick[2], (place, found, tick)


assert (problems := validate_fmu(unit)) == [], problems
folder = extract(unit)
if "--build" in sys.argv:
    assert not os.path.exists(os.path.join(folder, "binaries"))
    build_platform_binary(folder, generator="Unix Makefiles")
choices, ticks = parsed(vectors)
assert len(choices) == 8 and len(ticks) > 300 and len(settings_names) == 21

# The start values are those of the binary, and every setting is read back.
one, other = Unit(folder, "one"), Unit(folder, "other")
starts = {variable.name: variable.start for variable in description.modelVariables}
assert bits(one.get(numbers)) == bits(float(starts[name]) for name in settings_names if name != "settings.law")
assert one.get_whole(law) == int(starts["settings.law"])
distinct = [0.5 + k for k in range(len(numbers))]
one.settings((distinct, 1))
assert one.get(numbers) == distinct and one.get_whole(law) == 1
one.reset()
assert bits(one.get(numbers)) == bits(other.get(numbers))

# All vectors, in one instance; before each tick the other starts again from the bytes of the first.
changes = 0
for k, tick in enumerate(ticks):
    if tick[1]:
        one.reset()
    if tick[1] or tick[0] != ticks[k - 1][0]:
        one.settings(choices[tick[0]])
        changes += not tick[1]
    other.take_over(one)
    assert bits(other.outputs()) == bits(one.outputs()) and other.get_whole(fault) == one.get_whole(fault), k
    for instance in (one, other):
        same(instance.step(tick[3]), tick, k)
    assert not is_3 or abs(one.get([references["time"]])[0] - one.time_s) < 1e-9
assert changes >= 9, changes

# Memory: back to an instant and on for a while, by copy in the same instance and by bytes in the other; twice the same bytes.
for start, kept in ((0, 31), (170, 201)):
    one.reset()
    one.settings(choices[ticks[start][0]])
    first = next(k for k in range(start, -1, -1) if ticks[k][1])
    for k in range(first, kept):
        one.settings(choices[ticks[k][0]])
        same(one.step(ticks[k][3]), ticks[k], k)
    memory = one.memory()
    written = one.written(memory)
    assert written == one.written(memory)
    for k in range(kept, kept + 20):
        one.settings(choices[ticks[k][0]])
        same(one.step(ticks[k][3]), ticks[k], k)
    assert one.written(one.memory()) != written
    from_bytes = other.read(written)
    for instance, recalled in ((one, memory), (other, from_bytes)):
        instance.recall(recalled)
        for k in range(kept, kept + 20):
            instance.settings(choices[ticks[k][0]])
            same(instance.step(ticks[k][3]), ticks[k], k)
    one.free(memory)
    other.free(from_bytes)
    for wrong in (written[:-1], b"x" + written[1:], written[:-8] + b"\x09" + 7 * b"\0"):
        refused("found other bytes", one.read, wrong)

# The two switches, held by nothing but memory: |u| and |e| lie within their hysteresis.
one.reset()
one.set_law(1)
one.tuned(u_p_plus_v=0.3, u_p_minus_v=0.3, eps_u_v=1e3, eps_e_rad=1e-12)
one.step([0.5, 0.1, 0.0])
other.recall(other.read(one.written(one.memory())))
for instance in (one, other):
    instance.tuned(eps_u_v=1e-9, hysteresis_u=1e15, eps_e_rad=1e6, hysteresis_e=1.0)
    found = instance.step([0.5, 0.1, 0.0])
    assert abs(found[0][0]) == 0.3 and found[1] == 0, found

# What is refused changes nothing.
before = one.written(one.memory())
refused("found a step of", one.step, [0.5, 0.1, 0.0], 2 * period_s)
refused("found a step of", one.fmu.doStep, 0.0, float("nan"))
refused("found value reference 4", one.set, [references["reference_rad"], references["voltage_v"]], [9.0, 9.0])
refused("found value reference 99", one.get, [99])
refused("0, 1 or 2", one.set_law, 3)
refused("0, 1 or 2", one.set_law, 1, fault)
assert one.written(one.memory()) == before
one.fmu.reset()
refused("needed behind", one.fmu.doStep, 0.0, period_s)
one.start()
one.fmu.terminate()
refused("needed behind", one.fmu.doStep, 0.0, period_s)
refused("found a terminated instance", one.set, [references["reference_rad"]], [0.0])
refused("found a terminated instance", one.set_law, 1)
one.fmu.freeInstance()
other.end()

# The whole simulation by FMPy's own loop, at the settings of the controller file.
result = simulate_fmu(folder, stop_time=100 * period_s, step_size=period_s, output_interval=period_s,
                      start_values={"reference_rad": 0.25, "theta_rad": 0.125}, output=OUTPUTS + ["fault"])
check = Unit(folder, "check")
for k in range(1, 101):
    expected, latched = check.step([0.25, 0.125, 0.0])
    assert bits(result[name][k] for name in OUTPUTS) == bits(expected) and int(result["fault"][k]) == latched, k
assert any(abs(result["voltage_v"]) > 0.1)
check.end()
shutil.rmtree(folder)
print(f"{len(ticks)} ticks, {changes} changes, FMI {description.fmiVersion}")
