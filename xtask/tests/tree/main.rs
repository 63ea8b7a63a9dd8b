//! What must hold of the tree of files: pages against sources, edges and circles of the packages, language, mutants, records.

mod folder;
mod packages;

mod circles;
mod crate_pages;
mod documents;
mod edges;
mod language;
mod mutants;
mod records;
