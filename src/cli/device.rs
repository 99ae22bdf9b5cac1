// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a command computes.

use std::cell::OnceCell;

use brdf_baker::bake::Backend;
use brdf_baker::{Error, Result};

use super::Global;

/// The device that the user named, opened when it is first asked for.
pub struct Device<'a> {
    global: &'a Global,
    opened: OnceCell<Backend>,
}

impl<'a> Device<'a> {
    pub fn new(global: &'a Global) -> Self {
        Device { global, opened: OnceCell::new() }
    }

    /// The open device. One that cannot be opened is an error each time.
    pub fn backend(&self) -> Result<&Backend> {
        if let Some(backend) = self.opened.get() {
            return Ok(backend);
        }
        let backend = Backend::open(&self.global.device, self.global.validate)?;
        Ok(self.opened.get_or_init(|| backend))
    }

    /// The processor, for a table that has no kernel. Refused where another device was named.
    pub fn processor(&self, table: &str) -> Result<&Backend> {
        let named = &self.global.device;
        if ["auto", "cpu"].contains(&named.as_str()) {
            return Ok(&Backend::Cpu);
        }
        Err(Error::usage(format!("{table} is computed on the processor, not on the device '{named}'"), "drop --device"))
    }

    /// Opens it anew when it is next asked for: a device that was lost stays lost.
    pub fn close(&mut self) {
        self.opened = OnceCell::new();
    }
}
