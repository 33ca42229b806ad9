"""A road between browser and server that can be cut, fall silent, or slow down to a trickle. On 127.0.0.1 only."""

import socket
import threading
import time

# Small, so that the road itself hides nothing: what it does not carry stays in the server's socket.
BUFFER = 4096


class Road:
    """Forwards `port` (its own) to `to` (the server's)."""

    def __init__(self, to):
        self.to, self.open, self.silent, self.bytes_s = to, True, False, None
        self.carried, self.pairs, self.lock = 0, [], threading.Lock()
        self.door = socket.create_server(("127.0.0.1", 0))
        self.port = self.door.getsockname()[1]
        threading.Thread(target=self._admit, daemon=True).start()

    def url(self, run):
        """The run's address by this road."""
        return f"http://127.0.0.1:{self.port}/#{run.token}"

    def cut(self):
        """Ends every connection and lets nobody in."""
        self.open = False
        with self.lock:
            pairs, self.pairs = self.pairs, []
        for end in (end for pair in pairs for end in pair):
            _shut(end)

    def hush(self):
        """Carries nothing any more and ends nothing: a cable that was pulled."""
        self.silent = True

    def mend(self):
        """As at first. What fell silent is ended, as a network would in the end."""
        if self.silent:
            self.cut()
        self.open, self.silent, self.bytes_s = True, False, None

    def throttle(self, bytes_s):
        """So many bytes a second towards the browser."""
        self.bytes_s = bytes_s

    def close(self):
        self.cut()
        self.door.close()

    def _admit(self):
        while True:
            try:
                near, _ = self.door.accept()
            except OSError:
                return
            threading.Thread(target=self._connect, args=(near,), daemon=True).start()

    def _connect(self, near):
        if not self.open:
            near.close()
            return
        far = socket.socket()
        far.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
        try:
            far.connect(("127.0.0.1", self.to))
        except OSError:
            near.close()
            return
        with self.lock:
            self.pairs.append((near, far))
        threading.Thread(target=self._carry, args=(near, far, False), daemon=True).start()
        self._carry(far, near, True)

    def _carry(self, source, sink, down):
        try:
            while piece := source.recv(BUFFER):
                while self.silent and self.open:
                    time.sleep(0.02)
                rate = self.bytes_s
                if down and rate:
                    time.sleep(len(piece) / rate)
                sink.sendall(piece)
                self.carried += len(piece) if down else 0
        except OSError:
            pass
        _shut(source)
        _shut(sink)


def _shut(end):
    try:
        end.shutdown(socket.SHUT_RDWR)
    except OSError:
        pass
    end.close()
