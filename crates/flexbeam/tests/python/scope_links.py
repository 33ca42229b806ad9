"""The way to the run: a page loaded again, a connection lost and regained, a viewer that is too slow."""

from playwright.sync_api import expect
from proxy import Road
from running import as_recorded
from scenario import scenario

COMPARED = "reference_rad", "theta_rad", "alpha_rad", "commanded_v"


@scenario
def a_reload_in_the_middle_brings_everything_back(program, browser):
    run = program.run(program.controller(), "--signal", "square")
    viewer = browser.viewer(run.url)
    viewer.press("Start")
    viewer.reads("Running")
    viewer.goes_on(2000)
    oldest = viewer.held()["tick"][0]
    viewer.page.reload()
    viewer.reads("Running")
    viewer.goes_on()
    assert viewer.held()["tick"][0] == oldest, "the history is back"
    expect(viewer.page.get_by_text("You are in control.")).to_be_visible()
    viewer.follows(viewer.drag("Amplitude in °", 0.6))
    viewer.shot("link_reloaded")
    viewer.press("Stop")
    assert run.status() == 0
    viewer.reads("Stopped")
    as_recorded(viewer.held(*COMPARED), run.recording())
    viewer.close()


@scenario
def a_lost_connection_comes_back_without_a_hole(program, browser):
    run = program.run(program.controller(), "--signal", "square")
    road = Road(run.port)
    viewer = browser.viewer(road.url(run))
    viewer.press("Start")
    viewer.reads("Running")
    viewer.goes_on()
    for what, lose in [("cut", road.cut), ("silent", road.hush)]:
        lose()
        lost = viewer.page.get_by_role("alert").filter(has_text="Connection lost.")
        expect(lost).to_be_visible()
        expect(lost).to_contain_text("The run goes on without this page")
        viewer.reads("No connection")
        assert viewer.button("Start").is_disabled() and viewer.button("Stop").is_disabled()
        viewer.page.keyboard.press("Control+.")
        expect(viewer.page.get_by_text("Emergency stop did nothing")).to_be_visible()
        viewer.shot(f"link_{what}")
        viewer.press("Dismiss")
        at = viewer.newest()
        road.mend()
        viewer.reads("Running")
        expect(lost).to_be_hidden()
        viewer.goes_on()
        assert viewer.newest() > at + 300
    viewer.shot("link_regained")
    viewer.press("Stop")
    assert run.status() == 0
    viewer.reads("Stopped")
    as_recorded(viewer.held(*COMPARED), run.recording())
    viewer.close()
    road.close()


@scenario
def a_slow_viewer_disturbs_nobody(program, browser):
    run = program.run(program.controller(), "--signal", "square")
    road = Road(run.port)
    slow, swift = browser.viewer(road.url(run)), browser.viewer(run.url)
    slow.reads("Armed")
    swift.reads("Armed")
    road.throttle(3000)  # bytes a second; the samples are some 60 000
    slow.press("Start")
    swift.reads("Running")
    swift.goes_on(6000)
    assert swift.newest() > slow.newest() + 2000, "the slow one lags"
    slow.shot("link_slow")
    swift.press("Stop")
    road.throttle(None)
    assert run.status() == 0
    swift.reads("Stopped")
    recording = run.recording()
    held = swift.held(*COMPARED)
    as_recorded(held, recording)
    assert held["tick"][-1] == recording.samples[-1].tick, "up to the last one"
    assert recording.report["unrecorded"] == 0
    as_recorded(slow.held(*COMPARED), recording, lost=slow.ask("() => window.flexbeam.store.lost"))
    swift.close()
    slow.close()
    road.close()


@scenario
def the_next_run_at_the_same_address_is_seen_without_a_reload(program, browser):
    controller = program.controller()
    first = program.run(controller, out="first.mcap")
    viewer = browser.viewer(first.url)
    viewer.press("Start")
    viewer.reads("Running")
    viewer.press("Stop")
    first.status()
    viewer.reads("Stopped")
    second = program.run(controller, out="second.mcap", port=first.port)
    assert second.url == first.url, "a bookmark survives"
    viewer.reads("Armed")
    viewer.press("Start")
    viewer.reads("Running")
    viewer.press("Stop")
    assert second.status() == 0
    viewer.reads("Stopped")
    as_recorded(viewer.held(*COMPARED), second.recording())
    viewer.close()
