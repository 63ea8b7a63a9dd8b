//! Names that scenes had once, each with its successor. Add a line for each variant or key that is removed.

use scene_runs::scene::Retired;

pub(crate) const RETIRED: &[Retired] = &[
    Retired {
        path: "method.log_density_fit",
        successor: "`flow_map_fit`, which takes 9 s where it took 11 s, with a third of its error",
    },
    Retired {
        path: "scheme.runge_kutta_chebyshev",
        successor: "`lawson_adams_bashforth_2`, which has 0.02 % in 7 ms where it had 0.04 % in 139 ms on the damper",
    },
    Retired {
        path: "scheme.lawson_runge_kutta_4",
        successor: "`lawson_adams_bashforth_2`, or `runge_kutta_4` behind a filter",
    },
    Retired {
        path: "scheme.heun",
        successor: "`runge_kutta_4`, which has a smaller error at the same cost",
    },
    Retired {
        path: "scheme.leap_frog",
        successor: "`runge_kutta_4`: with noise or damping it is stable at no step",
    },
    Retired {
        path: "scheme.forward_euler",
        successor: "the method `canor_denoel_2013`, whose scheme it is",
    },
    Retired {
        path: "canor_denoel_2013.scheme",
        successor: "nothing in its place: the method steps by forward Euler as printed",
    },
    Retired {
        path: "integrator",
        successor: "nothing in its place: each system has its best integrator",
    },
    Retired {
        path: "method.importance_sampling",
        successor: "`guided_paths`, which has a smaller error in every scene and also serves common events",
    },
];
