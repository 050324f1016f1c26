//! Roots of quadratics.

/// Finds the roots of a·t² + b·t + c, the lesser one first; `None`: there are not two.
pub(crate) fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let square = b * b - 4.0 * a * c;
    if square.is_nan() || square <= 0.0 || a == 0.0 {
        return None;
    }
    // Without the difference of like numbers.
    let sum = -0.5 * (b + square.sqrt().copysign(b));
    let [first, second] = [sum / a, c / sum];
    Some([first.min(second), first.max(second)])
}
