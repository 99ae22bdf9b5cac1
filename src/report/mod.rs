// SPDX-License-Identifier: MIT OR Apache-2.0
//! A check as one page of HTML that needs nothing else: no network, no other file.
//!
//! The page holds two JSON objects: the *result*, the very one that `verify --json` prints, from which every number on
//! the page is taken, and the *picture*, which [`table`] or [`cube`] collects: texels, references and axes to draw. The
//! script in the page draws them. An element that shows a number of the result names its place there (`data-path`) and
//! its full value (`data-value`), so that the page can be held against the JSON.

pub mod cube;
pub mod table;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use half::f16;
use serde_json::{Value, json};

use crate::texture::Meta;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPTS: [&str; 5] = [
    include_str!("element.js"),
    include_str!("common.js"),
    include_str!("table.js"),
    include_str!("cube.js"),
    include_str!("main.js"),
];

/// The page's text. `title` is what a browser shows on the tab.
pub fn page(title: &str, result: &Value, picture: &Value) -> String {
    fill(title, STYLE, &SCRIPTS.concat(), &json!({ "result": result, "picture": picture }))
}

/// A page with a style, a script and the data that the script reads.
pub(crate) fn fill(title: &str, style: &str, script: &str, data: &Value) -> String {
    // `</script>` inside a string would end the element: JSON can say `<` in another way.
    let data = data.to_string().replace('<', "\\u003c");
    let title: String = title
        .chars()
        .map(|c| match c {
            '&' => "&amp;".into(),
            '<' => "&lt;".into(),
            '{' => "&#123;".into(),
            c => c.to_string(),
        })
        .collect();
    // The data comes last, so that nothing in it is taken for a place to fill.
    PAGE.replace("{{style}}", style)
        .replace("{{script}}", script)
        .replace("{{title}}", &title)
        .replace("{{data}}", &data)
}

/// Single floats, little endian, as base64.
fn floats(values: impl IntoIterator<Item = f32>) -> String {
    STANDARD.encode(values.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

/// Half floats, the same way.
pub(crate) fn halves(values: impl IntoIterator<Item = f32>) -> String {
    STANDARD.encode(values.into_iter().flat_map(|v| f16::from_f32(v).to_le_bytes()).collect::<Vec<u8>>())
}

/// A file's statements as a list of pairs, which keeps their order.
pub(crate) fn pairs(meta: &Meta) -> Vec<(&str, &str)> {
    meta.iter().collect()
}

/// Up to `n` indices of 0..len, spread evenly, both ends included.
fn spread(len: u32, n: u32) -> Vec<u32> {
    let n = n.min(len);
    let at = |i: u32| (f64::from(i) * f64::from(len - 1) / f64::from((n - 1).max(1))).round() as u32;
    (0..n).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_name_ends_the_data_or_fills_a_place() {
        let name = "</script><b>{{style}}&.ktx2";
        let page = page(name, &json!({ "path": name }), &Value::Null);
        assert_eq!(page.matches("</script>").count(), 2, "the data and the script");
        assert!(page.contains("&lt;/script>&lt;b>&#123;&#123;style}}&amp;.ktx2</title>"));
        let (_, data) = page.split_once("type=\"application/json\">").expect("the data's element");
        let (data, _) = data.split_once("</script>").expect("its end");
        let data: Value = serde_json::from_str(data).expect("JSON");
        assert_eq!(data["result"]["path"], name);
    }

    #[test]
    fn spread_reaches_both_ends_once() {
        assert_eq!(spread(256, 5), [0, 64, 128, 191, 255]);
        assert_eq!(spread(3, 5), [0, 1, 2]);
        assert_eq!(spread(1, 5), [0]);
    }
}
