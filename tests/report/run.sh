#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Opens pages of `verify --report` in headless Chromium, light and dark: no message on the console, every number equal to
# that of `verify --json`. Chromium and node come from apt when they are missing. Screenshots stay in target/report.
set -eu
cd "$(dirname "$0")/../.."

need() { # package, then a command that works when it is there
    package=$1
    shift
    if ! "$@" >/dev/null 2>&1; then
        echo "report: installing $package"
        if [ "$(id -u)" = 0 ]; then sudo=; else sudo=sudo; fi
        $sudo apt-get update -q && $sudo apt-get install -qy --no-install-recommends "$package"
        "$@" >/dev/null || { echo "report: $package is still missing" >&2; exit 1; }
    fi
}
need nodejs node --version
need chromium chromium --version

# With what `make` builds with, so that nothing is built twice.
# shellcheck disable=SC2046 # flags are words
cargo build --quiet --release $(sh scripts/setup.sh --cargo-flags)
rm -rf target/report
mkdir -p target/report
target/release/brdf-baker sky -o target/report/sky.exr --size 256 --elevation 25 --sun-disc --exposure -5
node tests/report/check.mjs target/release/brdf-baker target/report
