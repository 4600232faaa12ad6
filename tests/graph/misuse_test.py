#!/usr/bin/env python3
"""The example of blueprint.h compiles; changed so that types do not fit, it does not, and the compiler says why."""

import os
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
COMPILER = os.environ.get("WEFT_CXX", "c++")

# Name: what is replaced in the example, by what, and what the compiler says.
MISUSES = {
    "local_values_must_fit":
        ("double adapt(", "int adapt(", "the output of the first node is not the input of the second"),
    "an_alternative_must_fit":
        ("double adapt(", "std::variant<int, float> adapt(", "the output of the first node is not the input of the second"),
    "one_alternative_alone_must_fit":
        ("double adapt(", "std::variant<double, double> adapt(", "the output of the first node is not the input of the second"),
    "remote_values_must_fit":
        ("g.remote<double>", "g.remote<float>", "the value of the edge is not what the event receives"),
    "sent_values_must_fit":
        ("round, quality)", "round, 1)", "the value sent is not of the type that the event receives"),
    "nodes_have_node_bodies":
        ("g.node<&Subdomain::propose>", "g.node<&Subdomain::gather>", "a node's body must be Out State::body"),
    "events_have_event_bodies":
        ("g.event<&Subdomain::gather>", "g.event<&Subdomain::adapt>", "an event's body must be Out State::body"),
    "inputs_are_not_changed_in_place":
        ("double size)", "double& size)", "by value or by reference to const"),
    "local_edges_do_not_end_at_events":
        ("g.local(adapt, propose)", "g.local(adapt, gather)", "a local edge cannot end at an event"),
    "remote_edges_end_at_events":
        ("(propose, gather)", "(propose, adapt)", "a remote edge ends at an event"),
    "wakes_take_a_round":
        ("return g;", 'g.wakes<&Subdomain::adapt>(gather, "wake"); return g;',
         "a body that wakes must be Out State::body(NodeContext&, std::uint64_t round)"),
}


def example():
    """The struct in the comment that blueprint.h opens with."""
    lines = (ROOT / "graph/dataflow/blueprint.h").read_text().splitlines()
    comment = [line[len("//     "):] for line in lines if line.startswith("//     ")]
    return "\n".join(comment[: comment.index("};") + 1])


def compile_errors(structs):
    """What the compiler says to a program with these structs, each in a namespace and, as it believes, in a file of its name."""
    source = '#include "graph/dataflow/blueprint.h"\n' + "".join(
        f'#line 1 "{name}.case"\nnamespace {name} {{\nusing namespace weft::graph::dataflow;\n{struct}\n'
        "void use(weft::engine::Registry& registry) { register_blueprint<Subdomain>(registry); }\n}\n"
        for name, struct in structs.items())
    command = [COMPILER, "-std=c++20", "-fsyntax-only", "-fmax-errors=0", f"-I{ROOT}", "-x", "c++", "-"]
    result = subprocess.run(command, input=source, capture_output=True, text=True, check=False)
    return "" if result.returncode == 0 else result.stderr


def refused(text, message):
    """The structs that this message is about. From where a template is made GCC says before the error, Clang after it."""
    place = re.compile(r"(?m)^(\w+)\.case:\d+:\d+: ")
    names = set()
    for error in re.finditer(f"error: static assertion failed.*{re.escape(message)}", text):
        before, after = place.findall(text[:error.start()]), place.findall(text[error.end():])
        names.update(after[:1] if "clang" in COMPILER else before[-1:])
    return names


class Misuse(unittest.TestCase):
    def test_the_example_compiles_and_so_it_does_with_an_alternative_that_fits(self):
        fitting = example().replace("double adapt(", "std::variant<int, double> adapt(")
        self.assertNotEqual(fitting, example())
        self.assertEqual(compile_errors({"as_it_is": example(), "with_an_alternative": fitting}), "")

    def test_each_misuse_is_refused_in_words(self):
        """All in one program."""
        for name, (old, new, message) in MISUSES.items():
            self.assertEqual(example().count(old), 1, f"{name}: the example has no {old}")
        errors = compile_errors({name: example().replace(old, new) for name, (old, new, _) in MISUSES.items()})
        for name, (_, _, message) in MISUSES.items():
            with self.subTest(name):
                self.assertIn(name, refused(errors, message), errors)


if __name__ == "__main__":
    unittest.main()
