// SPDX-License-Identifier: MIT OR Apache-2.0
//! Faults on demand: no test can make a driver lose its device, and every program must be seen to bear it.
//!
//! The variable `BRDF_BAKER_INJECT` lists faults, joined by commas; who sets it asks for a failure. It is no part of the
//! program's interface.

use crate::error::{Error, Result, nearest};

const VARIABLE: &str = "BRDF_BAKER_INJECT";

/// What shall go wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Faults {
    /// `device-lost=N`: the device is lost at its N-th submission, and stays so.
    pub(super) device_lost: Option<u64>,
    /// `device-memory=BYTES`: this is all the memory that the device has.
    pub(super) device_memory: Option<u64>,
    /// `max-buffer=BYTES`: no buffer can be larger.
    pub(super) max_buffer: Option<u64>,
    /// `old-driver=1`: no device has Vulkan 1.1.
    pub(super) old_driver: Option<u64>,
}

impl Faults {
    /// Those that the environment asks for.
    pub(super) fn wanted() -> Result<Faults> {
        std::env::var(VARIABLE).map_or(Ok(Faults::default()), |text| Faults::parse(&text))
    }

    fn parse(text: &str) -> Result<Faults> {
        let mut faults = Faults::default();
        for part in text.split(',').filter(|part| !part.is_empty()) {
            let (name, value) = part.split_once('=').unwrap_or((part, ""));
            let fault = match name {
                "device-lost" => &mut faults.device_lost,
                "device-memory" => &mut faults.device_memory,
                "max-buffer" => &mut faults.max_buffer,
                "old-driver" => &mut faults.old_driver,
                _ => {
                    let known = ["device-lost", "device-memory", "max-buffer", "old-driver"];
                    return Err(Error::usage(format!("{VARIABLE} asks for '{name}'"), nearest(name, known)));
                }
            };
            let number = value.parse();
            *fault =
                Some(number.map_err(|_| Error::usage(format!("{VARIABLE}: '{value}' of {name} is no number"), ""))?);
        }
        Ok(faults)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_asked_for_by_name_and_number() {
        let faults = Faults::parse("device-lost=3,max-buffer=1024").unwrap();
        assert_eq!((faults.device_lost, faults.max_buffer, faults.device_memory), (Some(3), Some(1024), None));
        assert_eq!(Faults::parse("").unwrap(), Faults::default());
        assert!(Faults::parse("device-last=3").unwrap_err().help().contains("did you mean 'device-lost'"));
        assert!(Faults::parse("max-buffer").is_err());
    }
}
