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
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::Value;

use super::Global;

/// Resolution of the progress bar.
const BAR_STEPS: u64 = 1000;
/// A command that has not ended by itself so long after Ctrl-C is ended from outside: a decoder, a driver's compiler and
/// a disk know nothing of cancelling.
const GRACE: Duration = Duration::from_millis(50);

/// Standard output, the progress bar, and the cancel flag.
pub struct Console {
    json: bool,
    quiet: bool,
    bar: ProgressBar,
    cancelled: Arc<AtomicBool>,
}

impl Console {
    /// Takes over Ctrl-C: the running command ends within one slice of work, at the latest after [`GRACE`], and leaves no
    /// file.
    pub fn new(global: &Global) -> Result<Console> {
        let bar = if global.quiet || global.json || !std::io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            let style = ProgressStyle::with_template("{msg:24} {bar:40} {percent:>3} %  {elapsed}")
                .expect("the template is valid");
            ProgressBar::new(BAR_STEPS).with_style(style)
        };
        let cancelled = Arc::new(AtomicBool::new(false));
        let (flag, shown) = (cancelled.clone(), bar.clone());
        let on_ctrl_c = move || {
            flag.store(true, Ordering::Relaxed);
            std::thread::sleep(GRACE);
            let _no_more_files = format::abandon();
            shown.finish_and_clear();
            report(&Error::Cancelled);
            // Not through the exit handlers of libraries: a driver's would wait for threads that are still at work.
            signal_hook::low_level::exit(Error::Cancelled.exit_code().into());
        };
        ctrlc::set_handler(on_ctrl_c).map_err(|e| Error::usage(format!("cannot take over Ctrl-C: {e}"), ""))?;
        Ok(Console { json: global.json, quiet: global.quiet, bar, cancelled })
    }

    /// Shows progress; breaks when the user pressed Ctrl-C.
    pub fn progress(&mut self, progress: Progress<'_>) -> ControlFlow<()> {
        if self.bar.message() != progress.stage {
            self.bar.set_message(progress.stage.to_string());
        }
        self.bar.set_position((progress.done * BAR_STEPS as f64) as u64);
        if self.cancelled.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Prints one result: `text` for people, `value` with --json.
    pub fn result(&mut self, text: &str, value: &Value) -> Result<()> {
        self.bar.finish_and_clear();
        let line = if self.json { value.to_string() } else { text.to_string() };
        self.raw(format!("{line}\n").as_bytes())
    }

    /// Writes bytes to stdout.
    pub fn raw(&mut self, bytes: &[u8]) -> Result<()> {
        let mut out = std::io::stdout().lock();
        match out.write_all(bytes).and_then(|()| out.flush()) {
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
        if !self.quiet {
            self.bar.suspend(|| eprintln!("warning: {text}"));
        }
    }
}

/// Prints an error and its way out to stderr; only the first, as a command that ends and the handler of Ctrl-C may both
/// come here.
pub fn report(error: &Error) {
    static REPORTED: AtomicBool = AtomicBool::new(false);
    if REPORTED.swap(true, Ordering::Relaxed) {
        return;
    }
    eprintln!("error: {error}");
    if !error.help().is_empty() {
        eprintln!("  help: {}", error.help());
    }
}
