"""What can be seen and saved: rules of accessibility, narrow screens, pictures and numbers taken away as files."""

import struct
import xml.etree.ElementTree as xml

import numpy as np
from browser import NARROWEST, PHONE, WIDE
from playwright.sync_api import expect
from scenario import scenario

# What sticks out sideways, unless it is in something that scrolls by itself.
STICKS_OUT = """() => {
    const scrolls = one => one && one !== document.body && (getComputedStyle(one).overflowX !== "visible" || scrolls(one.parentElement));
    const out = [...document.body.querySelectorAll("*")].filter(one => {
        const {left, right, width} = one.getBoundingClientRect();
        return width > 0 && (right > innerWidth + 1 || left < -1) && one.checkVisibility() && !scrolls(one.parentElement)
            && !one.closest(".unseen, .skip");
    });
    return [document.documentElement.scrollWidth - innerWidth, out.map(one => one.outerHTML.slice(0, 120))];
}"""

ALL_LOOKS = [(size, scheme) for size in [WIDE, PHONE] for scheme in ["dark", "light"]]

# Of a sheet over the page, whose colours and widths are the page's.
TWO_LOOKS = [(WIDE, "dark"), (PHONE, "light")]


@scenario
def axe_finds_nothing(program, browser):
    run = program.run(program.controller(), "--signal", "square")
    viewer = browser.viewer(run.url)
    page, found = viewer.page, []

    def look(state, only=ALL_LOOKS):
        for size, scheme in only:
            page.set_viewport_size({"width": size[0], "height": size[1]})
            page.emulate_media(color_scheme=scheme)
            viewer.shot(f"look_{state}_{size[0]}_{scheme}")
            found.extend(f"{state}, {size[0]} px, {scheme}: {line}" for line in viewer.violations())
        page.set_viewport_size({"width": WIDE[0], "height": WIDE[1]})

    viewer.reads("Armed")
    look("armed")
    viewer.press("Start")
    viewer.goes_on(5000)
    look("running")
    viewer.press("Help and keys")
    look("help", TWO_LOOKS)
    page.keyboard.press("Escape")
    page.get_by_role("region", name="Scope: Tip angle").get_by_role("button", name="Signals and settings").click()
    look("scope_sheet", TWO_LOOKS)
    page.keyboard.press("Escape")
    viewer.press("Edit panel Reference")
    look("panel_sheet", TWO_LOOKS)
    page.keyboard.press("Escape")
    viewer.press("Stop")
    run.status()
    expect(page.get_by_role("dialog", name="The run was stopped")).to_be_visible()
    look("over")
    assert not found, "\n".join(found)
    viewer.close()


@scenario
def a_phone_scrolls_downwards_only(program, browser):
    run = program.run(program.controller(), "--signal", "square")
    viewer = browser.viewer(run.url, PHONE, has_touch=True, is_mobile=True)
    viewer.reads("Armed")
    viewer.button("Start").tap()
    viewer.goes_on(2000)
    for size in [PHONE, NARROWEST]:
        viewer.page.set_viewport_size({"width": size[0], "height": size[1]})
        viewer.page.wait_for_timeout(200)
        sideways, out = viewer.ask(STICKS_OUT)
        assert sideways <= 0 and not out, (size, sideways, out)
        for share in [0, 0.5, 1]:
            viewer.ask("share => scrollTo(0, share * document.documentElement.scrollHeight)", share)
            expect(viewer.button("Emergency stop")).to_be_in_viewport(ratio=1)
            viewer.shot(f"phone_{size[0]}_{share}")
    viewer.button("Emergency stop").tap()
    assert run.status() == 3
    viewer.reads("Fault")
    viewer.shot("phone_fault")
    viewer.close()


def snapshot(viewer, entry):
    """What a scope's menu gives: name and bytes."""
    scope = viewer.page.get_by_role("region", name="Scope: Tip angle")
    scope.get_by_role("button", name="More", exact=True).click()
    with viewer.page.expect_download() as download:
        viewer.page.get_by_role("menuitem", name=entry).click()
    with open(download.value.path(), "rb") as file:
        return download.value.suggested_filename, file.read()


@scenario
def snapshots_are_what_was_measured(program, browser):
    run = program.run(program.controller(), "--signal", "square")
    viewer = browser.viewer(run.url, accept_downloads=True)
    viewer.press("Start")
    viewer.goes_on(4000)
    viewer.press("Stop")
    run.status()
    viewer.reads("Stopped")
    viewer.press("Look at the data")
    name, png = snapshot(viewer, "Picture (PNG)")
    assert name.startswith("tip-angle_") and png[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", png[16:24])
    assert width > 500 and height > 200
    with open(f"{browser.shots}/snapshot.png", "wb") as file:
        file.write(png)
    name, svg = snapshot(viewer, "Drawing (SVG)")
    drawing = xml.fromstring(svg)
    assert drawing.tag == "{http://www.w3.org/2000/svg}svg"
    words = "".join(drawing.itertext())
    assert "Tip angle" in words and "Model" in words or "odel" in words, words
    assert b"http" not in svg.replace(b"http://www.w3.org/2000/svg", b""), "it stands alone"
    with open(f"{browser.shots}/snapshot.svg", "wb") as file:
        file.write(svg)
    page = browser.context().new_page()
    page.set_content(f"<body style='margin:0'>{svg.decode()[svg.decode().index('<svg'):]}")
    page.screenshot(path=f"{browser.shots}/snapshot_svg.png")
    page.context.close()
    name, text = snapshot(viewer, "Samples (CSV)")
    head, *rows = [line.split(",") for line in text.decode().splitlines() if not line.startswith("#")]
    assert head == ["time_s", "reference_rad", "y_model_rad", "psi_rad"]
    ours = run.recording().by_tick()
    values = np.array(rows, dtype=float)
    ticks = np.rint(values[:, 0] / 0.001).astype(int)
    assert len(ticks) > 3000 and (np.diff(ticks) > 0).all()
    assert [tick for tick in range(ticks[0], ticks[-1]) if tick in ours] == list(ticks[:-1]), "none is left out"
    for k, key in enumerate(head[1:], start=1):
        running = [row for row, tick in enumerate(ticks) if ours[tick].phase == 1]
        recorded = np.array([getattr(ours[ticks[row]], key) for row in running], dtype=np.float32)
        assert len(running) > 3000 and (values[running, k].astype(np.float32) == recorded).all(), key
    viewer.close()
