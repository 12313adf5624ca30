//! Storage of the saturated rock.

/// Storage coefficient in 1/Pa from porosity, Biot coefficient and the bulk moduli of the rock and
/// of the fluid in Pa (Eq. 38).
pub(crate) fn storage_coefficient(
    porosity: f64,
    biot_coefficient: f64,
    rock_bulk_modulus: f64,
    fluid_bulk_modulus: f64,
) -> f64 {
    (biot_coefficient - porosity) * (1.0 - biot_coefficient) / rock_bulk_modulus
        + porosity / fluid_bulk_modulus
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_in_a_porous_rock_by_hand() {
        // (0.7 − 0.2)(1 − 0.7)/10 GPa + 0.2/2 GPa
        let storage = storage_coefficient(0.2, 0.7, 1e10, 2e9);
        assert!((storage - 1.15e-10).abs() < 1e-24);
    }
}
