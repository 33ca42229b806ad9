"""The scope page in Debian's Chromium, as a person sees and works it. Serves nothing and downloads nothing."""

import json
import os

from axe_playwright_python.base import AXE_SCRIPT
from playwright.sync_api import expect, sync_playwright

CHROMIUM = "/usr/bin/chromium"

# As root there is no sandbox; the rest keeps Chromium from talking to anybody but the page's server.
FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --disable-default-apps"
).split()

WIDE, PHONE, NARROWEST = (1440, 900), (390, 844), (320, 640)

# Longer than any stall of a busy machine.
PATIENCE_MS = 30_000

expect.set_options(timeout=PATIENCE_MS)


class Browser:
    """One Chromium. Each viewer is a browser of its own to the page: no storage is shared."""

    def __init__(self, shots):
        self.shots = shots
        os.makedirs(shots, exist_ok=True)

    def __enter__(self):
        self.playwright = sync_playwright().start()
        self.chromium = self.playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        return self

    def __exit__(self, *_):
        self.chromium.close()
        self.playwright.stop()

    def viewer(self, url, size=WIDE, dark=True, **more):
        """Somebody who opens the address."""
        context = self.chromium.new_context(
            viewport={"width": size[0], "height": size[1]}, color_scheme="dark" if dark else "light", **more
        )
        context.set_default_timeout(PATIENCE_MS)
        return Viewer(self, context, url)


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

    def shot(self, name, whole=False):
        self.page.screenshot(path=os.path.join(self.browser.shots, f"{name}.png"), full_page=whole)

    def close(self):
        """Closes the page; nothing in it may have failed."""
        complaints = self.complaints
        self.context.close()
        assert not complaints, "\n".join(complaints)

    def until(self, expression, argument=None):
        """What the JavaScript expression gives, as soon as it is true."""
        return self.page.wait_for_function(expression, arg=argument, timeout=PATIENCE_MS).json_value()

    def ask(self, expression, argument=None):
        return self.page.evaluate(expression, argument)

    def button(self, name):
        return self.page.get_by_role("button", name=name, exact=True)

    def violations(self):
        """What axe-core finds wrong, a line each."""
        # evaluate() is the debugger's: the page's own policy lets no foreign script in.
        self.page.evaluate(AXE_SCRIPT + "; 0")
        found = self.page.evaluate("axe.run(document, {resultTypes: ['violations']})")
        return [
            f"{rule['id']} ({rule['impact']}): {rule['help']}: {json.dumps(node['target'])} {node['failureSummary']}"
            for rule in found["violations"] for node in rule["nodes"]
        ]
