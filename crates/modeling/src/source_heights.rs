//! Heights of one source: their datum and unit, from what its file states and what the user adds.
//!
//! ```text
//! datum   stated by the file, else by the system that the user gives, else --src-vdatum, else mean sea level
//! unit    stated by the file, else by the system that the user gives, else that of the horizontal coordinates, else metres
//! ```
//!
//! Whatever is assumed, or stated and not told apart here, is said in a note.

use hedgehop_geo::{Crs, VerticalCrs, VerticalDatum};

/// Statements on the datum and unit of a source's heights.
pub(super) struct Stated<'a> {
    /// File name, for notes.
    pub name: &'a str,
    /// Statement of the file.
    pub file: &'a VerticalCrs,
    /// Statement of the reference system that the user gives for a file that states none.
    pub given: VerticalCrs,
    /// Statement of `--src-vdatum`.
    pub flag: Option<VerticalDatum>,
    /// Horizontal system.
    pub crs: &'a Crs,
}

/// Datum and unit of a source's heights.
pub(super) struct SourceHeights {
    pub datum: VerticalDatum,
    /// Metres upward per unit; below 0 for depths.
    pub metres_per_unit: f64,
    /// The datum was assumed, since nothing names one.
    pub is_silent: bool,
}

impl Stated<'_> {
    /// Decides on datum and unit; what is to be said of them is added to `notes`.
    pub(super) fn settle(self, notes: &mut Vec<String>) -> SourceHeights {
        let name = self.name;
        let vertical = self.file.clone().or(self.given);
        let label = match (&vertical.name, vertical.datum) {
            (Some(own), _) => own.clone(),
            (None, datum) => datum.map_or(String::new(), |datum| datum.label().to_owned()),
        };

        if let (Some(stated), Some(flag)) = (vertical.datum, self.flag)
            && stated != flag
        {
            notes.push(format!(
                "{name}: states {} as its vertical datum, which counts; --src-vdatum is of files that state none",
                stated.label()
            ));
        }

        let is_silent = vertical.is_silent() && self.flag.is_none();
        let datum = vertical.datum.or(self.flag).unwrap_or(VerticalDatum::Msl);
        if vertical.datum.is_none() && vertical.name.is_some() {
            let taken = if self.flag.is_some() {
                "as --src-vdatum says"
            } else {
                "which it may miss by metres (--src-vdatum says otherwise)"
            };
            notes
                .push(format!("{name}: heights are in '{label}', taken as above {}, {taken}", datum.label()));
        }

        let horizontal = self.crs.metres_per_unit().filter(|_| !self.crs.is_local()).unwrap_or(1.0);
        let metres_per_unit = vertical.metres_per_unit.unwrap_or(horizontal);
        if vertical.metres_per_unit.is_none() && horizontal != 1.0 {
            notes.push(format!(
                "{name}: heights are taken to be in units of {horizontal} m, as its other coordinates are"
            ));
        }

        SourceHeights { datum, metres_per_unit, is_silent }
    }
}

impl SourceHeights {
    /// Words for a description: `heights above EGM96 mean sea level in units of 0.3048 m`.
    pub(super) fn words(&self) -> String {
        let metres = self.metres_per_unit;
        let (kind, side) = if metres < 0.0 { ("depths", "below") } else { ("heights", "above") };
        let unit =
            if metres.abs() == 1.0 { String::new() } else { format!(" in units of {} m", metres.abs()) };
        format!("{kind} {side} {}{unit}", self.datum.label())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled(
        file: VerticalCrs,
        given: VerticalCrs,
        flag: Option<VerticalDatum>,
        crs: u32,
    ) -> (SourceHeights, Vec<String>) {
        let crs = Crs::from_epsg(crs).unwrap();
        let mut notes = Vec::new();
        let heights = Stated { name: "a.tif", file: &file, given, flag, crs: &crs }.settle(&mut notes);
        (heights, notes)
    }

    #[test]
    fn files_count_before_users_and_users_before_assumptions() {
        let feet = VerticalCrs { metres_per_unit: Some(0.3048), ..VerticalCrs::default() };
        let silent = VerticalCrs::default;

        let (heights, notes) = settled(silent(), silent(), None, 32_632);
        assert!(heights.is_silent && heights.metres_per_unit == 1.0 && notes.is_empty());
        let (heights, _) = settled(silent(), feet.clone(), Some(VerticalDatum::Navd88), 32_632);
        assert_eq!((heights.datum, heights.metres_per_unit), (VerticalDatum::Navd88, 0.3048));
        let (heights, _) =
            settled(feet, VerticalCrs { metres_per_unit: Some(1.0), ..silent() }, None, 32_632);
        assert_eq!(heights.metres_per_unit, 0.3048);

        // A grid in feet whose heights say nothing.
        let (heights, notes) = settled(silent(), silent(), None, 2263);
        assert_eq!(heights.metres_per_unit, 1200.0 / 3937.0);
        assert!(notes[0].contains("as its other coordinates are"), "{notes:?}");
    }

    #[test]
    fn datums_that_are_not_told_apart_are_named() {
        let ngvd = VerticalCrs {
            name: Some("NGVD29 height (ftUS)".into()),
            metres_per_unit: Some(-0.5),
            datum: None,
        };
        let (heights, notes) = settled(ngvd, VerticalCrs::default(), None, 32_632);
        assert_eq!(heights.datum, VerticalDatum::Msl);
        assert!(!heights.is_silent && notes[0].contains("NGVD29"), "{notes:?}");
        assert_eq!(heights.words(), "depths below mean sea level in units of 0.5 m");
    }
}
