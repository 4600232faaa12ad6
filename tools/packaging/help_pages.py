#!/usr/bin/env python3
"""Man pages, shell completion and the reference in Markdown, from what `weft --help-data` prints: the command's own help."""

import argparse
import gzip
import json
import pathlib
import re


def all_commands(command):
    yield command
    for sub in command["commands"]:
        yield from all_commands(sub)


def groups_of(command):
    """The options by the headings of --help, in its order."""
    groups = {}
    for option in command["options"]:
        groups.setdefault("Arguments" if option["positional"] else option["group"], []).append(option)
    return groups


def names_of(option):
    return option["names"] or [option["value"]]


# Man pages -----------------------------------------------------------------------------------------------------------

def roff(text):
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return "\n".join("\\&" + line if line[:1] in ".'" else line for line in escaped.split("\n"))


def man_option(option):
    names = ", ".join(f"\\fB{roff(name)}\\fR" if option["names"] else f"\\fI{roff(name)}\\fR" for name in names_of(option))
    value = f" \\fI{roff(option['value'])}\\fR" if option["names"] and option["value"] else ""
    return f".TP\n{names}{value}\n{roff(option['text'])}\n"


def man_name(command):
    return command["name"].replace(" ", "-")


def man_page(command, commands, version):
    name = man_name(command)
    usage = command["usage"].removeprefix("Usage: ")
    pieces = [f'.TH {name.upper()} 1 "" "weft {version}" "User Commands"\n', ".SH NAME\n",
              f"{roff(name)} \\- {roff(command['text'].rstrip('.'))}\n", ".SH SYNOPSIS\n", f".B {roff(usage)}\n"]
    for group, options in groups_of(command).items():
        pieces.append(f'.SH "{group.upper()}"\n')
        pieces += [man_option(option) for option in options]
    if command["commands"]:
        pieces.append(".SH SUBCOMMANDS\n")
        pieces += [f".TP\n\\fB{roff(man_name(sub))}\\fR(1)\n{roff(sub['text'])}\n" for sub in command["commands"]]
    if command["footer"]:
        pieces.append(f".SH NOTES\n.nf\n{roff(command['footer'])}\n.fi\n")
    related = [man_name(other) for other in commands if other is not command
               and (command["name"].startswith(other["name"] + " ") or other["name"].startswith(command["name"] + " "))]
    if related:
        pieces.append(".SH SEE ALSO\n" + ",\n".join(f"\\fB{roff(other)}\\fR(1)" for other in related) + "\n")
    return "".join(pieces)


# Shell completion ----------------------------------------------------------------------------------------------------

def takes_path(option):
    return {"FILE": "file", "DIR": "folder"}.get(option["kind"], "")


def bash_case(command):
    named = [option for option in command["options"] if option["names"]]
    words = [name for option in named for name in option["names"]]
    words += [sub["name"].split()[-1] for sub in command["commands"]]
    by_kind = {kind: "|".join(name for option in named if option["value"] and takes_path(option) == kind
                              for name in option["names"]) for kind in ("file", "folder", "")}
    lines = [f'    "{command["name"]}")', f'      words="{" ".join(words)}"']
    lines += [f'      {variable}="|{by_kind[kind]}|"' for kind, variable in
              (("file", "files"), ("folder", "folders"), ("", "values"))]
    lines.append("      ;;")
    return "\n".join(lines)


def bash_completion(root):
    commands = list(all_commands(root))
    known = " ".join(f'"{command["name"]}"' for command in commands)
    cases = "\n".join(bash_case(command) for command in commands)
    return f"""# bash completion for weft, made from its help
_weft() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}}
  local command=weft word known words files folders values i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=${{COMP_WORDS[i]}}
    for known in {known}; do
      if [[ "$command $word" == "$known" ]]; then
        command=$known
        break
      fi
    done
  done
  case $command in
{cases}
  esac
  COMPREPLY=()
  if [[ $files == *"|$previous|"* ]]; then
    mapfile -t COMPREPLY < <(compgen -f -- "$current")
  elif [[ $folders == *"|$previous|"* ]]; then
    mapfile -t COMPREPLY < <(compgen -d -- "$current")
  elif [[ $values == *"|$previous|"* ]]; then
    return
  elif [[ $current == -* || $command == weft || $command == "weft mesh" ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  fi
  if [[ ${{#COMPREPLY[@]}} -eq 0 && $current != -* ]]; then
    mapfile -t COMPREPLY < <(compgen -f -- "$current")
  fi
}}
complete -o filenames -F _weft weft
"""


def zsh_text(text):
    return re.sub(r"([\[\]:\\])", r"\\\1", text).replace("'", "'\\''")


def zsh_specs(command):
    for option in command["options"]:
        action = {"file": ":_files", "folder": ":_files -/", "": ": "}[takes_path(option)]
        for name in option["names"]:
            value = f":{zsh_text(option['value'])}{action}" if option["value"] else ""
            yield f"'{'*' if option['repeatable'] else ''}{name}[{zsh_text(option['text'])}]{value}'"
        if option["positional"]:
            yield f"'{'*' if option['repeatable'] else ''}:{zsh_text(option['text'])}{action}'"


def zsh_function(command):
    name = "_" + re.sub(r"[ -]", "_", command["name"])
    specs = list(zsh_specs(command))
    if not command["commands"]:
        return f"{name}() {{\n  _arguments \\\n    " + " \\\n    ".join(specs) + "\n}\n"
    subs = " ".join(f"'{sub['name'].split()[-1]}:{zsh_text(sub['text'])}'" for sub in command["commands"])
    cases = "\n".join(f"        {sub['name'].split()[-1]}) _{re.sub(r'[ -]', '_', sub['name'])} ;;"
                      for sub in command["commands"])
    specs = [spec for spec in specs if not spec.startswith("':")] + ["'1: :->command'", "'*:: :->arguments'"]
    return f"""{name}() {{
  local state line
  _arguments -C \\
    {f' {chr(92)}{chr(10)}    '.join(specs)}
  case $state in
    command)
      local -a commands=({subs})
      _describe 'subcommand' commands
      ;;
    arguments)
      case $line[1] in
{cases}
      esac
      ;;
  esac
}}
"""


def zsh_completion(root):
    return "#compdef weft\n# made from the help of weft\n\n" + "\n".join(zsh_function(c) for c in all_commands(root)) + '\n_weft "$@"\n'


def fish_text(text):
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"


def fish_lines(command):
    path = command["name"].split()[1:]
    subs = [sub["name"].split()[-1] for sub in command["commands"]]
    conditions = [f"__fish_seen_subcommand_from {word}" for word in path]
    if subs:
        conditions.append("not __fish_seen_subcommand_from " + " ".join(subs))
    start = "complete -c weft" + (f" -n '{'; and '.join(conditions)}'" if conditions else "")
    for sub in command["commands"]:
        yield f"{start} -f -a {sub['name'].split()[-1]} -d {fish_text(sub['text'])}"
    for option in command["options"]:
        names = "".join(f" -l {name[2:]}" if name.startswith("--") else f" -s {name[1:]}" for name in option["names"])
        files = {"file": " -r -F", "folder": " -x -a '(__fish_complete_directories)'", "": " -x"}[takes_path(option)]
        if names:
            yield f"{start}{names}{files if option['value'] else ''} -d {fish_text(option['text'])}"


def fish_completion(root):
    lines = [line for command in all_commands(root) for line in fish_lines(command)]
    return "# fish completion for weft, made from its help\n" + "\n".join(lines) + "\n"


# The reference -------------------------------------------------------------------------------------------------------

def cell(text):
    return text.replace("|", "\\|").replace("<", "&lt;").replace(">", "&gt;")


def reference(root):
    lines = ["# The command {#command}", "", "What `weft --help` and `weft SUBCOMMAND --help` say.", ""]
    for command in all_commands(root):
        anchor = man_name(command)
        lines += [f"## {command['name']} {{#{anchor}}}", "", cell(command["text"]), "",
                  "    " + command["usage"].removeprefix("Usage: "), ""]
        for group, options in groups_of(command).items():
            lines += [f"**{group}**", "", "| option | is |", "|---|---|"]
            for option in options:
                names = ", ".join(names_of(option)) + (" " + option["value"] if option["names"] and option["value"] else "")
                lines.append(f"| `{names}` | {cell(option['text'])} |")
            lines.append("")
        if command["footer"]:
            lines += ["    " + line for line in command["footer"].split("\n")] + [""]
    return "\n".join(lines)


def write(path, contents):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(contents if isinstance(contents, bytes) else contents.encode())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("help_data", type=pathlib.Path, help="what `weft --help-data` prints")
    parser.add_argument("folder", type=pathlib.Path, help="gets man1/, completions and command.md")
    parser.add_argument("--version", required=True)
    options = parser.parse_args()
    root = json.loads(options.help_data.read_text())
    commands = list(all_commands(root))
    for command in commands:
        page = man_page(command, commands, options.version).encode()
        write(options.folder / "man1" / f"{man_name(command)}.1.gz", gzip.compress(page, 9, mtime=0))
    write(options.folder / "weft.bash", bash_completion(root))
    write(options.folder / "_weft", zsh_completion(root))
    write(options.folder / "weft.fish", fish_completion(root))
    write(options.folder / "command.md", reference(root))


if __name__ == "__main__":
    main()
