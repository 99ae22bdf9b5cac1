// SPDX-License-Identifier: MIT OR Apache-2.0
//! One thing that every sound file obeys, and whether this one does.

use serde::Serialize;

/// A statement about all texels, or about all that were compared.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Law {
    /// What must hold, as a reader would say it.
    pub statement: String,
    /// Does it?
    pub holds: bool,
    /// Where it does not, the first place; empty where it does.
    pub detail: String,
}

impl Law {
    /// A law that holds when `failures`, sentences about this law alone, is empty.
    pub fn new(statement: impl Into<String>, failures: &[String]) -> Law {
        Law {
            statement: statement.into(),
            holds: failures.is_empty(),
            detail: failures.first().cloned().unwrap_or_default(),
        }
    }
}
