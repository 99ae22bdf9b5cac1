// SPDX-License-Identifier: MIT OR Apache-2.0
//! One error type, sorted by who can act on it.

use std::path::{Path, PathBuf};

/// What went wrong, to what, and the way out.
///
/// The `Display` text is one sentence that names the thing; [`Error::help`] is the way out, where there is one.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The request itself is not valid: an unknown name, a size out of range, a combination that does not exist.
    #[error("{what}")]
    Usage {
        /// The sentence.
        what: String,
        /// The way out.
        help: String,
    },
    /// The operating system refused to read or write `path`.
    #[error("cannot {doing} '{}': {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// A verb: `read`, `write`, `create`.
        doing: &'static str,
        /// The system's reason.
        source: std::io::Error,
        /// The way out.
        help: String,
    },
    /// A file's content cannot be used.
    #[error("cannot use '{}': {what}", path.display())]
    Input {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
        /// The way out.
        help: String,
    },
    /// No Vulkan device fits the request.
    #[error("{what}")]
    NoDevice {
        /// The sentence, with the devices found.
        what: String,
        /// The way out.
        help: String,
    },
    /// The Vulkan driver failed, or the validation layers found a mistake.
    #[error("{op} failed on the GPU: {detail}")]
    Gpu {
        /// The operation, with the kernel and the slice where they are known.
        op: String,
        /// The driver's answer.
        detail: String,
    },
    /// A check was carried out and the values are wrong.
    #[error("{what}")]
    Verify {
        /// The sentence, with the figures.
        what: String,
    },
    /// The user asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// The result of everything fallible in this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// A request that is not valid, and what to do about it.
    pub fn usage(what: impl Into<String>, help: impl Into<String>) -> Self {
        Error::Usage { what: what.into(), help: help.into() }
    }

    /// A file whose content cannot be used, and what to do about it.
    pub fn input(path: &Path, what: impl Into<String>, help: impl Into<String>) -> Self {
        Error::Input { path: path.into(), what: what.into(), help: help.into() }
    }

    /// A failed system call on `path`.
    pub fn io(doing: &'static str, path: &Path, source: std::io::Error) -> Self {
        use std::io::ErrorKind as K;
        let help = match source.kind() {
            K::NotFound if doing == "read" => "check the spelling of the path",
            K::NotFound => "create the folder first",
            K::PermissionDenied | K::ReadOnlyFilesystem => {
                "choose a folder that you may write to, or change its permissions"
            }
            K::IsADirectory => "name a file, not a folder",
            K::StorageFull => "free some space on the disk",
            _ => "",
        };
        Error::Io { path: path.into(), doing, source, help: help.into() }
    }

    /// The way out; empty where none is known.
    pub fn help(&self) -> &str {
        match self {
            Error::Usage { help, .. }
            | Error::Io { help, .. }
            | Error::Input { help, .. }
            | Error::NoDevice { help, .. } => help,
            Error::Gpu { .. } => "try `--device cpu`, or `--validate` to see what the validation layers say",
            Error::Verify { .. } | Error::Cancelled => "",
        }
    }

    /// The process exit code: 1 a check failed, 2 usage or failure, 130 cancelled.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Verify { .. } => 1,
            Error::Cancelled => 130,
            _ => 2,
        }
    }
}

/// Names near to `wanted`, best first: for "did you mean" in an error about an unknown name.
pub(crate) fn nearest<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let mut ranked: Vec<(usize, &str)> = known.iter().map(|k| (edit_distance(wanted, k), *k)).collect();
    ranked.sort();
    match ranked.first() {
        Some((distance, name)) if *distance <= 2 => format!("did you mean '{name}'? known are: {}", known.join(", ")),
        _ => format!("known are: {}", known.join(", ")),
    }
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_names_a_misspelt_one() {
        assert!(nearest("gxg", ["ggx", "beckmann"]).starts_with("did you mean 'ggx'?"));
        assert!(nearest("phong", ["ggx", "beckmann"]).starts_with("known are: ggx"));
    }

    #[test]
    fn exit_codes_follow_the_contract() {
        assert_eq!(Error::Verify { what: String::new() }.exit_code(), 1);
        assert_eq!(Error::usage("a", "b").exit_code(), 2);
        assert_eq!(Error::Cancelled.exit_code(), 130);
    }
}
