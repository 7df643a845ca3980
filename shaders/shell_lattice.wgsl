// Step 2: attributes of the skin below the columns of the optical-depth lattice, read from the
// maps.
// In: `groom`, `maps_and_tables`. Out: density factor and packed colours in `columns`.

@group(0) @binding(1) var<uniform> fur: FurParameters;
@group(0) @binding(2) var<uniform> groom: Groom;
@group(0) @binding(3) var<storage, read> maps_and_tables: array<vec2u>;
@group(0) @binding(4) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(5) var<storage, read> prisms: array<Prism>;
@group(0) @binding(6) var<storage, read> corner_uv: array<vec2f>;
@group(0) @binding(7) var<storage, read_write> columns: array<Column>;

#import shared/index
#import shared/undercoat_types
#import shared/shell_types
#import shared/column
#import shared/record
#import shared/groom
#import shared/roots

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= fur.lattice.columns {
        return;
    }
    let at = skin_point(columns[i].prism, column_lambda(columns[i].grid));
    // Relative to the density from which fur.undercoat.extinction is computed.
    columns[i].density = scalar(UNDERCOAT_DENSITY, at) / fur.undercoat.density;
    columns[i].color_root = pack_albedo(color(UNDERCOAT_COLOR_ROOT, at));
    columns[i].color_tip = pack_albedo(color(UNDERCOAT_COLOR_TIP, at));
    columns[i].color_base = pack_albedo(color(BASE_COLOR, at));
}
