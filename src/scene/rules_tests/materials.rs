//! Rules of the fluid and the materials.

use super::check;

#[test]
fn fluid_rules() {
    check(&[
        ("\"1 cP\"", "0", "`viscosity` must be positive", "0"),
        ("\"1 g/cm^3\"", "-1", "`density` must be positive", "-1"),
        (
            "\"2.2 GPa\"",
            "\"-2 GPa\"",
            "`bulk_modulus` must be positive",
            "\"-2 GPa\"",
        ),
        (
            "viscosity = \"1 cP\"",
            "",
            "`viscosity` is missing",
            "[fluid]",
        ),
        (
            "bulk_modulus = \"2.2 GPa\"",
            "",
            "storage by Eq. 38 needs `fluid.bulk_modulus`",
            "clay",
        ),
    ]);
}

#[test]
fn material_rules() {
    check(&[
        ("\"10 mD\"", "0", "`permeability` must be positive", "0"),
        ("\"1e-10 1/Pa\"", "-1", "`storage` must be positive", "-1"),
        (
            "storage = \"1e-10 1/Pa\"",
            "",
            "material `sand` has no storage",
            "sand",
        ),
        (
            "porosity = 0.2",
            "porosity = 0.2\nstorage = 1",
            "`storage` excludes `porosity`",
            "0.2",
        ),
        (
            "porosity = 0.2",
            "",
            "storage by Eq. 38 needs `porosity` too",
            "clay",
        ),
        (
            "porosity = 0.2",
            "porosity = -0.2",
            "`porosity` must lie between 0 and 1, found -0.2",
            "-0.2",
        ),
        (
            "biot_coefficient = 0.7",
            "biot_coefficient = 1.7",
            "`biot_coefficient` must lie between 0 and 1, found 1.7",
            "1.7",
        ),
        (
            "biot_coefficient = 0.7",
            "biot_coefficient = 0.1",
            "`biot_coefficient` must not be below `porosity` (Eq. 38)",
            "0.1",
        ),
        (
            "bulk_modulus = \"10 GPa\"",
            "bulk_modulus = 0",
            "`bulk_modulus` must be positive",
            "0",
        ),
        (
            "median = \"1 mD\"",
            "median = 0",
            "`median` must be positive",
            "0",
        ),
        (
            "log10_std = 0.5",
            "log10_std = -1",
            "`log10_std` must lie between 0 and 3, found -1",
            "-1",
        ),
        (
            "decades = 4",
            "decades = 0",
            "`decades` must lie between 0.001 and 22, found 0",
            "0",
        ),
        (
            "seed = 1 }",
            "correlation_length = 0 }",
            "`correlation_length` must be positive",
            "0",
        ),
        (
            "storage = \"1e-10 1/Pa\"",
            "storage = {distribution = \"log-normal\", median = -1, log10_std = 1}",
            "`median` must be positive",
            "-1",
        ),
        (
            "storage = \"1e-10 1/Pa\"",
            "storage = {distribution = \"log-normal\", median = \"1 m\", log10_std = 1}",
            "expected an inverse pressure (1/Pa), found a length: \"1 m\"",
            "\"1 m\"",
        ),
        (
            "porosity = 0.2",
            "porosity = {file = \"n.npy\", contrast = 0}",
            "`contrast` must be positive",
            "0",
        ),
        (
            "permeability = \"10 mD\"",
            "permeability = {file = \"k.txt\"}",
            "`file` must be a file ending in `npy`, `csv` or `vtu`",
            "\"k.txt\"",
        ),
        (
            "permeability = \"10 mD\"",
            "permeability = {file = \"k.npy\", column = \"k\"}",
            "a `.npy` file has no columns",
            "\"k\"",
        ),
        (
            "permeability = \"10 mD\"",
            "permeability = {flie = \"k.npy\"}",
            "`file`, `distribution`, `k1` or `xx` is missing",
            "{flie = \"k.npy\"}",
        ),
        (
            "permeability = \"10 mD\"",
            "permeability = {k1 = 1, k2 = 2, angle = 30}",
            "`angle` is more than a whole turn",
            "30",
        ),
        (
            "permeability = \"10 mD\"",
            "permeability = {k1 = 1, k2 = 0, angle = 0}",
            "`k2` must be positive",
            "0",
        ),
        (
            "permeability = \"10 mD\"",
            "permeability = {xx = 1, yy = 4, xy = -2}",
            "a permeability tensor needs xy² below xx yy",
            "-2",
        ),
        (
            "[materials.clay]\nregion",
            "[materials.clay]\n#",
            "only one material can go without a `region`",
            "clay",
        ),
        (
            "[materials.sand]",
            "[materials.\"a/b\"]",
            "the name `a/b` cannot be used in a file name",
            "\"a/b\"",
        ),
    ]);
}
