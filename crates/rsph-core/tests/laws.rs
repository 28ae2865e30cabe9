//! Every law of the registry: a new one is tested by being there.

mod common;

use common::{FIBRE, every_law};
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

/// The law with fibres, which have no stiffness where they are slack.
const FIBRES: &str = "holzapfel-gasser-ogden";

/// Whether the fibres begin to be stretched there, where the tangent jumps.
fn is_at_the_kink(material: &dyn Material, f: &Mat3) -> bool {
    let (a, dispersion) = (Vec3::from(FIBRE), 0.1);
    let square = dispersion * f.norm_squared() + (1.0 - 3.0 * dispersion) * (f * a).norm_squared();
    material.name() == FIBRES && (square * f.determinant().powf(-2.0 / 3.0) - 1.0).abs() < 1e-3
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
            if is_at_the_kink(material, &f) {
                return;
            }
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
            // Only the ground between the fibres is damped.
            let rate = if material.name() == FIBRES { Mat3::zeros() } else { rate };
            let errors = [g, -g].map(|g| {
                let f = Mat3::identity() + g;
                let p = law.first_piola(&f) + law.viscous_piola(&f, &rate);
                let e = SymTensor::symmetric_part(&(g + rate * material.relaxation_time()));
                (p - material.stiffness().stress(e).to_matrix()).norm()
            });
            // Fibres are stretched by the one or by the other.
            let worst = if material.name() == FIBRES { f64::min } else { f64::max };
            assert!(worst(errors[0], errors[1]) < 1e-9, "{}: {errors:?}", material.name());
        });
    }
}

#[test]
fn every_law_has_an_undeformed_state_without_stress_or_energy() {
    for material in every_law(10.0) {
        let none = Mat3::zeros();
        let (strain, stress) = material.law().measures(material.relaxation_time(), &none, &none);
        assert!(strain.0.iter().chain(&stress.0).all(|s| s.abs() < 1e-14), "{}: {stress:?}", material.name());
        assert!(material.young_modulus() > 0.0 && material.p_wave_modulus() >= material.shear_modulus());
        // A shear strain counts twice in its energy.
        let twice = |i: usize| if i < 3 { 1.0 } else { 2.0 };
        let c = material.stiffness().0;
        let symmetric = |i: usize, j: usize| twice(i) * c[i][j] - twice(j) * c[j][i];
        assert!((0..36).all(|k| symmetric(k / 6, k % 6).abs() < 1e-12), "{}: {c:?}", material.name());
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

/// Shear modulus of the laws of tissue that are made with E = 10.
const TISSUE_MU: f64 = 10.0 / 2.6;

/// Differences of principal Cauchy stresses of deformations that keep the volume, and the shear stress, against the closed forms
/// of an incompressible solid with these slopes of w at (I1, I2).
fn closed_forms(name: &str, slopes: impl Fn(f64, f64) -> [f64; 2]) {
    law_named(name, |law| {
        let cauchy = |f: &Mat3| law.first_piola(f) * f.transpose() / f.determinant();
        let diagonal = |a: f64, b: f64, c: f64| {
            let sigma = cauchy(&Mat3::from_diagonal(&Vec3::new(a, b, c)));
            let [x, y, z] = [a * a, b * b, c * c];
            let [w1, w2] = slopes(x + y + z, x * y + y * z + z * x);
            (sigma[(0, 0)] - sigma[(2, 2)], w1, w2)
        };
        let close = |found: f64, exact: f64| {
            assert!((found - exact).abs() < 1e-12 * (1.0 + exact.abs()), "{name}: {found} {exact}");
        };
        for s in [0.7_f64, 1.2, 1.8] {
            let (uniaxial, w1, w2) = diagonal(s, s.powf(-0.5), s.powf(-0.5));
            close(uniaxial, 2.0 * (s * s - 1.0 / s) * (w1 + w2 / s));
            let (equibiaxial, w1, w2) = diagonal(s, s, s.powi(-2));
            close(equibiaxial, 2.0 * (s * s - s.powi(-4)) * (w1 + w2 * s * s));
            let (planar, w1, w2) = diagonal(s, 1.0, 1.0 / s);
            close(planar, 2.0 * (s * s - s.powi(-2)) * (w1 + w2));
            let mut f = Mat3::identity();
            f[(0, 1)] = s;
            let [w1, w2] = slopes(3.0 + s * s, 3.0 + s * s);
            close(cauchy(&f)[(0, 1)], 2.0 * s * (w1 + w2));
        }
        // The volume: sigma = K ln J / J 1.
        let bulk_modulus = TISSUE_MU * 2.0 * 1.3 / (3.0 * 0.4);
        let sigma = cauchy(&(Mat3::identity() * 1.1));
        close(sigma[(0, 0)], bulk_modulus * 3.0 * 1.1_f64.ln() / 1.1_f64.powi(3));
    });
}

#[test]
fn tissue_has_its_closed_forms() {
    let mu = TISSUE_MU;
    closed_forms("mooney-rivlin", |_, _| [0.3 * mu, 0.2 * mu]);
    closed_forms("yeoh", |i1, _| [mu * (0.5 + 0.2 * (i1 - 3.0) + 0.3 * (i1 - 3.0).powi(2)), 0.0]);
    closed_forms("veronda-westmann", |i1, _| [mu * (2.0 * (i1 - 3.0)).exp(), -0.5 * mu]);
    closed_forms("fung", |i1, _| [0.5 * mu * (1.5 * (i1 - 3.0)).exp(), 0.0]);
}

#[test]
fn ogden_by_hand() {
    law_named("ogden", |law| {
        for s in [0.7_f64, 1.0, 1.5] {
            let f = Mat3::from_diagonal(&Vec3::new(s, s.powf(-0.5), s.powf(-0.5)));
            let sigma = law.first_piola(&f) * f.transpose();
            let term = |mu: f64, a: f64| 2.0 * mu / a * (s.powf(a) - s.powf(-0.5 * a));
            let exact = term(0.7 * TISSUE_MU, 3.0) + term(0.3 * TISSUE_MU, -2.5);
            assert!((sigma[(0, 0)] - sigma[(1, 1)] - exact).abs() < 1e-12 * (1.0 + exact.abs()));
        }
    });
}

#[test]
fn fibres_by_hand() {
    law_named(FIBRES, |law| {
        let a = Vec3::from(FIBRE);
        for s in [0.8_f64, 1.3] {
            // A stretch along both families, across it by the root of its inverse.
            let across = s.powf(-0.5);
            let f = Mat3::identity() * across + a * a.transpose() * (s - across);
            let sigma = law.first_piola(&f) * f.transpose();
            let side = a.cross(&Vec3::z());
            let found = a.dot(&(sigma * a)) - side.dot(&(sigma * side));
            let (i1, kappa) = (s * s + 2.0 / s, 0.1);
            let e: f64 = (kappa * (i1 - 3.0) + (1.0 - 3.0 * kappa) * (s * s - 1.0)).max(0.0);
            let pull = 2.0 * 0.2 * TISSUE_MU * e * (e * e).exp();
            let exact = (s * s - 1.0 / s) * (TISSUE_MU + 2.0 * kappa * pull)
                + 2.0 * (1.0 - 3.0 * kappa) * pull * s * s;
            assert!((found - exact).abs() < 1e-12 * (1.0 + exact.abs()), "{found} {exact}");
        }
    });
}
