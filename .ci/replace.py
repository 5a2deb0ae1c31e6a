"""replace.py SRC FILE BEFORE AFTER: replaces code below the folder SRC that occurs once, whatever its line breaks.

White space between tokens does not count, nor does a comma before a closing bracket. The code is looked for in FILE; where that file
is gone, in all files. Prints the file that was changed; exit status 1 if the code is not there, or not the only one.
"""

import pathlib
import re
import sys

BRACKETS = ")]}"


def pattern(code):
    tokens = re.findall(r"\w+|[^\w\s]", code)
    parts = []
    for before, token in zip([""] + tokens, tokens):
        between = r"\s+" if re.match(r"\w", token) and re.match(r"\w", before) else r"\s*"
        if token in BRACKETS and before != ",":
            between = r"\s*,?\s*"
        parts.append((between if before else "") + re.escape(token))
    return re.compile("".join(parts))


def main():
    source, name, before, after = sys.argv[1:]
    file = pathlib.Path(source, name)
    files = [file] if file.exists() else sorted(p for p in pathlib.Path(source).rglob("*") if p.suffix in (".rs", ".wgsl"))
    found = [(path, match) for path in files for match in pattern(before).finditer(path.read_text())]
    if len(found) != 1:
        sys.exit(f"{len(found)} places")
    path, match = found[0]
    text = path.read_text()
    # A fragment may begin and end with white space, which the pattern does not take.
    path.write_text(text[: match.start()] + after.strip() + text[match.end() :])
    print(path)


main()
