//! What runs must keep, what materials and boundaries must do, and the extension traits: in one program, since the
//! step is compiled anew for every one.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends by it")]

mod axis;
mod balance;
mod boundaries;
mod contact;
mod custom_field_experiment;
mod custom_keep;
mod custom_material;
mod derivatives;
mod fixtures;
mod invariants;
mod loads;
mod plate_impact;
mod rest;
mod restart;
mod rigid;
mod uncertainty;
mod varying;
