// The peer's side of the comparison: three.js with headless-gl, set up as an experienced user would for speed.
//
// base: the materials of the file, with transmission 0, lit by the file's lights and by a prefiltered environment.
// all:  "floor" shows a mirrored view of the size of the frame; "chrome" a cube of 6 x 256 x 256 texels that is
//       captured for every frame; "glass" refracts a cube that is captured once; "pane" is blended and reflects a
//       prefiltered cube that is captured once. None of these materials uses three's transmission pass.
// full: as all, with a shadow map of 512 x 512 texels for each face around each light, drawn once and read without a filter.
//       There is no light between surfaces.
// Like the presets draft and standard, all have one sample per pixel and no anisotropic filtering.
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { pathToFileURL, fileURLToPath } from 'node:url';
import createContext from 'gl';
import sharp from 'sharp';
globalThis.self ??= globalThis;  // GLTFLoader reads it
const THREE = await import('three');
const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
const { Reflector } = await import('three/addons/objects/Reflector.js');

const kCubeSize = 256, kShadowSize = 512, kGlassIor = 1.5;
const kGlass = ['glass', 'pane'];
sharp.cache(false);

// Buffers of a glTF file, from the disk.
THREE.FileLoader.prototype.load = function (url, done, _, fail) {
  try {
    const bytes = readFileSync(fileURLToPath(new URL(url, this.path || undefined)));
    const text = this.responseType !== 'arraybuffer';
    done(text ? bytes.toString() : bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  } catch (error) {
    fail ? fail(error) : console.error(error);
  }
};

// Textures of a glTF file, from the disk or its buffers: decoded by sharp, since Node has no images.
const texturesFromDisk = (folder) => (parser) => ({
  name: 'textures-from-disk',
  async loadTexture(index) {
    const { json } = parser, definition = json.textures[index];
    const image = json.images[definition.source ?? definition.extensions?.EXT_texture_webp?.source];
    const encoded = image.uri === undefined ? Buffer.from(await parser.getDependency('bufferView', image.bufferView))
      : join(folder, decodeURIComponent(image.uri));
    const { data, info } = await sharp(encoded).ensureAlpha().raw().toBuffer({ resolveWithObject: true });
    const texture = new THREE.DataTexture(data, info.width, info.height);
    const sampler = json.samplers?.[definition.sampler] ?? {};
    const wrap = (code) => ({ 33071: THREE.ClampToEdgeWrapping, 33648: THREE.MirroredRepeatWrapping })[code] ?? THREE.RepeatWrapping;
    Object.assign(texture, { magFilter: THREE.LinearFilter, minFilter: THREE.LinearMipmapLinearFilter, generateMipmaps: true,
      wrapS: wrap(sampler.wrapS), wrapT: wrap(sampler.wrapT), flipY: false, needsUpdate: true });
    parser.associations.set(texture, { textures: index });
    return texture;
  },
});

// The mirrored view times the colour of the metal, as three's own reflector with the default colour.
const mirrorShader = {
  name: 'MirrorShader',
  uniforms: { color: { value: null }, tDiffuse: { value: null }, textureMatrix: { value: null } },
  vertexShader: `
    uniform mat4 textureMatrix;
    varying vec4 vUv;
    void main() {
      vUv = textureMatrix * vec4(position, 1.0);
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    }`,
  fragmentShader: `
    uniform vec3 color;
    uniform sampler2D tDiffuse;
    varying vec4 vUv;
    void main() {
      gl_FragColor = vec4(color * texture2DProj(tDiffuse, vUv).rgb, 1.0);
      #include <tonemapping_fragment>
      #include <colorspace_fragment>
    }`,
};

export class Peer {
  // sky: radiance by the vertical component of a direction.
  static async create({ scene, size, sky, skySize, quality = 85 }) {
    const peer = new Peer();
    Object.assign(peer, { size_: size, quality_: quality, pixels_: Buffer.alloc(size.width * size.height * 4), effects_: false });
    const gl = createContext(size.width, size.height, { createWebGL2Context: true, antialias: false, alpha: false, stencil: false,
      preserveDrawingBuffer: true });
    if (!gl) throw new Error('headless-gl gives no context: is there an X display?');
    peer.gl_ = gl;
    const canvas = { ...size, style: {}, addEventListener() {}, removeEventListener() {}, getContext: () => gl };
    const renderer = peer.renderer_ = new THREE.WebGLRenderer({ canvas, context: gl, antialias: false, powerPreference: 'high-performance' });
    renderer.debug.checkShaderErrors = process.env.PEER_CHECKS === '1';
    renderer.toneMapping = THREE.NeutralToneMapping;
    renderer.info.autoReset = false;
    Object.assign(renderer.shadowMap, { enabled: true, type: THREE.BasicShadowMap, autoUpdate: false });

    const loader = new GLTFLoader().register(texturesFromDisk(dirname(scene)));
    const bytes = readFileSync(scene);
    const content = scene.endsWith('.glb') ? bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length) : bytes.toString();
    const file = await loader.parseAsync(content, pathToFileURL(dirname(scene)).href + '/');
    peer.scene_ = new THREE.Scene().add(file.scene);
    peer.environment_(sky, skySize);
    const extent = new THREE.Box3().setFromObject(file.scene).getSize(new THREE.Vector3()).length();
    peer.camera_ = new THREE.PerspectiveCamera(50, size.width / size.height, 0.003 * extent, 20 * extent);
    peer.named_ = new Map();
    file.scene.traverse((object) => { if (object.isMesh) peer.prepareBase_(object); });
    file.scene.updateMatrixWorld(true);
    file.scene.traverse((object) => { object.matrixAutoUpdate = false; });
    return peer;
  }

  get driver() {
    return this.gl_._getParameterDirect?.(this.gl_.RENDERER) ?? this.gl_.getParameter(this.gl_.RENDERER);
  }

  // mode: base, all or full. Draws the shadow maps, and captures the cubes that are captured once.
  setMode(mode) {
    this.effects_ = mode !== 'base';
    this.castShadows_(mode === 'full');
    if (this.effects_) this.prepareAll_();
    for (const [mesh, materials] of this.materials_) mesh.material = (this.effects_ && materials.all) || materials.base;
    if (this.mirror_) {
      this.mirror_.visible = this.effects_;
      this.named_.get('floor').visible = !this.effects_;
    }
  }

  // One frame: milliseconds of drawing, of reading the pixels and of encoding them, and the JPEG file.
  async frame(pose) {
    const gl = this.gl_, camera = this.camera_;
    const start = performance.now();
    camera.fov = THREE.MathUtils.radToDeg(pose.yfov);
    camera.position.fromArray(pose.position);
    camera.lookAt(...pose.target);
    camera.updateProjectionMatrix();
    this.renderer_.info.reset();
    if (this.effects_ && this.liveCube_) this.capture_(this.liveCube_, this.named_.get('chrome'));
    this.renderer_.render(this.scene_, camera);
    gl.finish();
    const drawn = performance.now();
    gl.readPixels(0, 0, this.size_.width, this.size_.height, gl.RGBA, gl.UNSIGNED_BYTE, this.pixels_);
    const read = performance.now();
    const picture = await sharp(this.pixels_, { raw: { ...this.size_, channels: 4 } }).removeAlpha().flip()
      .jpeg({ quality: this.quality_, chromaSubsampling: '4:2:0', optimiseCoding: false }).toBuffer();
    const end = performance.now();
    return { total: end - start, draw: drawn - start, read: read - drawn, encode: end - read, picture,
      draws: this.renderer_.info.render.calls, triangles: this.renderer_.info.render.triangles };
  }

  close() {
    this.gl_.getExtension('STACKGL_destroy_context')?.destroy();
  }

  environment_(sky, { width, height }) {
    const texels = new Float32Array(width * height * 4);
    for (let row = 0; row < height; ++row) {
      const radiance = sky(-Math.cos(Math.PI * (row + 0.5) / height));  // the first row is -Y
      for (let column = 0; column < width; ++column) texels.set([...radiance, 1], (row * width + column) * 4);
    }
    const image = new THREE.DataTexture(texels, width, height, THREE.RGBAFormat, THREE.FloatType);
    Object.assign(image, { mapping: THREE.EquirectangularReflectionMapping, magFilter: THREE.LinearFilter,
      minFilter: THREE.LinearFilter, needsUpdate: true });
    this.scene_.background = image;
    this.prefilter_ = new THREE.PMREMGenerator(this.renderer_);
    this.scene_.environment = this.prefilter_.fromEquirectangular(image).texture;
  }

  // Glass casts no shadow.
  castShadows_(on) {
    this.scene_.traverse((object) => {
      if (object.isLight) {
        object.castShadow = on;
        object.shadow?.mapSize.set(kShadowSize, kShadowSize);
      }
      if (!object.isMesh) return;
      object.castShadow = on && !object.material.transparent && !kGlass.includes(object.material.name);
      object.receiveShadow = on;
    });
    this.renderer_.shadowMap.needsUpdate = on;
  }

  prepareBase_(mesh) {
    this.materials_ ??= new Map();
    let material = mesh.material;
    const layered = ['clearcoat', 'sheen', 'iridescence', 'anisotropy'].some((layer) => material[layer] > 0);
    if (material.isMeshPhysicalMaterial && layered) {
      material.transmission = 0;
    } else if (material.isMeshPhysicalMaterial) {  // glass without transmission is an opaque dielectric: the cheaper type
      material = new THREE.MeshStandardMaterial({ name: material.name, color: material.color, metalness: material.metalness,
        roughness: material.roughness, side: material.side, map: material.map, normalMap: material.normalMap, normalScale: material.normalScale,
        metalnessMap: material.metalnessMap, roughnessMap: material.roughnessMap, aoMap: material.aoMap, emissive: material.emissive,
        emissiveMap: material.emissiveMap });
    }
    this.materials_.set(mesh, { base: material });
    this.named_.set(material.name, mesh);
    mesh.material = material;
  }

  prepareAll_() {
    if (this.prepared_) return;
    this.prepared_ = true;
    const set = (name, material) => { this.materials_.get(this.named_.get(name)).all = material; };
    const { named_: named } = this;
    const floor = named.get('floor'), chrome = named.get('chrome'), glass = named.get('glass'), pane = named.get('pane');
    if (!floor || !chrome || !glass || !pane || named.size > 5) return;  // only rooms have such parts

    const bounds = new THREE.Box3().setFromObject(floor), extent = bounds.getSize(new THREE.Vector3());
    this.mirror_ = new Reflector(new THREE.PlaneGeometry(extent.x, extent.z), { textureWidth: this.size_.width,
      textureHeight: this.size_.height, multisample: 0, shader: mirrorShader, color: floor.material.color });
    bounds.getCenter(this.mirror_.position);
    this.mirror_.rotation.x = -Math.PI / 2;
    this.mirror_.visible = false;
    this.scene_.add(this.mirror_);

    const once = (mesh, mapping) => {
      const cube = this.cube_(mesh, mapping);
      this.capture_(cube, mesh);
      return cube.renderTarget.texture;
    };
    // Only cubes show this floor.
    const around = this.cube_(floor, THREE.CubeReflectionMapping);
    around.position.y += 1;
    this.capture_(around, floor, chrome);
    const inCubes = floor.material.clone();
    inCubes.envMap = this.prefilter_.fromCubemap(around.renderTarget.texture).texture;
    set('floor', inCubes);
    floor.material = inCubes;
    set('glass', new THREE.MeshBasicMaterial({ envMap: once(glass, THREE.CubeRefractionMapping), refractionRatio: 1 / kGlassIor }));
    const behind = this.prefilter_.fromCubemap(once(pane, THREE.CubeReflectionMapping)).texture;
    set('pane', new THREE.MeshStandardMaterial({ color: pane.material.color, transparent: true, opacity: 0.1, roughness: 0, metalness: 0,
      envMap: behind, side: THREE.DoubleSide, depthWrite: false }));
    this.liveCube_ = this.cube_(chrome, THREE.CubeReflectionMapping);
    set('chrome', new THREE.MeshBasicMaterial({ color: chrome.material.color, envMap: this.liveCube_.renderTarget.texture }));
  }

  cube_(mesh, mapping) {
    const target = new THREE.WebGLCubeRenderTarget(kCubeSize, { type: THREE.HalfFloatType, generateMipmaps: true,
      minFilter: THREE.LinearMipmapLinearFilter });
    target.texture.mapping = mapping;
    const cube = new THREE.CubeCamera(0.05, 200, target);
    new THREE.Box3().setFromObject(mesh).getCenter(cube.position);
    return cube;
  }

  // The cube without the objects at its centre, and with a floor that is no mirror: one mirrored view per frame.
  capture_(cube, ...hidden) {
    const { mirror_: mirror } = this, floor = this.named_.get('floor');
    const mirrored = mirror.visible;
    mirror.visible = false;
    floor.visible = true;
    for (const mesh of hidden) mesh.visible = false;
    cube.update(this.renderer_, this.scene_);
    for (const mesh of hidden) mesh.visible = true;
    mirror.visible = mirrored;
    floor.visible = !mirrored;
  }
}
