"""Runs of the real program, for a browser to look at, and what their recordings say afterwards."""

import json
import os
import queue
import re
import signal
import subprocess
import threading
import time

import numpy as np
from mcap.reader import SeekingReader
from mcap_ros2.decoder import DecoderFactory

# No stall of a shared machine ends these runs: what is tested is what people see and do.
PATIENT = ["--hold", "60"]

# A person would have lost patience long before; a busy machine has not.
LONG_S = 60.0


def until(what, holds, patience_s=LONG_S):
    """What `holds` returns, as soon as it is true."""
    end = time.monotonic() + patience_s
    while True:
        found = holds()
        if found:
            return found
        if time.monotonic() > end:
            raise AssertionError(f"never within {patience_s:.0f} s: {what}")
        time.sleep(0.02)


class Program:
    """`flexbeam`, in a folder of its own."""

    def __init__(self, program, folder):
        self.program, self.folder, self.runs = program, folder, []
        os.makedirs(folder, exist_ok=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def done(self, line):
        """Standard output of a command that succeeds."""
        ended = subprocess.run([self.program, *line.split()], cwd=self.folder, capture_output=True, text=True)
        assert ended.returncode == 0, f"flexbeam {line}: {ended.stderr}"
        return ended.stdout

    def controller(self):
        """A controller of the paper's rig, its law measured: a fraction of a second."""
        for line in [
            "record --linear --duration 4",
            "identify recording.csv --order 4",
            "design model.toml --stability-degree 1.5 --uncertainty beam",
            "rig test --apply-to controller.toml",
        ]:
            self.done(line)
        return "controller.toml"

    def run(self, what, *words, out="run.mcap", port=0):
        """A run that waits for its start and can be watched."""
        watched = ["--scope", f"127.0.0.1:{port}", "--scope-token-file", "token"]
        run = Run(self, ["run", what, "--wait", "--plain", "-o", out, *PATIENT, *watched, *words], out)
        self.runs.append(run)
        return run

    def end(self):
        for run in self.runs:
            run.kill()


class Run:
    """One run, from its first line on standard error to its exit status."""

    def __init__(self, program, words, out):
        self.folder, self.out = program.folder, out
        self.process = subprocess.Popen(
            [program.program, *words], cwd=program.folder, stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )
        self.lines, self.said = queue.Queue(), []
        threading.Thread(target=self._listen, daemon=True).start()
        self.url = self._hear(r"scope: (http://\S+)").group(1)
        self.base, self.token = self.url.split("#")
        self.port = int(re.search(r":(\d+)/", self.base).group(1))

    def _listen(self):
        for line in self.process.stderr:
            self.lines.put(line)
        self.lines.put(None)

    def _hear(self, pattern):
        while True:
            line = self.lines.get(timeout=LONG_S)
            assert line is not None, "the run ended before it said where its scope is:\n" + "".join(self.said)
            self.said.append(line)
            found = re.search(pattern, line)
            if found:
                return found

    def status(self):
        """Its exit status, once it has ended by itself."""
        return self.process.wait(timeout=LONG_S)

    def interrupt(self):
        """Ctrl-C: the run ends at 0 V."""
        self.process.send_signal(signal.SIGINT)
        return self.status()

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def resident_kb(self):
        """Memory of the process that is in RAM."""
        with open(f"/proc/{self.process.pid}/status") as file:
            return int(re.search(r"VmRSS:\s+(\d+)", file.read()).group(1))

    def recording(self):
        return Recording(os.path.join(self.folder, self.out))


class Recording:
    """An MCAP file as PyPI's readers see it: samples, settings, events, report."""

    def __init__(self, path):
        self.samples, self.settings, self.events, reports = [], [], [], []
        topics = {"/settings": self.settings, "/events": self.events, "/report": reports}
        with open(path, "rb") as file:
            for schema, channel, message in SeekingReader(file, validate_crcs=True).iter_messages():
                if channel.topic == "/signals":
                    decode = DecoderFactory().decoder_for(channel.message_encoding, schema)
                    self.samples.append(decode(message.data))
                elif channel.topic in topics:
                    topics[channel.topic].append(json.loads(message.data))
        self.report = reports[-1] if reports else None

    def by_tick(self):
        return {sample.tick: sample for sample in self.samples}

    def said(self, kind):
        return [event["text"] for event in self.events if event["kind"] == kind]


def as_recorded(held, recording, lost=0):
    """What a page holds is what was recorded, to the last bit of a float32; nothing between is missing but what was announced."""
    ours = recording.by_tick()
    ticks = [int(tick) for tick in held["tick"]]
    assert len(ticks) > 100 and ticks == sorted(set(ticks)), "ticks rise"
    have = set(ticks)
    missing = [tick for tick in range(ticks[0], ticks[-1]) if tick in ours and tick not in have]
    assert len(missing) == lost, f"{len(missing)} samples are missing, {lost} are announced"
    for key in held.keys() - {"tick"}:
        recorded = np.array([getattr(ours[tick], key) for tick in ticks], dtype=np.float32)
        seen = held[key].astype(np.float32)
        differ = [tick for tick, a, b in zip(ticks, recorded, seen) if a != b and not (a != a and b != b)]
        assert not differ, f"{key} differs at {differ[:5]} of {len(differ)}"
