#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| brdf_baker_fuzz::run("recipe", bytes));
