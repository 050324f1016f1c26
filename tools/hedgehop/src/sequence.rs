//! Many frames, one after the other; writing overlaps with rendering the next.
//!
//! ```text
//! for each camera:  frame = render on the farm ──bounded channel──▶ encoder threads: sink(frame)
//! ```
//! The channel holds as many frames as there are encoders, so that memory stays bounded when the
//! disk is slower than the farm.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crossbeam::channel::{Receiver, Sender, bounded};
use hedgehop::frame::Frame;
use hedgehop::progress::Observer;
use hedgehop::render::{RenderOptions, render_frame};
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};

/// A finished frame on its way to the disk.
#[derive(Debug)]
pub struct Shot {
    /// Absolute number, 1…
    pub number: u64,
    /// The picture.
    pub frame: Frame,
}

/// What renders.
#[derive(Debug, Clone, Copy)]
pub struct Sequence<'a, S> {
    /// The database.
    pub source: &'a S,
    /// How pictures look.
    pub options: &'a RenderOptions,
    /// Who renders.
    pub farm: &'a Farm,
    /// Threads that write; one if the order matters.
    pub encoders: usize,
}

/// What became of a sequence.
#[derive(Debug)]
pub struct Flown {
    /// Numbers of frames that the sink has taken, rising.
    pub finished: Vec<u64>,
    /// The first thing that went wrong, or that the user asked to stop.
    pub end: Result<()>,
}

impl<S: PageSource> Sequence<'_, S> {
    /// Renders `cameras` in order and hands every frame to `sink`.
    pub fn fly(
        &self,
        cameras: &[(u64, Camera)],
        sink: &(dyn Fn(Shot) -> Result<()> + Sync),
        observer: &dyn Observer,
    ) -> Flown {
        let failed = AtomicBool::new(false);
        observer.begin("render", cameras.len() as u64, "frames");
        let flown = thread::scope(|scope| {
            let (sender, receiver) = bounded(self.encoders);
            let encoders: Vec<_> = (0..self.encoders)
                .map(|_| {
                    let receiver = receiver.clone();
                    scope.spawn(|| encode(receiver, sink, &failed, observer))
                })
                .collect();
            drop(receiver);
            let mut flown =
                Flown { finished: Vec::new(), end: self.render_all(cameras, sender, &failed, observer) };
            for encoder in encoders {
                let (finished, end) = encoder.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                flown.finished.extend(finished);
                // The cause of a stop is what an encoder says; the renderer only notices it.
                if end.is_err() {
                    flown.end = end;
                }
            }
            flown.finished.sort_unstable();
            flown
        });
        observer.end();
        flown
    }

    fn render_all(
        &self,
        cameras: &[(u64, Camera)],
        sender: Sender<Shot>,
        failed: &AtomicBool,
        observer: &dyn Observer,
    ) -> Result<()> {
        for &(number, ref camera) in cameras {
            if failed.load(Ordering::Relaxed) {
                break;
            }
            if observer.cancelled() {
                return Err(Error::Interrupted("frames written so far are whole".into()));
            }
            let frame = render_frame(self.source, camera, self.options, self.farm)?.frame;
            if sender.send(Shot { number, frame }).is_err() {
                break;
            }
        }
        Ok(())
    }
}

fn encode(
    shots: Receiver<Shot>,
    sink: &(dyn Fn(Shot) -> Result<()> + Sync),
    failed: &AtomicBool,
    observer: &dyn Observer,
) -> (Vec<u64>, Result<()>) {
    let mut finished = Vec::new();
    for shot in shots {
        let number = shot.number;
        if let Err(error) = sink(shot) {
            failed.store(true, Ordering::Relaxed);
            return (finished, Err(error));
        }
        finished.push(number);
        observer.advance(1);
    }
    (finished, Ok(()))
}
