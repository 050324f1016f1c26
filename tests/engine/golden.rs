//! Golden pictures: ten views whose pictures are kept, and must stay as they are until somebody means to change them.
//!
//! A picture is compared with its file in `golden/` for each instruction set of the machine. Sets and libraries of
//! mathematics differ in last bits, so that a picture may be off by [`most_mean`] and [`MOST_FAR`]. Files are made with
//! the portable set. AVX2 differs from them by 0.0002 codes in the mean at the most, in two pixels of `objects` by 2 and 4
//! codes, elsewhere by one. Two percent of visibility make 0.07 (`night`) to 0.5 codes (`ridges`), but 0.006 in `snow`,
//! which hides more than haze; two percent of the colour of the balloon of `objects` 0.013; a black pixel among white ones
//! 0.008.
//!
//! ```text
//! cargo test -p hedgehop-tests --test engine golden                               all ten
//! HEDGEHOP_BLESS=1 cargo test -p hedgehop-tests --test engine golden::fog         what is rendered now becomes the golden picture
//! HEDGEHOP_PIXEL=120,80 cargo test -p hedgehop-tests --test engine golden::fog -- --nocapture    what both engines see there
//! ```

mod noise;
mod panels;
mod pictures;
mod worlds;

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use glam::Vec3;
use hedgehop::colour::srgb8_picture;
use hedgehop::encode::read_picture;
use hedgehop::frame::{Frame, Picture};
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::simd::Isa;
use hedgehop::subimage::Farm;

use crate::scene::ORIGIN;
use panels::Panel;
use pictures::{AMPLIFIED, Distance};

/// Mean absolute difference of codes up to which a picture is as it was. AVX-512 has rough roots of 14 bits; AVX2's, cut to
/// as many, make 0.0015 (`night`) to 0.0101 (`fog`), always by one code, since they round the codes of light otherwise.
fn most_mean(isa: Isa) -> f64 {
    if isa.name() == "avx512" { 0.02 } else { 0.01 }
}

/// Share of the pixels that may be far off.
const MOST_FAR: f64 = 0.0005;

/// Variable of the environment that makes golden pictures of those that are rendered.
const BLESS: &str = "HEDGEHOP_BLESS";

/// Variable of the environment that has a pixel replayed: `COLUMN,ROW` from the upper left.
const PIXEL: &str = "HEDGEHOP_PIXEL";

static FARM: LazyLock<Farm> = LazyLock::new(|| Farm::new(2).unwrap());

/// A test for each panel, of its name.
macro_rules! golden_pictures {
    ($($name:ident)+) => {
        $(
            #[test]
            fn $name() {
                Golden { name: stringify!($name), panel: panels::$name() }.check();
            }
        )+
    };
}

golden_pictures! { ridges village objects fog banked snow fisheye night corridor down }

/// A panel with its name.
struct Golden {
    /// Name of the test and the file.
    name: &'static str,
    /// View that is rendered.
    panel: Panel,
}

impl Golden {
    /// Holds the picture against its golden one, or does what the environment asks for.
    fn check(&self) {
        if let Ok(pixel) = std::env::var(PIXEL) {
            self.replay(&pixel);
        }
        if std::env::var_os(BLESS).is_some_and(|bless| bless == "1") {
            // Every machine has this set.
            pictures::write(&self.file(), &self.picture(Isa::PORTABLE));
        }

        let (file, name) = (self.file(), self.name);
        let bless = self.command(&format!("{BLESS}=1"));
        let expected = read_picture(&file).unwrap_or_else(|error| {
            panic!("no golden picture {name}: {error}\nTo make it, look at it and keep it:\n  {bless}")
        });
        for isa in Isa::available() {
            self.compare(isa, &expected, &bless);
        }
    }

    fn compare(&self, isa: Isa, expected: &Picture, bless: &str) {
        let (name, found) = (self.name, self.picture(isa));
        assert_eq!(
            [found.width, found.height],
            [expected.width, expected.height],
            "golden picture {name} has another size. If that is meant:\n  {bless}"
        );
        let distance = Distance::new(&found, expected);
        let Distance { mean, far, worst, most } = distance;
        let most_mean = most_mean(isa);
        if mean <= most_mean && far <= MOST_FAR {
            return;
        }

        let failed = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("golden-{name}.png"));
        pictures::write(&failed, &pictures::side_by_side(expected, &found));
        let [column, row] = worst;
        let replay = self.command(&format!("{PIXEL}={column},{row}"));
        panic!(
            "golden picture {name} is not as it was ({isa}): codes are off by {mean:.3} in the mean (most {most_mean}), \
             {:.2} % of the pixels by more than {} (most {} %)\n\
             expected | difference x {AMPLIFIED} | actual:\n  {}\n\
             worst is pixel {column},{row}, by {most}: expected {}, actual {}. To see what is there:\n  {replay} -- --nocapture\n\
             If the change is meant, look at the picture and keep it:\n  {bless}",
            100.0 * far,
            Distance::FAR,
            100.0 * MOST_FAR,
            failed.display(),
            pictures::hex(expected, worst),
            pictures::hex(&found, worst),
        );
    }

    /// The golden picture's file.
    fn file(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("engine/golden").join(format!("{}.png", self.name))
    }

    /// The command that runs this test alone with a variable of the environment.
    fn command(&self, variable: &str) -> String {
        format!("{variable} cargo test -p hedgehop-tests --test engine golden::{}", self.name)
    }

    fn renderer(&self, engine: Engine, isa: Isa) -> Renderer<'static> {
        let options = RenderOptions { engine, ..self.panel.options };
        let renderer = Renderer::new(self.panel.world, &options).with_isa(isa);
        renderer.at(self.panel.seconds).moving(self.panel.velocity)
    }

    fn picture(&self, isa: Isa) -> Picture {
        let renderer = self.renderer(Engine::Planes, isa);
        let camera = &self.panel.camera;
        assert_eq!(renderer.engine_for(camera).unwrap(), Engine::Planes, "{}", self.name);
        renderer.picture_with(camera, &self.panel.scenery, &FARM).unwrap().0
    }

    /// Prints what both engines see at a pixel.
    #[expect(clippy::print_stdout, reason = "it is asked for")]
    fn replay(&self, pixel: &str) {
        let camera = &self.panel.camera;
        let parsed =
            pixel.split_once(',').map(|(column, row)| [column, row].map(|at| at.trim().parse::<u32>()));
        let (column, row) = match parsed {
            Some([Ok(column), Ok(row)]) if column < camera.width && row < camera.height => (column, row),
            _ => {
                panic!("{PIXEL}={pixel} is no COLUMN,ROW of the {} x {} pixels", camera.width, camera.height)
            }
        };

        println!("golden picture {}, pixel {column},{row}", self.name);
        if let Ok(golden) = read_picture(&self.file()) {
            println!("  expected   {}", pictures::hex(&golden, [column, row]));
        }
        for isa in Isa::available() {
            println!("  {:10} {}", isa.name(), pictures::hex(&self.picture(isa), [column, row]));
        }
        let Some(ray) = camera.ray(f64::from(column) + 0.5, f64::from(row) + 0.5) else {
            println!("  the screen has no picture there");
            return;
        };

        let eye = ray.origin - ORIGIN.extend(0.0);
        println!("  ray from {eye:.3} m (from the world's south-west corner) along {:.6}", ray.direction);
        for (name, engine) in [("planes", Engine::Planes), ("rays", Engine::Reference)] {
            let renderer = self.renderer(engine, Isa::best());
            let frame = renderer.frame_with(camera, &self.panel.scenery, &FARM).unwrap().frame;
            let at = (row * camera.width + column) as usize;
            let range = f64::from(frame.range[at]);
            let seen = match frame.level[at] {
                Frame::SKY_LEVEL => "sky".to_owned(),
                level => {
                    let what = match level {
                        Frame::BODY_LEVEL => format!("body {}", frame.id[at] & !(1 << 31)),
                        level => format!("level {}", level + 1),
                    };
                    let position = eye + ray.direction * range;
                    let normal = Vec3::from(frame.normal[at]);
                    format!("{what}, range {range:.3} m, position {position:.3}, normal {normal:.4}")
                }
            };

            let light = frame.colour[at];
            let [red, green, blue] = srgb8_picture(&[light])[..] else { unreachable!("three codes a pixel") };
            println!("  {name:10} #{red:02x}{green:02x}{blue:02x}, light {:.5}, {seen}", Vec3::from(light));
        }
    }
}
