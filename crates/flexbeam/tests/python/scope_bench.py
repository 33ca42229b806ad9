"""How long a frame of the scope page takes, and what it holds after an hour:  scope_bench.py PROGRAM [frame|memory]

Prints tables for the book. The run is the real one at 1 kHz, the browser Debian's Chromium without a screen or a graphics card.
"""

import json
import os
import sys
import tempfile

import numpy as np
from browser import Browser
from running import Program

TEN = [
    "reference_rad", "smoothed_rad", "psi_rad", "y_model_rad", "theta_rad",
    "alpha_rad", "error_rad", "voltage_v", "commanded_v", "u_v",
]

SIZE = (1600, 900)

# Scopes on the page, and its size: what is out of sight is not drawn, so the last one is high enough for all four.
PAGES = [(1, SIZE), (4, SIZE), (4, (1600, 2000))]

# Ten seconds fill the plots; what comes after is measured.
FILL_S, MEASURE_S = 12, 20

# Time of each frame as main.js sees it, and from one frame to the next.
RECORD_FRAMES = """async seconds => {
    const {frames} = window.flexbeam, script = [], between = [];
    const end = performance.now() + 1e3 * seconds;
    let count = frames.count, before = performance.now();
    while (before < end) {
        const now = await new Promise(requestAnimationFrame);
        between.push(now - before);
        before = now;
        if (frames.count !== count) script.push(frames.last_ms);
        count = frames.count;
    }
    return {script, between: between.slice(1)};
}"""


def project(program, folder, scopes):
    """A project whose page shows so many scopes of all ten signals."""
    bench = Program(program.program, program.path(folder))
    bench.controller()
    text = 'schema = "flexbeam.project/1"\ncontroller = "controller.toml"\n'
    for k in range(scopes):
        text += f'\n[[scope]]\ntitle = "Ten {k + 1}"\nsignals = {json.dumps(TEN)}\nspan_s = 10.0\n'
    with open(bench.path("flexbeam.toml"), "w") as file:
        file.write(text + '\n[[panel]]\ntitle = "Reference"\nsettings = ["reference.amplitude_rad"]\n')


def frames(program, browser):
    print("| scopes | page | time of | frames | median [ms] | 95 % | 99 % | max |\n|---|---|---|---|---|---|---|---|")
    for scopes, size in PAGES:
        folder = f"ten{scopes}_{size[1]}"
        project(program, folder, scopes)
        run = program.run(folder, "--signal", "square", out=f"{folder}.mcap")
        viewer = browser.viewer(run.url, size)
        viewer.press("Start")
        viewer.page.wait_for_timeout(1e3 * FILL_S)
        found = viewer.ask(RECORD_FRAMES, MEASURE_S)
        for name, key in [("the page's own work", "script"), ("one frame to the next", "between")]:
            ms = np.array(found[key])
            low, mid, high = np.percentile(ms, [50, 95, 99])
            print(f"| {scopes} | {size[0]} x {size[1]} | {name} | {len(ms)} | {low:.1f} | {mid:.1f} | {high:.1f} | {ms.max():.1f} |")
        viewer.shot(folder)
        viewer.close()
        run.interrupt()


# Five minutes of the real run; then an hour pushed through the page's own decoder and store while it goes on drawing.
WATCH_MINUTES, HOUR_MINUTES = 5, 60

# A minute of frames of 33 rows, as the server sends them.
PUSH_MINUTE = """async minute => {
    const {store} = window.flexbeam, {decode} = await import("./frames.js");
    const m = store.signals.length, n = 30, first = store.last + 1;
    for (let k = 0; k < 60_000; k += n) {
        const frame = new ArrayBuffer(24 + 4 * n * (1 + m)), view = new DataView(frame);
        view.setUint32(0, 0x31534246, true);
        view.setUint32(4, n, true);
        view.setFloat64(8, first + k, true);
        view.setUint32(16, m, true);
        const offsets = new Uint32Array(frame, 24, n), values = new Float32Array(frame, 24 + 4 * n);
        for (let row = 0; row < n; row++) offsets[row] = row;
        for (let i = 0; i < values.length; i++) values[i] = Math.sin(0.001 * (first + k) + i);
        store.push(decode(frame));
        if (k % 3000 === 0) await new Promise(requestAnimationFrame);
    }
}"""


def heap_kb(session):
    """Objects and array buffers that are reachable."""
    session.send("HeapProfiler.collectGarbage")
    usage = session.send("Runtime.getHeapUsage")
    return (usage["usedSize"] + usage.get("backingStorageSize", 0)) / 1024


def slope(minutes, kb):
    return np.polyfit(minutes, kb, 1)[0]


def memory(program, browser):
    project(program, "memory", 4)
    run = program.run("memory", "--signal", "square", out="memory.mcap")
    viewer = browser.viewer(run.url, SIZE)
    session = viewer.context.new_cdp_session(viewer.page)
    viewer.press("Start")
    viewer.page.wait_for_timeout(90e3)  # the rings of server and page are full
    watched = []
    for minute in np.arange(0, WATCH_MINUTES + 0.1, 0.5):
        watched.append((minute, heap_kb(session), run.resident_kb()))
        viewer.page.wait_for_timeout(30e3)
    minutes, page, server = np.array(watched).T
    run.interrupt()
    pushed = []
    for minute in range(HOUR_MINUTES + 1):
        pushed.append((minute, heap_kb(session)))
        viewer.ask(PUSH_MINUTE, minute)
    ticks, heap = np.array(pushed).T
    print("| what | start [kB] | middle | end | slope [kB/min] | over an hour [kB] |\n|---|---|---|---|---|---|")
    for name, t, kb in [
        (f"page, {WATCH_MINUTES} minutes of the run", minutes, page),
        ("page, an hour pushed as fast as it goes", ticks, heap),
        (f"`flexbeam run`, resident, {WATCH_MINUTES} minutes", minutes, server),
    ]:
        k = slope(t, kb)
        print(f"| {name} | {kb[0]:.0f} | {kb[len(kb) // 2]:.0f} | {kb[-1]:.0f} | {k:+.1f} | {60 * k:+.0f} |")
    viewer.close()


with tempfile.TemporaryDirectory() as folder:
    program = Program(os.path.abspath(sys.argv[1]), folder)
    chosen = sys.argv[2:] or ["frame", "memory"]
    try:
        with Browser(os.path.join(folder, "shots")) as browser:
            for bench in [frames, memory]:
                if bench.__name__.startswith(tuple(chosen)):
                    bench(program, browser)
    finally:
        program.end()
