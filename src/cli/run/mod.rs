// SPDX-License-Identifier: MIT OR Apache-2.0
//! `brdf-baker run`

mod items;
mod keys;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use brdf_baker::format::Output;
use brdf_baker::recipe::{OpenJd, Origin, Recipe, Selection, normal};
use brdf_baker::{Error, Result};
use serde_json::{Value, json};

use super::Global;
use super::console::Console;
use super::device::Device;
use items::Item;

/// Chunks of a farm's job are this large before the scheduler knows how long an item takes.
const CHUNK: usize = 10;

#[derive(clap::Args)]
pub struct RunArgs {
    /// The recipe, a TOML file; its keys are the flags of `bake` and `env`
    #[arg(required_unless_present = "schema")]
    recipe: Option<PathBuf>,
    /// Write into this folder instead of the recipe's `output`
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Only check the recipe: keys, values, inputs, names of files
    #[arg(long, conflicts_with_all = ["dry_run", "emit_openjd"])]
    check: bool,
    /// Only say what would be baked and what is up to date
    #[arg(long, conflicts_with = "emit_openjd")]
    dry_run: bool,
    /// Bake what is up to date too
    #[arg(long)]
    force: bool,
    /// Stop at the first item that fails, instead of baking the others
    #[arg(long)]
    fail_fast: bool,
    /// Only bake a share: the I-th of N, or auto, as Slurm's job arrays and Kubernetes' indexed jobs say
    #[arg(long, value_name = "I/N|auto", conflicts_with = "items")]
    shard: Option<String>,
    /// Only bake these items, by their numbers in the plan: 1-10,15
    #[arg(long, value_name = "LIST")]
    items: Option<String>,
    /// Refuse to run if the recipe comes to another plan than this one, as --dry-run names it
    #[arg(long, value_name = "ID")]
    plan: Option<String>,
    /// Write the recipe as a job of a render farm, an Open Job Description template, instead of baking
    #[arg(long, value_name = "FILE.yaml", conflicts_with_all = ["shard", "items"])]
    emit_openjd: Option<PathBuf>,
    /// Say progress and failures on stdout as Open Job Description sessions read them
    #[arg(long)]
    openjd: bool,
    /// Print a JSON schema of recipes, for editors
    #[arg(long, exclusive = true)]
    schema: bool,
}

/// What became of an item.
#[derive(Clone, Copy, PartialEq)]
enum Outcome {
    Baked,
    Unchanged,
    Failed,
}

impl Outcome {
    fn name(self) -> &'static str {
        match self {
            Outcome::Baked => "baked",
            Outcome::Unchanged => "unchanged",
            Outcome::Failed => "failed",
        }
    }
}

impl RunArgs {
    pub fn run(self, global: &Global, console: &mut Console) -> Result<()> {
        let Some(path) = &self.recipe else {
            return console.raw(format!("{:#}\n", keys::schema()).as_bytes());
        };
        let mut recipe = Recipe::read(path)?;
        if let Some(output) = &self.output {
            recipe.output = normal(output);
        }
        let items = items::items(&recipe)?;
        let plan = items::plan_id(&items);
        if let Some(wanted) = self.plan.as_deref().filter(|wanted| *wanted != plan) {
            let what = format!("'{}' comes to the plan {plan}, not {wanted}", path.display());
            return Err(Error::usage(what, "the recipe or its environments changed: write the job again"));
        }
        if let Some(file) = &self.emit_openjd {
            return emit(&recipe, &items, &plan, file, console);
        }
        let selection = self.selection()?;
        if let Some(last) = selection.last().filter(|last| *last > items.len()) {
            let what = format!("there is no item {last}: '{}' has {}", path.display(), items.len());
            return Err(Error::usage(what, "--dry-run shows the items and their numbers"));
        }
        let chosen: Vec<&Item> = items.iter().filter(|item| item.is_in(&selection)).collect();
        let of = if chosen.len() == items.len() { String::new() } else { format!("{} of ", chosen.len()) };
        let head = format!("{}  {of}{} items, plan {plan}", path.display(), items.len());
        if self.check {
            let value = json!({ "recipe": path, "plan": plan, "items": items.len(), "chosen": chosen.len() });
            return console.result(&format!("{head}: sound"), &value);
        }
        let run = Run { args: &self, recipe: &recipe };
        if self.dry_run {
            return run.show(&chosen, &head, console);
        }
        run.bake(&chosen, &plan, &head, &mut Device::new(global), console)
    }

    fn selection(&self) -> Result<Selection> {
        match (&self.shard, &self.items) {
            (Some(shard), _) => Selection::shard(shard, &|name| std::env::var(name).ok()),
            (None, Some(items)) => Selection::items(items),
            (None, None) => Ok(Selection::All),
        }
    }
}

/// A recipe that is carried out.
struct Run<'a> {
    args: &'a RunArgs,
    recipe: &'a Recipe,
}

impl Run<'_> {
    /// Says what would be done.
    fn show(&self, chosen: &[&Item], head: &str, console: &mut Console) -> Result<()> {
        let mut waiting = BTreeSet::new();
        for item in chosen {
            // What reads a file that is yet to be baked is baked too.
            let is_current = !item.needs().is_some_and(|number| waiting.contains(&number))
                && !self.args.force
                && self.is_current(item, &item.origin(console)?, console)?;
            if !is_current {
                waiting.insert(item.number);
            }
            let state = if is_current { "up to date" } else { "to bake" };
            let files: Vec<String> = item.outputs.iter().map(|path| path.display().to_string()).collect();
            console.result(
                &format!("{:>5}  {state:10}  {} -> {}", item.number, item.name, files.join(", ")),
                &json!({ "item": item.number, "name": item.name, "state": state, "files": item.outputs }),
            )?;
        }
        let value = json!({ "recipe": self.recipe.path, "items": chosen.len(), "to_bake": waiting.len() });
        console.result(&format!("{head}: {} to bake", waiting.len()), &value)
    }

    /// Bakes what is not up to date, and reports each item.
    fn bake(
        &self,
        chosen: &[&Item],
        plan: &str,
        head: &str,
        device: &mut Device<'_>,
        console: &mut Console,
    ) -> Result<()> {
        let start = Instant::now();
        console.note(&format!("{head}{}", self.kinds(chosen)));
        console.items(chosen.len());
        let mut failed = BTreeSet::new();
        let (mut counts, mut first_failure) = ([0; 3], None);
        for (done, item) in chosen.iter().enumerate() {
            let began = Instant::now();
            console.item(done, &item.name);
            self.say(console, || format!("openjd_status: item {}: {}", item.number, item.name))?;
            let outcome = match item.needs().filter(|number| failed.contains(number)) {
                Some(number) => Err(Error::usage(format!("item {number}, whose file it reads, was not baked"), "")),
                None => self.bake_one(item, device, console),
            };
            let files = console.take_results();
            let report = |outcome: Outcome, sha256: Option<&str>| {
                let seconds = began.elapsed().as_secs_f64();
                let (number, name, outcome) = (item.number, &item.name, outcome.name());
                let mut report = json!({ "item": number, "name": name, "outcome": outcome, "seconds": seconds });
                if let Some(sha256) = sha256 {
                    report["recipe.sha256"] = sha256.into();
                }
                report
            };
            match outcome {
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Ok((outcome, sha256)) => {
                    counts[outcome as usize] += 1;
                    let mut report = report(outcome, Some(&sha256));
                    report["outputs"] = json!(item.outputs);
                    report["files"] = Value::Array(files);
                    let names: Vec<String> = item.outputs.iter().map(|path| path.display().to_string()).collect();
                    let text = (outcome == Outcome::Unchanged).then(|| format!("{}  unchanged", names.join(", ")));
                    console.item_result(text.as_deref(), &report)?;
                }
                Err(error) => {
                    counts[Outcome::Failed as usize] += 1;
                    failed.insert(item.number);
                    let mut report = report(Outcome::Failed, None);
                    report["error"] = error.to_string().into();
                    report["help"] = error.help().into();
                    console.item_result(None, &report)?;
                    console.failed(&format!("item {}, {}", item.number, item.name), &error);
                    if let Error::Gpu { .. } = error {
                        device.close();
                    }
                    first_failure.get_or_insert(error.exit_code());
                    if self.args.fail_fast {
                        break;
                    }
                }
            }
            self.say(console, || format!("openjd_progress: {:.2}", 100.0 * (done + 1) as f64 / chosen.len() as f64))?;
        }
        console.end_items();
        let [baked, unchanged, wrong] = counts;
        let seconds = start.elapsed().as_secs_f64();
        let value = json!({
            "recipe": self.recipe.path,
            "plan": plan,
            "items": chosen.len(),
            "baked": baked,
            "unchanged": unchanged,
            "failed": wrong,
            "seconds": seconds,
        });
        let text = format!("{head}: {baked} baked, {unchanged} unchanged, {wrong} failed  {seconds:.2} s");
        console.result(&text, &value)?;
        let what = format!("{wrong} of {} items of '{}' failed", chosen.len(), self.recipe.path.display());
        self.say(console, || if wrong > 0 { format!("openjd_fail: {what}") } else { "openjd_status: done".into() })?;
        match first_failure {
            None => Ok(()),
            Some(code) if code == (Error::Verify { what: String::new() }).exit_code() => Err(Error::Verify { what }),
            Some(_) => Err(Error::usage(what, "run it again when the causes are mended: what was baked stays")),
        }
    }

    /// Bakes an item unless it is up to date; the hash of what it is baked from.
    fn bake_one(&self, item: &Item, device: &Device<'_>, console: &mut Console) -> Result<(Outcome, String)> {
        let origin = item.origin(console)?;
        let sha256 = origin.sha256().to_string();
        if !self.args.force && self.is_current(item, &origin, console)? {
            return Ok((Outcome::Unchanged, sha256));
        }
        for folder in item.outputs.iter().filter_map(|output| output.parent()).filter(|f| *f != Path::new("")) {
            std::fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
        }
        let entry = &self.recipe.entries[item.entry];
        let plan = item.plan(&item.command()).map_err(|refusal| refusal.explain(self.recipe, entry))?;
        // A plan may have read an input.
        origin.check()?;
        plan.run(device, &origin, console)?;
        for output in &item.outputs {
            origin.state_beside(output, &mut |p| console.progress(p))?;
        }
        Ok((Outcome::Baked, sha256))
    }

    fn is_current(&self, item: &Item, origin: &Origin, console: &mut Console) -> Result<bool> {
        for output in &item.outputs {
            if !origin.is_of(output, &mut |p| console.progress(p))? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The plan in a few lines: what each entry comes to.
    fn kinds(&self, chosen: &[&Item]) -> String {
        let mut text = String::new();
        let mut counts = vec![0; self.recipe.entries.len()];
        chosen.iter().for_each(|item| counts[item.entry] += 1);
        for (entry, count) in self.recipe.entries.iter().zip(counts).filter(|(_, count)| *count > 0) {
            let subject = entry.key(entry.kind.subject()).map(|key| key.value.texts().join(", ")).unwrap_or_default();
            let targets = entry.key("for").map(|key| format!(" for {}", key.value.texts().join(", ")));
            let (line, kind) = (entry.place.line, entry.kind.name());
            text += &format!("\n  line {line}: {kind} {subject}{}: {count}", targets.unwrap_or_default());
        }
        text
    }

    /// A line that Open Job Description reads, where it was asked for.
    fn say(&self, console: &mut Console, line: impl FnOnce() -> String) -> Result<()> {
        if self.args.openjd { console.raw(format!("{}\n", line()).as_bytes()) } else { Ok(()) }
    }
}

/// Writes the template of a job.
fn emit(recipe: &Recipe, items: &[Item], plan: &str, file: &Path, console: &mut Console) -> Result<()> {
    if !file.extension().is_some_and(|e| e == "yaml" || e == "yml") {
        let what = format!("a template is YAML, which '{}' does not say", file.display());
        return Err(Error::usage(what, "name it .yaml"));
    }
    let job = OpenJd { items: items.len(), plan, chunk: CHUNK };
    let text = job.template(recipe, file)?;
    let bytes = Output::prepare(file)?.commit_bytes(text.as_bytes())?;
    let value = json!({ "path": file, "items": items.len(), "plan": plan, "bytes": bytes });
    console.result(&format!("{}  {} items, plan {plan}", file.display(), items.len()), &value)
}
