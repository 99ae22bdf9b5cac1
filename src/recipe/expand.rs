// SPDX-License-Identifier: MIT OR Apache-2.0
//! From an entry to the files that it stands for: patterns, lists of engines, placeholders.

use std::path::{Component, Path, PathBuf};

use glob::{MatchOptions, Pattern};

use super::{Entry, Key, Kind, Recipe};
use crate::env::import;
use crate::error::{Error, Result, nearest};
use crate::target::{self, OF_SET, SET};

/// What a path to write may hold: the input's name without extension (of a table its name), the folder between a pattern's
/// fixed part and the file that it found, and the engine.
pub const PLACEHOLDERS: [&str; 3] = ["name", "folder", "target"];

/// The characters that make a path a pattern.
const WILD: [char; 3] = ['*', '?', '['];
/// `*` stays within a folder and finds no hidden file.
const MATCH: MatchOptions =
    MatchOptions { case_sensitive: true, require_literal_separator: true, require_literal_leading_dot: true };

/// One of the things that an entry stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expansion {
    /// Relative to the recipe: an environment's input, as it is written or as a pattern found it.
    pub input: Option<PathBuf>,
    /// What it is called.
    pub name: String,
    /// Where a pattern found it, relative to the pattern's fixed part.
    pub folder: PathBuf,
    /// The engine.
    pub target: Option<String>,
    /// The entry names more engines than one.
    pub has_rivals: bool,
    /// Of a table of an engine's set, its file in the folder that `output` then names.
    pub file: Option<String>,
}

impl Expansion {
    /// A path with its placeholders filled in.
    pub fn fill(&self, recipe: &Recipe, key: &Key, text: &str) -> Result<PathBuf> {
        let mut filled = String::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            filled += before;
            let (name, after) = after.split_once('}').unwrap_or((after, ""));
            let folder = self.folder.to_string_lossy();
            match name {
                "name" => filled += &self.name,
                "folder" => filled += &folder,
                "target" => match &self.target {
                    Some(target) => filled += target,
                    None => return Err(recipe.wrong(key.place, "{target} stands for nothing", "add the key 'for'")),
                },
                _ => {
                    let what = format!("'{}' has an unknown placeholder {{{name}}}", key.name);
                    return Err(recipe.wrong(key.place, &what, &nearest(name, PLACEHOLDERS)));
                }
            }
            // A file in the pattern's own folder has none: `{folder}/{name}` must not begin at the root.
            rest = if name == "folder" && folder.is_empty() { after.trim_start_matches('/') } else { after };
        }
        Ok(PathBuf::from(filled + rest))
    }

    /// The folder, below that of the recipe's output, of files that the engine gives their names: its own where there are
    /// several engines.
    pub fn default_folder(&self) -> PathBuf {
        match &self.target {
            Some(target) if self.has_rivals => Path::new(target).join(&self.folder),
            _ => self.folder.clone(),
        }
    }
}

impl Entry {
    /// All that it stands for, sorted by input and then in the order of the engines.
    pub fn expand(&self, recipe: &Recipe) -> Result<Vec<Expansion>> {
        let subject = self.kind.subject();
        let Some(key) = self.key(subject) else {
            let what = format!("[[{}]] has no '{subject}'", self.kind.name());
            return Err(recipe.wrong(self.place, &what, &format!("say which: {subject} = \"...\"")));
        };
        let found = match self.kind {
            Kind::Bake => match key.value.texts().as_slice() {
                [table] => vec![(None, table.clone(), PathBuf::new())],
                _ => return Err(recipe.wrong(key.place, "'table' is a list", "write one [[bake]] for each")),
            },
            Kind::Env => {
                let mut found = vec![];
                for text in key.value.texts() {
                    found.extend(self.inputs(recipe, key, &text)?);
                }
                found.sort();
                found.dedup();
                found.into_iter().map(|(path, folder)| (Some(path.clone()), import::stem(&path), folder)).collect()
            }
        };
        if self.kind == Kind::Bake && found[0].1 == SET {
            return self.set(recipe, key);
        }
        let targets: Vec<Option<String>> = match self.key("for") {
            None => vec![None],
            Some(key) => key.value.texts().into_iter().map(Some).collect(),
        };
        let has_rivals = targets.len() > 1;
        let each = |(input, name, folder): (Option<PathBuf>, String, PathBuf)| {
            targets.iter().map(move |target| Expansion {
                input: input.clone(),
                name: name.clone(),
                folder: folder.clone(),
                target: target.clone(),
                has_rivals,
                file: None,
            })
        };
        Ok(found.into_iter().flat_map(each).collect())
    }

    /// Every table of its engines.
    fn set(&self, recipe: &Recipe, table: &Key) -> Result<Vec<Expansion>> {
        let Some(engines) = self.key("for") else {
            return Err(recipe.wrong(table.place, "a set is that of an engine", "add the key 'for'"));
        };
        if let Some(key) = self.keys.iter().find(|key| !OF_SET.contains(&key.name.as_str())) {
            let what = format!("'{}' does not go with a set, whose tables are as its engine takes them", key.name);
            return Err(recipe.wrong(key.place, &what, "write a [[bake]] for the table that should differ"));
        }
        let names = engines.value.texts();
        let mut found = vec![];
        for name in &names {
            let target = target::parse(name).map_err(|e| recipe.wrong(engines.place, &e.to_string(), e.help()))?;
            if target.tables.is_empty() {
                let what = format!("{name} takes no tables: it computes its own");
                return Err(recipe.wrong(engines.place, &what, "leave it out"));
            }
            found.extend(target.tables.iter().map(|preset| Expansion {
                input: None,
                name: preset.stem.into(),
                folder: PathBuf::new(),
                target: Some(name.clone()),
                has_rivals: names.len() > 1,
                file: Some(format!("{}.{}", preset.stem, preset.extension)),
            }));
        }
        Ok(found)
    }

    /// The first of these paths that one of its patterns finds: what is written there would be read the next time.
    pub fn picks_up<'a>(&self, recipe: &Recipe, mut paths: impl Iterator<Item = &'a PathBuf>) -> Option<&'a PathBuf> {
        let key = self.key("input").filter(|_| self.kind == Kind::Env)?;
        let wild = key.value.texts().into_iter().filter(|text| text.contains(WILD));
        let patterns: Vec<Pattern> = wild.filter_map(|text| Pattern::new(&pattern(recipe, &text)).ok()).collect();
        if patterns.is_empty() {
            return None;
        }
        paths.find(|path| patterns.iter().any(|pattern| pattern.matches_path_with(&normal(path), MATCH)))
    }

    /// The inputs that a text stands for, relative to the recipe, each with its folder.
    fn inputs(&self, recipe: &Recipe, key: &Key, text: &str) -> Result<Vec<(PathBuf, PathBuf)>> {
        if !text.contains(WILD) || recipe.folder().join(text).exists() {
            return Ok(vec![(text.into(), PathBuf::new())]);
        }
        let wrong = |what: String, help: &str| recipe.wrong(key.place, &what, help);
        let fixed: PathBuf =
            Path::new(text).components().take_while(|c| !c.as_os_str().to_string_lossy().contains(WILD)).collect();
        let root = normal(&recipe.folder().join(&fixed));
        let paths = glob::glob_with(&pattern(recipe, text), MATCH)
            .map_err(|e| wrong(format!("'{text}' is no pattern: {}", e.msg), "wildcards are *, **, ? and [...]"))?;
        let mut found = vec![];
        for path in paths {
            let path = path.map_err(|e| {
                let path = e.path().to_path_buf();
                Error::io("read", &path, e.into())
            })?;
            let below = path.strip_prefix(&root).unwrap_or(&path);
            found.push((fixed.join(below), below.parent().unwrap_or(Path::new("")).to_path_buf()));
        }
        if found.is_empty() {
            return Err(wrong(format!("'{text}' finds no file"), "paths are relative to the recipe's folder"));
        }
        Ok(found)
    }
}

/// A pattern of an entry, seen from the working folder.
fn pattern(recipe: &Recipe, text: &str) -> String {
    // Wildcards in the recipe's own place are meant as they are.
    let folder = Pattern::escape(&normal(recipe.folder()).to_string_lossy());
    match folder.as_str() {
        _ if Path::new(text).is_absolute() => text.into(),
        "" => normal(Path::new(text)).to_string_lossy().into_owned(),
        folder => normal(&Path::new(folder).join(text)).to_string_lossy().into_owned(),
    }
}

/// A path without `.`, and without `..` where a folder comes before it. Links are not looked at.
pub fn normal(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(out.components().next_back(), Some(Component::Normal(_))) => {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(folder: &Path, text: &str) -> Recipe {
        Recipe::parse(&folder.join("recipe.toml"), text).unwrap()
    }

    #[test]
    fn patterns_find_files_in_order_with_their_folders() {
        let folder = tempfile::TempDir::new().unwrap();
        let here = folder.path();
        for name in ["p/b.exr", "p/x/a.exr", "p/x/y/c.exr", "p/.hidden.exr", "p/d.hdr"] {
            let path = here.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let recipe = recipe(here, "[[env]]\ninput = ['p/d.hdr', 'p/**/*.exr']\nfor = ['bevy', 'three']\n");
        let found = recipe.entries[0].expand(&recipe).unwrap();
        let names: Vec<String> =
            found.iter().step_by(2).map(|e| e.input.as_ref().unwrap().display().to_string()).collect();
        assert_eq!(names, ["p/b.exr", "p/d.hdr", "p/x/a.exr", "p/x/y/c.exr"]);
        let last = found.last().unwrap();
        assert_eq!((last.name.as_str(), last.folder.as_path(), last.has_rivals), ("c", Path::new("x/y"), true));
        assert_eq!(last.default_folder(), Path::new("three/x/y"));
        let key = &recipe.entries[0].keys[0];
        let filled = |e: &Expansion, text| e.fill(&recipe, key, text).map(|p| p.display().to_string());
        assert_eq!(filled(last, "{target}/{folder}/{name}.ktx2").unwrap(), "three/x/y/c.ktx2");
        assert_eq!(filled(&found[0], "{folder}/{name}.ktx2").unwrap(), "b.ktx2");
        assert!(filled(last, "{nam}").unwrap_err().help().starts_with("did you mean 'name'?"));
        let written = [here.join("out/p/z.exr"), here.join("p/z/out.exr")];
        assert_eq!(recipe.entries[0].picks_up(&recipe, written.iter()), Some(&written[1]));
        assert_eq!(recipe.entries[0].picks_up(&recipe, written[..1].iter()), None);
    }

    #[test]
    fn what_is_missing_is_named() {
        let here = Path::new("nowhere");
        for (text, words) in [
            ("[[env]]\noutput = 'a'\n", "line 1, column 1: [[env]] has no 'input'"),
            ("[[env]]\ninput = '*.exr'\n", "line 2, column 1: '*.exr' finds no file"),
            ("[[env]]\ninput = '***.exr'\n", "'***.exr' is no pattern"),
            ("[[bake]]\ntable = ['a', 'b']\n", "'table' is a list"),
            ("[[bake]]\ntable = 'set'\n", "line 2, column 1: a set is that of an engine"),
            ("[[bake]]\ntable = 'set'\nfor = 'blendr'\n", "line 3, column 1: unknown target 'blendr'"),
            ("[[bake]]\ntable = 'set'\nfor = 'blender'\nsize = 8\n", "line 4, column 1: 'size' does not go with a set"),
        ] {
            let recipe = recipe(here, text);
            let error = recipe.entries[0].expand(&recipe).expect_err(text);
            assert!(error.to_string().contains(words), "{error}");
        }
    }

    #[test]
    fn a_path_is_normal_without_detours() {
        for (given, wanted) in [("./a/../b", "b"), ("../a", "../a"), ("a/./b/", "a/b"), ("/../a", "/../a"), ("", "")] {
            assert_eq!(normal(Path::new(given)), Path::new(wanted), "{given}");
        }
    }
}
