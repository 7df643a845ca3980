import * as THREE from 'three';
import { read } from 'three/addons/libs/ktx-parse.module.js';

/** A KTX2 file of 8-bit sRGB with all its mips; three.js has no loader for uncompressed array textures. */
export async function texture(url, wrapT) {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url}: ${answer.status} ${answer.statusText}`);
  const file = read(new Uint8Array(await answer.arrayBuffer()));
  if (file.vkFormat !== 43) throw new Error(`${url}: VkFormat ${file.vkFormat}, expected 43 (R8G8B8A8_SRGB)`);
  const { pixelWidth: width, pixelHeight: height } = file;
  const mips = file.levels.map(({ levelData }, i) => ({
    data: levelData, width: Math.max(1, width >> i), height: Math.max(1, height >> i),
  }));
  const made = new THREE.CompressedArrayTexture(mips, width, height, Math.max(1, file.layerCount), THREE.RGBAFormat);
  return Object.assign(made, {
    colorSpace: THREE.SRGBColorSpace, minFilter: THREE.LinearMipmapLinearFilter, magFilter: THREE.LinearFilter,
    wrapS: THREE.RepeatWrapping, wrapT, anisotropy: 8, needsUpdate: true,
  });
}

/** A fin that stands for fur `depth` times as deep: what a texel lets through, to that power; then mips down to `rows` rows. In half floats. */
export function deepen(fin, depth, rows) {
  let { data: bytes, width, height } = fin.mipmaps[0];
  const linear = Float32Array.from({ length: 256 }, (_, i) => new THREE.Color().setRGB(i / 255, 0, 0, THREE.SRGBColorSpace).r);
  let texels = Float32Array.from(bytes, (byte, i) => {
    const a = bytes[i | 3] / 255;
    return ((i & 3) === 3 ? a : linear[byte]) * (1 - (1 - a) ** depth) / Math.max(a, 1e-6);
  });
  const mips = [];
  for (let more = true; more;) {
    mips.push({ data: Uint16Array.from(texels, THREE.DataUtils.toHalfFloat), width, height });
    const [w, h, from, wide] = [width >> 1, height >> 1, texels, 4 * width];
    more = w > 0 && h >= rows;
    texels = Float32Array.from({ length: more ? 4 * w * h : 0 }, (_, i) => {
      const at = 2 * Math.floor(i / (4 * w)) * wide + 8 * (Math.floor(i / 4) % w) + (i & 3);
      return (from[at] + from[at + 4] + from[at + wide] + from[at + wide + 4]) / 4;
    });
    [width, height] = [w, h];
  }
  return Object.assign(fin, { mipmaps: mips, type: THREE.HalfFloatType, colorSpace: THREE.NoColorSpace });
}
