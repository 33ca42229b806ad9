"""What FMPy makes of the rig as a functional mock-up unit: it validates it, then drives it and compares every bit with flexbeam-rig.

run_rig_fmu.py unit.fmu periods PERIOD_S NAME=VALUE ..
    periods: rows of doubles, for each instant the outputs there and then the voltage that is held from there on
    With --build: of a unit without a binary, whose sources FMPy compiles
run_rig_fmu.py unit.fmu response.csv PERIOD_S --loop controller.fmu NAME=VALUE ..
    response.csv: of `flexbeam simulate`; both units step side by side, each taking what the other answered at the step before
"""

import csv
import os
import shutil
import struct
import sys

from fmpy import extract, read_model_description, simulate_fmu
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu

from fmu_instance import Instance, refused
from vectors import bits

OUTPUTS = "theta_rad alpha_rad true_theta_rad true_alpha_rad true_psi_rad true_theta_rad_s true_alpha_rad_s".split()

unit, data, period_s = sys.argv[1], sys.argv[2], float(sys.argv[3])
given = {name: float(value) for name, value in (word.split("=") for word in sys.argv[4:] if "=" in word)}
description = read_model_description(unit)
references = {variable.name: variable.valueReference for variable in description.modelVariables}
outputs = [references[name] for name in OUTPUTS]
voltage, contact = references["voltage_v"], references["contact"]
assert (problems := validate_fmu(unit)) == [], problems
folder = extract(unit)
if "--build" in sys.argv:
    assert not os.path.exists(os.path.join(folder, "binaries"))
    build_platform_binary(folder, generator="Unix Makefiles")


def numbered(text):
    return float(text) if text else float("nan")


def side_by_side():
    """The loop of both units against the rows of a simulation."""
    controller = sys.argv[sys.argv.index("--loop") + 1]
    of_controller = read_model_description(controller)
    place = extract(controller)
    rig, other = Instance(description, folder, "rig", **given), Instance(of_controller, place, "controller")
    inputs = [other.references[name] for name in ("reference_rad", "theta_rad", "alpha_rad")]
    answers = [other.references[name] for name in ("voltage_v", "u_v", "smoothed_rad", "y_model_rad")]
    rows = list(csv.DictReader(open(data)))
    for k, row in enumerate(rows):
        of_row = lambda *names: [numbered(row[name]) for name in names]
        read = rig.get(outputs)
        found = [read[0], read[1], read[2], read[3], read[4]]
        expected = of_row("theta_measured_rad", "alpha_measured_rad", "theta_rad", "alpha_rad", "psi_rad")
        assert bits(found) == bits(expected), (k, found, expected)
        sent = other.get(answers)[0]
        other.set(inputs, [numbered(row["reference_rad"]), *read[:2]])
        rig.set([voltage], [sent])
        for instance in (other, rig):
            instance.do_step(period_s)
        expected = of_row("voltage_v", "u_v", "smoothed_rad", "y_model_rad")
        assert bits(other.get(answers)) == bits(expected), (k, other.get(answers), expected)
    assert max(abs(numbered(row["theta_measured_rad"])) for row in rows) > 0.1
    for instance in (rig, other):
        instance.end()
    shutil.rmtree(place)
    print(f"{len(rows)} periods in a loop, FMI {description.fmiVersion}")


def driven():
    """One instance through all periods; now and then another one takes over from bytes."""
    numbers = open(data, "rb").read()
    row = struct.Struct("<9d")
    one, other = Instance(description, folder, "one", **given), Instance(description, folder, "other")
    for k in range(len(numbers) // row.size):
        *expected, stuck, voltage_v = row.unpack_from(numbers, k * row.size)
        if k % 997 == 500:
            other.take_over(one)
            one, other = other, one
        found = one.get(outputs)
        assert bits(found) == bits(expected) and (one.get_whole(contact) == 1) == (stuck == 1.0), (k, found, expected)
        one.set([voltage], [voltage_v])
        one.do_step(period_s)
    for instance in (one, other):
        instance.end()
    print(f"{len(numbers) // row.size} periods, FMI {description.fmiVersion}")


def start_values():
    """Those of the description are the binary's, and each is read back."""
    one = Instance(description, folder, "one")
    for variable in description.modelVariables:
        if variable.causality == "parameter":
            found = (one.get_whole if variable.name in one.whole_names else lambda r: one.get([r])[0])(variable.valueReference)
            start = variable.start.lower()
            assert found == float(start), (variable.name, found, start)
    changed = {"seed": 7, "delay_periods": 3, "friction.coulomb_nm": 0.5, "gauge.bias_rad": -0.25, "actuator.limit_v": 3.0}
    one.reset(**changed)
    for name, value in changed.items():
        found = one.get_whole(references[name]) if name in one.whole_names else one.get([references[name]])[0]
        assert found == value, name
    # The bias stands in the first reading: what is set before the first step was there from the beginning.
    assert abs(one.get(outputs)[1] + 0.25) < 0.01
    one.end()


def memory():
    """Back to an instant and on for a while, by copy in the same instance and by bytes in the other; twice the same bytes."""
    one, other = Instance(description, folder, "one", delay_periods=2, seed=5), Instance(description, folder, "other")

    def on(instance, count):
        found = []
        for k in range(count):
            instance.set([voltage], [3.0 if k % 40 < 20 else -2.0])
            instance.do_step(period_s)
            found += bits(instance.get(outputs))
        return found

    on(one, 57)
    kept = one.memory()
    written = one.written(kept)
    assert written == one.written(kept)
    right = on(one, 60)
    assert one.written(one.memory()) != written
    one.recall(kept)
    assert on(one, 60) == right
    other.recall(other.read(written))
    assert on(other, 60) == right
    for wrong in (written[:-1], b"x" + written[1:], written[:-8] + b"\x63" + 7 * b"\0"):
        refused("found other bytes", one.read, wrong)
    for instance in (one, other):
        instance.end()


def refusals():
    """What is refused changes nothing."""
    one = Instance(description, folder, "one")
    one.set([voltage], [1.0])
    one.do_step(period_s)
    before = one.written(one.memory())
    kind = "Float64" if one.is_3 else "Real"
    refused("found a step of", one.do_step, 2 * period_s)
    for name, value in [
        ("true_theta_rad", 1.0),
        ("friction.coulomb_nm", 0.01),
        ("gauge.noise_rad", -1.0),
        ("gauge.noise_rad", float("nan")),
        ("gauge.bias_rad", float("inf")),
        ("actuator.limit_v", 0.0),
        ("actuator.converter_step_v", float("inf")),
    ]:
        words = f"found value reference {references[name]}, needed that of a {kind} which is the input, or a parameter"
        refused(words, one.set, [voltage, references[name]], [9.0, value])
    for name, value in [("seed", 1), ("delay_periods", 0), ("contact", 0), ("encoder.counts_per_turn", -1)]:
        refused(f"found value reference {references[name]}, needed that of seed or delay", one.set_whole, references[name], value)
    refused("found value reference 99", one.get, [99])
    assert one.written(one.memory()) == before
    one.fmu.reset()
    for name, value in [("delay_periods", 17), ("friction.coulomb_nm", -0.1), ("friction.stribeck_speed_rad_s", 0.0)]:
        refused("and a value of its range", one.set_named, {name: value})
    one.start()
    one.set_named({"gauge.noise_rad": 0.0, "encoder.counts_per_turn": 0, "actuator.limit_v": float("inf")})
    one.end()


def own_loop_of_the_host():
    """The whole simulation by FMPy's own loop."""
    count = 200
    start = {"voltage_v": 2.5, "seed": 3, "gauge.bias_rad": 0.125}
    result = simulate_fmu(folder, stop_time=count * period_s, step_size=period_s, output_interval=period_s,
                          start_values=start, output=OUTPUTS + ["contact"])
    check = Instance(description, folder, "check", **start)
    for k in range(count + 1):
        assert bits(result[name][k] for name in OUTPUTS) == bits(check.get(outputs)), k
        assert int(result["contact"][k]) == check.get_whole(contact), k
        check.do_step(period_s)
    assert result["true_theta_rad"][-1] > 0.1
    check.end()


if "--loop" in sys.argv:
    side_by_side()
else:
    for part in (start_values, memory, refusals, own_loop_of_the_host, driven):
        part()
shutil.rmtree(folder)
