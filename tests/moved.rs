//! A mesh that is moved together with the camera looks the same: the fur's noise moves with it.

use crate::common::worlds::{RGBA, ball, plane, render, rmse};
use pelage_core::scene::Scene;

/// Structure in all layers: clumps of both, and frizz.
fn clumped(scene: &mut Scene) {
    scene.guard.clump = 0.6.into();
    scene.guard.clump_density = 20.0;
    scene.guard.frizz = 0.02.into();
    scene.undercoat.noise_contrast = 1.0;
    scene.undercoat.noise_frequency = 5.0;
}

#[test]
fn mesh_and_camera_moved_together_make_the_same_picture() {
    if crate::common::gpu::open().is_none() {
        return;
    }
    let still = render(&ball(clumped)).film;
    let by = [5.0, 3.0, -2.0];
    let moved = |mesh: [f32; 3]| {
        let world = ball(|s| {
            clumped(s);
            s.mesh.translate = mesh;
            for (k, by) in mesh.iter().enumerate() {
                s.camera.eye[k] += by;
                s.camera.target[k] += by;
            }
        });
        render(&world)
    };
    let film = moved(by).film;
    let difference = rmse(&still, &film, &RGBA);
    let spread = plane(&still, "R").iter().fold(0.0f32, |a, b| a.max(*b));
    println!("moved: rmse {difference:.5}, largest value {spread}");
    assert!(difference < 2e-3, "{difference}");
    // Another seed has other hairs: the comparison can fail.
    let other = render(&ball(|s| {
        clumped(s);
        s.render.seed = 5;
    }));
    assert!(rmse(&still, &other.film, &RGBA) > 10.0 * difference.max(1e-3));
}
