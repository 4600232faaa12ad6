#!/usr/bin/env python3
"""Runs weft over TCP on several hosts that are network namespaces of this machine: latency, limited bandwidth, a link
that is cut and restored, a host that is cut for good. Needs root, ip and Open MPI; says loudly what it cannot do."""

import argparse
import atexit
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PREFIX = f"weft{os.getpid() % 10000}"
# Open MPI starts its daemon on another host by this: agent HOST COMMAND...
AGENT = """#!/usr/bin/env bash
set -euo pipefail
host=$1; shift
exec ip netns exec {prefix}-${{host##*.}} unshare --uts bash -c 'hostname "$0"; eval "$1"' {prefix}-${{host##*.}} "$*"
"""
# Silence after which a rank on another host counts as dead (RuntimeOptions::silence), the grace to agree on it, and
# what mpirun takes to end.
PATIENCE = 120


def sh(*words, check=True):
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if check and done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, words))}: {done.stderr.strip()}")
    return done


def skip(why):
    print(f"several_hosts: SKIPPED: {why}", file=sys.stderr)


class Hosts:
    """Namespaces 1 to n at 10.77.0.1 to n, joined by a bridge in a namespace of its own."""

    def __init__(self, count):
        self.count, self.switch = count, f"{PREFIX}-s"
        atexit.register(self.remove)
        sh("ip", "netns", "add", self.switch)
        self.within(self.switch, "ip", "link", "add", "bridge", "type", "bridge")
        self.within(self.switch, "ip", "link", "set", "bridge", "up")
        for host in range(1, count + 1):
            self.add(host)

    def name(self, host):
        return f"{PREFIX}-{host}"

    def within(self, name, *words, check=True):
        return sh("ip", "netns", "exec", name, *words, check=check)

    def add(self, host):
        name = self.name(host)
        sh("ip", "netns", "add", name)
        self.within(self.switch, "ip", "link", "add", f"port{host}", "type", "veth", "peer", "name", "weft0", "netns", name)
        self.within(self.switch, "ip", "link", "set", f"port{host}", "master", "bridge", "up")
        self.within(name, "ip", "address", "add", f"10.77.0.{host}/24", "dev", "weft0")
        self.within(name, "ip", "link", "set", "lo", "up")
        self.within(name, "ip", "link", "set", "weft0", "up")

    def works(self, host, program):
        """Whether a process of that program runs there."""
        for pid in sh("ip", "netns", "pids", self.name(host)).stdout.split():
            try:
                if pathlib.Path(f"/proc/{pid}/comm").read_text().strip() == program:
                    return True
            except OSError:
                pass  # it has just ended
        return False

    def left_over(self, host, patience):
        """Whether processes of weft have not ended in that time; they are killed."""
        end = time.monotonic() + patience
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

    def shape(self, *words):
        """A queueing discipline on every link; False where the kernel has none such."""
        for host in range(1, self.count + 1):
            self.within(self.switch, "tc", "qdisc", "del", "dev", f"port{host}", "root", check=False)
            if words and self.within(self.switch, "tc", "qdisc", "add", "dev", f"port{host}", "root", *words, check=False).returncode != 0:
                return False
        return True

    def link(self, host, state):
        self.within(self.switch, "ip", "link", "set", f"port{host}", state)

    def remove(self):
        for host in range(1, self.count + 1):
            self.kill(host)
        for name in [self.switch, *map(self.name, range(1, self.count + 1))]:
            sh("ip", "netns", "del", name, check=False)


class Run:
    """One mpirun of weft over all hosts."""

    def __init__(self, options, hosts, folder, name):
        agent = folder / "agent"
        agent.write_text(AGENT.format(prefix=PREFIX))
        agent.chmod(0o755)
        self.output = folder / f"{name}.meshb"
        addresses = ",".join(f"10.77.0.{h}:{options.ranks}" for h in range(1, hosts.count + 1))
        environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        mpirun = ["mpirun", "--oversubscribe", "--bind-to", "none", "--host", addresses, "-n", hosts.count * options.ranks]
        for key, value in {"plm_rsh_agent": agent, "btl": "tcp,self", "btl_tcp_if_include": "weft0", "oob_tcp_if_include": "weft0",
                           "mpi_yield_when_idle": 1, "orte_keep_fqdn_hostnames": 1}.items():
            mpirun += ["--mca", key, value]
        weft = [options.weft, "adapt", folder / "start.meshb", "--metric-fn", "polar-2", "--complexity", options.complexity,
                "--subdomains", options.subdomains, "-o", self.output, "--quiet"]
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

    def under_way(self, hosts, seconds):
        """Waits until ranks work on the last host, and so long more; False when the run was over before."""
        while self.process.poll() is None and not hosts.works(hosts.count, "weft"):
            time.sleep(0.1)
        time.sleep(seconds)
        return self.process.poll() is None

    def end(self, limit):
        """Exit code (None: it hung), what it said, seconds."""
        try:
            code = self.process.wait(timeout=limit)
        except subprocess.TimeoutExpired:
            self.kill()
            code = None
        return code, self.said.read_text(), time.monotonic() - self.begin


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
        same = code == self.code and run.output.exists() and run.output.read_bytes() == self.bytes
        self.say(name, same, f"the mesh of one process in {seconds:.1f} s" if same else f"exit {code} after {seconds:.1f} s\n{said}")
        run.output.unlink(missing_ok=True)

    def shaped(self, name, *words):
        if self.hosts.shape(*words):
            self.same_mesh(name)
        else:
            skip(f"{name}: this kernel has no '{words[0]}'")
        self.hosts.shape()

    def cut_and_restored(self, seconds):
        def cut(run):
            run.under_way(self.hosts, self.options.cut_after)
            self.hosts.link(self.hosts.count, "down")
            time.sleep(seconds)
            self.hosts.link(self.hosts.count, "up")
        self.same_mesh(f"a link cut for {seconds} s", cut)

    def cut_for_good(self):
        run = Run(self.options, self.hosts, self.folder, "out")
        if not run.under_way(self.hosts, self.options.cut_after):
            return self.say("a host cut for good", False, "the run was over before the cut: give a larger --complexity")
        self.hosts.link(self.hosts.count, "down")
        code, said, seconds = run.end(PATIENCE)
        left = self.hosts.left_over(self.hosts.count, PATIENCE)
        self.hosts.link(self.hosts.count, "up")
        if left:
            said += "error: processes went on on the host that was cut off\n"
            code = None
        named = "rank" in said or "10.77.0." in said or self.hosts.name(self.hosts.count) in said
        good = code not in (None, 0) and named  # mpirun has codes of its own and not run.output.exists()
        what = next((line for line in said.splitlines() if "error" in line.lower() or "lost" in line.lower()), said.strip()[:200])
        self.say("a host cut for good", good, f"exit {code} after {seconds:.1f} s: {what}")


def why_not():
    if os.geteuid() != 0:
        return "network namespaces need root"
    for tool in ("ip", "tc", "unshare", "mpirun"):
        if shutil.which(tool) is None:
            return f"{tool} is not installed"
    if "Open MPI" not in sh("mpirun", "--version", check=False).stdout:
        return "mpirun is not Open MPI's"
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
    parser.add_argument("--complexity", type=int, default=4000)
    parser.add_argument("--cut-after", type=float, default=3, help="seconds after the ranks have started")
    parser.add_argument("--limit", type=float, default=600, help="seconds after which a run hangs")
    parser.add_argument("--only", choices=["plain", "latency", "bandwidth", "restored", "cut"], help="one of the trials")
    parser.add_argument("--repeat", type=int, default=1)
    options = parser.parse_args()
    options.weft = options.weft.resolve()
    signal.signal(signal.SIGTERM, end_by_signal)
    if why := why_not():
        return skip(why)
    with tempfile.TemporaryDirectory(prefix="weft-hosts-") as folder:
        hosts = Hosts(options.hosts)
        trials = Trials(options, hosts, pathlib.Path(folder))
        for _ in range(options.repeat):
            for name, trial in {
                "plain": lambda: trials.same_mesh(f"{options.hosts} hosts"),
                "latency": lambda: trials.shaped("latency of 20 ms, jitter 5 ms, 0.1 % lost", "netem", "delay", "20ms", "5ms", "loss", "0.1%"),
                "bandwidth": lambda: trials.shaped("100 Mbit/s", "tbf", "rate", "100mbit", "burst", "64kb", "latency", "200ms"),
                "restored": lambda: trials.cut_and_restored(3),
                "cut": trials.cut_for_good,
            }.items():
                if options.only in (None, name):
                    trial()
    return 1 if trials.failures else 0


if __name__ == "__main__":
    sys.exit(main())
