// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a file is baked from, as one hash in the file: to tell whether it must be baked again.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::error::{Error, Result};
use crate::format::{self, Fingerprint, Output};
use crate::progress::{OnProgress, tick};
use crate::stamp::Stamp;
use crate::texture::Meta;

/// The key under which a file states it.
pub const SHA256: &str = "recipe.sha256";
/// What the name of a file ends with that speaks for one whose container has no place for metadata.
const BESIDE: &str = ".baked.json";
/// Bytes that are hashed between two looks at the listener.
const STEP: usize = 1 << 20;

/// The SHA-256 of a bake's parameters, of its inputs' bytes, and of the program's version.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    sha256: String,
    inputs: Vec<(PathBuf, Stamp)>,
}

impl Origin {
    /// Of parameters in a fixed order, and of what these files hold now.
    pub fn of(parameters: &[String], inputs: &[PathBuf], on: &mut OnProgress<'_>) -> Result<Origin> {
        let mut hash = Sha256::new();
        // Lengths go before contents, so that no two lists hash alike.
        let mut part = |bytes: &[u8]| {
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(bytes);
        };
        part(env!("CARGO_PKG_VERSION").as_bytes());
        parameters.iter().for_each(|parameter| part(parameter.as_bytes()));
        let mut stamped = vec![];
        for path in inputs {
            let (digest, stamp) = file_hash(path, on)?;
            part(digest.as_bytes());
            stamped.push((path.clone(), stamp));
        }
        Ok(Origin { sha256: hexadecimal(hash), inputs: stamped })
    }

    /// 64 hexadecimal digits.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// An error where an input is no longer what was hashed.
    pub fn check(&self) -> Result<()> {
        for (path, stamp) in &self.inputs {
            let now = fs::metadata(path).map_err(|e| Error::io("read", path, e))?;
            if Stamp::of(&now) != *stamp {
                return Err(Stamp::changed(path));
            }
        }
        Ok(())
    }

    /// Puts it into a file's meta.
    pub fn state(&self, meta: &mut Meta) {
        meta.set(SHA256, &self.sha256);
    }

    /// Puts it into a JSON object that is no table.
    pub fn state_in_json(&self, object: &mut Value) {
        object[SHA256] = self.sha256.as_str().into();
    }

    /// Writes it beside a file whose container has no place for metadata, with the file's own hash. Does nothing for others.
    pub fn state_beside(&self, output: &Path, on: &mut OnProgress<'_>) -> Result<()> {
        if format::for_path(output)?.holds_meta() {
            return Ok(());
        }
        let (sha256, _) = file_hash(output, on)?;
        let content = json!({ SHA256: self.sha256, "file.sha256": sha256 });
        Output::prepare(&beside(output))?.commit_bytes(format!("{content:#}\n").as_bytes())?;
        Ok(())
    }

    /// Is this the origin of a file, and has the file what was baked? A file that is missing, damaged or changed is not.
    pub fn is_of(&self, output: &Path, on: &mut OnProgress<'_>) -> Result<bool> {
        if !output.is_file() {
            return Ok(false);
        }
        let Ok(format) = format::for_path(output) else { return Ok(false) };
        if !format.holds_meta() {
            let Some(stated) = json_of(&beside(output)) else { return Ok(false) };
            return Ok(
                stated[SHA256] == self.sha256.as_str() && stated["file.sha256"] == file_hash(output, on)?.0.as_str()
            );
        }
        let Ok((texture, encoding)) = format.read(output) else {
            // Spherical harmonics are JSON too, but no texture.
            return Ok(json_of(output).is_some_and(|object| object[SHA256] == self.sha256.as_str()));
        };
        if texture.meta.get(SHA256) != Some(&self.sha256) {
            return Ok(false);
        }
        let found = Fingerprint::of_stored(&texture, encoding);
        Ok(found.is_ok_and(|found| Fingerprint::stated(&texture.meta).is_ok_and(|stated| stated == Some(found))))
    }
}

/// The file that speaks for `output`.
fn beside(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_os_string();
    name.push(BESIDE);
    output.with_file_name(name)
}

fn json_of(path: &Path) -> Option<Value> {
    serde_json::from_slice(&fs::read(path).ok()?).ok()
}

/// The SHA-256 of a file's bytes, and its stamp; an error where it changes meanwhile.
fn file_hash(path: &Path, on: &mut OnProgress<'_>) -> Result<(String, Stamp)> {
    let io = |e| Error::io("read", path, e);
    let mut file = File::open(path).map_err(io)?;
    let meta = file.metadata().map_err(io)?;
    let stamp = Stamp::of(&meta);
    let (mut hash, mut buffer, mut read) = (Sha256::new(), vec![0; STEP], 0);
    loop {
        tick(on, "hashing", read as f64 / meta.len().max(1) as f64)?;
        let count = file.read(&mut buffer).map_err(io)?;
        if count == 0 {
            break;
        }
        hash.update(&buffer[..count]);
        read += count;
    }
    let now = file.metadata().map_err(io)?;
    if Stamp::of(&now) == stamp { Ok((hexadecimal(hash), stamp)) } else { Err(Stamp::changed(path)) }
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::{Progress, ignore};

    #[test]
    fn it_follows_parameters_and_bytes_but_not_the_place() {
        let folder = tempfile::TempDir::new().unwrap();
        let file = |name: &str, content: &str| {
            let path = folder.path().join(name);
            fs::write(&path, content).unwrap();
            path
        };
        let of = |parameters: &[&str], inputs: &[PathBuf]| {
            let parameters: Vec<String> = parameters.iter().map(|p| p.to_string()).collect();
            Origin::of(&parameters, inputs, &mut ignore).unwrap().sha256
        };
        let (a, same, b) = (file("a", "one"), file("b", "one"), file("c", "two"));
        let first = of(&["x", "y"], std::slice::from_ref(&a));
        assert_eq!(first, of(&["x", "y"], &[same]));
        for other in [
            of(&["x", "z"], std::slice::from_ref(&a)),
            of(&["xy"], std::slice::from_ref(&a)),
            of(&["x", "y"], &[b]),
            of(&["x", "y"], &[]),
        ] {
            assert_ne!(first, other);
        }
    }

    #[test]
    fn an_input_that_changes_is_noticed() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("input");
        fs::write(&path, vec![1; 3 * STEP]).unwrap();
        let origin = Origin::of(&[], std::slice::from_ref(&path), &mut ignore).unwrap();
        origin.check().unwrap();
        // While it is hashed: the listener is called after the first step.
        let mut grow = |p: Progress<'_>| {
            if p.done > 0.0 {
                fs::write(&path, vec![2; 4 * STEP]).unwrap();
            }
            std::ops::ControlFlow::Continue(())
        };
        let error = Origin::of(&[], std::slice::from_ref(&path), &mut grow).unwrap_err();
        assert!(error.to_string().contains("it changed while it was read"), "{error}");
        // After it was hashed.
        assert!(origin.check().unwrap_err().to_string().contains("it changed"));
    }
}
