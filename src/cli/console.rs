// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the user sees: results on stdout, progress and errors on stderr, and Ctrl-C.

use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use brdf_baker::format;
use brdf_baker::progress::Progress;
use brdf_baker::target::Choice;
use brdf_baker::{Error, Result};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::Value;

use super::Global;

/// Resolution of the progress bar.
const BAR_STEPS: u64 = 1000;
/// A command that has not ended by itself so long after Ctrl-C is ended from outside: a decoder, a driver's compiler and
/// a disk know nothing of cancelling.
const GRACE: Duration = Duration::from_millis(50);

/// Standard output, the progress bars, and the cancel flag.
pub struct Console {
    json: bool,
    quiet: bool,
    bars: MultiProgress,
    /// How far the present piece of work has come.
    bar: ProgressBar,
    /// How many items of a recipe are done, above it.
    items: Option<ProgressBar>,
    /// Results of the present item, which are reported together.
    held: Vec<Value>,
    cancelled: Arc<AtomicBool>,
}

impl Console {
    /// Takes over Ctrl-C: the running command ends within one slice of work, at the latest after [`GRACE`], and leaves no
    /// file.
    pub fn new(global: &Global) -> Result<Console> {
        let bars = MultiProgress::new();
        if global.quiet || global.json || !std::io::stderr().is_terminal() {
            bars.set_draw_target(ProgressDrawTarget::hidden());
        }
        let style = style("{msg:24} {bar:40} {percent:>3} %  {elapsed}");
        let bar = bars.add(ProgressBar::new(BAR_STEPS).with_style(style));
        let cancelled = Arc::new(AtomicBool::new(false));
        let (flag, shown) = (cancelled.clone(), bars.clone());
        let on_ctrl_c = move || {
            flag.store(true, Ordering::Relaxed);
            std::thread::sleep(GRACE);
            let _no_more_files = format::abandon();
            // Bars that cannot be wiped away do no harm.
            let _ = shown.clear();
            report(&Error::Cancelled);
            // Not through the exit handlers of libraries: a driver's would wait for threads that are still at work.
            signal_hook::low_level::exit(Error::Cancelled.exit_code().into());
        };
        ctrlc::set_handler(on_ctrl_c).map_err(|e| Error::usage(format!("cannot take over Ctrl-C: {e}"), ""))?;
        Ok(Console { json: global.json, quiet: global.quiet, bars, bar, items: None, held: vec![], cancelled })
    }

    /// Shows progress; breaks when the user pressed Ctrl-C.
    pub fn progress(&mut self, progress: Progress<'_>) -> ControlFlow<()> {
        if self.bar.message() != progress.stage {
            self.bar.set_message(progress.stage.to_string());
        }
        self.bar.set_position((progress.done * BAR_STEPS as f64) as u64);
        if self.cancelled.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Shows a bar for the items of a recipe. From now on, results belong to the item that was named last.
    pub fn items(&mut self, count: usize) {
        let style = style("{prefix:24} {bar:40} {percent:>3} %  {elapsed}, {eta} left  {msg}");
        self.items = Some(self.bars.insert_before(&self.bar, ProgressBar::new(count as u64).with_style(style)));
    }

    /// Begins an item, after `done` others.
    pub fn item(&mut self, done: usize, name: &str) {
        if let Some(items) = &self.items {
            items.set_prefix(format!("{done} of {} items", items.length().unwrap_or_default()));
            items.set_message(name.to_string());
            items.set_position(done as u64);
        }
        self.bar.reset();
    }

    /// Ends the last item: results are results again.
    pub fn end_items(&mut self) {
        self.bar.finish_and_clear();
        if let Some(items) = self.items.take() {
            items.finish_and_clear();
        }
    }

    /// The results of the item, as --json shows them.
    pub fn take_results(&mut self) -> Vec<Value> {
        std::mem::take(&mut self.held)
    }

    /// Prints what became of an item or of all of them: `text` for people, if there is something to say, `value` with
    /// --json.
    pub fn item_result(&mut self, text: Option<&str>, value: &Value) -> Result<()> {
        match (self.json, text) {
            (true, _) => self.raw(format!("{value}\n").as_bytes()),
            (false, Some(text)) => self.raw(format!("{text}\n").as_bytes()),
            (false, None) => Ok(()),
        }
    }

    /// Prints one result: `text` for people, `value` with --json.
    pub fn result(&mut self, text: &str, value: &Value) -> Result<()> {
        self.bar.finish_and_clear();
        if self.items.is_some() {
            self.held.push(value.clone());
            return if self.json { Ok(()) } else { self.raw(format!("{text}\n").as_bytes()) };
        }
        let line = if self.json { value.to_string() } else { text.to_string() };
        self.raw(format!("{line}\n").as_bytes())
    }

    /// Writes bytes to stdout.
    pub fn raw(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.bars.suspend(|| {
            let mut out = std::io::stdout().lock();
            out.write_all(bytes).and_then(|()| out.flush())
        });
        match written {
            // The reader (`head`, say) has all that it wanted.
            Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
            written => written.map_err(|e| Error::io("write", Path::new("stdout"), e)),
        }
    }

    /// Says what the user chose instead of a target's preset.
    pub fn overrides(&self, choice: &Choice) {
        if let (Some(target), [_, ..]) = (choice.target(), choice.overrides()) {
            self.warn(&format!("not what {target} wants by default: {}", choice.overrides().join(", ")));
        }
    }

    /// Prints a warning to stderr.
    pub fn warn(&self, text: &str) {
        self.note(&format!("warning: {text}"));
    }

    /// Prints to stderr what is no error.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            self.bars.suspend(|| complain(text));
        }
    }

    /// Prints why an item failed; the others go on.
    pub fn failed(&self, item: &str, error: &Error) {
        self.bars.suspend(|| complain(&format!("error: {item}: {}", in_full(error))));
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is valid")
}

/// Writes a line to stderr; nobody can be told when that fails.
fn complain(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// An error with its way out.
fn in_full(error: &Error) -> String {
    match error.help() {
        "" => error.to_string(),
        help => format!("{error}\n  help: {help}"),
    }
}

/// Prints an error and its way out to stderr; only the first, as a command that ends and the handler of Ctrl-C may both
/// come here.
pub fn report(error: &Error) {
    static REPORTED: AtomicBool = AtomicBool::new(false);
    if REPORTED.swap(true, Ordering::Relaxed) {
        return;
    }
    complain(&format!("error: {}", in_full(error)));
}
