#!/bin/sh
# SPDX-License-Identifier: MIT OR Apache-2.0
# Runs under Miri, which finds undefined behaviour and data races, the unit tests that neither talk to Vulkan nor take minutes
# when they are interpreted: readers and writers of texels, recipes, shares, progress on threads, axes.
#
# Needs a nightly toolchain with the components miri and rust-src. Takes three minutes of a core.
set -eu
cd "$(dirname "$0")/.."

# Isolation keeps files away, which tests of recipes write; rayon's threads end with the process, which is no leak. The memory
# that rayon reclaims (crossbeam-epoch) finds an object by a pointer to its first field: sound by Tree Borrows, and not by
# the older Stacked Borrows. It also keeps tags in pointers, as integers. Last bits of floats would vary from run to run.
MIRIFLAGS="-Zmiri-disable-isolation -Zmiri-ignore-leaks -Zmiri-deterministic-floats"
export MIRIFLAGS="$MIRIFLAGS -Zmiri-tree-borrows -Zmiri-permissive-provenance"
# Two threads are enough for a race; threads that wait are interpreted too.
export RAYON_NUM_THREADS=2
# What a few seconds suffice for; leftover asks for what Miri has not, a file's time.
cargo +nightly miri test --locked --lib -- \
    axis:: error:: texture:: env::file_axes env::import env::orientation format:: gpu::inject progress:: recipe:: \
    verify::certificate verify::identify::layout view:: \
    --skip format::leftover --skip bc6h::tests --skip smooth_pictures --skip half_ulp_bounds --skip format::harmonics \
    --skip one_changed_texel --skip fingerprint::tests::what_is_stated --skip an_input_that_changes --skip long_texts \
    --skip no_text_makes_it_panic
