//! Names that scenes had once, each with its successor. Add a line for each variant or key that is removed.

use scene_runs::scene::Retired;

pub(crate) const RETIRED: &[Retired] = &[
    Retired {
        path: "scheme.shape.linear",
        successor: "`quadratic_b_spline`: behind a shock derivatives by linear functions were off by 69 to 106 %",
    },
    Retired {
        path: "scheme.shape.gimp",
        successor: "`cubic_b_spline`, which oscillates by 0.7 to 2.6 % behind a shock where GIMP had 5 to 11 %",
    },
    Retired {
        path: "scheme.update_order",
        successor: "nothing in its place: stresses are updated last, from velocities mapped twice; the other orders gained or lost up to 8 % of the energy",
    },
    Retired {
        path: "flip.damping_time",
        successor: "`flip` with a linear viscosity of 0.3, or `apic`; it lost 2 to 5 % of the energy of an explosion",
    },
    Retired { path: "method.adjoint", successor: "`propagated` or `forward_difference`" },
];
