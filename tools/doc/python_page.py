#!/usr/bin/env python3
"""Makes the reference of the module for Python, in Markdown, of what the module says of itself: signatures, docstrings, and the
stubs' types of what is compiled. python_page.py STUBS TO"""

import ast
import dataclasses
import inspect
import pathlib
import re
import sys
import textwrap

import weft

TYPES = {"_Floats": "np.ndarray", "_Ints": "np.ndarray", "npt.NDArray[np.int64]": "np.ndarray", "npt.": "", "_np.": "np.", "_os.": "os.",
         "'": "", '"': ""}


def tidy(annotation):
    text = str(annotation)
    for word, better in TYPES.items():
        text = text.replace(word, better)
    return text


def call(name, parameters, returns):
    """Lines break between parameters."""
    head = f"{name}("
    words = ", ".join(word.replace(" ", "\0") for word in parameters)
    return textwrap.fill(f"{head}{words})\0->\0{returns}", 110, subsequent_indent=" " * len(head), break_long_words=False,
                         break_on_hyphens=False).replace("\0", " ")


def parameter(p):
    kind = {p.VAR_POSITIONAL: "*", p.VAR_KEYWORD: "**"}.get(p.kind, "")
    annotation = "" if p.annotation is p.empty or p.kind is p.VAR_KEYWORD else f": {tidy(p.annotation)}"
    return kind + p.name + annotation + ("" if p.default is p.empty else f" = {p.default!r}")


def signature(name, function):
    told = inspect.signature(function)
    words = [parameter(p) for p in told.parameters.values()]
    first = next((n for n, p in enumerate(told.parameters.values()) if p.kind is p.KEYWORD_ONLY), None)
    if first is not None:
        words.insert(first, "*")
    return call(f"weft.{name}", words, tidy(told.return_annotation))


def compiled_signature(name, node):
    words = [tidy(word) for word in re.split(r", (?![^\[]*\])", ast.unparse(node.args)) if word != "self"]
    return call(name, words, tidy(ast.unparse(node.returns)))


def said(thing):
    """A docstring; pybind11 puts the signature before that of a method."""
    text = inspect.cleandoc(thing.__doc__ or "")
    return text.partition("\n")[2].strip() if inspect.isroutine(thing) else text


def members(name, kind, stubs):
    if dataclasses.is_dataclass(kind):
        return [f"{field.name}: {tidy(field.type)}" for field in dataclasses.fields(kind)]
    lines = []
    for node in stubs[name].body if name in stubs else []:
        thing = getattr(kind, getattr(node, "name", ""), None)
        if isinstance(thing, property):
            lines += [f"{node.name}: {tidy(ast.unparse(node.returns))}", textwrap.indent(said(thing), "    ")]
        elif thing and not node.name.startswith("__"):
            lines += [compiled_signature(node.name, node), textwrap.indent(said(thing), "    ")]
    return [line for line in lines if line]


def constructor(name, stubs):
    made = [node for node in stubs[name].body if getattr(node, "name", "") == "__init__"] if name in stubs else []
    return [compiled_signature(f"weft.{name}", node).replace(" -> None", "") for node in made]


def block(*paragraphs):
    text = "\n\n".join(paragraph for paragraph in paragraphs if paragraph)
    return f"```none\n{text}\n```\n" if text else ""


def entry(name, *paragraphs):
    return f"### {name} {{#python-{name}}}\n\n{block(*paragraphs)}"


def class_entry(name, kind, stubs):
    bases = ", ".join(base.__name__ for base in kind.__bases__ if base.__name__ not in ("object", "pybind11_object"))
    head = constructor(name, stubs) or [f"class weft.{name}({bases})" if bases else f"class weft.{name}"]
    return entry(name, *head, said(kind), "\n".join(members(name, kind, stubs)))


def page(stubs):
    named = {name: thing for name, thing in vars(weft).items() if name in weft.__all__}
    classes = {"Report": weft._weft.Report, **{name: thing for name, thing in named.items() if inspect.isclass(thing)}}
    yield "# The module weft for Python {#python}\n"
    yield block(inspect.cleandoc(weft.__doc__))
    yield "## Functions {#python-functions}\n"
    yield from (entry(name, signature(name, thing), inspect.cleandoc(thing.__doc__)) for name, thing in named.items()
                if inspect.isfunction(thing))
    yield "## Options of adapt() {#python-named-options}\n"
    yield block("\n".join(f"{option.name:24}{option.type:10}{option.text}" for option in weft.options()))
    for title, errors in (("Classes", False), ("Errors", True)):
        yield f"## {title} {{#python-{title.lower()}}}\n"
        yield from (class_entry(name, kind, stubs) for name, kind in classes.items() if issubclass(kind, BaseException) == errors)


def main():
    stubs_path, to = map(pathlib.Path, sys.argv[1:])
    stubs = {node.name: node for node in ast.parse(stubs_path.read_text()).body if isinstance(node, ast.ClassDef)}
    to.write_text("\n".join(page(stubs)))


if __name__ == "__main__":
    main()
