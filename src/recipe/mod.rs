// SPDX-License-Identifier: MIT OR Apache-2.0
//! Recipes: a set of bakes, declared in a TOML file.
//!
//! ```toml
//! output = "baked"                # a folder; all files that are written lie in it
//!
//! [[bake]]
//! table = "split-sum"
//! output = "dfg.ktx2"
//!
//! [[env]]
//! input = "probes/**/*.exr"       # a file, a folder, a pattern, or a list of them
//! output = "{folder}/{name}.ktx2"
//! size = 128
//! ```
//!
//! This module knows files, places in them, patterns and placeholders, and no command: a key is a word with a value, and
//! who carries an [`Entry`] out says which words there are. Paths are relative to the recipe; what is written goes into the
//! folder `output`.

mod expand;
mod openjd;
mod origin;
mod selection;

use std::fmt;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

pub use self::expand::{Expansion, PLACEHOLDERS, normal};
pub use self::openjd::OpenJd;
pub use self::origin::{Origin, SHA256};
pub use self::selection::Selection;

use crate::error::{Error, Result, nearest};

/// The most bytes that a recipe may have: what it unfolds to in memory is bounded with it.
const MAX_BYTES: u64 = 1 << 20;

/// What a file declares.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// The file.
    pub path: PathBuf,
    /// The folder that what is written goes into.
    pub output: PathBuf,
    /// In the order of the file.
    pub entries: Vec<Entry>,
}

/// One `[[bake]]` or `[[env]]`, which may stand for many files.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it asks for.
    pub kind: Kind,
    /// Where it begins.
    pub place: Place,
    /// In the order of the file.
    pub keys: Vec<Key>,
}

/// What an entry asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A table.
    Bake,
    /// An environment, or several.
    Env,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Kind; 2] = [Kind::Bake, Kind::Env];

    /// The word in the file, which is the command's.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Bake => "bake",
            Kind::Env => "env",
        }
    }

    /// The key that says of what.
    pub fn subject(self) -> &'static str {
        match self {
            Kind::Bake => "table",
            Kind::Env => "input",
        }
    }
}

/// A line of an entry.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// What stands before the sign of equality.
    pub name: String,
    /// What stands after it.
    pub value: Value,
    /// Where the name stands.
    pub place: Place,
}

/// What a key is set to. A number is kept as it is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A string or a number.
    Text(String),
    /// `true` or `false`.
    Flag(bool),
    /// Strings and numbers, at least one.
    List(Vec<String>),
}

impl Value {
    /// The strings and numbers in it; `true` and `false` as words.
    pub fn texts(&self) -> Vec<String> {
        match self {
            Value::Text(text) => vec![text.clone()],
            Value::Flag(flag) => vec![flag.to_string()],
            Value::List(list) => list.clone(),
        }
    }
}

/// A position in a file, both counted from 1; the column in characters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// From the top.
    pub line: usize,
    /// From the left.
    pub column: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}", self.line, self.column)
    }
}

impl Recipe {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Recipe> {
        let io = |e| Error::io("read", path, e);
        let mut bytes = vec![];
        let file = std::fs::File::open(path).map_err(io)?;
        file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
        if bytes.len() as u64 > MAX_BYTES {
            let what = format!("a recipe has at most {MAX_BYTES} bytes");
            return Err(Error::input(path, what, "name the environments by a pattern, not one by one"));
        }
        match String::from_utf8(bytes) {
            Ok(text) => Recipe::parse(path, &text),
            Err(e) => {
                let line = 1 + e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count();
                Err(Error::input(path, format!("line {line} is not UTF-8"), "a recipe is a TOML file"))
            }
        }
    }

    /// Reads the text of the file at `path`, which says what paths are relative to.
    pub fn parse(path: &Path, text: &str) -> Result<Recipe> {
        let reader = Reader::new(path, text);
        let root = DeTable::parse(text).map_err(|e| {
            let place = reader.place(&e.span().unwrap_or_default());
            reader.wrong(place, e.message().lines().next().unwrap_or_default(), "a recipe is a TOML file")
        })?;
        let (mut output, mut entries) = (None, vec![]);
        for (name, value) in root.get_ref() {
            match name.get_ref().as_ref() {
                "output" => match value.get_ref().as_str() {
                    Some(text) => output = Some(text.to_string()),
                    None => return Err(reader.mistyped("output", value, "a folder, in quotes")),
                },
                word => match Kind::ALL.into_iter().find(|kind| kind.name() == word) {
                    Some(kind) => entries.extend(reader.entries(kind, value)?),
                    None => {
                        let what = format!("unknown key '{word}'");
                        let known = ["output"].into_iter().chain(Kind::ALL.map(Kind::name));
                        return Err(reader.wrong(reader.place(&name.span()), &what, &nearest(word, known)));
                    }
                },
            }
        }
        if entries.is_empty() {
            let help = "declare a table in [[bake]], or environments in [[env]]";
            return Err(Error::input(path, "it asks for nothing", help));
        }
        entries.sort_by_key(|entry| entry.place);
        let output = normal(&folder_of(path).join(output.unwrap_or_default()));
        Ok(Recipe { path: path.into(), output, entries })
    }

    /// The folder that its paths are relative to.
    pub fn folder(&self) -> &Path {
        folder_of(&self.path)
    }

    /// Something is wrong at a place.
    pub fn wrong(&self, place: Place, what: &str, help: &str) -> Error {
        Error::input(&self.path, format!("{place}: {what}"), help)
    }
}

impl Entry {
    /// The key of this name.
    pub fn key(&self, name: &str) -> Option<&Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// An error where it has a key that is not among those known.
    pub fn check_keys(&self, recipe: &Recipe, known: &[&str]) -> Result<()> {
        match self.keys.iter().find(|key| !known.contains(&key.name.as_str())) {
            None => Ok(()),
            Some(key) => {
                let what = format!("unknown key '{}' of [[{}]]", key.name, self.kind.name());
                Err(recipe.wrong(key.place, &what, &nearest(&key.name, known.iter().copied())))
            }
        }
    }
}

/// The folder that a file lies in, as a prefix: empty for the working folder.
fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// A text that is being read.
struct Reader<'a> {
    path: &'a Path,
    /// Of each byte, and of the end: looked up for every key, where counting would take the square of the text's length.
    places: Vec<Place>,
}

impl<'a> Reader<'a> {
    fn new(path: &'a Path, text: &str) -> Self {
        let mut places = Vec::with_capacity(text.len() + 1);
        let mut at = Place { line: 1, column: 1 };
        for c in text.chars() {
            places.extend(std::iter::repeat_n(at, c.len_utf8()));
            at = match c {
                '\n' => Place { line: at.line + 1, column: 1 },
                _ => Place { column: at.column + 1, ..at },
            };
        }
        places.push(at);
        Reader { path, places }
    }

    fn place(&self, span: &Range<usize>) -> Place {
        self.places[span.start.min(self.places.len() - 1)]
    }

    fn wrong(&self, place: Place, what: &str, help: &str) -> Error {
        Error::input(self.path, format!("{place}: {what}"), help)
    }

    fn mistyped(&self, key: &str, value: &Spanned<DeValue<'_>>, wanted: &str) -> Error {
        let found = match value.get_ref().type_str() {
            "integer" | "array" => format!("an {}", value.get_ref().type_str()),
            other => format!("a {other}"),
        };
        self.wrong(self.place(&value.span()), &format!("'{key}' is {found}"), &format!("write {wanted}"))
    }

    /// A list that holds nothing would ask for nothing, which nobody means.
    fn empty(&self, key: &str, value: &Spanned<DeValue<'_>>) -> Error {
        self.wrong(self.place(&value.span()), &format!("'{key}' is an empty list"), "fill it, or leave it out")
    }

    /// All `[[kind]]` of a file.
    fn entries(&self, kind: Kind, value: &Spanned<DeValue<'_>>) -> Result<Vec<Entry>> {
        let word = kind.name();
        let wanted = format!("[[{word}]] above its keys");
        let Some(list) = value.get_ref().as_array() else { return Err(self.mistyped(word, value, &wanted)) };
        if list.is_empty() {
            return Err(self.empty(word, value));
        }
        list.iter()
            .map(|value| {
                let table = value.get_ref().as_table().ok_or_else(|| self.mistyped(word, value, &wanted))?;
                let mut keys = vec![];
                for (name, value) in table {
                    let place = self.place(&name.span());
                    let value = self.value(name.get_ref(), value)?;
                    keys.push(Key { name: name.get_ref().to_string(), value, place });
                }
                keys.sort_by_key(|key| key.place);
                Ok(Entry { kind, place: self.place(&value.span()), keys })
            })
            .collect()
    }

    fn value(&self, key: &str, value: &Spanned<DeValue<'_>>) -> Result<Value> {
        Ok(match value.get_ref() {
            DeValue::Boolean(flag) => Value::Flag(*flag),
            DeValue::Array(list) if list.is_empty() => return Err(self.empty(key, value)),
            DeValue::Array(list) => Value::List(list.iter().map(|v| self.scalar(key, v)).collect::<Result<_>>()?),
            _ => Value::Text(self.scalar(key, value)?),
        })
    }

    fn scalar(&self, key: &str, value: &Spanned<DeValue<'_>>) -> Result<String> {
        match value.get_ref() {
            DeValue::String(text) => Ok(text.to_string()),
            DeValue::Integer(number) => Ok(number.to_string()),
            DeValue::Float(number) => Ok(number.to_string()),
            _ => Err(self.mistyped(key, value, "a string, a number, true or false, or a list of strings and numbers")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Recipe> {
        Recipe::parse(Path::new("a/recipe.toml"), text)
    }

    #[test]
    fn keys_keep_their_order_and_places() {
        let recipe =
            parse("output = \"out\"\n[[env]]\ninput = ['b', \"c\"]\nmirror = true\n[[bake]]\n  size = 64\n").unwrap();
        assert_eq!((recipe.output.as_path(), recipe.folder()), (Path::new("a/out"), Path::new("a")));
        let [env, bake] = recipe.entries.as_slice() else { panic!("{recipe:?}") };
        assert_eq!((env.kind, env.place.line, bake.kind, bake.place.line), (Kind::Env, 2, Kind::Bake, 5));
        assert_eq!(env.key("input").unwrap().value, Value::List(vec!["b".into(), "c".into()]));
        assert_eq!(env.key("mirror").unwrap().value, Value::Flag(true));
        let size = bake.key("size").unwrap();
        assert_eq!((&size.value, size.place), (&Value::Text("64".into()), Place { line: 6, column: 3 }));
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        for (text, what, help) in [
            ("[[bake]]\ntable = 'x\n", "line 2, column 11: invalid literal string", "TOML"),
            ("outptu = 'a'\n", "line 1, column 1: unknown key 'outptu'", "did you mean 'output'?"),
            ("[[enw]]\n", "unknown key 'enw'", "did you mean 'env'?"),
            ("[bake]\ntable = 'a'\n", "line 1, column 1: 'bake' is a table", "[[bake]]"),
            ("bake = [1]\n", "line 1, column 9: 'bake' is an integer", "[[bake]]"),
            ("output = 1\n", "line 1, column 10: 'output' is an integer", "a folder"),
            ("[[bake]]\nsize = 1979-05-27\n", "line 2, column 8: 'size' is a datetime", "a string"),
            ("[[bake]]\nsize = [[1]]\n", "line 2, column 9: 'size' is an array", "a string"),
            ("[[bake]]\nsize = 1\nsize = 2\n", "line 3, column 1", "TOML"),
            ("[[env]]\ninput = [ ]\n", "line 2, column 9: 'input' is an empty list", "leave it out"),
            ("[[bake]]\nsize = 1\nfor = []\n", "line 3, column 7: 'for' is an empty list", "fill it"),
            ("env = []\n[[bake]]\n", "line 1, column 7: 'env' is an empty list", "fill it"),
            ("# nothing\n", "asks for nothing", "[[env]]"),
        ] {
            let error = parse(text).expect_err(text);
            assert!(error.to_string().contains(what), "{text}: {error}");
            assert!(error.help().contains(help), "{text}: {}", error.help());
        }
    }

    #[test]
    fn a_key_that_nobody_knows_is_refused_with_the_nearest() {
        let recipe = parse("[[env]]\ninput = 'ä'\n'rougness-law' = 'x'\n").unwrap();
        let error = recipe.entries[0].check_keys(&recipe, &["input", "roughness-law"]).unwrap_err();
        assert!(error.to_string().ends_with("line 3, column 1: unknown key 'rougness-law' of [[env]]"), "{error}");
        assert!(error.help().starts_with("did you mean 'roughness-law'?"));
    }

    #[test]
    fn long_texts_take_no_longer_than_their_length() {
        let keys = |count: usize| (0..count).map(|i| format!("k{i} = 1\n")).collect::<String>();
        for text in ["[[env]]\n".repeat(100_000), format!("[[env]]\n{}", keys(80_000))] {
            let start = std::time::Instant::now();
            parse(&text).unwrap();
            assert!(start.elapsed().as_secs() < 10, "{:?} for {} bytes", start.elapsed(), text.len());
        }
    }

    #[test]
    fn no_text_makes_it_panic() {
        let sound = "output = 'o'\n[[env]]\ninput = ['ä', 1.5]\nmips = 0x1f\n[[bake]]\nfor = \"\"\"\nx\"\"\"\n";
        for cut in (0..sound.len()).filter(|i| sound.is_char_boundary(*i)) {
            let _ = parse(&sound[..cut]);
            for byte in ["[", "]", "\"", "=", "\n", "é", "{"] {
                let _ = parse(&format!("{}{byte}{}", &sound[..cut], &sound[cut..]));
            }
        }
    }
}
