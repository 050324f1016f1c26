//! Many frames: each overlaps with rendering the next, and with writing the one before.
//!
//! ```text
//! cameras ──▶ farm, k frames in flight ──in order, bounded channel──▶ encoder threads: sink(frame)
//! ```
//! The channel holds as many frames as there are encoders, so that memory stays bounded when the
//! disk is slower than the farm: k + 2 · encoders frames at most.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crossbeam::channel::{Receiver, Sender, bounded};

use crate::aov::AovInputs;
use crate::bound_flight::FilmMotion;
use crate::cpu_time;
use crate::finish::Finishing;
use crate::memory::Live;
use crate::product::Product;
use crate::scene::Playing;
use hedgehop::encode::sidecar::FrameCost;
use hedgehop::flight::FrameRate;
use hedgehop::frame::{Frame, Picture};
use hedgehop::memory::{Paging, ResidentPages};
use hedgehop::progress::Observer;
use hedgehop::render::{FlightPlan, LiveFrame, LivePlan, NumberedCamera, Rays, Rendered, Renderer};
use hedgehop::space::Camera;
use hedgehop::subimage::{Batch, Farm};
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};

/// A finished frame on its way to the disk.
#[derive(Debug)]
pub struct Shot {
    /// Image that was seen.
    pub image: Image,
    /// Frame that shows it, and what it cost.
    pub delivery: Delivery,
}

/// A frame as it was asked for.
#[derive(Debug)]
pub enum Image {
    /// 8-bit colour, and what saw it.
    Picture(Picture, Box<Camera>),
    /// Everything.
    Frame(Box<Frame>),
}

/// Sequence of frames to be rendered.
#[derive(Debug, Clone, Copy)]
pub struct Sequence<'a> {
    /// Pages of the database.
    pub pages: &'a ResidentPages,
    /// Renders them.
    pub renderer: &'a Renderer<'a>,
    /// Product of each frame.
    pub product: Product,
    /// Workers that render.
    pub farm: &'a Farm,
    /// Frames that are rendered at once.
    pub in_flight: usize,
    /// Threads that write; one if the order matters.
    pub encoders: usize,
    /// Frames a second of a flight that never waits for pages, and whose path nobody is to know beforehand; `None`: frames wait.
    pub live: Option<FrameRate>,
    /// Tell every second what paging costs.
    pub stats: bool,
    /// Objects of the scene, if there is one.
    pub playing: Option<&'a Playing>,
    /// Data that whole frames need for their further channels.
    pub aov_inputs: &'a AovInputs,
    /// Motion of the eye.
    pub motion: &'a FilmMotion,
    /// Steps from light to a picture, unless it is codes of the light as it is.
    pub finishing: Option<&'a Finishing<'a>>,
}

/// Result of a sequence.
#[derive(Debug)]
pub struct Flown {
    /// Numbers of frames that the sink has taken, rising.
    pub finished: Vec<u64>,
    /// Cost of paging of each delivered frame, in order.
    pub paging: Vec<(u64, Paging)>,
    /// Frames that were delivered, in order.
    pub delivered: Vec<Delivery>,
    /// First error, or that the user asked to stop.
    pub end: Result<()>,
}

/// Frame that was delivered to whoever writes it.
#[derive(Debug, Clone, Copy)]
pub struct Delivery {
    /// Absolute number, 1…
    pub number: u64,
    /// Fineness of the ground in it.
    pub rays: Rays,
    /// Time since the delivery before, or since the first frame's begin.
    pub wall: Duration,
    /// Processor time of the process in the same time, if the system says.
    pub cpu: Option<Duration>,
}

impl Delivery {
    /// Returns what the frame cost; `paging` is known once the sequence is over.
    pub fn cost(&self, paging: Option<Paging>) -> FrameCost {
        let cpu_s = self.cpu.map(|cpu| cpu.as_secs_f64());
        FrameCost { wall_s: self.wall.as_secs_f64(), cpu_s, paging }
    }
}

/// Fineness of the ground in a sequence.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fineness {
    /// Counts of all frames together.
    pub rays: Rays,
    /// The frame with the largest share of rays that met a coarser level, and that share.
    pub coarsest: Option<(u64, f64)>,
}

impl Flown {
    /// Returns the number of frames finished, and the fineness of the ground in all that were delivered.
    pub fn summed(&self) -> (usize, Fineness) {
        let mut rays = Rays::default();
        self.delivered.iter().for_each(|delivery| rays += delivery.rays);
        let shares = self.delivered.iter().map(|delivery| (delivery.number, delivery.rays.coarser_share()));
        (self.finished.len(), Fineness { rays, coarsest: shares.max_by(|(_, a), (_, b)| a.total_cmp(b)) })
    }
}

/// Renders a frame, by its place in the sequence.
type Look<'c> = dyn Fn(&Farm, u32, &Camera) -> Result<(Image, Rays)> + Sync + 'c;

/// Beginning, rendering and end of frames.
struct Flying<'c> {
    look: &'c Look<'c>,
    deliver: &'c dyn Fn(u32),
}

impl Sequence<'_> {
    /// Renders `cameras` in order and hands every frame to `sink`.
    pub fn fly(
        &self,
        cameras: &[NumberedCamera],
        sink: &(dyn Fn(&Shot) -> Result<()> + Sync),
        observer: &dyn Observer,
    ) -> Flown {
        let failed = AtomicBool::new(false);
        observer.begin("render", cameras.len() as u64, "frames");
        let flown = thread::scope(|scope| {
            let (sender, receiver) = bounded(self.encoders);
            let encoders: Vec<_> = (0..self.encoders)
                .map(|_| {
                    let receiver = receiver.clone();
                    scope.spawn(|| self.encode(receiver, sink, &failed, observer))
                })
                .collect();
            drop(receiver);
            let mut delivered = Vec::new();
            let (paging, end) = self.render_ahead(cameras, sender, &failed, &mut delivered, observer);
            let mut flown = Flown { finished: Vec::new(), paging, delivered, end };

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

    /// Renders all while what they need is brought into memory ahead of them.
    fn render_ahead(
        &self,
        cameras: &[NumberedCamera],
        sender: Sender<Shot>,
        failed: &AtomicBool,
        deliveries: &mut Vec<Delivery>,
        observer: &dyn Observer,
    ) -> (Vec<(u64, Paging)>, Result<()>) {
        let numbers = cameras.iter().map(|frame| frame.number);
        // What is looked up ahead is what several rays a pixel see.
        let side = self.finishing.map_or(1, |finishing| finishing.finish.antialias);
        let enlarged: Vec<_> = cameras
            .iter()
            .filter(|_| side > 1)
            .map(|&NumberedCamera { number, ref camera, sky }| NumberedCamera {
                number,
                camera: camera.enlarged(side),
                sky,
            })
            .collect();
        let planned = if side > 1 { &enlarged } else { cameras };
        let all =
            |flying: &Flying<'_>| self.render_all(cameras, flying, sender, failed, deliveries, observer);

        let flown = if let Some(rate) = self.live {
            let plan = LivePlan::new(self.renderer, self.farm);
            self.pages.live(&plan, |flight| {
                let look = |farm: &Farm, frame: u32, camera: &Camera| {
                    let NumberedCamera { number, camera: ref ahead, sky } = planned[frame as usize];
                    let seconds = rate.seconds_at(number);
                    plan.tell(LiveFrame { frame, seconds, camera: ahead.clone(), sky })?;
                    let pages = flight.begin(frame);
                    self.look(&self.renderer.under(sky).over(&pages), number, camera, farm)
                };

                let end = all(&Flying { look: &look, deliver: &|frame| flight.deliver(frame) });
                (numbers.zip(flight.frames()).collect(), end)
            })
        } else {
            let plan = FlightPlan::new(self.renderer, self.farm, planned);
            let plan = if self.product == Product::Picture { plan.of_pictures() } else { plan };
            self.pages.ahead_of(cameras.len() as u32, &plan, |flight| {
                let look = |farm: &Farm, frame: u32, camera: &Camera| {
                    flight.begin(frame);
                    let NumberedCamera { number, sky, .. } = cameras[frame as usize];
                    self.look(&self.renderer.under(sky), number, camera, farm)
                };
                let end = all(&Flying { look: &look, deliver: &|frame| flight.deliver(frame) });
                (numbers.zip(flight.frames()).collect(), end)
            })
        };

        flown.unwrap_or_else(|error| (Vec::new(), Err(error)))
    }

    /// Renders what was asked of a frame.
    fn look(
        &self,
        renderer: &Renderer<'_>,
        number: u64,
        camera: &Camera,
        farm: &Farm,
    ) -> Result<(Image, Rays)> {
        let renderer = &renderer.moving(self.motion.eye_velocity(number).unwrap_or_default());
        if let Some(finishing) = self.finishing {
            return self.finished(renderer, number, camera, finishing, farm);
        }
        let scenery = self.playing.map(|playing| playing.scenery(number)).unwrap_or_default();
        let renderer = renderer.at(self.playing.map_or(0.0, |playing| playing.seconds(number)));
        Ok(match self.product {
            Product::Picture => {
                let (picture, account) = renderer.picture_with(camera, &scenery, farm)?;
                (Image::Picture(picture, Box::new(camera.clone())), account.rays)
            }
            Product::Frame => {
                let Rendered { mut frame, account } = renderer.frame_with(camera, &scenery, farm)?;
                self.aov_inputs.complete(&mut frame, number, self.playing, &scenery.bodies, farm)?;
                (Image::Frame(Box::new(frame)), account.rays)
            }
        })
    }

    /// Renders what was asked of a frame, and finishes it.
    fn finished(
        &self,
        renderer: &Renderer<'_>,
        number: u64,
        camera: &Camera,
        finishing: &Finishing<'_>,
        farm: &Farm,
    ) -> Result<(Image, Rays)> {
        let plain = || Sequence { finishing: None, ..*self }.look(renderer, number, camera, farm);
        match self.product {
            Product::Picture => {
                let finished = finishing.picture(renderer, number, camera, self.playing, farm)?;
                let (mut picture, rays) = match finished {
                    Some((picture, account)) => (picture, account.rays),
                    None => match plain()? {
                        (Image::Picture(picture, _), rays) => (picture, rays),
                        frame => return Ok(frame),
                    },
                };

                if let Some(titles) = &finishing.titles {
                    // A frame that never waits has the ground from the file, as its path had.
                    let ground: &dyn PageSource =
                        if self.live.is_some() { self.pages.file() } else { self.pages };
                    titles.draw(ground, number, camera, &mut picture)?;
                }

                Ok((Image::Picture(picture, Box::new(camera.clone())), rays))
            }
            Product::Frame => match finishing.frame(renderer, number, camera, self.playing, farm)? {
                Some(Rendered { mut frame, account }) => {
                    let scenery = self.playing.map(|playing| playing.scenery(number)).unwrap_or_default();
                    self.aov_inputs.complete(&mut frame, number, self.playing, &scenery.bodies, farm)?;
                    Ok((Image::Frame(Box::new(frame)), account.rays))
                }
                None => plain(),
            },
        }
    }

    fn render_all(
        &self,
        cameras: &[NumberedCamera],
        flying: &Flying<'_>,
        sender: Sender<Shot>,
        failed: &AtomicBool,
        deliveries: &mut Vec<Delivery>,
        observer: &dyn Observer,
    ) -> Result<()> {
        let frames: Vec<_> =
            (0..).zip(cameras).map(|(frame, seen)| (seen.number, (frame, &seen.camera))).collect();
        let batch = Batch { frames: &frames, in_flight: self.in_flight, observer };
        let render = |farm: &Farm, &(frame, camera): &(u32, &Camera)| (flying.look)(farm, frame, camera);
        let mut live = Live::new(self.pages.paging());
        let now = || (Instant::now(), cpu_time::of_process());
        let mut before = now();

        self.farm.fly(&batch, render, |number, (image, rays)| {
            (flying.deliver)(deliveries.len() as u32);
            let (wall, cpu) = now();
            let cpu_since = cpu.zip(before.1).map(|(cpu, before)| cpu.saturating_sub(before));
            let delivery = Delivery { number, rays, wall: wall - before.0, cpu: cpu_since };
            before = (wall, cpu);
            deliveries.push(delivery);
            if self.stats
                && let Some(text) = live.deliver(number, || self.pages.paging())
            {
                observer.note(&text);
            }

            // What the encoder that failed says replaces this.
            let stopped = || Error::Interrupted("no frame can be written".into());
            if failed.load(Ordering::Relaxed) {
                return Err(stopped());
            }

            sender.send(Shot { image, delivery }).map_err(|_| stopped())
        })
    }

    /// Hands frames to `sink` as they come; the numbers of those that it took.
    fn encode(
        &self,
        shots: Receiver<Shot>,
        sink: &(dyn Fn(&Shot) -> Result<()> + Sync),
        failed: &AtomicBool,
        observer: &dyn Observer,
    ) -> (Vec<u64>, Result<()>) {
        let mut finished = Vec::new();
        for shot in shots {
            if let Err(error) = sink(&shot) {
                failed.store(true, Ordering::Relaxed);
                return (finished, Err(error));
            }
            if let Image::Picture(picture, _) = shot.image {
                self.renderer.recycle(picture);
            }
            finished.push(shot.delivery.number);
            observer.advance(1);
        }
        (finished, Ok(()))
    }
}
