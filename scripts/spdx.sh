#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Puts the licence into the first line of every source file, as REUSE and SPDX tools look for it.
#
#   scripts/spdx.sh           add the line where it is missing
#   scripts/spdx.sh --check   list files without it; exit code 1 if there are any
#
# The line goes first; behind `#!` and `<!DOCTYPE` where there is one. Files of kinds that have no comments, such as JSON, and
# files that a test compares byte by byte (tests/golden) have none.
set -eu
cd "$(dirname "$0")/.."

licence='SPDX-License-Identifier: MIT OR Apache-2.0'
missing=0

# With files that are new and not yet in git.
git ls-files --cached --others --exclude-standard | {
    while read -r file; do
        case $file in
        tests/golden/*) continue ;;
        *.rs | *.glsl | *.comp | *.js | *.mjs | *.ts) line="// $licence" ;;
        *.sh | *.py | .ci/run | Makefile) line="# $licence" ;;
        *.css) line="/* $licence */" ;;
        *.html) line="<!-- $licence -->" ;;
        *) continue ;;
        esac
        [ -f "$file" ] || continue
        if head -n 3 -- "$file" | grep -qF "$licence"; then continue; fi
        if [ "${1:-}" = --check ]; then
            printf 'no licence in its first lines: %s\n' "$file"
            missing=1
            continue
        fi
        first=$(head -n 1 -- "$file")
        # A new file with the old one's mode: the shell may be reading the old one, if it is this script.
        cp -p -- "$file" "$file.spdx"
        case $first in
        '#!'* | '<!'[Dd]*) printf '%s\n%s\n' "$first" "$line" && tail -n +2 -- "$file" ;;
        *) printf '%s\n' "$line" && cat -- "$file" ;;
        esac >"$file.spdx"
        mv -f -- "$file.spdx" "$file"
    done
    exit "$missing"
}
