//! Prints errors, warnings and notes, with the source line they refer to.

use std::{
    io::{ErrorKind, IsTerminal, Write},
    process::ExitCode,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use indicatif::{ProgressBar, ProgressStyle};
use tatu_core::errors::Error;
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain_text};

/// Prints a line on standard output. If this fails, the run continues. The exit code is then 1 (see [`finish`]), unless
/// the reader has closed the pipe, as `| head` does.
#[macro_export]
macro_rules! out {
    ($($text:tt)*) => {{
        use std::io::Write;
        $crate::report::wrote(writeln!(std::io::stdout(), $($text)*));
    }};
}
/// Prints a line on standard error; failures are ignored.
#[macro_export]
macro_rules! err {
    ($($text:tt)*) => {{
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}
pub use crate::{err, out};

/// Help text of the error that reports a crash; `tatu plugin check` omits it from its findings.
pub const CRASH_HELP: &str = "the output and trace up to this point have been written; run the program in a debugger, \
                              or report the crash to the plugin's author";

/// Whether output of the program was lost.
static OUTPUT_LOST: AtomicBool = AtomicBool::new(false);

/// Records that writing to standard output failed. A closed pipe, as with `| head`, is not an error.
pub fn wrote(result: std::io::Result<()>) {
    if let Err(e) = result
        && e.kind() != ErrorKind::BrokenPipe
        && !OUTPUT_LOST.swap(true, Ordering::Relaxed)
    {
        error(
            &Error::new("E105", format!("cannot write standard output: {e}")).help("check that the disk is not full"),
        );
    }
}

/// Prints an error about lost output, which makes [`finish`] return 1 instead of 0.
pub fn report_lost_output(e: &Error) {
    OUTPUT_LOST.store(true, Ordering::Relaxed);
    error(e);
}

/// Returns the exit code of the program: `code`, or 1 if `code` is 0 although output was lost.
pub fn finish(code: ExitCode) -> ExitCode {
    wrote(std::io::stdout().flush());
    if OUTPUT_LOST.load(Ordering::Relaxed) && code == ExitCode::SUCCESS { ExitCode::FAILURE } else { code }
}

/// Prints an error with its help and source line on standard error.
pub fn error(e: &Error) {
    print(e, Level::ERROR);
}

/// The warnings so far, for the summary and for `--strict`.
static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Maximum number of stored warnings, because a script may warn in every step.
const MAX_STORED_WARNINGS: usize = 1000;

/// Stores a warning that was printed.
fn store_warning(text: String) {
    let mut all = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
    if all.len() < MAX_STORED_WARNINGS {
        all.push(text);
    }
}

/// Returns the warnings that were printed so far, at most `MAX_STORED_WARNINGS`.
pub fn warnings() -> Vec<String> {
    WARNINGS.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Prints a warning in the same form as an error, and stores it.
pub fn warning(e: &Error) {
    store_warning(format!("[{}] {}", e.code, e.text));
    print(e, Level::WARNING);
}

/// Prints and stores a warning that has no code, such as a log line of a script.
pub fn warn_text(text: &str) {
    store_warning(text.to_owned());
    crate::report::err!("warning: {text}");
}

/// Prints a note on standard error.
pub fn note(text: &str) {
    crate::report::err!("note: {text}");
}

/// Creates a progress bar that counts in `unit`s. It is shown only if `wanted` is set, if standard error is a terminal,
/// and if the work takes more than a moment.
pub fn progress(length: u64, unit: &str, wanted: bool) -> ProgressBar {
    if !wanted || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(&format!("{{wide_bar}} {unit} {{pos}} of {{len}}, {{eta}} left"));
    let bar = ProgressBar::new(length).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

fn print(e: &Error, level: Level<'_>) {
    let source =
        e.place.as_ref().filter(|p| p.line > 0).and_then(|p| Some((p, read_plain_text(&p.file, MAX_FILE_BYTES).ok()?)));
    let path = e.place.as_ref().map(|p| p.file.display().to_string()).unwrap_or_default();
    let mut group =
        level.primary_title(e.text.as_str()).id(e.code).elements(Vec::<annotate_snippets::Element<'_>>::new());
    if let Some((place, text)) = &source {
        let end = place.span.end.min(text.len()).max(place.span.start.min(text.len()));
        // If only the line is known, mark the whole line.
        let span = match place.span.is_empty() && place.span.start == 0 {
            true => line_of(text, place.line),
            false => place.span.start.min(end)..end,
        };
        let label = e.expected.as_deref().filter(|x| x.len() <= 60).map(|x| format!("expected {x}"));
        let annotation = AnnotationKind::Primary.span(span);
        let annotation = match &label {
            Some(l) => annotation.label(l.clone()),
            None => annotation,
        };
        group = group.element(Snippet::source(text.clone()).path(path.clone()).annotation(annotation));
    }
    let shown = source.is_some() && e.expected.as_ref().is_some_and(|x| x.len() <= 60);
    if let Some(expected) = e.expected.as_ref().filter(|_| !shown) {
        group = group.element(Level::NOTE.message(format!("expected {expected}")));
    }
    if let Some(help) = &e.help {
        group = group.element(Level::HELP.message(help.as_str()));
    }
    let renderer = if std::io::stderr().is_terminal() { Renderer::styled() } else { Renderer::plain() };
    crate::report::err!("{}\n", renderer.render(&[group]));
}

/// Maximum number of characters of a source line that are shown; lines of logs and traces can be longer.
const MAX_LINE_CHARS: usize = 200;

/// Returns the byte range of a line in a text.
fn line_of(text: &str, line: usize) -> std::ops::Range<usize> {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let length = text[start..].lines().next().map_or(0, |l| l.chars().take(MAX_LINE_CHARS).map(char::len_utf8).sum());
    start..start + length
}

/// Subscribes to log messages outside of any world, such as the addresses of services.
pub fn install_log_printer() {
    // Fails only if a subscriber is already set, which nothing else in this program does.
    let _ = tracing::subscriber::set_global_default(LogPrinter);
}

/// Prints log messages on standard error.
struct LogPrinter;

impl tracing::Subscriber for LogPrinter {
    fn enabled(&self, metadata: &tracing::Metadata<'_>) -> bool {
        *metadata.level() <= tracing::Level::INFO && metadata.target().starts_with("tatu")
    }
    fn event(&self, event: &tracing::Event<'_>) {
        let mut text = MessageVisitor(String::new());
        event.record(&mut text);
        match *event.metadata().level() {
            tracing::Level::ERROR => err!("error: {}", text.0),
            tracing::Level::WARN => err!("warning: {}", text.0),
            _ => err!("{}", text.0),
        }
    }
    fn new_span(&self, _: &tracing::span::Attributes<'_>) -> tracing::span::Id {
        tracing::span::Id::from_u64(1)
    }
    fn record(&self, _: &tracing::span::Id, _: &tracing::span::Record<'_>) {}
    fn record_follows_from(&self, _: &tracing::span::Id, _: &tracing::span::Id) {}
    fn enter(&self, _: &tracing::span::Id) {}
    fn exit(&self, _: &tracing::span::Id) {}
}

/// Extracts the message of a log event.
struct MessageVisitor(String);

impl tracing::field::Visit for MessageVisitor {
    fn record_debug(&mut self, field: &tracing::field::Field, value: &dyn std::fmt::Debug) {
        if field.name() == "message" {
            self.0 = format!("{value:?}");
        }
    }
}
