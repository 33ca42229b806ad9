"""A project's page: laid out anew, saved from the page, and there again in the next run."""

import re
import tomllib

from playwright.sync_api import expect
from scenario import scenario

# Written by hand, with a comment wherever there may be one.
BY_HAND = """\
# The beam on the second bench.
schema = "flexbeam.project/1"
name = "Second bench"        # as its label says
controller = "controller.toml"

[reference]                  # gentle
shape = "square"             # the exercise
amplitude_rad = 0.3          # about 17 degrees

# What to watch.
[[scope]]
title = "Tip"                # large
signals = ["reference_rad", "psi_rad"]  # wanted and found
span_s = 5.0                 # one period and a bit

# What to turn.
[[panel]]
title = "Bench"              # only this
settings = ["reference.amplitude_rad", "law"]
"""


def titles(viewer):
    return [one.input_value() for one in viewer.page.get_by_role("textbox", name="Title of the scope").all()]


@scenario
def the_page_saves_and_the_next_run_is_as_it_was(program, browser):
    program.controller()
    with open("flexbeam.toml", "w") as file:
        file.write(BY_HAND)
    run = program.run(".", out="first.mcap")
    viewer = browser.viewer(run.url)
    expect(viewer.page.get_by_role("heading", name="Second bench")).to_be_visible()
    assert titles(viewer) == ["Tip"]
    assert viewer.reading("Amplitude in °") == 17.19
    expect(viewer.button("Save to project")).to_be_disabled()
    viewer.press("Start")
    viewer.reads("Running")
    viewer.entry("Amplitude in °").fill("24.5")
    viewer.entry("Amplitude in °").press("Enter")
    viewer.follows(24.5)
    viewer.press("Add scope")
    title = viewer.page.get_by_role("textbox", name="Title of the scope").last
    title.fill("Second look")
    title.press("Enter")
    viewer.page.get_by_role("region", name="Scope: Tip").get_by_role("combobox", name="Span").select_option("10")
    expect(viewer.page.get_by_text("Unsaved layout and settings")).to_be_visible()
    viewer.page.reload()
    viewer.reads("Running")
    viewer.until("what is unsaved survives a reload", lambda: titles(viewer) == ["Tip", "Second look"])
    viewer.shot("project_unsaved")
    viewer.press("Save to project")
    expect(viewer.button("Save to project")).to_be_disabled()
    expect(viewer.page.get_by_text("Unsaved")).to_be_hidden()
    viewer.press("Stop")
    assert run.status() == 0
    viewer.close()
    with open("flexbeam.toml") as file:
        text = file.read()
    for comment in re.findall("#.*", BY_HAND):
        assert comment in text, f"{comment} is gone:\n{text}"
    saved = tomllib.loads(text)
    assert [scope["title"] for scope in saved["scope"]] == ["Tip", "Second look"]
    assert saved["scope"][0]["span_s"] == 10.0
    again = program.run(".", out="second.mcap")
    viewer = browser.viewer(again.url)
    viewer.reads("Armed")
    assert titles(viewer) == ["Tip", "Second look"]
    assert viewer.reading("Amplitude in °") == 24.5
    expect(viewer.button("Save to project")).to_be_disabled()
    viewer.press("Start")
    viewer.follows(24.5)
    viewer.shot("project_again")
    viewer.press("Stop")
    assert again.status() == 0
    first, second = run.recording().settings[-1], again.recording().settings[0]
    assert first["reference"] == second["reference"] and first["settings"] == second["settings"], (first, second)
    viewer.close()


@scenario
def a_project_that_was_spoilt_by_hand_is_not_written_over(program, browser):
    program.controller()
    with open("flexbeam.toml", "w") as file:
        file.write(BY_HAND)
    run = program.run(".")
    viewer = browser.viewer(run.url)
    viewer.reads("Armed")
    viewer.press("Add scope")
    spoilt = BY_HAND.replace('name = "Second bench"', 'name = "Second bench')
    with open("flexbeam.toml", "w") as file:
        file.write(spoilt)
    viewer.press("Save to project")
    expect(viewer.page.get_by_role("alert").filter(has_text="Save to project")).to_contain_text("flexbeam.toml")
    viewer.shot("project_spoilt")
    with open("flexbeam.toml") as file:
        assert file.read() == spoilt
    expect(viewer.button("Save to project")).to_be_enabled()
    viewer.press("Stop")
    run.status()
    viewer.close()
