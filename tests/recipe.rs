// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker run`: what a recipe bakes, what it leaves alone, how its work is shared, and what it refuses.

mod common;

use std::path::Path;
use std::process::Command;

use brdf_baker::target;
use common::program::{command, environment, fails, files, on_any_device, succeeds};
use serde_json::Value;
use tempfile::TempDir;

/// A table and its average, a table for two engines, three probes in two folders with companions of every kind.
const RECIPE: &str = r#"
output = "baked"

[[bake]]
table = "albedo"
output = "albedo.exr"
size = 16

[[bake]]
table = "average-albedo"
of = "albedo.exr"
output = "average.ktx2"

[[bake]]
table = "split-sum"
for = ["bevy", "three"]
size = 16

[[env]]
input = "probes/**/*.exr"
output = "{folder}/{name}.ktx2"
size = 8
exposure = -1
irradiance = "{folder}/{name}_diffuse.dds"
irradiance-size = 4
sh = "{folder}/{name}.json"
"#;
const ITEMS: usize = 7;

fn studio() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("recipe.toml"), RECIPE).expect("writable");
    for (seed, name) in ["hall", "yard/a", "yard/b"].iter().enumerate() {
        environment(&folder.path().join(format!("probes/{name}.exr")), seed as f32);
    }
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Command {
    command(folder, &[&["run", "recipe.toml"][..], arguments].concat())
}

/// The report of each item, and that of all.
fn reports(stdout: &str) -> (Vec<Value>, Value) {
    let mut lines: Vec<Value> = stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let all = lines.pop().expect("a last line");
    (lines, all)
}

/// Numbers of the items with this outcome.
fn with(reports: &[Value], outcome: &str) -> Vec<u64> {
    reports.iter().filter(|r| r["outcome"] == outcome).map(|r| r["item"].as_u64().expect("a number")).collect()
}

fn baked(folder: &Path) -> Vec<u64> {
    let (items, all) = reports(&succeeds(&mut run(folder, &["--json"])));
    assert_eq!(items.len(), ITEMS);
    assert_eq!(all["unchanged"].as_u64().expect("a number") as usize, with(&items, "unchanged").len());
    with(&items, "baked")
}

#[test]
fn only_what_changed_is_baked_again() {
    let studio = studio();
    let here = studio.path();
    let path = |name: &str| here.join("baked").join(name);
    let plan = succeeds(&mut run(here, &["--dry-run"]));
    assert_eq!(plan.matches("to bake   ").count(), ITEMS, "{plan}");
    assert!(plan.contains("env probes/yard/b.exr -> baked/yard/b.ktx2, baked/yard/b_diffuse.dds, baked/yard/b.json"));
    assert!(files(here).len() == 4, "a plan writes nothing: {:?}", files(here));

    // Everything, with a report of each file that is what `bake` and `env` say.
    let (items, all) = reports(&succeeds(&mut run(here, &["--json"])));
    assert_eq!((with(&items, "baked").len(), &all["baked"]), (ITEMS, &Value::from(ITEMS)));
    assert_eq!(items[6]["files"].as_array().expect("files").len(), 3);
    assert!(items[6]["files"][0]["rms_error"].as_f64().expect("an error") < 1e-3);
    assert_eq!(items[2]["outputs"][0], "baked/bevy/dfg.ktx2");
    let verified = succeeds(&mut command(here, &["verify", "baked/yard/b.ktx2", "--source", "probes/yard/b.exr"]));
    assert!(verified.contains("right") && verified.contains("confirmed texels.sha256"), "{verified}");

    // Nothing, and then what each change concerns.
    assert_eq!(baked(here), [0u64; 0]);
    environment(&here.join("probes/yard/a.exr"), 7.0);
    assert_eq!(baked(here), [6], "an input");
    std::fs::write(here.join("recipe.toml"), RECIPE.replace("exposure = -1", "exposure = -2")).expect("writable");
    assert_eq!(baked(here), [5, 6, 7], "a parameter");
    std::fs::remove_file(path("hall.json")).expect("it is there");
    assert_eq!(baked(here), [5], "an output");
    for (name, item) in [("three/dfg_lut.js", 4), ("yard/b.ktx2", 7), ("yard/b_diffuse.dds", 7), ("bevy/dfg.ktx2", 3)] {
        let mut bytes = std::fs::read(path(name)).expect("it is there");
        let at = bytes.len() - 40;
        bytes[at] = if bytes[at] == b'1' { b'2' } else { b'1' };
        std::fs::write(path(name), bytes).expect("writable");
        assert_eq!(baked(here), [item], "a texel of {name}");
    }
    let table = RECIPE.replace("exposure = -1", "exposure = -2").replacen("size = 16", "size = 17", 1);
    std::fs::write(here.join("recipe.toml"), table).expect("writable");
    assert_eq!(baked(here), [1, 2], "an average follows its table");

    let (items, _) = reports(&succeeds(&mut run(here, &["--json", "--force"])));
    assert_eq!(with(&items, "baked").len(), ITEMS);
}

#[test]
fn shares_come_to_the_same_bytes() {
    let studio = studio();
    let here = studio.path();
    succeeds(&mut run(here, &[]));
    let whole = files(&here.join("baked"));
    assert_eq!(whole.len(), 4 + 3 * 3 + 3, "{whole:?}");
    let variables = |index: usize, count: usize| {
        [("JOB_COMPLETION_INDEX", index.to_string()), ("JOB_COMPLETIONS", count.to_string())]
    };
    for count in [2, 3] {
        let output = format!("shared-{count}");
        let mut seen = vec![];
        for index in (1..=count).rev() {
            let mut shard = run(here, &["-o", &output, "--json"]);
            match count {
                2 => shard.args(["--shard", &format!("{index}/{count}")]),
                _ => shard.args(["--shard", "auto"]).envs(variables(index - 1, count)),
            };
            seen.extend(with(&reports(&succeeds(&mut shard)).0, "baked"));
        }
        seen.sort_unstable();
        assert_eq!(seen, (1..=ITEMS as u64).collect::<Vec<_>>(), "each item once");
        assert_eq!(files(&here.join(&output)), whole);
        for name in &whole {
            let [a, b] =
                ["baked", &output].map(|folder| std::fs::read(here.join(folder).join(name)).expect("readable"));
            assert!(a == b, "{} differs in {count} shares", name.display());
        }
    }
    // Item 2 reads what item 1 writes: it goes with it.
    let (items, _) = reports(&succeeds(&mut run(here, &["-o", "some", "--json", "--items", "1,5-6"])));
    assert_eq!(with(&items, "baked"), [1, 2, 5, 6]);
    assert!(reports(&succeeds(&mut run(here, &["-o", "none", "--json", "--items", "2"]))).0.is_empty());
}

#[test]
fn a_job_of_a_farm_belongs_to_its_plan() {
    let studio = studio();
    let here = studio.path();
    succeeds(&mut run(here, &["--emit-openjd", "job.yaml"]));
    let job = std::fs::read_to_string(here.join("job.yaml")).expect("it was written");
    assert!(job.contains("range: \"1-7\"") && job.contains("default: \"baked\""), "{job}");
    let plan = job.split_once("- --plan\n            - \"").and_then(|(_, rest)| rest.get(..16)).expect("a plan");
    let arguments = ["--plan", plan, "--items", "5-6", "--openjd"];
    let stdout = succeeds(&mut run(here, &arguments));
    for line in ["openjd_status: item 5: env probes/hall.exr", "openjd_progress: 50.00", "openjd_progress: 100.00"] {
        assert!(stdout.lines().any(|l| l == line), "'{line}' is not in: {stdout}");
    }
    // One probe more, and the numbers mean others.
    environment(&here.join("probes/annex.exr"), 9.0);
    fails(&mut run(here, &arguments), 2, &["comes to the plan", &format!("not {plan}"), "write the job again"]);
    fails(&mut run(here, &["--emit-openjd", "job.json"]), 2, &["a template is YAML"]);
    fails(&mut run(here, &["--emit-openjd", "probes/job.yaml"]), 2, &["does not lie below the template"]);
    fails(&mut run(here, &["--items", "9"]), 2, &["there is no item 9", "has 8"]);
}

#[test]
fn one_that_fails_does_not_stop_the_others() {
    let studio = studio();
    let here = studio.path();
    std::fs::write(here.join("probes/broken.exr"), "not a picture").expect("writable");
    std::fs::create_dir_all(here.join("baked/albedo.exr")).expect("writable");
    let words =
        ["item 1, bake albedo", "name a file", "item 5, env probes/broken.exr", "it is not in a format", "3 of 8"];
    let (items, all) = reports(&fails(&mut run(here, &["--json"]), 2, &words));
    assert_eq!(with(&items, "failed"), [1, 2, 5]);
    assert_eq!(items[1]["error"], "item 1, whose file it reads, was not baked");
    assert!(items[4]["help"].as_str().expect("a way out").contains(".hdr"));
    assert_eq!((&all["failed"], &all["baked"]), (&3.into(), &5.into()));
    let stdout = fails(&mut run(here, &["--force", "--fail-fast", "--openjd"]), 2, &["1 of 8 items"]);
    assert!(stdout.contains("openjd_fail: 1 of 8 items") && stdout.contains("0 baked"), "{stdout}");
}

#[test]
fn mistakes_are_refused_before_any_work_with_their_place() {
    let studio = studio();
    let here = studio.path();
    let before = files(here);
    let bake = |keys: &str| format!("[[bake]]\ntable = \"split-sum\"\noutput = \"a.ktx2\"\n{keys}\n");
    let env = |keys: &str| format!("[[env]]\ninput = \"probes/**/*.exr\"\n{keys}\n");
    for (recipe, words) in [
        (bake("sise = 3"), ["line 4, column 1: unknown key 'sise' of [[bake]]", "did you mean 'size'?"]),
        (bake("size = \"3y\""), ["line 4, column 1: invalid value '3y' for 'size'", "bake --help"]),
        (bake("ndf = \"gxg\""), ["line 4, column 1: unknown distribution 'gxg'", "did you mean 'ggx'?"]),
        (bake("for = \"bevi\""), ["line 4, column 1: unknown target 'bevi'", "did you mean 'bevy'?"]),
        (bake("ior = 1.5\nmaterial = \"copper\""), ["line 4, column 1", "'ior' cannot be used with"]),
        (bake("for = []"), ["line 4, column 7: 'for' is an empty list", "leave it out"]),
        (bake("exact-rows = 1"), ["line 4, column 1: 'exact-rows' is neither true nor false", "without quotes"]),
        (bake("[[bake]]\noutput = \"b.ktx2\""), ["line 4, column 1: [[bake]] has no 'table'", "table ="]),
        (env(""), ["line 1, column 1: [[env]] has no 'output'", "'for'"]),
        (env("output = \"a.ktx2\"\nsh-order = 3"), ["[[env]] has no 'sh'", "add it"]),
        (env("output = \"a.ktx2\""), ["would both write 'a.ktx2'", "put {folder}"]),
        (env("output = \"probes/{name}/x.exr\""), ["its pattern would find 'probes/a/x.exr'", "does not look"]),
        (env("output = \"{nane}.ktx2\""), ["line 3, column 1: 'output' has an unknown placeholder {nane}", "'name'"]),
        (env("output = \"{target}/{name}.ktx2\""), ["line 3, column 1: {target} stands for nothing", "'for'"]),
        (env("output = \"{name}.png\"\nshape = \"equirect\"\nmips = 3"), ["PNG holds one level", "--mips 1"]),
        (
            "[[env]]\ninput = \"x.exr\"\noutput = \"a.ktx2\"\n".into(),
            ["line 2, column 1: cannot read 'x.exr'", "spelling"],
        ),
        (
            "[[env]]\ninput = []\noutput = \"a.ktx2\"\n".into(),
            ["line 2, column 9: 'input' is an empty list", "leave it out"],
        ),
        (
            "[[env]]\ninput = [\"probes/*.exr\", \"none/*.exr\"]\noutput = \"{name}.ktx2\"\n".into(),
            ["line 2, column 1: 'none/*.exr' finds no file", "relative to the recipe's folder"],
        ),
        ("[[env]]\ninput = \"x.exr\noutput = 3".into(), ["line 2, column", "TOML"]),
    ] {
        std::fs::write(here.join("recipe.toml"), &recipe).expect("writable");
        for arguments in [&["--check"][..], &[]] {
            let stdout = fails(&mut run(here, arguments), 2, &[&["cannot use 'recipe.toml'"][..], &words].concat());
            assert!(stdout.is_empty(), "{recipe}: {stdout}");
        }
        assert_eq!(files(here), before, "{recipe} left a file");
    }
}

#[test]
fn a_set_is_every_table_of_its_engines() {
    let folder = TempDir::new().expect("a folder");
    let here = folder.path();
    let plan = |output: &str| {
        let recipe = format!("[[bake]]\ntable = \"set\"\nfor = [\"blender\", \"filament\"]\n{output}");
        std::fs::write(here.join("recipe.toml"), recipe).expect("writable");
        succeeds(&mut run(here, &["--dry-run"]))
    };
    let tables = |name: &str| target::parse(name).expect(name).tables;
    for output in ["", "output = \"{target}\"\n"] {
        let plan = plan(output);
        for (engine, preset) in
            ["blender", "filament"].iter().flat_map(|name| tables(name).iter().map(move |p| (name, p)))
        {
            let stem = preset.stem;
            let line = format!("bake {stem} for {engine} -> {engine}/{stem}.{}", preset.extension);
            assert!(plan.contains(&line), "'{line}' is not in: {plan}");
        }
        assert_eq!(plan.lines().count(), tables("blender").len() + tables("filament").len() + 1, "{plan}");
    }
}

#[test]
fn the_schema_is_that_of_the_flags() {
    let found = succeeds(&mut on_any_device(Path::new("."), &["run", "--schema"]));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/recipe.schema.json");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, &found).expect("writable");
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == written, "docs/recipe.schema.json is not what `run --schema` prints: renew it with BLESS=1");
    // The example has no key that the schema does not know.
    let schema: Value = serde_json::from_str(&found).expect("JSON");
    let property = |kind: &str, key: &str| schema["properties"][kind]["items"]["properties"][key]["type"].clone();
    assert_eq!(property("env", "exposure"), "number");
    assert_eq!(property("env", "mirror"), "boolean");
    assert_eq!(property("env", "mips"), "integer");
    assert_eq!(property("env", "input"), serde_json::json!(["string", "array"]));
    assert_eq!(property("bake", "size"), serde_json::json!(["string", "integer"]));
}
