// Part of a box one sample wide, at distance `across` from the middle of a ribbon, that the ribbon
// covers. `radius`: half the ribbon's width. All lengths in samples.
fn ribbon_coverage(across: f32, radius: f32) -> f32 {
    return clamp(min(across + 0.5, radius) - max(across - 0.5, -radius), 0.0, 1.0);
}
