// Validates a glTF of `pelage bake --gltf`, opens the page in headless Chromium and takes a picture of what it draws:
// node test.mjs FOLDER PICTURE.png [QUERY]. Chromium is CHROMIUM, or the system's.
import { readFile, writeFile } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import puppeteer from 'puppeteer-core';
import validator from 'gltf-validator';
import { serve } from './serve.mjs';

const fail = (text) => { console.error(`web/shells: ${text}`); process.exit(1); };
const [folder, picture, query = ''] = process.argv.slice(2);
if (!picture) fail('usage: node test.mjs FOLDER PICTURE.png [QUERY]');
const places = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];
const chromium = process.env.CHROMIUM ?? places.find(existsSync) ?? fail('no Chromium: set CHROMIUM to its path');

const document = await readFile(join(folder, 'fur.gltf'));
const { issues } = await validator.validateBytes(new Uint8Array(document), {
  uri: 'fur.gltf',
  externalResourceFunction: async (uri) => new Uint8Array(await readFile(join(folder, decodeURIComponent(uri)))),
});
console.log(`glTF: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
const serious = issues.messages.filter((m) => m.severity < 2);
if (serious.length) fail(serious.slice(0, 20).map((m) => `${m.code} ${m.pointer}: ${m.message}`).join('\n'));

const server = await serve(folder);
const browser = await puppeteer.launch({
  executablePath: chromium,
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--force-color-profile=srgb'],
});
const complaints = [];
try {
  const page = await browser.newPage();
  const { view } = JSON.parse(document).extras.pelage;
  await page.setViewport({ width: view.width, height: view.height });
  page.on('console', (m) => ['error', 'warn', 'warning'].includes(m.type()) && complaints.push(`console: ${m.text()}`));
  page.on('pageerror', (e) => complaints.push(`page: ${e.message}`));
  page.on('requestfailed', (r) => complaints.push(`request: ${r.url()} ${r.failure()?.errorText}`));
  await page.goto(`http://127.0.0.1:${server.address().port}/?${query}`);
  const started = Date.now();
  await page.waitForFunction('window.ready || document.getElementById("fault").textContent', { timeout: 120_000 });
  const fault = await page.$eval('#fault', (e) => e.textContent);
  if (fault) complaints.push(fault);
  await writeFile(picture, await page.screenshot({ type: 'png' }));
  console.log(`${picture}: drawn after ${((Date.now() - started) / 1000).toFixed(1)} s`);
} finally {
  await browser.close();
  server.close();
}
// Software rendering reads pixels back, and says so.
const real = complaints.filter((c) => !/GPU stall due to ReadPixels|swiftshader/i.test(c));
if (real.length) fail(real.join('\n'));
