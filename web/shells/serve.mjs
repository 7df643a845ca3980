// Serves this page on the loopback, and a folder of `pelage bake --gltf` as fur/ below it: node serve.mjs FOLDER [PORT]
import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { dirname, extname, join, normalize, resolve } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const page = dirname(fileURLToPath(import.meta.url));
const types = { '.html': 'text/html', '.js': 'text/javascript', '.json': 'application/json', '.gltf': 'model/gltf+json' };

/** Starts to serve; resolves to the server once it listens. Port 0 is any free one. */
export function serve(fur, port = 0) {
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname));
    const file = path.startsWith('/fur/') ? join(resolve(fur), path.slice(5)) : join(page, path === '/' ? 'index.html' : path);
    try {
      const body = await readFile(file);
      response.writeHead(200, { 'content-type': types[extname(file)] ?? 'application/octet-stream' }).end(body);
    } catch {
      response.writeHead(404).end();
    }
  });
  return new Promise((done, fail) => server.once('error', fail).listen(port, '127.0.0.1', () => done(server)));
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  const [fur, port] = process.argv.slice(2);
  if (!fur) {
    console.error('usage: node serve.mjs FOLDER [PORT]   (FOLDER is written by pelage bake --gltf)');
    process.exit(2);
  }
  const server = await serve(fur, Number(port ?? 8000));
  console.log(`http://localhost:${server.address().port}/`);
}
