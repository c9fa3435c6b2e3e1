#!/usr/bin/env python3
"""Writes a page of help for each command, and a page of settings for each command that reads a file of them:

    docs/help_pages.py PROGRAM FOLDER

Each page holds what the program prints, so it cannot differ from it. The lines of the summary of the site go to standard
output, with FOLDER as it was given. docs/site.sh calls this.
"""

import pathlib
import subprocess
import sys
import textwrap

WIDTH = 124


def told(program, *words):
    return subprocess.run([program, *words], check=True, capture_output=True, text=True).stdout


def wrapped(text):
    """Long lines broken, each part as far to the right as its first."""
    for line in text.splitlines():
        indent = " " * (len(line) - len(line.lstrip()))
        broken = textwrap.wrap(line, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
        yield from broken if len(line) > WIDTH else [line.rstrip()]


def block(text, language):
    return f"```{language}\n" + text.strip("\n") + "\n```\n"


def help_block(text):
    return block("\n".join(wrapped(text)), "text")


def commands(help_):
    """The commands that a text of help lists, with a sentence on each."""
    _, _, rest = help_.partition("\nCommands:\n")
    lines = rest.split("\n\n", 1)[0].splitlines()
    listed = [line.split(None, 1) for line in lines if line.strip()]
    return [(name, about) for name, about in listed if name != "help"]


def values(program, command, argument=""):
    """The values of the first argument of a command that has a list of them, or of the named one, with their meanings."""
    text = told(program, command, "--help")
    _, _, rest = text[text.index(argument) :].partition("Possible values:\n")
    lines = rest.split("\n\n", 1)[0].splitlines()
    listed = [line.strip()[2:].partition(":") for line in lines if line.strip().startswith("- ")]
    return {name.strip(): about.strip() for name, _, about in listed}


def help_page(program, command):
    text = told(program, command, "--help")
    parts = [f"# landscape {command}\n", help_block(text)]
    for name, _ in commands(text):
        parts += [f"## landscape {command} {name}\n", help_block(told(program, command, name, "--help"))]
    return "\n".join(parts)


def settings_page(program, command):
    parts = [
        f"# Settings of {command}\n",
        f"`landscape config {command}` prints such a file, and `landscape {command} --config FILE` reads it. "
        "[Use from scripts](../scripts.md#settings-in-files) tells what a file may leave out.\n",
    ]
    if command == "stability":
        for protocol, about in values(program, command, "--protocol <NAME>").items():
            parts += [f"## {protocol}: {about}\n", f"`landscape config {command} --protocol {protocol}` prints:\n", block(told(program, "config", command, "--protocol", protocol), "toml")]
    else:
        parts.append(block(told(program, "config", command), "toml"))
    return "\n".join(parts)


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    whole = told(program, "--help")
    listed = commands(whole)
    lines = ["# Help of every command\n", "The pages of this part hold what `landscape COMMAND --help` prints.\n"]
    lines += [f"- [{name}]({name}.md): {about}" for name, about in listed]
    with_settings = values(program, "config")
    lines += ["\nThese commands read files of settings:\n"]
    lines += [f"- [{name}](settings-{name}.md)" for name in with_settings]
    lines += ["\n## landscape\n", help_block(whole)]
    pages = {"README": "\n".join(lines)}
    pages |= {name: help_page(program, name) for name, _ in listed}
    pages |= {f"settings-{name}": settings_page(program, name) for name in with_settings}
    for name, text in pages.items():
        (folder / f"{name}.md").write_text(text, encoding="utf-8")
        title = text.partition("\n")[0].removeprefix("# ")
        print(f"{'- ' if name == 'README' else '  - '}[{title}]({folder / name}.md)")


main()
