//! Keeping the threads of the pool awake.
//!
//! A step of a small body is a few hundred parallel loops of some ten microseconds, with short serial stretches
//! in between. A thread that finds no work in one of them falls asleep, and waking it costs as much as
//! the next loop. So while a step or an iteration runs, the other threads keep looking for work.

use std::sync::atomic::{AtomicBool, Ordering};

/// Looks in vain after which a thread gives up. It bounds what a thread can lose that came here in the middle of
/// other work.
const PATIENCE: usize = 2000;

/// Runs `act` in the thread pool while its other threads stay awake.
pub fn awake<R: Send>(act: impl FnOnce() -> R + Send) -> R {
    let done = AtomicBool::new(false);
    let threads = rayon::current_num_threads();
    rayon::scope(|_| {
        let own = rayon::current_thread_index();
        let watched = || {
            let result = act();
            done.store(true, Ordering::Release);
            result
        };
        rayon::join(watched, || attend(&done, own, threads - 1)).0
    })
}

/// Works on whatever there is until `done`, with up to `threads` threads but not with thread `but`.
fn attend(done: &AtomicBool, but: Option<usize>, threads: usize) {
    if threads == 0 || rayon::current_thread_index() == but {
        return;
    }
    rayon::join(|| look_for_work(done), || attend(done, but, threads - 1));
}

fn look_for_work(done: &AtomicBool) {
    let mut in_vain = 0;
    while !done.load(Ordering::Acquire) && in_vain < PATIENCE {
        if rayon::yield_now() == Some(rayon::Yield::Executed) {
            in_vain = 0;
        } else {
            in_vain += 1;
            std::thread::yield_now();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    /// Also where steps of several bodies, each with others inside, meet in one pool.
    #[test]
    fn everything_is_done_once_for_any_number_of_threads() {
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let sum = |k: u64| {
                awake(|| {
                    let inner = awake(|| (0..1000_u64).into_par_iter().sum::<u64>());
                    inner + (0..1000_u64).into_par_iter().map(|i| i * k).sum::<u64>()
                })
            };
            let sums: Vec<u64> = pool.install(|| (0..40_u64).into_par_iter().map(sum).collect());
            assert!(sums.iter().zip(0..).all(|(s, k)| *s == 499_500 * (k + 1)), "{threads}");
        }
    }
}
