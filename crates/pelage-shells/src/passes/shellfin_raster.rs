//! Draws shells and fins: the skin, fins at the silhouette, then textured shells from the skin
//! outwards.

use pelage_core::Result;
use pelage_gpu::kernel::Target;
use pelage_gpu::recorder::RasterTargets;
use pelage_gpu::{Gpu, Kernel, RasterKernel, Recorder, Scope};

/// The raster kernels of skin, fins and shells, and the conversion to samples.
pub struct ShellfinRaster {
    skin: RasterKernel,
    fins: RasterKernel,
    /// Without and with depth writing.
    shells: [RasterKernel; 2],
    to_samples: Kernel,
}

/// What is drawn in a frame.
#[derive(Debug, Clone, Copy)]
pub struct Draws {
    /// Triangles of the skin.
    pub triangles: u32,
    /// Edges that may carry fins; 0 without fins.
    pub edges: u32,
    /// Rows of vertices of a fin, skin and tip included.
    pub fin_rows: u32,
    /// Number of textured shells; may be 0.
    pub shells: u32,
    /// Triangles of a shell: those of the skin, or of all patches if they overlap.
    pub shell_triangles: u32,
    /// Whether shells write depth.
    pub depth_write: bool,
}

/// Features for which the kernels are compiled; unused ones cost nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Uses {
    /// Guard hairs have texture layers of their own.
    pub guard: bool,
    /// Levels of detail are blended.
    pub detail: bool,
    /// Hairs cast shadows on one another.
    pub shadow: bool,
    /// Points of the outline that masks a patch; 0 if patches do not overlap.
    pub outline: u32,
    /// Colour or length come from an image or from vertex colours.
    pub mapped: bool,
    /// Coats: the scene's own and those of its parts.
    pub coats: u32,
}

impl ShellfinRaster {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with the file and line of an error in the shader.
    pub fn new(gpu: &Gpu, uses: Uses) -> Result<Self> {
        let number = |b: bool| f64::from(u8::from(b));
        let constants = [
            ("GUARD", number(uses.guard)),
            ("DETAIL", number(uses.detail)),
            ("SHADOW", number(uses.shadow)),
            ("MAPPED", number(uses.mapped)),
            ("OUTLINE", f64::from(uses.outline)),
            ("COATS", f64::from(uses.coats.max(1))),
        ];
        let kernel = |name: &str, target| {
            let (vertex, fragment) = (format!("{name}_vertex"), format!("{name}_fragment"));
            RasterKernel::specialised(gpu, "shellfin_raster", [&vertex, &fragment], target, &constants)
        };
        let shell = |solid| kernel("shell", Target::Color { over: true, solid, both_sides: false });
        Ok(Self {
            skin: kernel("skin", Target::Color { over: false, solid: true, both_sides: true })?,
            fins: kernel("fin", Target::Color { over: true, solid: false, both_sides: true })?,
            shells: [shell(false)?, shell(true)?],
            to_samples: Kernel::new(gpu, "shellfin_raster", "to_samples")?,
        })
    }

    /// Draws a frame in the order skin, fins, shells. Rows, textures and samplers must be in scope.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    // [Lengyel2001] sec. 2.3
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scope: &Scope<'_>,
        targets: &RasterTargets<'_>,
        draws: &Draws,
    ) -> Result<()> {
        recorder.draw(&self.skin, scope, targets, 3 * draws.triangles)?;
        if draws.edges > 0 && draws.fin_rows > 1 {
            let counts = [6 * (draws.fin_rows - 1), draws.edges];
            recorder.draw_instances(&self.fins, scope, targets, counts, false)?;
        }
        if draws.shells > 0 {
            let kernel = &self.shells[usize::from(draws.depth_write)];
            let counts = [3 * draws.shell_triangles, draws.shells];
            recorder.draw_instances(kernel, scope, targets, counts, false)?;
        }
        Ok(())
    }

    /// Converts the drawn image to `samples` samples of the film.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] if a binding is missing.
    pub fn record_samples(&self, recorder: &mut Recorder<'_>, scope: &Scope<'_>, samples: u64) -> Result<()> {
        recorder.dispatch(&self.to_samples, scope, samples)
    }
}
