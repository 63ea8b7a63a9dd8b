//! Sources of the methods, as a page cites them.

use result_pages::Source;

const fn source(key: &'static str, text: &'static str, role: &'static str) -> Source {
    Source { key, text, role }
}

/// Canor 2013.
pub const CANOR_2013: Source = source(
    "canor2013ijnme",
    "Canor, T. and Denoël, V. (2013). Transient Fokker-Planck-Kolmogorov equation solved with smoothed particle hydrodynamics \
     method. International Journal for Numerical Methods in Engineering. doi:10.1002/nme.4461",
    "the equation on moving particles",
);
/// Roberts 1990.
pub const ROBERTS_1990: Source = source(
    "roberts1990",
    "Roberts, J. B. and Spanos, P. D. (1990). Random vibration and statistical linearization. Wiley, Chichester.",
    "statistical linearisation",
);
/// Scharfetter 1969.
pub const SCHARFETTER_1969: Source = source(
    "scharfetter1969",
    "Scharfetter, D. L. and Gummel, H. K. (1969). Large-signal analysis of a silicon Read diode oscillator. IEEE Transactions on \
     Electron Devices 16.",
    "fluxes between cells",
);
/// Girsanov 1960.
pub const GIRSANOV_1960: Source = source(
    "girsanov1960",
    "Girsanov, I. V. (1960). On transforming a certain class of stochastic processes by absolutely continuous substitution of \
     measures. Theory of Probability and its Applications 5(3), 285-301.",
    "weights of guided paths",
);
/// Macke 2003.
pub const MACKE_2003: Source = source(
    "macke2003",
    "Macke, M. and Bucher, C. (2003). Importance sampling for randomly excited dynamical systems. Journal of Sound and Vibration \
     268, 269-290.",
    "importance sampling of paths",
);
/// Au and Beck 2001.
pub const AU_BECK_2001: Source = source(
    "aubeck2001",
    "Au, S.-K. and Beck, J. L. (2001). Estimation of small failure probabilities in high dimensions by subset simulation. \
     Probabilistic Engineering Mechanics.",
    "subset simulation",
);
/// Chen 2019.
pub const CHEN_2019: Source = source(
    "chen2019",
    "Chen, W., Shi, Y., Ma, J., Xu, C., Lu, S. and Xu, X. (2019). Stochastic Material Point Method for Analysis in Non-Linear \
     Dynamics of Metals. Metals 9(1), 107. doi:10.3390/met9010107",
    "the material point method with random parameters",
);
/// Joe and Kuo 2008.
pub const JOE_KUO_2008: Source = source(
    "joekuo2008",
    "Joe, S. and Kuo, F. Y. (2008). Constructing Sobol sequences with better two-dimensional projections. SIAM Journal on \
     Scientific Computing 30(5), 2635-2654. doi:10.1137/070709359",
    "Sobol' points",
);
/// Saltelli 2010.
pub const SALTELLI_2010: Source = source(
    "saltelli2010",
    "Saltelli, A., Annoni, P., Azzini, I., Campolongo, F., Ratto, M. and Tarantola, S. (2010). Variance based sensitivity analysis \
     of model output. Design and estimator for the total sensitivity index. Computer Physics Communications 181, 259-270.",
    "Sobol' indices",
);
/// Parks 2008.
pub const PARKS_2008: Source = source(
    "parks2008",
    "Parks, M. L., Lehoucq, R. B., Plimpton, S. J. and Silling, S. A. (2008). Implementing peridynamics within a molecular dynamics \
     code. Computer Physics Communications 179(11), 777-783. doi:10.1016/j.cpc.2008.06.011",
    "bond-based peridynamics",
);
/// Tim 2019.
pub const TIM_2019: Source = source(
    "tim2019",
    "Tim (2019). Quick Notes on Probabilistic Peridynamics. Note dated 26 November 2019.",
    "peridynamics driven by Brownian motion",
);
/// Wood 2010.
pub const WOOD_2010: Source = source(
    "wood2010",
    "Wood, S. N. (2010). Statistical inference for noisy nonlinear ecological dynamic systems. Nature 466, 1102-1104. \
     doi:10.1038/nature09319",
    "the likelihood of summaries from ensembles",
);
/// Ohagan 2006.
pub const OHAGAN_2006: Source = source(
    "ohagan2006",
    "O'Hagan, A. (2006). Bayesian analysis of computer code outputs: a tutorial. Reliability Engineering and System Safety \
     91(10-11), 1290-1300. doi:10.1016/j.ress.2005.11.025",
    "the average over emulators",
);
/// Vehtari 2021.
pub const VEHTARI_2021: Source = source(
    "vehtari2021",
    "Vehtari, A., Gelman, A., Simpson, D., Carpenter, B. and Bürkner, P.-C. (2021). Rank-normalization, folding, and \
     localization: an improved R-hat for assessing convergence of MCMC. Bayesian Analysis 16(2), 667-718. doi:10.1214/20-BA1221",
    "R-hat and the effective sample size",
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_source_is_an_entry_of_the_bibliography_with_its_year() {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/references.bib");
        let bibliography = std::fs::read_to_string(path).unwrap();
        for source in [
            CANOR_2013,
            ROBERTS_1990,
            SCHARFETTER_1969,
            GIRSANOV_1960,
            MACKE_2003,
            AU_BECK_2001,
            CHEN_2019,
            JOE_KUO_2008,
            SALTELLI_2010,
            PARKS_2008,
            TIM_2019,
            WOOD_2010,
            OHAGAN_2006,
            VEHTARI_2021,
        ] {
            let (_, entry) = bibliography.split_once(&format!("{{{},", source.key)).unwrap();
            let entry = &entry[..entry.find("\n}").unwrap()];
            let (_, year) = source.text.split_once('(').unwrap();
            let year = &year[..4];
            assert!(entry.contains(&format!("{{{year}}}")), "{} {year}", source.key);
        }
    }
}
