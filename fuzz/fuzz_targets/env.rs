#![no_main]
// SPDX-License-Identifier: MIT OR Apache-2.0

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| brdf_baker_fuzz::run("env", bytes));
