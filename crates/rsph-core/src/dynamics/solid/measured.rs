//! Measures of deformation and stress of every particle, where they are asked for.

use super::Solid;
use crate::measures::LocalState;
use crate::ops::PAIR_COMPONENTS;
use crate::particles::{Column, Field, Particles};
use crate::tensor::{Mat3, SymTensor};
use std::sync::Arc;

impl Solid {
    /// Sets those of the [measures](crate::measures::MEASURES) at time `t`, with the strain and the stress of all particles, component by
    /// component.
    pub(super) fn set_measures(
        &mut self,
        t: f64,
        wanted: &[Field],
        [strain, stress]: [&[f64]; 2],
        particles: &mut Particles,
    ) {
        let n = self.len();
        let u = particles.column(Field::Displacement).clone();
        self.spread_displacement(t, u.values());
        let (is_linear, materials) = (self.is_linear(), Arc::clone(&self.materials));
        self.visit_sums(false, |a, _, sums| {
            let (mut g, plain) = (sums.deformation, &sums.gradient);
            if is_linear {
                // Only the strain is corrected near the surface.
                g = 0.5 * (g + g.transpose()) + 0.5 * (plain - plain.transpose());
            }
            let g = materials.larger_layer(a, &g);
            let mut out = [0.0; PAIR_COMPONENTS];
            out[..9].copy_from_slice(g.transpose().as_slice());
            out
        });
        let gradient = self.gather_pair(0..9);
        let tensor = |values: &[f64], a: usize| SymTensor(std::array::from_fn(|c| values[c * n + a]));
        let state = |a: usize| LocalState {
            deformation: Mat3::from_fn(|i, j| f64::from(u8::from(i == j)) + gradient[(3 * i + j) * n + a]),
            strain: tensor(strain, a),
            stress: tensor(stress, a),
            is_small_strain: self.materials.is_small_strain(a),
        };
        for field in wanted {
            let components = field.spec().components;
            let (mut column, mut values) = (vec![0.0; components * n], Vec::with_capacity(components));
            for a in 0..n {
                values.clear();
                state(a).put(*field, &mut values);
                values.iter().enumerate().for_each(|(c, value)| column[c * n + a] = *value);
            }
            particles.set(*field, Column::from_vec(column, n));
        }
    }
}
