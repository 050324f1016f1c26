//! Reference system of a database, and lengths in words.

use hedgehop::Result;
use hedgehop::geo::Crs;
use hedgehop::voxel::Header;

/// The database's reference system.
pub fn crs(header: &Header) -> Result<Crs> {
    let metadata = &header.metadata;
    Crs::from_record(&metadata.crs_name, metadata.crs_epsg, metadata.crs_proj.as_deref())
}

/// A length as short as six significant digits allow, metres.
pub fn metres(length: f64) -> String {
    let decimals = (5 - length.abs().max(1e-6).log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{length:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
