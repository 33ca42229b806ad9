"""Debian's Chromium for the scope page. Serves nothing and downloads nothing."""

import os

from playwright.sync_api import sync_playwright
from viewer import PATIENCE_MS, Viewer

CHROMIUM = "/usr/bin/chromium"

# As root there is no sandbox; the rest keeps Chromium from talking to anybody but the page's server. The last one stands for a
# name server that somebody else rules.
FLAGS = [
    *"--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking".split(),
    *"--disable-component-update --disable-sync --disable-default-apps".split(),
    "--host-resolver-rules=MAP rebound.test 127.0.0.1",
]

WIDE, PHONE, NARROWEST = (1440, 900), (390, 844), (320, 640)


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

    def context(self, size=WIDE, dark=True, **more):
        made = self.chromium.new_context(
            viewport={"width": size[0], "height": size[1]}, color_scheme="dark" if dark else "light", **more
        )
        made.set_default_timeout(PATIENCE_MS)
        return made

    def viewer(self, url, size=WIDE, dark=True, **more):
        """Somebody who opens the address."""
        return Viewer(self, self.context(size, dark, **more), url)
