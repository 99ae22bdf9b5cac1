// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a recipe comes to: one item for each bake, checked before any work.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use brdf_baker::env::import;
use brdf_baker::recipe::{Entry, Expansion, Key, Kind, Origin, Recipe, Selection};
use brdf_baker::{Error, Result};
use clap::{Command, FromArgMatches};
use sha2::{Digest, Sha256};

use super::keys::{self, CommandLine};
use crate::cli::bake::{BakeArgs, BakePlan};
use crate::cli::console::Console;
use crate::cli::device::Device;
use crate::cli::env::{EnvArgs, EnvPlan};

/// One bake.
pub struct Item {
    /// From 1.
    pub number: usize,
    /// `env probes/a.exr for three`.
    pub name: String,
    /// Which of the recipe's entries it comes from.
    pub entry: usize,
    kind: Kind,
    line: CommandLine,
    /// Where files go that the engine names.
    folder: PathBuf,
    /// All files that it writes.
    pub outputs: Vec<PathBuf>,
    /// The item that decides which process bakes it: its own, or the one whose file it reads.
    root: usize,
}

/// An item whose flags were understood.
pub enum Plan {
    Bake(Box<BakePlan>),
    Env(Box<EnvPlan>),
}

impl Plan {
    fn outputs(&self) -> Vec<&Path> {
        match self {
            Plan::Bake(plan) => plan.outputs(),
            Plan::Env(plan) => plan.outputs(),
        }
    }

    pub fn run(self, device: &Device<'_>, origin: &Origin, console: &mut Console) -> Result<()> {
        match self {
            Plan::Bake(plan) => plan.run(device, Some(origin), console),
            Plan::Env(plan) => plan.run(device, Some(origin), console),
        }
    }
}

impl Item {
    /// Is it part of what this process bakes? An item goes where the item goes whose file it reads.
    pub fn is_in(&self, selection: &Selection) -> bool {
        selection.holds(self.root)
    }

    /// The item whose file it reads.
    pub fn needs(&self) -> Option<usize> {
        self.line.needs
    }

    /// What it does, with all that can be refused refused.
    pub fn plan(&self, command: &Command) -> Result<Plan, Refusal> {
        let matches = command.clone().try_get_matches_from(&self.line.arguments).map_err(Refusal::Words)?;
        Ok(match self.kind {
            Kind::Bake => {
                let args = BakeArgs::from_arg_matches(&matches).map_err(Refusal::Words)?;
                Plan::Bake(Box::new(args.plan(&self.folder)?))
            }
            Kind::Env => {
                let args = EnvArgs::from_arg_matches(&matches).map_err(Refusal::Words)?;
                Plan::Env(Box::new(args.plan(&self.folder)?))
            }
        })
    }

    /// The command that understands its flags.
    pub fn command(&self) -> Command {
        keys::command(self.kind)
    }

    /// What its files are baked from.
    pub fn origin(&self, console: &mut Console) -> Result<Origin> {
        let mut files = vec![];
        for input in &self.line.inputs {
            files.extend(import::files(input)?);
        }
        Origin::of(&self.line.parameters, &files, &mut |p| console.progress(p))
    }

    /// Files that it reads, as the recipe names them.
    fn check_inputs(&self) -> Result<()> {
        if self.line.needs.is_some() {
            return Ok(());
        }
        for input in &self.line.inputs {
            for file in import::files(input)? {
                std::fs::metadata(&file).map_err(|e| Error::io("read", &file, e))?;
            }
        }
        Ok(())
    }
}

/// Why an item is refused: its words, or what they ask for.
pub enum Refusal {
    Words(clap::Error),
    Request(Error),
    /// Its place is in the error.
    Placed(Error),
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Self {
        Refusal::Request(error)
    }
}

impl Refusal {
    /// With the place in the recipe.
    pub fn explain(self, recipe: &Recipe, entry: &Entry) -> Error {
        match self {
            Refusal::Words(error) => keys::refused(recipe, entry, &error),
            Refusal::Placed(error) => error,
            Refusal::Request(error) => {
                let text = error.to_string();
                // A message quotes the word that it is about.
                let is_quoted = |key: &&Key| key.value.texts().iter().any(|word| text.contains(&format!("'{word}'")));
                let place = entry.keys.iter().find(is_quoted).map_or(entry.place, |key| key.place);
                recipe.wrong(place, &text, error.help())
            }
        }
    }
}

/// All items of a recipe, in its order, each checked.
pub fn items(recipe: &Recipe) -> Result<Vec<Item>> {
    let mut items: Vec<Item> = vec![];
    let mut writers: BTreeMap<PathBuf, usize> = BTreeMap::new();
    let commands = Kind::ALL.map(keys::command);
    for (index, entry) in recipe.entries.iter().enumerate() {
        let command = &commands[entry.kind as usize];
        entry.check_keys(recipe, &keys::names(command))?;
        for expansion in entry.expand(recipe)? {
            let mut item = item(recipe, index, &expansion, command, items.len() + 1, &writers)
                .map_err(|refusal| refusal.explain(recipe, entry))?;
            item.root = item.needs().map_or(item.number, |number| items[number - 1].root);
            for output in &item.outputs {
                if let Some(other) = writers.insert(output.clone(), item.number) {
                    let first = items.get(other - 1).map_or(&item.name, |item| &item.name);
                    let what = format!("'{first}' and '{}' would both write '{}'", item.name, output.display());
                    let help = "put {folder}, {name} or {target} into their output";
                    return Err(recipe.wrong(entry.place, &what, help));
                }
            }
            items.push(item);
        }
    }
    for entry in &recipe.entries {
        if let Some(output) = entry.picks_up(recipe, writers.keys()) {
            let what = format!("its pattern would find '{}', which the recipe writes", output.display());
            return Err(recipe.wrong(entry.place, &what, "write into a folder where the pattern does not look"));
        }
    }
    Ok(items)
}

fn item(
    recipe: &Recipe,
    index: usize,
    expansion: &Expansion,
    command: &Command,
    number: usize,
    writers: &BTreeMap<PathBuf, usize>,
) -> Result<Item, Refusal> {
    let entry = &recipe.entries[index];
    let line = CommandLine::new(recipe, entry, expansion, command, &|path| writers.get(path).copied())
        .map_err(Refusal::Placed)?;
    let subject = expansion.input.as_ref().map_or(expansion.name.clone(), |input| input.display().to_string());
    let target = expansion.target.as_ref().map(|target| format!(" for {target}")).unwrap_or_default();
    let name = format!("{} {subject}{target}", entry.kind.name());
    let folder = recipe.output.join(expansion.default_folder());
    let kind = entry.kind;
    let mut item = Item { number, name, entry: index, kind, line, folder, outputs: vec![], root: number };
    item.check_inputs()?;
    item.outputs = match item.line.needs {
        // What it reads is not there yet; its own file has a name in the recipe.
        Some(_) => {
            let matches = command.clone().try_get_matches_from(&item.line.arguments).map_err(Refusal::Words)?;
            matches.get_one::<PathBuf>("output").into_iter().cloned().collect()
        }
        None => item.plan(command)?.outputs().into_iter().map(Path::to_path_buf).collect(),
    };
    Ok(item)
}

/// What the numbers of the items belong to: 16 hexadecimal digits that change when an item is added, removed or changed.
pub fn plan_id(items: &[Item]) -> String {
    let mut hash = Sha256::new();
    for item in items {
        for text in item.line.parameters.iter().chain([&item.name]) {
            hash.update((text.len() as u64).to_le_bytes());
            hash.update(text);
        }
    }
    hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect()
}
