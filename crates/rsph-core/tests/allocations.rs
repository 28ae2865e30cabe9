//! A time step does not allocate, the watchdog's look at the state included.

use rsph_core::material::{KelvinVoigt, Material, NeoHookean, PronyTerm, Relaxing};
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Boundary, Curve, Fix, Load, LoadKind, MaterialPart, Setup, SolidSetup, Units};
use rsph_core::shape::BoxShape;
use rsph_core::simulation::Simulation;
use rsph_core::tensor::Vec3;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promises are those that the system's allocator asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above; the pointer came from the system's allocator.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: as in `dealloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A cube that is clamped and pulled, of two materials if `law` gives them, or under a pressure that follows its surface.
fn cube(law: fn(f64) -> Arc<dyn Material>, several: bool, kind: LoadKind) -> Simulation {
    let face = |at, side| Region::Plane { axis: Axis::Z, at, side };
    let mut solid = SolidSetup::new(law(100.0));
    solid.boundaries =
        vec![Boundary { name: None, region: face(0.0, Side::Below), fix: Fix::ALL, motion: None }];
    solid.loads = vec![Load { kind, curve: Curve::default() }];
    if several {
        let place = Arc::new(Region::Ball { centre: Vec3::repeat(0.5), radius: 0.3 });
        solid.parts.push(MaterialPart {
            name: "stiff".into(),
            material: law(1000.0),
            modulus: None,
            fibres: None,
            place,
        });
    }
    let shape = Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap());
    let setup = Setup::new(shape, Resolution::Particles(1000), solid);
    Simulation::new(Setup { units: Units::Normalised, ..setup }).unwrap()
}

#[test]
fn a_step_does_not_allocate() {
    let small: fn(f64) -> Arc<dyn Material> =
        |modulus| Arc::new(KelvinVoigt::new(1.0, modulus, 0.3, 0.2).unwrap());
    let relaxing: fn(f64) -> Arc<dyn Material> = |modulus| {
        let law = Arc::new(NeoHookean::new(1.0, modulus, 0.3, 0.0).unwrap());
        Arc::new(Relaxing::new(law, vec![PronyTerm { share: 0.5, time: 1.0 }]).unwrap())
    };
    let large: fn(f64) -> Arc<dyn Material> =
        |modulus| Arc::new(NeoHookean::new(1.0, modulus, 0.3, 0.2).unwrap());
    let top = Region::Plane { axis: Axis::Z, at: 1.0, side: Side::Above };
    let traction = LoadKind::Traction { region: top.clone(), traction: Vec3::z() };
    let follower = LoadKind::FollowerPressure { region: top, pressure: 1.0 };
    let bodies = [
        ("one linear law", cube(small, false, traction.clone())),
        ("two linear laws", cube(small, true, traction.clone())),
        ("two laws that relax", cube(relaxing, true, traction.clone())),
        ("two laws for any strain", cube(large, true, traction)),
        ("a follower", cube(large, false, follower)),
    ];
    // Inside of the pool: what the pool itself allocates when work comes from outside is not ours.
    // Its work queues may grow while it gets under way.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    for (what, mut simulation) in bodies {
        let counted = pool.install(|| {
            for _ in 0..50 {
                simulation.step().unwrap();
            }
            // A queue that grows because a thread is held up grows once; a step that allocates does so every time.
            let mut rounds = [0; 3];
            for round in &mut rounds {
                let before = ALLOCATIONS.load(Ordering::Relaxed);
                for _ in 0..60 {
                    simulation.step().unwrap();
                }
                *round = ALLOCATIONS.load(Ordering::Relaxed) - before;
            }
            rounds
        });
        assert!(counted.contains(&0), "allocations in rounds of 60 steps of {what}: {counted:?}");
    }
}
