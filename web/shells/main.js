// Shows the fur of `pelage bake --gltf`: the skin, fins on it, then shells from the skin outwards.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { finGeometry } from './fins.js';
import { skin, shells, fins } from './shaders.js';
import { deepen, texture } from './texture.js';

const query = new URLSearchParams(location.search);
const folder = query.get('fur') ?? 'fur/';

async function main() {
  const gltf = await new GLTFLoader().loadAsync(folder + 'fur.gltf');
  const fur = gltf.userData.pelage;
  const [layers, fin, edges, u, own] = await Promise.all([
    texture(folder + fur.layers_texture, THREE.RepeatWrapping), texture(folder + fur.fin_texture, THREE.ClampToEdgeWrapping),
    gltf.parser.getDependency('accessor', fur.fins.edges), gltf.parser.getDependency('accessor', fur.fins.u),
    query.has('view') ? fetch(query.get('view')).then((r) => r.json()) : {},
  ]);
  const view = { ...fur.view, ...own };
  const set = fur.shells;
  for (const key of ['shells', 'fins', 'depth_write', 'slanted']) if (query.has(key)) set[key] = query.get(key) === '1';

  deepen(fin, set.slanted ? fur.fins.depth : 1, fur.fins.rows);

  const skinGeometry = gltf.scene.getObjectByName('fur').geometry; // In cm: the node's scale to metres is left out.
  const shellGeometry = Object.assign(new THREE.InstancedBufferGeometry().copy(skinGeometry), { instanceCount: set.layers });
  // A layer is an instance: its means, and how hairs stray in it.
  const each = (name, size, of) => shellGeometry.setAttribute(name, new THREE.InstancedBufferAttribute(
    new Float32Array(fur.strays.flatMap((stray, l) => of(stray, fur.manifest.summary[l]))), size));
  each('mean', 4, (stray, layer) => [...layer.color, layer.coverage]);
  each('lean', 4, ({ lean }) => (lean ? [...lean, 1] : [0, 0, 0, 0]));
  each('stray', 2, ({ variance, guard }) => [variance, guard]);
  const lights = view.lights.map((l) => ({ direction: new THREE.Vector3(...l.direction), irradiance: new THREE.Vector3(...l.irradiance) }));
  const material = (part, more) => new THREE.ShaderMaterial({
    ...part, glslVersion: THREE.GLSL3, defines: { LIGHTS: Math.max(1, lights.length), FUR_UV: fur.fur_texcoord ? 'uv1' : 'uv' },
    uniforms: {
      layers: { value: layers }, fin: { value: fin }, lights: { value: lights }, table: { value: set.table },
      eye: { value: camera.position }, count: { value: fur.manifest.layers }, drawn: { value: set.layers },
      slanted: { value: set.slanted }, edge: { value: set.slanted && set.fins }, guard_variance: { value: fur.guard_variance },
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
