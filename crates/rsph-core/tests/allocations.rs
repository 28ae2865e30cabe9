//! A time step does not allocate, the watchdog's look at the state included.

use rsph_core::material::KelvinVoigt;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::Resolution;
use rsph_core::setup::{Boundary, Curve, Fix, Load, LoadKind, Setup, SolidSetup, Units};
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

#[test]
fn a_step_does_not_allocate() {
    let face = |at, side| Region::Plane { axis: Axis::Z, at, side };
    let mut simulation = Simulation::new(Setup {
        units: Units::Normalised,
        ..Setup::new(
            Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap()),
            Resolution::Particles(1000),
            SolidSetup {
                foundations: Vec::new(),
                material: Arc::new(KelvinVoigt::new(1.0, 100.0, 0.3, 0.2).unwrap()),
                boundaries: vec![Boundary {
                    name: None,
                    region: face(0.0, Side::Below),
                    fix: Fix::ALL,
                    motion: None,
                }],
                loads: vec![Load {
                    kind: LoadKind::Traction { region: face(1.0, Side::Above), traction: Vec3::z() },
                    curve: Curve::default(),
                }],
            },
        )
    })
    .unwrap();
    // Inside of the pool: what the pool itself allocates when work comes from outside is not ours.
    // Its work queues may grow while it gets under way.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let counted = pool.install(|| {
        for _ in 0..50 {
            simulation.step().unwrap();
        }
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        for _ in 0..100 {
            simulation.step().unwrap();
        }
        ALLOCATIONS.load(Ordering::Relaxed) - before
    });
    assert_eq!(counted, 0, "allocations in 100 steps");
}
