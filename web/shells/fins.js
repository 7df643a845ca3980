import * as THREE from 'three';

/** One quad an edge, turned into a fin by the vertex shader. */
export function finGeometry(skin, edges, u) {
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
