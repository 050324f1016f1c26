//! Layers: small transparent pictures that are laid over a finished one.

use glam::DVec2;
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform,
};

use crate::text::TextBlock;
use hedgehop::frame::Picture;

/// Halos of text, the widest first: its width, in sizes of the letters, and its opacity.
const HALOS: [[f32; 2]; 3] = [[0.28, 0.14], [0.19, 0.2], [0.1, 0.4]];

/// Colour with its opacity: 8-bit sRGB, and 0…1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ink {
    /// Colour.
    pub colour: [u8; 3],
    /// Opacity, 0…1.
    pub opacity: f32,
}

impl Ink {
    /// A colour that hides what is below it.
    pub const fn solid(colour: [u8; 3]) -> Self {
        Self { colour, opacity: 1.0 }
    }

    /// Returns the same colour with less opacity.
    pub const fn faint(self, opacity: f32) -> Self {
        Self { opacity, ..self }
    }

    fn paint(self) -> Paint<'static> {
        let mut paint = Paint { anti_alias: true, ..Paint::default() };
        let [red, green, blue] = self.colour;
        let opacity = (self.opacity.clamp(0.0, 1.0) * 255.0).round() as u8;
        paint.set_color(Color::from_rgba8(red, green, blue, opacity));
        paint
    }
}

/// A transparent picture at a place of the finished one, pixels.
#[derive(Debug, Clone)]
pub struct Layer {
    pixmap: Pixmap,
    left: i32,
    top: i32,
}

impl Layer {
    /// An empty layer with a corner at a place, as large as it is told; `None`: it has no pixel.
    pub fn new(corner: DVec2, size: DVec2) -> Option<Self> {
        let size = size.ceil();
        let is_sound = size.min_element() >= 1.0 && size.max_element() <= 20_000.0 && corner.is_finite();
        if !is_sound {
            return None;
        }
        let pixmap = Pixmap::new(size.x as u32, size.y as u32)?;
        Some(Self { pixmap, left: corner.x.floor() as i32, top: corner.y.floor() as i32 })
    }

    /// Moves places of the finished picture to the layer's own.
    fn own(&self) -> Transform {
        Transform::from_translate(-self.left as f32, -self.top as f32)
    }

    /// Fills an outline.
    pub fn fill(&mut self, path: &Path, ink: Ink) {
        let own = self.own();
        self.pixmap.fill_path(path, &ink.paint(), FillRule::Winding, own, None);
    }

    /// Draws a line along a path, of a width in pixels.
    pub fn stroke(&mut self, path: &Path, width: f64, ink: Ink) {
        let own = self.own();
        let stroke = Stroke {
            width: width as f32,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        self.pixmap.stroke_path(path, &ink.paint(), &stroke, own, None);
    }

    /// Draws text with its upper left corner at a place, and a dark halo around it that sets it off from anything.
    pub fn text(&mut self, block: &TextBlock, corner: DVec2, ink: Ink) {
        self.text_in_halo(block, corner, ink, 1.0);
    }

    /// Draws text, its halo narrower by a factor: large letters need less of one.
    pub fn text_in_halo(&mut self, block: &TextBlock, corner: DVec2, ink: Ink, narrower: f32) {
        let Some(outline) = &block.outline else { return };
        let there = Transform::from_translate(corner.x as f32, corner.y as f32);
        let Some(outline) = outline.clone().transform(there) else { return };
        for [width, opacity] in HALOS {
            let halo = Ink::solid([0; 3]).faint(opacity * ink.opacity);
            self.stroke(&outline, f64::from(narrower * width * block.size), halo);
        }
        self.fill(&outline, ink);
    }

    /// Sets pixels, by their place in the finished picture.
    pub fn shade(&mut self, colour_at: impl Fn(DVec2) -> Option<[u8; 3]>) {
        let (left, top, width) = (f64::from(self.left), f64::from(self.top), self.pixmap.width() as usize);
        for (index, pixel) in self.pixmap.pixels_mut().iter_mut().enumerate() {
            let place = DVec2::new(left + (index % width) as f64 + 0.5, top + (index / width) as f64 + 0.5);
            if let Some([red, green, blue]) = colour_at(place) {
                *pixel = tiny_skia::ColorU8::from_rgba(red, green, blue, 255).premultiply();
            }
        }
    }

    /// Lays the layer over a picture, with an opacity of 0…1; nothing beside the picture.
    pub fn blend(&self, picture: &mut Picture, opacity: f64) {
        let share = (opacity.clamp(0.0, 1.0) * 255.0).round() as u32;
        let (width, height) = (i64::from(picture.width), i64::from(picture.height));
        let across = i64::from(self.pixmap.width());
        for row in 0..i64::from(self.pixmap.height()) {
            let y = row + i64::from(self.top);
            if share == 0 || !(0..height).contains(&y) {
                continue;
            }

            // The columns of the layer that lie in the picture.
            let [from, to] =
                [-i64::from(self.left), width - i64::from(self.left)].map(|column| column.clamp(0, across));
            let pixels = &self.pixmap.pixels()[(row * across + from) as usize..(row * across + to) as usize];
            let first = (3 * (y * width + i64::from(self.left) + from)) as usize;
            for (pixel, codes) in pixels.iter().zip(picture.rgb[first..].chunks_exact_mut(3)) {
                if pixel.alpha() == 0 {
                    continue;
                }
                let below = 255 * 255 - u32::from(pixel.alpha()) * share;
                let own = [pixel.red(), pixel.green(), pixel.blue()];
                for (code, own) in codes.iter_mut().zip(own) {
                    let mixed = u32::from(own) * share * 255 + u32::from(*code) * below;
                    *code = ((mixed + 255 * 255 / 2) / (255 * 255)) as u8;
                }
            }
        }
    }
}

/// A line through places.
pub fn polyline(places: impl IntoIterator<Item = DVec2>) -> Option<Path> {
    through(places).finish()
}

/// The area that places enclose.
pub fn polygon(places: impl IntoIterator<Item = DVec2>) -> Option<Path> {
    let mut builder = through(places);
    builder.close();
    builder.finish()
}

/// Begins a path with straight lines through places.
fn through(places: impl IntoIterator<Item = DVec2>) -> PathBuilder {
    let mut builder = PathBuilder::new();
    for place in places {
        if builder.is_empty() {
            builder.move_to(place.x as f32, place.y as f32);
        } else {
            builder.line_to(place.x as f32, place.y as f32);
        }
    }
    builder
}

/// A disc about a place.
pub fn disc(middle: DVec2, radius: f64) -> Option<Path> {
    PathBuilder::from_circle(middle.x as f32, middle.y as f32, radius as f32)
}

/// A rectangle from one corner to another.
pub fn rectangle(corner: DVec2, size: DVec2) -> Option<Path> {
    Rect::from_xywh(corner.x as f32, corner.y as f32, size.x as f32, size.y as f32)
        .map(PathBuilder::from_rect)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey() -> Picture {
        Picture { width: 20, height: 10, rgb: vec![100; 600] }
    }

    fn red_square(corner: DVec2) -> Layer {
        let mut layer = Layer::new(corner, DVec2::splat(6.0)).unwrap();
        layer.fill(&rectangle(corner, DVec2::splat(6.0)).unwrap(), Ink::solid([250, 0, 0]));
        layer
    }

    #[test]
    fn layers_lie_where_they_belong_and_never_beside_the_picture() {
        for (corner, pixels) in
            [([3.0, 2.0], 36), ([-2.0, -3.0], 12), ([18.0, 8.0], 4), ([20.0, 3.0], 0), ([-60.0, 99.0], 0)]
        {
            let mut picture = grey();
            red_square(DVec2::from(corner)).blend(&mut picture, 1.0);
            let red = picture.rgb.chunks(3).filter(|codes| *codes == [250, 0, 0]).count();
            let kept = picture.rgb.chunks(3).filter(|codes| *codes == [100; 3]).count();
            assert_eq!((red, red + kept), (pixels, 200), "{corner:?}");
        }
    }

    #[test]
    fn opacity_mixes_codes() {
        let mut picture = grey();
        red_square(DVec2::new(3.0, 2.0)).blend(&mut picture, 0.5);
        let at = 3 * (4 * 20 + 5);
        assert_eq!(picture.rgb[at..at + 3], [175, 50, 50]);
        let mut picture = grey();
        red_square(DVec2::new(3.0, 2.0)).blend(&mut picture, 0.0);
        assert_eq!(picture, grey());
    }

    #[test]
    fn layers_without_pixels_are_none() {
        assert!(Layer::new(DVec2::ZERO, DVec2::new(0.0, 5.0)).is_none());
        assert!(Layer::new(DVec2::NAN, DVec2::ONE).is_none());
        assert!(polyline([]).is_none() && disc(DVec2::ZERO, -1.0).is_none());
    }
}
