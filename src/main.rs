// SPDX-License-Identifier: MIT OR Apache-2.0
//! Command line of brdf-baker: arguments → request → run → exit code.

mod cli;

use std::process::ExitCode;

use clap::Parser;

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
