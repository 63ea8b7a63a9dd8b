//! Sources of the methods, as a page cites them.

use result_pages::Source;

/// Chen 2019.
pub const CHEN_2019: Source = Source {
    key: "chen2019",
    text: "Chen, W., Shi, Y., Ma, J., Xu, C., Lu, S. and Xu, X. (2019). Stochastic Material Point Method for Analysis in Non-Linear \
     Dynamics of Metals. Metals 9(1), 107. doi:10.3390/met9010107",
    role: "the material point method with random parameters",
};

/// Joe and Kuo 2008.
pub const JOE_KUO_2008: Source = Source {
    key: "joekuo2008",
    text: "Joe, S. and Kuo, F. Y. (2008). Constructing Sobol sequences with better two-dimensional projections. SIAM Journal on \
     Scientific Computing 30(5), 2635-2654. doi:10.1137/070709359",
    role: "Sobol' points",
};

/// Saltelli 2010.
pub const SALTELLI_2010: Source = Source {
    key: "saltelli2010",
    text: "Saltelli, A., Annoni, P., Azzini, I., Campolongo, F., Ratto, M. and Tarantola, S. (2010). Variance based sensitivity analysis \
     of model output. Design and estimator for the total sensitivity index. Computer Physics Communications 181, 259-270.",
    role: "Sobol' indices",
};

/// Neyer 1994.
pub const NEYER_1994: Source = Source {
    key: "neyer1994",
    text: "Neyer, B. T. (1994). A D-optimality-based sensitivity test. Technometrics 36(1), 61-70. doi:10.1080/00401706.1994.10485399",
    role: "choice of the values at which runs are made",
};

/// Recht and Ipson 1963.
pub const RECHT_IPSON_1963: Source = Source {
    key: "rechtipson1963",
    text: "Recht, R. F. and Ipson, T. W. (1963). Ballistic perforation dynamics. Journal of Applied Mechanics 30(3), 384-390. \
     doi:10.1115/1.3636566",
    role: "residual velocity over impact velocity",
};
