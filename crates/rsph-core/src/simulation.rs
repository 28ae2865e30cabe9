//! A running simulation: the step, with its integration in time, balances, watchdog and remeshing.
//! What kind of body moves is behind [`model`].

mod balance;
mod checks;
mod extremes;
mod fsi_1d;
mod holds;
mod interactive;
mod model;
mod prescribed;
mod remeshing;
mod solid;
mod state;
mod statics;
mod time_step;

pub use crate::boundary::reaction::Reaction;
pub use crate::observe::Reading;
pub use balance::Conservation;
pub use extremes::{Extreme, Extremes};
pub use prescribed::VOLUME_INSIDE;
pub use remeshing::{RemeshLog, Sums};
pub use statics::Equilibrium;

use crate::dynamics::{Dynamics, Energy, ForceSums, Scales};
use crate::error::{Failure, FailureKind, InvalidInput};
use crate::integrate::chebyshev::RungeKuttaChebyshev;
use crate::integrate::implicit::{self, Implicit};
use crate::integrate::{Integrator, RungeKutta4};
use crate::particles::{Field, Particles};
use crate::pool::awake;
use crate::setup::{Gauge, Integration, Load, Mechanics, RemeshTrigger, Scheme, Setup, SolidSetup, TimeStep};
use crate::snapshot::Snapshot;
use crate::stability::step_limit;
use crate::surface::Surface;
use crate::tensor::{Mat3, Vec3};
use crate::watchdog::{Check, Watchdog};
use balance::Balance;
use fsi_1d::FluidBesideSolid;
use model::{Model, Moment, Parts};
use prescribed::PrescribedBody;
use remeshing::Remeshing;
use solid::SolidBody;
use time_step::choose_pace;

/// A reading that a kind of body adds to those of its probes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnReading {
    /// Its name.
    pub name: String,
    /// What it reads, with `.x` and so on for a component.
    pub quantity: String,
    /// SI unit.
    pub unit: &'static str,
}

impl OwnReading {
    /// A reading that says in its name what it is.
    fn new(name: &str, unit: &'static str) -> Self {
        Self { name: name.into(), quantity: name.into(), unit }
    }

    /// What a strain gauge reads.
    fn of_gauge(gauge: &Gauge) -> [Self; 2] {
        [("strain", "strain of gauges", "1"), ("length", "length of gauges", "m")].map(
            |(what, quantity, unit)| Self {
                name: format!("{}_{what}", gauge.name),
                quantity: quantity.into(),
                unit,
            },
        )
    }
}

/// The readings that gauges and a kind of body add to those of its probes, in order.
pub fn own_readings(mechanics: &Mechanics, gauges: &[Gauge], trigger: RemeshTrigger) -> Vec<OwnReading> {
    let volume = OwnReading::new(VOLUME_INSIDE, "m^3");
    match mechanics {
        Mechanics::Solid(solid) => {
            let of_gauges = gauges.iter().flat_map(OwnReading::of_gauge);
            let of_boundaries = solid.boundaries.iter().flat_map(holds::readings_of);
            of_gauges
                .chain(of_boundaries)
                .chain((trigger != RemeshTrigger::Never).then_some(volume))
                .collect()
        }
        Mechanics::Prescribed(_) => vec![volume],
        Mechanics::Interaction(_) => {
            fsi_1d::READINGS.iter().map(|(name, unit)| OwnReading::new(name, unit)).collect()
        }
    }
}

/// What is known of a simulation before its first step.
#[derive(Clone, Debug)]
pub struct Description {
    /// Number of particles.
    pub particles: usize,
    /// Spacing dx.
    pub spacing: f64,
    /// Smoothing length h.
    pub smoothing_length: f64,
    /// Neighbours of an inner particle.
    pub neighbours: usize,
    /// Scheme of integration, never `Auto`.
    pub scheme: Scheme,
    /// Why this scheme, if the choice was left open and it is not the paper's.
    pub scheme_reason: Option<String>,
    /// Time step, or the first of a scheme that chooses its steps.
    pub dt: f64,
    /// Shortest step worth taking, of a scheme that chooses its steps.
    pub shortest_step: Option<f64>,
    /// Largest rate of decay by viscosity (1/s).
    pub fastest_decay: f64,
    /// Largest stable time step.
    pub dt_limit: f64,
    /// Whether viscosity (true) or wave speed (false) sets the limit.
    pub limited_by_viscosity: bool,
    /// Volume of the particles.
    pub volume: f64,
    /// Volume of the shape.
    pub shape_volume: f64,
    /// Total force of the loads where the curves of all of them are 1.
    pub load: Vec3,
    /// Things the user should know (one sentence each).
    pub notes: Vec<String>,
}

/// A running simulation. A clone goes on from the same state, bit by bit.
#[derive(Clone, Debug)]
pub struct Simulation {
    setup: Setup,
    description: Description,
    model: Box<dyn Model>,
    particles: Particles,
    integrator: Box<dyn Integrator>,
    remeshing: Remeshing,
    watch: Watchdog,
    balance: Balance,
    time: f64,
    steps: u64,
    /// Length of the next step.
    dt: f64,
    evaluations: u64,
    equilibrium: Option<Equilibrium>,
    /// The steps to the next moment that was asked for.
    plan: Option<Plan>,
    /// Time step at the start.
    first_dt: f64,
    /// The particles as the last failure left them, and when.
    failed_state: Option<Snapshot>,
}

/// Steps of even length up to a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plan {
    from: f64,
    to: f64,
    /// The length that they should have at most.
    dt: f64,
    steps: u64,
    done: u64,
}

/// Share of a time step that counts as none.
const SAME: f64 = 1e-6;

impl Plan {
    /// When step `k` ends.
    fn moment(&self, k: u64) -> f64 {
        if k == self.steps {
            return self.to;
        }
        self.from + (self.to - self.from) * (k as f64 / self.steps as f64)
    }
}

/// The scheme of integration for the particles of a moment.
fn integrator(
    setup: &Setup,
    description: &Description,
    dynamics: &mut dyn Dynamics,
    particles: &Particles,
) -> Box<dyn Integrator> {
    let implicit = |scheme, dynamics: &mut dyn Dynamics| {
        let (tolerance, shortest) = (setup.integration.tolerance, description.shortest_step);
        Box::new(Implicit::new(scheme, dynamics, particles, tolerance, shortest))
    };
    match description.scheme {
        Scheme::Auto | Scheme::Rk4 => Box::<RungeKutta4>::default(),
        Scheme::Sdirk2 => implicit(implicit::Scheme::Sdirk2, dynamics),
        Scheme::BackwardEuler => implicit(implicit::Scheme::BackwardEuler, dynamics),
        Scheme::Rkc2 => Box::new(RungeKuttaChebyshev::new(dynamics, particles, description.fastest_decay)),
    }
}

impl Simulation {
    /// Samples the body, tags boundaries, loads and probes, and chooses the time step.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn new(setup: impl Into<Setup>) -> Result<Self, InvalidInput> {
        Self::of(setup.into())
    }

    fn of(setup: Setup) -> Result<Self, InvalidInput> {
        checks::check_solver(&setup.solver)?;
        checks::check_fields(&setup)?;
        let parts = match &setup.mechanics {
            Mechanics::Solid(solid) => SolidBody::parts(&setup.clone().with_mechanics(solid.clone()))?,
            Mechanics::Prescribed(prescription) => PrescribedBody::parts(&setup, prescription)?,
            Mechanics::Interaction(setting) => FluidBesideSolid::parts(&setup, setting)?,
        };
        let Parts { mut model, mut particles, description } = parts;
        let dynamics = model.dynamics_mut();
        dynamics.impose(0.0, &mut particles);
        let mut integrator = integrator(&setup, &description, dynamics, &particles);
        let energy = dynamics.energy(0.0, &particles);
        let forces = integrator.evaluate(dynamics, &particles, 0.0);
        // The energy is a difference of squares of u / dx, which round to 1e-16 of themselves. A strain e over
        // a length L, with u = e L, has (dx / L)^2 1e16 times as much.
        let moduli = setup.solid().into_iter().flat_map(SolidSetup::materials).map(|m| m.p_wave_modulus());
        let modulus = moduli.fold(0.0, f64::max);
        let rounding = 1e-16 * modulus * description.volume / description.spacing.powi(2);
        Ok(Self {
            watch: Watchdog::new(dynamics, &particles, energy, rounding),
            balance: Balance::new(dynamics.account(), &particles, energy, forces),
            remeshing: Remeshing::new(setup.remesh.trigger),
            dt: description.dt,
            evaluations: 0,
            equilibrium: None,
            plan: None,
            first_dt: description.dt,
            failed_state: None,
            setup,
            description,
            model,
            particles,
            integrator,
            time: 0.0,
            steps: 0,
        })
    }

    /// What it was made from.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// What is known before the first step.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Advances by one time step of length `dt`.
    ///
    /// # Errors
    /// When the state becomes meaningless; the last good state is kept.
    pub fn step(&mut self) -> Result<(), Failure> {
        while !self.step_by(self.dt)? {}
        self.check()
    }

    /// Advances to the time `t` exactly, shortening the steps evenly where needed. Stops early, at a
    /// whole step, when `keep_going` returns false (called after every step); called again for the same moment it
    /// takes the steps that it would have taken.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn advance_to(
        &mut self,
        t: f64,
        keep_going: &mut dyn FnMut(&mut Self) -> bool,
    ) -> Result<(), Failure> {
        loop {
            let mut plan = self.plan_to(self.next_moment(t));
            if plan.done == plan.steps {
                break;
            }
            let next = plan.moment(plan.done + 1);
            if self.step_by(next - self.time)? {
                self.time = next;
                plan.done += 1;
                self.plan = Some(plan);
                if !keep_going(self) {
                    return Ok(());
                }
            }
        }
        self.check()
    }

    /// The next moment up to `t` at which a step should end.
    fn next_moment(&self, t: f64) -> f64 {
        let from = self.time + 2.0 * SAME * self.dt;
        self.setup.solid().and_then(|solid| solid.moment_after(from, self.dt)).map_or(t, |m| m.min(t))
    }

    /// The plan of the steps up to `t`: the one that is being followed, even across a stop, until a remesh or a
    /// scheme that chooses its steps chooses another length.
    fn plan_to(&self, t: f64) -> Plan {
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits();
        if let Some(p) = self.plan
            && same(p.to, t)
            && same(p.dt, self.dt)
            && same(p.moment(p.done), self.time)
        {
            return p;
        }
        let (from, dt) = (self.time, self.dt);
        Plan { from, to: t, dt, steps: ((t - from) / dt - SAME).ceil().max(0.0) as u64, done: 0 }
    }

    /// Advances by `dt`; false if the scheme wants a shorter step and nothing was done.
    fn step_by(&mut self, dt: f64) -> Result<bool, Failure> {
        // The whole step inside the thread pool: entering it for every sum costs more than small sums.
        awake(|| self.step_inside(dt))
    }

    fn step_inside(&mut self, dt: f64) -> Result<bool, Failure> {
        let dynamics = self.model.dynamics_mut();
        let step = match self.integrator.step(dynamics, &mut self.particles, self.time, dt) {
            Ok(step) => step,
            Err((kind, what)) => {
                let failure = Failure {
                    kind,
                    time: self.time,
                    step: self.steps,
                    what,
                    place: None,
                    remedy: "take a shorter `time.dt`; a body that hangs by a thin piece needs a smaller \
                             spacing or a better hold"
                        .into(),
                };
                return Err(self.fail(failure));
            }
        };
        self.evaluations += step.evaluations;
        if let Some(next) = step.next {
            // A step that only fills up to a moment says little about how long steps may be.
            if !step.taken || next < self.dt || dt > 0.5 * self.dt {
                self.dt = next;
            }
        }
        if !step.taken {
            return Ok(false);
        }
        self.time += dt;
        self.steps += 1;
        self.balance.add(&step.sums, step.forces);
        let moment = Moment { time: self.time, step: self.steps };
        if let Some(failure) = self.model.disorder(&self.particles, moment) {
            return Err(self.fail(failure));
        }
        // What is not finite shows in the sums of the very step.
        if self.watch.is_due(self.steps) || !step.sums.work.is_finite() {
            self.check()?;
        }
        let strain = || self.model.strain(&self.particles, self.time, dt);
        if self.remeshing.is_due(dt, strain) {
            self.remesh()?;
        }
        Ok(true)
    }

    /// Remeshes at this moment, whatever triggers remeshing else; for a simulation that remeshes at all.
    ///
    /// # Errors
    /// A body that is never remeshed (`remesh.every` is 0), and particles that no lattice can take.
    pub fn remesh(&mut self) -> Result<(), Failure> {
        let moment = Moment { time: self.time, step: self.steps };
        if self.setup.remesh.trigger == RemeshTrigger::Never {
            return Err(Failure {
                kind: FailureKind::Scattered,
                time: moment.time,
                step: moment.step,
                what: "this simulation keeps the lattice that it starts on".into(),
                place: None,
                remedy: "give `remesh.every` or `remesh.interval`".into(),
            });
        }
        let energy = self.energy();
        let before = Sums::new(&self.particles, energy);
        match self.model.remesh(&self.particles, moment) {
            Ok(mut outcome) => {
                let imposed = self.model.dynamics().impose(self.time, &mut outcome.particles);
                self.balance.impose(&imposed);
                if let Some(limit) = &outcome.limit {
                    self.description.dt_limit = limit.dt;
                    // A scheme without a limit keeps its pace.
                    if self.description.scheme == Scheme::Rk4 {
                        self.description.dt = time_step::step_within(&self.setup, limit);
                        self.dt = self.description.dt;
                    }
                }
                self.particles = outcome.particles.clone();
                let energy = self.energy();
                let after = Sums::new(&self.particles, energy);
                let conserves_mass = self.model.dynamics().account().conserves_mass;
                let shortest = checks::SHORTEST_STEP * self.first_dt;
                let wrong =
                    if conserves_mass { checks::mass_lost(before.mass, after.mass, moment) } else { None };
                if let Some(failure) = wrong.or_else(|| checks::step_too_short(self.dt, shortest, moment)) {
                    return Err(self.fail_after_remesh(failure));
                }
                self.remeshing.done(&outcome, before, after, self.description.dt);
                let dynamics = self.model.dynamics_mut();
                self.integrator = integrator(&self.setup, &self.description, dynamics, &self.particles);
                let dynamics = self.model.dynamics();
                self.watch.restart(dynamics, &self.particles, self.time, self.steps);
                Ok(())
            }
            Err(failure) => Err(self.fail(failure)),
        }
    }

    /// The particles of the last good state are gone with their lattice: the remeshed ones stay.
    fn fail_after_remesh(&mut self, failure: Failure) -> Failure {
        self.watch.restart(self.model.dynamics(), &self.particles, self.time, self.steps);
        self.fail(failure)
    }

    fn energy(&mut self) -> Energy {
        self.model.dynamics_mut().energy(self.time, &self.particles)
    }

    /// Looks whether the state still makes sense; goes back to the last good one if not.
    fn check(&mut self) -> Result<(), Failure> {
        let (time, step) = (self.time, self.steps);
        let look = Check {
            energy: self.energy(),
            work: self.balance.work,
            smallest_jacobian: self.model.dynamics_mut().smallest_jacobian(time, &self.particles),
        };
        let inverted = look.smallest_jacobian.filter(|(_, j)| *j <= 0.0);
        let is_linear = self.model.dynamics_mut().solid().is_none_or(|solid| solid.is_linear());
        if let (Some((particle, _)), false) = (inverted, is_linear) {
            let place = self.particles.column(Field::Reference).vector(particle);
            return Err(self.fail(checks::inverted(place, Moment { time, step })));
        }
        let result = self.watch.check(self.model.dynamics(), &self.particles, &look, time, step);
        result.map_err(|failure| self.fail(failure))
    }

    /// Goes back to the last good state; the failure with its likely cause.
    fn fail(&mut self, failure: Failure) -> Failure {
        self.restore();
        checks::with_cause(failure, &self.setup, &self.description, self.dt)
    }

    /// Goes back to the last good state and keeps what the failure has made of it.
    fn restore(&mut self) {
        let particles = self.particles.clone();
        self.failed_state = Some(Snapshot { time: self.time, step: self.steps, particles });
        (self.time, self.steps) = self.watch.restore(self.model.dynamics(), &mut self.particles);
        // What follows from the restored columns.
        self.model.dynamics().impose(self.time, &mut self.particles);
    }

    /// Replaces all loads from this moment on, as where something touches a body in interactive use. Ramps
    /// keep counting from time 0.
    ///
    /// # Errors
    /// A load that acts on nothing, or a body whose loads can not be replaced; nothing has changed then.
    pub fn set_loads(&mut self, loads: Vec<Load>) -> Result<(), InvalidInput> {
        self.model.set_loads(&loads, self.time)?;
        if let Some(solid) = self.setup.solid_mut() {
            solid.loads = loads;
        }
        Ok(())
    }

    /// Evaluates the right-hand side at this moment without advancing, for measurements.
    pub fn evaluate(&mut self) -> ForceSums {
        self.integrator.evaluate(self.model.dynamics_mut(), &self.particles, self.time)
    }

    /// Simulated time.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of steps taken.
    pub fn step_count(&self) -> u64 {
        self.steps
    }

    /// Number of right-hand sides evaluated and, by implicit and static solves, operators applied.
    pub fn rhs_evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Goes on with another scheme of integration and time step.
    ///
    /// # Errors
    /// As for a new simulation: `time.integrator`, `time.dt`.
    pub fn set_integration(&mut self, integration: Integration, step: TimeStep) -> Result<(), InvalidInput> {
        let mut setup = self.setup.clone();
        (setup.integration, setup.time_step) = (integration, step);
        let dynamics = self.model.dynamics_mut();
        let (Some(solid), Some(mechanics)) = (dynamics.solid(), setup.solid()) else {
            return Err(InvalidInput::new(
                "time.integrator",
                integration.scheme.name(),
                "can not be changed: only a solid of the adjoint formulation has other schemes than rk4",
                "leave it out",
            ));
        };
        solid.linearise(self.time, self.particles.column(Field::Displacement).values());
        let limit = step_limit(solid);
        let pace = choose_pace(&setup, mechanics, &limit, true)?;
        self.description.scheme = pace.scheme;
        self.description.scheme_reason = pace.reason;
        self.description.shortest_step = pace.adaptive;
        self.description.dt = pace.dt;
        self.dt = pace.dt;
        self.setup = setup;
        self.integrator = integrator(&self.setup, &self.description, dynamics, &self.particles);
        Ok(())
    }

    /// K u of a displacement field (component by component), in newtons, held components zero, K the tangent stiffness of this
    /// moment; `None` if the body has no stiffness.
    pub fn stiffness(&mut self, u: &[f64]) -> Option<Vec<f64>> {
        let solid = self.model.dynamics_mut().solid()?;
        solid.linearise(self.time, self.particles.column(Field::Displacement).values());
        let mut free = u.to_vec();
        solid.fixed.zero(&mut free, u.len() / 3);
        let mut force = vec![0.0; u.len()];
        solid.apply(Scales::STATIC, &free, &mut force);
        Some(force)
    }

    /// The largest strain, turn and displacement of this moment; `None` for a body whose law takes them all, or has none.
    pub fn extremes(&mut self) -> Option<Extremes> {
        let limited: Vec<bool> = self.setup.solid()?.materials().map(|m| m.range().is_limited()).collect();
        if !limited.contains(&true) {
            return None;
        }
        let (x, u) = (self.particles.column(Field::Reference), self.particles.column(Field::Displacement));
        let (places, moved): (Vec<Vec3>, Vec<Vec3>) =
            (0..self.particles.len()).map(|a| (x.vector(a), u.vector(a))).unzip();
        let solid = self.model.dynamics_mut().solid()?;
        let mut gradients = solid.gradient(self.time, u.values());
        for (a, gradient) in gradients.iter_mut().enumerate() {
            if !limited[solid.material_of(a)] {
                *gradient = Mat3::zeros();
            }
        }
        Some(Extremes::new(&places, &moved, &gradients))
    }

    /// What to know where `extremes` are beyond what the law of the body is for.
    pub fn beyond_the_law(&self, extremes: &Extremes) -> Option<String> {
        let limited = self.setup.solid()?.materials().find(|m| m.range().is_limited())?;
        extremes.note(&**limited, &self.setup.shape.bounds())
    }

    /// The state without derived columns.
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// Frees the memory that the next step makes anew, so that what looks at this moment finds room.
    pub fn rest(&mut self) {
        self.integrator.rest();
    }

    /// A picture of this moment.
    pub fn snapshot(&mut self) -> Snapshot {
        let particles = self.model.derived(&self.particles, self.time, &self.setup.fields);
        Snapshot { time: self.time, step: self.steps, particles }
    }

    /// After a failure, the particles as they were when it was noticed, without derived columns; the simulation
    /// itself has gone back to its last good state.
    pub fn failed_state(&self) -> Option<&Snapshot> {
        self.failed_state.as_ref()
    }

    /// The surface of the moment of `snapshot`, which is one of this simulation's.
    pub fn surface(&self, snapshot: &Snapshot) -> Surface {
        self.model.surface(snapshot)
    }

    /// What remeshing has done so far; `None` if remeshing is off.
    pub fn remesh_log(&self) -> Option<RemeshLog> {
        (self.setup.remesh.trigger != RemeshTrigger::Never).then_some(self.remeshing.log)
    }

    /// The probes' readings of this moment, in order, and then those of [`own_readings`].
    pub fn readings(&mut self) -> Vec<Reading> {
        let mut readings = self.model.readings(&self.particles, self.time);
        self.read_holds(&mut readings);
        if self.setup.solid().is_some() && self.remesh_log().is_some() {
            let now = Snapshot { time: self.time, step: self.steps, particles: self.particles.clone() };
            let value = self.model.surface(&now).mesh.volume();
            readings.push(Reading { name: VOLUME_INSIDE.into(), value });
        }
        readings
    }

    /// The conserved sums of this moment.
    pub fn conservation(&mut self) -> Conservation {
        let energy = self.energy();
        self.balance.conservation(&self.particles, energy)
    }
}
