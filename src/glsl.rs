// SPDX-License-Identifier: MIT OR Apache-2.0
//! GLSL compiled at run time, for what a user writes. Needs the feature `glsl`, which links shaderc into the program; without
//! it [`compile`] says so.

use std::path::Path;

use crate::error::{Error, Result};

/// SPIR-V for Vulkan 1.1 of a compute shader that ends with a user's text: `before` is ours and declares what it calls.
///
/// What is wrong with the user's text is told with line and column of `path`, whose text it is.
pub fn compile(before: &str, user: &str, path: &Path) -> Result<Vec<u32>> {
    imp::compile(before, user, path)
}

/// Can this build compile GLSL?
pub const AVAILABLE: bool = cfg!(feature = "glsl");

/// The text with spaces for comments.
pub(crate) fn without_comments(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = ["//", "/*"].iter().filter_map(|mark| rest.find(mark)).min() {
        out.push_str(&rest[..start]);
        rest = &rest[start..];
        let end = match rest.starts_with("//") {
            true => rest.find('\n').unwrap_or(rest.len()),
            false => rest.find("*/").map_or(rest.len(), |end| end + 2),
        };
        out.extend(rest[..end].chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        rest = &rest[end..];
    }
    out + rest
}

#[cfg(not(feature = "glsl"))]
mod imp {
    use super::*;

    pub fn compile(_: &str, _: &str, _: &Path) -> Result<Vec<u32>> {
        Err(Error::usage(
            "this build of brdf-baker has no GLSL compiler",
            "build it with `make build`, or with `cargo build --release --features glsl`, which links shaderc",
        ))
    }
}

#[cfg(feature = "glsl")]
mod imp {
    use super::*;

    /// What our part and the user's are called in messages. A path could hold characters that `#line` cannot.
    const OURS: &str = "brdf-baker";
    const USERS: &str = "user";
    /// Errors that are shown.
    const SHOWN: usize = 8;

    pub fn compile(before: &str, user: &str, path: &Path) -> Result<Vec<u32>> {
        let broken = match spirv(before, user) {
            Ok(words) => return Ok(words),
            Err(message) => message,
        };
        // shaderc tells lines only. Of a text with one token a line, a line is a column.
        let (split, places) = one_token_a_line(user);
        let fine = match spirv(before, &split) {
            Ok(_) => vec![],
            Err(message) => located(&message, |line| places.get(line.wrapping_sub(1)).copied()),
        };
        let found = if fine.is_empty() { located(&broken, |line| Some((line, 1))) } else { fine };
        let name = path.display();
        let mut lines = vec![];
        for (line, column, message) in found.iter().take(SHOWN) {
            let text = user.lines().nth(line - 1).unwrap_or_default();
            // Tabs stay, so that the mark lies below its place.
            let indent: String = text.chars().take(column - 1).map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
            lines.push(format!("{name}:{line}:{column}: {message}\n{line:5} | {text}\n      | {indent}^"));
        }
        if lines.is_empty() {
            // A linker's error has no place.
            if let Some(name) = undefined(&broken) {
                let what = format!("`{name}` is not defined with the arguments that it is called with");
                return Err(Error::input(
                    path,
                    what,
                    "give it the types and the number of arguments that the form asks for",
                ));
            }
            lines.push(broken);
        }
        Err(Error::input(
            path,
            format!("it does not compile\n{}", lines.join("\n")),
            "it is GLSL 4.50 for Vulkan without #version, #extension, #include or `precision`; with --precision double, `float` means \
             double",
        ))
    }

    /// Words, or what the compiler says.
    fn spirv(before: &str, user: &str) -> Result<Vec<u32>, String> {
        let compiler = shaderc::Compiler::new().map_err(|e| e.to_string())?;
        let mut options = shaderc::CompileOptions::new().map_err(|e| e.to_string())?;
        options.set_optimization_level(shaderc::OptimizationLevel::Performance);
        options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_1 as u32);
        let text = format!("{before}\n#line 1 \"{USERS}\"\n{user}\n");
        let made = compiler.compile_into_spirv(&text, shaderc::ShaderKind::Compute, OURS, "main", Some(&options));
        match made {
            Ok(binary) => Ok(binary.as_binary().to_vec()),
            Err(shaderc::Error::CompilationError(_, message)) => Err(message),
            Err(other) => Err(other.to_string()),
        }
    }

    /// The function that has no body, as the linker tells it: its name, and then its types in short.
    fn undefined(message: &str) -> Option<&str> {
        let (_, after) = message.split_once("No function definition (body) found:")?;
        after.split_once('(')?.0.split_whitespace().last()
    }

    /// (line, column, message) of the errors in the user's text; `place` turns a line of the compiled text into one.
    fn located(message: &str, place: impl Fn(usize) -> Option<(usize, usize)>) -> Vec<(usize, usize, String)> {
        let error = |line: &str| {
            let (number, text) = line.strip_prefix(USERS)?.strip_prefix(':')?.split_once(": error: ")?;
            let (line, column) = place(number.parse().ok()?)?;
            Some((line, column, text.trim_start_matches("'' : ").trim().to_string()))
        };
        let mut found: Vec<_> = message.lines().filter_map(error).collect();
        found.dedup();
        found
    }

    /// The same program with one token a line outside preprocessor directives, and where each line starts in the text: its
    /// line and column from 1.
    fn one_token_a_line(text: &str) -> (String, Vec<(usize, usize)>) {
        let plain = without_comments(text);
        let (mut out, mut places) = (String::new(), vec![]);
        let mut put = |token: &str, line: usize, column: usize| {
            out.push_str(token);
            out.push('\n');
            places.push((line, column));
        };
        let mut in_directive = false;
        for (i, line) in plain.lines().enumerate() {
            if in_directive || line.trim_start().starts_with('#') {
                in_directive = line.ends_with('\\');
                put(line, i + 1, 1 + line.len() - line.trim_start().len());
                continue;
            }
            let chars: Vec<char> = line.chars().collect();
            let mut at = 0;
            while at < chars.len() {
                let start = at;
                let kind = kind(chars[at]);
                at += 1;
                while at < chars.len() && kind != Kind::Single && same_token(&chars[start..=at], kind) {
                    at += 1;
                }
                if kind != Kind::Space {
                    let token: String = chars[start..at].iter().collect();
                    put(&token, i + 1, start + 1);
                }
            }
        }
        (out, places)
    }

    #[derive(Clone, Copy, PartialEq)]
    enum Kind {
        Space,
        Word,
        Operator,
        Single,
    }

    fn kind(c: char) -> Kind {
        match c {
            c if c.is_whitespace() => Kind::Space,
            c if c.is_alphanumeric() || c == '_' || c == '.' => Kind::Word,
            '(' | ')' | '{' | '}' | '[' | ']' | ',' | ';' => Kind::Single,
            _ => Kind::Operator,
        }
    }

    /// Does the last character go on with a token of this kind? A number's exponent has a sign.
    fn same_token(token: &[char], of: Kind) -> bool {
        let [first, .., before, last] = token else {
            return kind(token[token.len() - 1]) == of;
        };
        let exponent = (first.is_ascii_digit() || *first == '.') && matches!(before, 'e' | 'E');
        kind(*last) == of || of == Kind::Word && exponent && matches!(last, '+' | '-')
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn tokens_know_where_they_were() {
            let text = "a /* b\n */ += 1e-3*c.x; // d\n#define E 1 \\\n  + 2\n\tf(-2.)";
            let (split, places) = one_token_a_line(text);
            let tokens: Vec<(&str, (usize, usize))> = split.lines().zip(places).collect();
            let expected = [
                ("a", (1, 1)),
                ("+=", (2, 5)),
                ("1e-3", (2, 8)),
                ("*", (2, 12)),
                ("c.x", (2, 13)),
                (";", (2, 16)),
                ("#define E 1 \\", (3, 1)),
                ("  + 2", (4, 3)),
                ("f", (5, 2)),
                ("(", (5, 3)),
                ("-", (5, 4)),
                ("2.", (5, 5)),
                (")", (5, 7)),
            ];
            assert_eq!(tokens, expected);
        }

        #[test]
        fn errors_have_lines_and_columns() {
            let user = "float twice(float x) {\n    return 2.0 * y;\n}\nfloat f( { }\n";
            let error = compile("#version 450\nvoid main() {}\n", user, Path::new("my.glsl")).unwrap_err().to_string();
            assert!(error.contains("my.glsl:2:18: 'y' : undeclared identifier"), "{error}");
            assert!(error.contains("    2 |     return 2.0 * y;\n      |                  ^"), "{error}");
            assert!(error.contains("my.glsl:4:10: syntax error"), "{error}");
        }
    }
}
