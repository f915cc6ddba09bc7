// The orbiting camera: plain values and pure functions, so that `node --test` can check the mathematics.
// Metres and radians; right-handed, +Y up; the camera looks down its own -Z. Yaw 0 looks along -Z,
// pitch is positive when the eye is above the target.

// Just short of straight up and down, where yaw would lose its meaning.
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

// From an eye and the direction it looks in; `distance` says how far ahead the centre of turning lies.
export function fromDirection({ position, direction, distance, yfov }) {
  const length = Math.hypot(...direction) || 1;
  return fromLookAt({ position, target: add(position, scale(direction, distance / length)), yfov });
}

// The direction a unit quaternion (x y z w) turns -Z to.
export function forwardOf([x, y, z, w]) {
  return [-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))];
}

function axes({ yaw, pitch }) {
  const [sinYaw, cosYaw, sinPitch, cosPitch] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)];
  return {
    right: [cosYaw, 0, -sinYaw],
    up: [-sinYaw * sinPitch, cosPitch, -cosYaw * sinPitch],
    toEye: [sinYaw * cosPitch, sinPitch, cosYaw * cosPitch],
  };
}

export function positionOf(camera) {
  return add(camera.target, scale(axes(camera).toEye, camera.distance));
}

// dx and dy in radians; positive dx turns the world to the right, as a finger drags it.
export function orbit(camera, dx, dy) {
  return { ...camera, yaw: camera.yaw - dx, pitch: clamp(camera.pitch + dy, -kMaxPitch, kMaxPitch) };
}

// dx and dy as shares of the side that yfov spans: what is at the target's depth stays under the finger.
// Positive dy is down the screen.
export function pan(camera, dx, dy) {
  const { right, up } = axes(camera);
  const metres = 2 * Math.tan(camera.yfov / 2) * camera.distance;
  return { ...camera, target: add(camera.target, add(scale(right, -dx * metres), scale(up, dy * metres))) };
}

// factor < 1 comes nearer.
export function zoom(camera, factor) {
  return { ...camera, distance: clamp(camera.distance * factor, kMinDistance, kMaxDistance) };
}

// Carries eye and target along: ahead along the level part of the view, sideways, and up, in metres.
export function walk(camera, ahead, aside, upwards) {
  const { right } = axes(camera);
  const level = [-Math.sin(camera.yaw), 0, -Math.cos(camera.yaw)];
  const step = add(add(scale(level, ahead), scale(right, aside)), [0, upwards, 0]);
  return { ...camera, target: add(camera.target, step) };
}

// An upright picture would see too little to the sides: there yfov counts for the width.
export function lensFor(yfov, aspect) {
  return aspect >= 1 ? yfov : Math.min(2.8, 2 * Math.atan(Math.tan(yfov / 2) / aspect));
}
