//! Time and memory of the path tracer for dense undercoat. PELAGE_HAIRS=1000000 measures more hairs
//! than the usual 60,000, PELAGE_LEAN their lean.

use crate::common::alone;
use crate::common::hairs::*;
use glam::Vec3;
use pelage_core::scene::DirectionalLight;
use pelage_fur::Layer;
use pelage_pathtrace::{self as pathtrace, Accumulator, Integrator, LightModel, Tracer};
use std::time::Instant;

/// Peak memory of this process, bytes; `None` if the system does not report it.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? * 1024)
}

/// CPU time of all threads, s, with a resolution of 0.01 s.
fn cpu() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    [11, 12].iter().filter_map(|i| fields.get(*i)?.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn variable<T: std::str::FromStr>(name: &str, usual: T) -> T {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(usual)
}

/// The peak is that of the process, so that the test runs in a process of its own.
#[test]
fn a_tracer_takes_no_more_memory_than_estimated() {
    alone("pathtrace_memory::a_tracer_takes_no_more_memory_than_estimated", measure);
}

fn measure() {
    const SEGMENTS: usize = 8;
    let count: u32 = variable("PELAGE_HAIRS", 60_000);
    let lean: f32 = variable("PELAGE_LEAN", 0.4);
    // 25,000 hairs/cm².
    let side = (count as f32 / 25_000.0).sqrt();
    let world = empty_world(|s| {
        s.mesh.scale = Some(0.1 * side);
        s.mesh.translate = [0.0; 3];
        s.environment = Some(sky());
        s.lights = vec![DirectionalLight::default()];
        s.camera.eye = [0.0, 20.0, 20.0];
        s.camera.fov = 2.0 * (0.25 * side / 28.0).atan().to_degrees();
        s.film.width = 128;
        s.film.height = 128;
    });
    let coat = strands(
        Layer::Undercoat,
        SEGMENTS,
        coat(count, side, 1.0, 0.0007, lean, SEGMENTS, 9),
        Vec3::new(0.7, 0.55, 0.4),
    );
    let coats = vec![(coat, diffuse())];
    let before = peak();
    let estimated = pathtrace::estimate(&world, &coats);
    let options = options(Integrator::Path, LightModel::Map, 2);
    let start = Instant::now();
    let mut tracer = Tracer::new(&world, coats, &options).unwrap();
    let built = start.elapsed().as_secs_f64();
    let after = peak();
    let mib = |bytes: u64| bytes as f64 / (1 << 20) as f64;
    println!(
        "{count} hairs of {SEGMENTS} segments: built in {built:.2} s, kept {:.0} MiB",
        mib(tracer.geometry.bytes())
    );
    for (integrator, samples) in [(Integrator::Single, 4), (Integrator::Path, 2)] {
        tracer.integrator = integrator;
        let mut means = Accumulator::new(128, 128);
        let (start, ran) = (Instant::now(), cpu());
        let rays = tracer.add(&mut means, samples, None).unwrap() as f64;
        let seconds = start.elapsed().as_secs_f64();
        let traced = f64::from(samples) * 128.0 * 128.0;
        println!(
            "{integrator:?}: {:.3} million samples/s, {:.3} million rays/s, {:.3} million rays a CPU second, {:.1} rays a sample, mean {:.5}",
            1e-6 * traced / seconds,
            1e-6 * rays / seconds,
            1e-6 * rays / (cpu() - ran).max(0.01),
            rays / traced,
            mean(&means.film(), "G")
        );
    }
    if let (Some(before), Some(after)) = (before, after) {
        println!("peak {:.0} MiB, before {:.0}, estimated {:.0}", mib(after), mib(before), mib(estimated));
        // The points were there before.
        assert!(after - before <= estimated, "{after} - {before} is more than {estimated}");
        assert!(after < 4 << 30 || count > 1_000_000);
    }
}
