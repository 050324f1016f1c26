//! Caches and pools that workers share.

mod keyed;
mod pool;

pub use keyed::{Bytes, KeyedCache};
pub use pool::{Lent, Used};
