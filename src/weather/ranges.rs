//! Ranges that the numbers of [`Weather`](super::Weather) lie within.

use std::ops::RangeInclusive;

/// Metres above or below the datum beyond which there is no weather.
const HIGHEST: f64 = 100_000.0;

/// Metres that clouds may be deep.
const CLOUD_DEPTHS: RangeInclusive<f64> = 10.0..=20_000.0;

/// Metres that may lie from one cloud to the next.
const CLOUD_SCALES: RangeInclusive<f64> = 100.0..=100_000.0;

/// Strongest wind that moves clouds, metres per second.
pub(crate) const FASTEST_CLOUDS: f64 = 1000.0;

/// Strongest wind in which rain and snow fall, metres per second.
pub(crate) const FASTEST_FALL: f64 = 100.0;

/// Heaviest fall, millimetres of water an hour: more than cloudbursts bring.
const HEAVIEST: f64 = 300.0;

/// Whether a share is one.
pub(crate) fn is_share(share: f64) -> bool {
    (0.0..=1.0).contains(&share)
}

/// Whether weather may lie at a height, metres above the datum.
pub(crate) fn is_height(metres: f64) -> bool {
    metres.abs() <= HIGHEST
}

/// Whether so many metres may be seen inside of fog or clouds.
pub(crate) fn is_visibility(metres: f64) -> bool {
    (1.0..=1.0e6).contains(&metres)
}

/// Whether the upper edge of fog may be so many metres deep.
pub(crate) fn is_edge_depth(metres: f64) -> bool {
    (1.0..=HIGHEST).contains(&metres)
}

/// Whether clouds may be so many metres deep.
pub(crate) fn is_cloud_depth(metres: f64) -> bool {
    CLOUD_DEPTHS.contains(&metres)
}

/// Whether so many metres may lie from cloud to cloud.
pub(crate) fn is_cloud_scale(metres: f64) -> bool {
    CLOUD_SCALES.contains(&metres)
}

/// Whether so many millimetres of water may fall an hour.
pub(crate) fn is_rate(rate: f64) -> bool {
    rate > 0.0 && rate <= HEAVIEST
}

/// Whether a wind may blow eastward or northward with so many metres per second, of which the strongest has `fastest`.
pub(crate) fn is_wind(speed: f64, fastest: f64) -> bool {
    speed.abs() <= fastest
}
