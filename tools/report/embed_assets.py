#!/usr/bin/env python3
"""embed_assets.py OUT.cpp FILE...: writes the files as constants, for tools/report/assets.h."""

import pathlib
import sys

CHUNK = 15000  # compilers need not take longer literals


def literals(text):
    delimiter = "weft_asset"
    assert f'){delimiter}"' not in text
    parts = [text[i:i + CHUNK] for i in range(0, len(text), CHUNK)] or [""]
    return "\n".join(f'R"{delimiter}({part}){delimiter}"' for part in parts)


def main():
    out, files = pathlib.Path(sys.argv[1]), [pathlib.Path(name) for name in sys.argv[2:]]
    lines = ['// Written by embed_assets.py.', '#include "tools/report/assets.h"', "", "namespace weft::report {", "",
             "std::string_view asset(std::string_view name) {"]
    for path in files:
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".js" and "</script" in text:
            sys.exit(f"{path} cannot be put into a page: it contains an end of scripts")
        size = len(text.encode())
        lines.append(f'  if (name == "{path.name}") {{\n    static constexpr char kText[] =\n{literals(text)};')
        lines.append(f"    return {{kText, {size}}};\n  }}")
    lines += ["  return {};", "}", "", "}  // namespace weft::report", ""]
    out.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
