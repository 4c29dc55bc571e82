//! The blind check.
