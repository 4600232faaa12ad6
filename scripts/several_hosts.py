#!/usr/bin/env python3
"""Runs weft over TCP on several hosts that are network namespaces of this machine: latency, limited bandwidth, a link
that is cut and restored, a host that is cut off for good or killed; or trials at random of all these. A run that has not
lost a host must make the mesh of one process; one that has must end in time, with an exit code and words of HOST_LOST.
Needs root, ip and Open MPI; says loudly what it cannot do."""

import argparse
import atexit
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from soft_switch import MTU, SoftSwitch

ROOT = pathlib.Path(__file__).resolve().parent.parent
PREFIX = f"weft{os.getpid() % 10000}"
# Open MPI starts its daemon on another host by this: agent HOST COMMAND...
AGENT = """#!/usr/bin/env bash
set -euo pipefail
host=$1; shift
exec ip netns exec {prefix}-${{host##*.}} unshare --uts bash -c 'hostname "$0"; eval "$1"' {prefix}-${{host##*.}} "$*"
"""
# Seconds from the loss of a host. A rank that is silent for so long counts as dead; TCP gives up what nobody acknowledges
# after RETRIES, each of which waits twice as long as the one before, and mpirun's end waits for that; a machine with other
# work needs some more.
SILENCE = int(re.search(r" silence\{([\d']+)\}", (ROOT / "engine/run/runtime.h").read_text())[1].replace("'", "")) / 1000
RETRIES = 6
# Between runs of weft's engine (one rank works alone, others wait for it) a rank's silence means nothing, and nothing is on its
# way that TCP could give up: Open MPI's daemons ask each other then, by default after 300 s and 9 times each 20 s. Here from 15 s
# on, so that they give up after 40: later than weft does in its runs, and later than links that come back.
KEEPALIVE = {"oob_tcp_keepalive_time": 15, "oob_tcp_keepalive_intvl": 5, "oob_tcp_keepalive_probes": 5}
MARGIN = 15
NOTICED = SILENCE + MARGIN
ENDED = SILENCE + 0.2 * (2 ** (RETRIES + 1) - 1) + MARGIN
# How a run ends that has lost a host: exit code of mpirun, what is said, and who notices. The group `rank` or `node` must be
# of the lost host, or, where that is the host of mpirun and cut off, of the others, which it has lost.
HOST_LOST = {
    2: r"error: rank (?P<rank>\d+) died",  # weft, which ends all by MPI_Abort with status 2 (<weft/weft.h>)
    # mpirun ends as what has started its daemon there (ssh, say), or another one: killed, or with an error of its own.
    1: r"unable to reliably start one or more daemons",
    9: r"unable to reliably start one or more daemons",
    137: r"process rank (?P<rank>\d+) with PID \d+ on node \S+ exited on signal 9",  # its daemon there, before it ended too
    205: r"Remote daemon: .* on node (?P<node>\S+)",  # mpirun: the connection to its daemon there is lost
    -signal.SIGKILL: "",  # mpirun was on that host and was killed itself
}


def sh(*words, check=True):
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if check and done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, words))}: {done.stderr.strip()}")
    return done


def skip(why):
    print(f"several_hosts: SKIPPED: {why}", file=sys.stderr)


def address(host):
    return f"10.77.0.{host}"


class Hosts:
    """Namespaces 1 to n at address(1) to address(n), joined by a switch."""

    def __init__(self, count):
        self.count = count
        atexit.register(self.remove)
        names = [self.name(host) for host in range(1, count + 1)]
        for name in names:
            sh("ip", "netns", "add", name)
        self.switch = SoftSwitch(names, "weft0")
        for host, name in enumerate(names, 1):
            self.within(name, "ip", "address", "add", f"{address(host)}/24", "dev", "weft0")
            self.within(name, "ip", "link", "set", "lo", "up")
            self.within(name, "ip", "link", "set", "weft0", "mtu", MTU, "up")
            # Open MPI's daemons notice a silent host by TCP alone, which gives up after a quarter of an hour by default.
            self.within(name, "sh", "-c", f"echo {RETRIES} >/proc/sys/net/ipv4/tcp_retries2")

    def name(self, host):
        return f"{PREFIX}-{host}"

    def within(self, name, *words, check=True):
        return sh("ip", "netns", "exec", name, *words, check=check)

    def works(self, host, program):
        """Whether a process of that program runs there."""
        for pid in sh("ip", "netns", "pids", self.name(host)).stdout.split():
            try:
                if pathlib.Path(f"/proc/{pid}/comm").read_text().strip() == program:
                    return True
            except OSError:
                pass  # it has just ended
        return False

    def left_over(self, host, end):
        """Whether processes of weft have not ended by then; they are killed."""
        while self.works(host, "weft") and time.monotonic() < end:
            time.sleep(0.2)
        left = self.works(host, "weft")
        self.kill(host)
        return left

    def kill(self, host):
        for pid in sh("ip", "netns", "pids", self.name(host), check=False).stdout.split():
            try:
                os.kill(int(pid), signal.SIGKILL)
            except OSError:
                pass

    def link(self, host, up):
        self.switch.link(host - 1, up)

    def remove(self):
        for host in range(1, self.count + 1):
            self.kill(host)
        for host in range(1, self.count + 1):
            sh("ip", "netns", "del", self.name(host), check=False)


class Run:
    """One mpirun of weft over all hosts."""

    def __init__(self, options, hosts, folder, name):
        agent = folder / "agent"
        agent.write_text(AGENT.format(prefix=PREFIX))
        agent.chmod(0o755)
        self.output = folder / f"{name}.meshb"
        addresses = ",".join(f"{address(h)}:{options.ranks}" for h in range(1, hosts.count + 1))
        environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        mpirun = ["mpirun", "--oversubscribe", "--bind-to", "none", "--host", addresses, "-n", hosts.count * options.ranks]
        for key, value in {"plm_rsh_agent": agent, "btl": "tcp,self", "btl_tcp_if_include": "weft0", "oob_tcp_if_include": "weft0",
                           "mpi_yield_when_idle": 1, "orte_keep_fqdn_hostnames": 1, **KEEPALIVE}.items():
            mpirun += ["--mca", key, value]
        weft = [options.weft, "adapt", folder / "start.meshb", "--metric-fn", "polar-2", "--complexity", options.complexity,
                "--subdomains", options.subdomains, "-o", self.output, "--progress", "plain"]
        words = ["ip", "netns", "exec", hosts.name(1), "unshare", "--uts", "bash", "-c", 'hostname "$0"; exec "$@"', hosts.name(1), *mpirun, *weft]
        self.begin = time.monotonic()
        # A file, not a pipe: what goes on on a host that was cut off would keep a pipe open.
        self.said = folder / f"{name}.log"
        with open(self.said, "w") as said:
            self.process = subprocess.Popen(list(map(str, words)), env=environment, stdout=said, stderr=subprocess.STDOUT, start_new_session=True)
        atexit.register(self.kill)

    def kill(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)

    def under_way(self, seconds):
        """Waits until the ranks of all hosts have begun, as the first line of progress tells, and so long more."""
        while self.process.poll() is None and "weft: " not in self.said.read_text():
            time.sleep(0.1)
        time.sleep(seconds)

    def end(self, limit):
        """Exit code (None: it hung), what it said, seconds."""
        try:
            code = self.process.wait(timeout=limit)
        except subprocess.TimeoutExpired:
            self.kill()
            code = None
        return code, self.said.read_text(), time.monotonic() - self.begin

    def end_of_lost(self, before, lost_at):
        """Exit code (None: it hung) of a run that lost a host then, what it said since (`before`: so many characters), seconds
        until weft or mpirun first said so (None: nobody), and until it ended."""
        noticed = None
        while self.process.poll() is None and time.monotonic() < lost_at + ENDED:
            noticed = noticed or self.notice(before, lost_at)
            time.sleep(0.1)
        seconds = time.monotonic() - lost_at
        code = self.process.poll()
        self.kill()
        return code, self.said.read_text()[before:], noticed or self.notice(before, lost_at), seconds

    def notice(self, before, lost_at):
        said = self.said.read_text()[before:]
        return time.monotonic() - lost_at if any(words and re.search(words, said) for words in HOST_LOST.values()) else None


class Trials:
    def __init__(self, options, hosts, folder):
        self.options, self.hosts, self.folder, self.failures = options, hosts, folder, 0
        sh(options.weft, "mesh", "box", "-o", folder / "start.meshb", "--cells", 6, 6, 6)
        one = sh(options.weft, "adapt", folder / "start.meshb", "--metric-fn", "polar-2", "--complexity", options.complexity,
                 "--subdomains", options.subdomains, "--threads", 1, "-o", folder / "one.meshb", "--quiet", check=False)
        self.code, self.bytes = one.returncode, (folder / "one.meshb").read_bytes()

    def say(self, name, good, what):
        self.failures += not good
        print(f"several_hosts: {'ok    ' if good else 'FAILED'} {name}: {what}", flush=True)

    def same_mesh(self, name, meanwhile=lambda run: None):
        run = Run(self.options, self.hosts, self.folder, "out")
        meanwhile(run)
        code, said, seconds = run.end(self.options.limit)
        same = self.is_right(run, code)
        self.say(name, same, f"the mesh of one process in {seconds:.1f} s" if same else f"exit {code} after {seconds:.1f} s\n{said}")
        run.output.unlink(missing_ok=True)

    def is_right(self, run, code):
        return code == self.code and run.output.exists() and run.output.read_bytes() == self.bytes

    def shaped(self, name, meanwhile=lambda run: None, **how):
        self.hosts.switch.shape(**how)
        self.same_mesh(name, meanwhile)
        self.hosts.switch.shape()

    def cut(self, host, after, seconds):
        """What cuts a host off for a while."""
        def meanwhile(run):
            run.under_way(after)
            self.hosts.link(host, False)
            time.sleep(seconds)
            self.hosts.link(host, True)
        return meanwhile

    def cut_and_restored(self, seconds):
        self.same_mesh(f"a link cut for {seconds} s", self.cut(self.hosts.count, self.options.cut_after, seconds))

    def lost(self, name, host, after, lose, cut=False):
        """A host that goes for good: the run ends as HOST_LOST says, in time, no process goes on, and there is no mesh, unless the
        right one was written before."""
        run = Run(self.options, self.hosts, self.folder, "out")
        run.under_way(after)
        before, is_over = len(run.said.read_text()), run.process.poll() is not None
        lost_at = time.monotonic()
        lose(host)
        code, said, noticed, seconds = run.end_of_lost(before, lost_at)
        left = [h for h in range(1, self.hosts.count + 1) if self.hosts.left_over(h, lost_at + ENDED)]
        self.hosts.link(host, True)
        if self.is_right(run, code):
            self.say(name, self.options.random is not None, "the run was over before: a larger --complexity takes longer")
        elif is_over:  # mpirun, for instance, gives up where it can't start all within a minute
            self.say(name, False, f"the run had ended before by itself: exit {code} after {time.monotonic() - run.begin:.1f} s\n{said}")
        else:
            wrong = self.wrong_end(host, cut, code, said, noticed)
            wrong += [f"processes went on on hosts {left}"] if left else []
            wrong += ["it wrote another mesh"] if run.output.exists() and run.output.read_bytes() != self.bytes else []
            what = re.search(f".*{HOST_LOST[code]}.*", said)[0] if not wrong and HOST_LOST[code] else ""
            told = f"exit {code} after {seconds:.1f} s" + (f", noticed after {noticed:.1f} s: {what.strip()}" if what else "")
            self.say(name, not wrong, "; ".join([told, *wrong]) + (f"\n{said}" if wrong else ""))
        run.output.unlink(missing_ok=True)

    def wrong_end(self, host, cut, code, said, noticed):
        """What is not as HOST_LOST has it."""
        if code is None:
            return [f"it hung for {ENDED:.0f} s"]
        if code not in HOST_LOST or (code < 0) != (host == 1 and not cut):
            return ["not an exit code of such a loss"]
        if code < 0:
            return []
        told = re.search(HOST_LOST[code], said)
        if not told:
            return ["not the words of this exit code"]
        wrong = [] if noticed <= NOTICED else [f"noticed after more than {NOTICED:.0f} s"]
        # What is printed comes by mpirun, on host 1.
        gone = range(2, self.hosts.count + 1) if host == 1 else [host]
        named = told.groupdict()
        if "rank" in named and int(named["rank"]) // self.options.ranks + 1 not in gone or \
           "node" in named and named["node"] not in [name for h in gone for name in (self.hosts.name(h), address(h))]:
            wrong.append("it names a rank or node that was not lost")
        return wrong

    def cut_for_good(self, host, after):
        self.lost(f"host {host} cut off for good", host, after, lambda lost: self.hosts.link(lost, False), cut=True)

    def killed(self, host, after):
        self.lost(f"all processes of host {host} killed", host, after, self.hosts.kill)

    def at_random(self, draw):
        """One trial: links of any kind, then perhaps a cut, or a host that goes for good."""
        host, after = draw.randrange(1, self.hosts.count + 1), draw.uniform(0, 2 * self.options.cut_after)
        kind = draw.choices(["slow", "cut", "cut for good", "killed"], [4, 3, 1, 2])[0]
        if kind == "killed":
            return self.killed(host, after)
        if kind == "cut for good":
            return self.cut_for_good(host, after)
        delay = draw.uniform(0, 0.02)
        how = {"delay": delay, "jitter": draw.uniform(0, delay / 2), "loss": 10 ** draw.uniform(-4, -2.3), "rate": 10 ** draw.uniform(6.5, 8)}
        name = f"{1000 * how['delay']:.1f} +- {1000 * how['jitter']:.1f} ms, {100 * how['loss']:.2f} % lost, {8e-6 * how['rate']:.0f} Mbit/s"
        if kind == "slow":
            return self.shaped(name, **how)
        seconds = draw.uniform(0.5, 8)
        return self.shaped(f"{name}, host {host} cut off for {seconds:.1f} s", self.cut(host, after, seconds), **how)


def why_not():
    if os.geteuid() != 0:
        return "network namespaces need root"
    for tool in ("ip", "unshare", "mpirun"):
        if shutil.which(tool) is None:
            return f"{tool} is not installed"
    if "Open MPI" not in sh("mpirun", "--version", check=False).stdout:
        return "mpirun is not Open MPI's"
    if not os.access("/dev/net/tun", os.R_OK | os.W_OK):
        return "there is no /dev/net/tun, for devices of programs"
    made = sh("ip", "netns", "add", f"{PREFIX}-t", check=False)
    sh("ip", "netns", "del", f"{PREFIX}-t", check=False)
    return f"network namespaces are not permitted here: {made.stderr.strip()}" if made.returncode != 0 else None


def end_by_signal(*_):
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # while what was made is removed
    sys.exit("several_hosts: ended by a signal")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--weft", default=ROOT / "build/bin/weft", type=pathlib.Path)
    parser.add_argument("--hosts", type=int, default=3, choices=range(2, 9))
    parser.add_argument("--ranks", type=int, default=1, help="of each host")
    parser.add_argument("--subdomains", type=int, default=12)
    parser.add_argument("--complexity", type=int, default=60_000)
    parser.add_argument("--cut-after", type=float, default=2, help="seconds after the ranks have begun")
    parser.add_argument("--limit", type=float, default=600, help="seconds after which a run hangs")
    parser.add_argument("--only", choices=["plain", "latency", "bandwidth", "restored", "cut", "killed"], help="one of the trials")
    parser.add_argument("--repeat", type=int, help="of the trials (default 1)")
    parser.add_argument("--random", type=int, help="so many trials at random in place of these")
    parser.add_argument("--seed", type=int, help="of the first at random; the next ones count on (default 1)")
    options = parser.parse_args()
    for unused in ("only", "repeat") if options.random is not None else ("seed",):
        if getattr(options, unused) is not None:
            parser.error(f"--{unused} has no effect {'with' if options.random is not None else 'without'} --random")
    if min(n for n in (options.repeat, options.random, options.ranks, 1) if n is not None) < 1:
        parser.error("--repeat, --random, --ranks: at least 1")
    options.weft = options.weft.resolve()
    signal.signal(signal.SIGTERM, end_by_signal)
    if why := why_not():
        return skip(why)
    with tempfile.TemporaryDirectory(prefix="weft-hosts-") as folder:
        hosts = Hosts(options.hosts)
        trials = Trials(options, hosts, pathlib.Path(folder))
        first = 1 if options.seed is None else options.seed
        for seed in range(first, first + (options.random or 0)):
            trials.at_random(random.Random(seed))
        for _ in range(0 if options.random else options.repeat or 1):
            for name, trial in {
                "plain": lambda: trials.same_mesh(f"{options.hosts} hosts"),
                "latency": lambda: trials.shaped("latency of 20 ms, jitter 5 ms, 0.1 % lost", delay=0.02, jitter=0.005, loss=0.001),
                "bandwidth": lambda: trials.shaped("100 Mbit/s", rate=100e6 / 8),
                "restored": lambda: trials.cut_and_restored(3),
                "cut": lambda: trials.cut_for_good(options.hosts, options.cut_after),
                "killed": lambda: trials.killed(options.hosts, options.cut_after),
            }.items():
                if options.only in (None, name):
                    trial()
    return 1 if trials.failures else 0


if __name__ == "__main__":
    sys.exit(main())
