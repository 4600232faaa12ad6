"""An Ethernet switch in a process of its own, for hosts that are network namespaces: every link can be slow, narrow, lossy or cut.

Linux has all of that in netem, but many kernels come without. Python forwards some 30,000 frames a second, of up to 9,000 bytes."""

import ctypes
import fcntl
import heapq
import itertools
import multiprocessing
import os
import random
import select
import signal
import struct
import time

MTU = 9000
TUNSETIFF, IFF_TAP, IFF_NO_PI, CLONE_NEWNET = 0x400454CA, 0x2, 0x1000, 0x40000000


def open_tap(namespace, device):
    """A new device in that namespace; what is read from the descriptor is what the host sends."""
    libc = ctypes.CDLL(None, use_errno=True)
    with open("/proc/self/ns/net") as here, open(f"/run/netns/{namespace}") as there:
        if libc.setns(there.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), f"cannot enter {namespace}")
        try:
            tap = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
            fcntl.ioctl(tap, TUNSETIFF, struct.pack("16sH22x", device.encode(), IFF_TAP | IFF_NO_PI))
        finally:
            libc.setns(here.fileno(), CLONE_NEWNET)
    return tap


class Link:
    """To one host: what happens to the frames that go there."""

    def __init__(self):
        self.up, self.free = True, 0.0
        self.shape()

    def shape(self, delay=0.0, jitter=0.0, loss=0.0, rate=None, queue=0.2):
        """Seconds (the jitter either way, so that frames overtake each other), share of frames lost, bytes a second, seconds that
        may wait for them."""
        self.delay, self.jitter, self.loss, self.rate, self.queue = delay, jitter, loss, rate, queue

    def arrival(self, size, now):
        """When a frame of that size is there; None: never."""
        if random.random() < self.loss:
            return None
        sent = now
        if self.rate:
            if self.free - now > self.queue:
                return None
            sent = self.free = max(now, self.free) + size / self.rate
        return sent + max(0.0, self.delay + random.uniform(-self.jitter, self.jitter))


class Forwarder:
    def __init__(self, taps, control):
        self.taps, self.control = taps, control
        self.links = [Link() for _ in taps]
        self.port_of = {}  # address -> port
        self.due, self.numbers = [], itertools.count()
        self.poll = select.poll()
        for descriptor in (*taps, control.fileno()):
            self.poll.register(descriptor, select.POLLIN)

    def run(self):
        ports = {tap: port for port, tap in enumerate(self.taps)}
        while True:
            wait = max(0.0, self.due[0][0] - time.monotonic()) * 1000 if self.due else None
            for descriptor, _ in self.poll.poll(wait):
                if descriptor in ports:
                    self.take(ports[descriptor])
                elif not self.obey():
                    return
            self.deliver()

    def obey(self):
        try:
            what, port, value = self.control.recv()
        except EOFError:  # whoever made the switch is gone
            return False
        if what == "link":
            self.links[port].up = value
        else:
            for link in self.links:
                link.shape(**value)
        self.control.send(None)
        return True

    def take(self, port):
        for _ in range(64):  # then the others
            try:
                frame = os.read(self.taps[port], MTU + 64)
            except BlockingIOError:
                return
            now = time.monotonic()
            self.port_of[frame[6:12]] = port
            known = self.port_of.get(frame[:6])
            for to in range(len(self.taps)) if known is None else [known]:
                arrival = self.links[to].arrival(len(frame), now) if to != port and self.links[port].up else None
                if arrival is not None:
                    heapq.heappush(self.due, (arrival, next(self.numbers), to, frame))

    def deliver(self):
        now = time.monotonic()
        while self.due and self.due[0][0] <= now:
            _, _, to, frame = heapq.heappop(self.due)
            if self.links[to].up:
                try:
                    os.write(self.taps[to], frame)
                except OSError:
                    pass  # the host has no room for it, or is not there yet: a lost frame


def forward(namespaces, device, control, ready):
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends with its maker
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    taps = [open_tap(name, device) for name in namespaces]
    ready.set()
    Forwarder(taps, control).run()


class SoftSwitch:
    """Gives each namespace a device that is plugged into the switch."""

    def __init__(self, namespaces, device):
        self.control, theirs = multiprocessing.Pipe()
        ready = multiprocessing.Event()
        self.process = multiprocessing.Process(target=forward, args=(namespaces, device, theirs, ready), daemon=True)
        self.process.start()
        theirs.close()
        while not ready.wait(0.2):
            if not self.process.is_alive():
                raise RuntimeError("the switch could not plug into the namespaces")

    def tell(self, what, port, value):
        self.control.send((what, port, value))
        self.control.recv()

    def shape(self, **how):
        """All links: see Link.shape()."""
        self.tell("shape", None, how)

    def link(self, port, up):
        self.tell("link", port, up)
