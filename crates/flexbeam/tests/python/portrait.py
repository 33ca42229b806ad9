"""The pictures of README and book, taken of a real run:  portrait.py PROGRAM FOLDER

A person at a wide screen, dark and light, and one with a phone. The same run each time: the simulated rig, its seed, the same
changes at the same instants of the run's time. What differs from one taking to the next is noise of the machine alone.
"""

import os
import sys
import tempfile

from browser import Browser
from running import Program

# Of a laptop and of a phone [CSS pixels], and pixels to each.
WIDE, PHONE = (1440, 1026), (390, 844)

# A picture that a reader's connection has to carry [bytes].
LARGEST = 200_000

PROJECT = """\
schema = "flexbeam.project/1"
name = "Flexible beam"
controller = "controller.toml"

[reference]
shape = "square"
amplitude_rad = 0.5235987755982988
period_s = 4.0

[[scope]]
title = "Tip angle"
signals = ["reference_rad", "y_model_rad", "psi_rad"]
span_s = 10.0

[[scope]]
title = "Voltage and deflection"
signals = ["alpha_rad", "voltage_v"]
span_s = 10.0

[[scope]]
title = "Deflection over tip angle"
kind = "xy"
signals = ["psi_rad", "alpha_rad"]
span_s = 4.0

[[panel]]
title = "Reference"
settings = ["reference.shape", "reference.amplitude_rad", "reference.period_s", "smooth_ticks"]

[[panel]]
title = "Law"
settings = ["law", "eps_u_v", "eps_e_rad"]
"""


def at(viewer, time_s):
    """Waits for an instant of the run."""
    viewer.until(f"{time_s} s", lambda: viewer.newest() * 1e-3 >= time_s)


def portrait(program, browser, name, size, dark, **more):
    with open(program.path("flexbeam.toml"), "w") as file:
        file.write(PROJECT)
    run = program.run(".", out=f"{name}.mcap")
    viewer = browser.viewer(run.url, size, dark, **more)
    viewer.press("Start")
    at(viewer, 9.0)
    viewer.entry("Amplitude in °").fill("45")
    viewer.entry("Amplitude in °").press("Enter")
    viewer.page.get_by_role("button", name="Save").first.click()
    # Nothing has the focus, nothing is pointed at.
    viewer.ask("() => { document.activeElement.blur(); scrollTo(0, 0); }")
    viewer.page.mouse.move(0, 0)
    at(viewer, 15.5)
    viewer.shot(name)
    viewer.press("Stop")
    run.status()
    viewer.close()


program, pictures = map(os.path.abspath, sys.argv[1:])
with tempfile.TemporaryDirectory() as folder:
    program = Program(program, folder)
    program.controller()
    try:
        with Browser(pictures) as browser:
            portrait(program, browser, "scope_dark", WIDE, dark=True)
            portrait(program, browser, "scope_light", WIDE, dark=False)
            portrait(program, browser, "scope_phone", PHONE, dark=True, device_scale_factor=2, is_mobile=True, has_touch=True)
    finally:
        program.end()
for name in ["scope_dark", "scope_light", "scope_phone"]:
    size = os.path.getsize(os.path.join(pictures, f"{name}.png"))
    assert size <= LARGEST, f"{name}.png has {size} bytes, needed at most {LARGEST}"
