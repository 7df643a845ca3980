// The fur as a grid of extinction over its bounding box, for rays that meet it from outside.
// Needs: fur_grid (uniform FurGrid), fur_cells (array<vec4u>).

struct FurGrid {
    low: vec3f,    // lowest corner, cm
    cell: f32,     // edge of a cell, cm
    size: vec3u,   // cells along each axis; 0: no fur
    padding: u32,
}

// Extinction of a cell along a unit direction, 1/cm. A cell holds the projected area of its hairs
// per volume and, as halves, the mean of t t^T over their directions t: xx, yy, zz, xy, xz, yz.
fn cell_extinction(index: u32, ray: vec3f) -> f32 {
    let cell = fur_cells[index];
    let square = unpack2x16float(cell.y);
    let more = unpack2x16float(cell.z);
    let mixed = unpack2x16float(cell.w);
    let along = dot(vec3f(square, more.x), ray * ray)
        + 2.0 * (more.y * ray.x * ray.y + mixed.x * ray.x * ray.z + mixed.y * ray.y * ray.z);
    return bitcast<f32>(cell.x) * sqrt(max(1.0 - along, 0.0));
}

// Optical depth along a ray to infinity: exact for extinction that is constant in each cell.
fn fur_depth(origin: vec3f, ray: vec3f) -> f32 {
    if fur_grid.size.x == 0u {
        return 0.0;
    }
    let size = vec3f(fur_grid.size);
    let start = (origin - fur_grid.low) / fur_grid.cell;
    let safe = select(ray, vec3f(1e-12), abs(ray) < vec3f(1e-12));
    let inverse = 1.0 / safe;
    let a = -start * inverse;
    let b = (size - start) * inverse;
    let low = min(a, b);
    let high = max(a, b);
    let enter = max(0.0, max(low.x, max(low.y, low.z)));
    let leave = min(high.x, min(high.y, high.z));
    if enter >= leave {
        return 0.0;
    }
    let from_cell = clamp(floor(start + safe * enter), vec3f(0.0), size - 1.0);
    var at = vec3i(from_cell);
    let step = vec3i(sign(safe));
    let steps = abs(inverse);
    // Distances to the next walls of the cell, in cells along the ray.
    var next = (from_cell + select(vec3f(0.0), vec3f(1.0), safe > vec3f(0.0)) - start) * inverse;
    var z = enter;
    var sum = 0.0;
    // A ray crosses at most as many walls as there are cells along the three axes.
    let most = fur_grid.size.x + fur_grid.size.y + fur_grid.size.z;
    for (var k = 0u; k < most; k++) {
        let nearest = min(next.x, min(next.y, next.z));
        let end = min(nearest, leave);
        let index = (u32(at.z) * fur_grid.size.y + u32(at.y)) * fur_grid.size.x + u32(at.x);
        if fur_cells[index].x != 0u {
            sum += cell_extinction(index, ray) * max(end - z, 0.0);
        }
        z = max(z, end);
        if next.x == nearest {
            at.x += step.x;
            next.x += steps.x;
        } else if next.y == nearest {
            at.y += step.y;
            next.y += steps.y;
        } else {
            at.z += step.z;
            next.z += steps.z;
        }
        if any(at < vec3i(0)) || any(at >= vec3i(fur_grid.size)) || z >= leave {
            break;
        }
    }
    return sum * fur_grid.cell;
}
