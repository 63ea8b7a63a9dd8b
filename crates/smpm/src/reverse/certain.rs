//! Refuses derivatives that are not in the numbers of particles.

use perturbation_moments::{Jet, Scalar};

use crate::error::Error;
use crate::material_points::Strain;
use crate::simulation::Simulation;
use crate::velocity_gradients::VelocityGradients;

fn depends(number: &Jet) -> bool {
    number.first.iter().any(|&slope| slope != 0.0)
}

/// Refuses a material that is the same for all particles of its body and depends on coefficients: its constants are no numbers of a
/// particle, by which the adjoint is. Constants are looked at where a material shows them; else a step of the first particle,
/// compressed long after the start, is.
///
/// # Errors
/// [`Error::NotReversed`].
pub(super) fn check<const D: usize>(jets: &mut Simulation<Jet, D>) -> Result<(), Error> {
    let (cell, viscosity) = (jets.config().cell, jets.config().viscosity);
    let what = "a body whose material depends on coefficients without varying in space";
    for body in jets.bodies_mut() {
        let mut found = false;
        let is_whole = body.points.show_constants(&mut |number: &mut Jet| found |= depends(number));
        if found {
            return Err(Error::NotReversed { what });
        }
        if is_whole {
            continue;
        }
        let mut before = vec![];
        let _ = body.points.show_numbers(0, &mut |number: &mut Jet| before.push(*number));
        let mut numbers = before.iter();
        let _ = body.points.visit_numbers(0, &mut |number: &mut Jet| {
            if let Some(of) = numbers.next() {
                *number = Jet::constant(of.value);
            }
        });
        // A compression by 1e-3 is within the range of every equation of state.
        let (mut gradients, dt) = (VelocityGradients::zero(), 1.0);
        let mut l = [[Jet::constant(0.0); 3]; 3];
        l[0][0] = Jet::constant(-1e-3);
        gradients.set(0, &l);
        let strain = Strain { dt, time: 1e30, cell, viscosity };
        body.points.pass(&mut |points| {
            let _ = points.update(0..1, strain, &gradients, &[0]);
        });
        let _ = body.points.show_numbers(0, &mut |number: &mut Jet| found |= depends(number));
        let mut numbers = before.iter();
        let _ = body.points.visit_numbers(0, &mut |number: &mut Jet| {
            if let Some(of) = numbers.next() {
                *number = *of;
            }
        });
        if found {
            return Err(Error::NotReversed { what });
        }
    }
    Ok(())
}
