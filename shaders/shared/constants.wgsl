// Numbers that several shaders use.

const PI: f32 = 3.1415927;
const TAU: f32 = 6.2831853;
// This and 1 / pi are one unit in the last place away from the nearest f32; kept because images
// depend on it.
const FRAC_PI_2: f32 = 1.5707963;
const FRAC_PI_4: f32 = 0.7853982;
const FRAC_1_PI: f32 = 0.31830989;
const FRAC_2_PI: f32 = 0.63661977;
const FRAC_1_TAU: f32 = 0.15915494;
const FRAC_1_PI_SQUARED: f32 = 0.10132118;

// Invalid index: no neighbour, no layer, nothing found.
const NONE: u32 = 0xffffffffu;
