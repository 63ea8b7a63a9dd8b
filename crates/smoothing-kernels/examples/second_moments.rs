//! Prints second moments of every kernel at equal support radius: its width for the same number of neighbours.
//!
//! `cargo run -p smoothing-kernels --example second_moments`

use smoothing_kernels::all;
use std::io::{self, Write};

fn print<const D: usize>(out: &mut impl Write) -> io::Result<()> {
    for (name, kernel) in all::<D>() {
        let kappa = kernel.second_moment();
        let deviation = kappa.sqrt() / kernel.support();
        writeln!(
            out,
            "{D}-D {name:18} kappa {kappa:.6}, deviation over support radius {deviation:.4}"
        )?;
    }
    Ok(())
}

fn main() -> io::Result<()> {
    let mut out = io::stdout().lock();
    print::<2>(&mut out)?;
    print::<3>(&mut out)
}
