import math
import os
import struct
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

FOLDER = os.path.dirname(os.path.abspath(__file__))
# Blender's z points up; the files' y does.
UPRIGHT = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def beside(name):
    return os.path.join(FOLDER, name)


def read_hair(path):
    """Segments a curve, points, diameters and colours of a HAIR file with all its arrays."""
    with open(path, "rb") as file:
        magic, curves, points, flags = struct.unpack("<4s3I", file.read(16))
        if magic != b"HAIR" or flags != 31:
            raise ValueError(f"{path}: not a HAIR file with all arrays")
        file.seek(128)
        segments = np.fromfile(file, "<u2", curves)
        xyz = np.fromfile(file, "<f4", 3 * points).reshape(-1, 3)
        diameter = np.fromfile(file, "<f4", points)
        file.seek(4 * points, os.SEEK_CUR)
        color = np.fromfile(file, "<f4", 3 * points).reshape(-1, 3)
    return segments, xyz, diameter, color


def read_ply(path):
    """Positions, colours, uv (None where there are none) and triangles of a PLY file."""
    with open(path, "rb") as file:
        names, counts, line = [], {}, b""
        while line.strip() != b"end_header":
            line = file.readline()
            words = line.split()
            if words[:1] == [b"element"]:
                counts[words[1]] = int(words[2])
            names += words[2:] if words[:2] == [b"property", b"float"] else []
        vertices = np.fromfile(file, "<f4", len(names) * counts[b"vertex"]).reshape(-1, len(names))
        faces = np.fromfile(file, [("n", "u1"), ("v", "<i4", 3)], counts[b"face"])
    colors = vertices[:, 6:9] if b"r" in names else None
    uv = vertices[:, 6:8] if b"u" in names else None
    return vertices[:, :3], colors, uv, faces["v"]


def new_material(name):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    return material, nodes, material.node_tree.links, nodes.new("ShaderNodeOutputMaterial")


def attribute_node(nodes, name):
    node = nodes.new("ShaderNodeAttribute")
    node.attribute_type = "GEOMETRY"
    node.attribute_name = name
    return node


def add_object(name, data, matrix):
    thing = bpy.data.objects.new(name, data)
    thing.matrix_world = matrix
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_surface(name, file, color, material, socket):
    """Adds the surface of a PLY file; its colour, image or colours of vertices go into a socket."""
    material, nodes, links = material
    xyz, colors, uv, triangles = read_ply(beside(file))
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(xyz.tolist(), [], triangles.tolist())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(triangles), bool))
    if isinstance(color, str):
        mesh.uv_layers.new(name="uv").data.foreach_set("uv", uv[triangles.ravel()].ravel())
        image = nodes.new("ShaderNodeTexImage")
        image.image = bpy.data.images.load(beside(color))
        image.image.colorspace_settings.is_data = True
        links.new(image.outputs["Color"], socket)
    elif color is not None:
        socket.default_value = (*color, 1)
    else:
        rgba = np.ones((len(xyz), 4), np.float32)
        rgba[:, :3] = colors
        mesh.attributes.new("surface_color", "FLOAT_COLOR", "POINT").data.foreach_set("color", rgba.ravel())
        links.new(attribute_node(nodes, "surface_color").outputs["Color"], socket)
    mesh.materials.append(material)
    return add_object(name, mesh, UPRIGHT)


def add_skin():
    material, nodes, links, output = new_material("skin")
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    links.new(diffuse.outputs["BSDF"], output.inputs["Surface"])
    add_surface("skin", "skin.ply", SKIN_COLOR, (material, nodes, links), diffuse.inputs["Color"])


def add_thing(thing):
    material, nodes, links, output = new_material(thing["name"])
    surface = nodes.new("ShaderNodeBsdfPrincipled")
    links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    surface.inputs["IOR"].default_value = 1.5
    surface.inputs["Roughness"].default_value = thing["roughness"]
    surface.inputs["Metallic"].default_value = thing["metallic"]
    surface.inputs["Coat Weight"].default_value = thing["clearcoat"]
    surface.inputs["Coat Roughness"].default_value = thing["clearcoat_roughness"]
    surface.inputs["Coat IOR"].default_value = 1.5
    parts = (material, nodes, links)
    added = add_surface(thing["name"], thing["file"], thing["color"], parts, surface.inputs["Base Color"])
    added.is_shadow_catcher = thing["shadow_catcher"]


def hair_material(layer):
    material, nodes, links, output = new_material(layer["name"])
    hair = nodes.new("ShaderNodeBsdfHairPrincipled")
    if hasattr(hair, "model"):
        hair.model = "CHIANG"
    hair.parametrization = "ABSORPTION"
    hair.inputs["Roughness"].default_value = layer["beta_m"]
    hair.inputs["Radial Roughness"].default_value = layer["beta_n"]
    # The tilt has the opposite sign in Cycles.
    hair.inputs["Offset"].default_value = -math.radians(layer["alpha_degrees"])
    hair.inputs["IOR"].default_value = layer["ior"]
    for name in ("Coat", "Random Roughness"):
        hair.inputs[name].default_value = 0
    if layer["absorption"] is not None:
        hair.inputs["Absorption Coefficient"].default_value = layer["absorption"]
    else:
        vector = attribute_node(nodes, "absorption").outputs["Vector"]
        links.new(vector, hair.inputs["Absorption Coefficient"])
    links.new(hair.outputs["BSDF"], output.inputs["Surface"])
    return material


def add_layer(layer):
    segments, xyz, diameter, color = read_hair(beside(layer["name"] + ".hair"))
    curves = bpy.data.hair_curves.new(layer["name"])
    curves.add_curves((segments.astype(np.int32) + 1).tolist())
    curves.attributes["position"].data.foreach_set("vector", xyz.ravel())
    if "radius" not in curves.attributes:
        curves.attributes.new("radius", "FLOAT", "POINT")
    curves.attributes["radius"].data.foreach_set("value", 0.5 * diameter)
    if layer["absorption"] is None:
        absorption = (np.log(np.clip(color, layer["darkest"], 1)) / layer["fit"]) ** 2
        attribute = curves.attributes.new("absorption", "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", absorption.astype(np.float32).ravel())
    curves.materials.append(hair_material(layer))
    add_object(layer["name"], curves, UPRIGHT)


def add_camera():
    right, up, back, eye = CAMERA
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit = "VERTICAL"
    camera.sensor_height = 24
    camera.lens = 12 / TAN_Y
    camera.clip_start = NEAR
    camera.clip_end = 1e6
    if LENS is not None:
        aperture, focus = LENS
        camera.dof.use_dof = True
        camera.dof.focus_distance = focus
        camera.dof.aperture_fstop = camera.lens * 1e-3 / aperture
    matrix = Matrix((right, up, back)).transposed().to_4x4()
    matrix.translation = eye
    bpy.context.scene.camera = add_object("camera", camera, UPRIGHT @ matrix)


def add_lights():
    for number, (direction, irradiance) in enumerate(LIGHTS):
        sun = bpy.data.lights.new(f"light{number}", "SUN")
        strength = max(irradiance)
        sun.energy = strength
        sun.color = [e / strength if strength > 0 else 0 for e in irradiance]
        sun.angle = 0
        turn = Vector(direction).to_track_quat("Z", "Y").to_matrix().to_4x4()
        add_object(sun.name, sun, UPRIGHT @ turn)
    world = bpy.data.worlds.new("sky")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = nodes["Background"]
    if isinstance(SKY, str):
        texture = nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(beside(SKY))
        texture.image.colorspace_settings.is_data = True
        mapping = nodes.new("ShaderNodeMapping")
        # The centre of Blender's map is at +x, that of the files' at -z.
        mapping.inputs["Rotation"].default_value = (0, 0, -math.radians(90 + SKY_ROTATE))
        generated = nodes.new("ShaderNodeTexCoord").outputs["Generated"]
        links.new(generated, mapping.inputs["Vector"])
        links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
        links.new(texture.outputs["Color"], background.inputs["Color"])
    else:
        background.inputs["Color"].default_value = (*(SKY or (0, 0, 0)), 1)


def set_up(scene):
    scene.unit_settings.scale_length = 0.01
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = not SKY_SEEN
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_mode = "RGBA"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.samples = SAMPLES
    cycles.use_denoising = False
    cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type, cycles.filter_width = FILTER
    cycles.sample_clamp_indirect = 0
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", 64)
    cycles.transparent_max_bounces = 64
    shapes = scene.cycles_curves.bl_rna.properties["shape"].enum_items.keys()
    # Thick curves have round sections, as the hairs have; linear ones are drawn from Blender 5 on.
    scene.cycles_curves.shape = "THICK_LINEAR" if "THICK_LINEAR" in shapes else "THICK"


def build():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    add_skin()
    for thing in OBJECTS:
        add_thing(thing)
    for layer in LAYERS:
        add_layer(layer)
    add_camera()
    add_lights()
    set_up(bpy.context.scene)


build()
arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
if arguments:
    bpy.context.scene.render.filepath = os.path.abspath(arguments[0])
    bpy.ops.render.render(write_still=True)
