"""Man pages and shell completion have every subcommand and option of the help, and their programs can read them."""

import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

WEFT = os.environ["WEFT"]
PAGES = pathlib.Path(os.environ["WEFT_HELP_PAGES"])
SECONDS = 60


def run(*words, **more):
    return subprocess.run(words, capture_output=True, text=True, timeout=SECONDS, **more)


def all_commands(command):
    yield command
    for sub in command["commands"]:
        yield from all_commands(sub)


COMMANDS = list(all_commands(json.loads(run(WEFT, "--help-data").stdout)))


def completed(line):
    """What bash offers after `line`."""
    script = f"""source {PAGES}/weft.bash; COMP_WORDS=({line.replace("''", '""')}); COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 ))
_weft; printf '%s\\n' "${{COMPREPLY[@]}}" """
    return [word for word in run("bash", "-c", script, cwd=PAGES).stdout.split("\n") if word]


class HelpPages(unittest.TestCase):
    def test_the_help_names_what_the_data_names(self):
        for command in COMMANDS:
            told = run(*([WEFT] + command["name"].split()[1:] + ["--help"])).stdout
            for option in command["options"]:
                self.assertIn(",".join(option["names"]) if option["names"] else option["value"], told)
                self.assertIn(option["text"], told)

    def test_there_is_a_man_page_for_every_command_with_all_its_options(self):
        for command in COMMANDS:
            page = gzip.decompress((PAGES / "man1" / (command["name"].replace(" ", "-") + ".1.gz")).read_bytes()).decode()
            for option in command["options"]:
                for name in option["names"]:
                    self.assertIn(name.replace("-", "\\-"), page)
        self.assertEqual(len(list((PAGES / "man1").iterdir())), len(COMMANDS))

    def test_man_reads_the_pages_without_warnings(self):
        if not shutil.which("man") or not shutil.which("groff"):
            self.skipTest("no man and groff: scripts/setup.sh --all")
        for page in (PAGES / "man1").iterdir():
            done = run("man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", "-Z", str(page),
                       env=dict(os.environ, MANROFFSEQ="", MANWIDTH="80", LC_ALL="C.UTF-8"))
            self.assertEqual((done.returncode, done.stderr), (0, ""), page.name)

    def test_bash_completes_subcommands_options_and_files(self):
        self.assertIn("adapt", completed("weft ad"))
        self.assertEqual(completed("weft mesh bo"), ["box"])
        self.assertEqual(completed("weft adapt --hgrad-s"), ["--hgrad-space"])
        self.assertIn("--no-interface-refinement", completed("weft adapt in.meshb --no"))
        self.assertNotIn("--metric", completed("weft stat --ma"))
        self.assertIn("weft.fish", completed("weft adapt --metric weft."))
        self.assertEqual(completed("weft adapt --complexity ''"), [])
        for command in COMMANDS:
            known = set(completed(f"{command['name']} -"))
            for option in command["options"]:
                self.assertLessEqual(set(option["names"]), known, command["name"])

    def test_zsh_and_fish_read_theirs(self):
        for shell, file in (("zsh", "_weft"), ("fish", "weft.fish")):
            with self.subTest(shell=shell):
                if not shutil.which(shell):
                    self.skipTest(f"no {shell}: scripts/setup.sh --all")
                done = run(shell, "-n", str(PAGES / file))
                self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_fish_completes_options_of_the_subcommand(self):
        if not shutil.which("fish"):
            self.skipTest("no fish: scripts/setup.sh --all")
        told = run("fish", "-c", f"source {PAGES}/weft.fish; complete -C 'weft adapt --hg'; complete -C 'weft sta'").stdout
        self.assertRegex(told, r"--hgrad\s")
        self.assertIn("stat", told)

    def test_the_reference_has_all_options(self):
        reference = (PAGES / "command.md").read_text()
        for command in COMMANDS:
            section = re.search(rf"\n## {command['name']} .*?(?=\n## |\Z)", reference, re.DOTALL)[0]
            for option in command["options"]:
                for name in option["names"]:
                    self.assertIn(name, section)


if __name__ == "__main__":
    unittest.main()
