// SPDX-License-Identifier: MIT OR Apache-2.0
//! Command line of brdf-baker: arguments → request → run → exit code.

mod cli;

use std::process::ExitCode;

use clap::Parser;
use mimalloc::MiMalloc;

/// Pictures of tens of megabytes come and go, at several threads at once. The system's allocator would return and fetch
/// their pages each time, a tenth of a draft's time.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    let args = cli::Args::parse();
    match cli::run(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            cli::console::report(&error);
            ExitCode::from(error.exit_code())
        }
    }
}
