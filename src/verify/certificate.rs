// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a file claims of itself, held against what is found: its certificate.
//!
//! A bake writes the claims: the hash of its texels ([`crate::format::Fingerprint`]), the rule with its nodes, the error
//! that its own check measured, device, driver and version. The hash and the rule are computed again. The errors of a
//! table were measured before it was stored, at texels that follow from its size, so they are measured there again, less
//! what rounding explains; they may come out smaller, never greater. Where a texel was computed cannot be found in it:
//! device, driver and version stay claims.

use serde::Serialize;

use super::cube::CubeReport;
use super::table::TableReport;
use crate::bake::specular::SpecularJob;
use crate::error::Result;
use crate::format::{Changed, Encoding, Fingerprint, Repr, SHA256, Steps};
use crate::texture::{Meta, Shape, Texture};

/// What became of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Computed or measured again, and right.
    Confirmed,
    /// Computed or measured again, and wrong.
    Refuted,
    /// Not checked: nothing in the file could show it, or not without the source.
    Stated,
    /// The file does not say.
    Missing,
}

/// One line of a certificate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Claim {
    /// The key under which the file states it.
    pub key: &'static str,
    /// What the file states.
    pub stated: Option<String>,
    /// What was found, where something was.
    pub found: Option<String>,
    /// Does the one agree with the other?
    pub verdict: Verdict,
}

/// All claims of a file.
#[derive(Clone, Debug, Serialize)]
pub struct Certificate {
    /// In the order of their importance.
    pub claims: Vec<Claim>,
    /// More texels than one are other ones than those that were baked.
    pub several_changed: bool,
    /// What is wrong, in sentences; empty when nothing is refuted.
    pub failures: Vec<String>,
}

/// What tables say of their texels.
const DESCRIBED: [&str; 2] = ["fit-error.worst", "fit-error.median"];

/// The relative error of a figure that is stated with three digits, and with two.
const THREE_DIGITS: f64 = 5.1e-3;
const TWO_DIGITS: f64 = 5.1e-2;

impl Certificate {
    /// Holds the texels of any file against its hash; the rest of its claims comes with [`Certificate::table`] or
    /// [`Certificate::environment`]. An error where the file's statement cannot be read.
    pub fn texels(texture: &Texture, encoding: Encoding) -> Result<Certificate> {
        let found = Fingerprint::of_stored(texture, encoding)?;
        let Some(stated) = Fingerprint::stated(&texture.meta)? else {
            let claim = Claim { key: SHA256, stated: None, found: Some(found.sha256), verdict: Verdict::Missing };
            return Ok(Certificate { claims: vec![claim], several_changed: false, failures: vec![] });
        };
        let texels = texture.levels.iter().map(|l| l.len() as u64).sum::<u64>() / texture.channels.len() as u64;
        let changed = found.changed_since(&stated, texels);
        let failures = match changed {
            None => vec![],
            Some(Changed::One(index)) => vec![format!("{} was changed after it was baked", place(texture, index))],
            Some(Changed::Several) => {
                vec!["several texels were changed after they were baked, or stored in another encoding".into()]
            }
        };
        let verdict = if changed.is_some() { Verdict::Refuted } else { Verdict::Confirmed };
        let claim = Claim { key: SHA256, stated: Some(stated.sha256), found: Some(found.sha256), verdict };
        Ok(Certificate { claims: vec![claim], several_changed: changed == Some(Changed::Several), failures })
    }

    /// Adds the claims of a table that is baked by this rule.
    pub fn table(self, rule: String, meta: &Meta, report: &TableReport) -> Certificate {
        self.measured(rule, meta, report.certified_worst, report.certified_median)
    }

    /// Adds the claims of anything that is baked by this rule and was measured again, less rounding.
    pub fn measured(mut self, rule: String, meta: &Meta, worst: f64, median: f64) -> Certificate {
        self.rule(meta, rule);
        self.at_most(meta, "error.worst", worst);
        self.at_most(meta, "error.median", median);
        self.origin(meta);
        self
    }

    /// Adds what a table says of its texels ([`crate::bake::Table::describe`]) to the certificate. It was measured before
    /// they were stored: where storing changed them it stays a claim.
    pub fn described(mut self, meta: &Meta, found: &Meta, steps: &Steps) -> Certificate {
        for (key, value) in found.iter() {
            let key = DESCRIBED.iter().find(|known| **known == key).expect("every table's keys are known");
            match value.parse() {
                Ok(found) if steps.encoding.repr == Repr::F32 => self.at_most(meta, key, found),
                _ => self.only_stated(meta, key),
            }
        }
        self
    }

    /// Adds the claims of an environment; its errors can be measured again only with the source.
    pub fn environment(mut self, job: &SpecularJob, meta: &Meta, report: &CubeReport, steps: &Steps) -> Certificate {
        self.rule(meta, job.rule());
        for (key, found) in
            [("error.relative.rms", report.certified_rms), ("error.relative.worst", report.certified_worst)]
        {
            let stated = meta.get(key).map(String::from);
            let most = stated.as_deref().map(str::parse::<f64>);
            let rounding = steps.relative();
            let verdict = match (most, found) {
                (None, _) => Verdict::Missing,
                (_, None) => Verdict::Stated,
                (Some(Ok(most)), Some(found)) if found <= most * (1.0 + TWO_DIGITS) + rounding => Verdict::Confirmed,
                // Rounding may take a larger share of very dark texels.
                (Some(Ok(_)), Some(_)) if steps.encoding.repr != Repr::F32 => Verdict::Stated,
                (_, Some(found)) => {
                    self.refute(key, stated.as_deref(), found);
                    Verdict::Refuted
                }
            };
            let found = found.map(|found| format!("{found:.1e} with rounding"));
            self.claims.push(Claim { key, stated, found, verdict });
        }
        self.origin(meta);
        self
    }

    fn refute(&mut self, key: &str, stated: Option<&str>, found: f64) {
        let stated = stated.unwrap_or_default();
        self.failures.push(format!("its {key} is {stated} by its certificate, but {found:.2e} was measured"));
    }

    /// The rule must be the one that this program would use, if this version baked the file.
    fn rule(&mut self, meta: &Meta, found: String) {
        let stated = meta.get("rule").map(String::from);
        let ours = meta.get("version") == Some(env!("CARGO_PKG_VERSION"));
        let verdict = match &stated {
            None => Verdict::Missing,
            Some(stated) if *stated == found => Verdict::Confirmed,
            Some(_) if !ours => Verdict::Stated,
            Some(stated) => {
                self.failures.push(format!("its rule is '{stated}' by its certificate, but this table's is '{found}'"));
                Verdict::Refuted
            }
        };
        self.claims.push(Claim { key: "rule", stated, found: Some(found), verdict });
    }

    /// A measured error that was stated with three digits.
    fn at_most(&mut self, meta: &Meta, key: &'static str, found: f64) {
        let stated = meta.get(key).map(String::from);
        let verdict = match stated.as_deref().map(str::parse::<f64>) {
            None => Verdict::Missing,
            Some(Ok(most)) if found <= most * (1.0 + THREE_DIGITS) => Verdict::Confirmed,
            Some(_) => {
                self.refute(key, stated.as_deref(), found);
                Verdict::Refuted
            }
        };
        let found = match found {
            0.0 => "nothing beyond rounding".into(),
            found => format!("{found:.2e} beyond rounding"),
        };
        self.claims.push(Claim { key, stated, found: Some(found), verdict });
    }

    /// Who baked it, with what.
    fn origin(&mut self, meta: &Meta) {
        for key in ["device", "driver", "version"] {
            self.only_stated(meta, key);
        }
    }

    fn only_stated(&mut self, meta: &Meta, key: &'static str) {
        let stated = meta.get(key).map(String::from);
        let verdict = if stated.is_some() { Verdict::Stated } else { Verdict::Missing };
        self.claims.push(Claim { key, stated, found: None, verdict });
    }
}

/// The name of the texel with this index over all levels.
fn place(texture: &Texture, index: u64) -> String {
    let (mut level, mut rest) = (0, index as usize);
    while let Some(texels) = texture.levels.get(level).map(|l| l.len() / texture.channels.len())
        && rest >= texels
    {
        rest -= texels;
        level += 1;
    }
    let (width, height) = texture.level_size(level);
    let (width, height) = (width as usize, height as usize);
    let (face, x, y) = (rest / (width * height), rest % width, rest / width % height);
    match texture.shape {
        Shape::Table => format!("texel ({x}, {y})"),
        Shape::Volume { .. } => format!("texel ({x}, {y}, {face})"),
        Shape::Array { .. } => format!("texel ({x}, {y}) of layer {face}"),
        Shape::Map => format!("texel ({x}, {y}) of mip {level}"),
        Shape::Cube => format!("texel ({x}, {y}) of face {}, mip {level},", ["+X", "-X", "+Y", "-Y", "+Z", "-Z"][face]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texel_of_a_cube_is_named_by_face_and_mip() {
        let channels = ["r", "g", "b"].map(String::from).to_vec();
        let levels = vec![vec![0.0; 6 * 16 * 3], vec![0.0; 6 * 4 * 3], vec![0.0; 6 * 3]];
        let cube = Texture { shape: Shape::Cube, width: 4, height: 4, channels, levels, meta: Meta::default() };
        assert_eq!(place(&cube, 16 * 2 + 4 + 3), "texel (3, 1) of face +Y, mip 0,");
        assert_eq!(place(&cube, 96 + 4 * 5 + 2), "texel (0, 1) of face -Z, mip 1,");
        assert_eq!(place(&cube, 96 + 24 + 1), "texel (0, 0) of face -X, mip 2,");
    }
}
