//! What the cases use.

pub(super) use result_figures::{ErrorKind, Measured, Reference};

pub(super) use crate::case::Run::{Alone, Together};
pub(super) use crate::case::{Case, CaseError, CaseResult, Context, Lines, Profile};
pub(super) use crate::cases::estimates::{estimated, sampled};
pub(super) use crate::cases::worst::Worst;
pub(super) use crate::claim::{Criterion, Subject};
pub(super) use crate::report::Claim;
