#!/usr/bin/env python3
"""Runs the tests of the page in Chromium.

Serves page/ and page-tests/ on 127.0.0.1, imports every *_test.js, runs each exported function, prints the failures and
exits 1 when there are any. Needs Playwright for Python; FLEXBEAM_CHROMIUM names another browser than Playwright's own.
Arguments: names of test files, all when there are none.
"""

import http.server
import os
import pathlib
import sys
import threading

from playwright.sync_api import sync_playwright

HERE = pathlib.Path(__file__).resolve().parent
FOLDERS = {"page": HERE.parent / "page", "page-tests": HERE}
TYPES = {".js": "text/javascript", ".css": "text/css", ".html": "text/html"}
FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync"
).split()
# One test that hangs must not hold up the others for ever.
LONGEST_MS = 60_000


class Files(http.server.BaseHTTPRequestHandler):
    """The two folders, and nothing else."""

    def do_GET(self):
        _, _, rest = self.path.partition("/")
        folder, _, name = rest.partition("/")
        path = FOLDERS.get(folder, HERE) / name
        if folder not in FOLDERS or "/" in name or not path.is_file():
            self.send_error(404)
            return
        body = path.read_bytes()
        self.send_response(200)
        self.send_header("Content-Type", TYPES.get(path.suffix, "application/octet-stream"))
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


RUN = """async (file) => {
  const tests = await import(file);
  const results = [];
  for (const [name, test] of Object.entries(tests)) {
    try { results.push([name, await test() ?? ""]); }
    catch (error) { results.push([name, null, String(error.stack ?? error)]); }
  }
  return results;
}"""


def run_file(page, base, name):
    """Failures of one file; prints a line for each test."""
    page.goto(f"{base}/page-tests/blank.html")
    results = page.evaluate(RUN, f"{base}/page-tests/{name}")
    if not results:
        print(f"FAILED {name}: exports no test")
        return 1
    failures = 0
    for test, said, *error in results:
        print(f"{'FAILED' if said is None else 'ok    '} {name}: {test}{f'  ({said})' if said else ''}")
        if said is None:
            failures += 1
            print("       " + error[0].replace("\n", "\n       "))
    return failures


def main():
    names = sys.argv[1:] or sorted(path.name for path in HERE.glob("*_test.js"))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Files)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    base = f"http://127.0.0.1:{server.server_port}"
    failures = 0
    with sync_playwright() as playwright:
        chromium = os.environ.get("FLEXBEAM_CHROMIUM") or None
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        page = browser.new_page(viewport={"width": 1200, "height": 800})
        page.set_default_timeout(LONGEST_MS)
        page.on("pageerror", lambda error: print(f"FAILED page error: {error}"))
        for name in names:
            failures += run_file(page, base, name)
        browser.close()
    server.shutdown()
    print(f"{failures} failed")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
