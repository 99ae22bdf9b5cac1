#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Fuzzes every reader for so many seconds each, with a limit of memory and of time for one file.
#
#   fuzz/run.sh [SECONDS [TARGET...]]     default: 60 seconds of each
#
# Needs cargo-fuzz and a nightly toolchain. New files go into fuzz/target/corpus; a file that breaks something lies in
# fuzz/artifacts and belongs, once its fault is mended, into fuzz/corpus. Leaks are not looked for: what a thread of the pool has
# just freed counts as lost while it ends. tests/hostile.rs counts memory.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- ktx2 exr hdr png dds ktx env npy json source picture environment recipe

cargo +nightly fuzz build -O
for target in "$@"; do
    found=fuzz/target/corpus/$target
    mkdir -p "$found"
    printf '\n== %s\n' "$target"
    cargo +nightly fuzz run -O "$target" "$found" "fuzz/corpus/$target" -- \
        -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -malloc_limit_mb=1024 -max_len=65536 -detect_leaks=0 -print_final_stats=1
done
