//! Colours: a table of materials and eight brightnesses of each.
//!
//! Few distinct colours with fine grain between neighbours compress to about a byte a pixel, where noise added
//! to each channel would need three; mixtures are dithered between materials.

/// Material that a pixel of the picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub enum Material {
    Pasture,
    PastureDry,
    PastureLush,
    Meadow,
    Wheat,
    Barley,
    Rape,
    Maize,
    Beet,
    Soil,
    Stubble,
    Hay,
    Hedge,
    BroadLight,
    BroadMid,
    BroadDark,
    Conifer,
    ConiferBlue,
    ForestFloor,
    RockPale,
    RockMid,
    RockDark,
    Scree,
    AlpGreen,
    AlpBrown,
    Heath,
    Snow,
    SnowShade,
    WaterDeep,
    WaterShallow,
    Gravel,
    Asphalt,
    Track,
    RoofTile,
    RoofTileDark,
    RoofSlate,
    RoofWood,
    RoofMetal,
    Yard,
    Garden,
    Wall,
}

/// sRGB of each material at middle brightness, in the order of [`Material`].
const TABLE: [[f64; 3]; 41] = [
    [106.0, 122.0, 66.0],
    [130.0, 134.0, 80.0],
    [92.0, 114.0, 60.0],
    [134.0, 142.0, 80.0],
    [194.0, 170.0, 108.0],
    [182.0, 170.0, 112.0],
    [186.0, 176.0, 78.0],
    [86.0, 108.0, 56.0],
    [100.0, 116.0, 72.0],
    [124.0, 98.0, 74.0],
    [176.0, 156.0, 110.0],
    [156.0, 152.0, 92.0],
    [58.0, 80.0, 40.0],
    [86.0, 106.0, 48.0],
    [70.0, 92.0, 42.0],
    [56.0, 78.0, 38.0],
    [40.0, 60.0, 40.0],
    [48.0, 68.0, 50.0],
    [74.0, 76.0, 46.0],
    [158.0, 152.0, 140.0],
    [132.0, 127.0, 118.0],
    [104.0, 101.0, 97.0],
    [160.0, 153.0, 139.0],
    [112.0, 120.0, 68.0],
    [132.0, 122.0, 78.0],
    [106.0, 98.0, 66.0],
    [238.0, 241.0, 246.0],
    [214.0, 221.0, 232.0],
    [48.0, 76.0, 82.0],
    [72.0, 98.0, 92.0],
    [172.0, 164.0, 146.0],
    [108.0, 106.0, 104.0],
    [164.0, 146.0, 112.0],
    [166.0, 92.0, 64.0],
    [136.0, 74.0, 56.0],
    [96.0, 98.0, 106.0],
    [116.0, 92.0, 74.0],
    [150.0, 156.0, 160.0],
    [160.0, 152.0, 134.0],
    [92.0, 116.0, 58.0],
    [196.0, 186.0, 168.0],
];

/// Brightnesses of a material.
const SHADES: f64 = 8.0;

/// sRGB of a material; `shade` −1 (dark) … 1 (bright), held to one of eight.
pub fn colour(material: Material, shade: f64) -> [u8; 3] {
    let level = ((shade.clamp(-1.0, 1.0) + 1.0) / 2.0 * (SHADES - 1.0)).round() / (SHADES - 1.0);
    let factor = 0.70 + 0.60 * level;
    // Shadow is lit by the sky: it turns a little to blue, and light to yellow.
    let tint = [factor + 0.02 * (level - 0.5), factor, factor - 0.06 * (level - 0.5)];
    let base = TABLE[material as usize];
    std::array::from_fn(|channel| (base[channel] * tint[channel]).round().clamp(0.0, 255.0) as u8)
}
