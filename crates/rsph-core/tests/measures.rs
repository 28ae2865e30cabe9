//! Measures of deformation and stress, on particles, on the surface and by probes, against closed forms.

use rsph_core::material::{KelvinVoigt, Material, NeoHookean};
use rsph_core::measures::MEASURES;
use rsph_core::particles::Field;
use rsph_core::region::Region;
use rsph_core::sample::Resolution;
use rsph_core::setup::{Formulation, Gauge, Probe, Quantity, RemeshTrigger, Setup, SolidSetup, VectorField};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{Mat3, SymTensor, Vec3};
use std::sync::Arc;

/// A free cube that starts with u = (F - 1) X.
fn deformed(material: Arc<dyn Material>, f: &Mat3) -> Setup<SolidSetup> {
    let cube = Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap());
    let mut setup = Setup::new(cube, Resolution::Spacing(0.2), SolidSetup::new(material));
    let gradient = f - Mat3::identity();
    setup.initial.displacement = VectorField::Affine { constant: Vec3::zeros(), gradient };
    setup.fields = MEASURES.to_vec();
    setup
}

/// Every measure of a homogeneous deformation at large strain, by the law's own functions.
#[test]
fn a_homogeneous_deformation_has_its_measures_everywhere() {
    let f = Mat3::new(1.3, 0.5, 0.0, -0.2, 0.9, 0.1, 0.05, 0.0, 1.1);
    let law = NeoHookean::new(1.0, 100.0, 0.3, 0.0).unwrap();
    let piola = law.law().finite_strain().unwrap().first_piola(&f);
    let cauchy = piola * f.transpose() / f.determinant();
    let second = f.try_inverse().unwrap() * piola;
    let symmetric = |m: &Mat3| SymTensor::symmetric_part(m).0.to_vec();
    let mut stresses: Vec<f64> = cauchy.symmetric_eigenvalues().iter().copied().collect();
    stresses.sort_by(|a, b| b.total_cmp(a));
    let mut stretches: Vec<f64> = f.singular_values().iter().copied().collect();
    stretches.sort_by(|a, b| b.total_cmp(a));
    let strains: Vec<f64> = stretches.iter().map(|s| s.ln()).collect();
    let expected = [
        (Field::DeformationGradient, f.transpose().as_slice().to_vec()),
        (Field::VolumeRatio, vec![f.determinant()]),
        (Field::GreenLagrangeStrain, symmetric(&(0.5 * (f.transpose() * f - Mat3::identity())))),
        (Field::PrincipalStretch, stretches),
        (Field::MaxShearStrain, vec![0.5 * (strains[0] - strains[2])]),
        (Field::PrincipalStrain, strains),
        (Field::MaxShearStress, vec![0.5 * (stresses[0] - stresses[2])]),
        (Field::PrincipalStress, stresses),
        (Field::Pressure, vec![-cauchy.trace() / 3.0]),
        (Field::FirstPiolaStress, piola.transpose().as_slice().to_vec()),
        (Field::SecondPiolaStress, symmetric(&second)),
    ];
    let mut setup = deformed(Arc::new(law), &f);
    let quantity = Quantity::parse("principal_stress.3").unwrap();
    setup.probes = vec![Probe { name: "p".into(), quantity, region: Region::All }];
    let mut cube = Simulation::new(setup).unwrap();
    let snapshot = cube.snapshot();
    for (field, expected) in &expected {
        let column = snapshot.column(*field);
        assert_eq!(column.components(), expected.len(), "{field:?}");
        for (c, expected) in expected.iter().enumerate() {
            for value in column.component(c) {
                assert!(
                    (value - expected).abs() < 1e-9 * (1.0 + expected.abs()),
                    "{field:?} {c}: {value} {expected}"
                );
            }
        }
    }
    // Hencky's strain is the strain of such a law, and its principal values and directions make it up.
    let (hencky, strain) = (snapshot.column(Field::HenckyStrain), snapshot.column(Field::Strain));
    let direction = [Field::PrincipalDirection1, Field::PrincipalDirection2, Field::PrincipalDirection3];
    for a in 0..snapshot.len() {
        let values = snapshot.column(Field::PrincipalStrain).vector(a);
        let sum: Mat3 = (0..3)
            .map(|k| {
                let n = snapshot.column(direction[k]).vector(a);
                n * n.transpose() * values[k]
            })
            .sum();
        assert!((sum - strain.tensor(a).to_matrix()).amax() < 1e-9);
        assert!((hencky.tensor(a).to_matrix() - strain.tensor(a).to_matrix()).amax() < 1e-12);
    }
    let smallest = snapshot.column(Field::PrincipalStress).component(2)[0];
    assert!((cube.readings()[0].value - smallest).abs() < 1e-9 * smallest.abs());
}

#[test]
fn the_surface_has_the_measures_of_its_own_strain_and_stress() {
    for material in [
        Arc::new(NeoHookean::new(1.0, 100.0, 0.3, 0.0).unwrap()) as Arc<dyn Material>,
        Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.0).unwrap()),
    ] {
        let f = Mat3::identity() + Mat3::new(0.03, 0.01, 0.0, 0.0, 0.02, 0.0, 0.01, 0.0, -0.01);
        let mut cube = Simulation::new(deformed(Arc::clone(&material), &f)).unwrap();
        let snapshot = cube.snapshot();
        let surface = cube.surface(&snapshot);
        let values = |name: &str| surface.field(name).unwrap().values.as_slice();
        let (strain, stress) = (values("strain"), values("stress"));
        for v in 0..surface.mesh.vertices.len() {
            let [e, s] = [strain, stress].map(|field| &field[6 * v..][..6]);
            let principal: f64 = values("principal_strain")[3 * v..][..3].iter().sum();
            assert!((principal - e[0] - e[1] - e[2]).abs() < 1e-12, "{}", material.name());
            assert!((values("pressure")[v] + (s[0] + s[1] + s[2]) / 3.0).abs() < 1e-9);
            // The free surface carries no traction, P n = 0, and det F belongs to the strain there.
            let volume = if material.name() == "neo-hookean" { principal.exp() } else { 1.0 + principal };
            assert!(
                (values("volume_ratio")[v] - volume).abs()
                    < 2e-3 * f64::from(u8::from(material.name() != "neo-hookean")) + 1e-9
            );
        }
    }
}

#[test]
fn measures_are_there_only_where_they_are_asked_for() {
    let material = || -> Arc<dyn Material> { Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.1).unwrap()) };
    let mut setup = deformed(material(), &Mat3::identity());
    setup.fields = vec![Field::VolumeRatio];
    let mut cube = Simulation::new(setup.clone()).unwrap();
    let names: Vec<&str> = cube.snapshot().columns().map(|(spec, _)| spec.name).collect();
    assert!(names.contains(&"volume_ratio") && names.contains(&"stress") && !names.contains(&"pressure"));
    setup.fields = vec![Field::Stress];
    assert_eq!(Simulation::new(setup.clone()).unwrap_err().key, "output.fields");
    setup.fields = vec![Field::VolumeRatio];
    setup.solver.formulation = Formulation::Paper;
    assert_eq!(Simulation::new(setup.clone()).unwrap_err().key, "output.fields");
    setup.fields = Vec::new();
    let quantity = Quantity::parse("pressure").unwrap();
    setup.probes = vec![Probe { name: "p".into(), quantity, region: Region::All }];
    assert_eq!(Simulation::new(setup).unwrap_err().key, "probe[0].quantity");
}

/// A rigid turn by 40 degrees that is remeshed: the deformation gradient stays that turn.
#[test]
fn the_deformation_gradient_goes_through_a_remesh() {
    let turn = *nalgebra::Rotation3::new(Vec3::new(0.0, 0.0, 0.7)).matrix();
    let mut setup = deformed(Arc::new(NeoHookean::new(1.0, 100.0, 0.3, 0.0).unwrap()), &turn);
    setup.remesh.trigger = RemeshTrigger::Steps(1000);
    let mut cube = Simulation::new(setup).unwrap();
    cube.remesh().unwrap();
    let snapshot = cube.snapshot();
    let f = snapshot.column(Field::DeformationGradient);
    for a in 0..snapshot.len() {
        let found = Mat3::from_fn(|i, j| f.component(3 * i + j)[a]);
        assert!((found - turn).amax() < 1e-3, "{found}");
    }
    for value in snapshot.column(Field::PrincipalStretch).values() {
        assert!((value - 1.0).abs() < 1e-3);
    }
}

#[test]
fn a_gauge_reads_the_change_of_a_distance_before_and_after_a_remesh() {
    let f = Mat3::new(1.3, 0.5, 0.0, -0.2, 0.9, 0.1, 0.05, 0.0, 1.1);
    let (from, to) = (Vec3::new(0.13, 0.4, 0.1), Vec3::new(0.77, 0.2, 1.0));
    let mut setup = deformed(Arc::new(NeoHookean::new(1.0, 100.0, 0.3, 0.0).unwrap()), &f);
    setup.gauges = vec![Gauge { name: "fibre".into(), from, to }];
    setup.remesh.trigger = RemeshTrigger::Steps(1000);
    let mut cube = Simulation::new(setup.clone()).unwrap();
    let (before, after) = ((to - from).norm(), (f * (to - from)).norm());
    for tolerance in [1e-12, 1e-3] {
        let readings = cube.readings();
        assert_eq!([&*readings[0].name, &*readings[1].name], ["fibre_strain", "fibre_length"]);
        assert!((readings[0].value - (after / before - 1.0)).abs() < tolerance, "{readings:?}");
        assert!((readings[1].value - after).abs() < tolerance, "{readings:?}");
        cube.remesh().unwrap();
    }
    setup.gauges[0].to.x = 1.5;
    let error = Simulation::new(setup.clone()).unwrap_err();
    assert_eq!(error.key, "gauge[0].to");
    assert!(error.problem.contains("lies 0.5000 outside"), "{}", error.problem);
    setup.gauges[0].to = from;
    assert_eq!(Simulation::new(setup).unwrap_err().key, "gauge[0].to");
}
