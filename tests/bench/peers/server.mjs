// Clerestory's side of the comparison: a server, and frames over one connection that stays open.
import { spawn } from 'node:child_process';
import { createServer } from 'node:net';
import http from 'node:http';

const freePort = () => new Promise((resolve, reject) => {
  const probe = createServer().on('error', reject).listen(0, '127.0.0.1', () => {
    const { port } = probe.address();
    probe.close(() => resolve(port));
  });
});

const effectsOf = (mode) => {
  const four = mode !== 'base', lit = mode === 'full';
  return { emission: four, refraction: four, planarReflection: four, environmentReflection: four, shadows: lit, indirectLight: lit };
};

export class Server {
  // Starts `clerestory serve` with one scene and one environment map, and waits until the scene is loaded. The renderer
  // process is the default one, without a standby (which would compile shaders while frames are measured).
  static async start({ program, scene, sky, single, size }) {
    const server = new Server();
    server.port_ = await freePort();
    server.size_ = size;
    server.agent_ = new http.Agent({ keepAlive: true, maxSockets: 1 });
    // Its allocator has settings of its own; scripts/bench sets those of the peer.
    const { MALLOC_MMAP_THRESHOLD_, MALLOC_TRIM_THRESHOLD_, ...env } = process.env;
    server.process_ = spawn(program, ['serve', '--port', String(server.port_), '--scene', scene, '--environment', sky, '--log-level',
      'error', '--first-compile', 'optimized', single ? '--single-process' : '--no-standby'], { env, stdio: ['ignore', 'ignore', 'inherit'] });
    process.once('exit', () => server.process_.kill('SIGKILL'));  // after an error here
    let ended = null;
    server.process_.on('exit', (status, signal) => { ended = `clerestory ended with ${signal ?? status}`; });
    for (const start = Date.now(); Date.now() - start < 180000; await new Promise((r) => setTimeout(r, 200))) {
      if (ended) throw new Error(ended);
      const { scenes } = await server.json_('/v1/scenes').catch(() => ({ scenes: [] }));
      const own = scenes.find((s) => s.default);
      if (!own) continue;
      const description = await server.json_(`/v1/scenes/${encodeURIComponent(own.id)}`);
      if (description.state === 'failed') throw new Error(`${scene}: ${JSON.stringify(description)}`);
      if (description.defaultView) return Object.assign(server, { view: description.defaultView });
    }
    throw new Error(`${scene} was not loaded within three minutes`);
  }

  // GET /v1/renderer: renderer and version name the driver.
  driver() {
    return this.json_('/v1/renderer');
  }

  // Waits until light between surfaces is complete, if the mode has it: its computation would slow both sides.
  async completeLight(pose, mode) {
    for (let share = 0; share < 1;) {
      const { headers } = await this.post_(this.requestOf_(pose, mode, 'standard'), { Prefer: 'wait=60' });
      share = Number(/share=([\d.]+)/.exec(headers['clerestory-light'])?.[1] ?? 1);
    }
  }

  // One frame from request to the last byte of the answer.
  async frame(pose, mode, preset, more = {}) {
    const start = performance.now();
    const answer = await this.post_({ ...this.requestOf_(pose, mode, preset), ...more });
    const total = performance.now() - start;
    if ('age' in answer.headers) throw new Error('the frame came from a cache');
    const parts = Object.fromEntries((answer.headers['server-timing'] ?? '').split(', ').map((part) => part.split(';dur='))
      .map(([name, milliseconds]) => [name, Number(milliseconds)]));
    return { total, parts, passes: answer.headers['clerestory-passes'], picture: answer.body };
  }

  async stop() {
    this.agent_.destroy();
    if (this.process_.exitCode !== null) return;
    const ended = new Promise((resolve) => this.process_.once('exit', resolve));
    this.process_.kill('SIGTERM');
    await ended;
  }

  requestOf_(pose, mode, preset) {
    return { camera: pose, ...this.size_, accuracy: preset, effects: effectsOf(mode), environment: { map: 'sky-of-bench' } };
  }

  async post_(request, headers = {}) {
    const answer = await this.send_('POST', '/v1/frames', JSON.stringify(request), headers);
    if (answer.status !== 200) throw new Error(`frame: ${answer.status} ${answer.body}`);
    return answer;
  }

  async json_(path) {
    return JSON.parse((await this.send_('GET', path)).body);
  }

  send_(method, path, body, more = {}) {
    const headers = body ? { 'Content-Type': 'application/json', 'Content-Length': Buffer.byteLength(body), ...more } : {};
    return new Promise((resolve, reject) => {
      const request = http.request({ host: '127.0.0.1', port: this.port_, method, path, headers, agent: this.agent_ }, (response) => {
        const chunks = [];
        response.on('data', (chunk) => chunks.push(chunk));
        response.on('end', () => resolve({ status: response.statusCode, headers: response.headers, body: Buffer.concat(chunks) }));
        response.on('error', reject);
      });
      request.on('error', reject);
      request.end(body);
    });
  }
}
