//! EXR files read back, whole and damaged.

use std::io::Cursor;

use ::exr::image::read::read;
use ::exr::prelude::{FlatSamples, ReadChannels, ReadLayers, f16};
use glam::DVec3;

use super::channels::within_half;
use super::*;
use crate::encode::testing;
use crate::frame::{Aov, MapPositions, MatteCoverage};
use hedgehop_base::Size;
use hedgehop_base::colour::linear_from_srgb8;

fn encoded(frame: &Frame) -> Vec<u8> {
    encode(Path::new("a.exr"), frame, &testing::info(), &Farm::new(1).unwrap()).unwrap()
}

fn flat(bytes: &[u8]) -> Layer<Channels> {
    let read = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    read.all_attributes().non_parallel().from_buffered(Cursor::new(bytes)).unwrap().layer_data
}

fn plane(layer: &Layer<Channels>, name: &str) -> FlatSamples {
    layer.channel_data.list.iter().find(|channel| &channel.name == name).unwrap().sample_data.clone()
}

#[test]
fn planes_come_back() {
    let frame = testing::frame(37, 40);
    let layer = flat(&encoded(&frame));
    let names: Vec<_> = layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "id", "level", "range"]);
    assert_eq!(plane(&layer, "range"), FlatSamples::F32(frame.range.clone()));
    assert_eq!(plane(&layer, "id"), FlatSamples::U32(frame.id.clone()));
    let levels = frame.level.iter().map(|&level| u32::from(level)).collect();
    assert_eq!(plane(&layer, "level"), FlatSamples::U32(levels));
    let greens = frame.colour.iter().map(|pixel| f16::from_f32(pixel[1])).collect();
    assert_eq!(plane(&layer, "G"), FlatSamples::F16(greens));
    let up = frame.normal.iter().map(|normal| f16::from_f32(normal[2])).collect();
    assert_eq!(plane(&layer, "N.Z"), FlatSamples::F16(up));
    assert_eq!(plane(&layer, "A"), FlatSamples::F16(vec![f16::ONE; frame.colour.len()]));
}

/// Z of a pixel is the forward coordinate of the point at its range, found the other way round:
/// through the matrix in the header.
#[test]
fn z_is_planar_and_the_matrix_maps_to_the_camera() {
    let mut frame = testing::frame(16, 12);
    let mut pose = frame.camera.pose;
    pose.eye = DVec3::new(120.0, -45.0, 310.0);
    frame.camera = Camera::new(pose, 16, 12);
    let layer = flat(&encoded(&frame));
    let FlatSamples::F32(depth) = plane(&layer, "Z") else { panic!("Z is float") };
    let matrix = layer.attributes.world_to_camera.unwrap();

    for row in 4..12 {
        for column in 0..16 {
            let at = row * 16 + column;
            let direction = frame.camera.direction(column as f64 + 0.5, row as f64 + 0.5);
            let point = pose.eye + direction * f64::from(frame.range[at]);
            let homogeneous = [point.x, point.y, point.z, 1.0];
            let view: Vec<f64> = (0..4)
                .map(|to| (0..4).map(|from| homogeneous[from] * f64::from(matrix[from * 4 + to])).sum())
                .collect();
            let screen = (
                8.0 + view[0] / view[2] * frame.camera.focal_px(),
                6.0 - view[1] / view[2] * frame.camera.focal_px(),
            );
            assert!((f64::from(depth[at]) / view[2] - 1.0).abs() < 1e-5, "{} {}", depth[at], view[2]);
            assert!((screen.0 - column as f64 - 0.5).abs() < 1e-3, "{screen:?} {column}");
            assert!((screen.1 - row as f64 - 0.5).abs() < 1e-3, "{screen:?} {row}");
            assert_eq!(view[3], 1.0);
        }
    }

    assert_eq!(depth[0], f32::INFINITY, "the sky");
}

#[test]
fn around_the_eye_z_is_range_and_nothing_is_transparent_beyond_the_picture() {
    let mut frame = testing::frame(16, 12);
    frame.camera = Camera::with_screen(frame.camera.pose, Screen::Fisheye { fov: 180.0 }, 16, 12);
    let layer = flat(&encoded(&frame));
    assert_eq!(plane(&layer, "Z"), FlatSamples::F32(frame.range.clone()));
    let FlatSamples::F16(alpha) = plane(&layer, "A") else { panic!("A is half") };
    assert_eq!((alpha[0], alpha[6 * 16 + 8]), (f16::ZERO, f16::ONE));
    let attributes = &layer.attributes;
    assert_eq!(attributes.horizontal_field_of_view, None);
    let decoded = decode(&encoded(&frame), None).unwrap();
    assert_eq!(decoded.entries["hedgehop.screen"], "fisheye fov_deg=180");
    assert!(!decoded.entries.contains_key("hedgehop.hfov_deg"));
}

#[test]
fn attributes_say_what_made_the_frame() {
    let frame = testing::frame(16, 9);
    let bytes = encoded(&frame);
    let layer = flat(&bytes);
    let attributes = &layer.attributes;
    let other = |name: &str| attributes.other[&text(name)].clone();
    assert_eq!(other("hedgehop.yaw_deg"), AttributeValue::F64(33.0));
    assert_eq!(other("hedgehop.hfov_deg"), AttributeValue::F64(60.0));
    let decoded = decode(&bytes, None).unwrap();
    assert_eq!(decoded.entries["hedgehop.eye_m"], "500123.456789 4649776.225 312.75");
    assert_eq!(decoded.entries["hedgehop.database_file"], "Küste.hop");
    assert_eq!(attributes.software_name.as_ref().unwrap(), "hedgehop 0.1.0");
    assert_eq!(attributes.horizontal_field_of_view, Some(60.0));
    let width = 2.0 * 30.0_f64.to_radians().tan();
    assert!((f64::from(attributes.screen_window_width) - width).abs() < 1e-6);
    assert!(attributes.layer_name.is_none(), "the colour is the default layer");
}

#[test]
fn equal_frames_are_equal_bytes_and_attributes_are_sorted() {
    let first = encoded(&testing::frame(40, 33));
    for _ in 0..4 {
        assert_eq!(first, encoded(&testing::frame(40, 33)));
    }
}

#[test]
fn any_number_of_workers_makes_the_same_bytes() {
    let frame = testing::frame(40, 67);
    let alone = encoded(&frame);
    for workers in [2, 3, 5] {
        let farm = Farm::new(workers).unwrap();
        let together = encode(Path::new("a.exr"), &frame, &testing::info(), &farm).unwrap();
        assert!(together == alone, "{workers} workers");
    }
}

/// Kind of samples that the pixels of a test have.
#[derive(Debug, Clone, Copy)]
enum Content {
    /// The frame of other tests.
    Slope,
    /// One value.
    Constant,
    /// Bits that do not compress, no numbers among them.
    Noise,
    /// Infinite numbers and no numbers, in turn.
    NoNumbers,
}

fn frame_of(content: Content, width: u32, height: u32) -> Frame {
    let mut frame = testing::frame(width, height);
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state ^ state >> 15
    };
    for pixel in 0..frame.id.len() {
        let floats: [f32; 3] = match content {
            Content::Slope => continue,
            Content::Constant => [0.25; 3],
            Content::Noise => [(); 3].map(|()| f32::from_bits(noise())),
            Content::NoNumbers => [f32::INFINITY, f32::NAN, f32::NEG_INFINITY],
        };
        let id = if matches!(content, Content::Noise) { noise() } else { 7 };
        (frame.colour[pixel], frame.normal[pixel]) = (floats, floats.map(|float| -float));
        (frame.range[pixel], frame.id[pixel], frame.level[pixel]) = (floats[pixel % 3], id, id as u8);
    }
    frame
}

#[test]
fn pictures_of_any_size_and_content_come_back() {
    use Content::{Constant, NoNumbers, Noise, Slope};
    let sizes =
        [(1, 1), (1, 2), (2, 1), (7, 15), (5, 16), (3, 17), (33, 31), (64, 49), (9000, 2), (35_000, 1)];
    for (width, height) in sizes {
        for content in [Slope, Constant, Noise, NoNumbers] {
            let frame = frame_of(content, width, height);
            let (case, bytes) = (format!("{content:?} of {width}×{height}"), encoded(&frame));
            let layer = flat(&bytes);
            let halves = |plane: FlatSamples| match plane {
                FlatSamples::F16(samples) => samples.into_iter().map(f16::to_bits).collect::<Vec<_>>(),
                _ => panic!("{case}: halves"),
            };
            let FlatSamples::F32(range) = plane(&layer, "range") else { panic!("{case}: range is float") };
            assert!(
                range.iter().zip(&frame.range).all(|(found, put)| found.to_bits() == put.to_bits()),
                "{case}"
            );
            assert!(plane(&layer, "id") == FlatSamples::U32(frame.id.clone()), "{case}");
            let levels = frame.level.iter().map(|&level| u32::from(level)).collect();
            assert!(plane(&layer, "level") == FlatSamples::U32(levels), "{case}");
            for (part, (colour, normal)) in [("R", "N.X"), ("G", "N.Y"), ("B", "N.Z")].into_iter().enumerate()
            {
                let bits = |value: f32| f16::from_f32(value).to_bits();
                let colours: Vec<_> =
                    frame.colour.iter().map(|pixel| bits(within_half(pixel[part]))).collect();
                assert!(halves(plane(&layer, colour)) == colours, "{case}: {colour}");
                let normals: Vec<_> = frame.normal.iter().map(|pixel| bits(pixel[part])).collect();
                assert!(halves(plane(&layer, normal)) == normals, "{case}: {normal}");
            }
            // The digest counts every bit.
            assert!(decode(&bytes, Some(Size { width, height })).is_ok(), "{case}");
        }
    }
}

#[test]
fn chunks_that_do_not_shrink_are_stored_as_they_are() {
    let noise: Vec<u32> = (1..=64 * 20_u32)
        .map(|at| at.wrapping_mul(2_654_435_761).reverse_bits().wrapping_mul(at | 1))
        .collect();
    let named = |name: &str, plane: Vec<u32>| ::exr::prelude::AnyChannel::new(name, FlatSamples::U32(plane));
    let mut zip = Zip::default();
    // Whatever was compressed before leaves no trace.
    for _ in 0..2 {
        let alone = by_name(vec![named("noise", noise.clone())]);
        let raw: Vec<u8> = noise[64 * 16..].iter().flat_map(|sample| sample.to_le_bytes()).collect();
        assert!(zip.compress(&alone, 64, 16..20) == raw);
        let even = by_name(vec![named("even", vec![5; 64 * 20])]);
        assert!(zip.compress(&even, 64, 0..16).len() < 1000);
    }
}

#[test]
fn colours_beyond_half_are_clipped() {
    let half = |radiance: f32| f16::from_f32(within_half(radiance));
    assert_eq!(half(1e9), f16::MAX);
    assert_eq!(half(f32::INFINITY), f16::MAX);
    assert_eq!(half(0.5), f16::from_f32(0.5));
}

#[test]
fn colour_is_found_again() {
    let frame = testing::frame(8, 8);
    let colour = decode(&encoded(&frame), Some(Size { width: 8, height: 8 })).unwrap().colour().unwrap();
    assert!((colour[20][1] - frame.colour[20][1]).abs() < 1e-3);
    assert!(decode(&encoded(&frame), Some(Size { width: 8, height: 9 })).is_err());
}

#[test]
fn further_channels_are_those_of_the_frame() {
    let mut frame = testing::frame(6, 3);
    let plain = encoded(&frame);
    let cover = |id: u32, share: f32| MatteCoverage { pixel: 7, id, share };
    let covers = vec![cover(1, 0.75), cover(MatteCoverage::GROUND, 0.25)];
    let matte = Matte { names: vec!["Küste".into(), "mast".into()], covers };
    frame.aov = Aov {
        matte: Some(matte.clone()),
        motion: Some((0..18).map(|pixel| [pixel as f32, -0.5 * pixel as f32]).collect()),
        position: Some(MapPositions {
            offset: DVec3::new(500_000.0, 4_649_000.0, 0.0),
            points: (0..18).map(|pixel| [pixel as f32, 0.25, f32::INFINITY]).collect(),
        }),
        synthesis: Some((0..18).map(|pixel| 0.125 * pixel as f32 - 1.0).collect()),
        material: true,
    };

    let bytes = encoded(&frame);
    let read = decode(&bytes, None).map_err(|what| what.to_string()).unwrap();
    let channel = |name: &str| match read.channel(name) {
        Some(FlatSamples::F32(samples)) => samples.clone(),
        other => panic!("{name}: {other:?}"),
    };
    for (name, samples) in matte.channels(&frame) {
        assert!(channel(&name) == samples, "{name}");
    }
    for (name, value) in matte.attributes() {
        let text =
            [name.as_bytes(), b"\0string\0", &(value.len() as u32).to_le_bytes(), value.as_bytes()].concat();
        assert!(bytes.windows(text.len()).any(|part| part == text), "{name}");
    }

    assert_eq!((channel("forward.u")[5], channel("forward.v")[5]), (5.0, -2.5));
    assert_eq!(channel("synthesis")[5], -0.375);
    assert_eq!(["P.X", "P.Y", "P.Z"].map(|name| channel(name)[5]), [5.0, 0.25, f32::INFINITY]);
    assert_eq!(read.entries["hedgehop.position_offset_m"], "500000 4649000 0");

    for (part, name) in ["material.R", "material.G", "material.B"].into_iter().enumerate() {
        let mark =
            |id: &u32| Frame::material_of(*id).map(|material| linear_from_srgb8(material.mark())[part]);
        let marks: Vec<f32> = frame.id.iter().map(|id| mark(id).unwrap_or_default()).collect();
        assert_eq!(channel(name), marks, "{name}");
    }

    // Without them a file has no trace of them.
    frame.aov = Aov::default();
    assert!(encoded(&frame) == plain && bytes != plain);
}
