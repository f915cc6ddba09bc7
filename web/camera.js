// The orbit camera: plain values and pure functions. Metres and radians; right-handed, +Y up; the camera looks along its
// own -Z. At yaw 0 it looks along -Z; pitch is positive if the eye is above the target.

// Just below straight up and down, where yaw is undefined.
const kMaxPitch = Math.PI / 2 - 1e-3;
const kMinDistance = 1e-6;
const kMaxDistance = 1e8;

const add = (a, b) => a.map((x, i) => x + b[i]);
const subtract = (a, b) => a.map((x, i) => x - b[i]);
const scale = (a, s) => a.map((x) => x * s);
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

export function fromLookAt({ position, target, yfov }) {
  const toEye = subtract(position, target);
  const distance = Math.hypot(...toEye);
  if (!(distance > kMinDistance)) return { target, distance: 1, yaw: 0, pitch: 0, yfov };
  return {
    target,
    distance,
    yaw: Math.atan2(toEye[0], toEye[2]),
    pitch: clamp(Math.asin(clamp(toEye[1] / distance, -1, 1)), -kMaxPitch, kMaxPitch),
    yfov,
  };
}

// From the eye and the view direction; the orbit centre is `distance` ahead.
export function fromDirection({ position, direction, distance, yfov }) {
  const length = Math.hypot(...direction) || 1;
  return fromLookAt({ position, target: add(position, scale(direction, distance / length)), yfov });
}

// -Z rotated by a unit quaternion (x y z w).
export function forwardOf([x, y, z, w]) {
  return [-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))];
}

// The axes of the camera in world space: right, up, and from target to eye.
export function axesOf({ yaw, pitch }) {
  const [sinYaw, cosYaw, sinPitch, cosPitch] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)];
  return {
    right: [cosYaw, 0, -sinYaw],
    up: [-sinYaw * sinPitch, cosPitch, -cosYaw * sinPitch],
    toEye: [sinYaw * cosPitch, sinPitch, cosYaw * cosPitch],
  };
}

export function positionOf(camera) {
  return add(camera.target, scale(axesOf(camera).toEye, camera.distance));
}

// dx and dy in radians; positive dx moves the scene to the right, as a drag does.
export function orbit(camera, dx, dy) {
  return { ...camera, yaw: camera.yaw - dx, pitch: clamp(camera.pitch + dy, -kMaxPitch, kMaxPitch) };
}

// dx and dy as fractions of the image height: points at the depth of the target follow the pointer. Positive dy is down.
export function pan(camera, dx, dy) {
  const { right, up } = axesOf(camera);
  const metres = 2 * Math.tan(camera.yfov / 2) * camera.distance;
  return { ...camera, target: add(camera.target, add(scale(right, -dx * metres), scale(up, dy * metres))) };
}

// A factor below 1 moves closer.
export function zoom(camera, factor) {
  return { ...camera, distance: clamp(camera.distance * factor, kMinDistance, kMaxDistance) };
}

// Rotates about the eye instead of the target.
export function look(camera, dx, dy) {
  const position = positionOf(camera);
  const turned = orbit(camera, dx, dy);
  return { ...turned, target: subtract(position, scale(axesOf(turned).toEye, camera.distance)) };
}

// Translates eye and target by metres in world space.
export function moved(camera, step) {
  return { ...camera, target: add(camera.target, step) };
}

// Looks at the point and moves closer; the point becomes the orbit centre.
export function focusOn(camera, point) {
  const facing = fromLookAt({ position: positionOf(camera), target: point, yfov: camera.yfov });
  return zoom(facing, 0.6);
}

// Interpolates between two cameras, t in [0, 1]; yaw takes the shorter direction.
export function interpolate(from, to, t) {
  const mix = (a, b) => a + (b - a) * t;
  const turn = ((((to.yaw - from.yaw + Math.PI) % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI)) - Math.PI;
  return {
    target: from.target.map((x, i) => mix(x, to.target[i])),
    distance: from.distance * (to.distance / from.distance) ** t,
    yaw: from.yaw + turn * t,
    pitch: mix(from.pitch, to.pitch),
    yfov: mix(from.yfov, to.yfov),
  };
}

// Intrinsics of a 1x1 image that shows pixel (x, y) of an image of this size; x and y from the top left, may be fractions.
export function lensOfPixel(yfov, width, height, x, y) {
  const focal = height / 2 / Math.tan(yfov / 2);
  return { fx: focal, fy: focal, cx: 0.5 - (x - width / 2), cy: 0.5 - (y - height / 2) };
}

// The point that such a pixel shows at `depth` metres along the view direction.
export function pointAt(camera, { fx, fy, cx, cy }, depth) {
  const { right, up, toEye } = axesOf(camera);
  const [x, y] = [((0.5 - cx) / fx) * depth, ((cy - 0.5) / fy) * depth];
  const ahead = subtract(positionOf(camera), scale(toEye, depth));
  return add(ahead, add(scale(right, x), scale(up, y)));
}

// The vertical field of view for an image of this aspect ratio: in portrait format yfov applies to the width.
export function lensFor(yfov, aspect) {
  return aspect >= 1 ? yfov : Math.min(2.8, 2 * Math.atan(Math.tan(yfov / 2) / aspect));
}
