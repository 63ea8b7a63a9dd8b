//! Water.

use super::shock;
use crate::{MieGruneisenParameters, Units};

/// Water; to be wrapped in a [`TensionCutOff`](crate::TensionCutOff).
///
/// | constant | value | source |
/// |---|---|---|
/// | density | 1000 kg/m³ | chosen |
/// | C | 1480 m/s | chosen, from memory as Steinberg's (1987, 1996): no public code or page that has them was found |
/// | S1, S2, S3 | 2.56, -1.986, 0.2268 | likewise |
/// | gamma0, a | 0.5, 0 | likewise |
///
/// The effect of this choice, measured once on `contact_explosion.json` against `U_s = 1647 m/s + 1.921 u_p`, gamma0 = 0.1 and
/// 998 kg/m³ (also from memory). Until 9 us all gauges in the plate agree within 1e-4 of the largest value. Until 14 us means
/// differ by 0.1 % (flow stress), 3.7 % (S_11), 4.0 % (S_22) and 1.7 % (pressure) of the largest mean, standard deviations by at
/// most 0.1, 5, 9 and 2 %.
#[must_use]
pub fn water(units: Units) -> MieGruneisenParameters<f64> {
    MieGruneisenParameters { s2: -1.986, s3: 0.2268, ..shock(units, [1000.0, 1480.0, 2.56, 0.5]) }
}
