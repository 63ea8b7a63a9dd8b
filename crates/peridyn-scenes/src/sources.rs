//! Sources of the methods, as a page cites them.

use result_pages::Source;

/// Parks 2008.
pub const PARKS_2008: Source = Source {
    key: "parks2008",
    text: "Parks, M. L., Lehoucq, R. B., Plimpton, S. J. and Silling, S. A. (2008). Implementing peridynamics within a molecular dynamics \
     code. Computer Physics Communications 179(11), 777-783. doi:10.1016/j.cpc.2008.06.011",
    role: "bond-based peridynamics",
};

/// Tim 2019.
pub const TIM_2019: Source = Source {
    key: "tim2019",
    text: "Tim (2019). Quick Notes on Probabilistic Peridynamics. Note dated 26 November 2019.",
    role: "peridynamics driven by Brownian motion",
};

/// Wood 2010.
pub const WOOD_2010: Source = Source {
    key: "wood2010",
    text: "Wood, S. N. (2010). Statistical inference for noisy nonlinear ecological dynamic systems. Nature 466, 1102-1104. \
     doi:10.1038/nature09319",
    role: "the likelihood of summaries from ensembles",
};

/// Ohagan 2006.
pub const OHAGAN_2006: Source = Source {
    key: "ohagan2006",
    text: "O'Hagan, A. (2006). Bayesian analysis of computer code outputs: a tutorial. Reliability Engineering and System Safety \
     91(10-11), 1290-1300. doi:10.1016/j.ress.2005.11.025",
    role: "the average over emulators",
};

/// Vehtari 2021.
pub const VEHTARI_2021: Source = Source {
    key: "vehtari2021",
    text: "Vehtari, A., Gelman, A., Simpson, D., Carpenter, B. and Bürkner, P.-C. (2021). Rank-normalization, folding, and \
     localization: an improved R-hat for assessing convergence of MCMC. Bayesian Analysis 16(2), 667-718. doi:10.1214/20-BA1221",
    role: "R-hat and the effective sample size",
};
