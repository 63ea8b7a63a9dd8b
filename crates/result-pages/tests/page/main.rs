//! A page, as text and in a browser.

#[path = "../drive/mod.rs"]
mod drive;
mod sample;

mod browser;
mod content;
