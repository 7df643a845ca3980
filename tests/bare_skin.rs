//! Skin without fur, as of a nose or an eye painted in a length map, is lit as any Lambertian
//! surface, however leaning the hairs around it.

use crate::common::gpu::{image, jittered_grid, scaled, world_on};
use crate::common::worlds::{plane, render};
use std::f32::consts::FRAC_1_PI;

/// A meadow of 10 x 10 cm with a bare square of 3.4 cm in its middle, where the undercoat is
/// `height` cm high and guard hairs have no length, seen from above; median red in the middle 0.8
/// x 0.8 cm. Few long hairs lean over it from outside.
fn middle(fur: &str, height: f32) -> f32 {
    let scene = format!(
        "[camera]\neye = [5, 20, 5.01]\ntarget = [5, 0, 5]\nfov = 2.3\nup = [0, 0, -1]\n\
         [film]\nwidth = 24\nheight = 24\nspp = 1\nfilter = \"box\"\n\
         [[lights]]\ndirection = [0.3, 1, 0.3]\nirradiance = [6, 6, 6]\n[base]\ncolor = [0.62, 0.62, 0.62]\n\
         [guard]\ndensity = 3\nlength = {{ map = \"len.png\", value = 2.2 }}\nspread = 35\n\
         comb = 1.5\ncomb_direction = [1, 0, 0]\n\
         [undercoat]\nheight = {{ map = \"height.png\", value = 0.8 }}\nlean = 0.5\nlayers = 8\ncell = 0.2\n\
         [bake]\nlayers = 4\nresolution = [32, 32]\n[shells]\nlength = {{ map = \"len.png\" }}\n\
         [render]\nfur = \"{fur}\"\n"
    );
    let hole = |u: f32, v: f32| (u - 0.5).abs() < 1.0 / 6.0 && (v - 0.5).abs() < 1.0 / 6.0;
    let map = |name, bare: f32| image(name, false, 64, |u, v| [if hole(u, v) { bare } else { 1.0 }; 4]);
    let maps = vec![map("len.png", 0.0), map("height.png", height / 0.8)];
    let world = world_on(&scene, Some(scaled(jittered_grid(40, 0.0), 0.25, 10.0)), maps);
    let film = render(&world).film;
    let mut red = plane(&film, "R").to_vec();
    red.sort_by(f32::total_cmp);
    red[red.len() / 2]
}

#[test]
fn bare_skin_is_lit_like_any_lambertian_surface() {
    if crate::common::gpu::open().is_none() {
        return;
    }
    let lambertian = 6.0 * 1.18f32.sqrt().recip() * 0.62 * FRAC_1_PI;
    for fur in ["hybrid", "explicit", "implicit", "shells"] {
        for height in [0.0, 1e-6, 1e-5, 1e-3] {
            let found = middle(fur, height);
            println!("{fur}, {height} cm: {found} of {lambertian}");
            // The hairs above, and 10 µm of undercoat, hide a few per cent.
            assert!((found / lambertian - 1.0).abs() < 0.06, "{fur}, {height} cm: {found}");
        }
    }
}
