//! For any file contents, reading ends in a scene, a result or a typed error.
//!
//! There is no panic, no hang, and no memory beyond [`MOST_BYTES`].
//!
//! `PROPTEST_CASES` sets the number of cases.

#![allow(clippy::unwrap_used, reason = "a setup that fails should fail the test")]

mod changes;
mod points;
mod scene;
mod shard;

use std::alloc::System;

use cap::Cap;

/// An allocation beyond it aborts the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);
