// Camera mathematics, gestures and flight.
import assert from "node:assert/strict";
import { test } from "node:test";

import { axesOf, focusOn, forwardOf, fromDirection, fromLookAt, interpolate, lensFor, lensOfPixel, look, moved, orbit, pan, pointAt,
         positionOf, zoom } from "../../web/camera.js";
import { Flight, directionOf, gestureOf, isFlightKey, kStep, wheelZoom } from "../../web/navigation.js";
import { near } from "./near.mjs";

const view = { position: [3, 4, 5], target: [0, 1, 0], yfov: 0.9 };

test("an orbit camera has the position of its look-at", () => near(positionOf(fromLookAt(view)), view.position));

test("a full turn ends at the start and keeps the distance", () => {
  let camera = fromLookAt(view);
  for (let i = 0; i < 8; ++i) {
    camera = orbit(camera, Math.PI / 4, 0);
    assert.ok(Math.abs(Math.hypot(...positionOf(camera).map((x, k) => x - camera.target[k])) - Math.sqrt(43)) < 1e-9);
  }
  near(positionOf(camera), view.position);
});

test("no drag rotates the camera beyond straight up or down", () => {
  for (const dy of [100, -100]) {
    const { pitch } = orbit(fromLookAt(view), 0, dy);
    assert.ok(Math.abs(pitch) < Math.PI / 2);
  }
});

test("look() keeps the position and rotates like orbit()", () => {
  const camera = fromLookAt(view), turned = look(camera, 0.3, -0.2);
  near(positionOf(turned), view.position);
  near(axesOf(turned).toEye, axesOf(orbit(camera, 0.3, -0.2)).toEye);
});

test("panning by the whole side moves points at the depth of the target by the whole side", () => {
  const camera = fromLookAt({ position: [0, 0, 2], target: [0, 0, 0], yfov: Math.PI / 2 });
  near(pan(camera, 1, 0).target, [-4, 0, 0]);
  near(pan(camera, 0, 1).target, [0, 4, 0]);
});

test("zooming in and out by the same factor changes nothing", () =>
  near(positionOf(zoom(zoom(fromLookAt(view), 1.3), 1 / 1.3)), view.position));

test("the identity looks along -Z, a quarter turn about Y along -X", () => {
  near(forwardOf([0, 0, 0, 1]), [0, 0, -1]);
  near(forwardOf([0, Math.SQRT1_2, 0, Math.SQRT1_2]), [-1, 0, 0]);
});

test("in portrait format the field of view applies to the width", () => {
  assert.equal(lensFor(1, 1.5), 1);
  assert.ok(Math.abs(Math.tan(lensFor(1, 0.5) / 2) * 0.5 - Math.tan(0.5)) < 1e-9);
});

test("the centre pixel at the depth of the target is the target; edge pixels match the field of view", () => {
  const camera = fromDirection({ position: [1, 2, 3], direction: [0, 0, -1], distance: 5, yfov: Math.PI / 2 });
  near(pointAt(camera, lensOfPixel(camera.yfov, 200, 100, 100, 50), 5), camera.target);
  near(pointAt(camera, lensOfPixel(camera.yfov, 200, 100, 100, 0), 5), [1, 7, -2]);
  near(pointAt(camera, lensOfPixel(camera.yfov, 200, 100, 200, 50), 5), [11, 2, -2]);
});

test("focusing looks at the point and moves closer along the line to it", () => {
  const camera = focusOn(fromLookAt(view), [3, 4, -5]);
  near(camera.target, [3, 4, -5]);
  near(positionOf(camera), [3, 4, 1]);
});

test("interpolation matches both ends and takes the shorter rotation", () => {
  const from = { ...fromLookAt(view), yaw: 3 }, to = { ...from, yaw: -3, distance: 2 };
  near(positionOf(interpolate(from, to, 0)), positionOf(from));
  near(positionOf(interpolate(from, to, 1)), positionOf(to));
  assert.ok(Math.abs(interpolate(from, to, 0.5).yaw) > 3);
});

// ---- flight -----------------------------------------------------------------------------------

// Keys at their moments, frames at a rate; the camera two seconds later.
function flown(rate, { events = [[0.1, "press", "KeyW"], [0.6, "press", "KeyD"], [0.9, "release", "KeyW"], [1.1, "release", "KeyD"]], inertia = true } = {}) {
  const flight = new Flight(0, { inertia });
  flight.speed = 4;
  let camera = fromLookAt({ position: [0, 1, 5], target: [0, 1, 0], yfov: 1 });
  const moments = [...events.map(([at, act, code]) => [at, () => flight[act](code)]),
                   ...Array.from({ length: Math.ceil(2 * rate) + 1 }, (_, i) => [i / rate, () => {}])];
  for (const [at, act] of moments.sort((a, b) => a[0] - b[0])) {
    camera = flight.advance(camera, at);
    act();
  }
  return flight.advance(camera, 2.5);
}

test("the same keys fly the same path at 30, 60 and 144 frames a second", () => {
  const slow = flown(30);
  for (const rate of [7, 60, 144, 1000]) near(positionOf(flown(rate)), positionOf(slow));
  assert.ok(Math.hypot(...slow.target.map((x, i) => x - [0, 1, 0][i])) > 2);
});

test("a held key reaches the full speed; after release the camera stops", () => {
  const flight = new Flight(0);
  flight.speed = 4;
  flight.press("KeyW");
  let camera = flight.advance(fromLookAt({ position: [0, 0, 5], target: [0, 0, 0], yfov: 1 }), 3);
  near(flight.velocity, [0, 0, -4], 1e-4);
  flight.release("KeyW");
  camera = flight.advance(camera, 10);
  assert.equal(flight.moving, false);
  const rest = positionOf(camera);
  near(positionOf(flight.advance(camera, 20)), rest);
});

test("integration is semi-implicit Euler: velocity, then position", () => {
  const flight = new Flight(0);
  flight.speed = 1;
  flight.press("KeyE");
  const camera = flight.advance({ target: [0, 0, 0], distance: 1, yaw: 0, pitch: 0, yfov: 1 }, 1.5 * kStep);
  assert.ok(camera.target[1] > 0);
  near(camera.target, [0, flight.velocity[1] * kStep, 0]);
});

test("diagonals are not faster, opposite keys cancel", () => {
  for (const codes of [["KeyW"], ["KeyW", "KeyD"], ["KeyW", "KeyD", "KeyE"]]) near([Math.hypot(...directionOf(codes))], [1]);
  near(directionOf(["KeyW", "KeyS"]), [0, 0, 0]);
  near(directionOf(["KeyA", "KeyW", "KeyS"]), [-1, 0, 0]);
  assert.ok(isFlightKey("KeyQ") && !isFlightKey("KeyR"));
});

test("with reduced motion the camera stops at release", () => {
  const until = (seconds) => flown(60, { inertia: false, events: [[0.1, "press", "KeyW"], [0.5, "release", "KeyW"], [seconds, "release", "KeyW"]] });
  near(positionOf(until(0.6)), positionOf(until(1.9)));
  assert.ok(Math.abs(positionOf(flown(60, { events: [[0.1, "press", "KeyW"], [0.5, "release", "KeyW"]] }))[2] - positionOf(until(1))[2]) > 0.1);
});

test("moving translates the target too", () => {
  const camera = moved(fromLookAt(view), [1, 2, 3]);
  near(positionOf(camera), [4, 6, 8]);
});

test("one finger orbits, two fingers pan and zoom", () => {
  assert.deepEqual(gestureOf([[0, 0]], [[100, 0]], 100), { kind: "orbit", dx: Math.PI, dy: 0 });
  const pinch = gestureOf([[0, 0], [10, 0]], [[-5, 0], [15, 0]], 100);
  assert.deepEqual([pinch.kind, pinch.dx, pinch.zoom], ["pan", 0, 0.5]);
  assert.equal(gestureOf([[5, 5], [5, 5]], [[5, 5], [5, 5]], 100).zoom, 1);
  assert.ok(wheelZoom(100, 0) > 1 && wheelZoom(-3, 1) < 1);
});
