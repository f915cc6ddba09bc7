#!/usr/bin/env python3
"""Finds words in sources and documents that words.txt replaces by a standard term.

    check_words.py [--words FILE] [--root FOLDER] [PATH...]   all tracked files by default
    check_words.py --self-test

Prints FILE:LINE: FOUND -> REPLACEMENT for each occurrence; exits 1 if there are any.

Rows of words.txt are `pattern | replacement | paths`; `paths` is optional and lists the only paths
that the row applies to, or, with a leading `!`, paths that it does not apply to. A pattern is one of
    word or phrase    ignores case; matches across line breaks, and in identifiers (someWord, SomeWord)
    =Identifier       exactly this identifier; `*` stands for any further characters of an identifier
    /regex/           a Python regular expression, which may not span lines
Rows that start with `skip` name paths that are not checked: generated files, texts of third parties,
patterns of words.txt itself.
"""
import argparse
import fnmatch
import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
BINARY = (".jpg", ".png", ".gif", ".ktx2", ".glb", ".bin", ".exr", ".hdr")
DATA = (".json", ".jsonl", ".csv", ".svg", ".supp")
# What separates the words of a phrase: spaces, or a line break with the next line's comment mark.
GAP = r"(?:[ \t]+|[ \t]*\n[ \t]*(?://+|#+|\*|\|)?[ \t]*)"


def compile_pattern(pattern):
    if pattern.startswith("/") and pattern.endswith("/"):
        return re.compile(pattern[1:-1])
    if pattern.startswith("="):
        name = re.escape(pattern[1:]).replace(r"\*", r"\w*")
        return re.compile(r"(?<!\w)" + name + r"(?!\w)")
    words = pattern.split()
    if len(words) > 1:
        return re.compile(r"(?<!\w)" + GAP.join(re.escape(w) for w in words) + r"(?!\w)", re.IGNORECASE)
    word = re.escape(pattern)
    capital = re.escape(pattern[0].upper() + pattern[1:])
    # At the start of a word, or as a later part of an identifier in camel case.
    return re.compile(rf"(?:(?<![A-Za-z])(?:{word}|{capital}|{re.escape(pattern.upper())})|(?<=[a-z0-9]){capital})(?![a-z])")


def literal_of(pattern):
    """Lower-case text that every match contains: a search for it is far quicker than the expression."""
    if pattern.startswith("/") and pattern.endswith("/"):
        return ""
    if pattern.startswith("="):
        return max(pattern[1:].split("*"), key=len).lower()
    return max(pattern.split(), key=len).lower()


class Rule:
    def __init__(self, pattern, replacement, paths):
        self.pattern, self.replacement = pattern, replacement
        self.literal = literal_of(pattern)
        self.regex = compile_pattern(pattern)
        self.only = [p for p in paths if not p.startswith("!")]
        self.never = [p[1:] for p in paths if p.startswith("!")]

    def applies(self, path):
        return (not self.only or matches(path, self.only)) and not matches(path, self.never)


def matches(path, globs):
    return any(fnmatch.fnmatch(path, g) or path.startswith(g.rstrip("/") + "/") for g in globs)


def read_rules(path):
    rules, skipped = [], []
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            line = line.strip()
            if not line or line.startswith("#"):
                continue
            cells = [c.strip() for c in line.split(" | ")]
            if cells[0].startswith("skip "):
                skipped += cells[0].split()[1:]
            elif len(cells) in (2, 3) and cells[0] and cells[1]:
                rules.append(Rule(cells[0], cells[1], cells[2].split() if len(cells) == 3 else []))
            else:
                sys.exit(f"{path}:{number}: expected `pattern | replacement | paths`")
    return rules, skipped


def tracked_files(root):
    command = shutil.which("git")
    git = command and subprocess.run([command, "-c", "safe.directory=*", "-C", root, "ls-files", "-z"],
                                     capture_output=True, check=False)
    if git and git.returncode == 0:
        return [p for p in git.stdout.decode().split("\0") if p]
    paths = []  # a copy of the tree without its history
    for folder, folders, files in os.walk(root):
        folders[:] = [f for f in folders if not f.startswith(".") and f not in ("build", "node_modules")]
        paths += [os.path.relpath(os.path.join(folder, f), root) for f in files]
    return paths


def find_words(text, path, rules):
    """Yields (line, text found, replacement)."""
    lower = text.lower()
    for rule in rules:
        if rule.literal not in lower or not rule.applies(path):
            continue
        for match in rule.regex.finditer(text):
            words = re.sub(r"\s+(//+|#+|\*|\|)?\s*", " ", match.group())
            yield text.count("\n", 0, match.start()) + 1, words, rule.replacement


def check(root, paths, rules, skipped):
    found = []
    for path in sorted(paths):
        full = os.path.join(root, path)
        if matches(path, skipped) or path.endswith(BINARY + DATA) or os.path.islink(full):
            continue
        try:
            with open(full, encoding="utf-8") as file:
                text = file.read()
        except (UnicodeDecodeError, FileNotFoundError, IsADirectoryError):
            continue
        found += [(path, *hit) for hit in sorted(find_words(text, path, rules))]
    return found


def self_test():
    rules = [Rule("whoever", "the client", []), Rule("comes to", "is", []), Rule("=kMost*", "kMax*", []),
             Rule("/turns? out/", "is", []), Rule("nought", "zero", ["docs"]), Rule("gate", "lock", ["!docs"])]
    cases = [
        ("src/a.cpp", "// Tells whoever asks.\n", [(1, "whoever")]),
        ("src/a.cpp", "\nTEST(Gate, TellsWhoeverAsks)\n", [(2, "Gate"), (2, "Whoever")]),
        ("src/a.cpp", "int whoeverElse; // WHOEVER\n", [(1, "whoever"), (1, "WHOEVER")]),
        ("src/a.cpp", "// The sum\n//   comes\n//   to 3.\n", [(2, "comes to")]),
        ("src/a.cpp", "constexpr int kMostPasses = 3, kAlmost = 2;\n", [(1, "kMostPasses")]),
        ("src/a.cpp", "// nought; it turns out well\n", [(1, "turns out")]),
        ("docs/a.md", "A gate of nought.\n", [(1, "nought")]),
        ("src/a.cpp", "// investigate, welcomes to, whoeverything\n", []),
    ]
    for path, text, expected in cases:
        found = sorted((line, word) for line, word, _ in find_words(text, path, rules))
        assert found == sorted(expected), f"{text!r}: {found}, expected {expected}"
    with tempfile.TemporaryDirectory() as root:  # a planted word, found in a file by the shipped list
        shipped, skipped = read_rules(os.path.join(HERE, "words.txt"))
        with open(os.path.join(root, "planted.cpp"), "w", encoding="utf-8") as file:
            file.write("// Correct.\n// Rejects whoever is slow.\n")
        found = check(root, tracked_files(root), shipped, skipped)
        assert [(f[0], f[1], f[2]) for f in found] == [("planted.cpp", 2, "whoever")], found
    print(f"self-test passed: {len(cases)} texts, {len(shipped)} rows in words.txt")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", default=os.path.join(HERE, "..", ".."))
    parser.add_argument("--words", default=os.path.join(HERE, "words.txt"))
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("paths", nargs="*", help="files or folders below the root")
    arguments = parser.parse_args()
    if arguments.self_test:
        return self_test()
    rules, skipped = read_rules(arguments.words)
    paths = tracked_files(arguments.root)
    if arguments.paths:
        paths = [p for p in paths if matches(p, arguments.paths)]
    found = check(arguments.root, paths, rules, skipped)
    for path, line, text, replacement in found:
        print(f"{path}:{line}: {text} -> {replacement}")
    if found:
        print(f"{len(found)} banned words; words.txt lists the standard terms", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
