"""`weft loop`: cycles with a real solver, resumption after kills and Ctrl-C, bad configurations."""

import csv
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

from command import WEFT, CommandTest, solution_text

SOLVER = pathlib.Path(os.environ["WEFT_EXAMPLE_SOLVER"]).resolve()
LAUNCHER = " ".join([*os.environ["WEFT_MPIRUN"].split(";"), "-n 2"])
POISSON = f"{SOLVER} poisson smooth {{mesh}} {{solution}}"


class LoopTest(CommandTest):
    def setUp(self):
        super().setUp()
        self.box(5)
        self.config = {"mesh": "box.meshb", "solver": POISSON, "complexities": [300, 600], "adapt": {"threads": 1}}

    def write_config(self, **changes):
        self.config.update(changes)
        return self.write("run.json", json.dumps(self.config))

    def loop(self, expect=0, **changes):
        return self.weft("loop", self.write_config(**changes), expect=expect)

    def fails(self, *says, **changes):
        done = self.loop(expect=2, **changes)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        for word in ("weft: ", *says):
            self.assertIn(word, done.stderr)

    def kept(self, cycle):
        return sorted(path.name for path in (self.folder / f"run/{cycle:03}").iterdir())

    def error(self, cycle):
        return json.loads((self.folder / f"run/{cycle:03}/solver.log").read_text())["l2_error"]


class Cycles(LoopTest):
    def test_the_error_falls_at_the_rate_of_theory(self):
        self.loop(complexities=[1000, 2000, 4000], metric={"hgrad": 1.5}, transfer="conservative")
        rate = math.log(self.error(1) / self.error(3)) / math.log(4)
        self.assertGreater(rate, 0.95 * 2 / 3)
        with open(self.folder / "run/cycles.csv") as table:
            rows = list(csv.DictReader(table))
        self.assertEqual([row["cycle"] for row in rows], ["0", "1", "2", "3"])
        self.assertAlmostEqual(float(rows[3]["complexity"]), 4000, delta=100)
        report = json.loads((self.folder / "run/003/report.json").read_text())
        self.assertEqual(report["fields"]["transfer"], "conservative")

    def test_the_first_mesh_is_not_replaced(self):
        (self.folder / "run/002").mkdir(parents=True)
        (self.folder / "box.meshb").rename(self.folder / "run/002/mesh.meshb")
        self.fails("run.json: mesh", "would be replaced by that of cycle 2", mesh="run/002/mesh.meshb")
        self.assertEqual(self.files(), ["run", "run.json"])

    def test_a_solution_that_is_the_first_mesh_is_not_replaced(self):
        for cycle in (0, 2):
            mesh = f"run/{cycle:03}/solution.vtu"
            (self.folder / mesh).parent.mkdir(parents=True)
            self.weft("convert", "box.meshb", mesh)
            before = (self.folder / mesh).read_bytes()
            self.fails("run.json: mesh", f"would be replaced by the solution of cycle {cycle}", mesh=mesh, solution_extension=".vtu")
            self.assertEqual((self.folder / mesh).read_bytes(), before)

    def test_everything_is_kept(self):
        text = self.loop().stdout
        self.assertIn("cycle 2 of 2: complexity", text)
        self.assertEqual(self.kept(0), ["done.json", "solution.solb", "solver.log"])
        self.assertEqual(self.kept(1), ["done.json", "mesh-fields.solb", "mesh.meshb", "mesh.solb", "report.json",
                                        "solution.solb", "solver.log"])
        self.weft("verify", "run/002/mesh.meshb", "--against", "box.meshb")

    def test_placeholders_are_quoted(self):
        self.folder = self.folder / "it's a folder"
        self.folder.mkdir()
        self.box(3)
        say = "echo cycle {cycle} from {restart} with ${HOME:+braces} > said; "
        self.loop(solver=say + POISSON, complexities=[100], cycles=2, mesh_extension=".mesh", folder="other name")
        self.assertEqual(self.files(), ["box.meshb", "other name", "run.json", "said"])
        said = (self.folder / "said").read_text()
        self.assertTrue(said.startswith("cycle 2 from "), said)
        self.assertIn("it's a folder/other name/002/mesh-fields.sol with", said)
        self.assertTrue((self.folder / "other name/002/solution.sol").exists())


    def test_of_pieces_the_mesh_is_the_restart(self):
        solver = "if [ {cycle} != 0 ]; then cp {restart} restart || exit 3; fi; " + POISSON
        for name, adapt in (("one", {"threads": 1}), ("several", {"threads": 1, "subdomains": 2})):
            self.loop(solver=solver, complexities=[300], mesh_extension=".pvtu", adapt=adapt, folder=name)
            restart = (self.folder / "restart").read_bytes()
            self.assertEqual(restart, (self.folder / name / "001/mesh.pvtu").read_bytes())
            self.assertIn(b'Name="solution', restart)


class OnRanks(LoopTest):
    def test_adaptations_run_on_the_ranks_of_the_launcher_and_the_solver_by_its_own_line(self):
        solver = "echo $OMPI_COMM_WORLD_SIZE$PMI_SIZE > ranks; " + POISSON
        text = self.loop(solver=solver, metric={"hgrad": 1.5, "norm": 4}, transfer="conservative",
                         adapt={"launcher": LAUNCHER, "subdomains": 4}).stdout
        self.assertRegex(text, r"cycle 2 of 2: complexity .* adapted on 2 ranks in ")
        self.assertEqual((self.folder / "ranks").read_text().strip(), "", "the solver was not started by mpirun")
        self.assertEqual(self.kept(1), ["adapt.log", "done.json", "mesh-fields.solb", "mesh.meshb", "mesh.solb", "report.json",
                                        "solution.solb", "solver.log"])
        report = json.loads((self.folder / "run/002/report.json").read_text())
        self.assertEqual((report["subdomains"]["ranks"], report["subdomains"]["subdomains"], report["threads"]), (2, 4, 1))
        self.assertEqual(report["fields"]["transfer"], "conservative")
        self.weft("verify", "run/002/mesh.meshb", "--against", "box.meshb")
        # The same mesh as the command makes of the same options.
        self.weft("adapt", "run/001/mesh.meshb", "--sol", "run/001/solution.solb", "--field", "run/001/solution.solb", "--complexity", 600,
                  "--hgrad", 1.5, "--norm", 4, "--transfer", "conservative", "--subdomains", 4, "--threads", 1, "-o", "same.meshb",
                  expect=(0, 1))
        self.assertEqual((self.folder / "same.meshb").read_bytes(), (self.folder / "run/002/mesh.meshb").read_bytes())

    def test_a_rank_that_fails_is_told_with_the_cycle(self):
        self.fails("run.json: adapt.launcher: cycle 1: ended with 3", "adapt.log", adapt={"launcher": "exit 3 #"})
        self.fails("run.json: adapt.launcher: cycle 1: wrote no mesh", adapt={"launcher": ": #"})
        self.fails("run.json: adapt.launcher: cycle 1: ended with ", "none.step", "adapt.log",
                   adapt={"launcher": LAUNCHER, "geometry": "none.step"})
        self.loop(adapt={"threads": 1})  # goes on in the cycle that failed

    def test_the_loop_itself_is_not_started_by_mpirun(self):
        done = subprocess.run([*LAUNCHER.split(), str(WEFT), "loop", self.write_config()], cwd=self.folder,
                              capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(done.stderr.count("start the loop without it"), 1, done.stderr)
        self.assertFalse((self.folder / "run").exists())


class Memory(LoopTest):
    MEASURE = "import resource, subprocess, sys; subprocess.run(sys.argv[1:]); print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"

    def peak(self, cells):
        """Of a loop, in bytes, that ends where its first adaptation would be started."""
        self.box(cells)
        values = self.write("sizes.sol", solution_text([(i % 7,) for i in range((cells + 1)**3)], kind=1))
        config = self.write_config(solver=f"cp {values} {{solution}} # {{mesh}}", solution_extension=".sol", adapt={"launcher": "exit 3 #"})
        # By a process of its own: what is forked begins with the peak of its parent.
        measured = subprocess.run([sys.executable, "-c", self.MEASURE, str(WEFT), "loop", config], cwd=self.folder, capture_output=True,
                                  text=True)
        self.assertIn("ended with 3", measured.stderr)
        shutil.rmtree(self.folder / "run")
        return int(measured.stdout.split()[-1]) * 1024

    def test_a_loop_with_a_launcher_does_not_hold_the_mesh(self):
        few, many = self.peak(2), self.peak(48)
        self.assertLess(many - few, 0.3 * (self.folder / "box.meshb").stat().st_size)


class Resumption(LoopTest):
    SLOW = "if [ {cycle} = 2 ] && [ -e slow ]; then echo $$ > pid; exec sleep 100; fi; " + POISSON

    def start_slow(self):
        """Starts the loop and waits until its solver hangs in cycle 2."""
        self.write("slow", "")
        self.write_config(solver=self.SLOW, complexities=[300, 400, 500])
        process = subprocess.Popen([str(WEFT), "loop", "run.json"], cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        for _ in range(1000):
            if (self.folder / "pid").exists() and (self.folder / "pid").read_text().strip():
                return process, int((self.folder / "pid").read_text())
            time.sleep(0.05)
        self.fail("the solver was not started")

    def go_on(self):
        (self.folder / "slow").unlink()
        before = (self.folder / "run/001/mesh.meshb").stat().st_mtime_ns
        text = self.weft("loop", "run.json").stdout
        self.assertIn("cycles 0 to 1 are done already", text)
        self.assertIn("cycle 3 of 3", text)
        self.assertEqual((self.folder / "run/001/mesh.meshb").stat().st_mtime_ns, before)

    def test_after_a_kill(self):
        process, solver = self.start_slow()
        process.kill()
        process.wait()
        self.assertNotIn("done.json", self.kept(2))
        self.assertIn("still runs", self.weft("loop", "run.json", expect=2).stderr)
        os.kill(solver, signal.SIGKILL)
        time.sleep(0.2)
        for name in (".weft-1-cycles.csv", "002/.weft-1-2.tmp"):  # as if killed while writing
            self.write("run/" + name, "half")
        self.go_on()
        self.assertEqual(list((self.folder / "run").rglob(".weft-*")), [])

    def test_after_an_interruption(self):
        process, solver = self.start_slow()
        process.send_signal(signal.SIGINT)
        text, _ = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 1)
        self.assertIn("interrupted in cycle 2", text)
        with self.assertRaises(ProcessLookupError):
            os.kill(solver, 0)
        self.go_on()

    def test_more_complexities_later(self):
        self.loop()
        text = self.loop(complexities=[300, 600, 700]).stdout
        self.assertIn("cycles 0 to 2 are done already", text)
        self.assertEqual(text.count("cycle 3 of 3"), 1)
        self.assertNotIn("cycle 2 of 3", text)

    def test_a_removed_cycle_takes_the_later_ones_with_it(self):
        self.loop()
        (self.folder / "run/001/done.json").unlink()
        text = self.loop().stdout
        self.assertIn("cycle 1 of 2", text)
        self.assertIn("cycle 2 of 2", text)

    def test_a_removed_folder_takes_the_later_cycles_with_it(self):
        """Also where the loop does not come to them: its next run must not take them for those of the new one."""
        self.loop(solver="if [ {cycle} = 1 ] && [ -e broken ]; then exit 3; fi; " + POISSON)
        shutil.rmtree(self.folder / "run/001")
        (self.folder / "run/002/checkpoints").mkdir()
        self.write("broken", "")
        self.assertIn("cycle 1: ended with 3", self.loop(expect=2).stderr)
        self.assertFalse({"done.json", "checkpoints"} & set(self.kept(2)), self.kept(2))

    def test_changed_settings_are_refused(self):
        self.loop()
        self.fails("run.json: complexity: has changed since cycle 1", "001", complexities=[301, 600])
        self.fails("run.json: metric: has changed since cycle 1", complexities=[300, 600], metric={"hgrad": 1.3})
        self.fails("run.json: solver: has changed since cycle 0", metric={}, solver=POISSON + " ")
        for text in ("{}", '{"schema": 1}'):
            (self.folder / "run/001/done.json").write_text(text)
            self.fails("001/done.json", "no marker", solver=POISSON)


class AnyOption(LoopTest):
    def test_of_adapt_has_its_effect_here_and_on_ranks(self):
        launcher = {"launcher": LAUNCHER, "subdomains": 3}
        for adapt in ({"threads": 1}, launcher):
            self.loop(complexities=[300], metric={"hgrad": 1.3, "implied": True},
                      adapt={**adapt, "no_swap": True, "freeze": "tets", "max_memory": 8e9}, folder="with")
            counts = json.loads((self.folder / "with/001/report.json").read_text())["operations"]
            self.assertEqual(sum(counts[name]["done"] for name in counts if "swap" in name), 0, counts)
            self.assertGreater(sum(counts[name]["done"] for name in counts), 0)
            self.config.pop("folder")
            subprocess.run(["rm", "-r", self.folder / "with"], check=True)

    def test_checkpoints_of_an_adaptation_go_when_it_is_done(self):
        self.loop(adapt={"threads": 1, "checkpoint_every": 0.01})
        self.assertNotIn("checkpoints", self.kept(2))
        self.assertNotIn("checkpoints.json", self.kept(2))

    def test_checkpoints_of_one_mesh_are_none_of_a_run_on_ranks(self):
        checkpoint = self.folder / "run/001/checkpoints/left"
        here = {"threads": 1, "max_memory": 1e6, "checkpoint_every": 60}
        self.loop(expect=2, adapt=here)
        checkpoint.parent.mkdir(exist_ok=True)
        checkpoint.touch()
        self.loop(expect=2, adapt=here)
        self.assertTrue(checkpoint.exists())
        self.loop(expect=2, adapt={**here, "launcher": "exit 3 #"})
        self.assertFalse(checkpoint.exists())

    def test_an_adaptation_that_was_killed_goes_on(self):
        config = self.write_config(complexities=[60000], adapt={"threads": 1, "checkpoint_every": 0.05})
        running = subprocess.Popen([WEFT, "loop", config, "--quiet"], cwd=self.folder)
        checkpoints = self.folder / "run/001/checkpoints"
        while running.poll() is None and not list(checkpoints.glob("*/complete")):
            time.sleep(0.02)
        running.send_signal(signal.SIGKILL)
        running.wait()
        self.assertTrue(list(checkpoints.glob("*/complete")), list(checkpoints.glob("*")))
        self.loop()
        report = json.loads((self.folder / "run/001/report.json").read_text())
        self.assertIn("checkpoints", report["checkpoints"]["resumed"])
        self.assertFalse(checkpoints.exists())


class Failures(LoopTest):
    def test_of_the_solver(self):
        self.fail_in_all_ways()

    def test_of_the_solver_where_a_launcher_starts_adaptations(self):
        self.config["adapt"] = {"launcher": "exit 3 #"}
        self.fail_in_all_ways()

    def fail_in_all_ways(self):
        self.fails("run.json: solver: cycle 0: ended with 3", "solver.log", solver="exit 3 # {mesh} {solution}")
        self.fails("cycle 0: ended with 137", solver="kill -9 $$ # {mesh} {solution}")
        self.fails("cycle 0: wrote no", "000/solution.solb", solver="true {mesh} {solution}")
        self.fails("solution.solb", solver="echo nonsense > {solution} # {mesh}")
        copy = "cp {} {{solution}} # {{mesh}}"
        self.write("short.sol", solution_text([(1,)] * 7, kind=1))
        self.fails("solution.sol", "another mesh", solver=copy.format("short.sol"), solution_extension=".sol")
        n = 6**3
        self.write("nan.sol", solution_text([(1,)] * 8 + [("nan",)] + [(1,)] * (n - 9), kind=1))
        self.fails("solution.sol", "vertex 9", solver=copy.format("nan.sol"))
        self.write("vector.sol", solution_text([(1, 2, 3)] * n, kind=2))
        self.fails("solution.sol", "no scalar field", solver=copy.format("vector.sol"))
        self.assertFalse((self.folder / "run/000/done.json").exists())

    def test_of_a_solution_in_a_mesh_file(self):
        n = 6**3
        for name, rows in (("good", [(7.25,)] + [(1,)] * (n - 1)), ("vector", [(1, 2, 3)] * n)):
            self.write(f"{name}.sol", solution_text(rows, kind=1 if len(rows[0]) == 1 else 2))
        self.weft("mesh", "box", "-o", "small.meshb", "--cells", 3)
        self.write("short.sol", solution_text([(1,)] * 64, kind=1))
        for extension, nan in ((".vtu", "field 1: vertex 1: not a finite number"), (".msh", "field 1: vertex 1: not a finite number"),
                               (".pvtu", "field 1: vertex "), (".cgns", None)):
            solver = f"cp {{}}_*.vtu run/000; cp {{}}{extension} {{{{solution}}}} # {{{{mesh}}}}"
            words = [] if extension == ".cgns" else ["--encoding", "ascii"]
            for name in ("good", "short", "vector"):
                self.weft("convert", "small.meshb" if name == "short" else "box.meshb", name + extension, "--sol", name + ".sol", *words)
            self.weft("convert", "box.meshb", "none" + extension, *words)
            fails = {"short": "belongs to another mesh: it has ", "vector": "has no scalar field", "none": "holds no fields at vertices"}
            if nan:
                for file in self.folder.glob("good*" + extension.replace("p", "")):
                    bad = file.with_name(file.name.replace("good", "bad"))
                    bad.write_text(file.read_text().replace("7.25", "nan"))
                if extension == ".pvtu":
                    self.write("bad.pvtu", (self.folder / "good.pvtu").read_text().replace("good_", "bad_"))
                fails["bad"] = nan
            for name, says in fails.items():
                with self.subTest(extension=extension, name=name):
                    for adapt in ({"threads": 1}, {"launcher": "exit 3 #"}):
                        self.fails(says, solver=solver.format(name, name), solution_extension=extension, adapt=adapt)
            self.fails("cycle 1: ended with 3", solver=solver.format("good", "good"))
            shutil.rmtree(self.folder / "run")
            for file in self.folder.glob("*.vtu"):
                file.unlink()

    def test_of_a_limit(self):
        for adapt in ({"threads": 1}, {"launcher": LAUNCHER, "force": True}):
            told = self.loop(expect=2, adapt={**adapt, "max_memory": 1e6}).stderr
            self.assertIn("run.json: adapt: cycle 1: ended early: memory limit", told)
        self.loop(adapt={"threads": 1})  # goes on in the cycle that failed

    def test_of_a_result_that_was_not_measured(self):
        """As when memory runs out once the mesh is written."""
        self.write("launch.py", "import json, pathlib, subprocess, sys\n"
                   "code = subprocess.call(sys.argv[1:])\n"
                   "path = pathlib.Path(sys.argv[sys.argv.index('--report') + 1]) / 'report.json'\n"
                   "path.write_text(json.dumps(json.loads(path.read_text()) | {'after': None}))\n"
                   "sys.exit(code)\n")
        self.fails("run.json: adapt: cycle 1: ", "not measured", "001/report.json", adapt={"launcher": f"{sys.executable} {self.folder}/launch.py"})
        self.assertFalse((self.folder / "run/001/done.json").exists())

    def test_of_a_configuration(self):
        for changes, says in [
            ({"mesh": None}, "mesh: must be a string"),
            ({"mesh": "none.meshb"}, "mesh: there is no file"),
            ({"solver": ""}, "solver: must be a string"),
            ({"solver": "run {mesh}"}, "solver: does not say {solution}"),
            ({"complexities": []}, "complexities: must be a list"),
            ({"complexities": 1000}, "complexities: must be a list"),
            ({"complexities": [1, -1]}, "complexities[1]: must be a number above zero"),
            ({"complexities": [1e999]}, "JSON"),
            ({"cycles": 1.5}, "cycles: must be a whole number"),
            ({"cycles": 0}, "cycles: must be a number"),
            ({"metric": []}, "metric: must be an object"),
            ({"metric": {"hgrad": "big"}}, "metric.hgrad: must be a number"),
            ({"metric": {"hgrd": 1}}, "metric.hgrd: is unknown; did you mean hgrad?"),
            ({"metric": {"norm": 0.5}}, "metric.norm: must be a number from 1"),
            ({"metric": {"recovery": "guess"}}, "metric.recovery: must be l2 or lsq"),
            ({"metric": {"hmin": 2, "hmax": 1}}, "metric.hmin: is larger than hmax"),
            ({"adapt": {"threads": 0}}, "adapt.threads"),
            ({"adapt": {"ridge_angle": 200}}, "adapt.ridge_angle: must be at most 180"),
            ({"adapt": {"partitioner": "nobody"}}, "adapt: --partitioner: partitioner 'nobody'"),
            ({"adapt": {"layers_by": "guess"}}, "adapt.layers_by: 'guess' is none of"),
            ({"adapt": {"geometry_scale": 2}}, "adapt: --geometry-scale"),
            ({"adapt": {"geometri": "a.step"}}, "adapt.geometri: is unknown; did you mean geometry?"),
            ({"metric": {"curvature": -1}}, "--curvature"),
            ({"metric": {"geometry": "a.step"}}, "metric.geometry: is unknown"),
            ({"transfer": "magic"}, "transfer: must be conservative or linear"),
            ({"mesh_extension": ".stl"}, "mesh_extension: must be one of"),
            ({"solution_extension": "solb"}, "solution_extension: must begin with a dot"),
            ({"nonsense": 1}, "nonsense: is unknown"),
        ]:
            config = {**self.config, **changes}
            self.write("bad.json", json.dumps(config))
            self.assert_fails("loop", "bad.json", says=["bad.json", says])
        del self.config["mesh"]
        self.write("bad.json", json.dumps(self.config))
        self.assert_fails("loop", "bad.json", says="bad.json: mesh: is missing")

    def test_of_the_file(self):
        self.assert_fails("loop", "none.json", says="none.json: cannot be opened")
        self.write("bad.json", '{"mesh": "a",\n "solver" }')
        self.assert_fails("loop", "bad.json", says=["bad.json: is not JSON: at line 2"])
        self.write("bad.json", '{"mesh": 1e999}')
        self.assert_fails("loop", "bad.json", says="bad.json: has a number that is too large")
        self.write("bad.json", "[]")
        self.assert_fails("loop", "bad.json", says="must be an object")
        self.assert_fails("loop", says="CONFIG", code=64)


if __name__ == "__main__":
    unittest.main()
