//! Mattes in EXR files.

use super::super::{exr, testing};
use super::*;

fn cover(pixel: u32, id: u32, share: f32) -> MatteCoverage {
    MatteCoverage { pixel, id, share }
}

fn plane<'c>(channels: &'c [(String, Vec<f32>)], name: &str) -> &'c [f32] {
    &channels.iter().find(|(known, _)| known == name).unwrap().1
}

#[test]
fn hashes_are_those_of_the_reference() {
    for (text, hash) in [
        ("", 0),
        ("test", 0xba6b_d213),
        ("Hello, world!", 0xc036_3e43),
        ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
    ] {
        assert_eq!(murmur3(text.as_bytes()), hash, "{text}");
    }
}

/// Values that Psyop's own tests of its Nuke tools hold.
#[test]
fn ids_are_those_of_other_programs() {
    for (name, value) in [
        ("hello", 6.070_562_710_24e-17),
        ("cube", -4.084_619_125_19e15),
        ("sphere", 2.790_186_043_83e15),
        ("plane", 3.665_576_175_93e-11),
    ] {
        let own = f64::from(id(name));
        assert!((own / value - 1.0).abs() < 1e-9, "{name}: {own}");
    }
    for number in 0..200_000 {
        let id = id(&format!("object {number}"));
        assert!(id.is_normal(), "{number}: {id}");
    }
}

#[test]
fn ranks_hold_the_largest_shares_and_the_ground_what_is_left() {
    let frame = testing::frame(6, 3);
    let mut matte = Matte { names: vec!["car".into(), "mast".into()], covers: Vec::new() };
    matte.covers =
        vec![cover(7, 1, 0.5), cover(7, MatteCoverage::GROUND, 0.375), cover(7, 0, 0.125), cover(13, 1, 1.0)];
    let channels = matte.channels(&frame);
    assert_eq!(channels.len(), 12);
    let [first, second] = ["CryptoObject00", "CryptoObject01"]
        .map(|layer| ["R", "G", "B", "A"].map(|part| plane(&channels, &format!("{layer}.{part}"))));
    // The first third is sky.
    assert_eq!(first.map(|plane| plane[5]), [0.0; 4]);
    assert_eq!(first.map(|plane| plane[6]), [id("ground"), 1.0, 0.0, 0.0]);
    assert_eq!(first.map(|plane| plane[7]), [id("mast"), 0.5, id("ground"), 0.375]);
    assert_eq!(second.map(|plane| plane[7]), [id("car"), 0.125, 0.0, 0.0]);
    assert_eq!(first.map(|plane| plane[13]), [id("mast"), 1.0, 0.0, 0.0]);
    for pixel in 6..18 {
        let sum: f32 = channels.iter().skip(1).step_by(2).map(|(_, plane)| plane[pixel]).sum();
        assert_eq!(sum, 1.0, "pixel {pixel}");
    }
}

#[test]
fn bodies_of_one_name_are_one_thing() {
    let frame = testing::frame(6, 3);
    let names = ["heli", "mast", "heli", "heli"].map(str::to_owned).to_vec();
    let covers = vec![
        cover(7, 1, 0.375),
        cover(7, MatteCoverage::GROUND, 0.25),
        cover(7, 0, 0.125),
        cover(7, 3, 0.125),
        cover(7, 2, 0.125),
        cover(8, 2, 0.5),
        cover(8, MatteCoverage::GROUND, 0.5),
    ];
    let channels = Matte { names, covers }.channels(&frame);
    let at = |pixel: usize| {
        ["0.R", "0.G", "0.B", "0.A", "1.R", "1.G", "1.B", "1.A"]
            .map(|part| plane(&channels, &format!("CryptoObject0{part}"))[pixel])
    };
    assert_eq!(at(7), [id("mast"), 0.375, id("heli"), 0.375, id("ground"), 0.25, 0.0, 0.0]);
    assert_eq!(at(8), [id("heli"), 0.5, id("ground"), 0.5, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn more_bodies_than_ranks_leave_the_smallest_out() {
    let frame = testing::frame(6, 3);
    let covers = (0..9).map(|id| cover(8, id, (9 - id) as f32 / 45.0)).collect();
    let channels = Matte { names: Vec::new(), covers }.channels(&frame);
    assert_eq!(plane(&channels, "CryptoObject02.B")[8], id("object 5"));
    assert_eq!(plane(&channels, "CryptoObject02.A")[8], 4.0 / 45.0);
}

#[test]
fn the_manifest_tells_ids_of_all_names() {
    let names = ["Küste \"A\"", "ground", "mast"].map(str::to_owned).to_vec();
    let matte = Matte { names: names.clone(), covers: Vec::new() };
    let [name, hash, conversion, manifest] = matte.attributes();
    // The first digits of the hash of the layer's name.
    assert_eq!(name.0, format!("cryptomatte/{}/name", &format!("{:08x}", murmur3(b"CryptoObject"))[..7]));
    assert_eq!((name.1.as_str(), hash.1.as_str()), ("CryptoObject", "MurmurHash3_32"));
    assert_eq!(conversion.1, "uint32_to_float32");
    let manifest: serde_json::Value = serde_json::from_str(&manifest.1).unwrap();
    assert_eq!(manifest.as_object().unwrap().len(), 4);
    for name in names.iter().map(String::as_str).chain(["ground_"]) {
        let bits = u32::from_str_radix(manifest[name].as_str().unwrap(), 16).unwrap();
        assert_eq!(f32::from_bits(bits), id(name), "{name}");
    }
    // An object that is called like the ground is not it.
    let channels = matte.channels(&testing::frame(6, 3));
    assert_eq!(plane(&channels, "CryptoObject00.R")[17], id("ground_"));
}

fn exr_of(frame: &Frame) -> Vec<u8> {
    crate::encode::encode_frame("a.exr".as_ref(), frame, &testing::info()).unwrap()
}

#[test]
fn many_names_fit_into_a_header() {
    let mut frame = testing::frame(6, 3);
    let names = (0..5_000).map(|number| format!("object with a long name {number}")).collect();
    frame.aov.matte = Some(Matte { names, covers: Vec::new() });
    assert!(exr::decode(&exr_of(&frame), None).is_ok());
}
