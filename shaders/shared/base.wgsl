// Base fragments: depth, radiance (three halves), normal (octahedral). One a sample.

const NO_BASE: f32 = 1e30;
