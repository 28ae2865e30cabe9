//! What the machine can do: fused multiply-adds in double precision and the bandwidth of memory (STREAM
//! triad), with one thread and with all. `cargo bench -p rsph-core --bench limits`; prints JSON.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// Sums that do not wait for each other: more than latency times issue width.
const CHAINS: usize = 16;
/// Times each thing is measured; the best counts.
const REPEATS: usize = 5;
/// Values of each array of the triad: 128 MB, beyond a core's share of the caches.
const TRIAD: usize = 1 << 24;

struct Multiply {
    rounds: u64,
}

impl WithSimd for Multiply {
    /// A number that depends on all of it, and the lanes of a vector.
    type Output = (f64, usize);

    #[allow(clippy::inline_always)] // or it would not get the instruction set
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let factor = simd.splat_f64s(black_box(0.999_999));
        let addend = simd.splat_f64s(black_box(1e-6));
        let mut sums = [simd.splat_f64s(1.0); CHAINS];
        for _ in 0..self.rounds {
            for sum in &mut sums {
                *sum = simd.mul_add_e_f64s(*sum, factor, addend);
            }
        }
        let total = sums.into_iter().fold(simd.splat_f64s(0.0), |a, b| simd.add_f64s(a, b));
        (simd.reduce_sum_f64s(total), S::F64_LANES)
    }
}

/// Billions of multiply-adds a second on `threads` threads, and lanes of a vector.
fn multiply_adds(threads: usize) -> (f64, usize) {
    let (rounds, arch) = (4_000_000, Arch::new());
    let (mut best, mut lanes) = (0.0_f64, 0);
    for _ in 0..REPEATS {
        let start = Instant::now();
        lanes = (0..threads)
            .into_par_iter()
            .with_max_len(1)
            .map(|_| {
                let (sum, lanes) = arch.dispatch(Multiply { rounds });
                black_box(sum);
                lanes
            })
            .max()
            .unwrap_or(0);
        let count = threads as f64 * rounds as f64 * (CHAINS * lanes) as f64;
        best = best.max(count / start.elapsed().as_secs_f64() / 1e9);
    }
    (best, lanes)
}

/// Gigabytes a second of a = b + s c, 24 bytes a value as STREAM counts, on `threads` threads.
fn triad(threads: usize) -> f64 {
    let chunk = TRIAD.div_ceil(threads);
    let (mut a, mut b, mut c) = (vec![0.0; TRIAD], vec![0.0; TRIAD], vec![0.0; TRIAD]);
    // Touched first by the threads that use them.
    (a.par_chunks_mut(chunk), b.par_chunks_mut(chunk), c.par_chunks_mut(chunk))
        .into_par_iter()
        .for_each(|(a, b, c)| (a.fill(0.0), b.fill(1.0), c.fill(2.0)).0);
    let scale = black_box(3.0);
    let mut best = 0.0_f64;
    for _ in 0..REPEATS {
        let start = Instant::now();
        (a.par_chunks_mut(chunk), b.par_chunks(chunk), c.par_chunks(chunk)).into_par_iter().for_each(
            |(a, b, c)| {
                for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                    *a = b + scale * c;
                }
            },
        );
        black_box(&mut a);
        best = best.max(24.0 * TRIAD as f64 / start.elapsed().as_secs_f64() / 1e9);
    }
    best
}

fn main() {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| (multiply_adds(threads), triad(threads)))
    };
    let ((one, lanes), triad_one) = on(1);
    let ((all, _), triad_all) = on(threads);
    println!(
        "{{\"threads\": {threads}, \"f64_lanes\": {lanes}, \"gfma_one\": {one:.1}, \"gfma_all\": {all:.1}, \
         \"triad_gb_one\": {triad_one:.1}, \"triad_gb_all\": {triad_all:.1}}}"
    );
}
