//! WKT.
