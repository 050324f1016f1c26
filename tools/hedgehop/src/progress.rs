//! Progress on standard error: a bar on a terminal, plain lines or JSON lines elsewhere.

use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use serde_json::json;

use crate::interrupt::Interrupt;
use hedgehop::progress::Observer;

/// Form in which progress is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// A bar on a terminal, plain lines elsewhere.
    Auto,
    /// A line every few seconds.
    Plain,
    /// One JSON object per line.
    Json,
    /// Nothing but notes and errors.
    None,
    /// Nothing: of work that is part of another.
    #[value(skip)]
    Silent,
}

/// Time between plain lines: seldom enough for a log, often enough to see life.
const PLAIN_INTERVAL: Duration = Duration::from_secs(5);
/// Time between JSON lines: often enough to draw a bar from.
const JSON_INTERVAL: Duration = Duration::from_secs(1);

/// Tells the user what the library does, and the library when the user wants it to stop.
#[derive(Debug)]
pub struct Reporter {
    interrupt: Interrupt,
    voice: Arc<Voice>,
}

/// Voice on standard error; also the thread has it that hears of Ctrl-C.
#[derive(Debug)]
struct Voice {
    mode: Mode,
    /// Whether it was told that the work stops.
    stopping: AtomicBool,
    stage: Mutex<Option<Stage>>,
}

#[derive(Debug)]
struct Stage {
    name: String,
    unit: String,
    total: u64,
    done: u64,
    begun: Instant,
    told: Instant,
    bar: Option<ProgressBar>,
}

impl Reporter {
    /// A reporter for `mode`; `Auto` looks at standard error.
    pub fn new(mode: Mode, interrupt: &Interrupt) -> Self {
        let voice = Arc::new(Voice { mode, stopping: AtomicBool::new(false), stage: Mutex::new(None) });
        let heard = voice.clone();
        interrupt.tell_at_once(move || heard.tell_stopping());
        Self { interrupt: interrupt.clone(), voice }
    }

    /// Returns what it hears interruptions from.
    pub fn interrupt(&self) -> &Interrupt {
        &self.interrupt
    }

    /// Returns another reporter of the same interruptions.
    pub fn with_mode(&self, mode: Mode) -> Self {
        let voice = Voice { mode, stopping: AtomicBool::new(false), stage: Mutex::new(None) };
        Self { interrupt: self.interrupt.clone(), voice: Arc::new(voice) }
    }
}

impl Voice {
    fn draws_bar(&self) -> bool {
        self.mode == Mode::Auto && io::stderr().is_terminal()
    }

    fn interval(&self) -> Duration {
        if self.mode == Mode::Json { JSON_INTERVAL } else { PLAIN_INTERVAL }
    }

    /// A line above the bar, if there is one. A closed standard error ends no work.
    fn line(&self, stage: Option<&Stage>, text: &str) {
        let print = || {
            let _ = writeln!(io::stderr().lock(), "{text}");
        };
        match stage.and_then(|stage| stage.bar.as_ref()) {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }

    fn tell(&self, stage: &Stage, event: &str) {
        match self.mode {
            Mode::Json => self.line(None, &stage.json(event).to_string()),
            Mode::None | Mode::Silent => {}
            Mode::Auto | Mode::Plain => self.line(None, &stage.sentence(event)),
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Stage>> {
        // A panic elsewhere cannot leave a stage half-written.
        self.stage.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn note(&self, text: &str) {
        if self.mode == Mode::Silent {
            return;
        }
        let lock = self.lock();
        if self.mode == Mode::Json {
            self.line(None, &json!({ "event": "note", "text": text }).to_string());
        } else {
            self.line(lock.as_ref(), &format!("note: {text}"));
        }
    }

    /// Says once what becomes of the work.
    fn tell_stopping(&self) {
        if !self.stopping.swap(true, Ordering::Relaxed) {
            self.note("stopping after the work in hand; press Ctrl-C again to stop at once");
        }
    }
}

impl Observer for Reporter {
    fn begin(&self, name: &str, total: u64, unit: &str) {
        let voice = &self.voice;
        let bar = voice.draws_bar().then(|| bar(name, total, unit));
        let now = Instant::now();
        let stage =
            Stage { name: name.into(), unit: unit.into(), total, done: 0, begun: now, told: now, bar };
        if voice.mode == Mode::Json {
            voice.tell(&stage, "begin");
        }
        *voice.lock() = Some(stage);
    }

    fn advance(&self, count: u64) {
        let mut lock = self.voice.lock();
        let Some(stage) = lock.as_mut() else { return };
        stage.done += count;
        if let Some(bar) = &stage.bar {
            bar.inc(count);
        } else if stage.told.elapsed() >= self.voice.interval() {
            stage.told = Instant::now();
            self.voice.tell(stage, "progress");
        }
    }

    fn end(&self) {
        let Some(stage) = self.voice.lock().take() else { return };
        match &stage.bar {
            Some(bar) => bar.finish_and_clear(),
            None => self.voice.tell(&stage, "end"),
        }
    }

    fn note(&self, text: &str) {
        self.voice.note(text);
    }

    fn cancelled(&self) -> bool {
        let requested = self.interrupt.requested();
        if requested {
            self.voice.tell_stopping();
        }
        requested
    }
}

fn bar(name: &str, total: u64, unit: &str) -> ProgressBar {
    let template = "{prefix} [{wide_bar}] {percent} %  {human_pos}/{human_len} {msg}  {rate}/s  ETA {eta}";
    let style = ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .with_key("rate", |state: &ProgressState, text: &mut dyn std::fmt::Write| {
            // The bar is redrawn soon, should this ever fail.
            let _ = text.write_str(&significant(state.per_sec()));
        });
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr())
        .with_style(style.progress_chars("=> "))
        .with_prefix(name.to_owned())
        .with_message(unit.to_owned());
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

impl Stage {
    /// Units per second since the stage began; `None` before anything is done.
    fn rate(&self) -> Option<f64> {
        let seconds = self.begun.elapsed().as_secs_f64();
        (self.done > 0 && seconds > 0.0).then(|| self.done as f64 / seconds)
    }

    fn eta_seconds(&self) -> Option<f64> {
        self.rate().map(|rate| self.total.saturating_sub(self.done) as f64 / rate)
    }

    fn sentence(&self, event: &str) -> String {
        let Self { name, unit, total, done, .. } = self;
        let rate = self.rate().map_or_else(String::new, |rate| format!(", {} {unit}/s", significant(rate)));
        if event == "end" {
            return format!("{name}: {done} {unit} in {}{rate}", clock(self.begun.elapsed().as_secs_f64()));
        }
        let percent = if *total == 0 { 100 } else { (done * 100) / total };
        let eta = self.eta_seconds().map_or_else(String::new, |eta| format!(", ETA {}", clock(eta)));
        format!("{name}: {percent} % ({done}/{total} {unit}){rate}{eta}")
    }

    fn json(&self, event: &str) -> serde_json::Value {
        json!({
            "event": event,
            "stage": self.name,
            "done": self.done,
            "total": self.total,
            "unit": self.unit,
            "elapsed_s": self.begun.elapsed().as_secs_f64(),
            "rate_per_s": self.rate(),
            "eta_s": self.eta_seconds(),
        })
    }
}

/// Three significant digits, as people read rates.
fn significant(value: f64) -> String {
    match value {
        v if v >= 100.0 => format!("{v:.0}"),
        v if v >= 10.0 => format!("{v:.1}"),
        v => format!("{v:.2}"),
    }
}

/// `m:ss` or `h:mm:ss`.
fn clock(seconds: f64) -> String {
    // Saturates for the absurd estimates of a stage that has hardly begun.
    let whole = seconds.round() as u64;
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes}:{seconds:02}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_read_as_clocks() {
        assert_eq!(clock(5.4), "0:05");
        assert_eq!(clock(59.6), "1:00");
        assert_eq!(clock(3723.0), "1:02:03");
    }

    #[test]
    fn a_stage_without_work_has_no_rate_and_no_division_by_zero() {
        let now = Instant::now();
        let stage = Stage {
            name: "pages".into(),
            unit: "pages".into(),
            total: 0,
            done: 0,
            begun: now,
            told: now,
            bar: None,
        };
        assert_eq!(stage.rate(), None);
        assert_eq!(stage.sentence("progress"), "pages: 100 % (0/0 pages)");
    }
}
