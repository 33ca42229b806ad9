"""A run from the page: start, change, stop, emergency stop; by mouse and by keyboard."""

import numpy as np
from playwright.sync_api import expect
from running import as_recorded
from scenario import scenario

AMPLITUDE = "Amplitude in °"


def same_tick(viewer, recording):
    """Each change acts in the page's samples at the tick that the recording gives it, and in the recording's own samples."""
    held = viewer.held("settings")
    assert len(recording.settings) > 1, "nothing was changed"
    for live in recording.settings[1:]:
        seen = held["tick"][held["settings"] >= live["revision"]]
        recorded = [sample.tick for sample in recording.samples if sample.settings >= live["revision"]]
        assert seen.min() == min(recorded) == live["tick"], live


@scenario
def a_run_is_started_changed_and_stopped(program, browser):
    run = program.run(program.controller(), "--signal", "square")
    viewer = browser.viewer(run.url)
    viewer.reads("Armed")
    assert run.token not in viewer.page.url, "the token does not stay in the address bar"
    assert viewer.button("Stop").is_enabled()
    viewer.shot("run_armed")
    viewer.press("Start")
    viewer.reads("Running")
    assert viewer.button("Start").is_disabled()
    viewer.shows("Reference in °", 30.0, 0.005)
    viewer.shows("Tip angle in °", 30.0, 3.0)
    viewer.until("a trace of the tip", lambda: viewer.inked("Tip angle", "psi_rad") > 100)
    dragged = viewer.drag(AMPLITUDE, 0.6)
    assert dragged > 31
    viewer.follows(dragged)
    viewer.slider(AMPLITUDE).focus()
    stepped = viewer.step(AMPLITUDE, "ArrowLeft", 4)
    assert stepped < dragged
    viewer.follows(stepped)
    law = viewer.page.get_by_role("group", name="Law").get_by_role("radio", name="None")
    law.check()
    expect(law).to_be_checked()
    viewer.goes_on(1500)
    viewer.shot("run_changed")
    viewer.press("Stop")
    assert run.status() == 0
    viewer.reads("Stopped")
    expect(viewer.page.get_by_role("dialog", name="The run was stopped")).to_be_visible()
    viewer.shot("run_stopped")
    recording = run.recording()
    same_tick(viewer, recording)
    last = recording.settings[-1]
    assert np.isclose(np.degrees(last["reference"]["amplitude_rad"]), stepped, rtol=1e-9), last
    assert last["settings"]["law"] == "none", last
    as_recorded(viewer.held("reference_rad", "theta_rad", "alpha_rad", "commanded_v"), recording)
    viewer.close()


@scenario
def the_emergency_stop_ends_the_run_at_status_3(program, browser):
    run = program.run(program.controller())
    viewer = browser.viewer(run.url)
    viewer.press("Start")
    viewer.shows("Tip angle in °", 30.0, 5.0)
    viewer.press("Emergency stop")
    assert run.status() == 3
    viewer.reads("Fault")
    expect(viewer.page.get_by_role("dialog")).to_contain_text("0 V")
    viewer.shot("run_emergency")
    assert run.recording().samples[-1].commanded_v == 0.0
    viewer.close()


@scenario
def escape_twice_is_the_emergency_stop_whatever_is_open(program, browser):
    run = program.run(program.controller())
    viewer = browser.viewer(run.url)
    viewer.press("Start")
    viewer.reads("Running")
    viewer.press("Help and keys")
    expect(viewer.page.get_by_role("dialog", name="Help")).to_be_visible()
    viewer.shot("run_help")
    for _ in range(3):  # the first one closes the sheet
        viewer.page.keyboard.press("Escape")
    assert run.status() == 3
    viewer.reads("Fault")
    viewer.close()


@scenario
def a_refused_setting_shows_its_limits(program, browser):
    run = program.run(program.controller())
    viewer = browser.viewer(run.url)
    viewer.reads("Armed")
    limit = viewer.entry("Voltage in V")
    limit.scroll_into_view_if_needed()
    before = limit.input_value()
    knob = viewer.page.locator(".knob").filter(has=limit)
    for typed, told in [("1000", ["1000", "needed", "10"]), ("a lot", ["needed a number in V"])]:
        limit.fill(typed)
        limit.press("Enter")
        expect(knob.locator(".note")).to_contain_text(told[0])
        note = knob.locator(".note").inner_text()
        assert all(word in note for word in told), note
        assert limit.input_value() == before
        viewer.shot(f"refused_{typed.replace(' ', '_')}")
    viewer.press("Stop")
    run.status()
    recording = run.recording()
    assert [live["revision"] for live in recording.settings] == [0], "nothing was changed"
    viewer.close()


@scenario
def the_keyboard_alone_starts_changes_and_stops(program, browser):
    run = program.run(program.controller(), "--signal", "square")
    viewer = browser.viewer(run.url)
    viewer.reads("Armed")
    expect(viewer.button("Start")).to_be_enabled()
    viewer.tab_to("Start")
    viewer.page.keyboard.press("Enter")
    viewer.reads("Running")
    viewer.tab_to(AMPLITUDE)
    viewer.shot("keyboard_slider")
    stepped = viewer.step(AMPLITUDE, "ArrowRight", 5)
    assert stepped > 30.0
    viewer.follows(stepped)
    viewer.tab_to("Stop", backwards=True)
    viewer.page.keyboard.press("Enter")
    assert run.status() == 0
    viewer.reads("Stopped")
    same_tick(viewer, run.recording())
    viewer.close()
