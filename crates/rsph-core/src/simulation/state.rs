//! The whole state of a simulation, out and in: with it a simulation of the same set-up goes on as if it
//! had never stopped, to the last bit.

use super::{Equilibrium, Plan, Simulation, integrator};
use crate::error::InvalidInput;
use crate::particles::{COLUMNS, Column, Field, Particles};
use crate::state::{State, Stateful, damaged};
use crate::tensor::Vec3;

/// Name of the array of a column.
fn name_of(column: &str) -> String {
    format!("particles/{column}")
}

impl Simulation {
    /// Everything that the future depends on, given the set-up that the simulation was made from. Loads that
    /// were replaced, forces that were put on it and probes that were added on the way are not part of it.
    pub fn state(&self) -> State {
        let mut state = State::default();
        let d = &self.description;
        state.put("body/sampled", [d.spacing, d.volume, d.shape_volume]);
        state.put_counts("body/particles", &[d.particles as u64]);
        state.put("time/now", [self.time, self.dt, d.dt, d.dt_limit]);
        state.put_counts("time/counts", &[self.steps, self.evaluations]);
        if let Some(p) = self.plan {
            state.put("time/plan", [p.from, p.to, p.dt]);
            state.put_counts("time/plan_steps", &[p.steps, p.done]);
        }
        for spec in COLUMNS.iter().filter(|c| self.particles.has(c.field)) {
            state.share(&name_of(spec.name), self.particles.column(spec.field).share());
        }
        if let Some(e) = &self.equilibrium {
            state.put_counts("equilibrium/counts", &[e.iterations as u64, e.steps as u64, e.applications]);
            state.put("equilibrium/sums", [e.residual, e.compliance]);
            state.put_vectors("equilibrium/forces", &[e.load, e.reaction]);
        }
        self.model.save(&mut state);
        self.integrator.save(&mut state);
        self.remeshing.save(&mut state);
        self.watch.save(&mut state);
        self.balance.save(&mut state);
        state
    }

    /// Takes back a state of a simulation of the same set-up. A simulation that fails to is of no use.
    ///
    /// # Errors
    /// A state of another body, or one that is damaged.
    pub fn set_state(&mut self, state: &State) -> Result<(), InvalidInput> {
        let d = &mut self.description;
        let sampled = [d.spacing, d.volume, d.shape_volume].map(f64::to_bits);
        let same = state.numbers("body/sampled")?.map(f64::to_bits) == sampled
            && state.counts("body/particles")? == [d.particles as u64];
        if !same {
            return Err(InvalidInput::new(
                "body",
                "",
                "the stored state is that of another body: its mesh has changed, or another program or \
                 processor has sampled it",
                "run from the start",
            ));
        }
        [self.time, self.dt, d.dt, d.dt_limit] = state.numbers("time/now")?;
        [self.steps, self.evaluations] = state.counts("time/counts")?;
        if !(self.dt.is_finite() && self.dt > 0.0 && self.time.is_finite()) {
            return Err(damaged("time/now", "is no time and time step"));
        }
        self.plan = if state.has("time/plan") {
            let [from, to, dt] = state.numbers("time/plan")?;
            let [steps, done] = state.counts("time/plan_steps")?;
            Some(Plan { from, to, dt, steps, done })
        } else {
            None
        };
        self.equilibrium = equilibrium(state)?;
        self.particles = particles(state, &self.particles)?;
        self.model.restore(state, &self.particles)?;
        self.integrator =
            integrator(&self.setup, &self.description, self.model.dynamics_mut(), &self.particles);
        self.integrator.restore(state)?;
        self.remeshing.restore(state)?;
        self.watch.restore_state(state, self.model.dynamics(), self.particles.len())?;
        self.balance.restore(state)
    }
}

fn equilibrium(state: &State) -> Result<Option<Equilibrium>, InvalidInput> {
    if !state.has("equilibrium/counts") {
        return Ok(None);
    }
    let [iterations, steps, applications] = state.counts("equilibrium/counts")?;
    let [residual, compliance] = state.numbers("equilibrium/sums")?;
    let forces: Vec<Vec3> = state.vectors("equilibrium/forces", 2)?;
    let (load, reaction) = (forces[0], forces[1]);
    let (iterations, steps) = (iterations as usize, steps as usize);
    Ok(Some(Equilibrium { iterations, steps, applications, residual, compliance, load, reaction }))
}

/// The stored particles, which have the columns of `like`.
fn particles(state: &State, like: &Particles) -> Result<Particles, InvalidInput> {
    let components = Field::Reference.spec().components;
    let reference = state.real(&name_of(Field::Reference.spec().name))?;
    let n = reference.len() / components;
    if n == 0 {
        return Err(damaged(&name_of(Field::Reference.spec().name), "holds no particle"));
    }
    let mut particles = Particles::new(n);
    for spec in COLUMNS.iter().filter(|c| like.has(c.field)) {
        let values = state.real_of(&name_of(spec.name), spec.components * n)?;
        if !values.iter().all(|x| x.is_finite()) {
            return Err(damaged(&name_of(spec.name), "holds a value that is not finite"));
        }
        particles.set(spec.field, Column::from_vec(values.to_vec(), n));
    }
    Ok(particles)
}
