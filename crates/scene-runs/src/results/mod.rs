//! Results of a run: answers with their errors, files, and the page.
//!
//! Where numbers come from is not known here.

pub mod answers;
pub mod output;
pub(crate) mod page;
pub mod report;
pub mod result_file;
