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
