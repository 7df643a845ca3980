import * as THREE from 'three';

const NONE = 0xffffffff;
const ROWS = 9; // Of vertices, so that a fin bends with the hair, and light falls off into the fur.

/** A strip of quads for each edge, as instances that the vertex shader turns into fins. */
export function finGeometry(skin, edges, u) {
  const geometry = new THREE.InstancedBufferGeometry();
  const rows = Array.from({ length: ROWS }, (_, i) => i / (ROWS - 1));
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(rows.flatMap((y) => [0, y, 0, 1, y, 0])), 3));
  geometry.setIndex(rows.slice(1).flatMap((_, i) => [0, 1, 2, 2, 1, 3].map((k) => 2 * i + k)));
  const add = (name, size, values) => geometry.setAttribute(name, new THREE.InstancedBufferAttribute(new Float32Array(values), size));
  const column = (attribute, k) => Array.from({ length: edges.count }, (_, i) => {
    const v = edges.getComponent(i, k);
    return v === NONE ? null : new THREE.Vector3().fromBufferAttribute(attribute, v);
  });
  const [a, b, c, d] = [0, 1, 2, 3].map((k) => column(skin.attributes.position, k));
  const normal = (a, b, c) => b.clone().sub(a).cross(c.clone().sub(a)).normalize();
  const first = a.map((_, i) => normal(a[i], b[i], c[i]));
  // An edge without a neighbour is always on the silhouette: its missing face all but turns away.
  const second = a.map((_, i) => (d[i] ? normal(b[i], a[i], d[i]) : first[i].clone().multiplyScalar(-0.999)));
  const flat = (vectors) => vectors.flatMap((v) => v.toArray());
  const names = { position: 'position', fur: '_fur', fur1: '_fur_1', fur2: '_fur_2' };
  for (const [name, attribute] of Object.entries(names)) {
    ['A', 'B'].forEach((end, k) => add(name + end, 3, flat(column(skin.attributes[attribute], k))));
  }
  // Colour and u: there are 16 attributes at most.
  const colors = [0, 1].map((k) => column(skin.attributes._fur_color, k));
  ['A', 'B'].forEach((end, k) => add('color' + end, 4, colors[k].flatMap((c, i) => [...c.toArray(), u.getComponent(i, k)])));
  // Across the edge, square to the fur that stands on it.
  const [upA, upB] = [0, 1].map((k) => column(skin.attributes._fur_normal, k));
  add('across', 3, flat(a.map((_, i) => b[i].clone().sub(a[i]).cross(upA[i].add(upB[i])).normalize())));
  add('normalA', 3, flat(first));
  add('normalB', 3, flat(second));
  return geometry;
}
