//! Names that scenes had once, each with its successor.
//!
//! Add a line for each variant or key that is removed. An unknown name of this table is reported with its successor in
//! place of the known names.

/// A removed name and its successor.
pub(super) struct Retired {
    /// The solver of the scenes that had it.
    solver: &'static str,
    /// The end of its path, from the key that holds it: `method.log_density_fit`, or `lattice.overlap` for a key.
    path: &'static str,
    /// What to use, after the words "use": a name and a reason with a measurement.
    pub(super) successor: &'static str,
}

const fn retired(solver: &'static str, path: &'static str, successor: &'static str) -> Retired {
    Retired { solver, path, successor }
}

const RETIRED: &[Retired] = &[
    // Densities and tails.
    retired(
        "fpk-sph",
        "method.log_density_fit",
        "`flow_map_fit`, which takes 9 s where it took 11 s, with a third of its error",
    ),
    retired(
        "fpk-sph",
        "scheme.runge_kutta_chebyshev",
        "`lawson_adams_bashforth_2`, which has 0.02 % in 7 ms where it had 0.04 % in 139 ms on the damper",
    ),
    retired(
        "fpk-sph",
        "scheme.lawson_runge_kutta_4",
        "`lawson_adams_bashforth_2`, or `runge_kutta_4` behind a filter",
    ),
    retired(
        "fpk-sph",
        "scheme.heun",
        "`runge_kutta_4`, which has a smaller error at the same cost",
    ),
    retired(
        "fpk-sph",
        "scheme.leap_frog",
        "`runge_kutta_4`: with noise or damping it is stable at no step",
    ),
    retired(
        "fpk-sph",
        "scheme.forward_euler",
        "the method `canor_denoel_2013`, whose scheme it is",
    ),
    retired(
        "fpk-sph",
        "canor_denoel_2013.scheme",
        "nothing in its place: the method steps by forward Euler as printed",
    ),
    retired(
        "fpk-sph",
        "integrator.semi_implicit_euler",
        "nothing in its place: each system has its best integrator",
    ),
    retired(
        "fpk-sph",
        "method.importance_sampling",
        "`guided_paths`, which has a smaller error in every scene and also serves common events",
    ),
    // Buildings.
    // The material point method.
    retired(
        "smpm",
        "scheme.shape.linear",
        "`quadratic_b_spline`: behind a shock derivatives by linear functions were off by 69 to 106 %",
    ),
    retired(
        "smpm",
        "scheme.shape.gimp",
        "`cubic_b_spline`, which oscillates by 0.7 to 2.6 % behind a shock where GIMP had 5 to 11 %",
    ),
    retired(
        "smpm",
        "scheme.update_order",
        "nothing in its place: stresses are updated last, from velocities mapped twice; the other orders gained or lost up to 8 % of the energy",
    ),
    retired(
        "smpm",
        "flip.damping_time",
        "`flip` with a linear viscosity of 0.3, or `apic`; it lost 2 to 5 % of the energy of an explosion",
    ),
    retired("smpm", "method.adjoint", "`propagated` or `forward_difference`"),
    // Peridynamics.
    retired("peridyn-sde", "mobility.compact", "`low_rank`, which serves any correlation length"),
    // Inference from cracks.
    #[cfg(test)]
    retired("self-check", "system.pendulum", "`linear_oscillator`, which is as small"),
    #[cfg(test)]
    retired("self-check", "viscous_damper.strength", "`intensity`"),
];

/// The entry of a name by the path at which a scene has it.
pub(super) fn retired_at(solver: &str, path: &str) -> Option<&'static Retired> {
    let is_end = |end: &str| {
        path.strip_suffix(end).is_some_and(|before| before.is_empty() || before.ends_with('.'))
    };
    RETIRED.iter().find(|it| it.solver == solver && is_end(it.path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_retired_for_its_solver_and_under_its_key_alone() {
        let is_retired = |solver: &str, path: &str| retired_at(solver, path).is_some();
        assert!(is_retired("fpk-sph", "method.log_density_fit"));
        assert!(is_retired("fpk-sph", "method.flow_map_fit.scheme.heun"));
        assert!(!is_retired("fpk-sph", "system.log_density_fit"));
        assert!(!is_retired("fpk-sph", "method.flow_map_fit.my_scheme.heun"));
        assert!(!is_retired("smpm", "method.log_density_fit"));
    }
}
