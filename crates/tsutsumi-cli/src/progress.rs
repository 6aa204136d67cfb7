//! Progress: a bar on a terminal, a line now and then elsewhere; Ctrl-C asks the run to end.

use std::io::IsTerminal;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tsutsumi_case::{Observer, Progress, Wish};

/// Until the first line where there is no terminal, and between the next ones.
pub(crate) const FIRST_LINE: Duration = Duration::from_secs(2);
pub(crate) const BETWEEN_LINES: Duration = Duration::from_secs(10);
/// Positions of the bar.
pub(crate) const RESOLUTION: f64 = 1000.0;

/// Shows a run to a person.
pub(crate) struct Display {
    stop: Arc<AtomicBool>,
    started: Instant,
    style: Style,
}

enum Style {
    Quiet,
    Bar(ProgressBar),
    Lines { next: Instant },
}

impl Display {
    pub(crate) fn new(quiet: bool) -> Self {
        let style = match (quiet, std::io::stderr().is_terminal()) {
            (true, _) => Style::Quiet,
            (false, true) => Style::Bar(bar()),
            (false, false) => Style::Lines { next: Instant::now() + FIRST_LINE },
        };
        Display { stop: stop_on_signal(), started: Instant::now(), style }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let Style::Bar(bar) = &self.style {
            bar.finish_and_clear();
        }
    }

    /// Steps made, of about how many; time; what is left of the wall time.
    fn words(&self, progress: &Progress) -> String {
        let share = progress.time / progress.end;
        let all = progress.steps as f64 + (progress.end - progress.time) / progress.dt;
        let left = self.started.elapsed().as_secs_f64() * (1.0 - share) / share;
        let left = if left.is_finite() { format!(", {left:.0} s left") } else { String::new() };
        format!("step {} of {all:.0}, t = {:.4e} of {} s{left}", progress.steps, progress.time, progress.end)
    }
}

/// A flag that Ctrl-C sets.
pub(crate) fn stop_on_signal() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    // A second Ctrl-C ends the program at once, should the first one go unheard.
    let handler = move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(crate::INTERRUPTED));
        }
    };
    // Without a handler Ctrl-C ends the program; the results on disk are whole all the same.
    let _ = ctrlc::set_handler(handler);
    stop
}

pub(crate) fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(RESOLUTION as u64), ProgressDrawTarget::stderr());
    match ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}") {
        Ok(style) => bar.with_style(style),
        // The template is fixed and right; a plain bar would do as well.
        Err(_) => bar,
    }
}

impl Observer for Display {
    fn started(&mut self, folder: &Path, progress: &Progress) {
        self.started = Instant::now();
        if !matches!(self.style, Style::Quiet) {
            eprintln!("writing to {}, step {:.4e} s", folder.display(), progress.dt);
        }
    }

    fn advanced(&mut self, progress: &Progress) -> Wish {
        let words = self.words(progress);
        match &mut self.style {
            Style::Quiet => {}
            Style::Bar(bar) => {
                bar.set_position((RESOLUTION * progress.time / progress.end) as u64);
                bar.set_message(words);
            }
            Style::Lines { next } if Instant::now() >= *next => {
                *next = Instant::now() + BETWEEN_LINES;
                eprintln!("{words}");
            }
            Style::Lines { .. } => {}
        }
        if self.stop.load(Ordering::Relaxed) { Wish::Stop } else { Wish::Continue }
    }

    fn warned(&mut self, message: &str) {
        match &self.style {
            Style::Bar(bar) => bar.suspend(|| eprintln!("warning: {message}")),
            _ => eprintln!("warning: {message}"),
        }
    }
}
