//! One line to copy for every key, shown where a key is missing or of the wrong type.

/// Pairs of a key pattern (list entries as `[]`) and a line that is right there.
const EXAMPLES: &[(&str, &str)] = &[
    ("title", "title = \"Tensile test\""),
    ("units", "units = \"SI\""),
    ("body", "[body]\nshape = { organ = \"liver\" }\nparticles = 1000"),
    ("body.shape", "shape = { box = { size = [1.0, 1.0, 1.0] } }"),
    ("body.shape.box", "shape = { box = { size = [1.0, 1.0, 1.0] } }"),
    ("body.shape.box.size", "size = [1.0, 1.0, 1.0]"),
    ("body.shape.sphere", "shape = { sphere = { radius = 0.5 } }"),
    ("body.shape.cylinder", "shape = { cylinder = { radius = 0.5, height = 2.0, axis = \"z\" } }"),
    ("body.shape.organ", "shape = { organ = \"liver\" }"),
    ("body.shape.mesh", "shape = { mesh = { path = \"organ.stl\", scale = 0.001 } }"),
    ("body.shape.mesh.path", "path = \"organ.stl\""),
    ("body.labelmap", "labelmap = { path = \"segmentation.nii.gz\", label = 1 }"),
    ("body.labelmap.path", "path = \"segmentation.nii.gz\""),
    ("body.labelmap.label", "label = 1"),
    ("body.labelmap.labels", "labels = { 6 = \"parenchyma\", 7 = \"tumour\" }"),
    ("material.region", "region = { ball = { centre = [0.03, 0.02, 0.0], radius = 0.015 } }"),
    ("material.shape", "shape = { mesh = { path = \"tumour.stl\", scale = 0.001 } }"),
    ("material.name", "name = \"tumour\""),
    ("material.modulus", "modulus = { path = \"elastography.nii.gz\", factor = 1000.0 }"),
    ("material.fibres", "fibres = { rotation = { rate = [0.0, 0.0, 1.0] } }"),
    ("body.labelmap.axes", "axes = \"organ\""),
    ("body.spacing", "spacing = 0.01"),
    ("body.particles", "particles = 1000"),
    (
        "material",
        "[material]\nmodel = \"kelvin-voigt\"\ndensity = 1000.0\nyoung_modulus = 1e5\npoisson_ratio = 0.3\nrelaxation_time = 0.2",
    ),
    ("dynamics", "[dynamics]\nkind = \"prescribed\"\nvelocity = \"leveque\""),
    ("dynamics.kind", "kind = \"prescribed\""),
    ("dynamics.velocity", "velocity = \"leveque\""),
    ("dynamics.reversal", "reversal = 1.257"),
    ("dynamics.band", "band = 2.0"),
    ("dynamics.iso", "iso = 0.5"),
    ("initial", "[initial]\nvelocity = { constant = [0.0, 0.0, 1.0] }"),
    ("initial.velocity", "velocity = { constant = [0.0, 0.0, 1.0] }"),
    ("initial.displacement", "displacement = { constant = [0.0, 0.0, 0.1] }"),
    ("boundary", "[[boundary]]"),
    ("boundary[].kind", "kind = \"clamp\""),
    ("boundary[].region", "region = { plane = { axis = \"z\", at = 0.0, side = \"below\" } }"),
    ("boundary[].moment_about", "moment_about = [0.0, 0.0, 0.1]"),
    ("boundary[].fix", "fix = [\"x\", \"y\", \"z\"]"),
    ("boundary[].motion", "motion = { ramp = { displacement = [0.0, 0.0, 0.1], from = 0.0, to = 1.0 } }"),
    (
        "boundary[].motion.curve",
        "motion = { curve = { displacement = [0.0, 0.0, 0.1], time = [0.0, 1.0, 2.0], value = [0.0, 1.0, 0.0] } }",
    ),
    (
        "boundary[].motion.oscillation",
        "motion = { oscillation = { amplitude = [0.0, 0.0, 0.1], frequency = 2.0 } }",
    ),
    ("foundation", "[[foundation]]"),
    ("foundation[].region", "region = { plane = { axis = \"z\", at = 0.0, side = \"below\" } }"),
    ("foundation[].normal", "normal = 1e5"),
    ("foundation[].tangential", "tangential = 1e4"),
    ("load", "[[load]]"),
    ("load[].kind", "kind = \"traction\""),
    ("load[].region", "region = { plane = { axis = \"z\", at = 1.0, side = \"above\" } }"),
    ("load[].traction", "traction = [0.0, 0.0, 1.0]"),
    ("load[].pressure", "pressure = 270.0"),
    ("load[].acceleration", "acceleration = [0.0, -9.81, 0.0]"),
    ("load[].centre", "centre = \"upper-right\""),
    ("load[].radius", "radius = 0.037"),
    ("load[].direction", "direction = [0.0, -1.0, 0.0]"),
    ("load[].ramp", "ramp = { from = 0.0, to = 0.1 }"),
    (
        "load[].curve",
        "curve = { time = [0.0, 0.3, 0.8], value = [0.0, 1.0, 0.0], kind = \"smooth\", periodic = true }",
    ),
    ("load[].ramp.to", "ramp = { from = 0.0, to = 0.1 }"),
    ("solver", "[solver]\nformulation = \"adjoint\""),
    ("solver.formulation", "formulation = \"adjoint\""),
    ("solver.smoothing", "smoothing = 1.25"),
    ("solver.hourglass", "hourglass = 1.0"),
    ("time", "[time]\nuntil = 3.0"),
    ("time.integrator", "integrator = \"rk4\""),
    ("time.dt", "dt = \"auto\""),
    ("time.until", "until = 3.0"),
    ("time.allow_unstable", "allow_unstable = false"),
    ("remesh", "[remesh]\nevery = 0"),
    ("remesh.every", "every = 0"),
    ("remesh.kernel", "kernel = \"m4-prime\""),
    ("output", "[output]\nevery = 0.05"),
    ("output.every", "every = 0.05"),
    ("output.fields", "fields = [\"principal_strain\", \"max_shear_stress\"]"),
    ("probe", "[[probe]]"),
    ("gauge", "[[gauge]]"),
    ("gauge[].name", "name = \"fibre\""),
    ("gauge[].from", "from = [0.0, 0.0, 0.0]"),
    ("gauge[].to", "to = [0.0, 0.0, 0.1]"),
    ("probe[].name", "name = \"extension\""),
    ("probe[].quantity", "quantity = \"displacement.z\""),
    ("probe[].region", "region = { plane = { axis = \"z\", at = 1.0, side = \"above\" } }"),
];

/// Lines for the parts of a region, by the last key.
const REGION_EXAMPLES: &[(&str, &str)] = &[
    ("plane", "region = { plane = { axis = \"z\", at = 0.0, side = \"below\" } }"),
    ("half_space", "region = { half_space = { point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] } }"),
    ("box", "region = { box = { min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 0.5] } }"),
    ("ball", "region = { ball = { centre = [0.0, 0.0, 0.0], radius = 0.1 } }"),
    (
        "surface_patch",
        "region = { surface_patch = { centre = [0.0, 0.0, 1.0], radius = 0.1, facing = [0.0, 0.0, 1.0] } }",
    ),
    ("part", "region = { part = \"falciform_ligament\" }"),
    ("point", "region = { point = [0.5, 0.5, 1.0] }"),
    (
        "and",
        "region = { and = [{ ball = { centre = [0.0, 0.0, 0.0], radius = 0.1 } }, { not = { point = [0.0, 0.0, 0.0] } }] }",
    ),
];

/// A line that is right at the key `path` (displayed form), or at the nearest key that holds it.
pub(super) fn example(path: &str) -> Option<&'static str> {
    let pattern: String = path.chars().filter(|c| !c.is_ascii_digit()).collect();
    if pattern.contains(".region.") {
        let known = pattern.rsplit(['.', '[']).find_map(|k| find(REGION_EXAMPLES, k));
        if known.is_some() {
            return known;
        }
    }
    let mut pattern = pattern.as_str();
    loop {
        if let Some(line) = find(EXAMPLES, pattern) {
            return Some(line);
        }
        pattern = &pattern[..pattern.rfind(['.', '['])?];
    }
}

fn find(table: &[(&str, &'static str)], key: &str) -> Option<&'static str> {
    table.iter().find(|(k, _)| *k == key).map(|(_, line)| *line)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_holder_gives_the_example() {
        assert_eq!(example("time.until"), Some("until = 3.0"));
        assert_eq!(example("load[3].traction[1]"), Some("traction = [0.0, 0.0, 1.0]"));
        assert!(example("boundary[0].region.and[1].ball.radius").unwrap().contains("ball"));
        assert_eq!(example("nonsense"), None);
    }

    #[test]
    fn every_example_is_toml() {
        for (key, line) in EXAMPLES.iter().chain(REGION_EXAMPLES) {
            assert!(line.parse::<toml::Table>().is_ok(), "{key}: {line}");
        }
    }
}
