//! Sources of the methods, as a page cites them.

use result_pages::Source;

/// Canor 2013.
pub const CANOR_2013: Source = Source {
    key: "canor2013ijnme",
    text: "Canor, T. and Denoël, V. (2013). Transient Fokker-Planck-Kolmogorov equation solved with smoothed particle hydrodynamics \
     method. International Journal for Numerical Methods in Engineering. doi:10.1002/nme.4461",
    role: "the equation on moving particles",
};

/// Roberts 1990.
pub const ROBERTS_1990: Source = Source {
    key: "roberts1990",
    text: "Roberts, J. B. and Spanos, P. D. (1990). Random vibration and statistical linearization. Wiley, Chichester.",
    role: "statistical linearisation",
};

/// Scharfetter 1969.
pub const SCHARFETTER_1969: Source = Source {
    key: "scharfetter1969",
    text: "Scharfetter, D. L. and Gummel, H. K. (1969). Large-signal analysis of a silicon Read diode oscillator. IEEE Transactions on \
     Electron Devices 16.",
    role: "fluxes between cells",
};

/// Girsanov 1960.
pub const GIRSANOV_1960: Source = Source {
    key: "girsanov1960",
    text: "Girsanov, I. V. (1960). On transforming a certain class of stochastic processes by absolutely continuous substitution of \
     measures. Theory of Probability and its Applications 5(3), 285-301.",
    role: "weights of guided paths",
};

/// Macke 2003.
pub const MACKE_2003: Source = Source {
    key: "macke2003",
    text: "Macke, M. and Bucher, C. (2003). Importance sampling for randomly excited dynamical systems. Journal of Sound and Vibration \
     268, 269-290.",
    role: "importance sampling of paths",
};

/// Au and Beck 2001.
pub const AU_BECK_2001: Source = Source {
    key: "aubeck2001",
    text: "Au, S.-K. and Beck, J. L. (2001). Estimation of small failure probabilities in high dimensions by subset simulation. \
     Probabilistic Engineering Mechanics.",
    role: "subset simulation",
};
