// SPDX-License-Identifier: MIT OR Apache-2.0
//! A recipe as a job of a render farm: an Open Job Description template.
//!
//! Revision `jobtemplate-2023-09` with the extension TASK_CHUNKING (RFC 0001): one step whose task parameter runs over the
//! numbers of the recipe's items, in chunks that the scheduler sizes. AWS Deadline Cloud takes such templates, and
//! `openjd run` runs them on one machine.

use std::path::Path;

use super::Recipe;
use crate::error::{Error, Result};

/// The most seconds that one chunk may take. A chunk aims at a twelfth of it.
const TIMEOUT_S: u32 = 3600;
/// Between the notice that a task is cancelled and its end. A bake ends within a tenth of a second.
const NOTICE_S: u32 = 10;

/// What a template says of a recipe.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpenJd<'a> {
    /// How many items there are.
    pub items: usize,
    /// The plan that their numbers belong to.
    pub plan: &'a str,
    /// Items that a chunk has at first.
    pub chunk: usize,
}

impl OpenJd<'_> {
    /// The template, to be written to `path`: into the recipe's folder, or into one above it, as a template's paths lead
    /// downward only.
    pub fn template(&self, recipe: &Recipe, path: &Path) -> Result<String> {
        let OpenJd { items, plan, chunk } = self;
        let below = |what: &Path| relative(path, what);
        let folder = below(recipe.folder())?;
        let output = below(&recipe.output)?;
        let file = recipe.path.file_name().unwrap_or_default().to_string_lossy();
        let (name, file, folder, output) = (
            quoted(&format!("brdf-baker {file}")),
            quoted(&format!("{{{{Param.Folder}}}}/{file}")),
            quoted(&folder),
            quoted(&output),
        );
        let target_s = TIMEOUT_S / 12;
        Ok(format!(
            r#"# Written by brdf-baker {version}: {items} items of the plan {plan}.
specificationVersion: jobtemplate-2023-09
extensions:
  - TASK_CHUNKING
name: {name}
parameterDefinitions:
  - name: Folder
    type: PATH
    objectType: DIRECTORY
    dataFlow: IN
    default: {folder}
    description: The recipe's folder, with the environments in it
  - name: Output
    type: PATH
    objectType: DIRECTORY
    dataFlow: OUT
    default: {output}
    description: Where the baked files go
  - name: Program
    type: STRING
    default: brdf-baker
    description: The program, as a worker finds it
  - name: Device
    type: STRING
    default: auto
    description: Where to compute, as --device takes it
  - name: ItemsPerTask
    type: INT
    minValue: 1
    default: {chunk}
    description: Items of a chunk, until the scheduler knows how long they take
  - name: SecondsPerTask
    type: INT
    minValue: 0
    default: {target_s}
    description: How long a chunk should take; 0 keeps ItemsPerTask
steps:
  - name: Bake
    parameterSpace:
      taskParameterDefinitions:
        - name: Items
          type: CHUNK[INT]
          range: "1-{items}"
          chunks:
            defaultTaskCount: "{{{{Param.ItemsPerTask}}}}"
            targetRuntimeSeconds: "{{{{Param.SecondsPerTask}}}}"
            rangeConstraint: NONCONTIGUOUS
    script:
      actions:
        onRun:
          command: "{{{{Param.Program}}}}"
          args:
            - run
            - {file}
            - --output
            - "{{{{Param.Output}}}}"
            - --plan
            - {plan}
            - --items
            - "{{{{Task.Param.Items}}}}"
            - --device
            - "{{{{Param.Device}}}}"
            - --openjd
            - --json
          timeout: {TIMEOUT_S}
          cancelation:
            mode: NOTIFY_THEN_TERMINATE
            notifyPeriodInSeconds: {NOTICE_S}
"#,
            version = env!("CARGO_PKG_VERSION"),
            plan = quoted(plan),
        ))
    }
}

/// A folder seen from that of the template.
fn relative(template: &Path, folder: &Path) -> Result<String> {
    let here = Path::new(".");
    let absolute = |path: &Path| std::path::absolute(if path == Path::new("") { here } else { path });
    let io = |e| Error::io("read", folder, e);
    let (from, to) = (absolute(template.parent().unwrap_or(here)).map_err(io)?, absolute(folder).map_err(io)?);
    let (from, to) = (super::normal(&from), super::normal(&to));
    match to.strip_prefix(&from) {
        Ok(below) if below == Path::new("") => Ok(".".into()),
        Ok(below) => Ok(below.to_string_lossy().replace('\\', "/")),
        Err(_) => {
            let what = format!("'{}' does not lie below the template '{}'", folder.display(), template.display());
            Err(Error::usage(
                what,
                "write the template into the recipe's folder or above; its paths lead downward only",
            ))
        }
    }
}

/// A string as YAML reads it: in double quotes, as JSON.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_downward_from_the_template() {
        let recipe = Recipe::parse(Path::new("a/b/r.toml"), "output = 'out'\n[[bake]]\ntable = 'albedo'\n").unwrap();
        let job = OpenJd { items: 7, plan: "0123", chunk: 2 };
        let text = job.template(&recipe, Path::new("a/job.yaml")).unwrap();
        for words in ["default: \"b\"\n", "default: \"b/out\"\n", "\"{{Param.Folder}}/r.toml\"", "range: \"1-7\""] {
            assert!(text.contains(words), "{words}: {text}");
        }
        assert!(job.template(&recipe, Path::new("a/b/job.yaml")).unwrap().contains("default: \".\"\n"));
        let error = job.template(&recipe, Path::new("a/c/job.yaml")).unwrap_err();
        assert!(error.to_string().contains("does not lie below"), "{error}");
    }
}
