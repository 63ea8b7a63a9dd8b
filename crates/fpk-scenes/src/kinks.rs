//! Where steps end at kinks of the noise, across which they would lose their order.

/// Kinks between two observations at which a step ends: those farther from both, and from each other, than a millionth of the time
/// between them, by which a multistep scheme would divide.
pub(crate) fn stops_before(kinks: &[f64], start: f64, end: f64) -> Vec<f64> {
    const LEAST_PART: f64 = 1e-6;
    let (least, mut last) = (LEAST_PART * (end - start), start);
    let mut stops = Vec::new();
    for &kink in kinks {
        if kink - last > least && end - kink > least {
            stops.push(kink);
            last = kink;
        }
    }
    stops
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_are_apart_from_the_ends_and_from_each_other() {
        let kinks = [1.0, 2.0, 2.000000001, 2.9999999999, 4.0];
        assert_eq!(stops_before(&kinks, 1.0, 3.0), [2.0]);
        assert_eq!(stops_before(&kinks, 0.0, 5.0), [1.0, 2.0, 2.9999999999, 4.0]);
    }
}
