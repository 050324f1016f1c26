//! Record of what made a frame, as it is written into every file: one list of entries for all formats.

use std::collections::BTreeMap;

use crate::space::{Camera, Screen};

/// Record of what made a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameInfo {
    /// Number of the frame, absolute, from 1.
    pub frame: u64,
    /// Time since the start of the flight, seconds.
    pub seconds: f64,
    /// Content hash of the database.
    pub database_hash: String,
    /// File name of the database.
    pub database_file: String,
    /// Coordinate reference system of the eye and the normals.
    pub crs_name: String,
    /// Datum that heights count from.
    pub vertical_datum: String,
    /// Digest of everything else that decides the picture ([`settings_digest`](crate::encode::sidecar::settings_digest)).
    pub settings_digest: String,
    /// Program and version that wrote the frame.
    pub writer: String,
}

/// A value of an entry. Numbers are written so that they read back to the same f64.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Text(String),
    Number(f64),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => write!(f, "{number}"),
        }
    }
}

/// Meaning of the camera's entries.
pub(super) const CAMERA_CONVENTIONS: &str = "eye: metres in the named reference system, x east, y north, \
     z up from the vertical datum; yaw: degrees clockwise from grid north; pitch: degrees, nose up \
     positive; roll: degrees, right wing down positive; all of the view itself; screen: projection and its \
     parameters; hfov: horizontal field of view of a planar screen, degrees; \
     pixel centres at half-integers, row 0 at the top";

/// Entries that two files of the same picture share; others may differ (a database that was renamed).
const IDENTITY: [&str; 9] = [
    "hedgehop.frame",
    "hedgehop.database_hash",
    "hedgehop.settings_digest",
    "hedgehop.eye_m",
    "hedgehop.yaw_deg",
    "hedgehop.pitch_deg",
    "hedgehop.roll_deg",
    "hedgehop.screen",
    "hedgehop.hfov_deg",
];

impl FrameInfo {
    /// Name and value of every entry, except the writer, for which the formats have names of their own.
    pub(super) fn entries(&self, camera: &Camera) -> Vec<(&'static str, Value)> {
        // A NUL ends a text in both formats.
        let text = |text: &str| Value::Text(text.replace('\0', " "));
        let pose = &camera.pose;
        let eye = format!("{} {} {}", pose.eye.x, pose.eye.y, pose.eye.z);

        let mut entries = vec![
            ("hedgehop.frame", Value::Text(self.frame.to_string())),
            ("hedgehop.seconds", Value::Number(self.seconds)),
            ("hedgehop.database_file", text(&self.database_file)),
            ("hedgehop.database_hash", text(&self.database_hash)),
            ("hedgehop.settings_digest", text(&self.settings_digest)),
            ("hedgehop.crs", text(&self.crs_name)),
            ("hedgehop.vertical_datum", text(&self.vertical_datum)),
            ("hedgehop.eye_m", Value::Text(eye)),
            ("hedgehop.yaw_deg", Value::Number(pose.attitude.yaw)),
            ("hedgehop.pitch_deg", Value::Number(pose.attitude.pitch)),
            ("hedgehop.roll_deg", Value::Number(pose.attitude.roll)),
            ("hedgehop.screen", Value::Text(camera.screen().to_string())),
        ];

        if let Screen::Planar { hfov } = *camera.screen() {
            entries.push(("hedgehop.hfov_deg", Value::Number(hfov)));
        }

        entries
    }

    /// The first entry by which a file with the entries `found` shows, or may show, another picture than this one;
    /// `None` when it says that it is this one.
    pub(super) fn difference(&self, camera: &Camera, found: &BTreeMap<String, String>) -> Option<String> {
        self.entries(camera).into_iter().filter(|(name, _)| IDENTITY.contains(name)).find_map(
            |(name, wanted)| {
                let plain = name.trim_start_matches("hedgehop.");
                match found.get(name) {
                    Some(there) if *there == wanted.to_string() => None,
                    Some(there) => Some(format!("{plain} is {there}, not {wanted}")),
                    None => Some(format!("it does not say its {plain}")),
                }
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use crate::encode::testing;
    use crate::space::{Camera, Screen};

    #[test]
    fn only_what_decides_the_picture_is_compared() {
        let (frame, info) = (testing::frame(4, 3), testing::info());
        let mut found: std::collections::BTreeMap<_, _> = info
            .entries(&frame.camera)
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value.to_string()))
            .collect();
        assert_eq!(info.difference(&frame.camera, &found), None);
        found.insert("hedgehop.database_file".to_owned(), "renamed.hop".to_owned());
        assert_eq!(info.difference(&frame.camera, &found), None);
        found.insert("hedgehop.roll_deg".to_owned(), "12.5".to_owned());
        assert_eq!(info.difference(&frame.camera, &found).unwrap(), "roll_deg is 12.5, not 20");
        let (width, height) = (frame.camera.width, frame.camera.height);
        let round = Camera::with_screen(frame.camera.pose, Screen::Fisheye { fov: 60.0 }, width, height);
        found.insert("hedgehop.roll_deg".to_owned(), "20".to_owned());
        assert_eq!(
            info.difference(&round, &found).unwrap(),
            "screen is planar hfov_deg=60, not fisheye fov_deg=60"
        );
        found.clear();
        let silent = info.difference(&frame.camera, &found).unwrap();
        assert!(silent.starts_with("it does not say"), "{silent}");
    }
}
