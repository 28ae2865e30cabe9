//! Every law of the registry: a new one is tested by being there.

mod common;

use common::every_law;
use nalgebra::Rotation3;
use proptest::prelude::*;
use rsph_core::material::{FiniteStrain, Law, Material};
use rsph_core::tensor::lanes::{MAX_LANES, Tensors};
use rsph_core::tensor::{Mat3, SymTensor, Vec3};

/// Calls `test` with every law for any deformation.
fn for_finite_strain(mut test: impl FnMut(&dyn Material, &dyn FiniteStrain)) -> usize {
    let mut count = 0;
    for material in every_law(10.0) {
        if let Law::FiniteStrain(law) = material.law() {
            test(&*material, law);
            count += 1;
        }
    }
    count
}

fn matrix(size: f64) -> impl Strategy<Value = Mat3> {
    prop::array::uniform9(-size..size).prop_map(|m| Mat3::from_row_slice(&m))
}

proptest! {
    #[test]
    fn stress_and_tangent_are_derivatives(g in matrix(0.25), d in matrix(1.0)) {
        let (f, e) = (Mat3::identity() + g, 1e-5);
        prop_assume!(f.determinant() > 0.2);
        for_finite_strain(|material, law| {
            let slope = (law.energy(&(f + d * e)) - law.energy(&(f - d * e))) / (2.0 * e);
            let p = law.first_piola(&f);
            let name = material.name();
            assert!((slope - p.dot(&d)).abs() < 1e-6 * (1.0 + p.norm()), "{name}: {slope} {}", p.dot(&d));
            let dp = (law.first_piola(&(f + d * e)) - law.first_piola(&(f - d * e))) / (2.0 * e);
            let tangent = law.tangent(&f, &d);
            assert!((dp - tangent).norm() < 1e-6 * (1.0 + tangent.norm()), "{name}");
        });
    }

    #[test]
    fn several_particles_at_once_are_as_one_by_one(
        g in prop::collection::vec(matrix(0.25), MAX_LANES), rate in prop::collection::vec(matrix(1.0), MAX_LANES)
    ) {
        let [mut f, mut df, mut piola, mut change] = [Tensors::ZERO; 4];
        for (lane, (g, rate)) in g.iter().zip(&rate).enumerate() {
            prop_assume!((Mat3::identity() + g).determinant() > 0.2);
            f.set(lane, &(Mat3::identity() + g));
            df.set(lane, rate);
        }
        let shares = [0.7, 0.3];
        for_finite_strain(|material, law| {
            law.stresses(2, &f, Some(&df), &mut piola);
            law.tangents(2, &f, &df, shares, &mut change);
            for lane in 0..2 {
                let (f, df, name) = (f.get(lane), df.get(lane), material.name());
                let damping = law.viscous_piola(&f, &df);
                let stress = law.first_piola(&f) + damping;
                assert!((piola.get(lane) - stress).norm() < 1e-11 * (1.0 + stress.norm()), "{name}");
                let tangent = law.tangent(&f, &df) * shares[0] + damping * shares[1];
                assert!((change.get(lane) - tangent).norm() < 1e-11 * (1.0 + tangent.norm()), "{name}");
            }
        });
    }

    #[test]
    fn the_tangent_is_symmetric(g in matrix(0.25), a in matrix(1.0), b in matrix(1.0)) {
        let f = Mat3::identity() + g;
        prop_assume!(f.determinant() > 0.2);
        for_finite_strain(|material, law| {
            let (ab, ba) = (a.dot(&law.tangent(&f, &b)), b.dot(&law.tangent(&f, &a)));
            assert!((ab - ba).abs() < 1e-11 * (1.0 + ab.abs()), "{}", material.name());
        });
    }

    #[test]
    fn a_rotation_turns_the_stress_and_costs_nothing(
        g in matrix(0.25), rate in matrix(1.0), turn in prop::array::uniform3(-3.0..3.0_f64)
    ) {
        let (f, q) = (Mat3::identity() + g, *Rotation3::new(Vec3::from(turn)).matrix());
        prop_assume!(f.determinant() > 0.2);
        for_finite_strain(|material, law| {
            let name = material.name();
            assert!((law.energy(&(q * f)) - law.energy(&f)).abs() < 1e-10, "{name}");
            assert!((law.first_piola(&(q * f)) - q * law.first_piola(&f)).norm() < 1e-9, "{name}");
            // d(QF)/dt = Q (dF/dt + W F) with any spin W: the damping sees dF/dt only.
            let spin = 0.5 * (rate - rate.transpose());
            let turned = law.viscous_piola(&(q * f), &(q * (rate + spin * f)));
            let difference = (turned - q * law.viscous_piola(&f, &rate)).norm();
            assert!(difference < 1e-9 * (1.0 + turned.norm()), "{name}");
        });
    }

    #[test]
    fn damping_takes_energy(g in matrix(0.3), rate in matrix(2.0)) {
        let f = Mat3::identity() + g;
        prop_assume!(f.determinant() > 0.1);
        for_finite_strain(|material, law| {
            assert!(law.viscous_piola(&f, &rate).dot(&rate) >= 0.0, "{}", material.name());
        });
    }

    #[test]
    fn small_strain_is_the_linear_law_of_its_stiffness(g in matrix(1e-6), rate in matrix(1e-6)) {
        for_finite_strain(|material, law| {
            let f = Mat3::identity() + g;
            let p = law.first_piola(&f) + law.viscous_piola(&f, &rate);
            let e = SymTensor::symmetric_part(&(g + rate * material.relaxation_time()));
            let linear = material.stiffness().stress(e).to_matrix();
            assert!((p - linear).norm() < 1e-9, "{}: {}", material.name(), (p - linear).norm());
        });
    }
}

#[test]
fn every_law_has_an_undeformed_state_without_stress_or_energy() {
    for material in every_law(10.0) {
        let none = Mat3::zeros();
        let (strain, stress) = material.law().measures(material.relaxation_time(), &none, &none);
        assert!(strain.0.iter().chain(&stress.0).all(|s| s.abs() < 1e-14), "{}", material.name());
        assert!(material.young_modulus() > 0.0 && material.p_wave_modulus() >= material.shear_modulus());
        let symmetric = |i: usize, j: usize| material.stiffness().0[i][j] - material.stiffness().0[j][i];
        assert!((0..36).all(|k| symmetric(k / 6, k % 6).abs() < 1e-12), "{}", material.name());
    }
    let turned_inside_out = |law: &dyn FiniteStrain| law.energy(&-Mat3::identity()).is_infinite();
    assert!(for_finite_strain(|m, law| assert!(turned_inside_out(law), "{}", m.name())) >= 3);
}

/// Moduli of the laws made with E = 10: mu and lambda.
const MU: f64 = 10.0 / 2.6;
const LAMBDA: f64 = 0.3 * 10.0 / (1.3 * 0.4);

fn law_named(name: &str, test: impl Fn(&dyn FiniteStrain)) {
    let found = for_finite_strain(|material, law| {
        if material.name() == name {
            test(law);
        }
    });
    assert!(found > 0);
}

#[test]
fn neo_hookean_by_hand() {
    law_named("neo-hookean", |law| {
        // Uniaxial stretch without contraction: P_xx = mu (s - 1/s) + lambda ln s / s, P_yy = lambda ln s.
        let s = 1.4_f64;
        let p = law.first_piola(&Mat3::from_diagonal(&Vec3::new(s, 1.0, 1.0)));
        assert!((p[(0, 0)] - (MU * (s - 1.0 / s) + LAMBDA * s.ln() / s)).abs() < 1e-12);
        assert!((p[(1, 1)] - LAMBDA * s.ln()).abs() < 1e-12);
        // Simple shear keeps the volume: sigma = mu (F F^T - 1).
        let mut f = Mat3::identity();
        f[(0, 1)] = 1.0;
        let sigma = law.first_piola(&f) * f.transpose();
        assert!((sigma - Mat3::new(MU, MU, 0.0, MU, 0.0, 0.0, 0.0, 0.0, 0.0)).norm() < 1e-12);
    });
}

#[test]
fn st_venant_kirchhoff_by_hand() {
    law_named("st-venant-kirchhoff", |law| {
        let s = 1.4_f64;
        let e = 0.5 * (s * s - 1.0);
        let p = law.first_piola(&Mat3::from_diagonal(&Vec3::new(s, s, 1.0)));
        assert!((p[(0, 0)] - s * (2.0 * MU + 2.0 * LAMBDA) * e).abs() < 1e-12);
        assert!((p[(2, 2)] - 2.0 * LAMBDA * e).abs() < 1e-12);
    });
}

#[test]
fn corotated_by_hand() {
    law_named("corotated", |law| {
        let (turn, s) = (*Rotation3::new(Vec3::new(0.3, -1.1, 2.0)).matrix(), 1.4);
        let p = law.first_piola(&(turn * Mat3::from_diagonal(&Vec3::new(s, 1.0, 1.0))));
        let unturned = turn.transpose() * p;
        assert!((unturned[(0, 0)] - (2.0 * MU + LAMBDA) * (s - 1.0)).abs() < 1e-12);
        assert!((unturned[(1, 1)] - LAMBDA * (s - 1.0)).abs() < 1e-12);
        assert!(unturned[(0, 1)].abs() < 1e-12);
    });
}
