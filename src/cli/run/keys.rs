// SPDX-License-Identifier: MIT OR Apache-2.0
//! The keys of a recipe are the flags of `bake` and `env`: what clap knows of them is all that there is to know.

use std::any::TypeId;
use std::ffi::OsString;
use std::path::PathBuf;

use brdf_baker::Result;
use brdf_baker::recipe::{Entry, Expansion, Key, Kind, Recipe, Value, normal};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, Args, Command};

use crate::cli::bake::BakeArgs;
use crate::cli::env::EnvArgs;

/// Keys that name files to write, which go into the recipe's output folder. Every other path names an input.
const OUTPUTS: [&str; 3] = ["output", "irradiance", "sh"];
/// Keys that may hold lists, which then stand for a bake each.
const LISTS: [&str; 2] = ["input", "for"];

/// The command that carries out entries of a kind, with its flags.
pub fn command(kind: Kind) -> Command {
    let command = Command::new(kind.name()).no_binary_name(true).disable_help_flag(true);
    match kind {
        Kind::Bake => BakeArgs::augment_args(command),
        Kind::Env => EnvArgs::augment_args(command),
    }
}

/// The words before the value of each flag, which are the keys.
pub fn names(command: &Command) -> Vec<&str> {
    command.get_arguments().map(name).collect()
}

fn name(argument: &Arg) -> &str {
    argument.get_long().unwrap_or(argument.get_id().as_str())
}

fn is_path(argument: &Arg) -> bool {
    argument.get_value_parser().type_id() == TypeId::of::<PathBuf>()
}

/// One bake of a recipe as a command line.
#[derive(Debug)]
pub struct CommandLine {
    /// What clap parses.
    pub arguments: Vec<OsString>,
    /// The same as the recipe has it, with relative paths, in a fixed order.
    pub parameters: Vec<String>,
    /// Files to read, but those that an item before writes.
    pub inputs: Vec<PathBuf>,
    /// The number of the item that writes one of the files to read.
    pub needs: Option<usize>,
}

impl CommandLine {
    /// Of one of the things that an entry stands for. `made_by` says which item writes a file.
    pub fn new(
        recipe: &Recipe,
        entry: &Entry,
        expansion: &Expansion,
        command: &Command,
        made_by: &dyn Fn(&PathBuf) -> Option<usize>,
    ) -> Result<CommandLine> {
        let mut line = CommandLine { arguments: vec![], parameters: vec![], inputs: vec![], needs: None };
        let mut positional = vec![];
        for key in &entry.keys {
            let Some(argument) = command.get_arguments().find(|a| name(a) == key.name) else { continue };
            let text = match (key.name.as_str(), &expansion.input, &expansion.target) {
                ("input", Some(input), _) => input.to_string_lossy().into_owned(),
                ("for", _, Some(target)) => target.clone(),
                ("table", ..) => expansion.name.clone(),
                _ => joined(argument, key),
            };
            if let ArgAction::SetTrue = argument.get_action() {
                match &key.value {
                    Value::Flag(true) => line.arguments.push(format!("--{}", key.name).into()),
                    Value::Flag(false) => {}
                    _ => {
                        let what = format!("'{}' is neither true nor false", key.name);
                        return Err(recipe.wrong(key.place, &what, "write true or false, without quotes"));
                    }
                }
                line.parameters.push(format!("{}={text}", key.name));
                continue;
            }
            let value: OsString = if OUTPUTS.contains(&key.name.as_str()) {
                let mut filled = expansion.fill(recipe, key, &text)?;
                filled.extend(&expansion.file);
                line.parameters.push(format!("{}={}", key.name, filled.display()));
                normal(&recipe.output.join(filled)).into()
            } else {
                line.parameters.push(format!("{}={text}", key.name));
                if is_path(argument) { line.input(recipe, &text, made_by).into() } else { text.into() }
            };
            match argument.get_long() {
                None => positional.push(value),
                Some(long) => {
                    let mut flag = OsString::from(format!("--{long}="));
                    flag.push(value);
                    line.arguments.push(flag);
                }
            }
        }
        line.parameters.sort();
        line.parameters.insert(0, entry.kind.name().into());
        if !positional.is_empty() {
            // After this, nothing is taken for a flag.
            line.arguments.push("--".into());
            line.arguments.extend(positional);
        }
        Ok(line)
    }

    /// The path of a file to read: one that the recipe writes, or one beside it.
    fn input(&mut self, recipe: &Recipe, text: &str, made_by: &dyn Fn(&PathBuf) -> Option<usize>) -> PathBuf {
        let written = normal(&recipe.output.join(text));
        if let Some(number) = made_by(&written) {
            self.needs = Some(number);
            self.inputs.push(written.clone());
            return written;
        }
        // Six files joined by commas are six paths.
        let path: Vec<String> =
            text.split(',').map(|p| recipe.folder().join(p).to_string_lossy().into_owned()).collect();
        let path = PathBuf::from(path.join(","));
        self.inputs.push(path.clone());
        path
    }
}

/// A value as one word; lists with the flag's own sign between their members.
fn joined(argument: &Arg, key: &Key) -> String {
    key.value.texts().join(argument.get_value_delimiter().unwrap_or(',').encode_utf8(&mut [0; 4]))
}

/// What clap refuses, with its place in the recipe.
pub fn refused(recipe: &Recipe, entry: &Entry, error: &clap::Error) -> brdf_baker::Error {
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        Some(ContextValue::Strings(list)) => list.first().map(String::as_str),
        _ => None,
    };
    // `--size <N|WxH>`, or `<TABLE>`.
    let argument = context(ContextKind::InvalidArg).unwrap_or_default();
    let word =
        argument.trim_start_matches(['-', '<']).split([' ', '=', '>', '[']).next().unwrap_or_default().to_lowercase();
    let place = entry.key(&word).map_or(entry.place, |key| key.place);
    if error.kind() == ErrorKind::MissingRequiredArgument {
        let what = format!("[[{}]] has no '{word}'", entry.kind.name());
        let help = if word == "output" { "add it, or the key 'for', which names an engine" } else { "add it" };
        return recipe.wrong(place, &what, help);
    }
    // What clap says in its first line, in the words of a recipe.
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
    let what = first.replace(&format!("'{argument}'"), &format!("'{word}'")).replace("argument", "key");
    recipe.wrong(place, &what, &format!("`brdf-baker {} --help` has the values", entry.kind.name()))
}

/// A JSON schema of recipes, for editors.
pub fn schema() -> serde_json::Value {
    use serde_json::json;
    let entry = |kind: Kind| {
        let command = command(kind);
        let properties: serde_json::Map<_, _> = command
            .get_arguments()
            .map(|argument| {
                let mut about =
                    json!({ "description": argument.get_help().map(|h| h.to_string()).unwrap_or_default() });
                about["type"] = value_type(argument);
                if takes_list(argument) {
                    about["minItems"] = 1.into();
                }
                (name(argument).to_string(), about)
            })
            .collect();
        json!({
            "type": "object",
            "additionalProperties": false,
            "required": [kind.subject()],
            "properties": properties,
        })
    };
    let list = |kind: Kind, about: &str| {
        json!({
            "description": about,
            "type": "array",
            "minItems": 1,
            "items": entry(kind),
        })
    };
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "A recipe of brdf-baker: what `brdf-baker run` bakes",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "output": { "type": "string", "description": "Folder for all that is written, relative to the recipe" },
            "bake": list(Kind::Bake, "A table: the flags of `brdf-baker bake`"),
            "env": list(Kind::Env, "Environments: the flags of `brdf-baker env`; input may be a pattern or a list, for a list"),
        },
    })
}

/// May it be set to a list?
fn takes_list(argument: &Arg) -> bool {
    argument.get_value_delimiter().is_some() || LISTS.contains(&name(argument))
}

/// The types that a key's value may have.
fn value_type(argument: &Arg) -> serde_json::Value {
    let parsed = argument.get_value_parser().type_id();
    let is = |types: &[TypeId]| types.iter().any(|t| parsed == *t);
    let mut types = match argument.get_action() {
        ArgAction::SetTrue => vec!["boolean"],
        _ if is(&[TypeId::of::<bool>()]) => vec!["boolean"],
        _ if is(&[TypeId::of::<u32>()]) => vec!["integer"],
        _ if is(&[TypeId::of::<f64>()]) => vec!["number"],
        _ if is(&[TypeId::of::<String>(), TypeId::of::<PathBuf>()]) => vec!["string"],
        // Words that may be numbers: sizes.
        _ => vec!["string", "integer"],
    };
    if takes_list(argument) {
        types = vec!["string", "array"];
    }
    match types.as_slice() {
        [one] => (*one).into(),
        several => several.into(),
    }
}
