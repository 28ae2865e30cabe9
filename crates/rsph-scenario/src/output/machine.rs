//! What a run ran on.

use sysinfo::{CpuRefreshKind, RefreshKind, System};

/// The vector instructions that the core's sums use on this processor.
pub fn simd() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        let v3 = has!("avx2") && has!("fma") && has!("bmi2");
        if v3 && has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl") {
            return "x86-64-v4";
        }
        if v3 {
            return "x86-64-v3";
        }
    }
    if cfg!(target_arch = "aarch64") { "neon" } else { "scalar" }
}

/// The name that the processor gives itself; empty if it has none.
pub fn processor() -> String {
    let only = RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing());
    let system = System::new_with_specifics(only);
    system.cpus().first().map(|cpu| cpu.brand().trim().to_owned()).unwrap_or_default()
}
