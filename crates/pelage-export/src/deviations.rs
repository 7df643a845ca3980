//! How an exported scene differs from the original: what the target cannot express of it.

use super::objects::Exported;
use super::sky::Sky;
use super::{Job, Target, curves, material, skin_colors};
use pelage_core::scene::{Background, Filter, FurLayers, Shading};
use pelage_fur::Layer;
use pelage_fur::groom;

/// One sentence for each thing that the target renders differently from this program.
pub(super) fn of(job: &Job<'_>, target: Target) -> Vec<String> {
    let mut notes = Vec::new();
    hairs(job, target, &mut notes);
    objects(job, target, &mut notes);
    lights(job, target, &mut notes);
    film(job, target, &mut notes);
    notes
}

fn hairs(job: &Job<'_>, target: Target, notes: &mut Vec<String>) {
    let scene = &job.world.scene;
    let has = |layer| job.strands.iter().any(|s| s.layer == layer && !s.hairs.is_empty());
    for (layer, wanted) in
        [(Layer::Guard, groom::has_guard(scene)), (Layer::Undercoat, groom::has_undercoat(scene))]
    {
        let name = curves::name(layer);
        if wanted && !has(layer) {
            notes.push(format!("the scene renders the {name}, but no hairs of it are here"));
        }
        if !has(layer) {
            continue;
        }
        let shown = matches!(target, Target::Usd | Target::Hair);
        match material::of(scene, layer).approximates {
            _ if shown => {
                notes.push(format!("the {name} has colours only: its scattering model is not expressed"));
            }
            Some(text) => notes.push(text),
            None => {}
        }
    }
    if has(Layer::Undercoat) {
        notes.push(
            "the undercoat, a volume where the scene is rendered, is here as hairs drawn from its density"
                .into(),
        );
    }
    if scene.render.fur == FurLayers::Shells {
        notes.push("the scene renders shells with textures; here are the hairs of its groom".into());
    }
    if scene.render.shading == Shading::Paper {
        notes.push(
            "shading = \"paper\" (root darkening, no shadows of the environment) is not expressed".into(),
        );
    }
    for strands in job.strands {
        let least = strands.opacity.iter().copied().fold(1.0, f32::min);
        if least < 1.0 && !matches!(target, Target::Usd | Target::Hair) {
            let name = curves::name(strands.layer);
            notes.push(format!("the {name} has an opacity down to {least}; here it is opaque"));
        }
    }
    let ends = match target {
        Target::Mitsuba => {
            "each segment is a B-spline of its own that follows the cone exactly (Mitsuba 3.9 turns the frame of its linear curves, so that hair \
             on them is wrong); cones are open at both ends and do not join at bends, and hits lie about 9e-5 (1 + largest \
             coordinate) cm off the surface: keep the model near the origin; scattered light leaves from the surface, not from the axis"
        }
        Target::Pbrt => {
            "each segment is a straight curve of its own, a ribbon that faces the ray with the normals of a cylinder, its width \
             linear in between; pbrt renders spectra, made of the RGB values here"
        }
        Target::Blender => {
            "Cycles draws smooth (Catmull-Rom) curves through the points where it has no linear ones (before Blender 5); the tilt \
             has the opposite sign there"
        }
        Target::Usd => "curves are linear; how round or flat they are drawn is the renderer's choice",
        Target::Hair => return,
    };
    if !job.strands.is_empty() {
        notes.push(ends.into());
    }
    let slope = steepest(job);
    if target == Target::Mitsuba && slope > 0.0 {
        notes.push(format!(
            "where hairs taper, the tangent of Mitsuba's hair model lies on the surface, turned from the axis by up to {:.3} degrees",
            slope.atan().to_degrees()
        ));
    }
}

fn objects(job: &Job<'_>, target: Target, notes: &mut Vec<String>) {
    if job.objects.is_empty() || target == Target::Hair {
        return;
    }
    let named = |which: &dyn Fn(&Exported<'_>) -> bool| {
        let names = job.objects.iter().filter(|of| which(of)).map(|of| format!("{:?}", of.object.name));
        let names: Vec<_> = names.collect();
        (!names.is_empty()).then(|| names.join(", "))
    };
    notes.extend(match target {
        Target::Mitsuba => {
            Some("objects have Mitsuba's principled material, whose diffuse part is Burley's".into())
        }
        Target::Pbrt => {
            Some("objects have layered materials, in which light is reflected back and forth".into())
        }
        Target::Usd => {
            Some("objects have UsdPreviewSurface, whose exact form is the renderer's choice".into())
        }
        Target::Blender | Target::Hair => None,
    });
    if target == Target::Pbrt {
        let varied = named(&|of| of.colors().len() > 1);
        notes.extend(varied.map(|names| format!("the colour of {names} is the mean of its vertices")));
    } else {
        let sampled = named(&|of| of.without_uv());
        let how = "is taken at the vertices and interpolated, as the mesh has no uv";
        notes.extend(sampled.map(|names| format!("the mapped colour of {names} {how}")));
    }
    let coated = |of: &Exported<'_>| of.object.material.clearcoat > 0.0;
    match target {
        Target::Mitsuba => {
            let about =
                "is a quarter as strong in Mitsuba, of another distribution, and at most as rough as 0.32";
            notes.extend(named(&coated).map(|names| format!("the clear coat of {names} {about}")));
        }
        Target::Pbrt => {
            let lost = named(&|of| coated(of) && of.object.material.metallic < 1.0);
            notes.extend(
                lost.map(|names| format!("the clear coat of {names} is left out where it is no metal")),
            );
        }
        Target::Blender | Target::Usd | Target::Hair => {}
    }
    if let Some(names) = named(&|of| of.object.shadow_catcher) {
        notes.push(match target {
            Target::Blender => {
                format!("the shadow catcher {names} blocks light and reflects it onto the fur in Cycles")
            }
            _ => format!(
                "{names} only catches shadows in the scene; here it is seen like any object and blocks light"
            ),
        });
    }
}

/// Largest change of radius per length.
fn steepest(job: &Job<'_>) -> f32 {
    let slope = |s: curves::Segment| {
        let [a, b] = s.ends;
        (b.w - a.w).abs() / a.truncate().distance(b.truncate())
    };
    job.strands.iter().flat_map(curves::segments).map(slope).fold(0.0, f32::max)
}

fn lights(job: &Job<'_>, target: Target, notes: &mut Vec<String>) {
    if target == Target::Hair {
        return;
    }
    let scene = &job.world.scene;
    let folded = job.world.lights.iter().filter(|l| l.environment).count();
    match (&job.sky, &scene.environment) {
        (Some(sky), _) => {
            let what = if matches!(sky, Sky::Map { .. }) { "map" } else { "uniform sky" };
            notes.push(format!(
                "the environment is a {what} here; it is folded to {folded} directional lights where the scene is rendered"
            ));
            if let (Sky::Map { .. }, Target::Pbrt) = (sky, target) {
                notes.push("the map is resampled to pbrt's square form, with the scene's rotation in it".into());
            }
        }
        (None, Some(_)) => notes.push(format!(
            "the environment is the {folded} directional lights that the scene is rendered with, and is not seen"
        )),
        _ => {}
    }
    if job.world.lights.iter().any(|l| !l.undercoat) {
        notes.push("the environment does not light the undercoat in the scene; here it does".into());
    }
    if (scene.base.color != pelage_core::scene::Color::Constant([0.0; 3]) || !scene.parts.is_empty())
        && skin_colors(job.world).len() > 1
    {
        notes.push(match target {
            Target::Pbrt => "the skin's mapped colour is its mean".into(),
            _ => "the skin's mapped colour is taken at the vertices and interpolated".to_owned(),
        });
    }
}

fn film(job: &Job<'_>, target: Target, notes: &mut Vec<String>) {
    if target == Target::Hair {
        return;
    }
    let film = &job.world.scene.film;
    let (filter, radius) = job.view.filter;
    let usual = pelage_core::film::filter::usual_radius(filter);
    match (target, filter) {
        (Target::Mitsuba, Filter::Gaussian) => notes.push(format!(
            "the Gaussian filter ends at {} pixels and is not lowered to 0 there; the scene's ends at {radius}",
            4.0 * radius / 3.0
        )),
        (Target::Mitsuba, Filter::Box | Filter::Mitchell) if radius != usual => notes.push(format!(
            "the {filter:?} filter has its usual radius of {usual} pixels, not {radius}"
        )),
        (Target::Blender, Filter::Gaussian) => {
            notes.push("Cycles' Gaussian filter has another width: 1.5 of its units, two of which are its radius".into());
        }
        (Target::Blender, Filter::Triangle | Filter::Mitchell) => {
            notes.push(format!("the {filter:?} filter is a Blackman-Harris filter here"));
        }
        (Target::Usd, _) => notes.push("film size, samples and filter are the renderer's settings".into()),
        _ => {}
    }
    if job.view.post {
        notes.push("depth of field is traced; the scene blurs the finished picture".into());
    }
    let behind = match film.background {
        Background::Color => "colour",
        Background::Plate => "plate",
        Background::Environment if job.sky.is_none() => "environment",
        Background::Transparent | Background::Environment => "",
    };
    if !behind.is_empty() {
        notes.push(format!("the background {behind} is left out: alpha stays"));
    }
    if film.exposure != 0.0 {
        notes.push(format!("the exposure of {} stops is left out: pictures are linear", film.exposure));
    }
}
