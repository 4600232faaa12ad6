#!/usr/bin/env python3
"""The example of blueprint.h compiles; changed so that types do not fit, it does not, and the compiler says why."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
COMPILER = os.environ.get("WEFT_CXX", "c++")


def example():
    """The struct in the comment that blueprint.h opens with."""
    lines = (ROOT / "graph/dataflow/blueprint.h").read_text().splitlines()
    comment = [line[len("//     "):] for line in lines if line.startswith("//     ")]
    return "\n".join(comment[: comment.index("};") + 1])


PRECOMPILED = tempfile.TemporaryDirectory()


def precompile():
    """The header, read once: it takes most of a program's time."""
    header = pathlib.Path(PRECOMPILED.name) / "header.h"
    header.write_text('#include "graph/dataflow/blueprint.h"\n')
    subprocess.run([COMPILER, "-std=c++20", f"-I{ROOT}", "-x", "c++-header", header, "-o", f"{header}.gch"], check=True)
    return header


def compile_errors(struct):
    """What the compiler says to a program with this struct; nothing when it compiles."""
    source = ("using namespace weft::graph::dataflow;\n"
              f"{struct}\n"
              "void use(weft::engine::Registry& registry) { register_blueprint<Subdomain>(registry); }\n")
    command = [COMPILER, "-std=c++20", "-fsyntax-only", f"-I{ROOT}", "-include", HEADER, "-x", "c++", "-"]
    result = subprocess.run(command, input=source, capture_output=True, text=True, check=False)
    return "" if result.returncode == 0 else result.stderr


HEADER = precompile()


class Misuse(unittest.TestCase):
    def refuses(self, old, new, message):
        """The example with `old` replaced by `new` is refused with `message`."""
        struct = example()
        self.assertEqual(struct.count(old), 1, f"the example has no {old}")
        errors = re.sub(r"\s+", " ", compile_errors(struct.replace(old, new)))
        self.assertIn(message, errors)

    def test_the_example_compiles(self):
        self.assertEqual(compile_errors(example()), "")

    def test_local_values_must_fit(self):
        self.refuses("double adapt(", "int adapt(", "the output of the first node is not the input of the second")

    def test_one_alternative_must_fit(self):
        self.assertEqual(compile_errors(example().replace("double adapt(", "std::variant<int, double> adapt(")), "")
        for other in ("std::variant<int, float>", "std::variant<double, double>"):
            self.refuses("double adapt(", f"{other} adapt(", "the output of the first node is not the input of the second")

    def test_remote_values_must_fit(self):
        self.refuses("g.remote<double>", "g.remote<float>", "the value of the edge is not what the event receives")

    def test_sent_values_must_fit(self):
        self.refuses("round, quality)", "round, 1)", "the value sent is not of the type that the event receives")

    def test_nodes_have_node_bodies(self):
        self.refuses("g.node<&Subdomain::propose>", "g.node<&Subdomain::gather>", "a node's body must be Out State::body")

    def test_events_have_event_bodies(self):
        self.refuses("g.event<&Subdomain::gather>", "g.event<&Subdomain::adapt>", "an event's body must be Out State::body")

    def test_inputs_are_not_changed_in_place(self):
        self.refuses("double size)", "double& size)", "by value or by reference to const")

    def test_local_edges_do_not_end_at_events(self):
        self.refuses("g.local(adapt, propose)", "g.local(adapt, gather)", "a local edge cannot end at an event")

    def test_remote_edges_end_at_events(self):
        self.refuses("(propose, gather)", "(propose, adapt)", "a remote edge ends at an event")

    def test_wakes_take_a_round(self):
        self.refuses("return g;", 'g.wakes<&Subdomain::adapt>(gather, "wake"); return g;',
                     "a body that wakes must be Out State::body(NodeContext&, std::uint64_t round)")


if __name__ == "__main__":
    unittest.main()
