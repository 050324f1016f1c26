//! Colours by name (CSS Color Module Level 4, 2022, §6.1) or number, and how much like features differ.

/// Names and their sRGB codes.
const NAMES: &str = "aliceblue f0f8ff antiquewhite faebd7 aqua 00ffff aquamarine 7fffd4 azure f0ffff beige f5f5dc bisque ffe4c4 \
black 000000 blanchedalmond ffebcd blue 0000ff blueviolet 8a2be2 brown a52a2a burlywood deb887 cadetblue 5f9ea0 chartreuse 7fff00 \
chocolate d2691e coral ff7f50 cornflowerblue 6495ed cornsilk fff8dc crimson dc143c cyan 00ffff darkblue 00008b darkcyan 008b8b \
darkgoldenrod b8860b darkgray a9a9a9 darkgreen 006400 darkgrey a9a9a9 darkkhaki bdb76b darkmagenta 8b008b darkolivegreen 556b2f \
darkorange ff8c00 darkorchid 9932cc darkred 8b0000 darksalmon e9967a darkseagreen 8fbc8f darkslateblue 483d8b darkslategray 2f4f4f \
darkslategrey 2f4f4f darkturquoise 00ced1 darkviolet 9400d3 deeppink ff1493 deepskyblue 00bfff dimgray 696969 dimgrey 696969 \
dodgerblue 1e90ff firebrick b22222 floralwhite fffaf0 forestgreen 228b22 fuchsia ff00ff gainsboro dcdcdc ghostwhite f8f8ff gold ffd700 \
goldenrod daa520 gray 808080 green 008000 greenyellow adff2f grey 808080 honeydew f0fff0 hotpink ff69b4 indianred cd5c5c indigo 4b0082 \
ivory fffff0 khaki f0e68c lavender e6e6fa lavenderblush fff0f5 lawngreen 7cfc00 lemonchiffon fffacd lightblue add8e6 lightcoral f08080 \
lightcyan e0ffff lightgoldenrodyellow fafad2 lightgray d3d3d3 lightgreen 90ee90 lightgrey d3d3d3 lightpink ffb6c1 lightsalmon ffa07a \
lightseagreen 20b2aa lightskyblue 87cefa lightslategray 778899 lightslategrey 778899 lightsteelblue b0c4de lightyellow ffffe0 lime 00ff00 \
limegreen 32cd32 linen faf0e6 magenta ff00ff maroon 800000 mediumaquamarine 66cdaa mediumblue 0000cd mediumorchid ba55d3 \
mediumpurple 9370db mediumseagreen 3cb371 mediumslateblue 7b68ee mediumspringgreen 00fa9a mediumturquoise 48d1cc mediumvioletred c71585 \
midnightblue 191970 mintcream f5fffa mistyrose ffe4e1 moccasin ffe4b5 navajowhite ffdead navy 000080 oldlace fdf5e6 olive 808000 \
olivedrab 6b8e23 orange ffa500 orangered ff4500 orchid da70d6 palegoldenrod eee8aa palegreen 98fb98 paleturquoise afeeee \
palevioletred db7093 papayawhip ffefd5 peachpuff ffdab9 peru cd853f pink ffc0cb plum dda0dd powderblue b0e0e6 purple 800080 \
rebeccapurple 663399 red ff0000 rosybrown bc8f8f royalblue 4169e1 saddlebrown 8b4513 salmon fa8072 sandybrown f4a460 seagreen 2e8b57 \
seashell fff5ee sienna a0522d silver c0c0c0 skyblue 87ceeb slateblue 6a5acd slategray 708090 slategrey 708090 snow fffafa \
springgreen 00ff7f steelblue 4682b4 tan d2b48c teal 008080 thistle d8bfd8 tomato ff6347 turquoise 40e0d0 violet ee82ee wheat f5deb3 \
white ffffff whitesmoke f5f5f5 yellow ffff00 yellowgreen 9acd32";

/// The colour of a name or of `#rgb`, `#rrggbb`.
pub fn colour(text: &str) -> Option<[u8; 3]> {
    let plain: String =
        text.trim().to_ascii_lowercase().chars().filter(|c| !matches!(c, ' ' | '_' | '-')).collect();
    if let Some(digits) = plain.strip_prefix('#') {
        return hex(digits);
    }
    let mut words = NAMES.split_ascii_whitespace();
    while let (Some(name), Some(digits)) = (words.next(), words.next()) {
        if name == plain {
            return hex(digits);
        }
    }
    None
}

fn hex(digits: &str) -> Option<[u8; 3]> {
    let number = u32::from_str_radix(digits, 16)
        .ok()
        .filter(|_| digits.bytes().all(|byte| byte.is_ascii_hexdigit()))?;
    let [_, red, green, blue] = number.to_be_bytes();
    match digits.len() {
        6 => Some([red, green, blue]),
        3 => Some([green & 15, blue >> 4, blue & 15].map(|digit| digit * 17)),
        _ => None,
    }
}

/// A number that a text stands for, all bits alike (FNV-1a by Fowler, Noll and Vo; last steps of `SplitMix64`, Steele and others 2014).
pub(in super::super) fn hash(text: &str) -> u64 {
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    mix(hash)
}

/// Another number for each number.
pub(crate) fn mix(number: u64) -> u64 {
    let number = (number ^ number >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let number = (number ^ number >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ number >> 31
}

/// A share, 0…1, of a number's bits.
pub(crate) fn share(number: u64) -> f64 {
    (number >> 11) as f64 / (1_u64 << 53) as f64
}

/// A colour a little lighter or darker, by the bits of a number: `amount` of 255 at most.
pub(in super::super) fn varied(colour: [u8; 3], number: u64, amount: f64) -> [u8; 3] {
    let all = share(mix(number)) * 2.0 - 1.0;
    let own = |index: u64| share(mix(number.wrapping_add(index + 1))) * 2.0 - 1.0;
    let mut index = 0;
    colour.map(|code| {
        index += 1;
        // Mostly all three together: tints differ less than lightness does.
        (f64::from(code) + amount * (0.75 * all + 0.25 * own(index))).round().clamp(0.0, 255.0) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_by_name_and_number() {
        assert_eq!(colour("Light Grey"), Some([211, 211, 211]));
        assert_eq!(colour("rebecca_purple"), Some([0x66, 0x33, 0x99]));
        assert_eq!(colour("#aBcDeF"), Some([0xab, 0xcd, 0xef]));
        assert_eq!(colour("#18f"), Some([0x11, 0x88, 0xff]));
        for text in ["", "#", "#12", "#12345g", "#+12345", "#1234567", "ff0000", "reddish"] {
            assert_eq!(colour(text), None, "{text}");
        }
        assert_eq!(NAMES.split_ascii_whitespace().count(), 2 * 148);
    }

    #[test]
    fn colours_vary_within_their_amount() {
        let colours: Vec<[u8; 3]> = (0..200).map(|index| varied([120, 100, 250], index, 12.0)).collect();
        assert!(colours.iter().all(|c| c[0].abs_diff(120) <= 12 && c[1].abs_diff(100) <= 12 && c[2] >= 238));
        let different: std::collections::HashSet<_> = colours.iter().collect();
        assert!(different.len() > 50, "{}", different.len());
    }
}
