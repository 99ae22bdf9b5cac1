//! Where a command computes.

use std::cell::OnceCell;

use brdf_baker::Result;
use brdf_baker::bake::Backend;

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

    /// Opens it anew when it is next asked for: a device that was lost stays lost.
    pub fn close(&mut self) {
        self.opened = OnceCell::new();
    }
}
