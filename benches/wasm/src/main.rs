//! The same calls without WebAssembly, to compare with.

fn main() {
    let particles = rsph_wasm::setup(5000);
    let begun = std::time::Instant::now();
    let moved = rsph_wasm::steps(100);
    let rate = 400.0 * particles as f64 / begun.elapsed().as_secs_f64() / 1e6;
    println!("{particles} particles, {rate:.2} M updates/s");
    println!("displacement after 100 steps {moved:.15e} m, at rest {:.15e} m", rsph_wasm::settle());
}
