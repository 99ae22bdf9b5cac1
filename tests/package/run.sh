#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Packages the crate and builds it as its user does: without the network, without shaderc, outside the checkout. What it then
# bakes must be what the checkout's program bakes, byte by byte. The shaders in the package must be those that this machine's
# shaderc makes of the sources in it.
#
#   tests/package/run.sh         after `make build`; the registry's crates must be on the machine, as they are after that
#   tests/package/run.sh game    also builds examples/game on the packaged crate, whose build script bakes, and runs it
set -eu
cd "$(dirname "$0")/../.."

# The flags are meant to be split.
# shellcheck disable=SC2046
flags="--release --locked $(sh scripts/setup.sh --cargo-flags)"
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
name=brdf-baker-$version
target=${CARGO_TARGET_DIR:-$PWD/target}
checkout=$PWD
# Outside the checkout, whose .cargo/config.toml tells where shaderc lies.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM

say() { printf 'package: %s\n' "$*"; }
fail() {
    say "$*" >&2
    exit 1
}

# The shaders of this checkout, and a look at what looks at them.
pack() {
    # shellcheck disable=SC2086
    cargo run --quiet $flags --bin pack-spirv -- "$@"
}
pack write spirv
cp -R spirv "$work/damaged"
one=$(find "$work/damaged" -name '*.spv' | head -n 1)
printf '\377' | dd of="$one" bs=1 seek=100 conv=notrunc 2>/dev/null
if pack check "$work/damaged" 2>/dev/null; then fail 'a changed shader was not seen'; fi
rm "$one"
if pack check "$work/damaged" 2>/dev/null; then fail 'a missing shader was not seen'; fi

# What is in the package.
cargo package --quiet --locked --allow-dirty --no-verify --offline -p brdf-baker
cargo package --quiet --locked --allow-dirty --offline -p brdf-baker --list >"$work/list"
other=$(grep -vE '^(Cargo\.(toml(\.orig)?|lock)|\.cargo_vcs_info\.json|(CHANGELOG|CONTRIBUTING|README)\.md|LICENSE-(MIT|APACHE)|docs/[a-z0-9-]+\.md|examples/[a-z_]+\.rs|build\.rs|(build|src|shaders|spirv)/.*)$' "$work/list" || true)
[ -z "$other" ] || fail "unexpected files: $other"
for file in LICENSE-MIT LICENSE-APACHE README.md build.rs shaders/probe.comp spirv/SOURCES src/lib.rs; do
    grep -qx "$file" "$work/list" || fail "$file is missing"
done
crate=$target/package/$name.crate
size=$(wc -c <"$crate")
[ "$size" -lt 5000000 ] || fail "$size bytes are too many: the registry takes 10 MB"
say "$(wc -l <"$work/list") files, $size bytes"

# As a user: nothing but what is in the package and the crates that it names.
tar -xzf "$crate" -C "$work"
pack check "$work/$name/spirv"
cd "$work/$name"
unset SHADERC_LIB_DIR VULKAN_SDK
export CARGO_NET_OFFLINE=true
cargo tree --locked --edges normal,build --prefix none >"$work/tree"
if grep -i shaderc "$work/tree"; then
    fail 'the package asks for shaderc'
fi
# The compiled dependencies are the checkout's: since cargo 1.91 they may lie apart from the results.
user() { CARGO_BUILD_BUILD_DIR=$target CARGO_TARGET_DIR=$work/target cargo "$@"; }
user build --quiet --release --locked --bin brdf-baker
for arguments in 'bake split-sum --size 64 --device cpu' 'bake split-sum --size 64' 'bake albedo --size 32 --ior 1.5'; do
    # shellcheck disable=SC2086
    "$checkout/target/release/brdf-baker" $arguments -o "$work/ours.ktx2" >"$work/said"
    # shellcheck disable=SC2086
    "$work/target/release/brdf-baker" $arguments -o "$work/theirs.ktx2" >/dev/null
    cmp "$work/ours.ktx2" "$work/theirs.ktx2"
    say "the same bytes: $arguments, on $(sed 's/.* s  //' "$work/said")"
done

# Shaders that were compiled from other sources, and none at all.
refused() {
    if user check --quiet --release --locked --lib >"$work/refused" 2>&1; then fail "built although $1"; fi
    grep -q "$2" "$work/refused" || { cat "$work/refused" >&2; fail "no clear error although $1"; }
    say "refused: $1"
}
echo '// changed' >>shaders/probe.comp
refused 'a shader changed' 'compiled from other shaders'
rm -r spirv
refused 'there are no compiled shaders' 'no compiled shaders.*compile-shaders'

if [ "${1:-}" = game ]; then
    rm -r "$work/${name:?}"
    tar -xzf "$crate" -C "$work"
    cp -R "$checkout/examples/game" "$work/game"
    cd "$work/game"
    # As if the crate came from the registry.
    sed "s|^brdf-baker = .*|brdf-baker = { path = \"../$name\" }|" Cargo.toml >Cargo.toml.new
    mv Cargo.toml.new Cargo.toml
    cp "$work/$name/Cargo.lock" Cargo.lock
    # Quick to build; the few texels need no more.
    export CARGO_PROFILE_RELEASE_BUILD_OVERRIDE_OPT_LEVEL=1
    CARGO_TARGET_DIR=$target/game cargo run --quiet --release --offline >"$work/said"
    cat "$work/said"
    grep -q 'reflects 0.9[0-9]* of red light' "$work/said" || fail 'the game read another table'
    grep -q '6 faces of 64 texels and 7 mips' "$work/said" || fail 'the game read another sky'
fi
say 'passed'
