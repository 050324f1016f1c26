//! Caches and pools that workers share.

mod keyed;
mod pool;

#[doc(hidden)]
pub use keyed::{Bytes, KeyedCache};
#[doc(hidden)]
pub use pool::{Lent, Used};
