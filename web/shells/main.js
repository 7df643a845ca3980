// Shows the fur of `pelage bake --gltf`: the skin, fins on it, then shells from the skin outwards.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { read } from 'three/addons/libs/ktx-parse.module.js';
import { skin, shells, fins } from './shaders.js';

const query = new URLSearchParams(location.search);
const folder = query.get('fur') ?? 'fur/';

/** A KTX2 file of 8-bit sRGB with all its mips; three.js has no loader for uncompressed array textures. */
async function texture(name) {
  const answer = await fetch(folder + name);
  if (!answer.ok) throw new Error(`${folder}${name}: ${answer.status} ${answer.statusText}`);
  const file = read(new Uint8Array(await answer.arrayBuffer()));
  if (file.vkFormat !== 43) throw new Error(`${name}: VkFormat ${file.vkFormat}, expected 43 (R8G8B8A8_SRGB)`);
  const { pixelWidth: width, pixelHeight: height } = file;
  const mips = file.levels.map(({ levelData }, i) => ({
    data: levelData, width: Math.max(1, width >> i), height: Math.max(1, height >> i),
  }));
  const made = new THREE.CompressedArrayTexture(mips, width, height, Math.max(1, file.layerCount), THREE.RGBAFormat);
  return Object.assign(made, {
    colorSpace: THREE.SRGBColorSpace, minFilter: THREE.LinearMipmapLinearFilter, magFilter: THREE.LinearFilter,
    wrapS: THREE.RepeatWrapping, wrapT: THREE.RepeatWrapping, anisotropy: 8, needsUpdate: true,
  });
}

/** One quad an edge, turned into a fin by the vertex shader. */
function finGeometry(skin, edges, u) {
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0]), 3));
  geometry.setIndex([0, 1, 2, 2, 1, 3]);
  const { position, _fur, _fur_color } = skin.attributes;
  const add = (name, size, values) => geometry.setAttribute(name, new THREE.InstancedBufferAttribute(new Float32Array(values), size));
  const column = (attribute, k) => Array.from({ length: edges.count }, (_, i) => {
    const v = edges.getComponent(i, k);
    return [attribute.getX(v), attribute.getY(v), attribute.getZ(v)];
  });
  const [a, b, c, d] = [0, 1, 2, 3].map((k) => column(position, k).map((p) => new THREE.Vector3(...p)));
  const normal = (a, b, c) => b.clone().sub(a).cross(c.clone().sub(a)).normalize();
  const first = a.map((_, i) => normal(a[i], b[i], c[i]));
  // An edge without a neighbour is always on the silhouette: its missing face looks the other way.
  const second = a.map((_, i) => (edges.getW(i) === 0xffffffff ? first[i].clone().negate() : normal(b[i], a[i], d[i])));
  ['A', 'B'].forEach((end, k) => {
    add('position' + end, 3, column(position, k).flat());
    add('fur' + end, 3, column(_fur, k).flat());
    add('color' + end, 3, column(_fur_color, k).flat());
  });
  add('normalA', 3, first.flatMap((n) => n.toArray()));
  add('normalB', 3, second.flatMap((n) => n.toArray()));
  add('u', 2, u.array);
  return geometry;
}

async function main() {
  const gltf = await new GLTFLoader().loadAsync(folder + 'fur.gltf');
  const fur = gltf.userData.pelage;
  const [layers, fin, edges, u, own] = await Promise.all([
    texture(fur.layers_texture), texture(fur.fin_texture),
    gltf.parser.getDependency('accessor', fur.fins.edges), gltf.parser.getDependency('accessor', fur.fins.u),
    query.has('view') ? fetch(query.get('view')).then((r) => r.json()) : {},
  ]);
  const view = { ...fur.view, ...own };
  const set = fur.shells;
  for (const key of ['shells', 'fins', 'depth_write']) if (query.has(key)) set[key] = query.get(key) === '1';

  const skinGeometry = gltf.scene.getObjectByName('fur').geometry; // In cm: the node's scale to metres is left out.
  const shellGeometry = Object.assign(new THREE.InstancedBufferGeometry().copy(skinGeometry), { instanceCount: set.layers });
  const lights = view.lights.map((l) => ({ direction: new THREE.Vector3(...l.direction), irradiance: new THREE.Vector3(...l.irradiance) }));
  const material = (part, more) => new THREE.ShaderMaterial({
    ...part, glslVersion: THREE.GLSL3, defines: { LIGHTS: Math.max(1, lights.length), FUR_UV: fur.fur_texcoord ? 'uv1' : 'uv' },
    uniforms: {
      layers: { value: layers }, fin: { value: fin }, lights: { value: lights }, table: { value: set.table },
      eye: { value: camera.position }, count: { value: fur.manifest.layers }, drawn: { value: set.layers },
      fade: { value: ['cosine', 'threshold', 'both'].indexOf(set.fade) }, threshold: { value: set.fin_threshold },
    }, ...more,
  });
  const blend = { // Colours are premultiplied.
    transparent: true, blending: THREE.CustomBlending, premultipliedAlpha: true,
    blendSrc: THREE.OneFactor, blendDst: THREE.OneMinusSrcAlphaFactor,
  };
  const size = [view.width, view.height];
  const camera = new THREE.PerspectiveCamera(view.camera.fov, size[0] / size[1], view.camera.near, 1000 * view.camera.near + 1000);
  camera.up.set(...view.camera.up);
  camera.position.set(...view.camera.eye);
  const scene = new THREE.Scene();
  if (view.background) scene.background = new THREE.Color(...view.background);
  [ // In this order: three.js sorts by renderOrder first.
    new THREE.Mesh(skinGeometry, material(skin)),
    set.fins && new THREE.Mesh(finGeometry(skinGeometry, edges, u), material(fins, { ...blend, side: THREE.DoubleSide, depthWrite: false })),
    set.shells && new THREE.Mesh(shellGeometry, material(shells, { ...blend, depthWrite: set.depth_write })),
  ].filter(Boolean).forEach((mesh, i) => scene.add(Object.assign(mesh, { renderOrder: i, frustumCulled: false })));

  // Blended in linear light: the buffer is a float one, and tone mapping and sRGB come after it.
  const renderer = new THREE.WebGLRenderer({ antialias: true, outputBufferType: THREE.HalfFloatType });
  renderer.toneMapping = { none: THREE.LinearToneMapping, neutral: THREE.NeutralToneMapping, agx: THREE.AgXToneMapping }[view.tonemap] ?? THREE.ACESFilmicToneMapping;
  renderer.toneMappingExposure = 2 ** view.exposure;
  renderer.setSize(...size);
  document.body.append(renderer.domElement);
  const controls = new OrbitControls(camera, renderer.domElement);
  controls.target.set(...view.camera.target);
  controls.update();
  const draw = () => renderer.render(scene, camera);
  controls.addEventListener('change', draw);
  draw();
  window.ready = true;
}

main().catch((fault) => {
  document.getElementById('fault').textContent = String(fault);
  throw fault;
});
