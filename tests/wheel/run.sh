#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Installs the wheel into an empty environment of Python and uses its command away from the checkout: it bakes what the
# checkout's program bakes, byte by byte, verifies it, and compiles a BRDF of a user. After `make build` and `make wheel`.
set -eu
cd "$(dirname "$0")/../.."
checkout=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM

say() { printf 'wheel: %s\n' "$*"; }
fail() {
    say "$*" >&2
    exit 1
}

version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
set -- target/wheels/*.whl
[ $# = 1 ] && [ -f "$1" ] || fail "not one wheel but: $*"
wheel=$1
case $wheel in
*/brdf_baker-"$version"-py3-none-*.whl) ;;
*) fail "$wheel has another name" ;;
esac

python3 -m venv "$work/venv"
# Nothing but what is in the wheel.
"$work/venv/bin/pip" install -q --disable-pip-version-check --no-index "$wheel"
"$work/venv/bin/pip" show --files brdf-baker >"$work/files"
for file in LICENSE-MIT LICENSE-APACHE bin/brdf-baker; do
    grep -q "$file\$" "$work/files" || fail "$file is missing"
done

cd "$work"
PATH=$work/venv/bin:$PATH
[ "$(brdf-baker --version)" = "brdf-baker $version" ] || fail "this is $(brdf-baker --version)"
brdf-baker bake split-sum --size 64 -o dfg.ktx2
brdf-baker verify dfg.ktx2 >verified || { cat verified >&2; fail 'its table is wrong'; }
head -n 1 verified
"$checkout/target/release/brdf-baker" bake split-sum --size 64 -o ours.ktx2 >/dev/null
cmp dfg.ktx2 ours.ktx2
# The compiler of users' BRDFs is in it.
brdf-baker bake albedo --glsl "$checkout/examples/brdf/ggx.glsl" --size 8 -o own.exr
size=$(wc -c <"$checkout/$wheel")
say "$(basename "$wheel"), $size bytes: passed"
