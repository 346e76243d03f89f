//! What tells a person on a terminal that work goes on, and tells the work that a person wants it to stop.

use std::cell::{Cell, RefCell};
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Work shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_millis(500);

/// A spinner on standard error while work goes on, and the wish to stop it.
pub struct Watch {
    stop: Arc<AtomicBool>,
    shown: bool,
    /// What is being done, each as a part of what stands before it.
    work: RefCell<Vec<(String, Instant)>>,
    bar: RefCell<Option<ProgressBar>>,
    asked: Cell<u32>,
}

impl Watch {
    /// A watch that shows progress when standard error is a terminal; `stop` is the wish to stop.
    pub fn new(stop: Arc<AtomicBool>) -> Watch {
        let shown = std::io::stderr().is_terminal();
        Watch { stop, shown, work: RefCell::default(), bar: RefCell::new(None), asked: Cell::new(0) }
    }

    /// Whether the user wants the work to stop. Also the moment to show that it goes on.
    pub fn interrupted(&self) -> bool {
        let asked = self.asked.get().wrapping_add(1);
        self.asked.set(asked);
        if self.shown && asked.is_multiple_of(64) {
            self.show();
        }
        self.stop.load(Ordering::Relaxed)
    }

    /// Forgets an earlier wish to stop.
    pub fn reset(&self) {
        self.stop.store(false, Ordering::Relaxed);
    }

    /// Work on this begins.
    pub fn begins(&self, what: &str) {
        let what: String = what.chars().take(60).collect();
        self.work.borrow_mut().push((what, Instant::now()));
    }

    /// The work has ended.
    pub fn ends(&self) {
        self.work.borrow_mut().pop();
        if let Some(bar) = self.bar.borrow_mut().take() {
            bar.finish_and_clear();
        }
    }

    fn show(&self) {
        let work = self.work.borrow();
        let Some((what, since)) = work.last() else { return };
        let mut bar = self.bar.borrow_mut();
        if bar.is_none() && since.elapsed() >= PATIENCE {
            let fresh = ProgressBar::new_spinner();
            if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {msg}") {
                fresh.set_style(style);
            }
            fresh.set_message(what.clone());
            fresh.enable_steady_tick(Duration::from_millis(120));
            *bar = Some(fresh);
        }
    }
}
