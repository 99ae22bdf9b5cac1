// SPDX-License-Identifier: MIT OR Apache-2.0
//! The text of a BRDF of one's own.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::error::{Error, Result};
use crate::glsl::without_comments;

/// A BRDF as GLSL: either form of [`OwnSource::form`], for any azimuth of both directions.
#[derive(Clone, Debug)]
pub struct OwnSource {
    path: PathBuf,
    text: String,
    form: Form,
}

/// What a text defines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// The whole BRDF.
    Brdf,
    /// Its distribution and its visibility.
    DV,
}

/// Ways to state a BRDF, for messages.
const FORMS: &str = "`vec3 brdf(vec3 l, vec3 v, float alpha)`, or both `float D(float n_dot_h, float alpha)` and `float \
                     V(float n_dot_v, float n_dot_l, float alpha)`";

impl OwnSource {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<OwnSource> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io("read", path, e))?;
        OwnSource::new(path, text)
    }

    /// A text, and the path that messages call it by.
    pub fn new(path: &Path, text: impl Into<String>) -> Result<OwnSource> {
        let text = text.into();
        let plain = without_comments(&text);
        let form = if defines(&plain, "vec3", "brdf") {
            Form::Brdf
        } else if defines(&plain, "float", "D") && defines(&plain, "float", "V") {
            Form::DV
        } else {
            return Err(Error::input(path, "it defines no BRDF", format!("define {FORMS}")));
        };
        Ok(OwnSource { path: path.into(), text, form })
    }

    /// The file's name, without its folder.
    pub fn name(&self) -> String {
        let name = self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy();
        name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
    }

    /// SHA-256 of the text, as 64 hexadecimal digits.
    pub fn sha256(&self) -> String {
        Sha256::digest(self.text.as_bytes()).iter().map(|b| format!("{b:02x}")).collect()
    }

    /// Where it comes from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it defines, in words.
    pub fn form(&self) -> &'static str {
        match self.form {
            Form::Brdf => "brdf(l, v, alpha)",
            Form::DV => "D(n_dot_h, alpha) V(n_dot_v, n_dot_l, alpha)",
        }
    }

    pub(super) fn text(&self) -> &str {
        &self.text
    }

    pub(super) fn is_whole(&self) -> bool {
        self.form == Form::Brdf
    }
}

/// Does a text without comments define the function `name` that returns a `kind`?
fn defines(text: &str, kind: &str, name: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(name).any(|(at, _)| {
        let (before, after) = (&text[..at], text[at + name.len()..].trim_start());
        let returns = before.trim_end();
        let apart = returns.len() < before.len();
        let ends = returns.strip_suffix(kind).is_some_and(|rest| !rest.ends_with(is_word));
        after.starts_with('(') && apart && ends
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_are_told_apart() {
        let form = |text: &str| OwnSource::new(Path::new("a.glsl"), text).map(|s| s.form).ok();
        assert_eq!(form("vec3  brdf (vec3 l, vec3 v, float alpha) { return vec3(1); }"), Some(Form::Brdf));
        assert_eq!(
            form("float D(float x, float a) { return x; }\nfloat\nV(float a, float b, float c) {}"),
            Some(Form::DV)
        );
        assert_eq!(form("float D(float x, float a) { return x; }"), None);
        assert_eq!(form("// vec3 brdf(vec3 l)\n/* vec3 brdf( */"), None);
        assert_eq!(form("vec3 my_brdf(vec3 l); bvec3 brdf(vec3 l); float brdf(vec3 l);"), None);
    }

    #[test]
    fn hash_is_of_the_bytes() {
        let of = |text: &str| OwnSource::new(Path::new("x/a.glsl"), text).unwrap();
        let (one, two) = (of("vec3 brdf(vec3 l) {}"), of("vec3 brdf(vec3 l) { }"));
        assert!(one.sha256() != two.sha256() && one.sha256().len() == 64 && one.name() == "a.glsl");
    }
}
