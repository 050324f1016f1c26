//! Tells builds with assertions whether the machine that compiles them has AVX-512: where it has not, they leave those
//! kernels out.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(host_has_avx512)");
    if has_avx512() {
        println!("cargo::rustc-cfg=host_has_avx512");
    }
}

#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx512() -> bool {
    false
}
