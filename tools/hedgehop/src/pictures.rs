//! Finished frames, read back: which pictures a folder holds, in which order, and what is in them.

use std::cmp::Ordering;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{ImageFormat, RgbImage};

use hedgehop::encode::{read_picture, read_regular};
use hedgehop::{Error, Result};

/// Kinds of pictures that are read.
const KINDS: [&str; 4] = ["png", "exr", "jpg", "jpeg"];

/// Whether a file is a picture by its name.
pub fn is_picture(path: &Path) -> bool {
    let kind = path.extension().map(|kind| kind.to_string_lossy().to_ascii_lowercase());
    kind.is_some_and(|kind| KINDS.contains(&kind.as_str()))
}

/// The pictures in a folder, in the order of their names, `2` before `10`.
///
/// # Errors
/// It cannot be read, or holds none.
pub fn in_folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let failed = |source| Error::io(folder, "read the folder", source);
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        // What begins with a dot is being written.
        if is_picture(&path) && !is_hidden && path.is_file() {
            found.push(path);
        }
    }
    if found.is_empty() {
        let what = "the folder holds no .png, .exr or .jpg; name one with frames";
        return Err(Error::invalid(folder, what));
    }
    found.sort_by(|a, b| by_number(&name(a), &name(b)).then_with(|| a.cmp(b)));
    Ok(found)
}

/// A picture as 8-bit sRGB.
///
/// # Errors
/// It cannot be read, or is damaged.
pub fn open(path: &Path) -> Result<RgbImage> {
    if path.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("exr")) {
        let picture = read_picture(path)?;
        let size = (picture.width, picture.height);
        return RgbImage::from_raw(size.0, size.1, picture.rgb).ok_or_else(|| {
            Error::invalid(path, format!("its pixels are not those of {}x{}", size.0, size.1))
        });
    }
    let bytes = read_regular(path, "read it")?;
    let picture = image::load_from_memory(&bytes);
    Ok(picture.map_err(|error| Error::invalid(path, format!("{error}; render it again")))?.into_rgb8())
}

/// The PNG of a picture that is to go to `path`.
pub fn png(picture: &RgbImage, path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(|error| Error::Configuration(format!("{} cannot be encoded: {error}", path.display())))?;
    Ok(bytes.into_inner())
}

/// Refuses names that do not end in .png; `what` is to be written there.
pub fn check_png(path: &Path, what: &str) -> Result<()> {
    if path.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("png")) {
        return Ok(());
    }
    let named = path.with_extension("png");
    Err(Error::Configuration(format!("{what} is a PNG; name it -o {}", named.display())))
}

/// The name of a file, for order and for people.
pub fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Returns the label of a picture on a sheet: the last number in its name, without the zeros before it.
pub fn label(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let digits = stem.split(|char: char| !char.is_ascii_digit()).rfind(|part| !part.is_empty());
    let number = digits.map_or("", |digits| digits.trim_start_matches('0'));
    if digits.is_some() && number.is_empty() { "0".to_owned() } else { number.to_owned() }
}

/// Order of names in which runs of digits count as numbers.
fn by_number(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a.as_bytes(), b.as_bytes());
    loop {
        let digits = |text: &[u8]| text.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let (in_a, in_b) = (digits(a), digits(b));
        if in_a > 0 && in_b > 0 {
            let number =
                |text: &[u8]| -> Vec<u8> { text.iter().copied().skip_while(|byte| *byte == b'0').collect() };
            let (own, other) = (number(&a[..in_a]), number(&b[..in_b]));
            match own.len().cmp(&other.len()).then_with(|| own.cmp(&other)) {
                Ordering::Equal => (a, b) = (&a[in_a..], &b[in_b..]),
                order => return order,
            }
            continue;
        }

        match (a.split_first(), b.split_first()) {
            (Some((first, rest)), Some((other, others))) if first == other => (a, b) = (rest, others),
            (first, other) => return first.map(|(byte, _)| byte).cmp(&other.map(|(byte, _)| byte)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count_as_numbers() {
        let mut names =
            ["b10.png", "b9.png", "b010x.png", "a", "b9", "", "b00000000000000000000000000000011"];
        names.sort_by(|a, b| by_number(a, b));
        assert_eq!(
            names,
            ["", "a", "b9", "b9.png", "b10.png", "b010x.png", "b00000000000000000000000000000011"]
        );
    }

    #[test]
    fn folders_hold_pictures_that_are_whole() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str| std::fs::write(folder.path().join(name), b"").unwrap();
        ["2.png", "10.png", ".3.png.x.part.png", "manifest.json", "1.EXR"].into_iter().for_each(put);
        let found: Vec<_> = in_folder(folder.path()).unwrap().iter().map(|path| name(path)).collect();
        assert_eq!(found, ["1.EXR", "2.png", "10.png"]);
        assert!(in_folder(&folder.path().join("none")).is_err());
        assert!(open(&folder.path().join("2.png")).unwrap_err().to_string().contains("2.png"));
        let labels = ["a/0042.png", "sunny.exr", "v2-000.png"].map(|name| label(Path::new(name)));
        assert_eq!(labels, ["42", "", "0"]);
        assert!(check_png(Path::new("a/map.svg"), "a map").unwrap_err().to_string().contains("map.png"));
    }
}
