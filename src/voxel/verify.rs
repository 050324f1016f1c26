//! Checking a database from end to end.
