//! Units of the constants of materials, by their names in all models.

use smpm::material::Units;

/// The unit of a constant in SI, and how a number of it is converted from SI.
pub(crate) fn unit(name: &str) -> (&'static str, fn(&Units, f64) -> f64) {
    match name {
        "density" => ("kg/m^3", Units::density),
        "sound_speed" | "detonation_speed" => ("m/s", Units::velocity),
        "reference_rate" => ("1/s", Units::rate),
        "specific_heat" => ("J/(kg K)", Units::specific_heat),
        "room_temperature" | "melting_temperature" => ("K", |_, number| number),
        "a" | "b" | "energy" | "shear_modulus" | "yield_stress" | "hardening_modulus"
        | "spall_strength" => ("Pa", Units::stress),
        _ => ("", |_, number| number),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smpm::material::library::ALL;

    #[test]
    fn constants_of_the_library_have_the_units_of_their_names() {
        let units = Units::new(0.3, 2.0, 7.0).unwrap();
        for entry in ALL {
            let [of_si, of_units] = [Units::SI, units].map(entry.parameters);
            for ((name, in_si), (_, value)) in of_si.into_iter().zip(of_units) {
                let expected = unit(name).1(&units, in_si);
                let is_same = value.to_bits() == expected.to_bits();
                assert!(is_same || (value / expected - 1.0).abs() < 1e-15, "{name}");
            }
        }
    }
}
