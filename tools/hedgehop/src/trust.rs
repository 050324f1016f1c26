//! Trust in a database, and reports of pages that were left out.

use std::path::Path;

use clap::{Args, ValueEnum};
use serde_json::Value;

use hedgehop::memory::PageFile;
use hedgehop::voxel::{Damaged, PageId, Trust, Verify};

/// Damaged pages that are named one by one.
const NAMED: usize = 8;

/// A damaged page that a coarser level stood in for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DamagedPage {
    /// Page of the database.
    pub id: PageId,
    /// Offset of the page in the database's file, bytes.
    pub byte: u64,
}

impl DamagedPage {
    /// Returns the pages of a database that were met and found damaged.
    pub fn of(file: &PageFile) -> Vec<Self> {
        file.damaged().into_iter().map(|(id, byte)| Self { id, byte }).collect()
    }
}

/// Flags of trust in a database: when its pages are checked, and treatment of damaged ones.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct TrustArgs {
    /// Time at which pages are checked against their checksums
    #[arg(long, value_enum, value_name = "WHEN", default_value = "first-touch")]
    verify: VerifyWhen,

    /// Treatment of damaged pages: fail ends the run, coarser has the next coarser level stand in for them
    #[arg(long, value_enum, value_name = "HOW", default_value = "fail")]
    damaged: DamagedHow,
}

/// `--verify` as users give it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum VerifyWhen {
    /// Once, when they are first touched
    #[default]
    FirstTouch,
    /// Never: damage shows in the pictures
    Never,
}

/// `--damaged` as users give it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum DamagedHow {
    /// Whoever touches one is told so
    #[default]
    Fail,
    /// The next coarser level stands in
    Coarser,
}

impl TrustArgs {
    /// Whether damaged pages are left out.
    pub fn leaves_out_damaged(self) -> bool {
        self.damaged == DamagedHow::Coarser
    }

    /// Converts to the library's type.
    pub fn trust(self) -> Trust {
        let verify = match self.verify {
            VerifyWhen::FirstTouch => Verify::FirstTouch,
            VerifyWhen::Never => Verify::Never,
        };
        let damaged = match self.damaged {
            DamagedHow::Fail => Damaged::Fail,
            DamagedHow::Coarser => Damaged::Coarser,
        };
        Trust { verify, damaged }
    }

    /// Adds to the settings that decide the pictures what may make them differ from those of a sound database.
    pub fn record(self, settings: &mut Value) {
        if self.verify == VerifyWhen::Never {
            settings["verify"] = "never".into();
        }
        if self.damaged == DamagedHow::Coarser {
            settings["damaged"] = "coarser".into();
        }
    }
}

/// Reports the pages that were left out; `None` if none were.
pub fn sentence(area: &Path, damaged: &[DamagedPage]) -> Option<String> {
    if damaged.is_empty() {
        return None;
    }
    let named: Vec<String> =
        damaged.iter().take(NAMED).map(|DamagedPage { id, byte }| format!("{id} at byte {byte}")).collect();
    let more = damaged.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(", and {more} more") } else { String::new() };
    Some(format!(
        "{}: damaged, and shown from coarser levels: {}{more}; copy the file again, or build it again",
        area.display(),
        named.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_departs_from_the_default_is_a_setting() {
        let mut settings = serde_json::json!({});
        TrustArgs::default().record(&mut settings);
        assert_eq!(settings, serde_json::json!({}));
        TrustArgs { verify: VerifyWhen::Never, damaged: DamagedHow::Coarser }.record(&mut settings);
        assert_eq!(settings, serde_json::json!({ "verify": "never", "damaged": "coarser" }));
    }

    #[test]
    fn many_damaged_pages_are_counted() {
        let page = |px| DamagedPage { id: PageId { level: 0, px, py: 0 }, byte: u64::from(px) * 4096 };
        assert_eq!(sentence(Path::new("a.hop"), &[]), None);
        let all: Vec<_> = (0..11).map(page).collect();
        let said = sentence(Path::new("a.hop"), &all).unwrap();
        assert!(said.starts_with("a.hop: damaged") && said.contains(", and 3 more;"), "{said}");
        assert!(said.contains("page (7, 0) of level 1 at byte 28672"), "{said}");
    }
}
