"""Somebody at the scope page: what they read, press and drag, and what their page holds of the run."""

import json
import os
import re
import time

import numpy as np
from axe_playwright_python.base import AXE_SCRIPT
from playwright.sync_api import expect

# Longer than any stall of a busy machine.
PATIENCE_MS = 30_000

expect.set_options(timeout=PATIENCE_MS)

# What the page's store holds of some signals, at ticks.
RAW = """keys => {
    const {store} = window.flexbeam, raw = Array.from({length: store.count - store.rawFirst}, (_, k) => store.rawFirst + k);
    const column = key => raw.map(k => store.valueAt(store.channels.get(key), k));
    return {tick: raw.map(k => store.tickAt(k)), ...Object.fromEntries(keys.map(key => [key, column(key)]))};
}"""

# Pixels of a scope's canvas that have the colour of a signal's trace.
INKED = """([title, key]) => import("./colours.js").then(({colourOf}) => {
    const canvas = [...document.querySelectorAll(".scope")].find(one => one.ariaLabel.endsWith(title)).querySelector("canvas");
    const wanted = colourOf(key).match(/[0-9a-f]{2}/gi).map(byte => parseInt(byte, 16));
    const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let k = 0; k < data.length; k += 4) count += wanted.every((byte, c) => Math.abs(data[k + c] - byte) < 24) && data[k + 3] > 200;
    return count;
})"""


class Viewer:
    """One page, what its console complained of, and whom it asked for anything."""

    def __init__(self, browser, context, url):
        self.browser, self.context = browser, context
        self.page = context.new_page()
        self.complaints = []
        self.page.on("request", self._request)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("console", self._console)
        self.page.goto(url)

    def _request(self, request):
        if not request.url.startswith(("http://127.0.0.1:", "data:", "blob:http://127.0.0.1:")):
            self.complaints.append(f"asked for {request.url}")

    def _console(self, message):
        # A server that is away is the scenario's doing, and Chromium says so by itself.
        if message.type == "error" and "net::ERR_" not in message.text and "WebSocket connection" not in message.text:
            self.complaints.append(message.text)

    def close(self):
        """Closes the page; nothing in it may have failed."""
        self.context.close()
        assert not self.complaints, "\n".join(self.complaints)

    def shot(self, name):
        self.page.screenshot(path=os.path.join(self.browser.shots, f"{name}.png"))

    # What a person reads.

    def reads(self, phase):
        """Waits until the state in the top bar is this word."""
        expect(self.page.locator("#top .pill")).to_contain_text(phase)

    def figure(self, label):
        """A large number, as shown."""
        text = self.page.get_by_role("group", name=label).locator(".number").inner_text()
        return float(text.strip().replace("\u2212", "-")) if re.search(r"\d", text) else float("nan")

    def shows(self, label, value, within):
        self.until(f"{label} of {value}", lambda: abs(self.figure(label) - value) <= within)

    def inked(self, title, key):
        return self.ask(INKED, [title, key])

    # What a person does.

    def button(self, name):
        return self.page.get_by_role("button", name=name, exact=True)

    def press(self, name):
        self.button(name).click()

    def slider(self, name):
        return self.page.get_by_role("slider", name=name, exact=True)

    def entry(self, name):
        return self.page.get_by_role("textbox", name=name, exact=True)

    def reading(self, name):
        """What stands in a setting's entry, in the unit shown."""
        return float(self.entry(name).input_value().replace("\u2212", "-"))

    def drag(self, name, share):
        """Takes a slider's thumb with the mouse and lets it go at a share of the way from its left end. Returns the value shown."""
        slider = self.slider(name)
        slider.scroll_into_view_if_needed()
        low, high, now = (float(slider.evaluate(f"one => one.{end}")) for end in ["min", "max", "value"])
        # Moves of the mouse are handled with the next frame; `change` comes after the last of them.
        slider.evaluate("one => { one.let_go = new Promise(done => one.addEventListener('change', done, {once: true})); }")
        box, mouse = slider.bounding_box(), self.page.mouse
        at = lambda share: (box["x"] + 8 + share * (box["width"] - 16), box["y"] + box["height"] / 2)
        mouse.move(*at((now - low) / (high - low)))
        mouse.down()
        mouse.move(*at(share), steps=12)
        mouse.up()
        slider.evaluate("one => one.let_go.then(() => 0)")
        return self.reading(name)

    def step(self, name, key, times):
        """Presses a key on the slider that has the focus, and sees each one act. Returns the value shown."""
        for _ in range(times):
            before = self.reading(name)
            self.page.keyboard.press(key)
            self.until(f"{key} acts on {name}", lambda: self.reading(name) != before)
        return self.reading(name)

    def tab_to(self, name, backwards=False):
        """Goes to a control by the Tab key alone; its focus is to be seen."""
        names = []
        for _ in range(120):
            self.page.keyboard.press("Shift+Tab" if backwards else "Tab")
            focus = self.ask("() => [document.activeElement.ariaLabel ?? document.activeElement.textContent.trim(), document.activeElement.type]")
            names.append(focus[0])
            if focus[0] == name and focus[1] != "text":
                return self._has_a_ring(name)
        raise AssertionError(f"Tab never came to {name}, but to {names}")

    def _has_a_ring(self, name):
        """The control with the focus looks other without it."""
        box = self.page.locator(":focus").bounding_box()
        clip = {"x": box["x"] - 6, "y": box["y"] - 6, "width": box["width"] + 12, "height": box["height"] + 12}
        control = self.page.evaluate_handle("() => document.activeElement")
        focused = self.page.screenshot(clip=clip)
        control.evaluate("one => one.blur()")
        assert self.page.screenshot(clip=clip) != focused, f"{name} with the focus looks as without"
        control.evaluate("one => one.focus({focusVisible: true})")

    # What the page holds.

    def ask(self, expression, argument=None):
        return self.page.evaluate(expression, argument)

    def until(self, what, holds):
        """What `holds` returns, as soon as it is true; the page goes on meanwhile."""
        end = time.monotonic() + PATIENCE_MS / 1e3
        while not (found := holds()):
            if time.monotonic() > end:
                self.shot("never")
                raise AssertionError(f"never: {what}")
            self.page.wait_for_timeout(50)
        return found

    def latest(self, key):
        return self.ask("key => window.flexbeam.store?.latest(key) ?? NaN", key)

    def newest(self):
        """The newest tick that the page has; NaN when none."""
        return self.ask("() => window.flexbeam.store?.last ?? NaN")

    def follows(self, shown):
        """Waits until a square reference has this amplitude, in degrees, to the last digit shown."""
        self.until(f"an amplitude of {shown}°", lambda: abs(abs(self.figure("Reference in °")) - shown) < 0.001)

    def goes_on(self, ticks=300):
        """Waits for so many more samples."""
        before = self.newest()
        self.until("more samples", lambda: self.newest() > before + ticks)

    def held(self, *keys):
        """Raw samples: an array for each signal, and `tick`."""
        return {key: np.array(column) for key, column in self.ask(RAW, list(keys)).items()}

    def violations(self):
        """What axe-core finds wrong, a line each."""
        # evaluate() is the debugger's: the page's own policy lets no foreign script in.
        self.page.evaluate(AXE_SCRIPT + "; 0")
        found = self.page.evaluate("axe.run(document, {resultTypes: ['violations']})")
        return [
            f"{rule['id']} ({rule['impact']}): {rule['help']}: {json.dumps(node['target'])} {node['failureSummary']}"
            for rule in found["violations"] for node in rule["nodes"]
        ]
