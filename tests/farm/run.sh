#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Bakes 210 probes as a render farm does: the job that `run --emit-openjd` writes, checked and run by Open Job Description's
# own program (openjd-cli, from PyPI, installed under target/farm) in four workers, of which one is killed at work.
# Python's venv comes from apt when it is missing.
set -eu
cd "$(dirname "$0")/../.."
work=$PWD/target/farm
mkdir -p "$work"

if ! python3 -c 'import ensurepip, venv' >/dev/null 2>&1; then
    echo "farm: installing python3-venv"
    if [ "$(id -u)" = 0 ]; then sudo=; else sudo=sudo; fi
    $sudo apt-get update -q && $sudo apt-get install -qy python3-venv
fi
if ! cmp -s tests/farm/requirements.txt "$work/venv/requirements.txt"; then
    rm -rf "$work/venv"
    python3 -m venv "$work/venv"
    "$work/venv/bin/pip" install -q --disable-pip-version-check -r tests/farm/requirements.txt
    cp tests/farm/requirements.txt "$work/venv/"
fi

cargo build --quiet --release --bin brdf-baker
rm -rf "$work/studio"
"$work/venv/bin/python" tests/farm/check.py "$PWD/target/release/brdf-baker" "$work/venv/bin/openjd" "$work/studio"
