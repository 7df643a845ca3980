// Opens a report of `pelage figure` in headless Chromium: no complaint on the console, every picture loads, every link leads to a
// file, every slider moves what is seen. Takes a picture of each figure and a PDF of the page.
// node test.mjs INDEX.html FOLDER. Chromium is CHROMIUM, or the system's.
import { mkdir, writeFile } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import puppeteer from 'puppeteer-core';

const fail = (text) => { console.error(`web/report: ${text}`); process.exit(1); };
const [index, out] = process.argv.slice(2);
if (!out) fail('usage: node test.mjs INDEX.html FOLDER');
const places = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];
const chromium = process.env.CHROMIUM ?? places.find(existsSync) ?? fail('no Chromium: set CHROMIUM to its path');
await mkdir(out, { recursive: true });

const browser = await puppeteer.launch({ executablePath: chromium, args: ['--no-sandbox', '--force-color-profile=srgb'] });
const complaints = [];
try {
  const page = await browser.newPage();
  await page.setViewport({ width: 1240, height: 900 });
  page.on('console', (m) => ['error', 'warn', 'warning'].includes(m.type()) && complaints.push(`console: ${m.text()}`));
  page.on('pageerror', (e) => complaints.push(`page: ${e.message}`));
  page.on('requestfailed', (r) => complaints.push(`request: ${r.url()} ${r.failure()?.errorText}`));
  page.on('request', (r) => /^(file|data):/.test(r.url()) || complaints.push(`not from beside the page: ${r.url()}`));
  await page.goto(pathToFileURL(resolve(index)).href, { waitUntil: 'load', timeout: 120_000 });

  const pictures = await page.$$eval('img', (all) => all.map((i) => ({ src: i.src, loaded: i.complete && i.naturalWidth > 0 })));
  if (!pictures.length) complaints.push('the page shows no picture');
  pictures.filter((p) => !p.loaded).forEach((p) => complaints.push(`not loaded: ${p.src}`));
  const links = await page.$$eval('a[href]', (all) => all.map((a) => a.href));
  const files = links.map((href) => new URL(href)).filter((url) => url.protocol === 'file:' && !url.hash);
  files.filter((url) => !existsSync(fileURLToPath(url))).forEach((url) => complaints.push(`link to nothing: ${url}`));
  const targets = await page.$$eval('nav a', (all) => all.map((a) => [a.hash, !!document.querySelector(a.hash)]));
  targets.filter(([, there]) => !there).forEach(([hash]) => complaints.push(`no section ${hash}`));

  const wipes = await page.$$('.wipe');
  for (const [k, wipe] of wipes.entries()) {
    const area = await wipe.$('div');
    const seen = async (value) => {
      await wipe.$eval('input', (slider, to) => { slider.value = to; slider.dispatchEvent(new Event('input')); }, value);
      return area.screenshot({ type: 'png', encoding: 'base64' });
    };
    const [right, middle, left] = [await seen(0), await seen(50), await seen(100)];
    const name = await wipe.$eval('figcaption', (c) => c.innerText.replaceAll('\n', ' | '));
    if (right === left) complaints.push(`slider ${k + 1} (${name}): both ends look the same`);
    if (middle === left || middle === right) complaints.push(`slider ${k + 1} (${name}): the middle looks like an end`);
    await seen(50);
  }
  for (const section of await page.$$('section')) {
    const id = await section.evaluate((s) => s.id);
    await writeFile(join(out, `${id}.png`), await section.screenshot({ type: 'png' }));
  }
  await writeFile(join(out, 'figures.pdf'), await page.pdf({ format: 'A4', printBackground: true, margin: { top: '12mm', bottom: '12mm', left: '10mm', right: '10mm' } }));
  console.log(`${pictures.length} pictures, ${files.length} links, ${wipes.length} sliders, ${targets.length} figures`);
} finally {
  await browser.close();
}
if (complaints.length) fail(complaints.join('\n'));
