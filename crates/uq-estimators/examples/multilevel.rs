//! The mean payoff of a call on a stock that follows a geometric Brownian motion, by multilevel Monte Carlo.

use sde_integrators::{Noise, Purpose};
use uq_estimators::{Bias, Failure, Levels, Multilevel, Statistic, Target, Tolerance};

const FINEST: usize = 8;

/// Euler-Maruyama with `2^level` steps; every level takes sums of the same `2^8` normals.
#[allow(clippy::unnecessary_wraps, reason = "a model may fail")]
fn payoff(level: usize, realisation: u64, y: &mut [f64]) -> Result<(), Failure> {
    let mut normals = [0.0; 1 << FINEST];
    Noise::new(1).stream(Purpose::Field, realisation).fill_normal(&mut normals);
    let (n_steps, mut x) = (1 << level, 1.0_f64);
    for part in normals.chunks_exact(normals.len() / n_steps) {
        let dw = part.iter().sum::<f64>() / (normals.len() as f64).sqrt();
        x += 0.05 * x / n_steps as f64 + 0.2 * x * dw;
    }
    y[0] = (-0.05_f64).exp() * (x - 1.0).max(0.0);
    Ok(())
}

#[allow(clippy::print_stdout, reason = "an example")]
fn main() -> Result<(), uq_estimators::Error> {
    let costs: Vec<f64> = (0..=FINEST).map(|level| (level as f64).exp2()).collect();
    let ladder = Levels { costs: &costs, n_responses: 1, run: payoff };
    let targets =
        [Target { response: 0, statistic: Statistic::Mean, tolerance: Tolerance::Absolute(5e-4) }];
    let (bias, budget) = (Bias::Order(1.0), 1e8);
    let study = Multilevel {
        name: "call",
        targets: &targets,
        bias,
        block_length: 256,
        pilot_blocks: 2,
        budget,
    };
    let found = study.run(&ladder)?;
    let price = found.targets[0];
    println!("price {}, bias {} (Black and Scholes: 0.104506)", price.estimate, price.bias);
    println!("cost {:.2e} steps; one level {:.2e}", found.cost, found.single_level_cost);
    Ok(())
}
